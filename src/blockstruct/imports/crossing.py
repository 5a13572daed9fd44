"""Where a surface crosses itself."""

from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.geometry.planes import Planes
from blockstruct.geometry.polygon import plane_axes
from blockstruct.imports.flatten import triangulated

Array = NDArray[np.float64]
Face = tuple[int, ...]

#: Candidates judged at once.
CHUNK = 200_000


def first_crossing(vertices: Array, faces: list[Face], size: float) -> Array | None:
    """A point (3,) where a closed surface crosses itself, or None.

    An edge crosses a face if it passes through it; a polygon crosses itself if its outline does. A convex body is
    done with at once.

    Parameters
    ----------
    vertices : (n, 3) array
    faces
        Vertex indices of each planar face.
    size
        Largest extent of the body.
    """
    planes = Planes.of(vertices, faces)
    axes = np.stack(plane_axes(planes.normal), axis=1)[planes.face]
    flat = np.einsum("kaj,kj->ka", axes, vertices[planes.corner] - planes.centre[planes.face])
    simple = shapely.is_valid(shapely.polygons(shapely.linearrings(flat, indices=planes.face)))
    if not simple.all():
        return np.asarray(planes.centre[np.argmin(simple)])
    if planes.heights(vertices).max() <= 1e-7 * size:
        return None
    triangles = np.array([t for f in faces for t in triangulated(vertices, f)])
    edges = np.array(sorted({(min(a, b), max(a, b)) for f in faces for a, b in pairwise((*f, f[0]))}))
    low_edge, high_edge = vertices[edges].min(axis=1), vertices[edges].max(axis=1)
    low_face, high_face = vertices[triangles].min(axis=1), vertices[triangles].max(axis=1)
    x, y, z = np.argsort(-np.ptp(vertices, axis=0))
    tree = shapely.STRtree(shapely.box(low_face[:, x], low_face[:, y], high_face[:, x], high_face[:, y]))
    e, t = tree.query(shapely.box(low_edge[:, x], low_edge[:, y], high_edge[:, x], high_edge[:, y]))
    keep = (low_edge[e, z] <= high_face[t, z]) & (low_face[t, z] <= high_edge[e, z])
    keep &= ~np.any(edges[e][:, :, None] == triangles[t][:, None, :], axis=(1, 2))
    e, t = e[keep], t[keep]
    for part in np.array_split(np.arange(len(e)), len(e) // CHUNK + 1):
        point = _passage(vertices, edges[e[part]], triangles[t[part]], size)
        if point is not None:
            return point
    return None


def _passage(vertices: Array, edges: NDArray[np.int64], triangles: NDArray[np.int64], size: float) -> Array | None:
    """Point where one of the edges (m, 2) passes through its triangle (m, 3), or None."""
    start, end = vertices[edges[:, 0]], vertices[edges[:, 1]]
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    normal = normal / np.where(length > 0, length, 1.0)[:, None]
    below, above = np.einsum("ij,ij->i", start - a, normal), np.einsum("ij,ij->i", end - a, normal)
    # Touching, to within the planarity of faces, is no crossing.
    margin = 1e-6 * size
    through = (np.minimum(below, above) < -margin) & (np.maximum(below, above) > margin) & (length > 0)
    share = np.where(through, below / np.where(through, below - above, 1.0), 0.0)
    point = start + share[:, None] * (end - start)
    for p, q in ((a, b), (b, c), (c, a)):
        along = (q - p) / np.maximum(np.linalg.norm(q - p, axis=1), margin)[:, None]
        through &= np.einsum("ij,ij->i", np.cross(along, point - p), normal) > -margin
    hits = np.flatnonzero(through)
    return np.asarray(point[hits[0]]) if len(hits) else None
