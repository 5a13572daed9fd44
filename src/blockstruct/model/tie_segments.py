"""What ties are reduced to, stretches of one force, and checks of what their constructors take."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from blockstruct.errors import ModelError, UnknownNameError, shown
from blockstruct.model.block import Block
from blockstruct.model.checks import check_at_block, checked_name
from blockstruct.units import si, si_vector, symbol
from blockstruct.vocabulary import listed

Vector = tuple[float, float, float]
#: Where a tie ends: the name of a block, and the point of its anchor in m.
Anchor = tuple[str, Vector]

#: Dimension of every quantity that a tie of some kind may be given, a key of :data:`blockstruct.units.SI_UNITS`.
TIE_QUANTITIES: Mapping[str, str] = MappingProxyType(
    {
        "yield_force": "force",
        "area": "area",
        "strength": "stress",
        "diameter": "length",
        "bond_strength": "stress",
        "punching_force": "force",
        "bond_force": "force",
        "prestress": "force",
        "elongation_limit": "length",
    }
)

#: Length of a tie, relative to the larger of its blocks, below which it has no direction.
_SHORTEST = 1e-6


@dataclass(frozen=True, slots=True)
class TieSegment:
    """A stretch of a tie that carries one force, between two blocks.

    Attributes
    ----------
    tie, name : str
        Name of the tie, and of this stretch of it.
    blocks : (str, str)
        Blocks that it pulls together.
    start, end : three floats
        Where it ends in each of them, on the line along which it pulls, m.
    direction : three floats
        Unit vector from start to end.
    capacity : float
        Largest force, N.
    governing : str
        Which limit that is: ``yield``, ``strength``, ``punching`` or ``bond``.
    bond : (float, float)
        Force that each of the two blocks can take out of it along their length, N; infinite at an anchor.
    prestress : float
        Least force, N.
    elongation_limit : float
        m; infinite if none was given.
    """

    tie: str
    name: str
    blocks: tuple[str, str]
    start: Vector
    end: Vector
    direction: Vector
    capacity: float
    governing: str
    bond: tuple[float, float] = (math.inf, math.inf)
    prestress: float = 0.0
    elongation_limit: float = math.inf


def check_anchors(who: str, start: Anchor, end: Anchor, blocks: Mapping[str, Block]) -> None:
    """Refuse ends between which a tie holds nothing together.

    Raises
    ------
    UnknownNameError
        If a block is not among them.
    ModelError
        If the ends are at one block, at one point or at two supports, or an anchor lies outside its block.
    """
    for block, point in (start, end):
        if block not in blocks:
            msg = f"{who}: its anchor is at block {block!r}, which is not in the model; it has {listed(list(blocks))}"
            raise UnknownNameError(msg)
        remedy = "give a point of the block, as that under an anchor plate"
        check_at_block(f"{who}: its anchor", point, block, blocks[block].shape.vertices, remedy)
    (one, a), (other, b) = start, end
    if one == other:
        msg = f"{who}: both ends are at block {one!r}, so that it holds nothing together; name two blocks"
        raise ModelError(msg)
    if blocks[one].fixed and blocks[other].fixed:
        msg = f"{who}: both ends are at supports, {one!r} and {other!r}; anchor one of them to a free block"
        raise ModelError(msg)
    size = max(float(np.ptp(blocks[name].shape.vertices, axis=0).max()) for name in (one, other))
    if math.dist(a, b) <= _SHORTEST * size:
        msg = f"{who}: both ends are at {a} m, so that it has no direction; give two points"
        raise ModelError(msg)


def positive_quantities(given: Mapping[str, Any], who: str) -> dict[str, float | None]:
    """SI values of quantities that must be above zero, None of those that were not given."""
    found: dict[str, float | None] = {}
    for name, value in given.items():
        dimension = TIE_QUANTITIES[name]
        what = f"{who}: {name.replace('_', ' ')}"
        found[name] = number = None if value is None else si(value, dimension, what)
        if number is not None and number <= 0:
            msg = f"{what} {number:.6g} {symbol(dimension)}; give more than zero"
            raise ModelError(msg)
    return found


def anchor(given: Any, what: str) -> Anchor:
    """Block and point that a tie ends at."""
    if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 2:
        msg = f"{what} is {shown(given)}; give a block and a point, as in ('b1', Q_([0, 0, 3], 'm'))"
        raise ModelError(msg)
    block, point = given
    return checked_name(block, f"{what}: block"), si_vector(point, "length", what)


def set_fields(frozen: object, **values: Any) -> None:
    """Give a frozen object its fields."""
    for name, value in values.items():
        object.__setattr__(frozen, name, value)
