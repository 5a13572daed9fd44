"""Checks of what constructors and builders take: names, sequences, lengths and counts."""

import operator
import reprlib
from collections.abc import Iterable, Sequence
from typing import Any, get_args

from blockstruct.errors import ModelError
from blockstruct.units import si


def checked_name(name: Any, kind: str) -> str:
    """The name, if it is a text that can be printed on one line and is not blank."""
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        msg = f"{kind} {name!r}: a name must be a text of printable characters, not blank"
        raise ModelError(msg)
    return name


def checked_tuple(items: Any, kind: Any, what: str) -> tuple[Any, ...]:
    """The items, if they are a collection of objects of one kind (a class or a union of classes)."""
    kinds = get_args(kind) or (kind,)
    names = ", ".join(k.__name__ for k in kinds)
    if isinstance(items, str) or not isinstance(items, Iterable):
        msg = f"{what}: {reprlib.repr(items)} is no list; give a list of {names}"
        raise ModelError(msg)
    found = tuple(items)
    for item in found:
        if not isinstance(item, kinds):
            msg = f"{what}: {reprlib.repr(item)} is none of {names}; give a list of {names}"
            raise ModelError(msg)
    return found


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


def listed(names: Sequence[str], most: int = 10) -> str:
    """The first names, and how many more there are."""
    rest = len(names) - most
    return ", ".join(names[:most]) + (f" and {rest} more" if rest > 0 else "")
