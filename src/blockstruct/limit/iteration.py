"""What one program of the procedure found, and how the procedure ended."""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit.certificate import Certificate
from blockstruct.limit.friction import Sliding
from blockstruct.limit.problem import LimitProblem
from blockstruct.vocabulary import SolverStatus, Stage, Status

Array = NDArray[np.float64]

#: Ratio of the loads of two blocks that touch from which programs resolve the lighter one poorly. Measured on stacks
#: in which it carries the heavier one: 1e4 is certified, 1e5 is not.
APART = 3e4


@dataclass(frozen=True, slots=True)
class Iteration:
    """One program and its solution, non-dimensional.

    Attributes
    ----------
    stage : Stage
    load_factor : float
        α; NaN where the solver found no point, and in the dead-load program.
    x : (K, 3) array
        Contact forces (n, s, t).
    u : (6 F,) array
        Velocities, ``w_L·u = 1`` (``w_D·u = 1`` in the dead-load program).
    v : (K, 3) array
        Relative velocities plus minus minus, in the frame of the interface.
    sliding : Sliding
        The sliding condition of the program.
    c0, a : float
        Cohesion and slope of the schedule.
    linearised_at : (R,) array or None
        Normal force N0 about which the crushing of each rectangle is linearised, if it is.
    certificate : Certificate
        Against the true conditions.
    solver_status : SolverStatus
    solver_iterations : int
    solver_time : float
        Seconds.
    displacement : float
        Of a step of the loading path, from the state under dead load; NaN in programs.
    tie_force, elongation : (M,) arrays
        Forces T of ties with their prestress, tension positive, and rates of elongation.
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
        """Whether the solver claims a point: only the certificate tells what it is worth."""
        return is_solved(self.solver_status)


def is_solved(status: SolverStatus) -> bool:
    """Whether a solver claims a point."""
    return status in (SolverStatus.SOLVED, SolverStatus.ALMOST_SOLVED)


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a limit case ended: its status, its load factor and a sentence on why.

    Attributes
    ----------
    status : Status
    load_factor : float
    message : str
    hung, jammed : tuple of int
        Indices of free blocks whose dead load, or whose share of the variable load, self-stress decides on.
    """

    status: Status
    load_factor: float
    message: str
    hung: tuple[int, ...] = ()
    jammed: tuple[int, ...] = ()


#: A procedure: yields its iterations as they are solved, and returns how it ended.
Steps = Generator[Iteration, None, Outcome]
#: A search for a collapse state: yields its iterations, and returns why the last one is certified, or None; and the
#: last one that was solved.
Search = Generator[Iteration, None, tuple[str | None, Iteration]]


def given_up(problem: LimitProblem, why: str, last: Iteration) -> Outcome:
    """Outcome without a load factor, with the certificate of the last program that was solved."""
    c = last.certificate
    return Outcome(
        Status.NOT_CONVERGED,
        np.nan,
        f"{why}; last {problem.said(last.load_factor)} with equilibrium residual {c.equilibrium_residual:.1e}, "
        f"yield excess {c.yield_excess:.1e}, interpenetration {c.interpenetration:.1e}, "
        f"flow-rule gap {c.flow_rule_gap:.1e}{of_weights_apart(problem)}",
    )


def of_weights_apart(problem: LimitProblem) -> str:
    """What to do where a light block carries a heavy one, as the end of a message; empty where none does."""
    A = sp.csc_array(problem.A[: 6 * len(problem.wrench_unit), ::3])
    ratio = problem.wrench_unit[A.indices // 6] / np.repeat(problem.force_unit, np.diff(A.indptr))
    if not ratio.max(initial=0.0) > APART:
        return ""
    return (
        f"; loads of two blocks that touch are up to {ratio.max():.1e} apart, of which programs resolve the smaller "
        "one poorly: give a plate or a wedge between heavy blocks no weight at all, or more"
    )
