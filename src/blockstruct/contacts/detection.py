"""Detection of interfaces between faces of blocks."""

import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array, Index
from blockstruct.errors import GeometryError, ModelError, UnknownNameError, shown
from blockstruct.geometry.coplanar import (
    FacePair,
    coplanar_face_pairs,
    crossed_faces,
    joined_pairs,
    parts_not_hidden,
    without_far_sides,
)
from blockstruct.geometry.neighbours import box_pairs, separations, unsupported
from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.model import (
    Block,
    Detection,
    DetectionReport,
    DetectionTolerances,
    FoundContact,
    Interface,
    JointMaterial,
    check_unrepeated,
    checked_tuple,
    lies_between,
)
from blockstruct.model.fit import CLOSE, NEAR, OVERLAP, Same, overlaps, same_blocks
from blockstruct.units import QuantityLike, si, to_quantity
from blockstruct.vocabulary import JointOrientation, counted, shortened

# Limits of detection: lengths relative to the mean block size, areas relative to its square, angles in radians.

#: Default angle tolerance, as a text.
ANGLE = "1 deg"
#: Largest angle of two reported faces, and of two faces that look at each other, radians.
ANGLE_REACH, LARGEST_ANGLE = math.radians(10), math.radians(45)


def detect_interfaces(
    blocks: Iterable[Block],
    joint_material: Any,
    tolerance: Any = None,
    *,
    angle_tolerance: Any = ANGLE,
    area_tolerance: Any = None,
    explicit: Iterable[Interface] = (),
) -> Detection:
    """Find every common area of the faces of two blocks.

    The search covers all faces, whatever the size and number of the blocks. A pair of blocks may have several
    interfaces. Pieces in one plane, as of triangulated faces, become one interface. Contacts between two fixed blocks
    are rejected. If a block thinner than the tolerance is between two others, their contact is rejected there.
    The normal of an interface points up or, if level, along +y or +x. The name of an interface is ``minus|plus``, from
    its blocks; further interfaces of the pair are ``minus|plus#2`` and so on. The report lists rejected contacts,
    close blocks and overlaps.

    Parameters
    ----------
    blocks
        Blocks with unique names.
    joint_material : JointMaterial, mapping or function
        Strength of the interfaces. For several materials, give a mapping from patterns, whose first match counts, such
        as ``{"base|*": dry, "bed": mortar, "*": dry}``. Patterns are ``"bed"``, ``"head"`` and ``"inclined"``, the
        names of two blocks in any order, and ``"*"`` for all other joints. Or give a function from an interface to its
        joint material.
    tolerance : quantity, length
        Largest gap, and largest penetration, between two faces in contact. The default is 1e-5 of the mean block size,
        the cube root of the mean volume of the free blocks.
    angle_tolerance : quantity, angle
        Largest angle between two faces in contact.
    area_tolerance : quantity, area
        Largest area of a contact that is rejected as a line or a point. The default is 1e-6 of the square of the mean
        block size.
    explicit
        Known interfaces. They are kept unchanged, and there is no search between their blocks.

    Raises
    ------
    ModelError
        If a joint has no joint material, a pattern of names fits no joint, a tolerance is not positive, or two blocks
        have the same name.
    GeometryError
        If the outline of a face crosses itself.
    UnknownNameError
        If an explicit interface names an unknown block.
    """
    who = "detect_interfaces"
    blocks = list(checked_tuple(blocks, Block, f"{who}: blocks"))
    known = checked_tuple(explicit, Interface, f"{who}: explicit")
    rule = joint_rule(joint_material, who)
    _check_names(blocks, known)
    for body, face in crossed_faces([b.shape for b in blocks]):
        msg = (
            f"block {blocks[body].name!r}: the outline of face {face} crosses itself; correct the order of its vertices"
        )
        raise GeometryError(msg)
    size = float(np.mean([b.volume for b in blocks if not b.fixed] or [1.0]) ** (1 / 3))
    limits = _tolerances(size, tolerance, angle_tolerance, area_tolerance)

    detection = _detection(same_blocks(blocks), size, limits, known)
    interfaces = (*known, *(i.with_joint_material(rule(i)) for i in detection.interfaces))
    check_rules_fit(joint_material, interfaces, who)
    return Detection(interfaces, detection.report)


