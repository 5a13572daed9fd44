"""The contact-point table of a model."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import CrushingNotAvailableError
from blockstruct.geometry import plane_axes, tributary_areas
from blockstruct.model import Model

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class ContactPoints:
    """All contact points k of a model, one interface j after the other.

    Attributes
    ----------
    position : (K, 3) array, m
    interface : (K,) array
        Index of the interface of each point.
    minus, plus : (K,) arrays
        Indices of the two blocks.
    frame : (J, 3, 3) array
        Rows n, s, t of each interface; n points from minus to plus, s is horizontal.
    centroid : (J, 3) array, m
    area : (J,) array, m²
    friction, dilatancy : (K,) arrays
        Friction coefficient and tangent of the dilatancy angle.
    cohesion, tension : (K,) arrays, N
        Cohesion and tensile strength times the tributary area.
    """

    position: Array
    interface: Index
    minus: Index
    plus: Index
    frame: Array
    centroid: Array
    area: Array
    friction: Array
    dilatancy: Array
    cohesion: Array
    tension: Array

    @classmethod
    def of(cls, model: Model) -> Self:
        """Table of a model.

        Raises
        ------
        CrushingNotAvailableError
            A joint material of finite compressive strength.
        """
        for joint in model.joint_materials.values():
            if np.isfinite(joint.compressive_strength):
                msg = (
                    f"joint material {joint.name!r}: compressive strength {joint.compressive_strength:.6g} Pa, but "
                    "crushing is not available in this version; leave compressive_strength out to take it as infinite"
                )
                raise CrushingNotAvailableError(msg)
        index = {b.name: i for i, b in enumerate(model.blocks)}
        interfaces = model.interfaces
        counts = np.array([len(i.polygon) for i in interfaces], dtype=np.int64)
        position = np.concatenate([i.polygon for i in interfaces])
        centroid = np.array([i.centroid for i in interfaces])
        n = np.array([i.normal for i in interfaces])
        s, t = plane_axes(n)
        joint_values = np.array(
            [
                (j.friction_coefficient, j.dilatancy, j.cohesion, j.tensile_strength)
                for j in (i.joint_material for i in interfaces)
            ]
        )
        minus, plus = (
            np.array([index[end] for end in ends])
            for ends in ([i.minus for i in interfaces], [i.plus for i in interfaces])
        )
        tributary = tributary_areas(position, np.cumsum(counts) - counts, centroid, n)
        friction, dilatancy, c, ft = np.repeat(joint_values, counts, axis=0).T
        return cls(
            position=position,
            interface=np.repeat(np.arange(len(interfaces)), counts),
            minus=np.repeat(minus, counts),
            plus=np.repeat(plus, counts),
            frame=np.stack([n, s, t], axis=1),
            centroid=centroid,
            area=np.array([i.area for i in interfaces]),
            friction=friction,
            dilatancy=dilatancy,
            cohesion=c * tributary,
            tension=ft * tributary,
        )

    def __len__(self) -> int:
        return len(self.position)
