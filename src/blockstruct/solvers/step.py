"""One step of rigid blocks with elastic contacts, friction, ties and inertia."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit import LimitProblem
from blockstruct.solvers.interior_point.schur import OPTIONS

Array = NDArray[np.float64]

#: Residual of equilibrium, in dead wrenches, of a solution, and with fixed limits of friction.
SOLVED, BALANCED = 1e-9, 1e-7
#: Share of its limit from which friction slid in the step before.
SLIDES = 1e-6
#: Most Newton iterations with friction that follows normal forces, and with fixed limits; how often these follow.
ITERATIONS, LIMITED, ROUNDS = 8, 150, 30
#: Earlier residuals of which the largest must not be exceeded, and halvings of a step to get there.
RECENT, HALVINGS = 4, 4
#: Stiffness of contacts that are open or slide, relative to closed ones, at the start with fixed limits; factor by
#: which it changes after long and short steps; and value below which it is zero.
RESISTS, CHANGE, NONE = 1e-2, 10.0, 1e-8
#: Shares of a direction that are long and short.
LONG, SHORT = 0.5, 0.1
#: Slope that ends the search along a direction, relative to its start; most divisions, and their least part.
FLAT, DIVISIONS, INSIDE = 0.1, 30, 0.05
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
    limits of friction are held fixed: displacements then minimise a convex function. The limits follow the normal
    forces, and Newton's method begins again.

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
    # Without earlier forces, nothing slides at first.
    normal = step.force[:, 0]
    limit = friction * np.maximum(normal, 0.0) if normal.any() else np.full(len(normal), np.inf)
    found = newton.solve(u, alpha)
    for _ in range(ROUNDS):
        if found is not None:
            break
        least = newton.minimised(u, alpha, limit)
        if least is None:
            return None
        u, alpha, kept = least
        found, limit = newton.solve(u, alpha), friction * kept[: 3 * len(limit) : 3]
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
        positions = np.r_[0 : 3 * self._K : 3, 3 * self._K : len(unit)]
        self._unmoved[positions] *= self._stiff[positions]
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
        kept, slope = self._limited(like, None)
        kept += np.bincount(self._rows, slope * (trial - like)[self._columns], len(kept))
        more, rise = self._direction(motion, step.load_factor, kept, slope)
        return motion + more, step.load_factor + rise

    def solve(self, u: Array, alpha: float) -> StepSolution | None:
        """Solve from displacements and a load factor; return None if the method does not converge."""
        kept, slope = self._limited(self._trial(u), None)
        recent = [np.inf]
        for _ in range(ITERATIONS):
            more, rise = self._direction(u, alpha, kept, slope)
            best = np.inf
            for halving in range(HALVINGS + 1):
                at = u + 0.5**halving * more, alpha + 0.5**halving * rise
                forces, slopes = self._limited(self._trial(at[0]), None)
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

    def minimised(self, u: Array, alpha: float, limit: Array) -> tuple[Array, float, Array] | None:
        """Return displacements, load factor and forces for fixed limits (K,) of friction; None if none are found.

        Each step goes along its direction to where the function that the displacements minimise is nearly least.
        """
        resists = RESISTS
        kept, slope = self._limited(self._trial(u), limit)
        for _ in range(LIMITED):
            more, rise = self._direction(u, alpha, kept, slope, resists)
            alpha += rise
            if not np.isfinite(alpha):
                return None
            share = self._share(u, more, alpha, limit)
            u = u + share * more
            if share > LONG:
                resists = resists / CHANGE if resists > NONE else 0.0
            elif share < SHORT:
                resists = CHANGE * max(resists, NONE)
            kept, slope = self._limited(self._trial(u), limit)
            if np.abs(self._missed(u, alpha, kept)).max() <= BALANCED:
                return u, alpha, kept
        return None

    def _share(self, u: Array, more: Array, alpha: float, limit: Array) -> float:
        """Return the share of a direction at which the minimised function is nearly least; at most one."""

        def slope(share: float) -> float:
            at = u + share * more
            return -float(self._missed(at, alpha, self._limited(self._trial(at), limit)[0]) @ more)

        low, high, at_low, at_high = 0.0, 1.0, slope(0.0), slope(1.0)
        flat, share = FLAT * abs(at_low), 1.0
        if at_high <= flat:
            return share
        for _ in range(DIVISIONS):
            part = min(max(at_low / (at_low - at_high), INSIDE), 1 - INSIDE)
            share = low + part * (high - low)
            at_share = slope(share)
            if abs(at_share) <= flat:
                break
            if at_share > 0:
                high, at_high = share, at_share
            else:
                low, at_low = share, at_share
        return share

    def _trial(self, u: Array) -> Array:
        """Return the forces of contacts and ties without limits."""
        return np.asarray(self._unmoved - self._stiff * (self._BT @ u))

    def _missed(self, u: Array, alpha: float, kept: Array) -> Array:
        """Return the residual (6 F,) of equilibrium."""
        step = self._step
        return np.asarray(self._B @ kept + step.problem.w_D + alpha * step.problem.w_L - step.inertia @ u)

    def _direction(
        self, u: Array, alpha: float, kept: Array, slope: Array, resists: float = 0.0
    ) -> tuple[Array, float]:
        """Return the changes of displacements and load factor; NaN if the matrix is singular."""
        step, w = self._step, self._step.problem.w_L
        stiffness = (slope + resists * (self._rows == self._columns)) * self._stiff[self._columns]
        D = sp.csr_array((stiffness, (self._rows, self._columns)), shape=2 * (len(kept),))
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

    def _limited(self, trial: Array, limit: Array | None) -> tuple[Array, Array]:
        """Return forces within the limits and the entries of their derivatives.

        The limit of friction is ``μ n`` if none is given.
        """
        problem, K = self._step.problem, self._K
        kept, slope = limited(trial[: 3 * K].reshape(-1, 3), problem.friction, limit)
        T = trial[3 * K :]
        pulls = np.clip(T, 0.0, problem.ties.capacity)
        return np.concatenate([kept.ravel(), pulls]), np.concatenate([slope.ravel(), (pulls == T).astype(float)])


def limited(x: Array, friction: Array, limit: Array | None = None) -> tuple[Array, Array]:
    """Return contact forces (K, 3) moved back to what contacts bear, and the derivatives (K, 3, 3).

    Contacts bear no tension, and friction up to the limit (K,), which is ``μ n`` if none is given.
    """
    n, size = np.maximum(x[:, 0], 0.0), np.hypot(x[:, 1], x[:, 2])
    most = friction * n if limit is None else limit
    slides = size > most
    share = np.divide(most, size, out=np.ones(len(n)), where=slides)
    along = x[:, 1:] / np.maximum(size, 1e-300)[:, None]
    slope = np.zeros((len(n), 3, 3))
    slope[:, 0, 0] = n > 0
    slope[:, 1, 1] = slope[:, 2, 2] = share
    slope[:, 1:, 1:] -= np.where(slides, share, 0.0)[:, None, None] * along[:, :, None] * along[:, None]
    if limit is None:
        slope[:, 1:, 0] = np.where(slides & (n > 0), friction, 0.0)[:, None] * along
    return np.column_stack([n, share[:, None] * x[:, 1:]]), slope
