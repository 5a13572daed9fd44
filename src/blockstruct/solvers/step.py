"""One step of rigid blocks with elastic contacts, friction, ties and inertia."""

from dataclasses import dataclass
from typing import Any

import clarabel
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit import LimitProblem
from blockstruct.solvers.interior_point.schur import OPTIONS

Array = NDArray[np.float64]

#: Residual of equilibrium, in dead wrenches, of a solution.
SOLVED = 1e-9
#: Share of its limit from which friction slid in the step before.
SLIDES = 1e-6
#: Most Newton iterations.
ITERATIONS = 8
#: Most cone programs with fixed limits of friction.
ROUNDS = 6
#: Earlier residuals of which the largest must not be exceeded, and halvings of a step to get there.
RECENT, HALVINGS = 4, 4
#: Refinements of each linear solution. Only inertia resists a mechanism.
REFINEMENTS = 2


@dataclass(frozen=True, slots=True)
class StepProblem:
    """Equilibrium and contacts at the end of a step.

        ``A x + Σ a_j T_j + w_D + α w_L = M Δu``, and ``w_L·Δu = s`` or α given

    A contact is elastic. Its normal force follows from the overlap at the end of the step, ``n = −(g + Δu_n) / C ≥ 0``.
    Its friction force changes by the slip of the step, ``−Δu_t / C``, and then moves back to the disc ``μ n``. There is
    no dilatancy. A tie pulls by its elongation at the end of the step divided by C, at most by its capacity.

    Attributes
    ----------
    problem : LimitProblem
        Equilibrium, loads and strength.
    gap : (K,) array
        Gap of each contact point before the step, in the unit of its relative displacement; negative for an overlap.
    slack : (M,) array
        Elongation of each tie before it pulls, in the unit of its elongation.
    inertia : (6 F, 6 F) sparse array
        ``M``: mass divided by the square of a time.
    force : (K, 3) array
        Forces before the step. The normal forces are only a first guess.
    compliance : float
        ``C``, m/N.
    displacement : float or None
        ``s``; None prescribes the load factor.
    load_factor : float
        Prescribed load factor, or a first guess.
    """

    problem: LimitProblem
    gap: Array
    slack: Array
    inertia: sp.csr_array
    force: Array
    compliance: float
    displacement: float | None
    load_factor: float = 0.0


@dataclass(frozen=True, slots=True)
class StepSolution:
    """Solution of a step.

    Attributes
    ----------
    x, tie_force : (K, 3) and (M,) arrays
    u : (6 F,) array
        Displacements.
    load_factor : float
    iterations : int
        Factorisations.
    """

    x: Array
    tie_force: Array
    u: Array
    load_factor: float
    iterations: int


def solve_step(step: StepProblem, motion: Array) -> StepSolution | None:
    """Solve a step.

    The method is the semismooth Newton method of P. Alart, A. Curnier (Comput. Methods Appl. Mech. Eng. 92 (1991)
    353–375). It begins with contacts that are open, stick or slide like in the step before. If it does not converge,
    limits of friction are held fixed: the step is then a second-order cone program, and Newton's method begins again
    from its solution. The limits follow the normal forces of the program.

    Parameters
    ----------
    step
        The step.
    motion : (6 F,) array
        Displacements to begin with.

    Returns
    -------
    StepSolution or None
        None if the method does not converge.
    """
    newton, friction = _Newton(step), step.problem.friction
    u, alpha = newton.predicted(motion)
    if not np.isfinite(alpha):
        u, alpha = motion, step.load_factor
    found, normal = newton.solve(u, alpha), step.force[:, 0]
    for _ in range(ROUNDS):
        if found is not None:
            break
        # Without earlier forces, nothing slides at first.
        limit = friction * normal if normal.any() else np.full(len(normal), np.abs(step.problem.w_D).sum())
        guess = newton.with_fixed_limits(limit, motion)
        if guess is None:
            return None
        u, alpha, normal = guess
        found = newton.solve(u, alpha)
    return found


