"""Files that views write."""

import contextlib
import os
from pathlib import Path

import pandas as pd

import blockstruct as bs
from blockstruct.files import csv_text, writing

#: First bytes of an HDF5 file.
_HDF5 = b"\x89HDF\r\n\x1a\n"


def target_with(path: str | Path, *suffixes: str) -> Path:
    """Return the path of a file to write.

    Raises
    ------
    StorageError
        If its name ends in none of the suffixes.
    """
    target = Path(path)
    if target.suffix.lower() not in suffixes:
        msg = f"{target}: give a name that ends in {' or '.join(suffixes)}"
        raise bs.errors.StorageError(msg)
    return target


def made_folder(path: str | Path) -> Path:
    """Make a folder, if it does not exist, and return its path.

    Raises
    ------
    StorageError
        If it cannot be made.
    """
    target = Path(path)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        msg = f"{target}: cannot be made ({error.strerror or error}); choose another folder"
        raise bs.errors.StorageError(msg) from error
    return target


def write_text(text: str, path: str | Path) -> Path:
    """Write a text in UTF-8 by :func:`write_bytes`."""
    return write_bytes(text.encode("utf-8"), path)


def write_bytes(content: bytes, path: str | Path) -> Path:
    """Write a file under a temporary name and move it into place; it replaces a text or a picture.

    Raises
    ------
    StorageError
        If the path cannot be written, holds an analysis, or is a device or a pipe.
    """
    target = Path(path)
    with writing(target):
        _check(target)
        draft = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            draft.write_bytes(content)
            draft.replace(target)
        finally:
            # On a read-only disk, or with too long a name, there is no draft to remove.
            with contextlib.suppress(OSError):
                draft.unlink()
    return target


def write_csv(frame: pd.DataFrame, path: str | Path) -> Path:
    """Write a table by :func:`write_text`; no text in it becomes a formula."""
    return write_text(csv_text(frame), path)


def _check(target: Path) -> None:
    """Refuse to replace a file that a view must not destroy."""
    if not target.is_file():
        if target.exists():
            msg = "it is not a regular file"
            raise OSError(msg)
        return
    with target.open("rb") as file:
        if file.read(len(_HDF5)) == _HDF5:
            msg = "it is an HDF5 file, such as an analysis"
            raise OSError(msg)
