"""Lines through bodies."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.geometry.triangles import half_solid_angles, triangulated

Array = NDArray[np.float64]

#: Length of a stretch, relative to the body, below which it is rounding.
SHORTEST = 1e-6
#: Share of the full solid angle above which a point is inside: it is 1 there, 1/2 on a face and 0 outside.
INSIDE = 0.75


def stretches_inside(shape: Polyhedron, start: Array, end: Array) -> list[tuple[float, float]]:
    """Stretches of the straight line from start to end that lie inside a body, convex or not.

    What runs in a face is not inside, nor is what rounding has moved off it.

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
    corners = shape.vertices[[face[0] for face in shape.faces]]
    along = shape.normals @ d
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = np.einsum("ij,ij->i", shape.normals, corners - start) / along
    within = crossed[(np.abs(along) > SHORTEST) & (crossed > 0) & (crossed < length)]
    at = np.unique([0.0, *within, length])
    smallest = SHORTEST * float(np.ptp(shape.vertices, axis=0).max())
    triangles = np.array([t for face in shape.faces for t in triangulated(shape.vertices, face)])
    found: list[tuple[float, float]] = []
    middle = start + ((at[1:] + at[:-1]) / 2)[:, None] * d
    # A face is as thick as rounding: a point in it leaves the body by a step along its normal, others do not.
    off = middle @ shape.normals.T - np.einsum("ij,ij->i", shape.normals, corners)
    point, face = np.nonzero(np.abs(off) <= smallest)
    tried = np.concatenate([middle, middle[point] + 2 * smallest * shape.normals[face]])
    share = half_solid_angles(shape.vertices[triangles], tried) / (2 * np.pi)
    inside = share[: len(middle)] >= INSIDE
    inside[point[share[len(middle) :] < INSIDE]] = False
    for (a, b), counts in zip(pairwise(at.tolist()), inside.tolist(), strict=True):
        if b - a <= smallest or not counts:
            continue
        if found and a - found[-1][1] <= smallest:
            found[-1] = found[-1][0], b
        else:
            found.append((a, b))
    return found