class _Newton:
    """Newton's method for the displacements and the load factor of a step.

    Trial forces are the forces of contacts and ties without limits; kept forces are within the limits.
    """

    def __init__(self, step: StepProblem) -> None:
        problem = step.problem
        self._step, self._K, self._factorisations = step, problem.n_points, 0
        self._B = sp.csr_array(sp.hstack([problem.A, problem.ties.columns]))
        self._BT = sp.csr_array(self._B.T)
        unit = np.concatenate([np.repeat(problem.force_unit, 3), problem.ties.force_unit])
        self._stiff = 1 / (step.compliance * unit**2)
        self._unmoved = np.concatenate([step.force.ravel(), np.zeros(len(problem.ties))])
        self._unmoved[: 3 * self._K : 3] = -step.gap
        self._unmoved[3 * self._K :] = -step.slack
        #: Forces of one sign: normal forces and ties.
        self._one_sided = np.r_[0 : 3 * self._K : 3, 3 * self._K : len(unit)]
        self._unmoved[self._one_sided] *= self._stiff[self._one_sided]
        place, tie = 3 * np.arange(self._K)[:, None, None], np.arange(3 * self._K, len(unit))
        rows, columns = np.broadcast_arrays(place + np.arange(3)[:, None], place + np.arange(3))
        self._rows, self._columns = (np.concatenate([part.ravel(), tie]) for part in (rows, columns))

    def predicted(self, motion: Array) -> tuple[Array, float]:
        """Return displacements and load factor if contacts stay open, stick or slide as in the step before."""
        step, K = self._step, self._K
        trial, before = self._trial(motion), step.force
        like = trial.copy()
        x = like[: 3 * K].reshape(-1, 3)
        closed = before[:, 0] > 0
        if not closed.any():
            return motion, step.load_factor
        sticks = closed & (np.hypot(before[:, 1], before[:, 2]) < (1 - SLIDES) * step.problem.friction * before[:, 0])
        x[:, 0] = np.where(closed, before[:, 0], np.minimum(x[:, 0], 0.0))
        x[sticks, 1:] = before[sticks, 1:]
        kept, slope = self._limited(like)
        kept += np.bincount(self._rows, slope * (trial - like)[self._columns], len(kept))
        more, rise = self._direction(motion, step.load_factor, kept, slope)
        return motion + more, step.load_factor + rise

    def solve(self, u: Array, alpha: float) -> StepSolution | None:
        """Solve from displacements and a load factor; return None if the method does not converge."""
        kept, slope = self._limited(self._trial(u))
        recent = [np.inf]
        for _ in range(ITERATIONS):
            more, rise = self._direction(u, alpha, kept, slope)
            best = np.inf
            for halving in range(HALVINGS + 1):
                at = u + 0.5**halving * more, alpha + 0.5**halving * rise
                forces, slopes = self._limited(self._trial(at[0]))
                missed = self._missed(*at, forces)
                if (size := float(np.linalg.norm(missed))) < best:
                    best, next_u, next_alpha, kept, slope = size, *at, forces, slopes
                    largest = float(np.abs(missed).max())
                if best < max(recent[-RECENT:]):
                    break
            if not np.isfinite(best):
                return None
            u, alpha = next_u, next_alpha
            recent.append(best)
            if largest <= SOLVED:
                x, T = kept[: 3 * self._K].reshape(-1, 3), kept[3 * self._K :]
                return StepSolution(x, T, u, float(alpha), self._factorisations)
        return None

    def with_fixed_limits(self, limit: Array, motion: Array) -> tuple[Array, float, Array] | None:
        """Return displacements, load factor and normal forces (K,) for given limits (K,) of friction.

        Forces, displacements and load factor minimise ``½ C Σ (x − x_0)² + ½ Δu·M Δu − α s`` in equilibrium,
        ``A x + w_D + α w_L = M Δu``, where ``x_0`` are the trial forces of blocks that do not move. The displacements
        are the multipliers of equilibrium. None if the program is not solved.
        """
        step, K, one_sided, capacity = self._step, self._K, self._one_sided, self._step.problem.ties.capacity
        forces, unknowns, s = len(self._stiff), len(motion), step.displacement
        # Displacements are in a length near their own.
        length = max(float(np.abs(motion).max()), float((1 / self._stiff).max()))
        soft, M = 1 / self._stiff / length, length * step.inertia
        P = sp.block_diag([sp.diags_array(soft), sp.csr_array((1, 1)), M])
        q = np.concatenate([-soft * self._unmoved, [0.0 if s is None else -s / length], np.zeros(unknowns)])
        unit = sp.eye_array(forces + 1 + unknowns, format="csr")
        discs, bounded = unit[: 3 * K].multiply(np.tile([[0.0], [1.0], [1.0]], (K, 1))), np.isfinite(capacity)
        push = sp.csr_array(step.problem.w_L[:, None])
        parts: list[tuple[Any, Any, list[Any]]] = [
            (sp.hstack([-self._B, -push, M]), step.problem.w_D, [clarabel.ZeroConeT(unknowns)]),
            (-unit[one_sided], np.zeros(len(one_sided)), [clarabel.NonnegativeConeT(len(one_sided))]),
            (unit[3 * K : forces][bounded], capacity[bounded], [clarabel.NonnegativeConeT(int(bounded.sum()))]),
            (-discs, np.kron(limit, [1.0, 0.0, 0.0]), [clarabel.SecondOrderConeT(3)] * K),
        ]
        if s is None:
            parts.append((unit[[forces]], np.array([step.load_factor]), [clarabel.ZeroConeT(1)]))
        rows, right, cones = zip(*parts, strict=True)
        settings = clarabel.DefaultSettings()
        settings.verbose, settings.direct_solve_method = False, "qdldl"
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = SOLVED
        G, every = sp.vstack(rows, format="csc"), [cone for group in cones for cone in group]
        solver = clarabel.DefaultSolver(sp.triu(P, format="csc"), q, G, np.concatenate(right), every, settings)
        solution = solver.solve()
        self._factorisations += int(solution.iterations)
        x, u = np.array(solution.x), -length * np.array(solution.z)[:unknowns]
        if not (np.isfinite(x).all() and np.isfinite(u).all()):
            return None
        return u, float(x[forces]), np.maximum(x[: 3 * K : 3], 0.0)

    def _trial(self, u: Array) -> Array:
        """Return the forces of contacts and ties without limits."""
        return np.asarray(self._unmoved - self._stiff * (self._BT @ u))

    def _missed(self, u: Array, alpha: float, kept: Array) -> Array:
        """Return the residual (6 F,) of equilibrium."""
        step = self._step
        return np.asarray(self._B @ kept + step.problem.w_D + alpha * step.problem.w_L - step.inertia @ u)

    def _direction(self, u: Array, alpha: float, kept: Array, slope: Array) -> tuple[Array, float]:
        """Return the changes of displacements and load factor; NaN if the matrix is singular."""
        step, w = self._step, self._step.problem.w_L
        D = sp.csr_array((slope * self._stiff[self._columns], (self._rows, self._columns)), shape=2 * (len(kept),))
        D.eliminate_zeros()
        S = sp.csc_matrix(self._B @ D @ self._BT + step.inertia)
        self._factorisations += 1
        try:
            lu = sp.linalg.splu(S, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options=OPTIONS)
        except RuntimeError:
            return np.full_like(u, np.nan), np.nan
        missed, push = self._missed(u, alpha, kept), lu.solve(w)
        more, rise = np.zeros_like(u), 0.0
        for _ in range(1 + REFINEMENTS):
            more = more + lu.solve(missed + rise * w - S @ more)
            if step.displacement is not None:
                further = float((step.displacement - w @ (u + more)) / (w @ push or np.nan))
                more, rise = more + further * push, rise + further
        return more, rise

    def _limited(self, trial: Array) -> tuple[Array, Array]:
        """Return forces within the limits and the entries of their derivatives."""
        problem, K = self._step.problem, self._K
        kept, slope = limited(trial[: 3 * K].reshape(-1, 3), problem.friction)
        T = trial[3 * K :]
        pulls = np.clip(T, 0.0, problem.ties.capacity)
        return np.concatenate([kept.ravel(), pulls]), np.concatenate([slope.ravel(), (pulls == T).astype(float)])


def limited(x: Array, friction: Array) -> tuple[Array, Array]:
    """Return contact forces (K, 3) moved back to what contacts bear, and the derivatives (K, 3, 3).

    Contacts bear no tension, and friction up to ``μ n``.
    """
    n, size = np.maximum(x[:, 0], 0.0), np.hypot(x[:, 1], x[:, 2])
    most = friction * n
    slides = size > most
    share = np.divide(most, size, out=np.ones(len(n)), where=slides)
    along = x[:, 1:] / np.maximum(size, 1e-300)[:, None]
    slope = np.zeros((len(n), 3, 3))
    slope[:, 0, 0] = n > 0
    slope[:, 1, 1] = slope[:, 2, 2] = share
    slope[:, 1:, 1:] -= np.where(slides, share, 0.0)[:, None, None] * along[:, :, None] * along[:, None]
    slope[:, 1:, 0] = np.where(slides & (n > 0), friction, 0.0)[:, None] * along
    return np.column_stack([n, share[:, None] * x[:, 1:]]), slope
