"""The one error tree: every blockstruct error is also a builtin, so plain ``except`` clauses work."""

import re
import reprlib
from typing import Any, Self

#: A number with a decimal comma, and what may follow it.
_COMMA = re.compile(r"([-+]?[0-9]+),([0-9]+(?:\s.*)?)", re.DOTALL)
_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = 80


class BlockstructError(Exception):
    """Base of every error blockstruct raises on purpose."""


class UnitError(BlockstructError, TypeError):
    """A bare number where a unit is needed, or a text that is not a quantity."""


class DimensionError(BlockstructError, ValueError):
    """A quantity of the wrong physical dimension."""


class ModelError(BlockstructError, ValueError):
    """A model, material, load or setting that has no mechanical meaning."""


class GeometryError(ModelError):
    """A shape that cannot be a block or an interface."""


class GeometryFileError(GeometryError):
    """A mesh, drawing or assembly that cannot be read as blocks."""


class UnknownNameError(ModelError, KeyError):
    """A name that nothing in the model carries."""

    def __str__(self) -> str:
        """Give the plain message: KeyError alone would print its repr."""
        return str(self.args[0]) if self.args else ""


class UnknownKeywordError(ModelError, TypeError):
    """A name that settings or the build function of a study do not have."""


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
    """A result whose status or certificate contradicts its own forces and velocities."""


class ClusterError(BlockstructError, ConnectionError):
    """A Dask cluster that cannot be reached, has no workers, or none that can run a study."""


class StudyError(BlockstructError, RuntimeError):
    """A study whose runs cannot be sent to the processes that are to carry them out."""


class MissingExtraError(BlockstructError, ImportError):
    """A package that only some views or file formats need and that is not installed."""

    @classmethod
    def of(cls, error: ImportError, extra: str, what: str) -> Self:
        """Error of something that needs the package that was not found, with the extra it comes with."""
        msg = f'{what}: {error.name} is not installed; it comes with: pip install "blockstruct[{extra}]"'
        return cls(msg, name=error.name)


class GeometryWarning(UserWarning):
    """Geometry from a file was repaired or left out; the report says what."""


class UnverifiedWarning(UserWarning):
    """A file is read although its seal does not match: nothing vouches for its numbers."""


class FormatWarning(UserWarning):
    """A file that other programs do not read as it is meant; write it anew."""


class VersionWarning(UserWarning):
    """Numbers that other versions made are kept where a run is gone on with; the versions of each case tell which."""


class LoadFactorWarning(UserWarning):
    """A load factor that means less than it seems to; the result says why."""


class StudyWarning(UserWarning):
    """Runs of a study failed, or their load factors mean less than they seem to; the rows say which and why."""


class UnusualValueWarning(UserWarning):
    """A value that is possible but hardly meant, a unit weight of 18 kN/mm³ for instance: look at it again."""


def decimal_point(text: str) -> str:
    """A text that begins with a number with a decimal comma, with a point instead; empty for any other text.

    >>> decimal_point("12,5 kN/m^3"), decimal_point("12.5 kN/m^3")
    ('12.5 kN/m^3', '')
    """
    found = _COMMA.fullmatch(text.strip())
    return f"{found[1]}.{found[2]}" if found else ""


def shown(value: Any) -> str:
    """Value on one line for the message of an error, cut short if it is long or deep.

    >>> shown([0] * 9), len(shown("k" * 1000))
    ('[0, 0, 0, 0, 0, 0, ...]', 80)
    """
    try:
        return " ".join(_REPR.repr(value).split())
    except Exception:  # numbers of many digits, objects that cannot be printed
        return f"a {type(value).__name__}"
