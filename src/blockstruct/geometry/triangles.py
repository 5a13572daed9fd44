"""Triangulation, and positions of points and lines relative to triangles and bodies."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array, Flags
from blockstruct.geometry.polygon import polygon_area
from blockstruct.geometry.polyhedron import Polyhedron


def triangulated(vertices: Array, face: Sequence[int]) -> list[tuple[int, ...]]:
    """Return the triangles of a polygon, convex or not, cut off at its shortest diagonals first.

    Two bodies with a common face, plane or warped, divide it in the same way.

    Parameters
    ----------
    vertices : (n, 3) array
    face
        Vertex indices in order.

    Returns
    -------
    list of (int, int, int)
        Vertex indices of the triangles, in the order of rotation of the face.
    """
    loop = list(face)
    if len(loop) == 3:
        return [(loop[0], loop[1], loop[2])]
    normal = polygon_area(vertices[loop])[2]
    triangles: list[tuple[int, ...]] = []
    while len(loop) > 3:
        before, after = [*loop[-1:], *loop[:-1]], [*loop[1:], *loop[:1]]
        lengths = np.linalg.norm(vertices[after] - vertices[before], axis=1)
        # Among diagonals of one length the least corner decides, whichever body asks.
        candidates = [
            (round(float(lengths[k]), 9), min(vertices[before[k]].tolist(), vertices[after[k]].tolist()), k)
            for k in np.flatnonzero(_ears(vertices[before], vertices[loop], vertices[after], normal)).tolist()
        ]
        k = min(candidates)[2] if candidates else 0
        triangles.append((before[k], loop[k], after[k]))
        del loop[k]
    return [*triangles, (loop[0], loop[1], loop[2])]


def _ears(before: Array, at: Array, after: Array, normal: Array) -> Flags:
    """Return which corners (n,) of a polygon are convex with a triangle that covers no other corner."""
    corners = np.stack([before, at, after], axis=1)
    edges = np.roll(corners, -1, axis=1) - corners
    is_convex = np.cross(edges[:, 0], edges[:, 1]) @ normal > 0
    sides = np.cross(edges[:, :, None], at[None, None] - corners[:, :, None]) @ normal
    covered = np.all(sides >= 0, axis=1)
    n = len(at)
    for shift in (-1, 0, 1):
        covered[np.arange(n), (np.arange(n) + shift) % n] = False
    return np.asarray(is_convex & ~covered.any(axis=1))


def half_solid_angles(triangles: Array, points: Array) -> Array:
    """Return half the solid angle (m,) of a closed surface (t, 3, 3) seen from points (m, 3): 2π inside.

    A. van Oosterom, J. Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 30 (1983) 125–126.
    """
    a, b, c = (triangles[None, :, k] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    numerator = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    denominator = (
        la * lb * lc
        + np.einsum("ijk,ijk->ij", a, b) * lc
        + np.einsum("ijk,ijk->ij", b, c) * la
        + np.einsum("ijk,ijk->ij", c, a) * lb
    )
    return np.asarray(np.arctan2(numerator, denominator).sum(axis=1))


def distances(points: Array, triangles: Array) -> Array:
    """Return the distance (m,) of each point (m, 3) from the nearest triangle (t, 3, 3)."""
    arms = points[:, None, None] - triangles[None]
    edges = np.roll(triangles, -1, axis=1) - triangles
    squares = np.einsum("tej,tej->te", edges, edges)
    along = np.clip(np.einsum("ptej,tej->pte", arms, edges) / squares, 0.0, 1.0)
    from_edges = np.linalg.norm(arms - along[..., None] * edges, axis=3).min(axis=2)
    normals = np.cross(edges[:, 0], edges[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    sides = np.einsum("ptej,tej->pte", arms, np.cross(normals[:, None], edges))
    heights = np.abs(np.einsum("ptj,tj->pt", arms[:, :, 0], normals))
    return np.asarray(np.where(np.all(sides >= 0, axis=2), heights, from_edges).min(axis=1))


def between_crossings(lines: Array, triangles: Array) -> Array:
    """Return the points (k, 3) midway between successive crossings of lines (m, 2, 3) with triangles (t, 3, 3).

    The ends of a line count as crossings. A line in the plane of a triangle does not cross it.
    """
    start, way = lines[:, None, 0], (lines[:, 1] - lines[:, 0])[:, None]
    a, b, c = triangles.transpose(1, 0, 2)[:, None]
    # T. Möller, B. Trumbore, "Fast, minimum storage ray/triangle intersection", J. Graphics Tools 2 (1997) 21–28.
    across = np.cross(way, c - a)
    determinant = np.einsum("mtj,mtj->mt", across, np.broadcast_to(b - a, across.shape))
    determinant[determinant == 0] = np.nan
    turned = np.cross(start - a, b - a)
    u = np.einsum("mtj,mtj->mt", start - a, across) / determinant
    v = np.einsum("mtj,mtj->mt", np.broadcast_to(way, turned.shape), turned) / determinant
    along = np.einsum("mtj,mtj->mt", np.broadcast_to(c - a, turned.shape), turned) / determinant
    # An extra crossing only divides a segment; a missing crossing would hide its end.
    hit = (u >= -ROUNDING) & (v >= -ROUNDING) & (u + v <= 1 + ROUNDING) & (along > 0) & (along < 1)
    line, _ = np.nonzero(hit)
    every = np.arange(len(lines))
    line = np.concatenate([every, every, line])
    share = np.concatenate([np.zeros(len(lines)), np.ones(len(lines)), along[hit]])
    order = np.lexsort((share, line))
    line, share = line[order], share[order]
    same = line[1:] == line[:-1]
    middle, of = ((share[1:] + share[:-1]) / 2)[same], line[1:][same]
    return np.asarray(lines[of, 0] + middle[:, None] * (lines[of, 1] - lines[of, 0]))


#: Share of the full solid angle above which a point is inside: 1 inside, 1/2 on a face, 0 outside.
INSIDE = 0.75


def stretches_inside(shape: Polyhedron, start: Array, end: Array, radius: float = 0.0) -> list[tuple[float, float]]:
    """Return the segments of the straight line from start to end inside a body, convex or not.

    A segment in a face, up to rounding, is not inside.

    Parameters
    ----------
    radius
        Radius of a round bar about the line. The whole cross-section must be inside.

    Returns
    -------
    list of (from, to)
        Distances from the start, ascending.
    """
    length = float(np.linalg.norm(end - start))
    low, high = np.minimum(start, end), np.maximum(start, end)
    if np.any(shape.vertices.max(axis=0) < low) or np.any(shape.vertices.min(axis=0) > high):
        return []
    d = (end - start) / length
    size = float(np.ptp(shape.vertices, axis=0).max())
    smallest = NEGLIGIBLE * size
    triangles = shape.vertices[[t for face in shape.faces for t in triangulated(shape.vertices, face)]]
    near = _ranges_near(triangles - start, d, radius + ROUNDING * size)
    at = np.unique(np.clip(np.append(near, [0.0, length]), 0.0, length))
    middle = (at[1:] + at[:-1]) / 2
    in_reach = np.any((near[:, :1] < middle) & (middle < near[:, 1:]), axis=0)
    inside = half_solid_angles(triangles, start + middle[:, None] * d) / (2 * np.pi) >= INSIDE
    segments: list[tuple[float, float]] = []
    for (a, b), counts in zip(pairwise(at.tolist()), (inside & ~in_reach).tolist(), strict=True):
        if b - a <= smallest or not counts:
            continue
        if segments and a - segments[-1][1] <= smallest:
            segments[-1] = segments[-1][0], b
        else:
            segments.append((a, b))
    return segments


def _ranges_near(triangles: Array, d: Array, radius: float) -> Array:
    """Return the ranges (n, 2) along a line in which triangles (t, 3, 3) are within a radius of the line.

    The line passes through the origin with the unit vector d. A range ends at a corner, on an edge or, for a face at an
    angle to the line, at the extreme point of its intersection with the cylinder.
    """
    along = triangles @ d
    off = triangles - along[..., None] * d
    to, along_to = np.roll(off, -1, axis=1) - off, np.roll(along, -1, axis=1) - along
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    slope = normals @ d
    across = normals - slope[:, None] * d
    with np.errstate(divide="ignore", invalid="ignore"):
        # On an edge, with its share: |off + share · to| = radius.
        squares, half = np.einsum("tej,tej->te", to, to), np.einsum("tej,tej->te", off, to)
        root = np.sqrt(half**2 - squares * (np.einsum("tej,tej->te", off, off) - radius**2))
        shares = np.stack([(-half - root) / squares, (-half + root) / squares])
        on_edges = np.where((shares >= 0) & (shares <= 1), along + shares * along_to, np.nan)
        # For a face perpendicular to the line, the crossing itself.
        steepness = np.linalg.norm(across, axis=1, keepdims=True)
        steepest = np.where(steepness > ROUNDING * np.abs(slope[:, None]), radius * across / steepness, 0.0)
        furthest = np.stack([-steepest, steepest])
        height = np.einsum("tj,tj->t", normals, triangles[:, 0])
        on_faces = (height - np.einsum("ktj,tj->kt", furthest, normals)) / slope
        arms = (furthest + on_faces[..., None] * d)[:, :, None] - triangles
        sides = np.cross(np.roll(triangles, -1, axis=1) - triangles, arms)
        within = np.all(np.einsum("ktej,tj->kte", sides, normals) >= 0, axis=2)
    on_faces[~(within & np.isfinite(on_faces))] = np.nan
    corners = np.where(np.linalg.norm(off, axis=2) <= radius, along, np.nan)
    places = np.concatenate([corners.T, on_edges.transpose(0, 2, 1).reshape(6, -1), on_faces])
    places = places[:, ~np.isnan(places).all(axis=0)]
    return np.column_stack([np.nanmin(places, axis=0), np.nanmax(places, axis=0)])
