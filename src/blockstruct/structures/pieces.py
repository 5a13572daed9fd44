"""Blocks of the units of walls, for any position of the wall."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from blockstruct.arrays import Array
from blockstruct.geometry.polyhedron import box, lofted
from blockstruct.model import Block, Material
from blockstruct.structures.bond import Panel
from blockstruct.structures.prism import block


@dataclass(slots=True)
class Pieces:
    """Blocks of a wall with its sidewalls and buttresses, in building order."""

    prefix: str
    material: Material
    course_height: float
    blocks: list[Block] = field(default_factory=list)

    def box(self, name: str, corner: Sequence[float], size: Sequence[float], *, fixed: bool = False) -> None:
        """Lay a box with its smallest corner at ``corner``."""
        self.blocks.append(block(self.prefix + name, box(corner, size), self.material, fixed=fixed))

    def panel(self, panel: Panel) -> None:
        """Lay the courses of a panel, and the voussoirs of its openings."""
        axes, height = panel.axes, self.course_height
        for number in range(1, len(panel.heads) + 1):
            for unit in panel.units(number):
                if unit.outline is not None:
                    self._extruded(panel.name + unit.name, unit.outline, unit.v, axes)
                    continue
                (u0, u1), (v0, v1) = unit.u, unit.v
                x, y, _ = np.minimum(axes[2] + u0 * axes[0] + v0 * axes[1], axes[2] + u1 * axes[0] + v1 * axes[1])
                a, b, _ = np.abs((u1 - u0) * axes[0] + (v1 - v0) * axes[1])
                self.box(panel.name + unit.name, (x, y, (number - 1) * height), (a, b, height))
        for i, opening in enumerate(panel.openings, start=1):
            for k, outline in enumerate(opening.voussoir_outlines(height), start=1):
                self._extruded(f"{panel.name}voussoir {i}.{k}", outline, (0.0, panel.bond.thickness), axes)

    def _extruded(self, name: str, outline: Array, v: tuple[float, float], axes: Array) -> None:
        foot = axes[2] + outline[:, :1] * axes[0] + outline[:, 1:] * np.array([0.0, 0.0, 1.0])
        body = lofted(foot + v[0] * axes[1], foot + v[1] * axes[1])
        self.blocks.append(block(self.prefix + name, body, self.material))
