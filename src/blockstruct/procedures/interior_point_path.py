"""A loading path by interior-point steps: few and exact, each of many factorisations."""

from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.friction import fictitious_sliding
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.program import ConicProgram
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.path import Path
from blockstruct.solvers.interior_point import ContactProblem, ContactState
from blockstruct.vocabulary import PathEnd

Array = NDArray[np.float64]

#: Of displacements and gap, relative, and a tenth of it of forces: of the state under dead load, asked of a step, and
#: good enough for one that goes no further. The force that an interior point leaves on unloaded contacts holds
#: structures together: measured on two leaves beside each other, 1e-3 ends 0.8 % high, 1e-6 0.04 %.
OF_DEAD_LOAD, TOLERANCE, ENOUGH = 1e-7, 1e-5, 1e-3
#: Complementarity gap at which a step begins, in multiples of its work.
CENTRING = 1.0
#: Factorisations of one step, and of all of them.
MAX_OF_STEP, MAX_OF_PATH = 80, 600
#: Attempts at a step: as it is, with lagging friction, and then each a third as long as the last.
ATTEMPTS = 4
#: Share of friction that does not lag.
LAG = 0.5
#: Cohesion of contacts whose friction lags, which keeps those without force from having none.
LAG_FLOOR = 1e-5


class InteriorPointPath(Path):
    """Steps of :class:`~blockstruct.solvers.interior_point.ContactProblem`.

    Where Coulomb's law is not solved, friction begins to lag: ``‖t‖ ≤ μ (n + n_last) / 2``. The law is the same once
    forces no longer change, and half of what makes a step non-monotone is gone. Measured on 820 blocks: 30
    factorisations per step of any length, where Coulomb's law is not solved.

    Parameters
    ----------
    program, settings, divided
        See :class:`~blockstruct.procedures.path.Path`.
    """

    def __init__(self, program: ConicProgram, settings: ProcedureSettings, divided: int = 1) -> None:
        super().__init__(program, settings, divided)
        self._step, self._spent, self._lags = 0.0, 0, False

    def _at_rest(self) -> tuple[ContactState, int] | None:
        found = self.contact.solve(
            self._rest(), self.contact.start(), centring=1.0, tolerance=OF_DEAD_LOAD, max_iterations=MAX_OF_STEP
        )
        if not found.within(ENOUGH):
            return None
        self._spent = found.iterations
        self._state = replace(found.state, u=0 * found.state.u)
        self._next = self._first * self._unit
        return self._state, found.iterations

    def advance(self, bound: float) -> Iteration | None:
        """The next step, shortened until it is solved; None if the path has ended."""
        start, iterations = perf_counter(), 0
        if self._is_at_limit:
            self.end = PathEnd.LIMIT_REACHED
            return None
        for _ in range(ATTEMPTS):
            if self._spent >= MAX_OF_PATH:
                return None
            s = self._next
            # The state under dead load is so far from that of a first step that it is no guess.
            guess = self._state.scaled(s / self._step) if self._step else self._afresh(s, bound)
            contact = self._lagging()
            found = contact.solve(
                self._memory(self._state, s),
                guess,
                centring=CENTRING if self._step else None,
                tolerance=TOLERANCE,
                max_iterations=MAX_OF_STEP,
            )
            self._spent += found.iterations
            iterations += found.iterations
            if found.within(ENOUGH):
                self._state, self._step, self._last = found.state, s, contact
                self._total += s
                self._next = s * self._growth
                if not self._lags:
                    self.peak = max(self.peak, found.state.alpha)
                return self._step_done(found.state, s, iterations, perf_counter() - start)
            # From the dead load, whose friction is not that of the push, lagging would overshoot.
            if self._lags or not self._step:
                self._next = s / 3
            else:
                self._lags = True
        return None

    def refine(self) -> None:
        """Nothing to do: its steps are exact."""

    def forces(self, last: Iteration) -> Array:
        """Forces of the last step."""
        return last.x

    def _afresh(self, s: float, bound: float) -> ContactState:
        """What a first step begins with: normal forces as they are on average, and the load factor of the bound."""
        normal = np.abs(self._state.x[self._normal]).mean()
        rise = min(s / self._unit, max(abs(bound - self._state.alpha), 1e-3))
        return self.contact.afresh(float(normal), s, self._state.alpha + rise)

    def _lagging(self) -> ContactProblem:
        """The contacts, and from the first step on that they do not solve, those whose friction lags behind."""
        if not self._lags:
            frozen = self.program.is_frozen
            return self.contact.with_conditions(self._sliding, self._next_bearing()) if frozen else self.contact
        last = np.maximum(self._state.x[self._normal], -self._problem.tension)
        half = fictitious_sliding(self._problem, last, LAG_FLOOR, -LAG)
        return self.contact.with_conditions(half, self._next_bearing())
