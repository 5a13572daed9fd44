"""Record the result of each program and the outcome of a procedure."""

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Self, TypeVar

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import Array
from blockstruct.limit.certificate import Certificate
from blockstruct.limit.friction import Sliding
from blockstruct.limit.problem import LimitProblem
from blockstruct.vocabulary import PathEnd, Procedure, Reason, SolverStatus, Stage, Status

#: Load ratio of two touching blocks above which programs resolve the lighter one poorly. Measured on stacks with the
#: heavier block on top: a ratio of 1e4 is certified, 1e5 is not.
APART = 3e4


@dataclass(frozen=True, slots=True)
class Iteration:
    """One program and its solution, non-dimensional.

    Attributes
    ----------
    stage : Stage
    load_factor : float
        α; NaN if the solver found no point, and in the dead-load program.
    x : (K, 3) array
        Contact forces (n, s, t).
    u : (6 F,) array
        Velocities, ``w_L·u = 1`` (``w_D·u = 1`` in the dead-load program).
    v : (K, 3) array
        Velocities of the plus block relative to the minus block, in the frame of the interface.
    sliding : Sliding
        Sliding condition of the program.
    c0, a : float
        Cohesion and slope of the schedule.
    linearised_at : (R,) array or None
        Normal force N0 at the latest crushing tangent of each rectangle; None unless crushing is linearised.
    certificate : Certificate
        Certificate against the true conditions.
    solver_status : SolverStatus
    solver_iterations : int
    solver_time : float
        Solver time, s.
    displacement : float
        Displacement of a loading-path step from the state under dead load; NaN in programs.
    tie_force, elongation : (M,) arrays
        Forces T of ties including prestress, tension positive, and rates of elongation.
    """

    stage: Stage
    load_factor: float
    x: Array
    u: Array
    v: Array
    sliding: Sliding
    c0: float
    a: float
    linearised_at: Array | None
    certificate: Certificate
    solver_status: SolverStatus
    solver_iterations: int
    solver_time: float
    tie_force: Array
    elongation: Array
    displacement: float = np.nan

    @property
    def solved(self) -> bool:
        """Whether the solver claims a solution; only the certificate proves it."""
        return is_solved(self.solver_status)

    def of_case(self, problem: LimitProblem) -> Self:
        """Return the iteration in multiples of the variable load of the case.

        An iteration under dead load alone is unchanged.
        """
        if self.stage.is_of_dead_load:
            return self
        unit, c = problem.load_unit, self.certificate
        return replace(
            self,
            load_factor=self.load_factor / unit,
            u=self.u / unit,
            v=self.v / unit,
            elongation=self.elongation / unit,
            certificate=replace(
                c, flow_rule_gap=c.flow_rule_gap / unit, flow_rule_gap_limit=c.flow_rule_gap_limit / unit
            ),
        )


def is_solved(status: SolverStatus) -> bool:
    """Return whether a solver claims a solution."""
    return status in (SolverStatus.SOLVED, SolverStatus.ALMOST_SOLVED)


@dataclass(frozen=True, slots=True)
class Found:
    """A certified collapse state and the procedure that found it.

    Attributes
    ----------
    state : Iteration
    procedure : Procedure
    settled : bool
        Whether the load factor had settled when the search ended.
    drift : tuple of float or None
        Lowest and highest of the last load factors; None if the search records none.
    peak : float
        Largest load factor on the loading path; NaN if the state has it.
    """

    state: Iteration
    procedure: Procedure
    settled: bool = True
    drift: tuple[float, float] | None = None
    peak: float = np.nan


