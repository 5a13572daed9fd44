"""Walls with openings, sidewalls and buttresses, rooms, and piers with spandrels."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
import shapely
from attrs import field, frozen

from blockstruct.arrays import ROUNDING
from blockstruct.errors import ModelError, check_known, shown
from blockstruct.model import Block, Material, checked_tuple
from blockstruct.model.fields import (
    LEFT_OUT,
    LENGTH,
    ModelObject,
    check_total,
    checked_count,
    has_name,
    is_truth,
    items,
    label,
    named_arguments,
    positive_length,
    scalar,
    store,
)
from blockstruct.structures.bond import Bond, Panel, Pieces
from blockstruct.structures.builder import builder, count, length, lengths, optional_length
from blockstruct.structures.openings import QUARTER, AnyOpening, Opening, check_openings
from blockstruct.structures.rubble import Rubble, RubbleJoints
from blockstruct.units import QuantityLike, to_quantity


@frozen(repr=False, field_transformer=named_arguments)
class Sidewall(ModelObject):
    """A wall along +y at the back of a wall along x.

    Parameters
    ----------
    name
        Prefix of its units.
    at : quantity, length
        Start of its thickness along the wall: zero for a return at the left end, length minus thickness of the wall for
        a return at the right end (L), a value in between for a T.
    length : quantity, length
        Length from the back of the wall.
    openings
        Openings; their ``start`` is measured from the back of the wall.
    bonded
        Whether every second course extends through the wall to its face. Otherwise the sidewall butts against the wall.
    """

    behind: ClassVar[bool] = True

    name: str = field(validator=has_name)
    at: float = field(converter=scalar, metadata=LENGTH)
    length: float = field(converter=length, metadata=LENGTH)
    openings: tuple[AnyOpening, ...] = field(default=(), converter=items, metadata={"kind": AnyOpening})
    bonded: bool = field(default=True, validator=is_truth)

    def width_in(self, wall: Bond) -> float:
        """Return the width along a wall, which is its thickness, m."""
        return wall.thickness

    def panel(self, wall: Bond, heads: Sequence[float], rubble: RubbleJoints | None) -> Panel:
        """Return the panel of the sidewall, from the back of a wall with courses up to ``heads``."""
        name, t = f"{self.name}.", wall.thickness
        axes = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [self.at, t, 0.0]])
        extent, openings = (0.0, self.length), self.openings
        if not self.bonded:
            return Panel(name, wall, axes, heads, extent, openings, rubble=rubble)
        # A whole unit starts at the face of the wall, or half a unit from the face if a joint would otherwise be near
        # the back. A unit then joins both walls.
        beyond = t / wall.unit_length - np.floor(t / wall.unit_length)
        origin = -t if QUARTER <= beyond <= 1 - QUARTER else -t + wall.unit_length / 2
        return Panel(name, wall, axes, heads, extent, openings, back=t, origin=origin, shifts_odd=True, rubble=rubble)


@frozen(repr=False, field_transformer=named_arguments)
class Buttress(ModelObject):
    """A pier in front of or at the back of a wall along x, vertical or battered.

    Parameters
    ----------
    name
        Prefix of its units.
    at, width : quantity, length
        Start along the wall, and width.
    courses
        Number of courses.
    projection : quantity, length
        Projection from the wall at the foot.
    top_projection : quantity, length
        Projection at the top; equal to ``projection`` by default. The outer face is plane.
    behind
        True: at the back of the wall (+y). False: in front of its face (−y).
    bonded
        Whether every second course extends through the wall. Otherwise the buttress butts against the wall.
    """

    name: str = field(validator=has_name)
    at: float = field(converter=scalar, metadata=LENGTH)
    width: float = field(converter=length, metadata=LENGTH)
    courses: int = field(converter=count, metadata={"least": 1})
    projection: float = field(converter=length, metadata=LENGTH)
    top_projection: float = field(default=LEFT_OUT, converter=optional_length, metadata=LENGTH)
    behind: bool = field(default=False, validator=is_truth)
    bonded: bool = field(default=True, validator=is_truth)

    def __attrs_post_init__(self) -> None:
        if self.top_projection is None:
            store(self, top_projection=self.projection)
        if self.top_projection > self.projection * (1 + ROUNDING):
            msg = (
                f"{label(self)}: top_projection {self.top_projection:.6g} m is beyond the projection at the foot, "
                f"{self.projection:.6g} m; give at most that"
            )
            raise ModelError(msg)

    @property
    def length(self) -> float:
        """Largest projection from the wall, m."""
        return self.projection

    def width_in(self, wall: Bond) -> float:
        """Return the width along a wall, m."""
        return self.width

    def panel(self, wall: Bond, heads: Sequence[float], rubble: RubbleJoints | None) -> Panel:
        """Return the panel of the buttress, from the face or the back of a wall with courses up to ``heads``."""
        outwards, foot = (1.0, wall.thickness) if self.behind else (-1.0, 0.0)
        height = self.courses * wall.course_height
        # In courses that extend through the wall, half of a unit is in the wall.
        back = -wall.thickness
        slope = [(back, 0.0), (self.projection, 0.0), (self.top_projection, height), (back, height)]
        return Panel(
            name=f"{self.name}.",
            bond=Bond(wall.unit_length, wall.course_height, self.width),
            axes=np.array([[0.0, outwards, 0.0], [1.0, 0.0, 0.0], [self.at, foot, 0.0]]),
            heads=heads[: self.courses],
            extent=(0.0, self.projection),
            back=wall.thickness if self.bonded else 0.0,
            within=shapely.Polygon(slope),
            rubble=rubble,
        )


Side = Sidewall | Buttress


def check_sides(sides: Sequence[Side], openings: Sequence[AnyOpening], end: float, courses: int, wall: Bond) -> None:
    """Refuse sidewalls and buttresses off the wall or too high, or that overlap each other or an opening."""
    slack = ROUNDING * wall.thickness
    for k, side in enumerate(sides):
        width, place = side.width_in(wall), "at the back of" if side.behind else "in front of"
        who = f"wall: {label(side)} at {side.at:.6g} m"
        if not -slack <= side.at <= end - width + slack:
            msg = f"{who} is not {place} the wall; give a position between 0 m and {end - width:.6g} m"
            raise ModelError(msg)
        for other in sides[:k]:
            beyond = other.at + other.width_in(wall)
            if side.name == other.name or (side.at < beyond - slack and other.at < side.at + width - slack):
                msg = f"{who} has the name or the position of {other.name!r} at {other.at:.6g} m; rename or move it"
                raise ModelError(msg)
        for opening in openings:
            low, _, high, _ = opening.outline(wall.course_height).bounds
            if low < side.at + width - slack and side.at < high - slack:
                msg = f"{who} is {place} the opening at {opening.start:.6g} m; move one of them"
                raise ModelError(msg)
        if isinstance(side, Sidewall):
            check_openings(side.openings, side.length, wall.course_height, courses, label(side))
        elif side.courses > courses:
            msg = f"{who} has {side.courses} courses, the wall {courses}; give at most as many as the wall has"
            raise ModelError(msg)


def gable_levels(length: float, foot: float, rise: float, course: float, smallest: float) -> list[float]:
    """Return the upper sides of the courses of a gable; the last is the apex.

    A piece smaller than the ``smallest`` area at the apex is joined to the course below.
    """
    # The triangle above z has the area (apex − z)² L / (2 rise).
    tip = float(np.sqrt(2 * rise * smallest / length))
    number = max(1, int(np.floor((rise - tip) / course * (1 + ROUNDING))) + 1)
    return [*(foot + k * course for k in range(1, number)), foot + rise]


#: Direction along a wall, direction through it, and its origin.
_FRONT = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])


@builder
def wall(
    *,
    length: QuantityLike,
    courses: int | None = None,
    height: QuantityLike | None = None,
    unit_length: QuantityLike | None = None,
    unit_height: QuantityLike,
    thickness: QuantityLike,
    material: Material,
    openings: Sequence[AnyOpening] = (),
    sidewalls: Sequence[Sidewall] = (),
    buttresses: Sequence[Buttress] = (),
    gable: QuantityLike | None = None,
    rubble: Rubble | None = None,
    leaves: int = 1,
    header_every: int | None = None,
    base: bool = True,
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of a wall along x in running bond or of rubble, with openings, sidewalls and buttresses.

    Every second course is shifted by half a unit. A joint that would leave less than a quarter of a unit at an end, at
    an opening, at a slope or at the face of a bonded sidewall is dropped, and the piece is joined to its neighbour.
    Units at rings of voussoirs and under slopes are cut to fit exactly.

    Parameters
    ----------
    length : quantity, length
        Length along x from x = 0.
    courses
        Number of courses, from z = 0.
    height : quantity, length
        Height of all courses, in place of their number: a multiple of ``unit_height``.
    unit_length, unit_height : quantity, length
        Length of a whole unit (for rubble, by default, the mean of its limits), and height of every course.
    thickness : quantity, length
        Thickness along y from y = 0, of the sidewalls, too.
    material
        Material of all blocks.
    openings
        Openings of the wall along x: :class:`Opening` with a lintel or an arch, or
        :class:`blockstruct.structures.RoundOpening`.
    sidewalls
        Walls along +y at the ends (L) or in between (T).
    buttresses
        :class:`blockstruct.structures.Buttress` in front or at the back of the wall.
    gable : quantity, length
        Rise of a gable over the last course, with its apex in the middle of the wall. By default there is no gable.
    rubble : blockstruct.structures.Rubble
        Units of random lengths in the wall, its sidewalls and its buttresses. By default the wall has a regular bond.
    leaves
        Number of leaves through the thickness, with head joints shifted by half a unit.
    header_every
        Interval of header courses: units half as long, through all leaves. By default there are no header courses.
    base
        Whether to add a fixed block ``base`` under the whole plan, one course high.
    prefix
        Start of all names. The k-th unit of the j-th course is ``j.k``, lintels are ``j.lintel1`` …, the k-th voussoir
        of the i-th opening is ``voussoir i.k``. Units of a sidewall or a buttress are ``name.j.k``. Names of units in
        leaves end in ``a``, ``b`` … from the face.

    Raises
    ------
    ModelError
        If an opening is outside its wall, off its bed joints or at a sidewall; if two lintels overlap; if a sidewall or
        a buttress is off the wall, overlaps another or repeats its name; or if rubble cannot fill a course.

    Examples
    --------
    >>> tuff = Material("tuff", "12 kN/m^3")
    >>> size = {"unit_length": "40 cm", "unit_height": "20 cm", "thickness": "20 cm", "material": tuff}
    >>> from blockstruct.structures import Opening
    >>> door = Opening(start="1.2 m", sill="0 m", width="0.8 m", height="1.6 m")
    >>> sides = [Sidewall("left", at="0 m", length="2 m"), Sidewall("right", at="3 m", length="2 m")]
    >>> blocks = wall(length="3.2 m", courses=12, openings=[door], sidewalls=sides, **size)
    >>> blocks[0].name, blocks[1].name, blocks[-1].name
    ('base', '1.1', 'right.12.6')
    >>> round(sum(b.volume for b in blocks[1:]) / 0.2, 6) == 2 * 2 * 2.4 + 3.2 * 2.4 - 0.8 * 1.6
    True
    """
    reach = positive_length(length, "wall: length")
    bond, number = bond_of(
        "wall", courses, height, unit_length, unit_height, thickness, leaves=leaves, headers=header_every, rubble=rubble
    )
    course, t = bond.course_height, bond.thickness
    front = checked_tuple(openings, AnyOpening, "wall: openings")
    sides = checked_tuple(sidewalls, Sidewall, "wall: sidewalls")
    sides += checked_tuple(buttresses, Buttress, "wall: buttresses")
    heads, within = gable_of(reach, number, gable, bond, "wall")
    check_openings(front, reach, course, number, "wall", within)
    check_sides(sides, front, reach, number, bond)
    check_units(len(heads) * (reach + sum(s.length for s in sides)), bond, rubble, "wall")

    laid = Pieces(prefix, material, course)
    if base:
        before, behind = (max((s.length for s in sides if s.behind is at), default=0.0) for at in (False, True))
        laid.box("base", (0.0, -before, -course), (reach, before + t + behind, course), fixed=True)
    panels = [side.panel(bond, heads[:number], joints_of(rubble, side.name)) for side in sides]
    # In every second course the wall leaves room for the sidewalls and buttresses that extend through it.
    ends = [(s.at, s.at + s.width_in(bond), len(p.heads)) for s, p in zip(sides, panels, strict=True) if s.bonded]
    laid.panel(Panel("", bond, _FRONT, heads, (0.0, reach), front, ends, within=within, rubble=joints_of(rubble, "")))
    for panel in panels:
        laid.panel(panel)
    return laid.blocks


