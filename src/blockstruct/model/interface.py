"""Interfaces between blocks."""

from copy import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import GeometryError, ModelError, shown
from blockstruct.geometry import mean_distances, polygon_area
from blockstruct.model.checks import checked_name
from blockstruct.model.joint_material import JointMaterial
from blockstruct.units import si_array
from blockstruct.vocabulary import JointOrientation

Array = NDArray[np.float64]


#: Distance of a corner from the next, relative to the size of an interface, that is rounding of one.
SAME_CORNER = 1e-9
#: Deviation of a corner from the plane of an interface, relative to its size: what is rounding, and what no plane fits.
PLANARITY, LARGEST_DEVIATION = 1e-5, 0.2


@dataclass(frozen=True, slots=True, eq=False)
class Interface:
    """A contact between two blocks: plane, or fitted by a plane.

    Parameters
    ----------
    name
        Unique in the model.
    minus, plus
        Names of the two blocks. The normal points from the minus block to the plus block.
    polygon : quantity, length, shape (k, 3)
        Corners, counter-clockwise seen from the plus block, about the normal: they are the contact points. One that is
        given again, as where an outline is closed, counts once. They need not lie in one plane: the contact then has
        the area, the normal and the axes of the plane fitted to them (through their centroid, along the area vector of
        the polygon), while each force acts at its own corner, or where a joint crushes in cells at that of a cell in
        the plane.
    joint_material
        Strength of the joint.

    Attributes
    ----------
    polygon : (k, 3) array
        m.
    area : float
        m².
    centroid : (3,) array
        m.
    normal : (3,) array
        Unit normal from minus to plus.
    deviation : float
        Largest distance of a corner from the fitted plane, m; rounding in a plane contact.

    Raises
    ------
    GeometryError
        If the polygon has no area, or deviates from a plane by more than a fifth of its size.
    ModelError
        If the interface joins a block with itself, or has no joint material.
    """

    name: str
    minus: str
    plus: str
    polygon: Any = field(repr=False)
    joint_material: JointMaterial
    area: float = field(init=False)
    centroid: Array = field(init=False, repr=False)
    normal: Array = field(init=False, repr=False)
    deviation: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        checked_name(self.name, "interface")
        who = f"interface {self.name!r}"
        for end in (self.minus, self.plus):
            checked_name(end, f"{who}: block")
        polygon = np.array(si_array(self.polygon, "length", f"{who}: polygon"))
        if polygon.ndim != 2 or polygon.shape[1:] != (3,) or len(polygon) < 3:
            msg = f"{who}: polygon of shape {polygon.shape}; give three or more points, shape (k, 3)"
            raise GeometryError(msg)
        if self.minus == self.plus:
            msg = f"{who}: joins block {self.minus!r} with itself; name two blocks"
            raise ModelError(msg)
        if not isinstance(self.joint_material, JointMaterial):
            msg = f"{who}: joint material is {shown(self.joint_material)}; give a JointMaterial"
            raise ModelError(msg)
        area, centroid, normal = polygon_area(polygon)
        size = float(np.ptp(polygon, axis=0).max())
        if area <= 1e-12 * size**2:
            msg = f"{who}: the polygon has no area; remove the interface or correct its corners"
            raise GeometryError(msg)
        polygon = polygon[np.linalg.norm(polygon - np.roll(polygon, 1, axis=0), axis=1) > SAME_CORNER * size]
        deviation = float(np.abs((polygon - centroid) @ normal).max())
        if deviation > LARGEST_DEVIATION * size:
            msg = (
                f"{who}: a corner lies {deviation:.3g} m off the plane fitted to the polygon (limit "
                f"{LARGEST_DEVIATION * size:.3g} m); divide the contact into interfaces that are closer to planes"
            )
            raise GeometryError(msg)
        for attribute, value in (
            ("polygon", polygon),
            ("area", area),
            ("centroid", centroid),
            ("normal", normal),
            ("deviation", deviation),
        ):
            object.__setattr__(self, attribute, value)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def is_planar(self) -> bool:
        """Whether the corners lie in one plane but for rounding."""
        return self.deviation <= PLANARITY * float(np.ptp(self.polygon, axis=0).max())

    @property
    def torsion_lever(self) -> float:
        """Mean distance of the area from its centroid, m: lever of friction about the normal under uniform pressure."""
        (lever,) = mean_distances(self.polygon, np.array([0]), self.centroid[None], self.normal[None])
        return float(lever)

    @property
    def orientation(self) -> JointOrientation:
        """Bed, head or inclined, by the angle of the normal to the vertical."""
        return JointOrientation.of(float(self.normal[2]))

    def with_joint_material(self, joint_material: JointMaterial) -> "Interface":
        """The same contact of another joint material."""
        other = copy(self)
        object.__setattr__(other, "joint_material", joint_material)
        return other
