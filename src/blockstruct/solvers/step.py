"""One step of rigid blocks that touch, rub, are tied together and have mass."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit import ConicProgram, LimitProblem, ProcedureSettings
from blockstruct.solvers.corrected_forces import LEAST_FRICTION, Aim, corrected_forces, within
from blockstruct.solvers.interior_point import ContactProblem, ContactState, Step
from blockstruct.solvers.interior_point.cones import ConeVector
from blockstruct.solvers.interior_point.schur import OPTIONS
from blockstruct.solvers.splitting import Splitting

Array = NDArray[np.float64]
#: Contact forces (K, 3), tie forces (M,), displacements (6 F,) and load factor.
Forces = tuple[Array, Array, Array, float]

#: Compliances of contacts, softest first: displacement under a mean force, as shares of that of the step. Measured on
#: walls of 55 and 205 blocks: with 0.01 the load factor is within 1e-3 of that of the stiffest, and steps that are not
#: solved with it are not solved with softer ones either.
COMPLIANCES = (1e-2, 1e-3, 1e-4)
#: Newton iterations with one compliance, and those of the first attempt from the last forces.
ITERATIONS, ATTEMPT = 12, 6
#: Solutions from the forces that were found where stiffer contacts are not solved.
ROUNDS = 3
#: Residual of equilibrium, in dead wrenches, of a solution; and corrections of each linear system: nothing but inertia
#: resists a mechanism.
SOLVED, REFINEMENTS = 1e-9, 2
#: Of the splitting: residual, iterations in which it must halve, and its penalty, in displacements of the step under a
#: mean force.
TOLERANCE, PATIENCE, PENALTY = 1e-4, 60, 0.3
#: Residual of the splitting up to which its state is one.
ENOUGH = 1e-2
#: Where Newton's method does not solve a step: least normal force of a closed contact, relative to the mean, share of
#: friction within which forces begin to be balanced, and corrections.
PRESSED, INSIDE, CORRECTIONS = 1e-4, 1 - 1e-3, 30
#: Likewise: change of the load factor that costs as much as doubling a force, flow-rule gap that is little, both
#: relative to the load factor, and the share of their way below which corrections lead nowhere.
FREE, MISSES, NOWHERE = 1e-3, 1e-3, 0.05


@dataclass(frozen=True, slots=True)
class StepProblem:
    """What is known before a step.

        ``A x + Σ a_j T_j + w_D + α w_L = M Δu``, ``w_L·Δu = s`` or ``α`` given,
        ``C (x − x_0) + g + AᵀΔu = opening ≥ 0`` and sliding, with Coulomb's law without dilatancy

    Contacts open or stay closed at the end of the step. Forces that a rigid structure leaves open are those nearest to
    the ones before, and of several motions the one of least ``Δuᵀ M Δu`` is taken.

    Attributes
    ----------
    problem : LimitProblem
        Equilibrium, loads and strength.
    gap : (K,) array
        Of each contact point before the step, in the unit of its relative displacement.
    slack : (M,) array
        Elongation of each tie before it pulls, likewise.
    inertia : (6 F, 6 F) sparse array
        ``M``: mass divided by the square of a time. Softer contacts than the stiffest have more in proportion.
    force : (K, 3) array
        ``x_0``.
    tie_force : (M,) array
        Of ties, likewise.
    compliance : float
        Displacement of the step divided by a mean force, m/N: ``C`` is a share of it.
    displacement : float or None
        ``s``; None prescribes the load factor.
    load_factor : float
        That which is prescribed.
    """

    problem: LimitProblem
    gap: Array
    slack: Array
    inertia: sp.csr_array
    force: Array
    tie_force: Array
    compliance: float
    displacement: float | None
    load_factor: float = 0.0


@dataclass(frozen=True, slots=True)
class StepSolution:
    """What solves a step.

    Attributes
    ----------
    x, tie_force : (K, 3) and (M,) arrays
    u : (6 F,) array
        Displacements.
    load_factor : float
    inertia : float
        Factor of the inertia of the step with which it was solved.
    iterations : int
        Factorisations.
    """

    x: Array
    tie_force: Array
    u: Array
    load_factor: float
    inertia: float
    iterations: int


def solve_step(step: StepProblem, motion: Array, settings: ProcedureSettings) -> StepSolution | None:
    """Solve a step of joints with friction alone, and of ties.

    A Newton method finds forces, displacements and the state of every contact, from the last forces; where it does not,
    from what the splitting finds, which is slower to the last digit and surer of the first three. Contacts are then
    made stiffer for as long as Newton's method follows.

    Parameters
    ----------
    step, settings
        The step, and of its case.
    motion : (6 F,) array
        Displacements to begin with.

    Returns
    -------
    StepSolution or None
        Forces that are exactly in equilibrium; None if neither method finds any.
    """
    newton, soft = _Newton(step), COMPLIANCES[0]
    found = newton.solve(newton.tried(motion, soft), soft, ATTEMPT)
    spent = newton.iterations
    if found is None:
        split = _split(step, motion, soft, settings)
        if split is None:
            return None
        found = newton.solve(newton.tried_of(split, soft), soft, ITERATIONS)
        spent += 1 + newton.iterations
        if found is None:
            found = _balanced(step, split, *newton.projected(split), soft / COMPLIANCES[-1])
            return StepSolution(*found, soft / COMPLIANCES[-1], spent)
    rounds = 0
    while soft > COMPLIANCES[-1] and rounds <= ROUNDS:
        stiffer = max(c for c in COMPLIANCES if c < soft)
        following = newton.solve(newton.stiffened(soft / stiffer), stiffer, ITERATIONS)
        spent += newton.iterations
        if following is not None:
            found, soft = following, stiffer
            continue
        rounds += 1
        following = newton.again(found, soft)
        spent += newton.iterations
        if following is None:
            break
        found = following
    return StepSolution(*found, soft / COMPLIANCES[-1], spent)


def _split(step: StepProblem, motion: Array, soft: float, settings: ProcedureSettings) -> ContactState | None:
    """State of the step by splitting, for any condition of the joints."""
    problem, K = step.problem, step.problem.n_points
    compliance = soft * step.compliance * problem.force_unit**2
    contact = ContactProblem(ConicProgram(problem, settings), np.repeat(compliance[:, None], 3, axis=1))
    splitting = Splitting(contact, step.inertia * (soft / COMPLIANCES[-1]))
    reference, opening = np.zeros((2, contact.conditions.size))
    reference[: 3 * K], reference[contact.ties] = step.force.ravel(), step.tie_force
    opening[: 3 * K : 3], opening[contact.ties] = step.gap, step.slack
    y = contact.conditions.of_forces(reference) + contact.conditions.offset
    soc = y.soc.copy()
    size, most = np.linalg.norm(soc[:, 1:], axis=1), np.maximum(soc[:, 0], 0.0)
    soc[:, 0], soc[:, 1:] = most, soc[:, 1:] * np.minimum(1.0, most / np.maximum(size, 1e-300))[:, None]
    y, v = ConeVector(soc, np.maximum(y.line, 0.0)), (contact.AT @ motion)[: 3 * K].reshape(-1, 3)
    slip, open_ = np.zeros_like(soc), np.zeros_like(y.line)
    open_[:K] = np.where(step.force[:, 0] > 0, 0.0, np.maximum(v[:, 0] + step.gap, 0.0))
    guess = ContactState(reference, y, ConeVector(slip, open_), motion, step.load_factor)
    try:
        found = splitting.solve(
            Step(reference, opening, step.displacement, step.load_factor),
            guess,
            penalty=PENALTY / soft,
            tolerance=TOLERANCE,
            patience=PATIENCE,
        )
    except RuntimeError:
        return None
    return found.state if found.residual <= ENOUGH else None


def _balanced(step: StepProblem, split: ContactState, x: Array, T: Array, inertia: float) -> Forces:
    """Forces in equilibrium near others (K, 3) that miss the flow rule least; these themselves if there are none."""
    problem, s, u, alpha = step.problem, step.displacement, split.u, split.alpha
    pressed = x[:, 0] > PRESSED * x[:, 0].mean()
    mu = np.maximum(problem.friction[pressed], LEAST_FRICTION)
    wanted = inertia * (step.inertia @ u) - problem.unbalanced(np.zeros_like(x), T, 0.0 if s is not None else alpha)
    aim = None
    if s is not None:
        v = (problem.A.T @ u).reshape(-1, 3)[pressed]
        opening, slip = np.maximum(v[:, 0] + step.gap[pressed], 0.0), np.hypot(v[:, 1], v[:, 2])
        scale = max(abs(alpha), -float((x[pressed, 1:] * v[:, 1:]).sum()) / s)
        cost = np.column_stack([opening + mu * slip, v[:, 1:]]) / s
        aim = Aim(problem.w_L, alpha, FREE * scale, cost, MISSES * scale, NOWHERE)
    columns, begin = problem.A[:, np.repeat(pressed, 3)], within(x[pressed], mu, INSIDE)
    found = corrected_forces(columns, mu, begin, wanted, corrections=CORRECTIONS, aim=aim)
    if found is not None:
        x = np.zeros_like(x)
        x[pressed] = found[0]
        alpha = found[1] if s is not None else alpha
    return x, T, u, alpha


class _Newton:
    """The iteration of P. Alart, A. Curnier (Comput. Methods Appl. Mech. Eng. 92 (1991) 353–375).

    Its unknowns are forces that contacts and ties would have without conditions, ``x_0 − C⁻¹ (g + AᵀΔu)``: three of
    each contact, one of each tie. Projected onto their conditions, they are in equilibrium.
    """

    def __init__(self, step: StepProblem) -> None:
        problem = step.problem
        self._step, self._K, self.iterations = step, problem.n_points, 0
        self._B = sp.csr_array(sp.hstack([problem.A, problem.ties.columns]))
        self._BT = sp.csr_array(self._B.T)
        unit = np.concatenate([np.repeat(problem.force_unit, 3), problem.ties.force_unit])
        self._soft = step.compliance * unit**2
        self._before = np.concatenate([step.force.ravel(), step.tie_force])
        self._open = np.zeros_like(self._before)
        self._open[: 3 * self._K : 3], self._open[3 * self._K :] = step.gap, step.slack
        place = 3 * np.arange(self._K)[:, None, None]
        rows, columns = np.broadcast_arrays(place + np.arange(3)[:, None], place + np.arange(3))
        tie = 3 * self._K + np.arange(len(problem.ties))
        self._rows, self._columns = (np.concatenate([part.ravel(), tie]) for part in (rows, columns))
        self._last = self._before

    def tried(self, u: Array, soft: float) -> Array:
        """Forces without conditions, of displacements."""
        return np.asarray(self._before - (self._BT @ u + self._open) / (soft * self._soft))

    def tried_of(self, state: ContactState, soft: float) -> Array:
        """The same of a state that is only nearly a solution: those that its own conditions were applied to."""
        K, x = self._K, self.projected(state)
        soft_of = soft * self._soft[: 3 * K].reshape(-1, 3)
        slip, opening = np.zeros((K, 3)), state.z.line[:K]
        slip[:, 0], slip[:, 1:] = opening, state.z.soc[:K, 1:]
        return np.concatenate([(x[0] - slip / soft_of).ravel(), state.x[len(state.x) - len(x[1]) :]])

    def projected(self, state: ContactState) -> tuple[Array, Array]:
        """Contact forces (K, 3) and tie forces (M,) of a state, inside their conditions."""
        problem, sliding = self._step.problem, state.y.soc[: self._K]
        n = np.divide(
            sliding[:, 0], problem.friction, out=state.x[: 3 * self._K : 3].copy(), where=problem.friction > 0
        )
        n = np.where(state.z.line[: self._K] > 0, 0.0, np.maximum(n, 0.0))
        T = state.x[len(state.x) - len(problem.ties) :]
        return np.column_stack([n, sliding[:, 1:]]), np.clip(T, 0.0, problem.ties.capacity)

    def stiffened(self, ratio: float) -> Array:
        """Forces without conditions of the last solution, for contacts that are stiffer by a ratio."""
        kept, _ = self._cut(self._last)
        return np.asarray(kept + ratio * (self._last - kept))

    def again(self, found: Forces, soft: float) -> "Forces | None":
        """Solve again, with forces nearest to those that were found: what contacts miss of the flow rule is less."""
        self._before = np.concatenate([found[0].ravel(), found[1]])
        return self.solve(self._last, soft, ATTEMPT)

    def solve(self, tried: Array, soft: float, most: int) -> "Forces | None":
        """Contact forces, tie forces, displacements and load factor; None if they are not found."""
        step, problem = self._step, self._step.problem
        stiff, w, s = 1 / (soft * self._soft), problem.w_L, step.displacement
        inertia = step.inertia * (soft / COMPLIANCES[-1])
        kept, slope = self._cut(tried)
        least = np.inf
        for self.iterations in range(1, most + 1):
            D = sp.csr_array((slope * stiff[self._columns], (self._rows, self._columns)), shape=2 * (len(kept),))
            D.eliminate_zeros()
            S = sp.csc_matrix(self._B @ D @ self._BT + inertia)
            try:
                lu = sp.linalg.splu(S, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options=OPTIONS)
            except RuntimeError:
                return None
            linear = slope * (self._before - stiff * self._open - tried)[self._columns]
            forces = kept + np.bincount(self._rows, linear, len(kept))
            b = self._B @ forces + problem.w_D
            push, u, alpha = lu.solve(w), np.zeros(len(w)), step.load_factor
            for _ in range(1 + REFINEMENTS):
                more = lu.solve(b + alpha * w - S @ u)
                rise = 0.0 if s is None else float((s - w @ (u + more)) / (w @ push))
                u, alpha = u + more + rise * push, alpha + rise
            last, tried = tried, self.tried(u, soft)
            kept, slope = self._cut(tried)
            missed = np.abs(self._B @ kept + problem.w_D + alpha * w - inertia @ u).max()
            if missed <= SOLVED:
                self._last = tried
                return kept[: 3 * self._K].reshape(-1, 3), kept[3 * self._K :], u, float(alpha)
            if not np.isfinite(missed):
                break
            if missed >= least:
                # Contacts that change their state to and fro go half of the way.
                tried = (tried + last) / 2
                kept, slope = self._cut(tried)
            least = min(least, missed)
        return None

    def _cut(self, tried: Array) -> tuple[Array, Array]:
        """Forces that fulfil their conditions, and the derivatives: the entries of small blocks."""
        problem, K = self._step.problem, self._K
        x, T = tried[: 3 * K].reshape(-1, 3), tried[3 * K :]
        n, size = np.maximum(x[:, 0], 0.0), np.hypot(x[:, 1], x[:, 2])
        slides = size > problem.friction * n
        share = np.where(slides, problem.friction * n / np.maximum(size, 1e-300), 1.0)
        along = x[:, 1:] / np.maximum(size, 1e-300)[:, None]
        slope = np.zeros((K, 3, 3))
        slope[:, 0, 0] = n > 0
        slope[:, 1, 1] = slope[:, 2, 2] = share
        slope[:, 1:, 1:] -= np.where(slides, share, 0.0)[:, None, None] * along[:, :, None] * along[:, None]
        slope[:, 1:, 0] = np.where(slides & (n > 0), problem.friction, 0.0)[:, None] * along
        cut = np.clip(T, 0.0, problem.ties.capacity)
        kept = np.column_stack([n, share[:, None] * x[:, 1:]])
        return np.concatenate([kept.ravel(), cut]), np.concatenate([slope.ravel(), (cut == T).astype(float)])
