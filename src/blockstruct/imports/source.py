"""Content and numbers of files, and optional packages for some formats."""

import math
import re
from importlib import import_module
from pathlib import Path
from typing import Any

from blockstruct.errors import GeometryFileError, MissingExtraError
from blockstruct.files import read_file
from blockstruct.imports.tolerances import MOST_BYTES, MOST_FACES

#: Numbers as all formats write them. Python also reads ``1_0``, ``nan`` and the digits of other scripts.
_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_WHOLE = re.compile(r"[-+]?[0-9]{1,18}")


def read_number(text: str) -> float:
    """Return the finite number that a text is; anything else is a ValueError.

    >>> read_number("-1.5e-3"), read_number(repr(2))
    (-0.0015, 2.0)
    """
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    if not math.isfinite(value):
        msg = f"{text[:60]!r} is not a finite number"
        raise ValueError(msg)
    return value


def read_whole(text: str) -> int:
    """Return the whole number that a text is; anything else is a ValueError."""
    if not _WHOLE.fullmatch(text):
        msg = f"{text[:60]!r} is not a whole number"
        raise ValueError(msg)
    return int(text)


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a file.

    Raises
    ------
    StorageError
        If the file cannot be read, or is larger than any mesh that is imported.
    GeometryFileError
        If the file is empty.
    """
    content = read_file(path, "a mesh, drawing or assembly", MOST_BYTES)
    if not content.strip():
        msg = f"{path}: is empty; export it again"
        raise GeometryFileError(msg)
    return content


def checked_faces(faces: int, path: Path) -> int:
    """Return the number of faces of a file; refuse too many before slow steps."""
    if faces > MOST_FACES:
        msg = (
            f"{path}: {faces} faces, the limit is {MOST_FACES}; simplify the meshes first: a rigid block "
            "needs the shape of its joints, not the grain of its surface"
        )
        raise GeometryFileError(msg)
    return faces


def read_text(path: Path) -> str:
    """Return the text of a file, as :func:`read_bytes`; refuse other content."""
    content = read_bytes(path)
    if b"\0" in content:
        msg = f"{path}: is not text; export it again"
        raise GeometryFileError(msg)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Older programs write names in the code page of Windows or of their own; digits are the same in all.
        return content.decode("cp1252", errors="replace")


def package(name: str, extra: str, needed_for: str) -> Any:
    """Import a package of an extra.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise MissingExtraError.of(error, extra, needed_for) from error