def bond_of(
    who: str,
    courses: int | None,
    height: QuantityLike | None,
    unit_length: QuantityLike | None,
    unit_height: QuantityLike,
    thickness: QuantityLike,
    *,
    leaves: int,
    headers: int | None,
    rubble: Rubble | None,
) -> tuple[Bond, int]:
    """Return the bond of a wall and the number of its courses, from the arguments of a builder."""
    t, course = lengths(who, thickness=thickness, unit_height=unit_height)
    number = _courses(who, courses, height, course)
    if rubble is not None and not isinstance(rubble, Rubble):
        msg = f"{who}: rubble is {shown(rubble)}; give a Rubble"
        raise ModelError(msg)
    every = None if headers is None else checked_count(headers, 2, f"{who}: header_every")
    unit = _unit(who, unit_length, rubble)
    return Bond(unit, course, t, checked_count(leaves, 1, f"{who}: leaves"), every), number


def joints_of(rubble: Rubble | None, name: str) -> RubbleJoints | None:
    """Return the joints of a panel of rubble; None for a regular bond."""
    return None if rubble is None else RubbleJoints(rubble, name)


def check_units(length: float, bond: Bond, rubble: Rubble | None, who: str) -> None:
    """Refuse more units than a model can have, for the length of all courses, m."""
    shortest = min(bond.unit_length, rubble.shortest if rubble else math.inf)
    check_total(length * bond.leaves / shortest, who)