@lru_cache(maxsize=1)
def _detection(same: Same[Block], size: float, limits: DetectionTolerances, known: tuple[Interface, ...]) -> Detection:
    """Return the interfaces beyond the known ones, without joint materials, and the report on all."""
    blocks = same.items
    explicit_pairs = {frozenset((i.minus, i.plus)) for i in known}
    interfaces: list[Interface] = []
    unknown = math.nan
    contacts = [
        FoundContact(i.minus, i.plus, i.name, "", unknown, unknown, i.area, i.orientation, False) for i in known
    ]
    taken = {i.name for i in known}
    for pair, hidden_by in _face_pairs([b.shape for b in blocks], size, limits):
        minus, plus = blocks[pair.minus], blocks[pair.plus]
        ends = (minus.name, plus.name)
        if frozenset(ends) in explicit_pairs:
            continue
        between = lies_between(blocks[k].name for k in hidden_by)
        name, reason, near_miss = "", between or _reason(pair, limits), False
        orientation = JointOrientation.of(float(pair.normal[2]))
        if minus.fixed and plus.fixed:
            if reason not in ("", "area"):
                continue
            reason = "supports"
        elif reason:
            near_miss = not between and not _reason(pair, limits, factor=2.0)
        else:
            name = _free_name("|".join(ends), taken)
            taken.add(name)
            interfaces.append(Interface(name, *ends, to_quantity(pair.polygon, "length"), unruled()))
        contacts.append(FoundContact(*ends, name, reason, pair.gap, pair.angle, pair.area, orientation, near_miss))
    return Detection(tuple(interfaces), _report(blocks, limits, contacts))


def _free_name(pair: str, taken: Collection[str]) -> str:
    """Return the first free name of an interface of a pair; names of blocks may contain ``|`` and ``#``."""
    return next(name for k in count(1) if (name := pair if k == 1 else f"{pair}#{k}") not in taken)


def _face_pairs(
    shapes: list[Polyhedron], size: float, limits: DetectionTolerances
) -> list[tuple[FacePair, tuple[int, ...]]]:
    """Return close faces that look at each other, each with the blocks in between.

    Pieces of one contact are joined.
    """
    rounding = min(limits.gap, OVERLAP * size)
    reach, angle = max(2 * limits.gap, NEAR * size), max(2 * limits.angle, ANGLE_REACH)
    pairs = coplanar_face_pairs(shapes, reach, angle, rounding=rounding)
    pairs = without_far_sides([p for p in pairs if p.area > ROUNDING * size**2], rounding)
    apart = [p for p in pairs if _reason(p, limits) not in ("", "area")]
    met = joined_pairs([p for p in pairs if _reason(p, limits) in ("", "area")], limits.gap, limits.angle, rounding)
    judged = parts_not_hidden(met, pairs, rounding, limits.area) + [(p, ()) for p in apart]
    return sorted(judged, key=lambda p: (p[0].minus, p[0].plus, *p[0].polygon[0]))


def _reason(pair: FacePair, limits: DetectionTolerances, factor: float = 1.0) -> str:
    """Return why two faces are not in contact, with all tolerances times a factor; empty if they are in contact."""
    if pair.angle > factor * limits.angle:
        return "angle"
    if abs(pair.gap) > factor * limits.gap:
        return "gap" if pair.gap > 0 else "penetration"
    return "area" if pair.area <= limits.area / factor else ""


def _report(blocks: Sequence[Block], limits: DetectionTolerances, contacts: Sequence[FoundContact]) -> DetectionReport:
    names = [b.name for b in blocks]
    index = {name: k for k, name in enumerate(names)}
    accepted = [c for c in contacts if not c.reason]
    joined = np.array([(index[c.minus], index[c.plus]) for c in accepted], dtype=np.int64)
    touched = {end for c in accepted for end in (c.minus, c.plus)}
    met = np.array([sorted((index[c.minus], index[c.plus])) for c in contacts], dtype=np.int64).reshape(-1, 2)
    shared = overlaps(blocks, limits.gap)
    met = np.concatenate([met, np.array([o[:2] for o in shared], dtype=np.int64).reshape(-1, 2)])
    return DetectionReport(
        tolerances=limits,
        contacts=tuple(contacts),
        overlaps=tuple((names[i], names[j], depth) for i, j, depth in shared),
        nonplanar_faces=tuple(
            (b.name, f, float(b.shape.deviations[f])) for b in blocks for f in b.shape.nonplanar_faces
        ),
        floating=tuple(names[k] for k in unsupported(np.array([bool(b.held) for b in blocks], dtype=bool), joined)),
        untouched=tuple(name for name in names if name not in touched),
        close=tuple((names[i], names[j], distance) for i, j, distance in _close(blocks, limits, met)),
    )


