"""Walls in running bond: openings with lintels, sidewalls that bond in, several leaves with headers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from blockstruct.errors import ModelError, shown
from blockstruct.geometry import box, polyhedron
from blockstruct.keywords import checked_keywords
from blockstruct.model import Block, Material, checked_tuple
from blockstruct.model.checks import check_total, checked_count, checked_name, positive_length
from blockstruct.structures.bond import Bond, without
from blockstruct.structures.builder import builder
from blockstruct.structures.openings import Opening, check_openings
from blockstruct.units import QuantityLike, si


@checked_keywords
@dataclass(frozen=True, slots=True)
class Sidewall:
    """A wall that runs along +y, from behind the wall along x.

    Parameters
    ----------
    name
        Prefix of its units.
    at : quantity, length
        Where its thickness begins along the wall; zero for a return at the left end, the length of the wall less its
        depth for one at the right end (L), anything between for a T.
    length : quantity, length
        From the back of the wall.
    openings
        Openings, with ``start`` counted from the back of the wall.
    bonded
        Whether every other course runs through the wall to its face; else the sidewall butts against it.
    """

    name: str
    at: Any
    length: Any
    openings: Sequence[Opening] = ()
    bonded: bool = True

    def __post_init__(self) -> None:
        who = f"sidewall {checked_name(self.name, 'sidewall')!r}"
        if not isinstance(self.bonded, bool):
            msg = f"{who}: bonded is {shown(self.bonded)}; give True or False"
            raise ModelError(msg)
        object.__setattr__(self, "at", si(self.at, "length", f"{who}: at"))
        object.__setattr__(self, "length", positive_length(self.length, f"{who}: length"))
        object.__setattr__(self, "openings", checked_tuple(self.openings, Opening, f"{who}: openings"))


@builder
def wall(
    *,
    length: QuantityLike,
    courses: int,
    unit_length: QuantityLike,
    unit_height: QuantityLike,
    depth: QuantityLike,
    material: Material,
    openings: Sequence[Opening] = (),
    sidewalls: Sequence[Sidewall] = (),
    leaves: int = 1,
    header_every: int | None = None,
    base: bool = True,
    prefix: str = "",
) -> list[Block]:
    """Blocks of a wall along x in running bond, with all that belongs to it: a façade with sidewalls is one call.

    Every other course is shifted by half a unit. A joint that would cut off less than a quarter of a unit, at an end
    or beside an opening, is left out: the piece stays with its neighbour.

    Parameters
    ----------
    length, depth : quantity, length
        Of the wall along x from x = 0, and its thickness along y from y = 0, that of the sidewalls too.
    courses
        Number of courses, from z = 0.
    unit_length, unit_height : quantity, length
        Of a whole unit, and of every course.
    material
        Material of all blocks.
    openings
        Openings of the wall along x.
    sidewalls
        Walls along +y that return at its ends (L) or meet it between (T).
    leaves
        Number of leaves side by side through the thickness, with head joints shifted by half a unit.
    header_every
        Every how many courses there is one of headers: half a unit long, through all leaves. None by default.
    base
        Whether to add a fixed block ``base`` under the whole plan, one course high.
    prefix
        Put before the names: the k-th unit of the j-th course of the wall is called ``j.k``, lintels
        ``j.lintel1`` …, those of a sidewall ``name.j.k``; units of leaves end in ``a``, ``b`` … from the face.

    Raises
    ------
    ModelError
        If an opening does not lie in its wall or on its bed joints, or meets a sidewall; or a sidewall is not behind
        the wall, overlaps another or shares its name.

    Examples
    --------
    >>> tuff = Material("tuff", "12 kN/m^3")
    >>> size = {"unit_length": "40 cm", "unit_height": "20 cm", "depth": "20 cm", "material": tuff}
    >>> door = Opening(start="1.2 m", sill="0 m", width="0.8 m", height="1.6 m")
    >>> sides = [Sidewall("left", at="0 m", length="2 m"), Sidewall("right", at="3 m", length="2 m")]
    >>> blocks = wall(length="3.2 m", courses=12, openings=[door], sidewalls=sides, **size)
    >>> blocks[0].name, blocks[1].name, blocks[-1].name
    ('base', '1.1', 'right.12.6')
    >>> round(sum(b.volume for b in blocks[1:]) / 0.2, 6) == 2 * 2 * 2.4 + 3.2 * 2.4 - 0.8 * 1.6
    True
    """
    reach, t = positive_length(length, "wall: length"), positive_length(depth, "wall: depth")
    height, number = positive_length(unit_height, "wall: unit_height"), checked_count(courses, 1, "wall: courses")
    headers = None if header_every is None else checked_count(header_every, 2, "wall: header_every")
    bond = Bond(
        positive_length(unit_length, "wall: unit_length"), height, t, checked_count(leaves, 1, "wall: leaves"), headers
    )
    front = checked_tuple(openings, Opening, "wall: openings")
    sides = checked_tuple(sidewalls, Sidewall, "wall: sidewalls")
    check_openings(front, reach, height, number, "wall")
    _check_sidewalls(sides, front, reach, t)
    check_total(number * bond.leaves * (reach + sum(s.length for s in sides)) / bond.unit_length, "wall")
    for side in sides:
        check_openings(side.openings, side.length, height, number, f"sidewall {side.name!r}")

    blocks = []

    def add(name: str, x: float, y: float, z: float, size: tuple[float, float, float], *, fixed: bool = False) -> None:
        vertices, faces = box((x, y, z), size)
        blocks.append(Block(prefix + name, polyhedron(vertices, faces, prefix + name), material, fixed))

    if base:
        add("base", 0.0, 0.0, -height, (reach, t + max((s.length for s in sides), default=0.0), height), fixed=True)
    gaps = [(side.at, side.at + t) for side in sides if side.bonded]
    for j in range(1, number + 1):
        shifted = j % 2 == 0
        # In the courses that it does not begin with a whole unit the wall leaves room for its sidewalls.
        parts = without([(0.0, reach)], gaps if shifted else [])
        for unit in bond.course(j, parts, 0.0, shifted, front):
            add(unit.name, unit.u[0], unit.v[0], (j - 1) * height, (_size(unit.u), _size(unit.v), height))
    for side in sides:
        start = -t if side.bonded else 0.0
        for j in range(1, number + 1):
            through = side.bonded and j % 2 == 0
            shifted = j % 2 == (1 if side.bonded else 0)
            part = (start if through else 0.0, side.length)
            for unit in bond.course(j, [part], start, shifted, side.openings):
                corner = (side.at + unit.v[0], t + unit.u[0], (j - 1) * height)
                add(f"{side.name}.{unit.name}", *corner, (_size(unit.v), _size(unit.u), height))
    return blocks


def _size(interval: tuple[float, float]) -> float:
    return interval[1] - interval[0]


def _check_sidewalls(sides: Sequence[Sidewall], openings: Sequence[Opening], length: float, depth: float) -> None:
    slack = 1e-9 * depth
    for k, side in enumerate(sides):
        who = f"wall: sidewall {side.name!r} at {side.at:.6g} m"
        if not -slack <= side.at <= length - depth + slack:
            msg = f"{who} is not behind the wall; give a place between 0 m and {length - depth:.6g} m"
            raise ModelError(msg)
        for other in sides[:k]:
            if side.name == other.name or abs(side.at - other.at) < depth - slack:
                msg = f"{who} has the name or the place of another at {other.at:.6g} m; rename or move it"
                raise ModelError(msg)
        for opening in openings:
            if opening.start < side.at + depth - slack and side.at < opening.end - slack:
                msg = f"{who} stands behind the opening at {opening.start:.6g} m; move one of them"
                raise ModelError(msg)