def gable_of(length: float, number: int, rise: QuantityLike | None, bond: Bond, who: str) -> tuple[list[float], Any]:
    """Return the upper sides of all courses of a wall, m, and its polygon, which is None without a gable."""
    course, top = bond.course_height, number * bond.course_height
    heads = [k * course for k in range(1, number + 1)]
    if rise is None:
        return heads, None
    above = positive_length(rise, f"{who}: gable")
    heads += gable_levels(length, top, above, course, bond.smallest)
    return heads, shapely.Polygon([(0, 0), (length, 0), (length, top), (length / 2, top + above), (0, top)])


def _unit(who: str, unit_length: QuantityLike | None, rubble: Rubble | None) -> float:
    """Return the length of a whole unit, m; by default the mean of the limits of rubble."""
    if unit_length is not None:
        return positive_length(unit_length, f"{who}: unit_length")
    if rubble is None:
        msg = f"{who}: unit_length is missing; give the length of a whole unit, or rubble"
        raise ModelError(msg)
    return float(rubble.shortest + rubble.longest) / 2


def _courses(who: str, courses: int | None, height: QuantityLike | None, course: float) -> int:
    """Return the number of courses, given as such or as the height of the wall."""
    if (courses is None) == (height is None):
        msg = f"{who}: give the number of courses or the height, one of them"
        raise ModelError(msg)
    if height is None:
        return checked_count(courses, 1, f"{who}: courses")
    number = positive_length(height, f"{who}: height") / course
    if not math.isclose(number, round(number)):
        msg = (
            f"{who}: height {shown(height)} is {number:.4g} courses of {course:.4g} m; give a whole number of them, "
            f"such as {math.ceil(number) * course:.6g} m, or another unit_height"
        )
        raise ModelError(msg)
    return checked_count(round(number), 1, f"{who}: courses")


