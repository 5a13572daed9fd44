"""Files as they are read: their content, and the packages that some formats need."""

from importlib import import_module
from pathlib import Path
from typing import Any

from blockstruct.errors import GeometryFileError, MissingExtraError, StorageError
from blockstruct.imports.tolerances import MOST_FACES


def read_bytes(path: Path) -> bytes:
    """Bytes of a file.

    Raises
    ------
    StorageError
        If the file cannot be read.
    GeometryFileError
        If the file is empty.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        msg = f"{path}: cannot be read ({error.strerror or error}); give the path of a file that can"
        raise StorageError(msg) from error
    if not content.strip():
        msg = f"{path}: is empty; export it again"
        raise GeometryFileError(msg)
    return content


def checked_faces(faces: int, path: Path) -> int:
    """The number of faces of a file, if there are not far too many: asked before anything slow is done."""
    if faces > MOST_FACES:
        msg = (
            f"{path}: {faces} faces, the limit is {MOST_FACES}; simplify the meshes first, a rigid block "
            "needs the shape of its joints, not that of its grain"
        )
        raise GeometryFileError(msg)
    return faces


def read_text(path: Path) -> str:
    """Text of a file, as :func:`read_bytes`; refuses what is not text."""
    content = read_bytes(path)
    if b"\0" in content:
        msg = f"{path}: is not text; export it again"
        raise GeometryFileError(msg)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Older programs write names in the alphabet of Windows, or their own; numbers read the same in all of them.
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
