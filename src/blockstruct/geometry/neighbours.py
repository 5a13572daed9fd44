"""Neighbours among many boxes and bodies, and their distances."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import shapely
from scipy.sparse import coo_array

from blockstruct.arrays import CHUNK, Array, Flags, Index
from blockstruct.geometry.polyhedron import Polyhedron

#: Unit vector that is not along the faces of usual structures: half of all faces look along it.
OBLIQUE = np.array([0.36, 0.48, 0.8])


def connected(pairs: Index, n: int) -> Index:
    """Return the number (n,) of the connected part of each of n nodes, which pairs (m, 2) join."""
    from scipy.sparse.csgraph import connected_components

    pairs = pairs.reshape(-1, 2)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1] if n else np.empty(0), dtype=np.int64)


def unsupported(held: Flags, ends: Index) -> Index:
    """Return which of n bodies have no path over touching pairs (m, 2) to a held body (n,)."""
    label = connected(ends, len(held))
    return np.flatnonzero(~np.isin(label, label[held]))


def box_pairs(low: Array, high: Array) -> tuple[Index, Index]:
    """Return the index pairs (i, j), i < j, of axis-parallel boxes that meet.

    Parameters
    ----------
    low, high : (n, 3) arrays
        Smallest and largest corners. A box with ``low > high`` along an axis meets no other box.
    """
    i, j = _boxes_that_meet(low, high, np.zeros(len(low)), 0.0)
    order = np.lexsort((j, i))
    return i[order], j[order]


def facing_pairs(low: Array, high: Array, normals: Array, angle: float) -> tuple[Index, Index]:
    """Return the index pairs of faces whose boxes meet, except most of those that do not look at each other.

    Parameters
    ----------
    low, high : (n, 3) arrays
        Smallest and largest corners of the boxes.
    normals : (n, 3) array
        Unit normals.
    angle
        Largest angle between two faces that look at each other, radians.
    """
    return _boxes_that_meet(low, high, normals @ OBLIQUE, angle)


def _boxes_that_meet(low: Array, high: Array, ahead: Array, within: float) -> tuple[Index, Index]:
    """Return the index pairs (i, j) of boxes that meet, with values ``ahead`` of about opposite sign.

    The search tree covers the two longest axes of the structure. Along the third axis the structure is cut into slabs,
    which are next to each other in the tree, so that solid structures cost no more than walls.
    """
    real = np.flatnonzero(np.all(low <= high, axis=1))
    if len(real) < 2:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    low, high, ahead = low[real], high[real], ahead[real]
    start, extent = low.min(axis=0), high.max(axis=0) - low.min(axis=0)
    x, y, z = np.argsort(-extent)
    thickness = max(2.0 * float(np.mean(high[:, z] - low[:, z])), float(extent[z]) / 1000.0) or 1.0
    first, last = (np.floor((h[:, z] - start[z]) / thickness).astype(np.int64) for h in (low, high))
    box, slab, _ = expanded(first, last - first + 1)
    shift = slab * (1.5 * extent[y] + 1e-300) - start[y]
    boxes = shapely.box(low[box, x] - start[x], low[box, y] + shift, high[box, x] - start[x], high[box, y] + shift)
    front, back = (np.flatnonzero(sense * ahead[box] >= -within / 2) for sense in (1, -1))
    one, other = shapely.STRtree(boxes[back]).query(boxes[front])
    one, other = front[one], back[other]
    i, j = box[one], box[other]
    # Two boxes with several common slabs count in the first of them only.
    once = (ahead[i] > ahead[j]) | ((ahead[i] == ahead[j]) & (i < j))
    i, j, common = i[once], j[once], slab[one[once]]
    keep = (common == np.maximum(first[i], first[j])) & (low[i, z] <= high[j, z]) & (low[j, z] <= high[i, z])
    return real[i[keep]], real[j[keep]]


def separations(bodies: list[Polyhedron], i: Index, j: Index) -> Array:
    """Return the distances (m,) of the bodies i (m,) from the bodies j (m,) along the normals of their faces.

    A distance above zero is a lower bound of the true distance, and exact if a face of one looks at the other. It is
    zero or negative if no plane along a face separates the two: they overlap, touch with edges only, or one extends
    into a hollow of the other.
    """
    if not len(i):
        return np.empty(0)
    normals = _Packed.of([b.normals for b in bodies])
    vertices = _Packed.of([b.vertices for b in bodies])
    support = np.concatenate([(b.normals @ b.vertices.T).max(axis=1) for b in bodies])

    def beyond(i: Index, j: Index) -> Array:
        """Return the largest distance of the bodies j beyond a body i along one of its normals."""
        pair, face, first_face = expanded(normals.start[i], normals.count[i])
        row, vertex, first_vertex = expanded(vertices.start[j][pair], vertices.count[j][pair])
        heights = np.einsum("ij,ij->i", normals.values[face[row]], vertices.values[vertex])
        gaps = np.minimum.reduceat(heights, first_vertex) - support[face]
        return np.asarray(np.maximum.reduceat(gaps, first_face))

    work = np.cumsum(np.maximum(normals.count[i] * vertices.count[j], normals.count[j] * vertices.count[i]))
    cuts = np.flatnonzero(np.diff(work // CHUNK)) + 1
    chunks = zip(np.split(i, cuts), np.split(j, cuts), strict=True)
    return np.concatenate([np.maximum(beyond(a, b), beyond(b, a)) for a, b in chunks])


@dataclass(frozen=True, slots=True)
class _Packed:
    """Arrays of several bodies, one after the other."""

    values: Array
    start: Index
    count: Index

    @classmethod
    def of(cls, arrays: list[Array]) -> Self:
        count = np.array([len(a) for a in arrays])
        return cls(np.concatenate(arrays), np.cumsum(count) - count, count)


def expanded(start: Index, count: Index) -> tuple[Index, Index, Index]:
    """Expand ranges ``start + (0 … count − 1)``: the range of each member, the members, the first of each range."""
    first = np.cumsum(count) - count
    of = np.repeat(np.arange(len(count)), count)
    return of, start[of] + np.arange(len(of)) - first[of], first
