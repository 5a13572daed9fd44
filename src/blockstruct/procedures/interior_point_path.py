"""Follow a loading path by interior-point steps.

Steps are few and exact, each with many factorisations.
"""

from dataclasses import replace

import numpy as np

from blockstruct.arrays import SLIGHT, Array
from blockstruct.limit.friction import fictitious_sliding
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.program import ConicProgram
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.path import ATTEMPTS, TOLERANCE, Path
from blockstruct.solvers.interior_point import ContactProblem, ContactSolution, ContactState

#: Most factorisations of all steps. Measured: with more, a wall with ties ends 9 % lower than by splitting.
MAX_OF_PATH = 600
#: Share of friction that does not lag.
LAG = 0.5


class InteriorPointPath(Path):
    """Follow a path by interior-point steps with elastic contacts.

    After a failed step with Coulomb's law, friction lags: ``‖t‖ ≤ μ (n + n_last) / 2``. The law is the same once forces
    no longer change. Half of the term that makes a step non-monotone is gone. Measured on 820 blocks whose steps fail
    with Coulomb's law: 30 factorisations per step of any length.

    Parameters
    ----------
    program, settings, divided
        See :class:`~blockstruct.procedures.path.Path`.
    """

    def __init__(self, program: ConicProgram, settings: ProcedureSettings, divided: int = 1) -> None:
        super().__init__(program, settings, divided)
        self._spent, self._lags = 0, False

    def _at_rest(self) -> tuple[ContactState, int] | None:
        # An interior point leaves forces on unloaded contacts, and these hold structures together. Measured on two
        # adjacent leaves: a tolerance of 1e-3 ends 0.8 % high, 1e-6 0.04 %.
        tolerance = self._settings.numerics.solver_tolerance
        found = self.contact.solve(self._rest(), self.contact.start(), centre=True, tolerance=tolerance)
        if not found.within(SLIGHT):
            return None
        self._spent = found.iterations
        return replace(found.state, u=0 * found.state.u), found.iterations

    def _solved(self, length: float, bound: float) -> tuple[ContactState, float, int] | None:
        iterations = 0
        for _ in range(ATTEMPTS):
            self.is_exhausted = self._spent >= MAX_OF_PATH
            if self.is_exhausted:
                return None
            found = self._attempted(length, bound)
            self._spent += found.iterations
            iterations += found.iterations
            if found.within(SLIGHT):
                if not self._lags:
                    self.peak = max(self.peak, found.state.alpha)
                return found.state, length, iterations
            # Friction under dead load differs from friction under the push: from there, lagging would overshoot.
            if self._lags or not self._step:
                length /= 3
            else:
                self._lags = True
        return None

    def _attempted(self, length: float, bound: float) -> ContactSolution:
        s = length * self._unit
        # The state under dead load is too far from the first step to be a useful guess.
        guess = self._state.scaled(length / self._step) if self._step else self._afresh(s, bound)
        step = self._memory(self._state, s)
        return self._lagging().solve(step, guess, centre=bool(self._step), tolerance=TOLERANCE)

    def refine(self) -> None:
        """Do nothing, because the steps are exact."""

    def forces(self, last: Iteration) -> Array:
        """Return the forces of the last step."""
        return last.x

    def _afresh(self, s: float, bound: float) -> ContactState:
        """Return the state that a first step begins with.

        Normal forces equal the mean, and the load factor is at most the bound.
        """
        normal = np.abs(self._state.x[self._normal]).mean()
        rise = min(s / self._unit, max(abs(bound - self._state.alpha), 1e-3))
        return self.contact.afresh(float(normal), s, self._state.alpha + rise)

    def _lagging(self) -> ContactProblem:
        """Return the contacts, with lagging friction after a failed step."""
        if not self._lags:
            return self.contact
        last = np.maximum(self._state.x[self._normal], -self._problem.tension)
        # A cohesion as small as the tolerance keeps some resistance at unloaded contacts.
        half = fictitious_sliding(self._problem, last, TOLERANCE, -LAG)
        return self.contact.with_sliding(half)
