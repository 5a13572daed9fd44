"""Files that views write."""

import os
from pathlib import Path

import blockstruct as bs


def write_text(text: str, path: str | Path) -> Path:
    """Write a text beside its place and put it there whole.

    Raises
    ------
    StorageError
        A path that cannot be written.
    """
    target = Path(path)
    draft = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        draft.write_text(text, encoding="utf-8")
        draft.replace(target)
    except OSError as error:
        draft.unlink(missing_ok=True)
        msg = f"{target}: cannot be written ({error.strerror or error}); choose another file"
        raise bs.StorageError(msg) from error
    return target
