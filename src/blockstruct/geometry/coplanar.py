"""Pairs of faces that lie in one plane, look at each other and share an area."""

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
            pairs += _common_areas(front, back, turned[front[0]], offset[front[0]], middle, corners, starts, body)
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


def _common_areas(
    front: Index,
    back: Index,
    n: Array,
    offset: float,
    middle: Array,
    corners: Array,
    starts: Index,
    body: Index,
) -> list[FacePair]:
    s, t = plane_axes(n)
    axes = np.column_stack([s, t])
    front_polygons, back_polygons = (_polygons(f, axes, middle, corners, starts) for f in (front, back))
    i, j = shapely.STRtree(back_polygons).query(front_polygons, predicate="intersects")
    apart = body[front[i]] != body[back[j]]
    i, j = i[apart], j[apart]
    common = shapely.intersection(front_polygons[i], back_polygons[j])
    parts, of_pair = shapely.get_parts(common, return_index=True)
    areal = shapely.get_type_id(parts) == shapely.GeometryType.POLYGON
    pairs = []
    for part, k in zip(parts[areal], of_pair[areal], strict=True):
        for piece in _without_holes(part):
            ring = shapely.get_coordinates(shapely.orient_polygons(shapely.normalize(piece)))[:-1]
            points = middle + ring @ axes.T + offset * n
            pairs.append(FacePair(int(body[front[i[k]]]), int(body[back[j[k]]]), points, float(piece.area)))
    return pairs


def _polygons(faces: Index, axes: Array, middle: Array, corners: Array, starts: Index) -> NDArray[np.object_]:
    lengths = starts[faces + 1] - starts[faces]
    index = np.concatenate([np.arange(starts[f], starts[f + 1]) for f in faces])
    flat = (corners[index] - middle) @ axes
    rings = shapely.linearrings(flat, indices=np.repeat(np.arange(len(faces)), lengths))
    return np.asarray(shapely.polygons(rings))


def _without_holes(polygon: shapely.Polygon) -> list[shapely.Polygon]:
    """The polygon in parts that have no hole, cut through the middle of each hole."""
    if not polygon.interiors:
        return [polygon]
    x = polygon.interiors[0].centroid.x
    x0, y0, x1, y1 = polygon.bounds
    halves = [polygon & shapely.box(x0, y0, x, y1), polygon & shapely.box(x, y0, x1, y1)]
    parts = shapely.get_parts(halves)
    return [piece for part in parts if part.geom_type == "Polygon" for piece in _without_holes(part)]
