"""Suggestions for unknown names, and copies of frozen objects."""

from collections.abc import Callable, Iterable
from difflib import get_close_matches
from functools import partial
from inspect import signature
from types import MappingProxyType
from typing import Any

from blockstruct.errors import UnknownNameError, shown


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return advice on an unknown name: similar known names, or all names.

    >>> did_you_mean("friction", ["name", "friction_coefficient", "friction_angle"])
    'did you mean friction_coefficient or friction_angle?'
    >>> did_you_mean("colour", ["name", "fixed"])
    'known are name, fixed'
    """
    known = list(known)
    near = [name for name in known if word and name.startswith(word)]
    # The search for similar words is slower for longer words.
    near = near or get_close_matches(word[:100], known, cutoff=0.7)
    return f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(known) or 'none'}"


def check_known(name: Any, known: Iterable[str], what: str) -> None:
    """Check that a name is known; ``what`` says where it was given and what it names.

    Raises
    ------
    UnknownNameError
        If it is not, with advice.
    """
    known = list(known)
    if not isinstance(name, str) or name not in known:
        msg = f"{what} {shown(name)}; {did_you_mean(str(name), known)}"
        raise UnknownNameError(msg)


def made_again(instance: Any) -> tuple[Callable[[], Any], tuple[()]]:
    """Return the ``__reduce__`` value of an object with frozen mappings.

    It makes a new object from its arguments. Python cannot pickle or copy a frozen view of a dictionary.
    """
    kind: Callable[..., Any] = type(instance)
    values = {name: getattr(instance, name) for name in signature(kind).parameters}
    plain = {name: dict(v) if isinstance(v, MappingProxyType) else v for name, v in values.items()}
    return partial(kind, **plain), ()
