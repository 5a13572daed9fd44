"""Solve frictional contact over one step of displacement.

The method is a primal–dual interior-point loop.
"""

from copy import copy
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from typing import Self

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array
from blockstruct.limit import ConicProgram
from blockstruct.limit.friction import Sliding
from blockstruct.solvers.interior_point.conditions import Conditions, Weights
from blockstruct.solvers.interior_point.cones import ConeVector, Scaling, centred
from blockstruct.solvers.interior_point.schur import OPTIONS, Factor, SchurComplement


@dataclass(frozen=True, slots=True)
class ContactState:
    """Forces, multipliers, displacements and load factor, non-dimensional.

    Attributes
    ----------
    x : (N,) array
        Contact forces, then the auxiliary variables of crushing.
    y, z : ConeVector
        ``E x + e`` and its multipliers.
    u : (6 F,) array
        Displacements of the step.
    alpha : float
        Load factor.
    """

    x: Array
    y: ConeVector
    z: ConeVector
    u: Array
    alpha: float

    def moved(self, d: "ContactState", t: float) -> "ContactState":
        """Return ``self + t d``."""
        return ContactState(
            self.x + t * d.x, self.y + t * d.y, self.z + t * d.z, self.u + t * d.u, self.alpha + t * d.alpha
        )

    def scaled(self, ratio: float) -> "ContactState":
        """Return the state with multipliers and displacements scaled."""
        return ContactState(self.x, self.y, ratio * self.z, ratio * self.u, self.alpha)

    def backwards(self) -> "ContactState":
        """Return the opposite direction."""
        return ContactState(-self.x, -1.0 * self.y, -1.0 * self.z, -self.u, -self.alpha)

    def longest_step(self, d: "ContactState") -> float:
        """Return the largest t for which ``self + t d`` stays in the cones."""
        return min(self.y.longest_step(d.y), self.z.longest_step(d.z))


@dataclass(frozen=True, slots=True)
class Residuals:
    """Residuals of a state, and the complementarity gap ``y·z``."""

    equilibrium: Array
    flow: Array
    work: float
    forces: ConeVector
    gap: float

    def scaled(self, share: float) -> "Residuals":
        """Return a share of the residuals, with the same gap."""
        return Residuals(share * self.equilibrium, share * self.flow, share * self.work, share * self.forces, self.gap)


@dataclass(frozen=True, slots=True)
class ContactSolution:
    """State with the errors of its step.

    Attributes
    ----------
    state : ContactState
        The state.
    unbalanced, incompatible, gap : float
        Largest residual of equilibrium and of forces in the cones. Largest residual of displacements, relative to the
        largest displacement. Complementarity gap relative to the work of the step.
    iterations : int
        Factorisations.
    """

    state: ContactState
    unbalanced: float
    incompatible: float
    gap: float
    iterations: int

    def within(self, tolerance: float) -> bool:
        """Return whether displacements and gap are within a tolerance.

        Forces must be within a tenth of the tolerance.
        """
        return self.unbalanced <= 0.1 * tolerance and self.incompatible <= tolerance and self.gap <= tolerance


@dataclass(frozen=True, slots=True)
class Step:
    """Data of one step: memory of contacts and prescribed displacement.

    Attributes
    ----------
    reference : (N,) array
        Forces about which contacts are elastic.
    opening : (N,) array
        Opening before the step, in the rows of normal forces.
    displacement : float or None
        ``w_L·u``; None keeps the load factor at zero.
    """

    reference: Array
    opening: Array
    displacement: float | None


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
        ahead = self._scaling.divided(self._scaling.point.solve(target))
        b = conditions.flow(ahead - self._weights.times(residuals.forces)) - residuals.flow
        x, u, alpha = self._forces(b, residuals.equilibrium, residuals.work)
        for refinement in range(REFINEMENTS + 1):
            y = conditions.of_forces(x) + residuals.forces
            z = ahead - self._weights.times(y)
            missed = conditions.flow(z) - residuals.flow - problem.compliance * x - problem.AT @ u
            is_precise = not np.abs(missed).max() > PRECISION * np.abs(residuals.flow).max()
            if is_precise or refinement == REFINEMENTS:
                break
            equilibrium = residuals.equilibrium + problem.A @ x + alpha * self._w_L
            more = self._forces(missed, equilibrium, residuals.work + float(self._w_L @ u))
            x, u, alpha = x + more[0], u + more[1], alpha + more[2]
        return ContactState(x, y, z, u, alpha)

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


#: Share of the way to the boundary at a turn of the central path; largest growth of the gap on the way back. Measured:
#: with the share of other steps a wall that crushes ends 0.1 % higher; with any growth a wall with ties ends 9 % lower.
TURNING_STEP, LARGEST_TURN = 0.5, 1.5
#: Number of iterations in which the largest residual must halve.
PATIENCE = 20
#: Complementarity gap of a first state, in multiples of the work of its step. Measured: with ten times the work, a
#: first step takes half as many factorisations as from the state under dead load (820 blocks: 20 instead of 51).
WIDE = 10.0


