"""Pairs of faces that look at each other and have a common area."""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.geometry.faces import Faces
from blockstruct.geometry.neighbours import box_pairs
from blockstruct.geometry.polygon import plane_axes, uncrossed
from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.geometry.tolerances import SIDEWAYS

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
        Corners of the common area, midway between the faces, counter-clockwise about the normal.
    normal : (3,) array
        Unit normal midway between the normals of the faces.
    area
        Area of the polygon.
    gap
        Largest distance of the faces along the normal over the polygon; negative for a penetration.
    closest
        Smallest distance of the faces over the polygon; zero if they cross.
    angle
        Between the planes of the faces, radians.
    """

    minus: int
    plus: int
    polygon: Array
    normal: Array
    area: float
    gap: float
    closest: float
    angle: float


def coplanar_face_pairs(
    bodies: list[Polyhedron], reach: float, angle: float, *, rounding: float | None = None
) -> list[FacePair]:
    """Return all common areas of faces of different bodies, whatever their number and size.

    Each pair of faces is tested on its own, with the mean planes. The faces look at each other, and their smallest
    distance over the common area is at most the reach.

    Parameters
    ----------
    bodies
        Polyhedra.
    reach
        Largest gap, and largest penetration, at the closest point.
    angle
        Largest angle between two faces, radians.
    rounding
        Deviation from a straight outline that counts as rounding; the reach by default.
    """
    if len(bodies) < 2:
        return []
    faces = Faces.of(bodies)
    front, back = _candidates(faces, reach, angle)
    n = faces.normal[front] - faces.normal[back]
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    middle = (faces.centre[front] + faces.centre[back]) / 2
    axes = np.stack(plane_axes(n), axis=1)
    extent = np.maximum(faces.extent[front], faces.extent[back])
    outlines = [uncrossed(faces.outlines(f, axes, middle, extent)) for f in (front, back)]
    parts, of_pair = shapely.get_parts(shapely.intersection(*outlines), return_index=True)
    # Faces are simple polygons, so their common area has no holes. Coincident edges leave spurious corners of rounding,
    # which would become contact points.
    parts = shapely.simplify(shapely.normalize(parts), reach if rounding is None else rounding)
    keep = (shapely.get_type_id(parts) == shapely.GeometryType.POLYGON) & ~shapely.is_empty(parts)
    parts, of_pair = shapely.orient_polygons(parts[keep]), of_pair[keep]
    if not len(parts):
        return []
    rings, of_part = shapely.get_coordinates(parts, return_index=True)
    # Rings of shapely repeat their first point.
    last = np.append(np.diff(of_part) > 0, [True])
    rings, of_part = rings[~last], of_part[~last]
    start = np.flatnonzero(np.append([True], np.diff(of_part) > 0))
    k = of_pair[of_part]
    points = middle[k] + np.einsum("ia,iaj->ij", rings, axes[k])
    # Heights of the two faces over the common corners, along n: the plane between them is the interface.
    low, high = (
        np.einsum("ij,ij->i", faces.centre[f[k]] - points, faces.normal[f[k]])
        / np.einsum("ij,ij->i", n[k], faces.normal[f[k]])
        for f in (front, back)
    )
    least, most = np.minimum.reduceat(high - low, start), np.maximum.reduceat(high - low, start)
    gap = np.where(np.abs(least) > np.abs(most), least, most)
    closest = np.where(least * most < 0, 0.0, np.minimum(np.abs(least), np.abs(most)))
    points = points + ((low + high) / 2)[:, None] * n[k]
    polygons = np.split(points, start[1:])
    angles = _angle(faces.normal[front], faces.normal[back])[of_pair]
    measures = np.column_stack([shapely.area(parts), gap, closest, angles])
    pairs = [
        FacePair(int(faces.body[front[k]]), int(faces.body[back[k]]), polygon, n[k], *numbers)
        for k, polygon, numbers in zip(of_pair, polygons, measures.tolist(), strict=True)
        if numbers[2] <= reach
    ]
    pairs.sort(key=lambda p: (p.minus, p.plus, *p.polygon[0]))
    return pairs


def crossed_faces(bodies: list[Polyhedron]) -> list[tuple[int, int]]:
    """Return the faces whose outline crosses itself, as (body, face); their common areas are undefined."""
    if not bodies:
        return []
    faces = Faces.of(bodies)
    every = np.arange(len(faces.body))
    axes = np.stack(plane_axes(faces.normal), axis=1)
    bad = ~shapely.is_valid(faces.outlines(every, axes, faces.centre, faces.extent))
    first = np.searchsorted(faces.body, faces.body)
    return [(int(faces.body[f]), int(f - first[f])) for f in np.flatnonzero(bad)]


def _candidates(faces: Faces, reach: float, angle: float) -> tuple[Index, Index]:
    """Return pairs of faces (front, back) of different bodies that look at each other and whose boxes meet.

    The front face looks up (or, if level, along +y or +x).
    """
    i, j = box_pairs(faces.low - reach, faces.high + reach)
    keep = faces.body[i] != faces.body[j]
    i, j = i[keep], j[keep]
    keep = _angle(faces.normal[i], faces.normal[j]) <= angle
    i, j = i[keep], j[keep]
    up = _half_space_sign(faces.normal[i] - faces.normal[j]) > 0
    return np.where(up, i, j), np.where(up, j, i)


def _angle(one: Array, other: Array) -> Array:
    """Return the angle between opposite faces from unit normals (m, 3), accurate for small angles."""
    return np.asarray(2 * np.arcsin(np.minimum(np.linalg.norm(one + other, axis=1) / 2, 1.0)))


def _half_space_sign(normals: Array) -> Array:
    """Return +1 for a normal that points up (or, if level, along +y, then +x), else −1."""
    x, y, z = np.where(np.abs(normals) < SIDEWAYS, 0.0, normals).T
    lead = np.where(z != 0, z, np.where(y != 0, y, x))
    return np.where(lead > 0, 1.0, -1.0)
