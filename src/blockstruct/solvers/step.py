"""One step of rigid blocks with elastic contacts, friction, ties and inertia."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array
from blockstruct.limit import LimitProblem
from blockstruct.limit.mirror import Mirror
from blockstruct.limit.ties import Ties
from blockstruct.solvers.anderson import accelerate
from blockstruct.solvers.interior_point.schur import OPTIONS
from blockstruct.solvers.splitting import FOLLOWS, LEAST, RELAXED, dot, factorised, norm

#: Most Newton iterations of a step, and halvings of a change.
ITERATIONS, HALVINGS = 25, 8
#: Number of recent steps of a motion whose works and lengths a new one is compared with.
RECENT = 4
#: Refinements of each linear solution. Only inertia resists a mechanism.
REFINEMENTS = 2
#: Largest errors of a solution by splitting: unbalanced wrench, in dead wrenches, and error of relative displacements,
#: relative to themselves, both in units of the problem and as lengths.
UNBALANCED, INCOMPATIBLE = 1e-2, 3e-3
#: Iterations in which the errors must halve while they are too large, and when they are not.
PATIENCE, BRIEF = 150, 100
#: First compliance of the springs of splitting, relative to slip divided by force, and the largest ratio of two
#: successive compliances.
COMPLIANCE, CHANGE = 3.0, 10.0
#: Number of compliances that are tried.
BALANCES = 9


@dataclass(frozen=True, slots=True)
class StepProblem:
    """Equilibrium and contacts at the end of a step.

        ``A x + Σ a_j T_j + w_D + α w_L = M Δu``, and ``w_L·Δu = s`` or α given

    A contact is elastic. Its normal force follows from the overlap at the end of the step, ``n = −(g + Δu_n) / C ≥ 0``.
    A cell that crushes bears at most its strength.
    The friction force changes by the slip of the step, ``−Δu_t / C``, and then moves back to the disc ``μ n``. There is
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
    mirror : Mirror or None
        The problem of half of the structure, if it is its own mirror image. The solution is then symmetrical.
    normal_compliance : (K,) array, optional
        ``C`` of normal forces, m/N.
    """

    problem: LimitProblem
    gap: Array
    slack: Array
    inertia: sp.csr_array
    force: Array
    compliance: float
    displacement: float | None
    load_factor: float = 0.0
    mirror: Mirror | None = None
    normal_compliance: Array | None = None


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
        Iterations of both methods.
    """

    x: Array
    tie_force: Array
    u: Array
    load_factor: float
    iterations: int


def solve_step(step: StepProblem, motion: Array, near: Array | None = None) -> StepSolution | None:
    """Solve a step.

    The method is the semismooth Newton method of P. Alart, A. Curnier (Comput. Methods Appl. Mech. Eng. 92 (1991)
    353–375). It begins with contacts that are open, stick or slide like in the step before. If it does not converge, it
    begins again from a solution by splitting. This solution remains if Newton's method does not converge from there.

    Parameters
    ----------
    step
        The step.
    motion : (6 F,) array
        Displacements with which Newton's method begins.
    near : (6 F,) array, optional
        Displacements of a similar step, with which splitting begins; ``motion`` by default.

    Returns
    -------
    StepSolution or None
        None if neither method converges.
    """
    near = motion if near is None else near
    return _solve(step, motion, near) if step.mirror is None else _solve_half(step, step.mirror, motion, near)


def _solve(step: StepProblem, motion: Array, near: Array) -> StepSolution | None:
    """Solve a step without symmetry."""
    newton = _Newton(step)
    u, alpha = newton.predicted(motion)
    if not np.isfinite(alpha):
        u, alpha = motion, step.load_factor
    found = newton.solve(u, alpha)
    if found is None and (rough := _split(newton, near)) is not None:
        found = newton.solve(rough.u, rough.load_factor) or rough
    return found