class ContactProblem:
    """Find x, u and α of a step with elastic, frictional contacts.

    Joints may also crush. With compliances C the step is

        ``A x + w_D + α w_L = 0``, ``C (x − x_0) + δ + Aᵀ u = Fᵀ z``, ``w_L·u = s``,
        ``E x + e = y ∈ K``, ``z ∈ K``, ``y ∘ z = 0``

    (:class:`Conditions`). Only the last equation is nonlinear. If the slope of dilatancy is less than friction, F is
    not E, and the problem is not monotone. The central path may then turn back. The loop follows the path round the
    turn, with a growing gap, instead of stopping there. The same law with De Saxcé's norm: V. Acary, P. Armand, H. M.
    Nguyen, M. Shpakovych, "Second-order cone programming for frictional contact mechanics using interior point
    algorithm", Optimization Methods and Software (2024).

    Parameters
    ----------
    program
        The program, with exact crushing. Its ties are rigid until they yield.
    compliance : (K, 3) array
        Compliance of each contact point, displacement per unit of force.
    """

    def __init__(self, program: ConicProgram, compliance: Array) -> None:
        self._program = program
        self.problem = program.problem
        self.conditions = Conditions(program)
        ties, size = self.problem.ties, self.conditions.size
        auxiliary = size - compliance.size - len(ties)
        columns = [self.problem.A, sp.csr_array((self.problem.A.shape[0], auxiliary)), ties.columns]
        self.A = sp.csr_array(sp.hstack(columns))
        self.AT = sp.csr_array(self.A.T)
        self.compliance = np.concatenate([compliance.ravel(), np.zeros(auxiliary + len(ties))])
        #: Positions of tie forces among the variables, and of ``T' ≥ 0`` among the half-lines.
        self.ties = slice(size - len(ties), size)
        self.slack = slice(program.slack_rows.start - 1, program.slack_rows.stop - 1)

    @property
    def at_rest(self) -> sp.dia_array:
        """Return the identity of idle rows, which keeps their velocities at zero."""
        return sp.diags_array(self.problem.idle.astype(float))

    @cached_property
    def complement(self) -> SchurComplement:
        """Return the Schur complement with the pattern of all factorisations."""
        return SchurComplement(sp.csc_array(self.A), self.conditions, self.problem.idle)

    def with_sliding(self, sliding: Sliding) -> Self:
        """Return the same contacts with another sliding condition."""
        other = copy(self)
        other.conditions = Conditions(self._program, sliding)
        return other

    def rigid(self, sliding: Sliding) -> Self:
        """Return the same contacts without compliance.

        They have another sliding condition.
        """
        # Computed here, the pattern is available to all copies.
        pattern = self.complement
        other = self.with_sliding(sliding)
        other.compliance, other.complement = np.zeros_like(self.compliance), pattern
        return other

    def start(self) -> ContactState:
        """Return a state with unit forces and multipliers.

        Its displacements are zero.
        """
        one = self.conditions.identity()
        x = np.zeros(self.conditions.size)
        x[: self.problem.n_points * 3 : 3] = 1.0
        return ContactState(x, one, one, np.zeros(self.A.shape[0]), 0.0)

    def afresh(self, normal: float, displacement: float, alpha: float) -> ContactState:
        """Return a first state for a step.

        It lies on the central path, with a wide gap and far from any boundary.

        Parameters
        ----------
        normal
            Normal force at every contact point.
        displacement, alpha
            Displacement of the step, and first load factor.
        """
        x = np.zeros(self.conditions.size)
        x[: self.problem.n_points * 3 : 3] = normal
        y = self.conditions.of_forces(x) + self.conditions.offset
        y = y.inside(self.conditions.identity(), 1e-3)
        mu = WIDE * displacement * max(abs(alpha), 1e-3) / y.degree
        return ContactState(x, y, mu * y.inverse(), np.zeros(self.A.shape[0]), alpha)

    def beside(self, state: ContactState) -> ContactState:
        """Return a first state near another state of unit work.

        Forces are unchanged. Pairs are centred at a complementarity gap as large as the load factor. Measured: from a
        tenth of this gap, 2,430 blocks are not solved.

        Parameters
        ----------
        state
            State of unit work. Its pairs need not be inside the cones.
        """
        mu = max(abs(state.alpha), 1e-3) / state.y.degree
        # Pairs of two zeros diverge, and the loop detects the result.
        with np.errstate(all="ignore"):
            y = centred(self.conditions.of_forces(state.x) + self.conditions.offset, state.z, mu)
            return ContactState(state.x, y, mu * y.inverse(), state.u, state.alpha)

    def elastic_displacement(self) -> float:
        """Return ``w_L·u`` under the variable load with all contacts held.

        Ties do not act.

        Raises
        ------
        RuntimeError
            If there are blocks that no contact holds.
        """
        # Rigid ties that carry the load would leave no displacement to begin with. Auxiliary variables are not forces.
        held = np.zeros_like(self.compliance)
        held[: 3 * self.problem.n_points] = 1 / self.compliance[: 3 * self.problem.n_points]
        stiffness = sp.csc_matrix(self.A @ sp.diags_array(held) @ self.AT + self.at_rest)
        w_L = self.problem.w_L
        if self.problem.settlement is not None:
            # Supports that carry all take the structure with them, without elastic forces.
            alone = stiffness[-1, -1]
            stiffness[-1, -1] *= 1 + ROUNDING
        elastic = sp.linalg.splu(stiffness, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options=OPTIONS)
        displacement = float(w_L @ elastic.solve(w_L))
        if self.problem.settlement is not None and displacement * alone * NEGLIGIBLE > w_L[-1] ** 2:
            return float(w_L[-1] ** 2 / alone)
        return displacement

    def solve(self, step: Step, guess: ContactState, *, centre: bool, tolerance: float) -> ContactSolution:
        """Solve a step.

        Parameters
        ----------
        step
            The step.
        guess
            State to start from.
        centre
            Whether the guess is first centred at a complementarity gap as large as the work of the step. Its forces and
            multipliers then need not be inside the cones.
        tolerance
            Tolerance of displacements and gap, and ten times the tolerance of forces.
        """
        # A diverging state ends in infinities or NaN, and the loop detects them.
        with np.errstate(all="ignore"):
            start = self._centred(step, guess) if centre else guess
            return self._solved(step, start, tolerance)

    def _solved(self, step: Step, state: ContactState, tolerance: float) -> ContactSolution:
        ahead: ContactState | None = None
        turned_at, largest = np.inf, list[float]()
        for k in count():
            residuals = self._residuals(step, state)
            now = self._measured(step, state, residuals, k)
            largest.append(max(now.unbalanced, now.incompatible, now.gap))
            if k and not np.isfinite(largest[-1]):
                break
            found = now
            stalled = k >= PATIENCE and not largest[-1] < 0.5 * largest[-1 - PATIENCE]
            if found.within(tolerance) or stalled:
                break
            try:
                newton = Newton(self, step, state, residuals)
            except (RuntimeError, np.linalg.LinAlgError):
                break
            tangent = newton.direction(0.0, residuals)
            balanced = max(found.unbalanced, found.incompatible) < found.gap
            if found.gap > LARGEST_TURN * turned_at:
                # This was not a turn, and the way back has failed.
                ahead = None
            if balanced and ahead is not None and newton.inner(tangent, ahead) < 0:
                turned_at = min(turned_at, found.gap)
                tangent = tangent.backwards()
                t = TURNING_STEP * min(1.0, state.longest_step(tangent))
                state = state.moved(tangent, t)
            else:
                turned_at = np.inf
                d, t = newton.corrected(tangent, balanced=balanced)
                state = state.moved(d, t)
            ahead = tangent
            if not t > ROUNDING:
                break
        return found

    def _centred(self, step: Step, guess: ContactState) -> ContactState:
        mu = self._work(step, guess) / guess.y.degree
        y = centred(self.conditions.of_forces(guess.x) + self.conditions.offset, guess.z, mu)
        x = self.conditions.forces_of(y, guess.x)
        y = (self.conditions.of_forces(x) + self.conditions.offset).inside(y, 0.1)
        return ContactState(x, y, mu * y.inverse(), guess.u, guess.alpha)

    def _work(self, step: Step, state: ContactState) -> float:
        if not step.displacement:
            return max(float(self.compliance @ state.x**2), 1e-300)
        return abs(step.displacement) * max(abs(state.alpha), 1e-3)

    def _residuals(self, step: Step, state: ContactState) -> Residuals:
        problem = self.problem
        return Residuals(
            equilibrium=self.A @ state.x + problem.w_D + state.alpha * problem.w_L,
            flow=self.compliance * (state.x - step.reference)
            + step.opening
            + self.AT @ state.u
            - self.conditions.flow(state.z),
            work=0.0 if step.displacement is None else float(problem.w_L @ state.u - step.displacement),
            forces=self.conditions.of_forces(state.x) + self.conditions.offset - state.y,
            gap=state.y.dot(state.z),
        )

    def _measured(self, step: Step, state: ContactState, residuals: Residuals, k: int) -> ContactSolution:
        forces = residuals.forces
        unbalanced = max(
            np.abs(residuals.equilibrium).max(), np.abs(forces.soc).max(), np.abs(forces.line).max(initial=0.0)
        )
        speed = max(np.abs(self.AT @ state.u).max(), 1e-300)
        incompatible = float(np.abs(residuals.flow).max() / speed)
        gap = residuals.gap / self._work(step, state)
        return ContactSolution(state, float(unbalanced), incompatible, gap, k)
