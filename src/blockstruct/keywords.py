"""Arguments by their names: those that are nearly right, and those that an object is made again of."""

import inspect
from collections.abc import Callable, Iterable
from dataclasses import fields
from difflib import get_close_matches
from functools import partial, wraps
from types import MappingProxyType
from typing import Any, TypeVar

from blockstruct.errors import UnknownKeywordError

_Called = TypeVar("_Called", bound=Callable[..., Any])


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """What to use instead of an unknown name: the known ones that it begins or resembles, or all of them.

    >>> did_you_mean("friction", ["name", "friction_coefficient", "friction_angle"])
    'did you mean friction_coefficient or friction_angle?'
    >>> did_you_mean("colour", ["name", "fixed"])
    'known are name, fixed'
    """
    known = list(known)
    near = [name for name in known if word and name.startswith(word)]
    # The longer a word, the slower the search for words like it.
    near = near or get_close_matches(word[:100], known, cutoff=0.7)
    return f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(known) or 'none'}"


def checked_keywords(called: _Called) -> _Called:
    """Function or class that refuses an unknown argument with the one that was probably meant.

    >>> @checked_keywords
    ... def wall(*, length, depth): ...
    >>> wall(lenght=1, depth=2)
    Traceback (most recent call last):
        ...
    blockstruct.errors.UnknownKeywordError: wall: no argument 'lenght'; did you mean length?
    """
    if isinstance(called, type):
        # The class stays what it is; only its making is watched.
        called.__init__ = _watched(called.__init__, called.__name__)  # type: ignore[misc]
        return called
    watched: _Called = _watched(called, called.__qualname__)
    return watched


def made_again(instance: Any) -> tuple[Callable[[], Any], tuple[()]]:
    """How a dataclass with frozen mappings is pickled and copied, as its ``__reduce__``: made again of its fields.

    Python can do neither with a frozen view of a dictionary.
    """
    kind: Callable[..., Any] = type(instance)
    values = {field.name: getattr(instance, field.name) for field in fields(instance)}
    plain = {name: dict(v) if isinstance(v, MappingProxyType) else v for name, v in values.items()}
    return partial(kind, **plain), ()


def _watched(function: Any, name: str) -> Any:
    known = [p for p in inspect.signature(function).parameters if p not in ("self", "cls")]

    @wraps(function)
    def watched(*args: Any, **keywords: Any) -> Any:
        for word in keywords:
            if word not in known:
                msg = f"{name}: no argument {word!r}; {did_you_mean(word, known)}"
                raise UnknownKeywordError(msg)
        return function(*args, **keywords)

    return watched
