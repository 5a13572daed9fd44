"""Lines through bodies."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.geometry.triangles import half_solid_angles, triangulated

Array = NDArray[np.float64]

#: Length of a stretch, relative to the body, below which it is rounding.
SHORTEST = 1e-6
#: Distance from a face, relative to the body, that is rounding.
ROUNDING = 1e-9
#: Share of the full solid angle above which a point is inside: it is 1 there, 1/2 on a face and 0 outside.
INSIDE = 0.75


def stretches_inside(shape: Polyhedron, start: Array, end: Array, radius: float = 0.0) -> list[tuple[float, float]]:
    """Stretches of the straight line from start to end that lie inside a body, convex or not.

    What runs in a face is not inside, nor is what rounding has moved off it.

    Parameters
    ----------
    radius
        Of a round bar about the line, whose whole cross-sections are to be inside.

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
    smallest = SHORTEST * size
    triangles = shape.vertices[[t for face in shape.faces for t in triangulated(shape.vertices, face)]]
    near = _ranges_near(triangles - start, d, radius + ROUNDING * size)
    at = np.unique(np.clip(np.append(near, [0.0, length]), 0.0, length))
    middle = (at[1:] + at[:-1]) / 2
    in_reach = np.any((near[:, :1] < middle) & (middle < near[:, 1:]), axis=0)
    inside = half_solid_angles(triangles, start + middle[:, None] * d) / (2 * np.pi) >= INSIDE
    found: list[tuple[float, float]] = []
    for (a, b), counts in zip(pairwise(at.tolist()), (inside & ~in_reach).tolist(), strict=True):
        if b - a <= smallest or not counts:
            continue
        if found and a - found[-1][1] <= smallest:
            found[-1] = found[-1][0], b
        else:
            found.append((a, b))
    return found


def _ranges_near(triangles: Array, d: Array, radius: float) -> Array:
    """Ranges (n, 2) along a line through the origin, of unit vector d, of triangles (t, 3, 3) within a radius of it.

    Each ends at a corner, on an edge or, of a face that the line crosses aslant, where the cylinder cuts it furthest.
    """
    along = triangles @ d
    off = triangles - along[..., None] * d
    to, along_to = np.roll(off, -1, axis=1) - off, np.roll(along, -1, axis=1) - along
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    slope = normals @ d
    across = normals - slope[:, None] * d
    with np.errstate(divide="ignore", invalid="ignore"):
        # On an edge, at a share of it: |off + share · to| = radius.
        squares, half = np.einsum("tej,tej->te", to, to), np.einsum("tej,tej->te", off, to)
        root = np.sqrt(half**2 - squares * (np.einsum("tej,tej->te", off, off) - radius**2))
        shares = np.stack([(-half - root) / squares, (-half + root) / squares])
        on_edges = np.where((shares >= 0) & (shares <= 1), along + shares * along_to, np.nan)
        # Of a face that the line crosses squarely, where it does.
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
    found = np.concatenate([corners.T, on_edges.transpose(0, 2, 1).reshape(6, -1), on_faces])
    found = found[:, ~np.isnan(found).all(axis=0)]
    return np.column_stack([np.nanmin(found, axis=0), np.nanmax(found, axis=0)])
