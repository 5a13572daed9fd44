"""Plane polygons in space: areas, axes, planes of many at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple, Self

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, SLIGHT, Array, Index
from blockstruct.geometry.tolerances import GRID, NO_AREA

#: Components that follow each component, and the next ones.
_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])


def cross(a: Array, b: Array) -> Array:
    """Return the vector products of vectors (k, 3) as ``np.cross`` does; for a few vectors, in a sixth of its time."""
    return np.asarray(a.take(_NEXT, 1) * b.take(_LAST, 1) - a.take(_LAST, 1) * b.take(_NEXT, 1))


def plane_axes(n: Array) -> tuple[Array, Array]:
    """Return the in-plane axes s (horizontal; along x in a horizontal plane) and t of unit normals n (..., 3)."""
    n = np.asarray(n, dtype=float)
    s = np.stack([-n[..., 1], n[..., 0], np.zeros(n.shape[:-1])], axis=-1)
    flat = np.linalg.norm(s, axis=-1) < ROUNDING
    level = np.array([1.0, 0.0, 0.0]) - n[..., :1] * n
    s = np.where(flat[..., None], level, s)
    s = s / np.linalg.norm(s, axis=-1, keepdims=True)
    return s, np.cross(n, s)


def next_corners(starts: Index, counts: Index) -> Index:
    """Return the index of the next corner in the same polygon, for polygons stored one after the other."""
    following = np.arange(1, int(counts.sum()) + 1)
    following[starts + counts - 1] = starts
    return following


def polygon_area(points: Array) -> tuple[float, Array, Array]:
    """Return the area, centroid (3,) and unit normal (3,) of a plane polygon, shape (k, 3), convex or not."""
    origin = points.mean(axis=0)
    a = points - origin
    b = np.concatenate([a[1:], a[:1]])
    parts = cross(a, b) / 2
    vector = parts.sum(axis=0)
    area = float(np.linalg.norm(vector))
    if area == 0.0:
        return 0.0, origin, np.zeros(3)
    normal = vector / area
    centroid = origin + ((parts @ normal) @ (a + b)) / (3 * area)
    return area, centroid, normal


def perimeter(points: Array) -> float:
    """Return the length of the outline of a polygon, shape (k, 3)."""
    return float(np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1).sum())


def tributary_areas(points: Array, starts: Index, centroids: Array, normals: Array) -> Array:
    """Return the share of the area of each vertex. The shares of a polygon have its area and its centroid.

    Each vertex takes half of its two triangles with the centroid. If the centroid does not see the whole outline, the
    triangles count by their absolute area, and the shares are then adjusted until their centroid is the centroid of the
    area. With another centroid, uniform tension would have a moment.

    Parameters
    ----------
    points : (K, 3) array
        Vertices of all polygons, one polygon after the other.
    starts : (J,) array
        Index of the first vertex of each polygon.
    centroids, normals : (J, 3) arrays
    """
    counts = np.diff(np.append(starts, len(points)))
    polygon = np.repeat(np.arange(len(starts)), counts)
    following = next_corners(starts, counts)
    previous = np.empty_like(following)
    previous[following] = np.arange(len(points))

    arms = points - centroids[polygon]
    signed = np.einsum("ij,ij->i", cross(arms, arms[following]), normals[polygon]) / 2
    triangles = np.abs(signed)
    areas, sizes = np.add.reduceat(signed, starts), np.add.reduceat(triangles, starts)
    shares = (triangles + triangles[previous]) / 2 * (areas / sizes)[polygon]
    for j in np.flatnonzero(sizes - areas > NO_AREA * sizes).tolist():
        part = slice(starts[j], starts[j] + counts[j])
        (axes,) = np.stack(plane_axes(normals[j : j + 1]), axis=1)
        shares[part] = areas[j] * _levelled(shares[part] / areas[j] + NO_AREA, arms[part] @ axes.T)
    return np.asarray(shares)


def _levelled(weights: Array, points: Array) -> Array:
    """Adjust weights (k,) so that the weighted mean of points (k, 2) is the origin.

    The result has the smallest relative entropy to the initial weights: these times ``exp(λ·p)``, with the λ that
    minimises the logarithm of the sum. A solution exists if the origin is in the convex hull of the points, as the
    centroid of an area is in the hull of its corners.
    """
    points = points / np.ptp(points, axis=0).max()
    slope = np.zeros(2)

    def trial(slope: Array) -> tuple[float, Array]:
        exponent = points @ slope
        grown = weights * np.exp(exponent - exponent.max())
        return float(np.log(grown.sum()) + exponent.max()), grown / grown.sum()

    least, levelled = trial(slope)
    share = 1.0
    while share > NEGLIGIBLE:
        mean = levelled @ points
        step = np.linalg.solve((levelled * points.T) @ points - np.outer(mean, mean), -mean)
        share = 1.0
        # Newton's method ends where not even a small part of a step descends further.
        while share > NEGLIGIBLE and (found := trial(slope + share * step))[0] >= least:
            share /= 2
        if share > NEGLIGIBLE:
            slope, (least, levelled) = slope + share * step, found
    return levelled


def mean_distances(points: Array, starts: Index, centroids: Array, normals: Array) -> Array:
    """Return the mean distance of the area of each polygon from its centroid, (J,).

    It is the lever of torsion under uniform pressure: ``b (√2 + asinh 1) / 6 = 0.38260 b`` for a square of side b, and
    ``2 r / 3`` for a disc of radius r. Consider the triangle of the centroid and an edge at the distance h, whose ends
    are at ``h a`` and ``h b`` from the foot of the perpendicular. Over it, the integral of the distance is
    ``h³ (G(b) − G(a)) / 3`` with ``G(t) = (t √(1 + t²) + asinh t) / 2``.

    Parameters
    ----------
    points, starts, centroids, normals
        As for :func:`tributary_areas`.
    """
    counts = np.diff(np.append(starts, len(points)))
    polygon = np.repeat(np.arange(len(starts)), counts)
    following = next_corners(starts, counts)
    arms = points - centroids[polygon]
    edge = arms[following] - arms
    length = np.maximum(np.linalg.norm(edge, axis=1), np.finfo(float).tiny)
    twice = np.einsum("ij,ij->i", cross(arms, arms[following]), normals[polygon])
    # An edge towards the centroid encloses no area.
    encloses = np.abs(twice) > 1e-12 * length**2
    h = np.where(encloses, twice / length, 1.0)
    direction = edge / length[:, None]

    def G(ends: Array) -> Array:  # noqa: N802 - the symbol of the formula
        t = np.einsum("ij,ij->i", ends, direction) / np.abs(h)
        return np.asarray((t * np.hypot(1.0, t) + np.arcsinh(t)) / 2)

    integral = encloses * np.sign(h) * np.abs(h) ** 3 / 3 * (G(arms[following]) - G(arms))
    return np.asarray(np.add.reduceat(integral, starts) / (np.add.reduceat(twice, starts) / 2))


def flat_polygons(points: Array, of: Index, axes: Array, middles: Array, extent: Array) -> NDArray[np.object_]:
    """Return the polygons of points (k, 3), each in its own plane, on a grid much finer than its extent.

    If corners of two polygons differ in their last digits only, GEOS returns a wrong intersection in about one of a
    thousand cases: a point or nothing for two equal outlines. On the grid such corners are equal.

    Parameters
    ----------
    points : (k, 3) array
    of : (k,) array
        Polygon of each point, ascending.
    axes : (n, 2, 3) array
    middles : (n, 3) array
        Origin of each plane.
    extent : (n,) array
        Extent of each polygon; equal for polygons to intersect.
    """
    flat = np.einsum("kaj,kj->ka", axes[of], points - middles[of])
    grid = np.exp2(np.floor(np.log2(GRID * extent)))[of][:, None]
    return np.asarray(shapely.polygons(shapely.linearrings(np.round(flat / grid) * grid, indices=of)))


def uncrossed(polygons: NDArray[np.object_]) -> NDArray[np.object_]:
    """Replace polygons that cross themselves by the areas that they enclose.

    A warped outline may cross itself in the projection along the normal of another face.
    """
    crossed = ~shapely.is_valid(polygons)
    polygons = polygons.copy()
    polygons[crossed] = shapely.make_valid(polygons[crossed], method="structure", keep_collapsed=False)
    return polygons


def intersections(one: NDArray[np.object_], other: NDArray[np.object_]) -> NDArray[np.object_]:
    """Return the intersections of pairs of polygons; empty if an outline crosses itself by more than rounding."""
    return np.asarray(shapely.intersection(_simple(one), _simple(other)))


def _simple(polygons: NDArray[np.object_]) -> NDArray[np.object_]:
    """Replace polygons that do not enclose their signed area exactly once by empty polygons."""
    enclosed, areas = uncrossed(polygons), shapely.area(polygons)
    enclosed[np.abs(shapely.area(enclosed) - areas) > SLIGHT * areas] = shapely.Polygon()
    return enclosed


Face = tuple[int, ...]


class Corners(NamedTuple):
    """The corners of all faces of a body, one face after the other.

    Attributes
    ----------
    corner : (k,) array
        Vertex of each corner.
    face : (k,) array
        Face of each corner.
    following : (k,) array
        Next corner of the same face.
    start, sides : (f,) array
        First corner of each face, and the number of its corners.
    """

    corner: Index
    face: Index
    following: Index
    start: Index
    sides: Index

    @classmethod
    def of(cls, faces: Sequence[Face]) -> Self:
        """Return the corners of faces, at least one."""
        count = np.array([len(f) for f in faces])
        corner = np.fromiter(chain.from_iterable(faces), dtype=np.int64, count=int(count.sum()))
        start = np.cumsum(count) - count
        return cls(corner, np.repeat(np.arange(len(faces)), count), next_corners(start, count), start, count)


@dataclass(frozen=True, slots=True)
class Planes:
    """Mean planes of faces.

    Attributes
    ----------
    corners : Corners
        Of all faces.
    centre : (f, 3) array
        Mean of the corners.
    area : (f,) array
    normal : (f, 3) array
        Unit normals; zero for a face without area.
    longest : (f,) array
        Longest edge.
    deviation : (f,) array
        Largest distance of a corner from the plane.
    """

    corners: Corners
    centre: Array
    area: Array
    normal: Array
    longest: Array
    deviation: Array

    @classmethod
    def of(cls, vertices: Array, faces: Sequence[Face], corners: Corners | None = None) -> Self:
        """Return the planes of faces (at least one) with vertices (n, 3); the corners of the faces may be at hand."""
        corners = corners or Corners.of(faces)
        corner, face, following, start, count = corners
        points = vertices[corner]
        centre = np.add.reduceat(points, start) / count[:, None]
        arms = points - centre[face]
        vector = np.add.reduceat(cross(arms, arms[following]) / 2, start)
        area = np.linalg.norm(vector, axis=1)
        normal = vector / np.where(area > 0, area, 1.0)[:, None]
        return cls(
            corners=corners,
            centre=centre,
            area=area,
            normal=normal,
            longest=np.maximum.reduceat(np.linalg.norm(arms[following] - arms, axis=1), start),
            deviation=np.maximum.reduceat(np.abs(np.einsum("ij,ij->i", arms, normal[face])), start),
        )

    def heights(self, points: Array) -> Array:
        """Return the heights (m, f) of points (m, 3) over each plane."""
        return np.asarray(points @ self.normal.T - np.einsum("ij,ij->i", self.centre, self.normal))
