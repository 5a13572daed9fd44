"""What all builders of structures refuse alike."""

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
    """Return a builder that refuses arguments of another kind, of those that builders share."""

    @wraps(function)
    def build(*args: Any, **keywords: Any) -> Any:
        for name, value in keywords.items():
            kind, what = _KINDS.get(name, (object, ""))
            if not isinstance(value, kind):
                msg = f"{function.__name__}: {name} is {shown(value)}; give {what}"
                raise ModelError(msg)
        return function(*args, **keywords)

    return cast(_Function, build)
