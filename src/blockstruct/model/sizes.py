"""Sizes and counts that builders take."""

import operator
from typing import Any

from blockstruct.errors import ModelError, shown
from blockstruct.units import si

#: Lengths that a builder takes, m, and blocks that it makes.
SHORTEST, LONGEST, MOST_BLOCKS = 1e-6, 1e6, 100_000


def positive_length(value: Any, what: str) -> float:
    """Length in m.

    Raises
    ------
    ModelError
        A length that is not above zero, or of no building.
    """
    length = si(value, "length", what)
    if length <= 0:
        msg = f"{what} {length:.6g} m; give a length above zero"
        raise ModelError(msg)
    if not SHORTEST <= length <= LONGEST:
        msg = f"{what} {length:.6g} m; give a length from {SHORTEST:g} to {LONGEST:g} m, is its unit right?"
        raise ModelError(msg)
    return length


def checked_count(value: Any, least: int, what: str) -> int:
    """Whole number of at least ``least``, and of no more blocks than anybody builds.

    Raises
    ------
    ModelError
        No whole number, or one that is less or more.
    """
    try:
        count = operator.index(value)
    except TypeError:
        count = least - 1
    if not least <= count <= MOST_BLOCKS or isinstance(value, bool):
        msg = f"{what} {shown(value)}; give a whole number of at least {least} and at most {MOST_BLOCKS}"
        raise ModelError(msg)
    return count


def check_total(blocks: float, what: str) -> None:
    """Refuse a structure of far too many blocks before the first of them is made.

    Raises
    ------
    ModelError
        More than any model has.
    """
    if blocks > MOST_BLOCKS:
        msg = f"{what}: some {blocks:.3g} blocks, the limit is {MOST_BLOCKS}; give larger or fewer units"
        raise ModelError(msg)