def _solve_half(step: StepProblem, mirror: Mirror, motion: Array, near: Array) -> StepSolution | None:
    """Solve a step of a structure that is its own mirror image by solving its half."""
    # Motions of blocks in the plane of symmetry that are not symmetrical have empty columns.
    some = np.flatnonzero(np.diff(mirror.T.tocsc().indptr))
    T = sp.csr_array(mirror.T[:, some])
    size = T.power(2).sum(axis=0)
    _, first, number = np.unique(mirror.point, return_index=True, return_counts=True)
    half = replace(
        mirror.half,
        A=sp.csc_array(sp.csr_array(mirror.half.A)[some]),
        w_D=mirror.half.w_D[some],
        w_L=mirror.half.w_L[some],
        # A point that stands for two is half as compliant.
        force_unit=mirror.half.force_unit / np.sqrt(number),
        ties=Ties.none(len(some)),
    )
    of_half = replace(
        step,
        problem=half,
        gap=step.gap[first] * number,
        inertia=sp.csr_array(T.T @ step.inertia @ T),
        force=step.force[first],
        normal_compliance=None if step.normal_compliance is None else step.normal_compliance[first],
    )
    found = _solve(of_half, (T.T @ motion) / size, (T.T @ near) / size)
    if found is None:
        return None
    return replace(found, x=(mirror.S @ found.x.ravel()).reshape(-1, 3), u=T @ found.u)


def _split(newton: "_Newton", motion: Array) -> StepSolution | None:
    """Solve a step by splitting, like :class:`~blockstruct.solvers.splitting.Splitting`.

    Returns None if the iteration does not converge.
    """
    springs = _Springs(newton, motion)
    for _ in range(BALANCES):
        try:
            springs.balance()
        except RuntimeError:
            # The matrix is singular to rounding: the step is much longer than the blocks.
            return None
        iterations, residual = accelerate(springs, springs.measure, patience=PATIENCE, enough=1, brief=BRIEF)
        newton.iterations += iterations
        if residual <= 1:
            return springs.solution(newton.iterations)
    return None


