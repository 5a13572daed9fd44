"""What a path is, new files, CSV without formulas, and JSON objects that repeat no key."""

import re
from collections import Counter
from pathlib import Path
from typing import Any

import pandas as pd

from blockstruct.errors import StorageError

#: How a formula of a spreadsheet begins, if it is not a number.
_FORMULA = re.compile(r"(?![-+]?\d*\.?\d+([eE][-+]?\d+)?\Z)[=+\-@\t\r]")


def unique_pairs(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Object of JSON, refused with a ValueError if it repeats a key, of which the last would silently win."""
    found = dict(pairs)
    if len(found) < len(pairs):
        twice = sorted(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
        msg = f"repeated keys {twice[:10]}; rename or merge them"
        raise ValueError(msg)
    return found


def irregular(path: Path) -> str:
    """Return what a path is if it is no regular file; empty for a file or nothing.

    Asked before a path is opened: a pipe waits for its other end, and a device may never come to its own.
    """
    if path.is_file() or not path.exists():
        return ""
    return "a folder" if path.is_dir() else "not a regular file but a pipe or a device"


def check_new(path: Path) -> Path:
    """A path, refused if there is a file already: asked before the work that a file is to hold."""
    if path.exists():
        raise _taken(path)
    return path


def write_new(path: Path, text: str) -> Path:
    """Write a text to a file that does not exist yet."""
    return write_new_bytes(path, text.encode("utf-8"))


def write_new_bytes(path: Path, content: bytes | memoryview) -> Path:
    """Write bytes to a file that does not exist yet."""
    try:
        with path.open("xb") as stream:
            stream.write(content)
    except FileExistsError as error:
        raise _taken(path) from error
    except OSError as error:
        msg = f"{path}: cannot be written ({error.strerror or error}); choose another file"
        raise StorageError(msg) from error
    return path


def _taken(path: Path) -> StorageError:
    return StorageError(f"{path}: exists and is not replaced; choose another name or remove it")


def csv_text(frame: pd.DataFrame) -> str:
    """Table as CSV, in which a text that a spreadsheet would run as a formula begins with an apostrophe.

    Names come from anyone's files: ``=HYPERLINK(…)`` is one. Numbers stay as they are, negative ones too.
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
    return plain.to_csv(lineterminator="\n")


def _plain(values: Any) -> Any:
    """Texts of an index or a column, none of them a formula."""
    return values.map(lambda value: f"'{value}" if isinstance(value, str) and _FORMULA.match(value) else value)
