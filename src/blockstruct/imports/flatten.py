"""Make faces planar: move vertices into planes, or divide polygons into triangles."""

import numpy as np
from numpy.typing import NDArray

from blockstruct.geometry import triangulated
from blockstruct.geometry.planes import Planes
from blockstruct.imports.tolerances import EXACT, ROUNDS, SHALLOW

Array = NDArray[np.float64]
Face = tuple[int, ...]


def flattened(vertices: Array, faces: list[Face], tolerance: float, size: float) -> tuple[Array, list[Face], int]:
    """Make every face planar to rounding.

    Each polygon within the tolerance gets a plane, and every vertex moves to the nearest common point of its planes.
    Two blocks with a common face thus keep a common face. Other polygons are divided into triangles by their shortest
    diagonals, so that two blocks divide a common warped face in the same way.

    Parameters
    ----------
    vertices : (n, 3) array
    faces
        Vertex indices of each face.
    tolerance
        Largest deviation from a plane of a polygon that is flattened.
    size
        Largest extent of the body.

    Returns
    -------
    vertices, faces, int
        Moved vertices, planar faces, and the number of polygons divided into triangles.
    """
    off = Planes.of(vertices, faces).deviation
    limit = EXACT * size
    if np.all(off <= limit):
        return vertices, faces, 0
    warped = off > tolerance
    kept = [f for f, bad in zip(faces, warped, strict=True) if not bad]
    points = _moved(vertices, kept, limit)
    move = float(np.linalg.norm(points - vertices, axis=1).max())
    if move > 2 * tolerance or (kept and Planes.of(points, kept).deviation.max() > limit):
        points, warped = vertices, off > limit
    loops = [t for f, bad in zip(faces, warped, strict=True) for t in (triangulated(points, f) if bad else [f])]
    return points, loops, int(warped.sum())


def _moved(vertices: Array, faces: list[Face], limit: float) -> Array:
    """Move vertices to the nearest common points of the planes of their polygons, until all are planar."""
    polygons = [f for f in faces if len(f) > 3]
    points = vertices.copy()
    if not polygons:
        return points
    planes = Planes.of(points, polygons)
    corner, of_face = planes.corner, planes.face
    order = np.argsort(corner, kind="stable")
    vertex, count = np.unique(corner, return_counts=True)
    slot = np.arange(len(corner)) - np.repeat(np.cumsum(count) - count, count)
    row = np.repeat(np.arange(len(vertex)), count)
    for _ in range(ROUNDS):
        if planes.deviation.max() <= limit:
            break
        height = np.einsum("ij,ij->i", points[corner] - planes.centre[of_face], planes.normal[of_face])
        normals = np.zeros((len(vertex), count.max(), 3))
        offsets = np.zeros((len(vertex), count.max(), 1))
        normals[row, slot] = planes.normal[of_face[order]]
        offsets[row, slot, 0] = -height[order]
        points[vertex] += (np.linalg.pinv(normals, rcond=SHALLOW) @ offsets)[:, :, 0]
        planes = Planes.of(points, polygons)
    return points
