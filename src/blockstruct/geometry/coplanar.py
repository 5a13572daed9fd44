"""Pairs of faces that lie in one plane, look at each other and share an area."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import shapely
from numpy.typing import NDArray

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


#: Cosine beyond which two faces look at each other; how far apart they may lie is for the tolerance to say.
FACING = np.cos(0.02)


def coplanar_face_pairs(bodies: list[Polyhedron], tolerance: float) -> list[FacePair]:
    """All common areas of faces of different bodies, whatever their number and size.

    Every two faces are judged by themselves: they look at each other, and over the area that they share neither
    gap nor penetration exceeds the tolerance.

    Parameters
    ----------
    bodies
        Polyhedra.
    tolerance
        Largest gap, and largest penetration, that still counts as contact.
    """
    if len(bodies) < 2:
        return []
    faces = _Faces.of(bodies)
    front, back = _candidates(faces, tolerance)
    n = faces.normal[front] - faces.normal[back]
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    middle = (faces.centre[front] + faces.centre[back]) / 2
    axes = np.stack(plane_axes(n), axis=1)
    outlines = [_outlines(faces, f, axes, middle) for f in (front, back)]
    parts, of_pair = shapely.get_parts(shapely.intersection(*outlines), return_index=True)
    # Faces are simple polygons, so what two of them share has no holes. Where edges of the two coincide but for
    # rounding, clipping leaves corners that are none: they would be contact points.
    parts = shapely.simplify(shapely.normalize(parts), tolerance)
    pairs = []
    for part, k in zip(parts, of_pair, strict=True):
        if part.geom_type != "Polygon" or part.is_empty:
            continue
        ring = shapely.get_coordinates(shapely.orient_polygons(part))[:-1]
        points = middle[k] + ring @ axes[k]
        # Heights of the two faces over the common corners, along n: the plane between them is the interface.
        heights = [
            ((faces.centre[f[k]] - points) @ faces.normal[f[k]]) / (n[k] @ faces.normal[f[k]]) for f in (front, back)
        ]
        if np.abs(heights[1] - heights[0]).max() <= tolerance:
            points = points + np.outer((heights[0] + heights[1]) / 2, n[k])
            pairs.append(FacePair(int(faces.body[front[k]]), int(faces.body[back[k]]), points, float(part.area)))
    pairs.sort(key=lambda p: (p.minus, p.plus, *p.polygon[0]))
    return pairs


@dataclass(frozen=True, slots=True)
class _Faces:
    """All faces of all bodies, one after the other; corners from ``start`` on, ``count`` of them."""

    body: Index
    normal: Array
    centre: Array
    low: Array
    high: Array
    corners: Array
    start: Index
    count: Index

    @classmethod
    def of(cls, bodies: list[Polyhedron]) -> Self:
        loops = [b.vertices[list(face)] for b in bodies for face in b.faces]
        count = np.array([len(loop) for loop in loops])
        start = np.cumsum(count) - count
        corners = np.concatenate(loops)
        return cls(
            body=np.repeat(np.arange(len(bodies)), [len(b.faces) for b in bodies]),
            normal=np.concatenate([b.normals for b in bodies]),
            centre=np.add.reduceat(corners, start) / count[:, None],
            low=np.minimum.reduceat(corners, start),
            high=np.maximum.reduceat(corners, start),
            corners=corners,
            start=start,
            count=count,
        )


def _candidates(faces: _Faces, tolerance: float) -> tuple[Index, Index]:
    """Pairs of faces (front, back) of different bodies that look at each other and whose boxes meet.

    The front face looks up (or, if level, along +y or +x). The search tree has two axes, those along which the
    structure is longest; the third is tested afterwards.
    """
    extent = faces.high.max(axis=0) - faces.low.min(axis=0)
    x, y, z = np.argsort(-extent)
    low, high = faces.low - tolerance, faces.high + tolerance
    boxes = shapely.box(low[:, x], low[:, y], high[:, x], high[:, y])
    i, j = shapely.STRtree(boxes).query(boxes)
    keep = (i < j) & (faces.body[i] != faces.body[j])
    i, j = i[keep], j[keep]
    keep = (low[i, z] <= high[j, z]) & (low[j, z] <= high[i, z])
    i, j = i[keep], j[keep]
    keep = np.einsum("ij,ij->i", faces.normal[i], faces.normal[j]) < -FACING
    i, j = i[keep], j[keep]
    up = _half_space_sign(faces.normal[i] - faces.normal[j]) > 0
    return np.where(up, i, j), np.where(up, j, i)


def _half_space_sign(normals: Array) -> Array:
    """+1 where a normal points up (or, if level, along +y, then +x), else −1."""
    x, y, z = np.where(np.abs(normals) < 1e-3, 0.0, normals).T
    lead = np.where(z != 0, z, np.where(y != 0, y, x))
    return np.where(lead > 0, 1.0, -1.0)


def _outlines(faces: _Faces, index: Index, axes: Array, middle: Array) -> NDArray[np.object_]:
    """Outline of the faces, each in its own plane of axes (m, 2, 3) about its own middle (m, 3)."""
    count = faces.count[index]
    of_corner = np.repeat(np.arange(len(index)), count)
    offset = np.arange(len(of_corner)) - np.repeat(np.cumsum(count) - count, count)
    points = faces.corners[np.repeat(faces.start[index], count) + offset] - middle[of_corner]
    flat = np.einsum("kaj,kj->ka", axes[of_corner], points)
    return np.asarray(shapely.polygons(shapely.linearrings(flat, indices=of_corner)))
