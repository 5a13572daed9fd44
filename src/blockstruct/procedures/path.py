"""Define the common parts of loading paths: start, memory and steps."""

from abc import ABC, abstractmethod
from dataclasses import replace
from functools import cached_property
from time import perf_counter

import numpy as np

from blockstruct.arrays import Array
from blockstruct.limit.certificate import certify
from blockstruct.limit.friction import true_sliding
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.program import ConicProgram
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.solvers.interior_point import ContactProblem, ContactState, Step
from blockstruct.vocabulary import PathEnd, SolverStatus, Stage

#: The load factor has settled within this relative range while the displacement grows tenfold. Measured on 90
#: structures of 18 kinds: with 3e-3 as many end elsewhere, with 1e-2 twice as many.
SETTLED = 5e-3
#: Residual of a step. Measured by splitting on 37 structures against an independent path: with 1e-4 the load factor of
#: rubble is 3.5 % off, with 1e-5 0.1 %. The times of these cases agree to 3 %.
TOLERANCE = 1e-5
#: Most attempts at a step by interior points, and at a closed state.
ATTEMPTS = 8
#: Displacement at which a path ends, in elastic displacements, or in those at half of the bound if they are longer.
#: Beyond it, elastic strain is negligible.
FURTHEST = 1e5


class Path(ABC):
    """State of a loading path, and its next step.

    Parameters
    ----------
    program
        The program, with the exact cones of crushing.
    settings
        Steps, and stiffness of joints without a given stiffness.
    divided
        Number of steps in place of each step of the settings.

    Attributes
    ----------
    program : ConicProgram
        The program.
    peak : float
        Largest load factor so far.
    is_exhausted : bool
        Whether all iterations of the path are used up.
    end : PathEnd
        Why the next step is None.
    contact : ContactProblem
        Contacts of the path.
    reached : ContactState
        State of the last step, with displacements of unit work.
    """

    _state: ContactState

    def __init__(self, program: ConicProgram, settings: ProcedureSettings, divided: int = 1) -> None:
        self.program = program
        problem = self._problem = program.problem
        normal, shear = problem.compliance.T
        shear = np.where(np.isnan(shear), normal / settings.shear_stiffness_ratio, shear)
        self.contact = ContactProblem(program, np.column_stack([normal, shear, shear]))
        self._settings, self._sliding = settings, true_sliding(problem)
        self._first, self._growth = settings.path_step / divided, settings.path_growth ** (1 / divided)
        self._load_factors: list[tuple[float, float]] = []
        self._step, self._total, self._unit = 0.0, 0.0, np.nan
        self.peak, self.end, self.is_exhausted = -np.inf, PathEnd.STEP_NOT_SOLVED, False

    @cached_property
    def dead_load(self) -> Iteration | None:
        """Return the state under dead load, or None if there is no such state."""
        start = perf_counter()
        try:
            self._unit = self.contact.elastic_displacement()
            found = self._at_rest()
        except RuntimeError:
            # Nothing holds some of the blocks.
            return None
        if found is None:
            return None
        self._state, iterations = found
        return replace(self.iteration(self._state, iterations, perf_counter() - start), displacement=0.0)

    @abstractmethod
    def _at_rest(self) -> tuple[ContactState, int] | None:
        """Return the state under dead load, and the number of iterations."""

    def advance(self, bound: float) -> Iteration | None:
        """Solve the next step; return None if the path has ended.

        The load factor hardly passes ``bound``.
        """
        start = perf_counter()
        if self._is_at_limit(bound):
            self.end = PathEnd.LIMIT_REACHED
            return None
        found = self._solved(self._growth * self._step if self._step else self._first, bound)
        if found is None:
            return None
        self._state, self._step, iterations = found
        s = self._step * self._unit
        self._total += s
        self._load_factors.append((self._total, self._state.alpha))
        self.reached = self._state.scaled(1 / s)
        step = self.iteration(self.reached, iterations, perf_counter() - start)
        return replace(step, displacement=self._displacement())

    @abstractmethod
    def _solved(self, length: float, bound: float) -> tuple[ContactState, float, int] | None:
        """Solve the next step, of a length in elastic displacements or less.

        Return its state, its length and the number of iterations, or None.
        """

    @abstractmethod
    def forces(self, last: Iteration) -> Array:
        """Return forces (K, 3) at the end of the path.

        Friction follows the normal forces.
        """

    @abstractmethod
    def refine(self) -> None:
        """Solve later steps more exactly.

        The end of the path was not exact enough.
        """

    @property
    def drift(self) -> tuple[float, float]:
        """Return the range of the load factor over the last tenfold displacement.

        The lowest value comes first.
        """
        last = [alpha for total, alpha in self._load_factors if 10 * total >= self._total]
        return min(last), max(last)

    def _is_at_limit(self, bound: float) -> bool:
        # A small load next to a large dead load takes many elastic displacements to its collapse.
        half = (total for total, alpha in self._load_factors if alpha >= bound / 2)
        return self._total >= FURTHEST * max(self._unit, next(half, 0.0))

    def has_settled(self, last: Iteration) -> bool:
        """Return whether the load factor has settled.

        It has hardly changed while the displacement grew tenfold.
        """
        low, high = self.drift
        return 10 * self._load_factors[0][0] < self._total and high - low <= SETTLED * self.scale(last)

    def scale(self, found: Iteration) -> float:
        """Return the scale of the load factor.

        The scale is the load factor, or a thousandth of the mechanism's work scale if that is larger.
        """
        return max(abs(found.load_factor), 1e-3 * self._problem.work_scale(found.u))

    def gap(self, found: Iteration) -> float:
        """Return the flow-rule gap relative to the scale of the load factor."""
        return float(found.certificate.flow_rule_gap / self.scale(found))

    @property
    def _normal(self) -> slice:
        return slice(0, 3 * self._problem.n_points, 3)

    def _rest(self) -> Step:
        """Return the step from no load to the dead load.

        A support that will settle stays fixed, with any reaction.
        """
        size = len(self.contact.compliance)
        return Step(np.zeros(size), np.zeros(size), None if self._problem.settlement is None else 0.0)

    def _memory(self, state: ContactState, s: float) -> Step:
        """Return the step with everything that contacts and ties remember.

        These are friction forces, openings of open contacts and slack of ties. Crushing, and the yielding of ties, is
        forgotten.
        """
        K, normal = self._problem.n_points, self._normal
        reference, opening = state.x.copy(), np.zeros_like(state.x)
        reference[normal] = 0.0
        reference[3 * K :] = 0.0
        opening[normal] = state.z.line[:K] - self.contact.compliance[normal] * state.x[normal]
        opening[self.contact.ties] = state.z.line[self.contact.slack]
        return Step(reference, opening, s)

    def _displacement(self) -> float:
        """Return the displacement so far, m.

        It is in multiples of the elastic displacement if joints have no stiffness.
        """
        unit = self._problem.displacement_unit
        return self._total * unit if np.isfinite(unit) else self._total / self._unit

    def iteration(self, state: ContactState, iterations: int, seconds: float) -> Iteration:
        """Return the iteration of a state with displacements of unit work."""
        problem = self._problem
        x, u = state.x[: 3 * problem.n_points].reshape(-1, 3), state.u
        T = state.x[self.contact.ties] + problem.ties.prestress(state.alpha)
        return Iteration(
            stage=Stage.LOADING_PATH,
            load_factor=state.alpha,
            x=x,
            u=u,
            v=(problem.A.T @ u).reshape(-1, 3),
            sliding=self._sliding,
            c0=0.0,
            a=0.0,
            linearised_at=None,
            certificate=certify(problem, x, u, state.alpha, self._settings, T),
            solver_status=SolverStatus.SOLVED,
            solver_iterations=iterations,
            solver_time=seconds,
            tie_force=T,
            elongation=problem.ties.elongation(u),
        )
