"""Checks of arguments that all builders share."""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

from blockstruct.errors import ModelError, shown
from blockstruct.model import Material

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