@dataclass(frozen=True, slots=True)
class Outcome:
    """Outcome of a limit case.

    Attributes
    ----------
    status : Status
    load_factor : float
        α at collapse; infinite if unbounded, NaN without a result.
    reason : Reason
        Reason for the status.
    procedure : Procedure or None
        Procedure that found the load factor; None without a load factor.
    settled : bool
        Whether the load factor had settled when the procedure ended.
    drift : tuple of float or None
        Lowest and highest of the last load factors.
    peak : float
        Largest load factor on the loading path; NaN if it does not exceed the load factor.
    path_end : PathEnd or None
        End of the loading path; None if the path was not followed.
    carried : float
        Largest share of the dead load that the joints carry; NaN if they carry the whole dead load.
    programs : int
        Programs solved before the search was given up; 0 otherwise.
    load_ratio : float
        Largest load ratio of two touching blocks, if too large for the solver; NaN otherwise.
    without_crushing : float
        Load factor of the same case without crushing; NaN as a rule. It is set if crushing raised the load factor by
        more than the accuracy of the procedure. ``load_factor`` and the last iteration are then without crushing.
    collapse_time : float
        Time of a record at which a block has fallen, s; NaN if none has.
    uniform_torsion, biaxial_crushing : float
        Load factor of the same case with the torsion of uniform pressure, and with crushing about both axes; NaN if it
        was not found, because no note needs it.
    estimated : bool
        Whether ``uniform_torsion`` and ``biaxial_crushing`` are estimates by the first steps of the loading path.
    other_procedure : float
        Load factor of the same case by another procedure, if it depends on self-stress; NaN otherwise.
    hung, jammed : tuple of int
        Free blocks whose dead load (hung) or share of the variable load (jammed) depends on self-stress.
    lowered_friction : float
        Load factor of the same case with the friction of each joint divided by its excess of torsion; NaN if no note
        needs it.
    """

    status: Status
    load_factor: float
    reason: Reason
    procedure: Procedure | None = None
    settled: bool = False
    drift: tuple[float, float] | None = None
    peak: float = np.nan
    path_end: PathEnd | None = None
    carried: float = np.nan
    programs: int = 0
    load_ratio: float = np.nan
    without_crushing: float = np.nan
    collapse_time: float = np.nan
    uniform_torsion: float = np.nan
    biaxial_crushing: float = np.nan
    estimated: bool = False
    other_procedure: float = np.nan
    hung: tuple[int, ...] = ()
    jammed: tuple[int, ...] = ()
    lowered_friction: float = np.nan

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Return the outcome from plain values.

        The values are the JSON form of :func:`dataclasses.asdict`.
        """
        kinds: dict[str, Any] = {"status": Status, "reason": Reason, "procedure": Procedure, "path_end": PathEnd}
        kinds |= dict.fromkeys(("drift", "hung", "jammed"), tuple)
        return cls(**{n: kinds[n](v) if n in kinds and v is not None else v for n, v in values.items()})

    def of_case(self, problem: LimitProblem) -> Self:
        """Return the outcome in multiples of the variable load of the case."""
        unit = problem.load_unit
        drift = None if self.drift is None else (self.drift[0] / unit, self.drift[1] / unit)
        return replace(
            self,
            load_factor=self.load_factor / unit,
            drift=drift,
            peak=self.peak / unit,
            without_crushing=self.without_crushing / unit,
        )

    @property
    def stands_in(self) -> bool:
        """Whether another procedure replaced an unfinished loading path."""
        return self.procedure is not None and self.path_end not in (None, PathEnd.CLOSED)


#: A procedure: yields its iterations when solved, and returns its outcome.
Steps = Generator[Iteration, None, Outcome]
#: A search for a collapse state: yields its iterations, and returns the state (or None) and the last solved iteration.
Search = Generator[Iteration, None, tuple[Found | None, Iteration]]

_Item = TypeVar("_Item")
_Value = TypeVar("_Value")


def changed_steps(
    steps: Generator[_Item, None, _Value], change: Callable[[_Item], _Item]
) -> Generator[_Item, None, _Value]:
    """Yield each item of a generator as a function returns it; return the value of the generator."""
    while True:
        try:
            step = next(steps)
        except StopIteration as stop:
            value: _Value = stop.value
            return value
        yield change(step)


def conclude(steps: Generator[_Item, None, _Value], hear: Callable[[_Item], object] = lambda _: None) -> _Value:
    """Return the value of a generator, after a function has heard each of its items."""
    while True:
        try:
            step = next(steps)
        except StopIteration as stop:
            value: _Value = stop.value
            return value
        hear(step)


def given_up(problem: LimitProblem, reason: Reason, *, programs: int = 0) -> Outcome:
    """Return an outcome without a load factor."""
    ratio = _load_ratio(problem)
    return Outcome(
        Status.NOT_CONVERGED, np.nan, reason, programs=programs, load_ratio=ratio if ratio > APART else np.nan
    )


def _load_ratio(problem: LimitProblem) -> float:
    """Return the largest ratio of the loads of two touching blocks."""
    A = sp.csc_array(problem.A[: 6 * len(problem.wrench_unit), ::3])
    ratio = problem.wrench_unit[A.indices // 6] / np.repeat(problem.force_unit, np.diff(A.indptr))
    return float(ratio.max(initial=0.0))
