"""Build the contact-point table of a model."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from blockstruct.arrays import ROUNDING, Array, Index
from blockstruct.geometry.cells import is_rectangle, polygon_cells
from blockstruct.geometry.polygon import mean_distances, plane_axes, tributary_areas
from blockstruct.model import Model
from blockstruct.vocabulary import Torsion


class Division(NamedTuple):
    """How interfaces that crush are divided into cells.

    ``cells`` is the approximate number of cells per interface. ``divided`` lists the interfaces that are divided even
    if they are rectangles. ``regular`` makes all cells of equal size. Interfaces that are not rectangles are always
    divided. Earlier files also divide rectangles that resist tension, into cells of equal size. Verification and
    continued runs keep the division of the file.
    """

    cells: int = 64
    divided: tuple[int, ...] = ()
    regular: bool = False

    @classmethod
    def of_cells(cls, model: Model, cells: int, interface: Index, position: Array) -> Self:
        """Return the division that reproduces stored cells of a model.

        The model generates the cells again, so nothing else in the stored cells is trusted.
        """
        divided = tuple(np.unique(interface).tolist())

        def is_regular(j: int) -> bool:
            i = model.interfaces[j]
            centres, _ = polygon_cells(i.polygon, i.centroid, i.normal, cells, i.name, regular=True)
            stored = position[interface == j]
            near = ROUNDING * np.ptp(i.polygon, axis=0).max()
            return stored.shape == centres.shape and bool(np.abs(stored - centres).max() <= near)

        return cls(cells, divided, bool(divided) and all(map(is_regular, divided)))


@dataclass(frozen=True, slots=True)
class ContactPoints:
    """All contact points k of a model, grouped by interface j.

    Contact points are the corners of an interface. If its joint crushes and it is not a rectangle, they are the
    centroids of its cells.

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
    strength : (J,) array, Pa
        Compressive strength f_c; infinite if the joint does not crush.
    torsion_lever : (J,) array, m
        Lever of friction under uniform pressure: the mean distance of the area from its centroid. Infinite if friction
        at the contact points alone limits the torque.
    friction, dilatancy : (K,) arrays
        Friction coefficient and tangent of the dilatancy angle.
    cohesion, tension : (K,) arrays, N
        Cohesion and tensile strength times the tributary area.
    tributary_area : (K,) array, m²
        Part of the interface area that each point represents.
    normal_stiffness, shear_stiffness : (K,) arrays, Pa/m
        Stiffness of the joint per area; infinite if the joint material has none.
    compression : (K,) array, N
        Compressive strength times the area of a cell; infinite at corners.
    rectangles : (R, 4) array
        Contact points at the corners, in order around the outline, of the interfaces that crush as rectangles.
    """

    position: Array
    interface: Index
    minus: Index
    plus: Index
    frame: Array
    centroid: Array
    area: Array
    strength: Array
    torsion_lever: Array
    friction: Array
    dilatancy: Array
    cohesion: Array
    tension: Array
    tributary_area: Array
    normal_stiffness: Array
    shear_stiffness: Array
    compression: Array
    rectangles: Index

    @classmethod
    def of(cls, model: Model, division: Division) -> Self:
        """Return the contact-point table of a model.

        Parameters
        ----------
        model
            The model.
        division
            Division of the interfaces that crush.
        """
        interfaces = model.interfaces
        index = {b.name: i for i, b in enumerate(model.blocks)}
        joints = [i.joint_material for i in interfaces]
        strength = np.array([j.compressive_strength for j in joints])
        crushes = np.isfinite(strength)
        rectangular = np.array(
            [c and is_rectangle(i.polygon) for c, i in zip(crushes, interfaces, strict=True)], dtype=bool
        )
        rectangular[list(division.divided)] = False
        in_cells = crushes & ~rectangular
        meshes = {
            j: polygon_cells(i.polygon, i.centroid, i.normal, division.cells, i.name, regular=division.regular)
            for j, i in enumerate(interfaces)
            if in_cells[j]
        }
        corners = [i.polygon for i in interfaces]
        centroid = np.array([i.centroid for i in interfaces])
        n = np.array([i.normal for i in interfaces])
        s, t = plane_axes(n)
        starts = np.cumsum([0, *map(len, corners[:-1])])
        of_polygons = np.concatenate(corners), starts, centroid, n
        of_corners = np.split(tributary_areas(*of_polygons), starts[1:])
        parts = [meshes.get(j, part) for j, part in enumerate(zip(corners, of_corners, strict=True))]
        position, tributary = (np.concatenate(column) for column in zip(*parts, strict=True))
        counts = np.array([len(areas) for _, areas in parts])
        first = np.cumsum(counts) - counts
        of_point = np.repeat(np.arange(len(interfaces)), counts)
        compression = np.where(in_cells[of_point], tributary * strength[of_point], np.inf)
        uniform = [j.torsion is Torsion.UNIFORM_PRESSURE for j in joints]
        crushing = crushes & rectangular

        def at_points(values: list[float]) -> Array:
            return np.repeat(np.array(values, dtype=float), counts)

        return cls(
            position=position,
            interface=of_point,
            minus=np.repeat([index[i.minus] for i in interfaces], counts),
            plus=np.repeat([index[i.plus] for i in interfaces], counts),
            frame=np.stack([n, s, t], axis=1),
            centroid=centroid,
            area=np.array([i.area for i in interfaces]),
            strength=strength,
            torsion_lever=np.where(uniform, mean_distances(*of_polygons), np.inf),
            friction=at_points([j.friction_coefficient for j in joints]),
            dilatancy=at_points([j.dilatancy for j in joints]),
            cohesion=at_points([j.cohesion for j in joints]) * tributary,
            tension=at_points([j.tensile_strength for j in joints]) * tributary,
            tributary_area=tributary,
            normal_stiffness=at_points([j.normal_stiffness for j in joints]),
            shear_stiffness=at_points([j.shear_stiffness for j in joints]),
            compression=compression,
            rectangles=first[crushing][:, None] + np.arange(4),
        )

    def __len__(self) -> int:
        return len(self.position)

    @property
    def divided(self) -> tuple[int, ...]:
        """Indices of the interfaces that are divided into cells."""
        return tuple(np.unique(self.interface[np.isfinite(self.compression)]).tolist())
