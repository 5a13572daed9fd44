"""Lines through bodies."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.geometry.tolerances import NEGLIGIBLE, ROUNDING
from blockstruct.geometry.triangles import half_solid_angles, triangulated

Array = NDArray[np.float64]

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
