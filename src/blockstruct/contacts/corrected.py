"""Joints between faces that were moved before detection, each allowed the moves of its own faces."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from blockstruct.contacts.detection import LARGEST_ANGLE, detect_interfaces
from blockstruct.model import Block, Detection, FoundContact, Interface, checked_tuple
from blockstruct.units import QuantityLike, to_quantity
from blockstruct.vocabulary import counted

Array = NDArray[np.float64]

#: By how much more than its planes, fitted anew, shows a corner of a face may be off: four times, in a quadrilateral.
CORNER_OFF = 4.0
#: Joints that a printed list names.
LISTED = 20


@dataclass(frozen=True, slots=True)
class CorrectedJoints:
    """Joints that are contact if each is allowed the moves of its own faces, and how to have them detected.

    Give :func:`blockstruct.detect_interfaces` the ``tolerance`` and the ``explicit`` interfaces.

    Attributes
    ----------
    closed : tuple of FoundContact
        Joints beyond the tolerance of detection, but within the moves of their own faces.
    tolerance : str or None
        With which exactly these are found beside those found by default; None if that would close others too, or
        if there are none.
    explicit : tuple of Interface
        Where no tolerance finds these alone: all interfaces of their blocks.
    """

    closed: tuple[FoundContact, ...]
    tolerance: str | None
    explicit: tuple[Interface, ...]

    def __str__(self) -> str:
        if not self.closed:
            return "no joint was opened by repairs of its own faces"
        rows = [f"  {c.minus} | {c.plus}: {c.gap:.3g} m, area {c.area:.3g} m^2" for c in self.closed[:LISTED]]
        if len(self.closed) > LISTED:
            rows.append(f"  and {len(self.closed) - LISTED} more")
        largest = max(abs(c.gap) for c in self.closed)
        how = "stated one by one" if self.tolerance is None else "found with a gap tolerance of as much"
        closed, their = counted(len(self.closed), "joint"), "its" if len(self.closed) == 1 else "their"
        head = f"{closed} closed that repairs of {their} own faces opened"
        return "\n".join([f"{head}, by up to {largest:.3g} m, {how}:", *rows])


def corrected_joints(
    blocks: Iterable[Block],
    joint_material: Any,
    moves: Mapping[str, ArrayLike],
    *,
    angle_tolerance: QuantityLike | None = None,
    area_tolerance: QuantityLike | None = None,
) -> CorrectedJoints:
    """Find the joints that were contact before vertices of their faces were moved.

    One corner of a quadrilateral that is off by d moves each of its corners by d/4 into their new plane. A joint may
    therefore gape, or its blocks penetrate, by four times the largest moves across it on its one face and on its other,
    beside what is rounding anyway. Joints further open than that were drawn open and stay so, whatever moved elsewhere.

    Parameters
    ----------
    blocks, joint_material, angle_tolerance, area_tolerance
        As for :func:`blockstruct.detect_interfaces`.
    moves
        How each vertex of a block was moved, shape (n, 3), m; of the blocks of which any was, as in
        :attr:`blockstruct.imports.Imported.moves`.

    Raises
    ------
    BlockstructError
        As :func:`blockstruct.detect_interfaces`.
    """
    known = {b.name: b for b in checked_tuple(blocks, Block, "corrected_joints: blocks")}
    moved = {name: np.asarray(move, dtype=float) for name, move in moves.items()}
    given = {"angle_tolerance": angle_tolerance, "area_tolerance": area_tolerance}
    limits: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    largest = CORNER_OFF * max((float(np.linalg.norm(m, axis=1).max()) for m in moved.values()), default=0.0)
    if not largest:
        return CorrectedJoints((), None, ())
    base = detect_interfaces(known.values(), joint_material, **limits).report.tolerances.gap

    def found_within(gap: float) -> tuple[Detection, list[FoundContact], list[FoundContact]]:
        """What is found with a tolerance; of what is beyond the base, the joints within their own moves and others."""
        found = detect_interfaces(known.values(), joint_material, to_quantity(gap, "length"), **limits)
        polygons = {i.name: i for i in found.interfaces}
        beyond = [c for c in found.report.contacts if c.interface and abs(c.gap) > base]
        own = [abs(c.gap) <= base + _allowed(polygons[c.interface], known, moved) for c in beyond]
        split = [[c for c, mine in zip(beyond, own, strict=True) if mine is which] for which in (True, False)]
        return found, split[0], split[1]

    wide, closed, _ = found_within(base + 2 * largest)
    if not closed:
        return CorrectedJoints((), None, ())
    # Rounding of the tolerance itself must not lose the joint that it is taken from.
    gap = (1 + 1e-9) * max(abs(c.gap) for c in closed)
    _, again, others = found_within(gap)
    if not others:
        return CorrectedJoints(tuple(again), f"{gap!r} m", ())
    pairs = {(c.minus, c.plus) for c in closed}
    stated = {c.interface for c in closed}
    stated |= {
        c.interface for c in wide.report.contacts if (c.minus, c.plus) in pairs and c.interface and abs(c.gap) <= base
    }
    return CorrectedJoints(tuple(closed), None, tuple(i for i in wide.interfaces if i.name in stated))


def _allowed(interface: Interface, blocks: Mapping[str, Block], moves: Mapping[str, Array]) -> float:
    """How far an interface may be open because the two faces that it lies on were moved across it, m."""
    total = 0.0
    for name, normal in ((interface.minus, interface.normal), (interface.plus, -interface.normal)):
        shape = blocks[name].shape
        corners = [list(shape.faces[f]) for f in np.flatnonzero(shape.normals @ normal > np.cos(LARGEST_ANGLE))]
        if name in moves and corners:
            # Of the faces that look that way, the nearest: a step has several.
            off = [abs((shape.vertices[c].mean(axis=0) - interface.polygon.mean(axis=0)) @ normal) for c in corners]
            total += CORNER_OFF * float(np.abs(moves[name][corners[int(np.argmin(off))]] @ normal).max())
    return total
