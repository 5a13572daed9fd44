"""Checks of arguments that builders share, and converters of the fields of their parts."""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

from blockstruct.errors import ModelError, shown
from blockstruct.model import Material
from blockstruct.model.checks import checked_count, positive_length
from blockstruct.units import QuantityLike

#: Metadata of a length.
LENGTH = {"dimension": "length"}
_Function = TypeVar("_Function", bound=Callable[..., Any])

_KINDS: dict[str, tuple[type, str]] = {
    "material": (Material, "a Material"),
    "prefix": (str, "a text"),
    **dict.fromkeys(("abutments", "base", "keystone", "staggered"), (bool, "True or False")),
}


def builder(function: _Function) -> _Function:
    """Return a builder that refuses shared arguments of a wrong type."""

    @wraps(function)
    def build(*args: Any, **keywords: Any) -> Any:
        for name, value in keywords.items():
            kind, remedy = _KINDS.get(name, (object, ""))
            if not isinstance(value, kind):
                msg = f"{function.__name__}: {name} is {shown(value)}; give {remedy}"
                raise ModelError(msg)
        return function(*args, **keywords)

    return cast(_Function, build)


def lengths(who: str, **values: Any) -> list[float]:
    """Return the lengths of a builder, m, in the order of its arguments."""
    return [positive_length(value, f"{who}: {name}") for name, value in values.items()]


def length(value: QuantityLike, dimension: str = "", what: str = "") -> float:
    """Return a length in m, within the range of buildings."""
    return positive_length(value, what)


def optional_length(value: QuantityLike | None, dimension: str = "", what: str = "") -> float | None:
    """Return a length in m that may be left out."""
    return None if value is None else positive_length(value, what)


def count(value: int, least: int = 1, what: str = "") -> int:
    """Return a whole number from ``least``."""
    return checked_count(value, least, what)


def optional_count(value: int | None, least: int = 1, what: str = "") -> int | None:
    """Return a whole number from ``least`` that may be left out."""
    return None if value is None else checked_count(value, least, what)
