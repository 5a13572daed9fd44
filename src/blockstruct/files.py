"""Text files that are written once, and the objects of JSON that repeat no key."""

from collections import Counter
from pathlib import Path
from typing import Any

from blockstruct.errors import StorageError


def unique_pairs(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Object of JSON, refused with a ValueError if it repeats a key, of which the last would silently win."""
    found = dict(pairs)
    if len(found) < len(pairs):
        twice = sorted(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
        msg = f"repeated keys {twice[:10]}; rename or merge them"
        raise ValueError(msg)
    return found


def write_new(path: Path, text: str) -> Path:
    """Write a text to a file that does not exist yet."""
    return write_new_bytes(path, text.encode("utf-8"))


def write_new_bytes(path: Path, content: bytes | memoryview) -> Path:
    """Write bytes to a file that does not exist yet."""
    try:
        with path.open("xb") as stream:
            stream.write(content)
    except FileExistsError as error:
        msg = f"{path}: exists and is not replaced; choose another name or remove it"
        raise StorageError(msg) from error
    except OSError as error:
        msg = f"{path}: cannot be written ({error.strerror or error}); choose another file"
        raise StorageError(msg) from error
    return path
