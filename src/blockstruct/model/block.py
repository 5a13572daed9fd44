"""Rigid blocks."""

from collections.abc import Iterable, Sequence, Set
from typing import ClassVar, Self

import numpy as np
from attrs import field, frozen

from blockstruct.arrays import Array
from blockstruct.errors import GeometryError, ModelError, shown
from blockstruct.geometry.polyhedron import Polyhedron, box, polyhedron
from blockstruct.model.fields import (
    ModelObject,
    checked_direction,
    checked_name,
    has_name,
    instance_of,
    named_arguments,
)
from blockstruct.model.materials import Material
from blockstruct.units import VectorLike, si_array, si_vector
from blockstruct.vocabulary import MOTIONS


def held_motions(value: bool | Iterable[str], what: str = "") -> tuple[str, ...]:
    """Return the motions in which a block is held, in the order of :data:`~blockstruct.vocabulary.MOTIONS`."""
    if isinstance(value, bool):
        return MOTIONS if value else ()
    motions = value if isinstance(value, Sequence | Set) and not isinstance(value, str) else [value]
    if not all(isinstance(motion, str) and motion in MOTIONS for motion in motions):
        msg = f"{what} is {shown(value)}; give True, False or motions that are held: {', '.join(MOTIONS)}"
        raise ModelError(msg)
    return tuple(motion for motion in MOTIONS if motion in motions)


#: Largest angle between a face and the direction that selects it, degrees.
SAME_DIRECTION = 5.0


@frozen(repr=False, eq=False, field_transformer=named_arguments)
class Block(ModelObject):
    """A rigid polyhedral block, made with :meth:`box` or :meth:`from_faces`.

    Attributes
    ----------
    name : str
        Unique in its model.
    shape : Polyhedron
        Vertices in m, outward faces.
    material : Material
    held : tuple of str
        Motions in which the support holds the block, some of ``x, y, z, rx, ry, rz``: along the global axes, and about
        them through the centroid. All six of a fixed block, none of a free one. The argument is ``fixed``: True,
        False, or these motions, as ``("x", "z")``.
    """

    computed: ClassVar = {"volume": "volume", "centroid": "length", "weight": "force"}

    name: str = field(validator=has_name)
    shape: Polyhedron = field(repr=False)
    material: Material = field(validator=instance_of(Material))
    held: tuple[str, ...] = field(default=(), converter=held_motions, alias="fixed", repr=False)

    def __repr__(self) -> str:
        fixed = f", fixed={self.fixed or self.held})" if self.held else ")"
        return f"{super().__repr__()[:-1]}{fixed}"

    @property
    def fixed(self) -> bool:
        """Whether the block is held in all motions."""
        return len(self.held) == len(MOTIONS)

    @property
    def is_roller(self) -> bool:
        """Whether the block is held in some motions, and moves in the others."""
        return bool(self.held) and not self.fixed

    @classmethod
    def box(
        cls, name: str, origin: VectorLike, size: VectorLike, material: Material, *, fixed: bool | Iterable[str] = False
    ) -> Self:
        """Return an axis-parallel box, whose faces 0 to 5 look along −z, +z, −y, +x, +y, −x.

        Parameters
        ----------
        name
            Unique in the model.
        origin, size : quantity, length, three components
            Corner with the smallest coordinates, and edge lengths along x, y, z.
        material
            Material of the block.
        fixed
            Whether the block is a support, or the motions in which a support holds it: :attr:`held`.
        """
        checked_name(name, "block")
        corner = si_vector(origin, "length", f"block {shown(name)}: origin")
        edges = si_vector(size, "length", f"block {shown(name)}: size")
        if min(edges) <= 0:
            msg = f"block {shown(name)}: size {edges} m; give three lengths above zero"
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
        fixed: bool | Iterable[str] = False,
    ) -> Self:
        """Return a polyhedron with polygon faces, convex or not, each plane within 0.2 % of the size of the block.

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
            Whether the block is a support, or the motions in which a support holds it: :attr:`held`.

        Raises
        ------
        GeometryError
            If the surface is open, inside out, far from planar or without volume.
        """
        checked_name(name, "block")
        points = si_array(vertices, "length", f"block {shown(name)}: vertices")
        return cls(name, polyhedron(points, faces, name), material, fixed)

    def face_towards(self, direction: VectorLike) -> int:
        """Return the index of the one face whose outward normal is within 5 degrees of a direction.

        Parameters
        ----------
        direction : three floats or str
            As ``(0, -1, 0)`` or ``"-y"``.

        Raises
        ------
        GeometryError
            If there is no such face, or several.

        Examples
        --------
        >>> size = ["1 m", "1 m", "1 m"]
        >>> Block.box("b", ["0 m", "0 m", "0 m"], size, Material("tuff", "12 kN/m^3")).face_towards("-y")
        2
        """
        towards = np.array(checked_direction(direction, f"block {self.name!r}: direction"))
        cosines = self.shape.normals @ towards
        facing = np.flatnonzero(cosines > np.cos(np.radians(SAME_DIRECTION)))
        if len(facing) != 1:
            near = int(np.argmax(cosines))
            off = np.degrees(np.arccos(min(cosines[near], 1.0)))
            msg = (
                f"block {self.name!r}: {len(facing) or 'no'} faces look towards {tuple(towards.tolist())}; give the "
                f"index of one: face {near} is nearest, {off:.3g} degrees off"
            )
            raise GeometryError(msg)
        return int(facing[0])

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
