"""Bodies that occupy the same space."""

import numpy as np
from numpy.typing import NDArray

from blockstruct.geometry.polyhedron import Polyhedron

Array = NDArray[np.float64]


def overlapping_pairs(bodies: list[Polyhedron], tolerance: float) -> list[tuple[int, int, float]]:
    """Pairs of bodies whose interiors meet, with a penetration depth.

    Convex pairs are decided exactly, by separating axes. Where a body is not convex, a regular grid of points
    in the common bounding box is tested instead: an overlap smaller than a twelfth of that box may escape.

    Parameters
    ----------
    bodies
        Polyhedra.
    tolerance
        Depth that still counts as touching.

    Returns
    -------
    list of (i, j, depth)
        ``i < j``. The depth is that of the shallowest direction (convex) or of the common bounding box.
    """
    if len(bodies) < 2:
        return []
    low = np.array([b.vertices.min(axis=0) for b in bodies])
    high = np.array([b.vertices.max(axis=0) for b in bodies])
    found = []
    convex = [_is_convex(b, tolerance) for b in bodies]
    for i, j in _box_pairs(low, high, tolerance):
        a, b = bodies[i], bodies[j]
        if convex[i] and convex[j]:
            depth = _convex_depth(a, b)
        else:
            depth = _sampled_depth(a, b, np.maximum(low[i], low[j]), np.minimum(high[i], high[j]))
        if depth > tolerance:
            found.append((int(i), int(j), depth))
    return found


def _box_pairs(low: Array, high: Array, tolerance: float) -> NDArray[np.int64]:
    """Index pairs (m, 2) of axis-parallel boxes that share more than the tolerance in every direction.

    Sweeps along the axis with the most distinct positions, then tests the other two for all candidates at once.
    """
    axis = int(np.argmax([len(np.unique(np.round(low[:, k], 9))) for k in range(3)]))
    order = np.argsort(low[:, axis], kind="stable")
    low, high = low[order], high[order]
    stop = np.searchsorted(low[:, axis], high[:, axis] - tolerance)
    found = []
    for chunk in np.array_split(np.arange(len(low)), max(1, len(low) // 512)):
        count = np.maximum(stop[chunk] - chunk - 1, 0)
        i = np.repeat(chunk, count)
        j = i + 1 + np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count)
        shared = np.minimum(high[i], high[j]) - np.maximum(low[i], low[j])
        hit = np.all(shared > tolerance, axis=1)
        found.append(np.column_stack([order[i[hit]], order[j[hit]]]))
    pairs = np.sort(np.concatenate(found), axis=1)
    return pairs[np.lexsort(pairs.T[::-1])]


def _is_convex(body: Polyhedron, tolerance: float) -> bool:
    on_face = body.vertices[[face[0] for face in body.faces]]
    heights = np.einsum("fk,fvk->fv", body.normals, body.vertices[None] - on_face[:, None])
    return bool(heights.max() <= tolerance)


def _directions(body: Polyhedron) -> Array:
    edges = np.concatenate([body.vertices[list(f)] - body.vertices[[*f[1:], f[0]]] for f in body.faces])
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    sign = np.where(edges[np.arange(len(edges)), np.argmax(np.abs(edges), axis=1)] < 0, -1.0, 1.0)
    return np.unique(np.round(edges * sign[:, None], 9), axis=0)


def _convex_depth(a: Polyhedron, b: Polyhedron) -> float:
    cross = np.cross(_directions(a)[:, None], _directions(b)[None]).reshape(-1, 3)
    length = np.linalg.norm(cross, axis=1)
    axes = np.concatenate([a.normals, b.normals, cross[length > 1e-6] / length[length > 1e-6, None]])
    pa, pb = a.vertices @ axes.T, b.vertices @ axes.T
    return float(np.minimum(pa.max(axis=0) - pb.min(axis=0), pb.max(axis=0) - pa.min(axis=0)).min())


def _sampled_depth(a: Polyhedron, b: Polyhedron, low: Array, high: Array) -> float:
    # Off the regular points, where faces of neat blocks lie: a point on a face is neither inside nor outside.
    steps = (np.arange(12) + 0.5 + 0.013 * np.sqrt(2)) / 12.1
    grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    points = low + grid * (high - low)
    points = points[_inside(a, points)]
    if len(points) and _inside(b, points).any():
        return float((high - low).min())
    return 0.0


def _inside(body: Polyhedron, points: Array) -> NDArray[np.bool_]:
    """Whether each point lies inside, by the solid angle the surface spans (van Oosterom & Strackee 1983)."""
    fan = np.array([(f[0], f[k], f[k + 1]) for f in body.faces for k in range(1, len(f) - 1)])
    a, b, c = (body.vertices[fan[:, k]][None] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    numerator = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    denominator = (
        la * lb * lc
        + np.einsum("ijk,ijk->ij", a, b) * lc
        + np.einsum("ijk,ijk->ij", b, c) * la
        + np.einsum("ijk,ijk->ij", c, a) * lb
    )
    return np.asarray(np.arctan2(numerator, denominator).sum(axis=1) > np.pi)
