"""Pairs of faces that lie in one plane, look at each other and share an area."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from blockstruct.geometry.polygon import plane_axes
from blockstruct.geometry.polyhedron import Polyhedron

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Polygons = NDArray[np.object_]


@dataclass(frozen=True, slots=True)
class FacePair:
    """The common area of two faces.

    Attributes
    ----------
    minus, plus
        Indices of the two bodies; the normal points from minus to plus.
    polygon : (k, 3) array
        Corners of the common area, counter-clockwise about the normal.
    area
        Area of the polygon; it may be below the limit that makes it an interface.
    """

    minus: int
    plus: int
    polygon: Array
    area: float


def coplanar_face_pairs(bodies: list[Polyhedron], tolerance: float) -> list[FacePair]:
    """All common areas of faces of different bodies, whatever their number and size.

    Parameters
    ----------
    bodies
        Polyhedra.
    tolerance
        Distance between two planes, across the whole model, that still counts as contact.
    """
    if not bodies:
        return []
    normals = np.concatenate([b.normals for b in bodies])
    body = np.repeat(np.arange(len(bodies)), [len(b.faces) for b in bodies])
    loops = [body_.vertices[list(face)] for body_ in bodies for face in body_.faces]
    starts = np.cumsum([0, *(len(loop) for loop in loops)])
    corners = np.concatenate(loops)

    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, extent = (low + high) / 2, float(np.linalg.norm(high - low))
    # Opposite faces of one plane get one key: the normal is turned to a half space.
    sign = _half_space_sign(normals)
    turned = normals * sign[:, None]
    offset = np.einsum("ij,ij->i", corners[starts[:-1]] - middle, turned)
    plane = _group(np.column_stack([turned * extent, offset]), tolerance)

    pairs: list[FacePair] = []
    order = np.argsort(plane, kind="stable")
    for faces in np.split(order, np.flatnonzero(np.diff(plane[order])) + 1):
        front, back = faces[sign[faces] > 0], faces[sign[faces] < 0]
        if len(front) and len(back):
            n, d = turned[front[0]], offset[front[0]]
            axes = np.stack(plane_axes(n))
            front_polygons, back_polygons = (_polygons(f, corners, starts, axes, middle) for f in (front, back))
            for i, j, ring, area in _common_areas(front_polygons, back_polygons, tolerance):
                minus, plus = int(body[front[i]]), int(body[back[j]])
                if minus != plus:
                    pairs.append(FacePair(minus, plus, middle + ring @ axes + d * n, area))
    pairs.sort(key=lambda p: (p.minus, p.plus, *p.polygon[0]))
    return pairs


def _half_space_sign(normals: Array) -> Array:
    """+1 where a normal points up (or, if level, along +y, then +x), else −1."""
    x, y, z = np.where(np.abs(normals) < 1e-6, 0.0, normals).T
    lead = np.where(z != 0, z, np.where(y != 0, y, x))
    return np.where(lead > 0, 1.0, -1.0)


def _group(keys: Array, tolerance: float) -> Index:
    """Label of each key such that keys nearer than the tolerance share one."""
    rounded, inverse = np.unique(np.round(keys / tolerance), axis=0, return_inverse=True)
    near = cKDTree(rounded).query_pairs(2.0, output_type="ndarray")
    graph = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(rounded), len(rounded)))
    labels = connected_components(graph, directed=False)[1]
    return np.asarray(labels[inverse.ravel()], dtype=np.int64)


def _polygons(faces: Index, corners: Array, starts: Index, axes: Array, middle: Array) -> Polygons:
    """Faces as polygons in their plane, whose axes are the rows of ``axes``, shape (2, 3)."""
    lengths = starts[faces + 1] - starts[faces]
    index = np.concatenate([np.arange(starts[f], starts[f + 1]) for f in faces])
    flat = (corners[index] - middle) @ axes.T
    rings = shapely.linearrings(flat, indices=np.repeat(np.arange(len(faces)), lengths))
    return np.asarray(shapely.polygons(rings))


def _common_areas(front: Polygons, back: Polygons, tolerance: float) -> Iterator[tuple[int, int, Array, float]]:
    """Index in front and in back, corners (k, 2) counter-clockwise, and area, of every common area."""
    i, j = shapely.STRtree(back).query(front, predicate="intersects")
    parts, of_pair = shapely.get_parts(shapely.intersection(front[i], back[j]), return_index=True)
    # Faces are simple polygons, so what two of them share has no holes. Where edges of the two coincide but for
    # rounding, clipping leaves corners that are none: they would be contact points.
    for part, k in zip(shapely.simplify(shapely.normalize(parts), tolerance), of_pair, strict=True):
        if part.geom_type == "Polygon" and not part.is_empty:
            ring = shapely.get_coordinates(shapely.orient_polygons(part))[:-1]
            yield int(i[k]), int(j[k]), ring, float(part.area)
