"""Accelerate a fixed-point iteration by Anderson's method."""

from itertools import count
from typing import Protocol

import numpy as np

from blockstruct.arrays import Array

#: Iterations between two accelerations; changes in the memory.
LOOK, MEMORY = 5, 20
#: Relative addition to the diagonal of the normal equations; growth of a change above which the memory is discarded.
REGULARISATION, GROWN = 1e-10, 2.0


class Anderson:
    """Predict the point at which an iteration changes least.

    The prediction follows the last changes. D. G. Anderson, J. ACM 12 (1965) 547–560, doi:10.1145/321296.321305; here
    the second type, H. Fang, Y. Saad, Numer. Linear Algebra Appl. 16 (2009) 197–221, doi:10.1002/nla.617.

    Parameters
    ----------
    weight : (N,) array
        Weight of each number in the norm of a change.
    memory
        Number of changes in memory.
    """

    def __init__(self, weight: Array, memory: int) -> None:
        self._weight, self._memory = weight, memory
        self._points, self._changes = (np.empty((memory, len(weight))) for _ in range(2))
        self._products = np.empty((memory, memory))
        self._known, self._newest = 0, 0
        self._last: tuple[Array, Array, float] | None = None

    def point(self, before: Array, after: Array) -> Array:
        """Return the next point of the iteration.

        The iteration has taken the point ``before`` (N,) to ``after`` (N,).
        """
        change = self._weight * (after - before)
        size = float(np.einsum("i,i->", change, change))
        last, self._last = self._last, (after.copy(), change, size)
        if last is None or size > GROWN**2 * last[2]:
            self._known = 0
            return after
        self._newest = self._newest + 1 if self._known else 0
        place = self._newest % self._memory
        self._known = min(self._known + 1, self._memory)
        np.subtract(after, last[0], out=self._points[place])
        np.subtract(change, last[1], out=self._changes[place])
        known = self._changes[: self._known]
        self._products[place, : self._known] = self._products[: self._known, place] = np.einsum(
            "ij,j->i", known, self._changes[place]
        )
        matrix = self._products[: self._known, : self._known].copy()
        matrix.flat[:: self._known + 1] += REGULARISATION * np.trace(matrix) + np.finfo(float).tiny
        share = np.linalg.solve(matrix, np.einsum("ij,j->i", known, change))
        return np.asarray(after - np.einsum("i,ij->j", share, self._points[: self._known]))


class Iteration(Protocol):
    """Fixed-point iteration of a point (N,)."""

    @property
    def point(self) -> Array:
        """The point."""

    def move(self, point: Array) -> None:
        """Continue from another point."""

    def advance(self) -> None:
        """Make one iteration."""

    def residual(self) -> float:
        """Return the error of the last iteration."""


def accelerate(
    iteration: Iteration, weight: Array, *, patience: int, tolerance: float = 0.0, enough: float = 0.0, brief: int = 0
) -> tuple[int, float]:
    """Iterate until the residual is below the tolerance, or no longer falls.

    Every ``LOOK`` iterations the residual is computed, and Anderson's method predicts the next point.

    Parameters
    ----------
    iteration
        The iteration, at its beginning.
    weight : (N,) array
        As for :class:`Anderson`.
    tolerance
        Residual at which to end.
    patience
        Number of iterations in which the residual must halve.
    enough, brief
        Residual below which the number of iterations is ``brief`` instead.

    Returns
    -------
    int, float
        Number of iterations and last residual.
    """
    memory = Anderson(weight, MEMORY)
    begun, least, reached = iteration.point, np.inf, 0
    for k in count(1):
        iteration.advance()
        if k % LOOK:
            continue
        residual = iteration.residual()
        if 2 * residual <= least:
            least, reached = residual, k
        if not residual > tolerance or k >= reached + (patience if residual > enough else brief):
            break
        begun = memory.point(begun, iteration.point)
        iteration.move(begun)
    return k, residual
