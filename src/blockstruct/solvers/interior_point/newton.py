"""Compute Newton's directions at a state of contact.

One factorisation gives predictor, corrector and centrality correctors.
"""

from typing import TYPE_CHECKING

import numpy as np

from blockstruct.arrays import Array
from blockstruct.solvers.interior_point.conditions import Weights
from blockstruct.solvers.interior_point.cones import ConeVector, Scaling
from blockstruct.solvers.interior_point.schur import Factor
from blockstruct.solvers.interior_point.state import ContactState, Residuals, Step

if TYPE_CHECKING:
    from blockstruct.solvers.interior_point.contact_step import ContactProblem


#: Share of the way to the boundary that a step takes.
FRACTION = 0.99
#: Centrality correctors per factorisation (Gondzio). Measured: two save a third of the factorisations, more save none.
CORRECTORS = 2
#: Largest rounding of a direction, relative to the residual of displacements; most refinements.
PRECISION, REFINEMENTS = 1e-2, 2


class Newton:
    """Compute Newton's directions at one state by one factorisation."""

    def __init__(self, problem: "ContactProblem", step: Step, state: ContactState, residuals: Residuals) -> None:
        self._problem, self._state, self._residuals = problem, state, residuals
        self._free = step.displacement is not None
        self._scaling = Scaling(state.y, state.z)
        self._weights: Weights = problem.conditions.weights(self._scaling, problem.compliance)
        self._factor: Factor = problem.complement.factorised(self._weights)
        self._w_L = problem.problem.w_L
        self._of_load = self._factor.solve(self._w_L) if self._free else np.zeros_like(self._w_L)
        self._mean = residuals.gap / state.y.degree
        self._squared = self._scaling.point.times(self._scaling.point)

    def inner(self, a: ContactState, b: ContactState) -> float:
        """Return the inner product of two directions in the scaled space."""
        scaling = self._scaling
        return scaling.divided(a.y).dot(scaling.divided(b.y)) + scaling.times(a.z).dot(scaling.times(b.z))

    def direction(self, centre: float, residuals: Residuals, correction: ConeVector | None = None) -> ContactState:
        """Return the direction to the point with ``y ∘ z = centre e``.

        Subtract a correction of second order, if there is one.
        """
        problem, conditions = self._problem, self._problem.conditions
        target = centre * conditions.identity() - self._squared
        if correction is not None:
            target = target - correction
        h = self._scaling.divided(self._scaling.point.solve(target)) - self._weights.times(residuals.forces)
        b = conditions.flow(h) - residuals.flow
        x, u, alpha = self._forces(b, residuals.equilibrium, residuals.work)
        for _ in range(REFINEMENTS):
            y = conditions.of_forces(x)
            missed = b - problem.compliance * x - conditions.flow(self._weights.times(y)) - problem.AT @ u
            if not np.abs(missed).max() > PRECISION * np.abs(residuals.flow).max():
                break
            equilibrium = residuals.equilibrium + problem.A @ x + alpha * self._w_L
            more = self._forces(missed, equilibrium, residuals.work + float(self._w_L @ u))
            x, u, alpha = x + more[0], u + more[1], alpha + more[2]
        y = conditions.of_forces(x)
        return ContactState(x, y + residuals.forces, h - self._weights.times(y), u, alpha)

    def _forces(self, b: Array, equilibrium: Array, work: float) -> tuple[Array, Array, float]:
        """Solve the linear equations of a direction for x, u and α.

        The equations are ``(C + Fᵀ W⁻² E) x + Aᵀ u = b``, ``A x + α w_L = −equilibrium`` and ``w_L·u = −work``.
        """
        problem, weights = self._problem, self._weights
        u = self._factor.solve(equilibrium + problem.A @ weights.solve(b))
        alpha = 0.0
        if self._free:
            alpha = float(-(work + self._w_L @ u) / (self._w_L @ self._of_load))
            u = u + alpha * self._of_load
        return weights.solve(b - problem.AT @ u), u, alpha

    def corrected(self, tangent: ContactState, *, balanced: bool) -> tuple[ContactState, float]:
        """Return Mehrotra's direction with Gondzio's correctors and its step.

        With ``balanced``, the share of the residuals removed is at most the share of the gap removed. Removing more
        lets the iterates leave the neighbourhood of the path.
        """
        state, scaling, mean = self._state, self._scaling, self._mean
        reach = min(1.0, state.longest_step(tangent))
        after = state.moved(tangent, reach)
        centring = float(np.clip(after.y.dot(after.z) / self._residuals.gap, 1e-2, 1.0)) ** 3
        residuals = self._residuals.scaled(1 - centring if balanced else 1.0)
        centre = centring * mean
        correction = scaling.divided(tangent.y).times(scaling.times(tangent.z))
        best = self.direction(centre, residuals, correction)
        reach = min(1.0, state.longest_step(best))
        for _ in range(CORRECTORS):
            if reach > 0.9:
                break
            beyond = state.moved(best, min(1.0, 1.2 * reach + 0.2))
            product = scaling.divided(beyond.y).times(scaling.times(beyond.z))
            add = (product.clipped(0.1 * centre, 10 * centre) - product).clipped(-10 * centre, 10 * centre)
            correction = correction - add
            trial = self.direction(centre, residuals, correction)
            trial_reach = min(1.0, state.longest_step(trial))
            if trial_reach < reach + 0.01:
                break
            best, reach = trial, trial_reach
        if reach < 0.1:
            # The corrections have shortened the step too much.
            plain = self.direction(max(centring, 0.5) * mean, residuals)
            plain_reach = min(1.0, state.longest_step(plain))
            if plain_reach > reach:
                best, reach = plain, plain_reach
        return best, min(1.0, FRACTION * state.longest_step(best))