class _Springs:
    """Iteration of a step between blocks with a spring at each contact and tie, and their forces.

    Each iteration first moves the blocks, and then finds the force of each contact and tie separately. The trial force
    of a spring is its force before the contact or the tie gives way. The limits of friction follow the normal forces,
    smoothed. The point consists of trial forces and limits. :meth:`balance` comes before the first iteration.

    Attributes
    ----------
    measure : (4 K + M,) array
        Weights of a change of the point in its norm.
    """

    def __init__(self, newton: "_Newton", motion: Array) -> None:
        step, problem = newton.step, newton.step.problem
        self._step, self._B, self._BT, self._points = step, newton.B, newton.BT, 3 * problem.n_points
        self._friction, self._w_D, self._w_L = problem.friction, problem.w_D, problem.w_L
        self._strength = problem.compression
        self._elastic, self._unmoved = newton.stiffness, newton.unmoved
        self._unit = 1 / np.sqrt(step.compliance * newton.stiffness)
        # Friction has the compliance of all contacts, normal forces may have another one.
        self._unit[: self._points : 3] = self._unit[1 : self._points : 3]
        self._force = np.concatenate([step.force.ravel(), np.zeros(len(problem.ties))])
        self._moved = newton.BT @ motion
        self._limit = self._friction * np.maximum(step.force[:, 0], 0.0)
        self._compliance, self._errors = COMPLIANCE, (1.0, 1.0)

    def balance(self) -> None:
        """Adapt the springs to the present forces, motion and errors.

        Stiffer springs reduce the error of the motion, and softer springs that of the forces.
        """
        unbalanced, incompatible = self._errors
        self._compliance *= float(np.clip(unbalanced / max(incompatible, 1e-300), 1 / CHANGE, CHANGE))
        points, force, moved = self._points, self._force, self._moved
        normal = np.maximum(force[:points:3], 0.0)
        mean = float(normal.sum()) / max(len(normal), 1) or 1.0
        size = np.concatenate([np.maximum(normal, LEAST * mean), np.full(len(force) - points, mean)])
        slip = np.concatenate([np.linalg.norm(moved[:points].reshape(-1, 3), axis=1), np.abs(moved[points:])])
        slip = np.maximum(slip, np.sqrt((moved**2).mean()) + mean * (1 / self._elastic).mean())
        rho = size / (self._compliance * slip)
        self._stiffness = rho = np.concatenate([np.repeat(rho[: points // 3], 3), rho[points // 3 :]])
        share = rho / (rho + self._elastic)
        self._fixed, self._share = share * self._unmoved, 1 - share
        self._solve = factorised(sp.coo_array(self._B @ sp.diags_array(rho) @ self._BT + self._step.inertia))
        self._push = self._solve(self._w_L)
        self._resists = dot(self._w_L, self._push)
        self.measure = 1 / np.sqrt(np.concatenate([rho, rho[:points:3]]))
        self.move(np.concatenate([force - rho * moved, self._limit]))

    @property
    def point(self) -> Array:
        return np.concatenate([self._trial, self._limit])

    def move(self, point: Array) -> None:
        size = len(self._stiffness)
        self._trial, self._limit = point[:size], np.maximum(point[size:], 0.0)
        self._force = self._within(self._limit)

    def advance(self) -> None:
        s = self._step.displacement
        b = self._w_D + self._B @ (2 * self._force - self._trial)
        self._alpha = self._step.load_factor if s is None else (s - dot(self._push, b)) / self._resists
        self._u = self._solve(b + self._alpha * self._w_L)
        self._moved = self._BT @ self._u
        self._missed = self._force - self._trial - self._stiffness * self._moved
        self._trial = self._trial + RELAXED * self._missed
        self._limit = self._limit + FOLLOWS * (self._friction * self._normal() - self._limit)
        self._force = self._within(self._limit)

    def residual(self) -> float:
        w = self._w_D + self._alpha * self._w_L - self._step.inertia @ self._u
        unbalanced = float(np.abs(self._B @ self._within_friction() + w).max())
        missed, moved = self._missed / self._stiffness, self._moved
        # Units follow the weights of blocks: without lengths, contacts of small blocks would hardly count.
        in_units, in_lengths = (norm(missed / k) / max(norm(moved / k), 1e-300) for k in (1.0, self._unit))
        incompatible = max(in_units, in_lengths)
        self._errors = unbalanced / UNBALANCED, incompatible / INCOMPATIBLE
        return max(self._errors)

    def solution(self, iterations: int) -> StepSolution:
        """Return the solution after the last iteration."""
        force, K = self._within_friction(), self._points
        return StepSolution(force[:K].reshape(-1, 3), force[K:], self._u, float(self._alpha), iterations)

    def _normal(self) -> Array:
        """Return normal forces (K,) for the trial forces."""
        own = slice(0, self._points, 3)
        return np.asarray(np.clip(self._fixed[own] + self._share[own] * self._trial[own], 0.0, self._strength))

    def _within_friction(self) -> Array:
        """Return forces within the friction of their own normal forces."""
        return self._within(self._friction * self._normal())

    def _within(self, limit: Array) -> Array:
        """Return forces for the trial forces and limits (K,) of friction."""
        force: Array = self._fixed + self._share * self._trial
        x = force[: self._points].reshape(-1, 3)
        np.clip(x[:, 0], 0.0, self._strength, out=x[:, 0])
        size = np.maximum(np.hypot(x[:, 1], x[:, 2]), 1e-300)
        x[:, 1:] *= np.minimum(limit / size, 1.0)[:, None]
        np.clip(force[self._points :], 0.0, self._step.problem.ties.capacity, out=force[self._points :])
        return force


def unmoved(step: StepProblem) -> tuple[Array, Array]:
    """Return the forces (3 K + M,) of contacts and ties that stay where they are, and their stiffness.

    There is no limit to these forces.
    """
    problem, K = step.problem, 3 * step.problem.n_points
    unit = np.concatenate([np.repeat(problem.force_unit, 3), problem.ties.force_unit])
    stiffness = 1 / (step.compliance * unit**2)
    if step.normal_compliance is not None:
        stiffness[:K:3] = 1 / (step.normal_compliance * problem.force_unit**2)
    force = np.concatenate([step.force.ravel(), -stiffness[K:] * step.slack])
    force[:K:3] = -stiffness[:K:3] * step.gap
    return force, stiffness


class _State(NamedTuple):
    """Displacements and a load factor, the forces within their limits and the entries of their derivatives.

    ``worst`` is the largest error of equilibrium.
    """

    u: Array
    alpha: float
    kept: Array
    slope: Array
    worst: float


class _Newton:
    """Newton's method for the displacements and the load factor of a step.

    Trial forces are the forces of contacts and ties without limits; kept forces are within the limits.

    Attributes
    ----------
    B, BT : (6 F, 3 K + M) and (3 K + M, 6 F) sparse arrays
        Wrenches of the forces of contacts and ties; their relative displacements.
    unmoved, stiffness : (3 K + M,) arrays
        As in :func:`unmoved`.
    iterations : int
        Of all methods so far.
    """

    def __init__(self, step: StepProblem) -> None:
        problem = step.problem
        self.step, self._K, self.iterations = step, problem.n_points, 0
        self.B = sp.csr_array(sp.hstack([problem.A, problem.ties.columns]))
        self.BT = sp.csr_array(self.B.T)
        self.unmoved, self.stiffness = unmoved(step)
        place, tie = 3 * np.arange(self._K)[:, None, None], np.arange(3 * self._K, len(self.stiffness))
        rows, columns = np.broadcast_arrays(place + np.arange(3)[:, None], place + np.arange(3))
        self._rows, self._columns = (np.concatenate([part.ravel(), tie]) for part in (rows, columns))

    def predicted(self, motion: Array) -> tuple[Array, float]:
        """Return displacements and load factor if contacts stay open, stick or slide as in the step before."""
        step, K = self.step, self._K
        trial, before = self._trial(motion), step.force
        like = trial.copy()
        x = like[: 3 * K].reshape(-1, 3)
        closed = before[:, 0] > 0
        if not closed.any():
            return motion, step.load_factor
        limit = (1 - NEGLIGIBLE) * step.problem.friction * before[:, 0]
        sticks = closed & (np.hypot(before[:, 1], before[:, 2]) < limit)
        x[:, 0] = np.where(closed, before[:, 0], np.minimum(x[:, 0], 0.0))
        x[sticks, 1:] = before[sticks, 1:]
        kept, slope = self._limited(like)
        kept += np.bincount(self._rows, slope * (trial - like)[self._columns], len(kept))
        more, rise = self._direction(motion, step.load_factor, kept, slope)
        return motion + more, step.load_factor + rise

    def solve(self, u: Array, alpha: float) -> StepSolution | None:
        """Solve from displacements and a load factor; return None if the method does not converge."""
        trial = self._at(u, alpha)
        for _ in range(ITERATIONS):
            before, trial = trial.worst, least_missed(self._along(trial), trial.worst)
            if trial.worst <= ROUNDING:
                x, T = trial.kept[: 3 * self._K].reshape(-1, 3), trial.kept[3 * self._K :]
                return StepSolution(x, T, trial.u, float(trial.alpha), self.iterations)
            if not trial.worst < before:
                return None
        return None

    def _along(self, trial: "_State") -> Callable[[float], "_State"]:
        """Return trials by the share of a Newton change."""
        more, rise = self._direction(trial.u, trial.alpha, trial.kept, trial.slope)
        return lambda share: self._at(trial.u + share * more, trial.alpha + share * rise)

    def _at(self, u: Array, alpha: float) -> "_State":
        kept, slope = self._limited(self._trial(u))
        return _State(u, alpha, kept, slope, float(np.abs(self._missed(u, alpha, kept)).max()))

    def _trial(self, u: Array) -> Array:
        """Return the forces of contacts and ties without limits."""
        return np.asarray(self.unmoved - self.stiffness * (self.BT @ u))

    def _missed(self, u: Array, alpha: float, kept: Array) -> Array:
        """Return the residual (6 F,) of equilibrium."""
        step = self.step
        return np.asarray(self.B @ kept + step.problem.w_D + alpha * step.problem.w_L - step.inertia @ u)

    def _direction(self, u: Array, alpha: float, kept: Array, slope: Array) -> tuple[Array, float]:
        """Return the changes of displacements and load factor; NaN if the matrix is singular."""
        step, w = self.step, self.step.problem.w_L
        D = sp.csr_array((slope * self.stiffness[self._columns], (self._rows, self._columns)), shape=2 * (len(kept),))
        D.eliminate_zeros()
        S = sp.csc_matrix(self.B @ D @ self.BT + step.inertia)
        self.iterations += 1
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
        problem, K = self.step.problem, self._K
        kept, slope = limited(trial[: 3 * K].reshape(-1, 3), problem.friction, problem.compression)
        T = trial[3 * K :]
        pulls = np.clip(T, 0.0, problem.ties.capacity)
        return np.concatenate([kept.ravel(), pulls]), np.concatenate([slope.ravel(), (pulls == T).astype(float)])


class Trial(Protocol):
    """A trial of Newton's method, and its largest error."""

    @property
    def worst(self) -> float:
        """Largest error."""


_AnyTrial = TypeVar("_AnyTrial", bound=Trial)


def least_missed(at: Callable[[float], _AnyTrial], enough: float) -> _AnyTrial:
    """Return the trial with the share of a change that misses least.

    Shares are halved until a trial misses less than half of ``enough``, or less than ``enough`` and more than the one
    before.

    Parameters
    ----------
    at
        Returns the trial with a share of the change.
    enough
        Error of the trial without the change.
    """
    best = at(1.0)
    for halving in range(1, HALVINGS + 1):
        if best.worst < enough / 2:
            break
        changed = at(0.5**halving)
        if changed.worst < best.worst:
            best = changed
        elif best.worst < enough:
            break
    return best


def limited(free: Array, friction: Array, strength: Array | float, limit: Array | None = None) -> tuple[Array, Array]:
    """Return contact forces (K, 3) within limits of tension, crushing and friction, and their derivatives (K, 3, 3).

    Parameters
    ----------
    free : (K, 3) array
        Forces without limits.
    friction : (K,) array
        Largest friction, relative to the normal force.
    strength : (K,) array
        Largest normal force.
    limit : (K,) array, optional
        Largest friction, if it does not follow the normal force.
    """
    n = np.minimum(np.maximum(free[:, 0], 0.0), strength)
    size = np.maximum(np.hypot(free[:, 1], free[:, 2]), 1e-300)
    limit, rate = (friction * n, friction) if limit is None else (limit, np.zeros_like(n))
    presses = (n > 0) & (free[:, 0] < strength)
    slides = size > np.maximum(limit, 1e-300)
    share = np.where(slides, limit, 1.0) / np.where(slides, size, 1.0)
    along = free[:, 1:] / size[:, None]
    slope = np.zeros((len(n), 3, 3))
    slope[:, 0, 0] = presses
    slope[:, 1, 1] = slope[:, 2, 2] = share
    slope[:, 1:, 1:] -= (slides * share)[:, None, None] * along[:, :, None] * along[:, None]
    slope[:, 1:, 0] = ((slides & presses) * rate)[:, None] * along
    return np.column_stack([n, share[:, None] * free[:, 1:]]), slope
