"""What names and collections of model objects must be."""

from collections.abc import Iterable
from typing import Any, get_args

from blockstruct.errors import ModelError, shown

#: Characters of a name. That of an interface holds two of blocks.
LONGEST_NAME = 1000


def checked_name(name: Any, kind: str) -> str:
    """The name, if it is a text that can be printed on one line, is not blank and not too long to be stored."""
    if not isinstance(name, str) or not name.strip() or not name.isprintable() or len(name) > LONGEST_NAME:
        msg = f"{kind} {shown(name)}: a name must be a text of 1 to {LONGEST_NAME} printable characters, not blank"
        raise ModelError(msg)
    return name


def checked_tuple(items: Any, kind: Any, what: str) -> tuple[Any, ...]:
    """The items, if they are a collection of objects of one kind (a class or a union of classes)."""
    kinds = get_args(kind) or (kind,)
    names = ", ".join(k.__name__ for k in kinds)
    if isinstance(items, str) or not isinstance(items, Iterable):
        msg = f"{what}: {shown(items)} is no list; give a list of {names}"
        raise ModelError(msg)
    try:
        found = tuple(items)
    except TypeError:  # quantities and arrays without a dimension only look like lists
        found = (items,)
    for item in found:
        if not isinstance(item, kinds):
            msg = f"{what}: {shown(item)} is none of {names}; give a list of {names}"
            raise ModelError(msg)
    return found
