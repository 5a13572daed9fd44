"""Frictional contact over one step of displacement: a primal–dual interior-point loop."""

from copy import copy
from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit import ConicProgram, Sliding
from blockstruct.solvers.interior_point.conditions import Conditions, Weights
from blockstruct.solvers.interior_point.cones import ConeVector, Scaling, centred
from blockstruct.solvers.interior_point.schur import Factor, SchurComplement

Array = NDArray[np.float64]

#: Share of the way to the boundary that a step goes.
FRACTION = 0.99
#: Centrality correctors a factorisation (Gondzio). Measured: two save a third of the factorisations, more save none.
CORRECTORS = 2
#: Share of the way to the boundary where the central path turns back, and how far the gap may rise on that way.
TURNING_STEP, LARGEST_TURN = 0.5, 1.5
#: Rounding that a direction may have, relative to what displacements miss, and refinements to that end.
PRECISION, REFINEMENTS = 1e-2, 2
#: Iterations in which the largest residual must halve, and the shortest step.
PATIENCE, SHORTEST = 20, 1e-7


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
    """

    x: Array
    y: ConeVector
    z: ConeVector
    u: Array
    alpha: float

    def moved(self, d: "ContactState", t: float) -> "ContactState":
        """``self + t d``."""
        return ContactState(
            self.x + t * d.x, self.y + t * d.y, self.z + t * d.z, self.u + t * d.u, self.alpha + t * d.alpha
        )

    def scaled(self, ratio: float) -> "ContactState":
        """The same with displacements in another ratio."""
        return ContactState(self.x, self.y, ratio * self.z, ratio * self.u, self.alpha)

    def backwards(self) -> "ContactState":
        """The opposite direction."""
        return ContactState(-self.x, -1.0 * self.y, -1.0 * self.z, -self.u, -self.alpha)

    def longest_step(self, d: "ContactState") -> float:
        """Largest t for which ``self + t d`` stays inside the cones."""
        return min(self.y.longest_step(d.y), self.z.longest_step(d.z))


@dataclass(frozen=True, slots=True)
class Residuals:
    """What a state misses, and the complementarity gap ``y·z``."""

    equilibrium: Array
    flow: Array
    work: float
    forces: ConeVector
    gap: float

    def scaled(self, share: float) -> "Residuals":
        """A share of them."""
        return Residuals(share * self.equilibrium, share * self.flow, share * self.work, share * self.forces, self.gap)


@dataclass(frozen=True, slots=True)
class ContactSolution:
    """A state, and how far it is from solving its step.

    Attributes
    ----------
    state : ContactState
    solved : bool
        Whether all three measures are within the tolerance.
    unbalanced, incompatible, gap : float
        Largest residual of equilibrium and of forces in the cones; of displacements, relative to the largest; and
        the complementarity gap relative to the work of the step.
    iterations : int
        Factorisations.
    """

    state: ContactState
    solved: bool
    unbalanced: float
    incompatible: float
    gap: float
    iterations: int


@dataclass(frozen=True, slots=True)
class Step:
    """One step: what contacts remember, and the prescribed displacement.

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


