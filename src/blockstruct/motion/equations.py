"""Solve the equations of a step of blocks in motion."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import NEGLIGIBLE, Array, Index
from blockstruct.solvers.interior_point.schur import OPTIONS
from blockstruct.solvers.step import HALVINGS, least_missed, limited

#: Newton iterations of a step.
ITERATIONS = 200
#: Iterations in which the limits of friction do not follow the normal forces.
HELD = 2
#: Number of unknowns up to which a dense matrix is faster than a sparse one.
DENSE = 60


class Trial(NamedTuple):
    """Velocities in the solution of a step.

    Attributes
    ----------
    V, v : (F, 6) and (K, 3) arrays
        Velocities and relative velocities.
    x, slope : (K, 3) and (K, 3, 3) arrays
        Forces within their limits, and their derivatives to the forces without limits.
    missed : (F, 6) array
        Unbalanced wrenches.
    worst : float
        Largest unbalanced wrench, in its unit.
    iterations : int
        Linear systems so far.
    """

    V: Array
    v: Array
    x: Array
    slope: Array
    missed: Array
    worst: float
    iterations: int


class System:
    """Unknowns of free blocks, and the contacts that connect two free blocks, or a free block and a support.

    Parameters
    ----------
    ends : (2, K) array
        Places of the blocks of each contact among the free ones: minus and plus; −1 for a support.
    F
        Number of free blocks.
    """

    def __init__(self, ends: Index, F: int) -> None:
        K, held = ends.shape[1], ends < 0
        # A support has the unknowns of the other block, without an effect.
        ends = np.where(held, ends[::-1], ends).T
        self._sign = (np.array([-1.0, 1.0]) * ~held.T).repeat(6, axis=1)[:, None]
        self._unknown = (6 * ends[:, :, None] + np.arange(6)).reshape(K, 12)
        self._size, self._dense = 6 * F, 6 * F <= DENSE
        rows, columns = np.broadcast_arrays(ends[:, :, None], ends[:, None])
        place = np.arange(F) if self._dense else _order(rows.ravel(), columns.ravel(), F)
        self._place, self._order = place, np.argsort(place)
        code = np.concatenate([(place[columns] * F + place[rows]).ravel(), place * (F + 1)])
        blocks, number = np.unique(np.append(code, np.arange(F**2) if self._dense else []), return_inverse=True)
        # Blocks are in the order of columns, and so are the entries of the matrix.
        column, row = (part.astype(np.int64) for part in np.divmod(blocks, F))
        first = np.searchsorted(column, np.arange(F + 1))
        height, i = 6 * np.diff(first), np.arange(6)[:, None]
        start = 30 * first[column] + 6 * np.arange(len(blocks))
        entries = start[:, None, None] + height[column, None, None] * i.T + i
        self._of_contacts = entries[number[: 4 * K].reshape(K, 2, 2)].transpose(0, 1, 3, 2, 4).ravel()
        self._of_blocks = entries[number[4 * K : 4 * K + F]].ravel()
        self._rows = np.empty(entries.size, dtype=np.int32)
        self._rows[entries] = 6 * row[:, None, None] + i
        self._starts = np.append(0, np.repeat(height, 6).cumsum()).astype(np.int32)

    def parts(self, frame: Array, turning: Array) -> Array:
        """Return the derivatives (K, 3, 12) of relative velocities to the velocities of the minus and the plus block.

        ``turning`` (2, K, 3, 3) are the derivatives to the angular velocities, without the sign.
        """
        return np.asarray(np.concatenate([frame, turning[0], frame, turning[1]], axis=2) * self._sign)

    def relative(self, parts: Array, V: Array) -> Array:
        """Return the relative velocities (K, 3), plus block minus minus block, for velocities (F, 6)."""
        return turned(parts, V.ravel()[self._unknown])

    def wrench(self, parts: Array, x: Array) -> Array:
        """Return the wrenches (F, 6) of contact forces (K, 3)."""
        onto = (x[:, None] @ parts).ravel()
        return np.asarray(np.bincount(self._unknown.ravel(), onto, self._size).reshape(-1, 6), dtype=np.float64)

    def solved(self, parts: Array, M: Array, weights: Array, b: Array) -> Array:
        """Return the solution (F, 6) of ``M + Jᵀ D J`` with the weights D (K, 3, 3) and the right-hand side (F, 6)."""
        stiffness = parts.transpose(0, 2, 1) @ (weights @ parts)
        # Without contacts, numpy counts in integers.
        data = np.asarray(np.bincount(self._of_contacts, stiffness.ravel(), len(self._rows)), dtype=np.float64)
        data[self._of_blocks] += M.ravel()
        if self._dense:
            return np.asarray(np.linalg.solve(data.reshape(self._size, -1).T, b.ravel()).reshape(-1, 6))
        S = sp.csc_matrix((data, self._rows, self._starts), shape=(self._size, self._size))
        lu = sp.linalg.splu(S, permc_spec="NATURAL", diag_pivot_thresh=0, options=OPTIONS)
        return np.asarray(lu.solve(b[self._order].ravel()).reshape(-1, 6)[self._place])


def _order(rows: Index, columns: Index, F: int) -> Index:
    """Return the places (F,) of blocks in an order that keeps factors of the matrix sparse."""
    pattern = sp.csc_matrix((np.ones(len(rows)), (rows, columns)), shape=(F, F))
    dominant = pattern + sp.diags_array(1 + np.ravel(pattern.sum(axis=0))).tocsc()
    return np.asarray(sp.linalg.splu(sp.csc_matrix(dominant), permc_spec="MMD_AT_PLUS_A", options=OPTIONS).perm_c)


@dataclass(frozen=True, slots=True)
class Equations:
    """Equations of motion of a step.

    Attributes
    ----------
    system : System
    parts : (K, 3, 12) array
        As in :meth:`System.parts`.
    M : (F, 6, 6) array
        Mass matrices by the time of the impulse.
    push : (F, 6) array, N and N·m
        Momentum before by the time of the impulse, and loads.
    unit : (F, 6) array, N and N·m
        Unit of unbalanced wrenches.
    resting, damping : (K, 3) and (K, 1) arrays, N and N·s/m
        Forces of contacts without limits are ``resting − damping v`` at relative velocities v.
    friction : (K,) array
    strength : (K,) or () array, N
        Largest normal forces.
    """

    system: System
    parts: Array
    M: Array
    push: Array
    unit: Array
    resting: Array
    damping: Array
    friction: Array
    strength: Array

    def solved(self, V: Array, v: Array, guess: Array) -> Trial | None:
        """Return the solution; None if it is not found.

        Parameters
        ----------
        V, v : (F, 6) and (K, 3) arrays
            First velocities and relative velocities.
        guess : (K, 3) array, N
            Forces without limits, by which contacts are open, stick or slide at first.
        """
        x, slope = limited(guess, self.friction, self.strength)
        x = x + turned(slope, self.resting - self.damping * v - guess)
        first = Trial(V, v, x, slope, self._missed(V, x), np.inf, 0)
        try:
            return self._newton(first) or self._with_growing_friction(V, v)
        except RuntimeError:
            return None

    def continued(self, trial: Trial) -> Trial | None:
        """Return the solution by Newton's method from that of similar equations; None if it does not converge."""
        try:
            return self._newton(self._at(trial.V, trial.v, trial.iterations))
        except RuntimeError:
            return None

    def _with_growing_friction(self, V: Array, v: Array) -> Trial | None:
        """Return the solution by friction that grows from zero; None if it is not found.

        Without friction, the problem is convex.
        """
        share, more, found = 0.0, 1.0, self._at_friction(0.0, V, v, 0)
        while found is not None and share < 1 and more > 0.5**HALVINGS:
            grown = min(share + more, 1.0)
            further = self._at_friction(grown, found.V, found.v, found.iterations)
            if further is None:
                more /= 2
            else:
                share, more, found = grown, 2 * more, further
        return found if share == 1 else None

    def _at_friction(self, share: float, V: Array, v: Array, iterations: int) -> Trial | None:
        """Return the solution with a share of the friction, from velocities; None if it is not found."""
        other = replace(self, friction=share * self.friction)
        return other._newton(other._at(V, v, iterations))

    def _newton(self, trial: Trial) -> Trial | None:
        """Return the solution by Newton's method from a trial; None if it does not converge."""
        least, last = np.inf, trial.iterations + ITERATIONS
        while not trial.worst <= NEGLIGIBLE:
            if trial.iterations > last:
                return None
            changed = self._changed(trial, least)
            if not changed.worst < least:
                limit = self.friction * trial.x[:, 0]
                changed = self._at(trial.V, trial.v, trial.iterations + 1, limit)
                for _ in range(HELD):
                    changed = self._changed(changed, changed.worst, limit)
                changed = self._at(changed.V, changed.v, changed.iterations)
            trial, least = changed, min(least, changed.worst)
        return trial

    def _changed(self, trial: Trial, enough: float, limit: Array | None = None) -> Trial:
        """Return the next trial by Newton's method; one that misses less than ``enough`` is sufficient."""
        change = self.system.solved(self.parts, self.M, trial.slope * self.damping[:, None], trial.missed)
        relative, count = self.system.relative(self.parts, change), trial.iterations + 1

        def along(share: float) -> Trial:
            return self._at(trial.V + share * change, trial.v + share * relative, count, limit)

        return least_missed(along, enough)

    def _at(self, V: Array, v: Array, iterations: int, limit: Array | None = None) -> Trial:
        """Return the trial at given velocities, with the given limits of friction (K,) if they wait."""
        free = self.resting - self.damping * v
        x, slope = limited(free, self.friction, self.strength, limit)
        missed = self._missed(V, x)
        return Trial(V, v, x, slope, missed, float(np.abs(missed / self.unit).max()), iterations)

    def _missed(self, V: Array, x: Array) -> Array:
        return np.asarray(self.push + self.system.wrench(self.parts, x) - turned(self.M, V))


def turned(matrices: Array, vectors: Array) -> Array:
    """Return the products (…, r) of matrices (…, r, c) and vectors (…, c)."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])
