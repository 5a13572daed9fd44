"""All faces of many bodies as flat arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.geometry.neighbours import expanded
from blockstruct.geometry.polygon import flat_polygons
from blockstruct.geometry.polyhedron import Polyhedron

Array = NDArray[np.float64]
Index = NDArray[np.int64]


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

    @property
    def extent(self) -> Array:
        """Largest extent along an axis of each face."""
        return np.asarray((self.high - self.low).max(axis=1))

    def outlines(self, index: Index, axes: Array, middle: Array, extent: Array) -> NDArray[np.object_]:
        """Return the outlines of faces, each in the plane with axes (m, 2, 3) about its origin (m, 3)."""
        of_corner, corner, _ = expanded(self.start[index], self.count[index])
        return flat_polygons(self.corners[corner], of_corner, axes, middle, extent)