class ContactProblem:
    """Finds x, u and α of a step with equilibrium, elastic contacts, friction and crushing.

    With compliances C the step is

        ``A x + w_D + α w_L = 0``, ``C (x − x_0) + δ + Aᵀ u = Fᵀ z``, ``w_L·u = s``,
        ``E x + e = y ∈ K``, ``z ∈ K``, ``y ∘ z = 0``

    (:class:`Conditions`): linear but for the last. Where sliding dilates less than it rubs, F is not E, the problem is
    not monotone and its central path may turn back. The loop then follows it round the turn, with growing gap,
    instead of stopping there. The same law with De Saxcé's norm in it: V. Acary, P. Armand, H. M. Nguyen,
    M. Shpakovych, "Second-order cone programming for frictional contact mechanics using interior point algorithm",
    Optimization Methods and Software (2024).

    Parameters
    ----------
    program
        The program, with exact crushing.
    compliance : (K, 3) array
        Of each contact point, displacement a unit of force.
    """

    def __init__(self, program: ConicProgram, compliance: Array) -> None:
        self._program = program
        self.problem = program.problem
        self.conditions = Conditions(program)
        auxiliary = self.conditions.size - compliance.size
        self.A = sp.csr_array(sp.hstack([self.problem.A, sp.csr_array((self.problem.A.shape[0], auxiliary))]))
        self._AT = sp.csr_array(self.A.T)
        self.compliance = np.concatenate([compliance.ravel(), np.zeros(auxiliary)])
        self._complement = SchurComplement(sp.csc_array(self.A), self.conditions)

    def with_sliding(self, sliding: Sliding) -> Self:
        """The same contacts with another sliding condition."""
        other = copy(self)
        other.conditions = Conditions(self._program, sliding)
        return other

    def start(self) -> ContactState:
        """A state to begin with: unit forces and multipliers, nothing moved."""
        one = self.conditions.identity()
        x = np.zeros(self.conditions.size)
        x[: self.problem.n_points * 3 : 3] = 1.0
        return ContactState(x, one, one, np.zeros(self.A.shape[0]), 0.0)

    def elastic_displacement(self) -> float:
        """Displacement ``w_L·u`` under the variable load if every contact held.

        Raises
        ------
        RuntimeError
            Blocks that no contact holds.
        """
        one = self.conditions.identity()
        # Multipliers that weigh nothing leave the compliance alone.
        weights = self.conditions.weights(Scaling(one, 1e-12 * one), self.compliance + 1e-9)
        return float(self.problem.w_L @ self._complement.factorised(weights).solve(self.problem.w_L))

    def solve(
        self, step: Step, guess: ContactState, *, centring: float, tolerance: float, max_iterations: int
    ) -> ContactSolution:
        """Solve a step.

        Parameters
        ----------
        step
            The step.
        guess
            State to start from; its forces and multipliers need not be inside the cones.
        centring
            Complementarity gap of the start, in multiples of the work of the step.
        tolerance
            Of displacements and gap; a tenth of it of forces.
        max_iterations
            Factorisations.
        """
        # A state that has lost its way ends in numbers that are none, which is seen.
        with np.errstate(all="ignore"):
            return self._solved(step, self._centred(step, guess, centring), tolerance, max_iterations)

    def _solved(self, step: Step, state: ContactState, tolerance: float, max_iterations: int) -> ContactSolution:
        ahead: ContactState | None = None
        turned_at, trail = np.inf, list[float]()
        for k in range(max_iterations + 1):
            residuals = self._residuals(step, state)
            now = self._measured(step, state, residuals, tolerance, k)
            trail.append(max(now.unbalanced, now.incompatible, now.gap))
            if k and not np.isfinite(trail[-1]):
                break
            found = now
            stalled = k >= PATIENCE and not trail[-1] < 0.5 * trail[-1 - PATIENCE]
            if found.solved or stalled or k == max_iterations:
                break
            try:
                newton = _Newton(self, step, state, residuals)
            except RuntimeError:
                break
            tangent = newton.direction(0.0, residuals)
            balanced = max(found.unbalanced, found.incompatible) < found.gap
            if found.gap > LARGEST_TURN * turned_at:
                # It was no turn, and the way back leads nowhere.
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
            if not t > SHORTEST:
                break
        return found

    def _centred(self, step: Step, guess: ContactState, centring: float) -> ContactState:
        mu = centring * self._work(step, guess) / guess.y.degree
        y = centred(self.conditions.of_forces(guess.x) + self.conditions.offset, guess.z, mu)
        x = self.conditions.forces_of(y, guess.x)
        y = (self.conditions.of_forces(x) + self.conditions.offset).inside(y, 0.1)
        return ContactState(x, y, mu * y.inverse(), guess.u, guess.alpha)

    def _work(self, step: Step, state: ContactState) -> float:
        if step.displacement is None:
            return max(float(self.compliance @ state.x**2), 1e-300)
        return abs(step.displacement) * max(abs(state.alpha), 1e-3)

    def _residuals(self, step: Step, state: ContactState) -> Residuals:
        problem = self.problem
        return Residuals(
            equilibrium=self.A @ state.x + problem.w_D + state.alpha * problem.w_L,
            flow=self.compliance * (state.x - step.reference)
            + step.opening
            + self._AT @ state.u
            - self.conditions.flow(state.z),
            work=0.0 if step.displacement is None else float(problem.w_L @ state.u - step.displacement),
            forces=self.conditions.of_forces(state.x) + self.conditions.offset - state.y,
            gap=state.y.dot(state.z),
        )

    def _measured(
        self, step: Step, state: ContactState, residuals: Residuals, tolerance: float, k: int
    ) -> ContactSolution:
        forces = residuals.forces
        unbalanced = max(
            np.abs(residuals.equilibrium).max(), np.abs(forces.soc).max(), np.abs(forces.line).max(initial=0.0)
        )
        speed = max(np.abs(self._AT @ state.u).max(), 1e-300)
        incompatible = float(np.abs(residuals.flow).max() / speed)
        gap = residuals.gap / self._work(step, state)
        solved = unbalanced <= 0.1 * tolerance and incompatible <= tolerance and gap <= tolerance
        return ContactSolution(state, bool(solved), float(unbalanced), incompatible, gap, k)


