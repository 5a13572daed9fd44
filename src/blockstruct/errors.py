"""All errors and warnings, and suggestions for unknown names.

Each error is also a builtin exception: plain ``except`` clauses for builtin exceptions work.
"""

import re
import reprlib
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from functools import partial
from inspect import signature
from textwrap import shorten
from types import MappingProxyType
from typing import Any, Self

#: A number with a decimal comma, and the text after it.
_COMMA = re.compile(r"([-+]?[0-9]+),([0-9]+(?:\s.*)?)", re.DOTALL)
_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = 80


class BlockstructError(Exception):
    """Base of every error blockstruct raises on purpose."""


class UnitError(BlockstructError, TypeError):
    """A bare number without its unit, or a text that is not a quantity."""


class DimensionError(BlockstructError, ValueError):
    """A quantity of the wrong physical dimension."""


class ModelError(BlockstructError, ValueError):
    """A model, material, load or setting that has no mechanical meaning."""


class GeometryError(ModelError):
    """A shape that cannot be a block or an interface."""


class GeometryFileError(GeometryError):
    """A mesh, drawing or assembly that cannot be read as blocks."""


class UnknownNameError(ModelError, KeyError):
    """A name that does not exist in the model."""

    def __str__(self) -> str:
        """Return the plain message; KeyError alone would print its repr."""
        return str(self.args[0]) if self.args else ""


class UnknownKeywordError(ModelError, TypeError):
    """An unknown name of a setting or of a parameter of a build function."""


class DocumentError(ModelError):
    """A model document that does not follow ``schemas/model-1.json``."""


class SolverError(BlockstructError, RuntimeError):
    """A solver that is not installed or refuses the program."""


class StorageError(BlockstructError, OSError):
    """A file that cannot be written or read."""


class BusyError(StorageError):
    """A file that another run is writing."""


class FormatError(BlockstructError, ValueError):
    """A file that is not a valid blockstruct analysis."""


class CertificateError(BlockstructError, ValueError):
    """A result that contradicts its own forces and velocities."""


class ClusterError(BlockstructError, ConnectionError):
    """A Dask cluster that cannot be reached or cannot run a study."""


class StudyError(BlockstructError, RuntimeError):
    """A study whose runs cannot be sent to its processes."""


class MissingExtraError(BlockstructError, ImportError):
    """A missing package that only some views or file formats need."""

    @classmethod
    def of(cls, error: ImportError, extra: str, what: str) -> Self:
        """Return the error for a missing package, naming its extra."""
        msg = f'{what}: {error.name} is not installed; it comes with: pip install "blockstruct[{extra}]"'
        return cls(msg, name=error.name)


class GeometryWarning(UserWarning):
    """Geometry from a file was repaired or left out; the report names it."""


class UnverifiedWarning(UserWarning):
    """A file is read although its seal does not match.

    Its numbers are unverified.
    """


class VersionWarning(UserWarning):
    """A resumed run keeps numbers of other versions.

    Each case gives its versions.
    """


class LoadFactorWarning(UserWarning):
    """A load factor that needs care; the notes of the result give the reason."""


class StudyWarning(UserWarning):
    """Runs of a study failed, or their load factors need care.

    The rows give the runs and the reasons.
    """


class UnusualValueWarning(UserWarning):
    """A possible value that is probably a mistake.

    An example is a unit weight of 18 kN/mm³.
    """


def decimal_point(text: str) -> str:
    """Return a text with a decimal comma as one with a decimal point.

    Text may follow the number. The result is empty for any other text.

    >>> decimal_point("12,5 kN/m^3"), decimal_point("12.5 kN/m^3")
    ('12.5 kN/m^3', '')
    """
    found = _COMMA.fullmatch(text.strip())
    return f"{found[1]}.{found[2]}" if found else ""


def shown(value: Any) -> str:
    """Return a value as one line for an error message, shortened.

    >>> shown([0] * 9), len(shown("k" * 1000))
    ('[0, 0, 0, 0, 0, 0, ...]', 80)
    """
    try:
        return " ".join(_REPR.repr(value).split())
    except Exception:  # numbers of many digits, objects that cannot be printed
        return f"a {type(value).__name__}"


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
    listed = shorten(", ".join(known), 10 * _REPR.maxother, placeholder=" …")
    return f"did you mean {' or '.join(near)}?" if near else f"known are {listed or 'none'}"


def check_known(name: Any, known: Iterable[str], what: str) -> None:
    """Check that a name is known; ``what`` is its place and its kind.

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
