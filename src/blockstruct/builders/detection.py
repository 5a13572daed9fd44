"""Interfaces from the faces that blocks share."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstruct.errors import ModelError
from blockstruct.geometry import coplanar_face_pairs
from blockstruct.model import Block, Interface, JointMaterial
from blockstruct.units import si, to_quantity

#: Gap between two planes, relative to the mean block size, that is still rounding.
GAP_TOLERANCE = 1e-5
#: Area, relative to the square of the mean block size, below which a contact is a line or a point.
AREA_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True)
class DetectionReport:
    """What a detection accepted and what it left out.

    Attributes
    ----------
    accepted : int
        Interfaces found.
    total_area : float
        Their area, m².
    tolerance : float
        Largest gap taken for contact, m.
    slivers : tuple of (minus, plus, area in m²)
        Contacts left out because their area is that of a line or a point.
    between_supports : tuple of (minus, plus)
        Contacts left out because both blocks are fixed.
    untouched : tuple of str
        Blocks without any interface.
    """

    accepted: int
    total_area: float
    tolerance: float
    slivers: tuple[tuple[str, str, float], ...]
    between_supports: tuple[tuple[str, str], ...]
    untouched: tuple[str, ...]

    def __str__(self) -> str:
        lines = [
            f"{self.accepted} interfaces, {self.total_area:.6g} m^2 (gap tolerance {self.tolerance:.3g} m)",
            f"{len(self.slivers)} slivers left out",
            f"{len(self.between_supports)} contacts between supports left out",
            f"{len(self.untouched)} blocks without interface",
        ]
        lines += [f"  sliver {a} | {b}: {area:.3g} m^2" for a, b, area in self.slivers]
        lines += [f"  untouched {name}" for name in self.untouched]
        return "\n".join(lines)


@dataclass(frozen=True, slots=True)
class Detection:
    """Interfaces of a set of blocks, and the report on how they were found."""

    interfaces: tuple[Interface, ...]
    report: DetectionReport


def detect_interfaces(blocks: Iterable[Block], joint_material: JointMaterial, tolerance: Any = None) -> Detection:
    """Find every area that the faces of two blocks share.

    All faces take part, whatever the size and number of the blocks; several interfaces a pair are possible.
    Contacts between two fixed blocks are left out. The normal of an interface points up or, if level, along
    +y or +x.

    Parameters
    ----------
    blocks
        Blocks with unique names.
    joint_material
        Strength of the interfaces.
    tolerance : quantity, length
        Largest gap between two planes that is still contact; 1e-5 of the mean block size by default.

    Raises
    ------
    ModelError
        No joint material, a tolerance that is not positive, or two blocks of one name.
    """
    blocks = list(blocks)
    if not isinstance(joint_material, JointMaterial):
        msg = f"detect_interfaces: joint_material is {joint_material!r}; give a JointMaterial"
        raise ModelError(msg)
    twice = [name for name, count in Counter(b.name for b in blocks).items() if count > 1]
    if twice:
        msg = f"detect_interfaces: block names used more than once: {', '.join(twice[:10])}; rename them"
        raise ModelError(msg)
    size = float(np.mean([b.volume for b in blocks if not b.fixed] or [1.0]) ** (1 / 3))
    gap = GAP_TOLERANCE * size if tolerance is None else si(tolerance, "length", "detect_interfaces: tolerance")
    if gap <= 0:
        msg = f"detect_interfaces: tolerance {gap:.6g} m; give a length above zero"
        raise ModelError(msg)

    interfaces: list[Interface] = []
    slivers, supports = [], []
    seen: Counter[tuple[str, str]] = Counter()
    for pair in coplanar_face_pairs([b.shape for b in blocks], gap):
        minus, plus = blocks[pair.minus], blocks[pair.plus]
        ends = (minus.name, plus.name)
        if minus.fixed and plus.fixed:
            supports.append(ends)
        elif pair.area <= AREA_TOLERANCE * size**2:
            slivers.append((*ends, pair.area))
        else:
            seen[ends] += 1
            name = "|".join(ends) + (f"#{seen[ends]}" if seen[ends] > 1 else "")
            interfaces.append(Interface(name, *ends, to_quantity(pair.polygon, "length"), joint_material))
    touched = {end for i in interfaces for end in (i.minus, i.plus)}
    report = DetectionReport(
        accepted=len(interfaces),
        total_area=float(sum(i.area for i in interfaces)),
        tolerance=gap,
        slivers=tuple(slivers),
        between_supports=tuple(supports),
        untouched=tuple(b.name for b in blocks if b.name not in touched),
    )
    return Detection(tuple(interfaces), report)
