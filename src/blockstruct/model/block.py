"""Rigid blocks."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import GeometryError, ModelError, shown
from blockstruct.geometry import Polyhedron, box, polyhedron
from blockstruct.model.checks import checked_direction, checked_name
from blockstruct.model.material import Material
from blockstruct.units import VectorLike, si_array, si_vector

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """A rigid polyhedral block. Make one with :meth:`box` or :meth:`from_faces`.

    Attributes
    ----------
    name : str
        Unique in its model.
    shape : Polyhedron
        Vertices in m, outward faces.
    material : Material
    fixed : bool
        Whether the block is a support.
    """

    name: str
    shape: Polyhedron = field(repr=False)
    material: Material
    fixed: bool = False

    def __post_init__(self) -> None:
        checked_name(self.name, "block")
        if not isinstance(self.material, Material):
            msg = f"block {self.name!r}: material is {shown(self.material)}; give a Material"
            raise ModelError(msg)
        if not isinstance(self.fixed, bool):
            msg = f"block {self.name!r}: fixed is {shown(self.fixed)}; give True or False"
            raise ModelError(msg)

    @classmethod
    def box(cls, name: str, origin: VectorLike, size: VectorLike, material: Material, *, fixed: bool = False) -> Self:
        """Axis-parallel box, whose faces 0 to 5 look along −z, +z, −y, +x, +y, −x.

        Parameters
        ----------
        name
            Unique in the model.
        origin, size : quantity, length, three components
            Least corner and edge lengths along x, y, z.
        material
            Material of the block.
        fixed
            Whether the block is a support.
        """
        checked_name(name, "block")
        corner = si_vector(origin, "length", f"block {name!r}: origin")
        edges = si_vector(size, "length", f"block {name!r}: size")
        if min(edges) <= 0:
            msg = f"block {name!r}: size {edges} m; give three lengths above zero, a block needs a volume"
            raise GeometryError(msg)
        vertices, faces = box(corner, edges)
        return cls(name, polyhedron(vertices, faces, name), material, fixed)

    @classmethod
    def from_faces(
        cls,
        name: str,
        vertices: VectorLike,
        faces: Sequence[Sequence[int]],
        material: Material,
        *,
        fixed: bool = False,
    ) -> Self:
        """General polyhedron with polygon faces, convex or not, each plane but for 0.2 % of the size of the block.

        Parameters
        ----------
        name
            Unique in the model.
        vertices : quantity, length, shape (n, 3)
            Corner points.
        faces
            Vertex indices of each face, counter-clockwise seen from outside.
        material
            Material of the block.
        fixed
            Whether the block is a support.

        Raises
        ------
        GeometryError
            If the surface is open, inside out, far from planar or without volume.
        """
        checked_name(name, "block")
        points = si_array(vertices, "length", f"block {name!r}: vertices")
        return cls(name, polyhedron(points, faces, name), material, fixed)

    def face_towards(self, direction: VectorLike) -> int:
        """Index of the one face whose outward normal looks along a direction, to 5 degrees.

        Parameters
        ----------
        direction : three floats or str
            As ``(0, -1, 0)`` or ``"-y"``.

        Raises
        ------
        GeometryError
            If no face looks there, or several do.

        Examples
        --------
        >>> size = ["1 m", "1 m", "1 m"]
        >>> Block.box("b", ["0 m", "0 m", "0 m"], size, Material("tuff", "12 kN/m^3")).face_towards("-y")
        2
        """
        towards = np.array(checked_direction(direction, f"block {self.name!r}: direction"))
        cosines = self.shape.normals @ towards
        found = np.flatnonzero(cosines > np.cos(np.radians(5.0)))
        if len(found) != 1:
            near = int(np.argmax(cosines))
            off = np.degrees(np.arccos(min(cosines[near], 1.0)))
            msg = (
                f"block {self.name!r}: {len(found) or 'no'} faces look towards {tuple(towards.tolist())}; give the "
                f"index of one: face {near} is nearest, {off:.3g} degrees off"
            )
            raise GeometryError(msg)
        return int(found[0])

    @property
    def volume(self) -> float:
        """Volume, m³."""
        return self.shape.volume

    @property
    def centroid(self) -> Array:
        """Centroid (3,), m."""
        return self.shape.centroid

    @property
    def weight(self) -> float:
        """Weight, N."""
        return self.shape.volume * self.material.unit_weight
