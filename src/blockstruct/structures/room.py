"""Four walls around a room, bonded at their corners."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from blockstruct.errors import ModelError
from blockstruct.geometry.tolerances import ROUNDING
from blockstruct.keywords import check_known
from blockstruct.model import Block, Material, checked_tuple
from blockstruct.structures.bond import Panel
from blockstruct.structures.builder import builder, lengths
from blockstruct.structures.openings import AnyOpening, check_openings
from blockstruct.structures.pieces import Pieces
from blockstruct.structures.rubble import Rubble
from blockstruct.structures.wall import bond_of, check_units, gable_of, joints_of
from blockstruct.units import QuantityLike

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
