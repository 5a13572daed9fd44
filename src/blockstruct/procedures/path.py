"""A loading path: what it begins with, what its contacts remember, and the steps that it is made of."""

from abc import ABC, abstractmethod
from dataclasses import replace
from functools import cached_property
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.certificate import certify
from blockstruct.limit.crushing import bearing
from blockstruct.limit.friction import true_sliding
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.program import ConicProgram
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.solvers.interior_point import ContactProblem, ContactState, Step
from blockstruct.vocabulary import PathEnd, SolverStatus, Stage

Array = NDArray[np.float64]

#: Range of the load factor while the displacement grows tenfold, relative, up to which it has settled. Measured on 90
#: structures of 18 kinds: with 3e-3 as many end elsewhere, with 1e-2 twice as many.
SETTLED = 5e-3
#: Displacement at which a path ends, in elastic displacements: beyond it no elastic strain is left to speak of.
FURTHEST = 1e5


class Path(ABC):
    """Where a path has got to, and the next step of it.

    Parameters
    ----------
    program
        The program, with cones of crushing whose lengths a step gives.
    settings
        Steps, and stiffness of joints that were given none.
    divided
        Number of steps in place of each step of the settings.

    Attributes
    ----------
    program : ConicProgram
    peak : float
        Largest load factor so far.
    end : PathEnd
        Why the next step is None.
    contact : ContactProblem
        Its contacts.
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
        #: The contacts as the last step had them.
        self._last = self.contact
        self._first, self._growth = settings.path_step / divided, settings.path_growth ** (1 / divided)
        self._load_factors: list[tuple[float, float]] = []
        self._total, self._unit = 0.0, np.nan
        self.peak, self.end = -np.inf, PathEnd.STEP_NOT_SOLVED

    @cached_property
    def dead_load(self) -> Iteration | None:
        """The state under dead load, None if none is found."""
        start = perf_counter()
        try:
            self._unit = self.contact.elastic_displacement()
            found = self._at_rest()
        except RuntimeError:
            # Blocks that nothing holds.
            return None
        if found is None:
            return None
        state, iterations = found
        return replace(self.iteration(state, iterations, perf_counter() - start), displacement=0.0)

    @abstractmethod
    def _at_rest(self) -> tuple[ContactState, int] | None:
        """Take the state under dead load, and the iterations that it took."""

    @abstractmethod
    def advance(self, bound: float) -> Iteration | None:
        """The next step, up to a load factor that it hardly passes; None if the path has ended."""

    @abstractmethod
    def forces(self, last: Iteration) -> Array:
        """Forces (K, 3) at the end of the path, the normal ones as friction follows them."""

    @abstractmethod
    def refine(self) -> None:
        """Solve later steps more exactly: the end that they have led to was not exact enough."""

    @property
    def bearing(self) -> Array:
        """Share of their length over which rectangles bear in the last step, (R, 2)."""
        return self._last.bearing

    def _next_bearing(self) -> Array:
        """Share of their length over which rectangles bear in a step from the last state, (R, 2)."""
        return bearing(self._problem, self._state.x[self._normal], self.bearing if self._load_factors else None)

    @property
    def drift(self) -> tuple[float, float]:
        """Lowest and highest load factor while the displacement last grew tenfold."""
        last = [alpha for total, alpha in self._load_factors if 10 * total >= self._total]
        return min(last), max(last)

    @property
    def _is_at_limit(self) -> bool:
        return self._total >= FURTHEST * self._unit

    def has_settled(self, last: Iteration) -> bool:
        """Return whether the load factor has hardly moved while the displacement grew tenfold."""
        low, high = self.drift
        return 10 * self._load_factors[0][0] < self._total and high - low <= SETTLED * self.scale(last)

    def scale(self, found: Iteration) -> float:
        """Return the load factor, or a thousandth of the work scale of its mechanism where that is larger."""
        return max(abs(found.load_factor), 1e-3 * self._problem.work_scale(found.u))

    def gap(self, found: Iteration) -> float:
        """Return the flow-rule gap relative to the scale of the load factor."""
        return float(found.certificate.flow_rule_gap / self.scale(found))

    @property
    def _normal(self) -> slice:
        return slice(0, 3 * self._problem.n_points, 3)

    def _rest(self) -> Step:
        """Step from nothing to the dead load. A support that will give way is held, by whatever reaction that takes."""
        size = len(self.contact.compliance)
        return Step(np.zeros(size), np.zeros(size), None if self._problem.settlement is None else 0.0)

    def _memory(self, state: ContactState, s: float) -> Step:
        """What contacts and ties remember: friction forces, the opening of open contacts and of slack ties.

        Rectangles remember what they have crushed and how far they have turned; if each step forgot it, blocks whose
        strips differ would settle away from each other without end. What cells have crushed and how far ties have
        yielded is forgotten.
        """
        K, normal = self._problem.n_points, self._normal
        reference, opening = state.x.copy(), np.zeros_like(state.x)
        reference[normal] = 0.0
        reference[3 * K :] = 0.0
        opening[normal] = state.z.line[:K] - self.contact.compliance[normal] * state.x[normal]
        opening[self.contact.ties] = state.z.line[self.contact.slack]
        if self.program.is_frozen:
            of_rectangles = 0.0 * state.z
            of_rectangles.soc[self.contact.strips] = state.z.soc[self.contact.strips]
            opening += self._last.conditions.flow(of_rectangles)
        return Step(reference, opening, s)

    def _displacement(self) -> float:
        """Displacement so far, m; in multiples of the elastic one if no stiffness was given."""
        unit = self._problem.displacement_unit
        return self._total * unit if np.isfinite(unit) else self._total / self._unit

    def _step_done(self, state: ContactState, s: float, iterations: int, seconds: float) -> Iteration:
        """A step of displacement s."""
        self._load_factors.append((self._total, state.alpha))
        self.reached = state.scaled(1 / s)
        return replace(self.iteration(self.reached, iterations, seconds), displacement=self._displacement())

    def iteration(self, state: ContactState, iterations: int, seconds: float) -> Iteration:
        """A state of the contacts with displacements of unit work."""
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