def _close(blocks: Sequence[Block], limits: DetectionTolerances, met: Index) -> list[tuple[int, int, float]]:
    """Return close pairs of blocks without common faces, except two supports."""
    if not blocks:
        return []
    shapes = [b.shape for b in blocks]
    low, high = (np.array([f(s.vertices, axis=0) for s in shapes]) for f in (np.min, np.max))
    i, j = box_pairs(low - limits.close / 2, high + limits.close / 2)
    fixed = np.array([b.fixed for b in blocks])
    far = ~np.isin(i * len(blocks) + j, met[:, 0] * len(blocks) + met[:, 1]) & ~(fixed[i] & fixed[j])
    i, j = i[far], j[far]
    distance = separations(shapes, i, j)
    keep = (distance >= -limits.gap) & (distance <= limits.close)
    return list(zip(i[keep].tolist(), j[keep].tolist(), np.maximum(distance[keep], 0.0).tolist(), strict=True))


def _check_names(blocks: Sequence[Block], explicit: Sequence[Interface]) -> None:
    check_unrepeated((b.name for b in blocks), "detect_interfaces: block")
    names = {b.name for b in blocks}
    for interface in explicit:
        for end in (interface.minus, interface.plus):
            if end not in names:
                msg = f"detect_interfaces: explicit interface {interface.name!r} joins the unknown block {end!r}"
                raise UnknownNameError(msg)


def _tolerances(size: float, gap: Any, angle: Any, area: Any) -> DetectionTolerances:
    gap = to_quantity(OVERLAP * size, "length") if gap is None else gap
    area = to_quantity(NEGLIGIBLE * size**2, "area") if area is None else area
    values = []
    for what, limit, dimension, unit in (
        ("tolerance", gap, "length", "m"),
        ("angle_tolerance", angle, "angle", "rad"),
        ("area_tolerance", area, "area", "m^2"),
    ):
        value = si(limit, dimension, f"detect_interfaces: {what}")
        if value <= 0:
            msg = f"detect_interfaces: {what} {value:.6g} {unit}; give a value above zero"
            raise ModelError(msg)
        values.append(value)
    if values[1] > LARGEST_ANGLE:
        msg = (
            f"detect_interfaces: angle_tolerance {math.degrees(values[1]):.4g} deg is above "
            f"{math.degrees(LARGEST_ANGLE):.4g} deg; give a smaller angle, at which the faces look at each other"
        )
        raise ModelError(msg)
    gap, angle, area = values
    return DetectionTolerances(gap, angle, area, close=max(2 * gap, CLOSE * size))


Rule = Callable[[Interface], JointMaterial]


@cache
def unruled() -> JointMaterial:
    """Return a placeholder for the joint material that a rule assigns later."""
    return JointMaterial("without a rule", 0.0)


