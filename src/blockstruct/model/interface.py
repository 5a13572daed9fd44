"""Interfaces between blocks."""

from typing import Any, ClassVar

import numpy as np
from attrs import field, frozen

from blockstruct.arrays import ROUNDING, Array
from blockstruct.errors import GeometryError, ModelError
from blockstruct.geometry.polygon import mean_distances, polygon_area
from blockstruct.geometry.tolerances import NO_AREA
from blockstruct.model.fields import ModelObject, changed, has_name, instance_of, label, named_arguments, store
from blockstruct.model.materials import JointMaterial
from blockstruct.units import VectorLike, si_array
from blockstruct.vocabulary import JointOrientation

#: Largest distance of a corner from the fitted plane, relative to the size.
LARGEST_DEVIATION = 0.2


def _polygon(value: VectorLike, dimension: str = "", what: str = "") -> Array:
    polygon = np.array(si_array(value, dimension, what))
    if polygon.ndim != 2 or polygon.shape[1:] != (3,) or len(polygon) < 3:
        msg = f"{what} of shape {polygon.shape}; give three or more points, shape (k, 3)"
        raise GeometryError(msg)
    return polygon


def _is_other_block(interface: Any, _: Any, plus: str) -> None:
    if plus == interface.minus:
        msg = f"{label(interface)}: joins block {plus!r} with itself; name two blocks"
        raise ModelError(msg)


@frozen(repr=False, eq=False, field_transformer=named_arguments)
class Interface(ModelObject):
    """A contact between two blocks: plane, or fitted by a plane.

    Parameters
    ----------
    name
        Unique in the model.
    minus, plus
        Names of the two blocks. The normal points from the minus block to the plus block.
    polygon : quantity, length, shape (k, 3)
        Corners, which are the contact points, counter-clockwise seen from the plus block. A repeated corner counts
        once. The corners need not lie in one plane. The contact then has the area, the normal and the axes of the
        fitted plane, through the centroid of the polygon and along its area vector. Each force acts at its own corner;
        if a joint crushes in cells, at the corner of a cell in the plane.
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
        Largest distance of a corner from the fitted plane, m.

    Raises
    ------
    GeometryError
        If the polygon has no area, or a corner is more than a fifth of its size from the plane.
    ModelError
        If the interface joins a block with itself, or has no joint material.
    """

    computed: ClassVar = {"torsion_lever": "length"}

    name: str = field(validator=has_name)
    minus: str = field(validator=has_name)
    plus: str = field(validator=[has_name, _is_other_block])
    polygon: Array = field(converter=_polygon, repr=False, metadata={"dimension": "length"})
    joint_material: JointMaterial = field(validator=instance_of(JointMaterial))
    area: float = field(init=False, metadata={"dimension": "area"})
    centroid: Array = field(init=False, repr=False, metadata={"dimension": "length"})
    normal: Array = field(init=False, repr=False, metadata={"dimension": "dimensionless"})
    deviation: float = field(init=False, repr=False, metadata={"dimension": "length"})

    def __attrs_post_init__(self) -> None:
        polygon = self.polygon
        area, centroid, normal = polygon_area(polygon)
        size = float(np.ptp(polygon, axis=0).max())
        if area <= NO_AREA * size**2:
            msg = f"{label(self)}: the polygon has no area; remove the interface or correct its corners"
            raise GeometryError(msg)
        edges = polygon - np.concatenate([polygon[-1:], polygon[:-1]])
        polygon = polygon[np.linalg.norm(edges, axis=1) > ROUNDING * size]
        deviation = float(np.abs((polygon - centroid) @ normal).max())
        if deviation > LARGEST_DEVIATION * size:
            msg = (
                f"{label(self)}: a corner is {deviation:.3g} m off the plane fitted to the polygon (limit "
                f"{LARGEST_DEVIATION * size:.3g} m); divide the contact into interfaces that are closer to planes"
            )
            raise GeometryError(msg)
        for array in (polygon, centroid, normal):
            array.setflags(write=False)
        store(self, polygon=polygon, area=area, centroid=centroid, normal=normal, deviation=deviation)

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
        """Return the same contact with another joint material."""
        other: Interface = changed(self, joint_material=joint_material)
        return other