#: The walls of a room: along x at y = 0 and at the other end of y, then along y at x = 0 and at the other end of x.
WALLS = ("front", "back", "left", "right")


@builder
def room(
    *,
    length: QuantityLike,
    width: QuantityLike,
    courses: int | None = None,
    height: QuantityLike | None = None,
    unit_length: QuantityLike | None = None,
    unit_height: QuantityLike,
    thickness: QuantityLike,
    material: Material,
    openings: Mapping[str, Sequence[AnyOpening]] = MappingProxyType({}),
    gable: QuantityLike | None = None,
    bonded: bool = True,
    rubble: Rubble | None = None,
    leaves: int = 1,
    header_every: int | None = None,
    base: bool = True,
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of four walls around a room: ``front``, ``back``, ``left`` and ``right``.

    Front and back are along x, at the least and the largest y; left and right are along y, at the least and the largest
    x. Bonded walls take turns to extend through their corners, and no joint there is within a quarter of a unit of the
    face of the other wall, so that units join both.

    Parameters
    ----------
    length, width : quantity, length
        Size of the plan along x and along y from x = y = 0, with the thickness of the walls.
    courses, height, unit_length, unit_height
        As for :func:`wall`.
    thickness : quantity, length
        Thickness of all walls.
    material
        Material of all blocks.
    openings : mapping of str to sequence
        Openings of each wall, by its name. Their ``start`` is a position on x in front and back, and on y in left and
        right.
    gable : quantity, length
        Rise of the gables of front and back, with their apex in the middle. By default there are no gables.
    bonded
        Whether the corners are bonded. Otherwise left and right butt against front and back.
    rubble, leaves, header_every
        As for :func:`wall`.
    base
        Whether to add a fixed block ``base`` under the whole plan, one course high.
    prefix
        Start of all names. The k-th unit of the j-th course of the front is ``front.j.k``; others as for :func:`wall`.

    Raises
    ------
    ModelError
        If the walls leave no room, or an opening is outside its wall, off its bed joints or in a corner.
    UnknownNameError
        If openings are given for another name.

    Examples
    --------
    >>> tuff = Material("tuff", "16 kN/m^3")
    >>> size = {"unit_length": "1 m", "unit_height": "0.5 m", "thickness": "0.5 m", "material": tuff}
    >>> from blockstruct.structures import Opening
    >>> door = Opening(start="1.5 m", sill="0 m", width="1 m", height="2 m")
    >>> blocks = room(length="4 m", width="3 m", height="3 m", openings={"front": [door]}, **size)
    >>> round(sum(b.volume for b in blocks if not b.fixed), 9) == (4 * 3 - 3 * 2) * 3 - 1 * 2 * 0.5
    True
    """
    bond, number = bond_of(
        "room", courses, height, unit_length, unit_height, thickness, leaves=leaves, headers=header_every, rubble=rubble
    )
    along, across = lengths("room", length=length, width=width)
    t, course = bond.thickness, bond.course_height
    if min(along, across) <= 2 * t * (1 + ROUNDING):
        msg = f"room: walls of {t:.6g} m leave no room in {along:.6g} × {across:.6g} m; give a larger plan"
        raise ModelError(msg)
    for name in openings:
        check_known(name, WALLS, "room: no wall")
    x, y = np.eye(3)[:2]
    beyond, corners = (t, [(0.0, t, number), (along - t, along, number)]) if bonded else (0.0, [])
    laid = Pieces(prefix, material, course)
    if base:
        laid.box("base", (0.0, 0.0, -course), (along, across, course), fixed=True)
    panels = []
    for name in WALLS:
        is_side, is_far, who = name in WALLS[2:], name in ("back", "right"), f"room: {name} wall"
        end, other = (across, along) if is_side else (along, across)
        heads, within = gable_of(end, number, None if is_side else gable, bond, who)
        holes = checked_tuple(openings.get(name, ()), AnyOpening, who)
        check_openings(holes, end, course, number, who, within)
        for hole in holes:
            low, _, high, _ = hole.outline(course).bounds
            if low < t * (1 - ROUNDING) or high > end - t * (1 - ROUNDING):
                msg = (
                    f"{who}: the opening from {low:.6g} to {high:.6g} m is in a corner; place it between {t:.6g} and "
                    f"{end - t:.6g} m"
                )
                raise ModelError(msg)
        u, v = (y, x) if is_side else (x, y)
        panels.append(
            Panel(
                name=f"{name}.",
                bond=bond,
                axes=np.array([u, v, (other - t if is_far else 0.0) * v]),
                heads=heads,
                extent=(t, across - t) if is_side else (0.0, along),
                openings=holes,
                crossings=() if is_side else corners,
                # In every second course the side walls take the corners.
                back=beyond * is_side,
                ahead=beyond * is_side,
                shifts_odd=is_side,
                within=within,
                rubble=joints_of(rubble, name),
            )
        )
    check_units(sum(len(p.heads) * (p.extent[1] - p.extent[0]) for p in panels), bond, rubble, "room")
    for panel in panels:
        laid.panel(panel)
    return laid.blocks


@builder
def pier_spandrel(
    *,
    bays: int,
    storeys: int,
    pier_width: QuantityLike,
    opening_width: QuantityLike,
    opening_height: QuantityLike,
    spandrel_height: QuantityLike,
    unit_length: QuantityLike,
    unit_height: QuantityLike,
    thickness: QuantityLike,
    material: Material,
    base: bool = True,
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of a façade with equal openings between piers, storey on storey, in running bond.

    Parameters
    ----------
    bays, storeys
        Number of openings along x and along z. There are ``bays + 1`` piers.
    pier_width, opening_width : quantity, length
        Widths along x.
    opening_height, spandrel_height : quantity, length
        Heights along z, multiples of the course height. The lowest openings begin on the ground. Lintels extend half a
        unit into the piers, or half of a pier that is narrower than a unit.
    unit_length, unit_height, thickness, material, base, prefix
        As for :func:`wall`.

    Raises
    ------
    ModelError
        If a height is not a multiple of the course height.

    Examples
    --------
    >>> tuff = Material("tuff", "12 kN/m^3")
    >>> blocks = pier_spandrel(
    ...     bays=2, storeys=2, pier_width="1 m", opening_width="1 m", opening_height="1.2 m", spandrel_height="0.6 m",
    ...     unit_length="0.5 m", unit_height="0.2 m", thickness="0.25 m", material=tuff,
    ... )
    >>> [b.name for b in blocks if "lintel" in b.name]
    ['7.lintel1', '7.lintel2', '16.lintel1', '16.lintel2']
    """
    n, m = checked_count(bays, 1, "pier_spandrel: bays"), checked_count(storeys, 1, "pier_spandrel: storeys")
    pier, clear = lengths("pier_spandrel", pier_width=pier_width, opening_width=opening_width)
    heights = {"opening_height": opening_height, "spandrel_height": spandrel_height, "unit_height": unit_height}
    opening, spandrel, course = lengths("pier_spandrel", **heights)
    (unit,) = lengths("pier_spandrel", unit_length=unit_length)
    for what, value in (("opening_height", opening), ("spandrel_height", spandrel)):
        if abs(value / course - round(value / course)) > 1e-6:
            msg = (
                f"pier_spandrel: {what} {value:.6g} m is not a multiple of the course height {course:.6g} m; change one"
            )
            raise ModelError(msg)
    check_total(n * m, "pier_spandrel")
    size = clear, opening, min(unit, pier) / 2
    openings = [
        Opening(*(to_quantity(v, "length") for v in (pier + k * (pier + clear), j * (opening + spandrel), *size)))
        for j in range(m)
        for k in range(n)
    ]
    return wall(
        length=to_quantity((n + 1) * pier + n * clear, "length"),
        courses=m * round((opening + spandrel) / course),
        unit_length=unit_length,
        unit_height=unit_height,
        thickness=thickness,
        material=material,
        openings=openings,
        base=base,
        prefix=prefix,
    )
