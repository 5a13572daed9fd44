"""Sizes and counts that builders take."""

import operator
from typing import Any

from blockstruct.errors import ModelError
from blockstruct.units import si


def positive_length(value: Any, what: str) -> float:
    """Length in m.

    Raises
    ------
    ModelError
        A length that is not above zero.
    """
    length = si(value, "length", what)
    if length <= 0:
        msg = f"{what} {length:.6g} m; give a length above zero"
        raise ModelError(msg)
    return length


def checked_count(value: Any, least: int, what: str) -> int:
    """Whole number of at least ``least``.

    Raises
    ------
    ModelError
        No whole number, or one that is less.
    """
    try:
        count = operator.index(value)
    except TypeError:
        count = least - 1
    if count < least or isinstance(value, bool):
        msg = f"{what} {value!r}; give a whole number of at least {least}"
        raise ModelError(msg)
    return count
