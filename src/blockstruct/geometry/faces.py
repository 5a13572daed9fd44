"""All faces of many bodies as flat arrays, and polygons that lie on them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.arrays import CHUNK, Array, Index
from blockstruct.geometry.neighbours import expanded
from blockstruct.geometry.polygon import flat_polygons, intersections, plane_axes, uncrossed
from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.geometry.tolerances import LIES_ON


@dataclass(frozen=True, slots=True)
class Faces:
    """All faces of all bodies, one after the other; each has ``count`` corners from ``start`` on."""

    body: Index
    normal: Array
    centre: Array
    low: Array
    high: Array
    corners: Array
    start: Index
    count: Index

    @classmethod
    def of(cls, bodies: Sequence[Polyhedron]) -> Self:
        """Return the faces of bodies, in their order."""
        count = np.array([len(face) for b in bodies for face in b.faces])
        first = np.cumsum([0, *(len(b.vertices) for b in bodies[:-1])])
        corner = [first + v for first, b in zip(first.tolist(), bodies, strict=True) for face in b.faces for v in face]
        corners = np.concatenate([b.vertices for b in bodies])[corner]
        body = np.repeat(np.arange(len(bodies)), [len(b.faces) for b in bodies])
        return cls.with_corners(body, np.concatenate([b.normals for b in bodies]), corners, count)

    @classmethod
    def with_corners(cls, body: Index, normal: Array, corners: Array, count: Index) -> Self:
        """Return polygons of bodies by their corners, one polygon after the other."""
        start = np.cumsum(count) - count
        return cls(
            body=body,
            normal=normal,
            centre=np.add.reduceat(corners, start) / count[:, None],
            low=np.minimum.reduceat(corners, start),
            high=np.maximum.reduceat(corners, start),
            corners=corners,
            start=start,
            count=count,
        )

    @property
    def extent(self) -> Array:
        """Largest extent along an axis of each face."""
        return np.asarray((self.high - self.low).max(axis=1))

    def outlines(self, index: Index, axes: Array, middle: Array, extent: Array) -> NDArray[np.object_]:
        """Return the outlines of faces, each in the plane with axes (m, 2, 3) about its origin (m, 3)."""
        of_corner, corner, _ = expanded(self.start[index], self.count[index])
        return flat_polygons(self.corners[corner], of_corner, axes, middle, extent)


def common_areas(polygons: Sequence[Array], normals: Array, i: Index, j: Index, tolerance: float) -> Array:
    """Return the common areas (m,) of the polygons i (m,) and the polygons j (m,), in the planes of i.

    An area is zero if the middles are further apart along the normal than the tolerance, or an outline crosses itself.

    Parameters
    ----------
    polygons
        Arrays of corners, shape (k, 3).
    normals : (n, 3) array
        Unit normals of the polygons.
    i, j
        Indices of polygons.
    tolerance
        Distance along the normal.
    """
    own = Faces.with_corners(
        np.arange(len(polygons)), normals, np.concatenate(polygons), np.array([*map(len, polygons)])
    )
    near = np.abs(np.einsum("ij,ij->i", own.centre[i] - own.centre[j], normals[i])) <= tolerance
    areas = np.zeros(len(i))
    i, j = i[near], j[near]
    if len(i):
        axes, extent = np.stack(plane_axes(normals[i]), axis=1), np.maximum(own.extent[i], own.extent[j])
        outlines = (own.outlines(k, axes, own.centre[i], extent) for k in (i, j))
        areas[near] = shapely.area(intersections(*outlines))
    return areas


def areas_on_bodies(
    polygons: Sequence[Array], normals: Array, limits: Array, inside: Array, bodies: Sequence[Polyhedron], of: Index
) -> tuple[Array, Array]:
    """Return the areas (m,) of polygons on faces of their bodies, and the distances (m,) of their corners from there.

    The distance is the largest of a corner from the part of the polygon on the body. It detects spikes, which have
    almost no area. Both are measured in the plane of the polygon, over faces that look along its normal. Parts further
    from the plane of the face than the limits do not count.

    Parameters
    ----------
    polygons
        Corners (k, 3) of each polygon.
    normals : (m, 3) array
        Unit normals.
    limits, inside : (m,) arrays
        Largest distances outside and inside the body.
    bodies
        Polyhedra.
    of : (m,) array
        Body of each polygon.
    """
    faces = Faces.of(bodies)
    own = Faces.with_corners(of, normals, np.concatenate(polygons), np.array([len(p) for p in polygons]))
    begin = np.searchsorted(faces.body, np.arange(len(bodies) + 1))
    count = np.diff(begin)[of]
    areas, distance = np.zeros(len(polygons)), np.full(len(own.corners), np.inf)
    for part in np.array_split(np.arange(len(polygons)), count.sum() // CHUNK + 1):
        row, face, _ = expanded(begin[of[part]], count[part])
        k = part[row]
        reach = np.maximum(limits, inside)[k, None]
        near = np.all((faces.low[face] <= own.high[k] + reach) & (faces.high[face] >= own.low[k] - reach), axis=1)
        near[near] = np.einsum("ij,ij->i", faces.normal[face[near]], normals[k[near]]) > np.cos(LIES_ON)
        k, face = k[near], face[near]
        if len(k):
            shared, corners = _shared(own, k, limits[k], inside[k], faces, face)
            np.add.at(areas, k, shapely.area(shared))
            pair, corner, _ = expanded(own.start[k], own.count[k])
            # The distance from an empty part is NaN, which fmin ignores.
            np.fmin.at(distance, corner, shapely.distance(shared[pair], corners))
    return areas, np.maximum.reduceat(distance, own.start)


def _shared(
    own: Faces, k: Index, limits: Array, inside: Array, faces: Faces, face: Index
) -> tuple[NDArray[np.object_], NDArray[np.object_]]:
    """Return the common parts of polygons k (m,) and a face each, within the limits, and the corners in that plane."""
    middles, normals = own.centre[k], own.normal[k]
    axes = np.stack(plane_axes(normals), axis=1)
    extent = np.maximum(faces.extent[face], own.extent[k])
    outlines = own.outlines(k, axes, middles, extent)
    shared = intersections(outlines, uncrossed(faces.outlines(face, axes, middles, extent)))
    # Height of the plane of the face over the plane of the polygon, linear over the polygon.
    facing = np.einsum("ij,ij->i", faces.normal[face], normals)
    level = np.einsum("ij,ij->i", faces.centre[face] - middles, faces.normal[face]) / facing
    slope = -np.einsum("kaj,kj->ka", axes, faces.normal[face]) / facing[:, None]
    ends, pair = shapely.get_coordinates(shared, return_index=True)
    heights = level[pair] + np.einsum("ka,ka->k", ends, slope[pair])
    far = np.unique(pair[(heights < -limits[pair]) | (heights > inside[pair])])
    if len(far):
        strips = _strips(level[far], slope[far], -limits[far], inside[far], extent[far])
        shared[far] = shapely.intersection(shared[far], strips)
    of, corner, _ = expanded(own.start[k], own.count[k])
    flat = np.einsum("kaj,kj->ka", axes[of], own.corners[corner] - middles[of])
    return shared, np.asarray(shapely.points(flat))


def _strips(level: Array, slope: Array, lowest: Array, highest: Array, extent: Array) -> NDArray[np.object_]:
    """Return the strips where linear functions (m,) of two coordinates are between two values, over an extent."""
    steep = np.linalg.norm(slope, axis=1)[:, None]
    along = np.divide(slope, steep, out=np.tile([1.0, 0.0], (len(slope), 1)), where=steep > 0)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    far = 4 * extent[:, None]
    # From the origin along the slope. Without a slope the whole plane is too far.
    low, high = (
        np.clip(np.divide(end, steep, out=np.full_like(steep, np.inf), where=steep > 0), -far, far)
        for end in ((lowest - level)[:, None], (highest - level)[:, None])
    )
    corners = [low * along - far * across, high * along - far * across]
    corners += [high * along + far * across, low * along + far * across]
    # GEOS does not accept polygons without width.
    return uncrossed(np.asarray(shapely.polygons(np.stack(corners, axis=1))))
