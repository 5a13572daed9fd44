"""Checks of the arguments of constructors and builders: names, sequences, lengths and counts."""

import math
import operator
import sys
from collections import Counter
from collections.abc import Iterable
from typing import Any, TypeGuard, get_args

import numpy as np

from blockstruct.arrays import SLIGHT, Array
from blockstruct.errors import ModelError, shown
from blockstruct.units import VectorLike, si, si_vector
from blockstruct.vocabulary import listed

#: Largest number of characters of a name or another stored text.
LONGEST_TEXT = 5000
#: Smallest and largest length of a builder, m.
SHORTEST, LONGEST = 1e-6, 1e6
#: Largest number of blocks of a structure, of steps of a curve, and of directions.
MOST = 100_000

#: Unit vector of each axis, by its name.
AXES_BY_NAME = {
    f"{sign}{axis}": tuple(float(f"{sign}{int(k == j)}") + 0.0 for k in range(3))
    for j, axis in enumerate("xyz")
    for sign in "+-"
}


def checked_direction(direction: VectorLike, what: str, remedy: str = "") -> tuple[float, float, float]:
    """Return the unit vector of a direction of length 1, or of the name of an axis such as ``"+x"``.

    Raises
    ------
    ModelError
        If the direction is zero, not of length 1, or an unknown name.
    """
    if isinstance(direction, str) and not any(map(str.isdigit, direction)):
        if direction.strip() not in AXES_BY_NAME:
            names = ", ".join(AXES_BY_NAME)
            msg = f"{what} {shown(direction)}: give one of {names}, or three numbers, as (0.6, 0.8, 0)"
            raise ModelError(msg)
        direction = AXES_BY_NAME[direction.strip()]
    x, y, z = si_vector(direction, "dimensionless", what)
    length = math.hypot(x, y, z)
    if length == 0:
        msg = f"{what} {(x, y, z)} is zero; give a direction such as (1, 0, 0) or '+x'"
        raise ModelError(msg)
    if abs(length - 1) > SLIGHT:
        msg = (
            f"{what} {(x, y, z)} has the length {length:.6g}, not 1; give a direction of length 1"
            f"{remedy.format(length=length)}"
        )
        raise ModelError(msg)
    return unit_vector_along(x, y, z)


def unit_vector_along(x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the unit vector along a vector. A unit vector keeps its digits when it is stored and read again."""
    length = math.hypot(x, y, z)
    return (x, y, z) if abs(length - 1) <= 4 * sys.float_info.epsilon else (x / length, y / length, z / length)


def is_name(name: Any) -> TypeGuard[str]:
    """Return whether a value is a name: a text that is not blank, printable on one line, and not too long."""
    return isinstance(name, str) and bool(name.strip()) and name.isprintable() and len(name) <= LONGEST_TEXT


def checked_name(name: Any, kind: str) -> str:
    """Return the name; refuse a blank text, one that is not printable on one line, or one too long to be stored."""
    if not is_name(name):
        msg = f"{kind} {shown(name)}: a name must be a text of 1 to {LONGEST_TEXT} printable characters, not blank"
        raise ModelError(msg)
    return name


def check_unrepeated(names: Iterable[str], what: str) -> None:
    """Refuse repeated names.

    Raises
    ------
    ModelError
        If a name is repeated.
    """
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        msg = f"{what} names used more than once: {listed(twice)}; rename them"
        raise ModelError(msg)


def checked_text(text: Any, what: str) -> str:
    """Return a text that is stored and printed on one line: a source of values, a tag, a parameter.

    Raises
    ------
    ModelError
        If it is not a printable text, or too long to be stored.
    """
    if not isinstance(text, str) or not text.isprintable() or len(text) > LONGEST_TEXT:
        msg = f"{what} is {shown(text)}; give a text of up to {LONGEST_TEXT} printable characters"
        raise ModelError(msg)
    return text


def checked_tuple(items: Any, kind: Any, what: str) -> tuple[Any, ...]:
    """Return the items as a tuple; refuse items that are not of one kind, a class or a union of classes."""
    kinds = get_args(kind) or (kind,)
    names = ", ".join(k.__name__ for k in kinds)
    if isinstance(items, str) or not isinstance(items, Iterable):
        msg = f"{what}: {shown(items)} is not a list; give a list of {names}"
        raise ModelError(msg)
    try:
        members = tuple(items)
    except TypeError:  # quantities and arrays without a dimension claim to be iterable
        members = (items,)
    for item in members:
        if not isinstance(item, kinds):
            msg = f"{what}: {shown(item)} is not one of {names}; give a list of {names}"
            raise ModelError(msg)
    return members


def positive_length(value: Any, what: str) -> float:
    """Return a length in m.

    Raises
    ------
    ModelError
        If the length is outside the range of buildings.
    """
    length = si(value, "length", what)
    if not SHORTEST <= length <= LONGEST:
        msg = f"{what} {length:.6g} m; give a length from {SHORTEST:g} to {LONGEST:g} m, and check its unit"
        raise ModelError(msg)
    return length


def checked_count(value: Any, least: int, what: str) -> int:
    """Return a whole number from ``least`` to :data:`MOST`.

    Raises
    ------
    ModelError
        If it is not a whole number, or outside this range.
    """
    try:
        count = operator.index(value)
    except TypeError:
        count = least - 1
    if not least <= count <= MOST or isinstance(value, bool):
        msg = f"{what} {shown(value)}; give a whole number of at least {least} and at most {MOST}"
        raise ModelError(msg)
    return count


def check_total(blocks: float, what: str) -> None:
    """Refuse a structure with too many blocks before it is built.

    Raises
    ------
    ModelError
        If there are more than :data:`MOST`.
    """
    if blocks > MOST:
        msg = f"{what}: about {blocks:.3g} blocks, the limit is {MOST}; give larger or fewer units"
        raise ModelError(msg)


def check_at_block(what: str, point: tuple[float, float, float], block: str, vertices: Array, remedy: str) -> None:
    """Refuse a point, m, outside the box around the vertices (n, 3) of its block.

    Raises
    ------
    ModelError
        If it is outside by more than rounding.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    slack = SLIGHT * float((high - low).max())
    if np.any(point < low - slack) or np.any(point > high + slack):
        msg = (
            f"{what} at block {block!r} is {tuple(point)} m, outside the block, which extends from "
            f"{low.round(6).tolist()} to {high.round(6).tolist()} m; {remedy}"
        )
        raise ModelError(msg)
