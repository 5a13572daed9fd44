"""Mean planes of all faces of a body."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple, Self

import numpy as np

from blockstruct.arrays import Array, Index
from blockstruct.geometry.polygon import cross, next_corners

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
