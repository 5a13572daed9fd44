"""The name of a file that is to be written: what may stand there, and that nothing else is ever replaced."""

import errno
import os
import stat
from collections.abc import Sequence
from pathlib import Path

from blockstruct.errors import StorageError, shown
from blockstruct.storage.lock import folder_of, in_the_way
from blockstruct.storage.snapshot import Snapshot, Stamp

SUFFIX = ".h5"


def place_of(path: str | Path) -> Path:
    """Absolute path of a file, behind all symbolic links: it stays the same whatever the working folder becomes.

    Raises
    ------
    StorageError
        If the text cannot be a path, or the working folder that it is relative to is gone.
    """
    try:
        return Path(os.path.realpath(path))
    except FileNotFoundError as error:
        msg = f"{path}: the working folder has been deleted; change to another one, or give an absolute path"
        raise StorageError(msg) from error
    except (TypeError, ValueError, OSError) as error:
        msg = f"{shown(path)}: is not a path ({error}); give that of a file, such as 'analysis.h5'"
        raise StorageError(msg) from error


def claim(path: str | Path) -> Path:
    """Check, before any work is done, that a file can be written at a path; make its folder if it is missing.

    Returns
    -------
    pathlib.Path
        Absolute, behind all symbolic links.

    Raises
    ------
    StorageError
        If the name does not end in ``.h5`` or is too long, or the path holds something other than an intact analysis,
        or is in a folder that cannot be made or written to.
    """
    place = place_of(path)
    try:
        _check_holder(place)
        if place.suffix != SUFFIX:
            msg = f"{path}: the name of an analysis ends in {SUFFIX}, as an Archive wants; write {path}{SUFFIX}"
            raise StorageError(msg)
        place.parent.mkdir(parents=True, exist_ok=True)
        _try(place)
    except StorageError:
        raise
    except OSError as error:
        raise _unwritable(place, error) from error
    return place


def put_in_place(draft: Path, place: Path, replaced: Sequence[Stamp]) -> None:
    """Give a draft that is on the disk its name, unless something else than what it replaces stands there.

    Raises
    ------
    StorageError
        If a file has appeared at the name.
    """
    while (present := Stamp.at(place)) is None:
        try:
            # Unlike a rename, this fails if a file appears between the line above and this one.
            os.link(draft, place)
        except FileExistsError:
            continue
        except OSError:  # A file system without hard links.
            break
        draft.unlink()
        sync(place.parent)
        return
    if present is not None and present not in replaced:
        msg = f"{place}: another file has appeared at this name, and is not replaced; move it away, then try again"
        raise StorageError(msg)
    draft.replace(place)
    sync(place.parent)


def sync(path: str | Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk."""
    if os.name == "nt" and Path(path).is_dir():
        return  # Windows opens no folders.
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _check_holder(place: Path) -> None:
    """Refuse a path whose holder must not be replaced."""
    try:
        mode = place.stat().st_mode
    except FileNotFoundError:
        return
    if stat.S_ISDIR(mode):
        msg = f"{place}: is a folder; give the path of a file, such as {place / 'analysis.h5'}"
        raise StorageError(msg)
    if not stat.S_ISREG(mode) or not Snapshot(place).sealed:
        what = "exists and is not a blockstruct analysis, or a damaged one"
        msg = f"{place}: {what}, so it is not replaced; choose another name"
        raise StorageError(msg)


def _try(place: Path) -> None:
    """Make, and remove, the folder of the working data, whose name is the longest of all that are needed."""
    folder = folder_of(place)
    try:
        folder.mkdir()
        folder.rmdir()
    except OSError as error:
        if not folder.is_dir():
            if isinstance(error, FileExistsError):
                raise in_the_way(place) from error
            raise
        if error.errno != errno.ENOTEMPTY and not os.access(folder, os.W_OK | os.X_OK):
            raise


def _unwritable(place: Path, error: OSError) -> StorageError:
    if error.errno == errno.ENAMETOOLONG:
        msg = f"{place}: the name is too long, with {len(folder_of(place).name)} characters; choose a shorter one"
        return StorageError(msg)
    return StorageError(f"{place}: cannot be written ({error.strerror or error}); choose a folder you can write to")