def joint_rule(material: Any, who: str) -> Rule:
    """Return a function from an interface to its joint material.

    Parameters
    ----------
    material
        A joint material for all joints; a function from an interface to its joint material; or a mapping from patterns
        to joint materials, whose first match counts. Patterns are ``"bed"``, ``"head"`` or ``"inclined"``
        (:class:`blockstruct.vocabulary.JointOrientation`), the names of two blocks in any order with ``*`` for any
        text, such as ``"base|*"``, and ``"*"`` for all other joints.
    who
        Name of the caller in error messages.

    Raises
    ------
    ModelError
        If the argument is of another kind, or, when the rule is applied, if no pattern fits a joint.

    Examples
    --------
    >>> from blockstruct.model import JointMaterial
    >>> lime, dry = JointMaterial("lime", 0.7), JointMaterial("dry", 0.6)
    >>> rule = joint_rule({"base|*": dry, "bed": lime, "*": dry}, "wall")
    >>> square = "m", [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> from blockstruct.units import Q_
    >>> polygon = Q_(square[1], square[0])
    >>> [rule(Interface("i", "1.1", plus, polygon, dry)).name for plus in ("2.1", "base")]
    ['lime', 'dry']
    """
    if isinstance(material, JointMaterial):
        return lambda interface: material
    if isinstance(material, Mapping) and material:
        for pattern, one in material.items():
            _check_pattern(pattern, one, who)
        return lambda interface: _first_match(material, interface, who)
    if callable(material) and not isinstance(material, type):
        return lambda interface: _call_rule(material, interface, who)
    msg = (
        f"{who}: joint_material is {shown(material)}; give a JointMaterial, a mapping such as "
        "{'bed': mortar, '*': dry}, or a function from an interface to its JointMaterial"
    )
    raise ModelError(msg)


def _check_pattern(pattern: Any, material: Any, who: str) -> None:
    if not isinstance(pattern, str) or not (pattern in {*JointOrientation, "*"} or pattern.count("|") == 1):
        msg = (
            f"{who}: {shown(pattern)} is not a pattern of joints; write "
            f"{', '.join(repr(o.value) for o in JointOrientation)}, two block names as in 'base|*', "
            "or '*' for all other joints"
        )
        raise ModelError(msg)
    if not isinstance(material, JointMaterial):
        msg = f"{who}: the pattern {shown(pattern)} gives {shown(material)}; give a JointMaterial"
        raise ModelError(msg)


def _first_match(rules: Mapping[str, JointMaterial], interface: Interface, who: str) -> JointMaterial:
    for pattern, material in rules.items():
        if pattern == interface.orientation or _names_fit(pattern, interface):
            return material
    msg = (
        f"{who}: no pattern of joint_material fits interface {interface.name!r} ({interface.orientation}); "
        f"the patterns are {', '.join(map(repr, rules))}; add '*' for all other joints"
    )
    raise ModelError(msg)


def _names_fit(pattern: str, interface: Interface) -> bool:
    # Only * is special: names may contain any other character.
    wanted = re.compile(".*".join(map(re.escape, pattern.split("*"))), re.DOTALL)
    ends = (interface.minus, interface.plus)
    return any(wanted.fullmatch("|".join(names)) for names in (ends, ends[::-1]))


def check_rules_fit(material: Any, interfaces: Iterable[Interface], who: str) -> None:
    """Refuse patterns of block names without a match: with a misspelt name, another pattern would apply.

    Raises
    ------
    ModelError
        If the mapping has such a pattern.
    """
    interfaces = list(interfaces)
    if not isinstance(material, Mapping) or not interfaces:
        return
    for pattern in material:
        if "|" in pattern and not any(_names_fit(pattern, i) for i in interfaces):
            msg = (
                f"{who}: no interface fits the pattern {shown(pattern)} of joint_material; correct its names (as in "
                f"{interfaces[0].name!r}) or remove it"
            )
            raise ModelError(msg)


def _call_rule(function: Callable[[Interface], Any], interface: Interface, who: str) -> JointMaterial:
    material = function(interface)
    if not isinstance(material, JointMaterial):
        result = f"{shown(material)} for {interface.name!r}"
        msg = f"{who}: the function for joint_material returns {result}; return a JointMaterial"
        raise ModelError(msg)
    return material


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
        joints = [f"{c.minus} | {c.plus}: {c.gap:.3g} m, area {c.area:.3g} m^2" for c in self.closed]
        largest = max(abs(c.gap) for c in self.closed)
        method = "listed as explicit interfaces" if self.tolerance is None else "detected with this gap tolerance"
        closed, their = counted(len(self.closed), "joint"), "its" if len(self.closed) == 1 else "their"
        head = f"{closed} closed that repairs of {their} faces opened"
        return "\n".join([f"{head}, by up to {largest:.3g} m, {method}:", *(f"  {row}" for row in shortened(joints))])


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
