"""How blocks and interfaces fit together: what a detection accepts or reports, and what a model refuses.

Both ask the functions below, so that a model never refuses what a detection accepted with the same tolerances.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import GeometryError
from blockstruct.geometry import areas_on_bodies, box_pairs, common_areas, overlapping_pairs, perimeter
from blockstruct.model.block import Block
from blockstruct.model.detection_report import DetectionReport
from blockstruct.model.interface import Interface
from blockstruct.vocabulary import counted, listed

Array = NDArray[np.float64]

#: Penetration, relative to the mean block size, that is rounding, and that blocks joined by an interface may have.
OVERLAP, JOINED_OVERLAP = 1e-5, 1e-2
#: Distance of an interface from the faces it lies on, relative to the smaller block: before them, half of a wide joint;
#: behind them, what blocks that are joined may share. Deeper, the lever of what it carries is not that of the joint.
OFF_FACE, BEHIND_FACE = 5e-2, JOINED_OVERLAP
#: Share of the area of an interface that may lie beside the faces of its blocks, and distance of a corner beside them,
#: relative to its area over half of its perimeter, the width of a long one: rounded coordinates.
OFF_OUTLINE, OFF_CORNER = 1e-2, 2.5e-2
#: Share of an interface that another of the same blocks may cover, and cosine of the angle between such two.
COVERED, PARALLEL = 1e-3, 0.99
#: Agreement of an interface with the area that its detection measured.
SAME_AREA = 1e-6


def overlaps(blocks: Sequence[Block], gap: float) -> list[tuple[int, int, float]]:
    """Blocks that share more space than contacts within a gap explain.

    Contacts are measured between the mean planes of faces: what corners deviate from these comes on top.

    Parameters
    ----------
    blocks
        In the order in which the result counts them.
    gap
        Largest penetration of a contact, m.

    Returns
    -------
    list of (i, j, depth in m)
        ``i < j``, pairs of supports among them.
    """
    off = [float(b.shape.deviations.max()) for b in blocks]
    found = overlapping_pairs([b.shape for b in blocks], gap)
    return [(i, j, depth) for i, j, depth in found if depth > gap + off[i] + off[j]]


def check_overlaps(
    who: str, blocks: Sequence[Block], interfaces: Sequence[Interface], detection: DetectionReport | None, size: float
) -> None:
    """Refuse blocks that share space, but for two supports: nothing moves there.

    Raises
    ------
    GeometryError
        If blocks overlap by more than rounding and the tolerance of the detection; joined ones, by more than a
        hundredth of the mean block size.
    """
    gap = max(detection.tolerances.gap if detection else 0.0, OVERLAP * size)
    joined = {frozenset((i.minus, i.plus)) for i in interfaces}
    pairs = [
        (a.name, b.name, depth)
        for a, b, depth in ((blocks[i], blocks[j], depth) for i, j, depth in overlaps(blocks, gap))
        if not ((a.fixed and b.fixed) or (depth <= JOINED_OVERLAP * size and frozenset((a.name, b.name)) in joined))
    ]
    if pairs:
        named = [f"{a!r} and {b!r} by {depth:.3g} m" for a, b, depth in pairs]
        deepest = max(depth for *_, depth in pairs)
        msg = (
            f"{who}: overlapping blocks, {counted(len(pairs), 'pair')} in all (limit {gap:.3g} m): "
            f"{listed(named)}; move or cut the blocks, or detect interfaces with a tolerance above {deepest:.3g} m "
            "(--gap where blocks are imported) and give the model all of what was found (interfaces=found)"
        )
        raise GeometryError(msg)


def check_interfaces(
    who: str, blocks: Sequence[Block], interfaces: Sequence[Interface], detection: DetectionReport | None, size: float
) -> None:
    """Every polygon lies on faces of its minus block that look along its normal, and on faces of its plus block.

    Each of its corners lies on or next to both, for they are the contact points. The faces under a polygon that is not
    plane may be several, each looking another way. Where a detection measured an interface, its tolerance of the gap
    counts along the outline, too: pieces of a rough joint are made whole over slits as wide.

    Raises
    ------
    GeometryError
        If an interface does not lie on its blocks, or covers another one.
    """
    if not interfaces:
        return
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
        # Pieces of a rough joint lie within the gap of their plane, and their faces within half of it of them: along
        # the normals of these.
        off = np.maximum(off, np.where(measured, 2 * gap / np.cos(detection.tolerances.angle), gap))
        slack[measured] = gap * around[measured]
    normals, areas = np.array([i.normal for i in interfaces]), np.array([i.area for i in interfaces])
    # On the minus blocks, then on the plus blocks.
    polygons, along = [i.polygon for i in interfaces] * 2, np.concatenate([normals, -normals])
    before, behind = np.tile(off, 2)
    on_faces, corners = (
        found.reshape(2, -1) for found in areas_on_bodies(polygons, along, before, behind, shapes, ends.T.ravel())
    )
    beside = np.argwhere(on_faces < (1 - OFF_OUTLINE) * areas - slack)
    if len(beside):
        end, k = beside[0]
        msg = (
            f"{who}: interface {interfaces[k].name!r} does not lie on a face of block "
            f"{blocks[ends[k, end]].name!r} that looks {('along', 'against')[end]} its normal: "
            f"{on_faces[end, k]:.3g} of its {areas[k]:.3g} m^2 do, up to {off[0, k]:.3g} m before it and "
            f"{off[1, k]:.3g} m behind it; give a polygon on "
            "both blocks, counter-clockwise seen from the plus block, or all of what was detected (interfaces=found) "
            "if its tolerance was larger"
        )
        raise GeometryError(msg)
    # A corner bears whatever the area about it.
    reach = np.where(measured, np.inf, OFF_CORNER * 2 * areas / around)
    beside = np.argwhere(corners > reach)
    if len(beside):
        end, k = beside[0]
        msg = (
            f"{who}: interface {interfaces[k].name!r} has a corner {corners[end, k]:.3g} m beside what of it lies on "
            f"block {blocks[ends[k, end]].name!r} (limit {reach[k]:.3g} m); give a polygon whose corners all lie on "
            "both blocks"
        )
        raise GeometryError(msg)
    _check_covered(who, interfaces, ends, measured, OFF_FACE * size)


def _measured(interfaces: Sequence[Interface], detection: DetectionReport | None) -> NDArray[np.bool_]:
    """Which interfaces are those that a detection accepted: same name, same blocks, same area."""
    accepted = {c.interface: c for c in detection.contacts if c.interface and not np.isnan(c.gap)} if detection else {}

    def same(interface: Interface) -> bool:
        c = accepted.get(interface.name)
        return (
            c is not None
            and (c.minus, c.plus) == (interface.minus, interface.plus)
            and abs(c.area - interface.area) <= SAME_AREA * interface.area
        )

    return np.array([same(i) for i in interfaces], dtype=bool)


def _check_covered(
    who: str, interfaces: Sequence[Interface], ends: NDArray[np.int64], measured: NDArray[np.bool_], slack: float
) -> None:
    """No area of a joint belongs to two interfaces of the same blocks, unless each was measured on faces of its own."""
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
    covered = np.flatnonzero(common_areas(polygons, normals, i, j, slack) > COVERED * areas[i])
    if len(covered):
        k = covered[0]
        msg = (
            f"{who}: interfaces {interfaces[i[k]].name!r} and {interfaces[j[k]].name!r} cover the same area of one "
            "joint; remove one of them"
        )
        raise GeometryError(msg)
