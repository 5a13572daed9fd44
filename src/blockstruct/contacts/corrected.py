"""Detection of joints whose faces were moved by repairs, with the moves as tolerance."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from blockstruct.arrays import Array
from blockstruct.contacts.detection import LARGEST_ANGLE, detect_interfaces
from blockstruct.model import Block, Detection, FoundContact, Interface, checked_tuple
from blockstruct.model.detection_report import LISTED
from blockstruct.units import QuantityLike, to_quantity
from blockstruct.vocabulary import counted

#: Error of one corner of a quadrilateral, divided by the move of each corner into the new plane.
CORNER_OFF = 4.0


@dataclass(frozen=True, slots=True)
class CorrectedJoints:
    """Joints in contact if the moves of their faces count as tolerance, and the arguments that detect them.

    Pass ``tolerance`` and ``explicit`` to :func:`blockstruct.detect_interfaces`.

    Attributes
    ----------
    closed : tuple of FoundContact
        Joints beyond the tolerance of detection, but within the moves of their faces.
    tolerance : str or None
        Gap tolerance that adds exactly these joints to the detected joints. None if it would close other joints too,
        or if ``closed`` is empty.
    explicit : tuple of Interface
        All interfaces of the blocks of these joints, if ``tolerance`` is None.
    """

    closed: tuple[FoundContact, ...]
    tolerance: str | None
    explicit: tuple[Interface, ...]

    def __str__(self) -> str:
        if not self.closed:
            return "no joint was opened by repairs of its faces"
        rows = [f"  {c.minus} | {c.plus}: {c.gap:.3g} m, area {c.area:.3g} m^2" for c in self.closed[:LISTED]]
        if len(self.closed) > LISTED:
            rows.append(f"  and {len(self.closed) - LISTED} more")
        largest = max(abs(c.gap) for c in self.closed)
        method = "listed as explicit interfaces" if self.tolerance is None else "detected with this gap tolerance"
        closed, their = counted(len(self.closed), "joint"), "its" if len(self.closed) == 1 else "their"
        head = f"{closed} closed that repairs of {their} faces opened"
        return "\n".join([f"{head}, by up to {largest:.3g} m, {method}:", *rows])


def corrected_joints(
    blocks: Iterable[Block],
    joint_material: Any,
    moves: Mapping[str, ArrayLike],
    *,
    angle_tolerance: QuantityLike | None = None,
    area_tolerance: QuantityLike | None = None,
) -> CorrectedJoints:
    """Find the joints that were in contact before vertices of their faces were moved.

    If one corner of a quadrilateral is off by d, each corner moves by d/4 into the new plane. The allowed gap or
    penetration of a joint is therefore four times the largest move across the joint on each of its two faces, plus
    rounding. A joint with a larger gap was drawn open and stays open, whatever moved elsewhere.

    Parameters
    ----------
    blocks, joint_material, angle_tolerance, area_tolerance
        As for :func:`blockstruct.detect_interfaces`.
    moves
        Move of each vertex of a block, shape (n, 3), m, for the blocks with moves, as in
        :attr:`blockstruct.imports.Imported.moves`.

    Raises
    ------
    BlockstructError
        As for :func:`blockstruct.detect_interfaces`.
    """
    known = {b.name: b for b in checked_tuple(blocks, Block, "corrected_joints: blocks")}
    moved = {name: np.asarray(move, dtype=float) for name, move in moves.items()}
    tolerances = {"angle_tolerance": angle_tolerance, "area_tolerance": area_tolerance}
    limits: dict[str, Any] = {name: value for name, value in tolerances.items() if value is not None}
    largest = CORNER_OFF * max((float(np.linalg.norm(m, axis=1).max()) for m in moved.values()), default=0.0)
    if not largest:
        return CorrectedJoints((), None, ())
    base = detect_interfaces(known.values(), joint_material, **limits).report.tolerances.gap

    def detect_within(gap: float) -> tuple[Detection, list[FoundContact], list[FoundContact]]:
        """Detect with a gap tolerance; return also the joints beyond ``base`` within their moves, and the others."""
        detection = detect_interfaces(known.values(), joint_material, to_quantity(gap, "length"), **limits)
        polygons = {i.name: i for i in detection.interfaces}
        within: list[FoundContact] = []
        others: list[FoundContact] = []
        for contact in detection.report.contacts:
            if contact.interface and abs(contact.gap) > base:
                allowed = base + _allowed(polygons[contact.interface], known, moved)
                (within if abs(contact.gap) <= allowed else others).append(contact)
        return detection, within, others

    wide, closed, _ = detect_within(base + 2 * largest)
    if not closed:
        return CorrectedJoints((), None, ())
    # The factor keeps the joint with the largest gap within the tolerance after rounding.
    gap = (1 + 1e-9) * max(abs(c.gap) for c in closed)
    _, again, others = detect_within(gap)
    if not others:
        return CorrectedJoints(tuple(again), f"{gap!r} m", ())
    pairs = {(c.minus, c.plus) for c in closed}
    listed = {c.interface for c in closed}
    listed |= {
        c.interface for c in wide.report.contacts if (c.minus, c.plus) in pairs and c.interface and abs(c.gap) <= base
    }
    return CorrectedJoints(tuple(closed), None, tuple(i for i in wide.interfaces if i.name in listed))


def _allowed(interface: Interface, blocks: Mapping[str, Block], moves: Mapping[str, Array]) -> float:
    """Return the allowed gap of an interface from the moves of its two faces across it, m."""
    total = 0.0
    for name, normal in ((interface.minus, interface.normal), (interface.plus, -interface.normal)):
        shape = blocks[name].shape
        corners = [list(shape.faces[f]) for f in np.flatnonzero(shape.normals @ normal > np.cos(LARGEST_ANGLE))]
        if name in moves and corners:
            # The nearest of the faces in this direction: a step has several.
            off = [abs((shape.vertices[c].mean(axis=0) - interface.polygon.mean(axis=0)) @ normal) for c in corners]
            total += CORNER_OFF * float(np.abs(moves[name][corners[int(np.argmin(off))]] @ normal).max())
    return total
