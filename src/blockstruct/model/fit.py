"""Checks that blocks and interfaces fit together.

Detections and models use the same functions: a model accepts every interface of a detection with the same tolerances.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Generic, TypeVar

import numpy as np
from attrs import field, frozen

from blockstruct.arrays import NEGLIGIBLE, SLIGHT, Flags, Index
from blockstruct.errors import GeometryError
from blockstruct.geometry.faces import areas_on_bodies, common_areas
from blockstruct.geometry.neighbours import box_pairs
from blockstruct.geometry.overlap import overlapping_pairs
from blockstruct.geometry.polygon import perimeter
from blockstruct.geometry.tolerances import PARALLEL
from blockstruct.model.block import Block
from blockstruct.model.detection_report import DetectionReport
from blockstruct.model.interface import Interface
from blockstruct.vocabulary import counted, listed

T = TypeVar("T")

#: Largest penetration of two blocks by rounding, relative to the mean block size.
OVERLAP = 1e-5
#: Distances relative to the size of blocks: of parts that are drawn in one place, and of parts that probably should be,
#: apart by the width of a mortar joint.
NEAR, CLOSE = 1e-2, 0.1
#: Largest distance of an interface from its faces, relative to the smaller block: outside, half a wide joint; inside,
#: the penetration of joined blocks. A deeper interface would have a wrong lever.
OFF_FACE, BEHIND_FACE = 5e-2, NEAR
#: Largest share of an interface outside the faces of its blocks, and largest distance of a corner from them relative to
#: its area over half its perimeter, which is the width of a long interface: rounded coordinates.
OFF_OUTLINE, OFF_CORNER = 1e-2, 2.5e-2


@frozen
class Same(Generic[T]):
    """Blocks or interfaces that count as equal if their keys are, for functions that keep their last result.

    A study builds one geometry for many runs.
    """

    items: tuple[T, ...] = field(eq=False)
    key: tuple[Any, ...]


def same_blocks(blocks: Sequence[Block]) -> Same[Block]:
    """Return blocks that are equal to those of the same names, supports and shapes, whatever their materials."""
    key = ((b.name, b.fixed, b.shape.faces, b.shape.vertices.tobytes()) for b in blocks)
    return Same(tuple(blocks), tuple(key))


def overlaps(blocks: Sequence[Block], gap: float) -> list[tuple[int, int, float]]:
    """Return the blocks that overlap by more than contacts within a gap.

    Contacts are measured between the mean planes of faces. The deviation of corners from these planes is added to the
    gap.

    Parameters
    ----------
    blocks
        In the order of the indices in the result.
    gap
        Largest penetration of a contact, m.

    Returns
    -------
    list of (i, j, depth in m)
        ``i < j``. Pairs of supports are included.
    """
    off = [float(b.shape.deviations.max()) for b in blocks]
    return [(i, j, depth) for i, j, depth in _overlaps(same_blocks(blocks), gap) if depth > gap + off[i] + off[j]]


@lru_cache(maxsize=1)
def _overlaps(of: Same[Block], gap: float) -> list[tuple[int, int, float]]:
    return overlapping_pairs([b.shape for b in of.items], gap)


def check_overlaps(
    who: str, blocks: Sequence[Block], interfaces: Sequence[Interface], detection: DetectionReport | None, size: float
) -> None:
    """Refuse blocks that overlap, unless both are supports.

    Raises
    ------
    GeometryError
        If blocks overlap by more than rounding and the tolerance of the detection. The limit of joined blocks is a
        hundredth of the mean block size.
    """
    gap = max(detection.tolerances.gap if detection else 0.0, OVERLAP * size)
    joined = {frozenset((i.minus, i.plus)) for i in interfaces}
    pairs = [
        (a.name, b.name, depth)
        for a, b, depth in ((blocks[i], blocks[j], depth) for i, j, depth in overlaps(blocks, gap))
        if not ((a.fixed and b.fixed) or (depth <= NEAR * size and frozenset((a.name, b.name)) in joined))
    ]
    if pairs:
        named = [f"{a!r} and {b!r} by {depth:.3g} m" for a, b, depth in pairs]
        deepest = max(depth for *_, depth in pairs)
        # A larger tolerance finds interfaces so far off their faces that check_interfaces refuses them.
        slight = (
            f", or detect interfaces with a tolerance above {deepest:.3g} m (--gap for imported blocks) and give the "
            "whole result to the model (interfaces=found)"
        )
        msg = (
            f"{who}: overlapping blocks, {counted(len(pairs), 'pair')} in all (limit {gap:.3g} m): {listed(named)}; "
            f"move or cut the blocks{slight if deepest <= OFF_FACE * size else ''}"
        )
        raise GeometryError(msg)


def check_interfaces(
    who: str, blocks: Sequence[Block], interfaces: Sequence[Interface], detection: DetectionReport | None, size: float
) -> None:
    """Refuse interfaces that do not lie on faces of both blocks.

    The faces of the minus block look along the normal, the faces of the plus block against it. All corners lie on or
    next to both blocks, because they are the contact points. A polygon that is not plane may lie on several faces with
    different normals. For an interface from a detection, the gap tolerance also applies along the outline: the
    detection joins pieces of a rough joint over slits of this width.

    Raises
    ------
    GeometryError
        If an interface does not lie on its blocks, or covers a second interface.
    """
    if interfaces:
        # Whatever their joint materials.
        key = tuple((i.name, i.minus, i.plus, i.polygon.tobytes()) for i in interfaces)
        _check_interfaces(who, same_blocks(blocks), Same(tuple(interfaces), key), detection, size)


@lru_cache(maxsize=1)
def _check_interfaces(
    who: str, of: Same[Block], same: Same[Interface], detection: DetectionReport | None, size: float
) -> None:
    blocks, interfaces = of.items, same.items
    shapes = [b.shape for b in blocks]
    known = {b.name: k for k, b in enumerate(blocks)}
    ends = np.array([(known[i.minus], known[i.plus]) for i in interfaces])
    measured = _measured(interfaces, detection)
    extent = np.array([np.ptp(s.vertices, axis=0).max() for s in shapes])
    off = np.outer([OFF_FACE, BEHIND_FACE], extent[ends].min(axis=1)) + 2 * np.array([i.deviation for i in interfaces])
    slack = np.zeros(len(interfaces))
    around = np.array([perimeter(i.polygon) for i in interfaces])
    if detection is not None:
        gap = detection.tolerances.gap
        # A piece of a rough joint is within the gap of the plane. Its faces are within half the gap of the piece, along
        # their own normals.
        off = np.maximum(off, np.where(measured, 2 * gap / np.cos(detection.tolerances.angle), gap))
        slack[measured] = gap * around[measured]
    normals, areas = np.array([i.normal for i in interfaces]), np.array([i.area for i in interfaces])
    # On the minus blocks, then on the plus blocks.
    polygons, along = [i.polygon for i in interfaces] * 2, np.concatenate([normals, -normals])
    outside, inside = np.tile(off, 2)
    on_faces, corners = (
        values.reshape(2, -1) for values in areas_on_bodies(polygons, along, outside, inside, shapes, ends.T.ravel())
    )
    misplaced = np.argwhere(on_faces < (1 - OFF_OUTLINE) * areas - slack)
    if len(misplaced):
        end, k = misplaced[0]
        msg = (
            f"{who}: interface {interfaces[k].name!r} does not lie on a face of block "
            f"{blocks[ends[k, end]].name!r} that looks {('along', 'against')[end]} its normal: "
            f"{on_faces[end, k]:.3g} of its {areas[k]:.3g} m^2 do, up to {off[0, k]:.3g} m outside the block and "
            f"{off[1, k]:.3g} m inside; give a polygon on both blocks, counter-clockwise seen from the plus block, or "
            "the whole result of the detection (interfaces=found) if its tolerance was larger"
        )
        raise GeometryError(msg)
    # Forces act at the corners, whatever the area around them.
    reach = np.where(measured, np.inf, OFF_CORNER * 2 * areas / around)
    misplaced = np.argwhere(corners > reach)
    if len(misplaced):
        end, k = misplaced[0]
        msg = (
            f"{who}: interface {interfaces[k].name!r} has a corner {corners[end, k]:.3g} m outside its area on "
            f"block {blocks[ends[k, end]].name!r} (limit {reach[k]:.3g} m); give a polygon whose corners all lie on "
            "both blocks"
        )
        raise GeometryError(msg)
    _check_covered(who, interfaces, ends, measured, OFF_FACE * size)


def _measured(interfaces: Sequence[Interface], detection: DetectionReport | None) -> Flags:
    """Return which interfaces a detection accepted: same name, same blocks, same area."""
    accepted = {c.interface: c for c in detection.contacts if c.interface and not np.isnan(c.gap)} if detection else {}

    def same(interface: Interface) -> bool:
        c = accepted.get(interface.name)
        return (
            c is not None
            and (c.minus, c.plus) == (interface.minus, interface.plus)
            and abs(c.area - interface.area) <= NEGLIGIBLE * interface.area
        )

    return np.array([same(i) for i in interfaces], dtype=bool)


def _check_covered(who: str, interfaces: Sequence[Interface], ends: Index, measured: Flags, slack: float) -> None:
    """Refuse two interfaces of the same blocks on one area, unless the detection measured each on its own faces."""
    polygons = [interface.polygon for interface in interfaces]
    low, high = (np.array([f(p, axis=0) for p in polygons]) for f in (np.min, np.max))
    i, j = box_pairs(low - slack / 2, high + slack / 2)
    ends = np.sort(ends, axis=1)
    normals = np.array([interface.normal for interface in interfaces])
    same = np.all(ends[i] == ends[j], axis=1) & ~(measured[i] & measured[j])
    i, j = i[same], j[same]
    parallel = np.abs(np.einsum("ij,ij->i", normals[i], normals[j])) > PARALLEL
    i, j = i[parallel], j[parallel]
    areas = np.array([interface.area for interface in interfaces])
    covered = np.flatnonzero(common_areas(polygons, normals, i, j, slack) > SLIGHT * areas[i])
    if len(covered):
        k = covered[0]
        msg = (
            f"{who}: interfaces {interfaces[i[k]].name!r} and {interfaces[j[k]].name!r} cover the same area of one "
            "joint; remove one of them"
        )
        raise GeometryError(msg)