class _Newton:
    """Newton's directions at one state, with one factorisation."""

    def __init__(self, problem: ContactProblem, step: Step, state: ContactState, residuals: Residuals) -> None:
        self._problem, self._state, self._residuals = problem, state, residuals
        self._free = step.displacement is not None
        self._scaling = Scaling(state.y, state.z)
        self._weights: Weights = problem.conditions.weights(self._scaling, problem.compliance)
        self._factor: Factor = problem._complement.factorised(self._weights)
        self._w_L = problem.problem.w_L
        self._of_load = self._factor.solve(self._w_L) if self._free else np.zeros_like(self._w_L)
        self._mean = residuals.gap / state.y.degree
        self._squared = self._scaling.point.times(self._scaling.point)

    def inner(self, a: ContactState, b: ContactState) -> float:
        """Inner product of two directions in the scaled space."""
        scaling = self._scaling
        return scaling.divided(a.y).dot(scaling.divided(b.y)) + scaling.times(a.z).dot(scaling.times(b.z))

    def direction(self, centre: float, residuals: Residuals, correction: ConeVector | None = None) -> ContactState:
        """Direction to the point with ``y ∘ z = centre e``, less a correction of second order."""
        problem, conditions = self._problem, self._problem.conditions
        target = centre * conditions.identity() - self._squared
        if correction is not None:
            target = target - correction
        h = self._scaling.divided(self._scaling.point.solve(target)) - self._weights.times(residuals.forces)
        b = conditions.flow(h) - residuals.flow
        x, u, alpha = self._forces(b, residuals.equilibrium, residuals.work)
        for _ in range(REFINEMENTS):
            y = conditions.of_forces(x)
            missed = b - problem.compliance * x - conditions.flow(self._weights.times(y)) - problem._AT @ u
            if not np.abs(missed).max() > PRECISION * np.abs(residuals.flow).max():
                break
            equilibrium = residuals.equilibrium + problem.A @ x + alpha * self._w_L
            more = self._forces(missed, equilibrium, residuals.work + float(self._w_L @ u))
            x, u, alpha = x + more[0], u + more[1], alpha + more[2]
        y = conditions.of_forces(x)
        return ContactState(x, y + residuals.forces, h - self._weights.times(y), u, alpha)

    def _forces(self, b: Array, equilibrium: Array, work: float) -> tuple[Array, Array, float]:
        """x, u, α of ``(C + Fᵀ W⁻² E) x + Aᵀ u = b``, ``A x + α w_L = −equilibrium``, ``w_L·u = −work``."""
        problem, weights = self._problem, self._weights
        u = self._factor.solve(equilibrium + problem.A @ weights.solve(b))
        alpha = 0.0
        if self._free:
            alpha = float(-(work + self._w_L @ u) / (self._w_L @ self._of_load))
            u = u + alpha * self._of_load
        return weights.solve(b - problem._AT @ u), u, alpha

    def corrected(self, tangent: ContactState, *, balanced: bool) -> tuple[ContactState, float]:
        """Mehrotra's direction with Gondzio's correctors, and how far to go along it.

        ``balanced`` takes off no larger a share of the residuals than of the gap: taking off more lets the iterates
        leave the neighbourhood of the path.
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
            # The corrections have spoilt it.
            plain = self.direction(max(centring, 0.5) * mean, residuals)
            plain_reach = min(1.0, state.longest_step(plain))
            if plain_reach > reach:
                best, reach = plain, plain_reach
        return best, min(1.0, FRACTION * state.longest_step(best))
