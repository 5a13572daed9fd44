"""Intersections of many pairs of plane convex polygons."""

from dataclasses import dataclass

import numpy as np

from blockstruct.arrays import Array, Flags, Index


@dataclass(frozen=True, slots=True)
class Clipped:
    """Common areas of P pairs of convex polygons, with at most N corners.

    Attributes
    ----------
    corner : (P, N, 2) array
        Corners in order, counter-clockwise. Entries beyond the count are arbitrary.
    edge : (P, N) array
        Edge that starts at each corner: ``i`` is edge i of the first polygon, ``M + j`` is edge j of the second. M is
        the largest number of corners of a first polygon.
    count : (P,) array
    """

    corner: Array
    edge: Index
    count: Index

    def __getitem__(self, chosen: Flags) -> "Clipped":
        return Clipped(self.corner[chosen], self.edge[chosen], self.count[chosen])

    @property
    def within(self) -> Flags:
        """Whether each corner is within the count, (P, N)."""
        return np.asarray(np.arange(self.corner.shape[1]) < self.count[:, None])

    @property
    def edges(self) -> Array:
        """Vector (P, N, 2) from each corner to the next; zero beyond the count."""
        along = _following(self.corner, self.count) - self.corner
        return np.where(self.within[:, :, None], along, 0.0)

    @property
    def area(self) -> Array:
        """Area (P,)."""
        twice = cross(self.corner, _following(self.corner, self.count))
        return np.asarray(np.where(self.within, twice, 0.0).sum(axis=1) / 2)

    @property
    def arriving(self) -> Index:
        """Edge that ends at each corner, (P, N)."""
        number = np.arange(self.corner.shape[1])
        before = np.where(number > 0, number - 1, np.maximum(self.count[:, None] - 1, 0))
        return np.take_along_axis(self.edge, before, 1)

    def without_short_edges(self, shortest: float) -> "Clipped":
        """Return the areas without corners whose edge is at most ``shortest`` long."""
        keep = self.within & (np.linalg.norm(self.edges, axis=2) > shortest)
        return _packed(self.corner, self.edge, keep)


def clipped(first: Array, n_first: Index, second: Array, n_second: Index, flush: float) -> Clipped:
    """Clip polygons by polygons (I. E. Sutherland, G. W. Hodgman (1974), doi:10.1145/360767.360802).

    A point outside by rounding counts as inside. Otherwise coincident edges, as in the face of a wall, would cross at
    arbitrary points, which differ between the front and the back of the wall.

    Parameters
    ----------
    first, second : (P, M, 2), (P, G, 2) arrays
        Convex polygons, counter-clockwise.
    n_first, n_second : (P,) arrays
        Numbers of corners.
    flush
        Distance outside an edge that counts as rounding.
    """
    M = first.shape[1]
    labels = np.broadcast_to(np.arange(M), first.shape[:2])
    result = Clipped(first, labels, n_first)
    pairs = np.arange(len(first))
    for k in range(second.shape[1]):
        a, b = second[:, k], second[pairs, np.where(k + 1 < n_second, k + 1, 0)]
        # A polygon stops clipping after its last edge.
        idle = (k >= n_second)[:, None]
        height = cross((b - a)[:, None], result.corner - a[:, None])
        outside = -flush * np.linalg.norm(b - a, axis=1, keepdims=True)
        inside, following = (height >= outside) | idle, _following(height, result.count)
        next_inside = (following >= outside) | idle
        span = height - following
        share = np.clip(height / np.where(span == 0, 1.0, span), 0.0, 1.0)
        crossing = result.corner + share[:, :, None] * (_following(result.corner, result.count) - result.corner)
        keep = np.stack([result.within & inside, result.within & (inside != next_inside)], axis=2)
        corner = np.stack([result.corner, crossing], axis=2)
        # An outline that leaves the polygon continues along the clipping edge.
        edge = np.stack([result.edge, np.where(inside, M + k, result.edge)], axis=2)
        shape = (len(first), 2 * result.corner.shape[1])
        result = _packed(corner.reshape(*shape, 2), edge.reshape(shape), keep.reshape(shape))
    return result


def cross(a: Array, b: Array) -> Array:
    """Return the cross product of vectors (…, 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _following(values: Array, count: Index) -> Array:
    """Return the value at the next corner."""
    number = np.arange(values.shape[1])
    after = np.where(number + 1 < count[:, None], number + 1, 0)
    return np.take_along_axis(values, after.reshape(after.shape + (1,) * (values.ndim - 2)), 1)


def _packed(corner: Array, edge: Index, keep: Flags) -> Clipped:
    """Move the corners to keep to the front."""
    count = keep.sum(axis=1)
    order = np.argsort(~keep, axis=1, kind="stable")[:, : max(int(count.max(initial=0)), 1)]
    return Clipped(np.take_along_axis(corner, order[:, :, None], 1), np.take_along_axis(edge, order, 1), count)
