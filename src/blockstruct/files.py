"""Files of users, new files, CSV without formulas, JSON without repeats."""

import errno
import os
import re
import stat
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import pandas as pd

from blockstruct.errors import StorageError

#: Most bytes, characters or values of one part of a file or an argument: more are a mistake, or an attack.
MOST_READ = 1_000_000
#: Start of a spreadsheet formula that is not a number.
_FORMULA = re.compile(r"(?![-+]?\d*\.?\d+([eE][-+]?\d+)?\Z)[=+\-@\t\r]")


def unique_pairs(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a JSON object; raise ValueError if it repeats a key.

    Otherwise the last value would silently win.
    """
    found = dict(pairs)
    if len(found) < len(pairs):
        twice = sorted(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
        msg = f"repeated keys {twice[:10]}; rename or merge them"
        raise ValueError(msg)
    return found


def open_file(path: Path, kind: str) -> BinaryIO:
    """Open a regular file of a user for reading, once.

    A pipe waits for its other end, and a device may have no end. Neither is opened.

    Parameters
    ----------
    path
    kind
        Kind of file, for the message: "a mesh".

    Raises
    ------
    StorageError
        If there is no regular file at the path, or it cannot be opened.
    """
    try:
        # A pipe would wait here for its other end.
        flags = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0)
        if path.is_dir():
            msg = f"{path}: is a folder; give the path of {kind}"
            raise StorageError(msg)
        descriptor = os.open(path, flags)
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            os.close(descriptor)
            msg = f"{path}: is not a regular file but a pipe or a device; give the path of {kind}"
            raise StorageError(msg)
    except StorageError:
        raise
    except (OSError, ValueError) as error:
        raise unreadable(path, error, kind) from error
    return os.fdopen(descriptor, "rb")


def read_file(path: Path, kind: str, most: int) -> bytes:
    """Return the bytes of a file of a user, as :func:`open_file`.

    A file of more than ``most`` bytes is refused.
    """
    with open_file(path, kind) as stream:
        size = os.fstat(stream.fileno()).st_size
        if size > most:
            msg = f"{path}: larger than {most / 1e6:g} MB, the limit of {kind}; divide it or simplify it"
            raise StorageError(msg)
        try:
            content = stream.read(size + 1)
        except OSError as error:
            raise unreadable(path, error, kind) from error
    if len(content) != size:
        msg = f"{path}: was written to while it was read; wait, then try again"
        raise StorageError(msg)
    return content


def unreadable(path: Path, error: Exception, kind: str) -> StorageError:
    """Return the error for a path that cannot be opened or read."""
    reason = getattr(error, "strerror", None) or error
    if isinstance(error, FileNotFoundError | NotADirectoryError):
        return StorageError(f"{path}: no such file; give the path of {kind}")
    if isinstance(error, PermissionError):
        return StorageError(f"{path}: cannot be read ({reason}); ask its owner for the right to read it")
    if getattr(error, "errno", None) in (errno.EMFILE, errno.ENFILE):
        return StorageError(f"{path}: cannot be opened, too many files are; close some of them")
    return StorageError(f"{path}: cannot be read ({reason}); give another path")


@contextmanager
def writing(path: Path, remedy: str = "choose another file") -> Iterator[None]:
    """Turn an error of the system while a file is written into a StorageError with the path and a remedy."""
    try:
        yield
    except StorageError:
        raise
    except OSError as error:
        msg = f"{path}: cannot be written ({error.strerror or error}); {remedy}"
        raise StorageError(msg) from error


def check_new(path: Path) -> Path:
    """Return a path, refused if it exists, before any work for the file."""
    if path.exists():
        raise _taken(path)
    return path


def write_new(path: Path, text: str) -> Path:
    """Write a text to a new file."""
    return write_new_bytes(path, text.encode("utf-8"))


def write_new_bytes(path: Path, content: bytes | memoryview) -> Path:
    """Write bytes to a new file."""
    with writing(path):
        try:
            with path.open("xb") as stream:
                stream.write(content)
        except FileExistsError as error:
            raise _taken(path) from error
    return path


def _taken(path: Path) -> StorageError:
    return StorageError(f"{path}: exists and is not replaced; choose another name or remove it")


def csv_text(frame: pd.DataFrame) -> str:
    """Return a table as CSV without formulas for a spreadsheet."""
    return without_formulas(frame).to_csv(lineterminator="\n")


def without_formulas(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a table without texts that a spreadsheet would run as formulas.

    Such a text begins with an apostrophe. Names may come from any file: ``=HYPERLINK(…)`` is one. Numbers are
    unchanged, including negative ones.
    """
    plain = frame.copy(deep=False)
    for name, column in frame.items():
        if not pd.api.types.is_numeric_dtype(column):
            plain[name] = _plain(column)
    index = frame.index
    if isinstance(index, pd.MultiIndex):
        plain.index = index.set_levels([_plain(level) for level in index.levels])
    else:
        plain.index = _plain(index)
    plain.columns = _plain(frame.columns)
    return plain


def _plain(values: Any) -> Any:
    """Return the texts of an index or a column without formulas."""
    return values.map(lambda value: f"'{value}" if isinstance(value, str) and _FORMULA.match(value) else value)
