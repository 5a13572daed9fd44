"""Faces in plan: orientation, cover, and integrals over them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.arrays import ROUNDING, SLIGHT, Array, Index
from blockstruct.geometry.polyhedron import Polyhedron

Outlines = NDArray[Any]


@dataclass(frozen=True, slots=True)
class PlanFaces:
    """Parts of faces as polygons in plan.

    Attributes
    ----------
    body : (n,) array
        Index of the polyhedron.
    outline : (n,) array of shapely polygons
        In the x–y plane.
    height : (n, 3) array
        Coefficients of the plane of each part, ``z = height @ (1, x, y)``.
    """

    body: Index
    outline: Outlines
    height: Array

    @classmethod
    def of(cls, shapes: Sequence[Polyhedron], sense: float, low: float = -np.inf, high: float = np.inf) -> Self:
        """Return the parts between two levels of faces that look up (sense 1) or down (sense −1)."""
        body, outline, height = [], [], []
        for i, shape in enumerate(shapes):
            for k in np.flatnonzero(sense * shape.normals[:, 2] > SLIGHT):
                corners = shape.vertices[list(shape.faces[k])]
                part = clipped(clipped(corners, 2, high), 2, low, keep=1)
                if len(part) < 3:
                    continue
                polygon = shapely.make_valid(shapely.Polygon(part[:, :2]))
                if polygon.area <= ROUNDING * np.ptp(corners, axis=0).max() ** 2:
                    continue
                n, centre = shape.normals[k], corners.mean(axis=0)
                body.append(i)
                outline.append(polygon)
                height.append([n @ centre / n[2], -n[0] / n[2], -n[1] / n[2]])
        return cls(
            np.array(body, dtype=np.int64),
            np.array(outline, dtype=object),
            np.array(height, dtype=float).reshape(-1, 3),
        )

    def __len__(self) -> int:
        return len(self.body)

    def __getitem__(self, chosen: Any) -> Self:
        return type(self)(self.body[chosen], self.outline[chosen], self.height[chosen])

    def z(self, xy: Array) -> Array:
        """Return the height of each plane at its points, (n, …, 2) to (n, …)."""
        a, b, c = (self.height[:, k].reshape(-1, *(1,) * (xy.ndim - 2)) for k in range(3))
        return np.asarray(a + b * xy[..., 0] + c * xy[..., 1])

    def within(self, region: Any) -> Self:
        """Return the parts in a region of the plan."""
        inside = type(self)(self.body, shapely.intersection(self.outline, region), self.height)
        return inside[shapely.area(inside.outline) > ROUNDING * region.area] if len(self) else self

    def without(self, covers: Self, tolerance: float, reach: float = np.inf) -> Self:
        """Subtract the areas under other faces at the same height, to a tolerance, or above, up to a reach."""
        if not len(self) or not len(covers):
            return self
        one, other = shapely.STRtree(covers.outline).query(self.outline, predicate="intersects")
        shared = shapely.intersection(self.outline[one], covers.outline[other])
        some = shapely.area(shared) > 0.0
        one, other, shared = one[some], other[some], shared[some]
        at = shapely.get_coordinates(shapely.point_on_surface(shared))
        above = covers[other].z(at) - self[one].z(at)
        # The underside of a thin body does not cover its own top.
        over = (above > -tolerance) & (above < reach) & ((self.body[one] != covers.body[other]) | (above > tolerance))
        outline = self.outline.copy()
        for k in np.unique(one[over]):
            outline[k] = shapely.difference(outline[k], shapely.union_all(shared[over & (one == k)]))
        rest = type(self)(self.body, outline, self.height)
        return rest[shapely.area(outline) > ROUNDING * shapely.area(self.outline)]

    def triangles(self) -> tuple[Array, Index]:
        """Return triangles of the outlines: corners (m, 3, 2), and the index of the part of each."""
        parts, owner = shapely.get_parts(shapely.constrained_delaunay_triangles(self.outline), return_index=True)
        corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
        return corners, owner


def clipped(corners: Array, axis: int, limit: float, keep: float = -1) -> Array:
    """Return the part of a polygon (k, d) below a limit along an axis, or above the limit with ``keep=1``.

    Separate parts of a polygon that is not convex stay joined along the limit.
    """
    if not np.isfinite(limit) or not len(corners):
        return corners
    side = keep * (corners[:, axis] - limit)
    after, next_side = np.roll(corners, -1, axis=0), np.roll(side, -1)
    inside = []
    for p, q, a, b in zip(corners, after, side, next_side, strict=True):
        if a >= 0:
            inside.append(p)
        if a * b < 0:
            inside.append(p + (q - p) * (a / (a - b)))
    return np.array(inside).reshape(-1, corners.shape[1])


def fan(corners: Array, normal: Array) -> tuple[Array, Array]:
    """Return the triangles (m, 3, 3) of a plane polygon from its first corner, and their signed areas."""
    triangles = np.stack([np.broadcast_to(corners[0], corners[1:-1].shape), corners[1:-1], corners[2:]], axis=1)
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return triangles, cross @ normal / 2


def products(area: Array, f: Array, g: Array) -> Array:
    """Return integrals of f·g over triangles with areas (m,), for linear f and g with corner values (m, 3)."""
    return np.asarray(area / 12 * (f.sum(axis=1) * g.sum(axis=1) + (f * g).sum(axis=1)))
