"""The folder beside a file that holds the working data of its run: whether there are any, and their end."""

import contextlib
from pathlib import Path

from blockstruct.errors import StorageError
from blockstruct.storage.claim import place_of
from blockstruct.storage.lock import WriterLock, folder_of


def is_unfinished(path: str | Path) -> bool:
    """Whether a run that writes to a path is under way, or was killed.

    Raises
    ------
    StorageError
        If the folder cannot be looked into.
    """
    plan = folder_of(place_of(path)) / "plan"
    try:
        return plan.is_file()
    except OSError as error:
        msg = f"{plan.parent}: cannot be looked into ({error.strerror}); ask its owner for the right to read it"
        raise StorageError(msg) from error


def refuse_killed(place: Path) -> None:
    """Refuse a path for which a killed run has iterations, which would be lost or mixed up with others."""
    folder = folder_of(place)
    if is_unfinished(place) and any(folder.glob("*.journal")):
        msg = (
            f"{place}: {folder} holds the iterations of a run that was killed; go on with it by AnalysisManager.resume "
            "(blockstruct resume), keep what it found by recover (blockstruct recover), or delete the folder"
        )
        raise StorageError(msg)


def tidy(path: str | Path) -> None:
    """Remove what a run leaves that was killed while it removed its working data, if nobody writes."""
    place = place_of(path)
    with contextlib.suppress(StorageError, OSError):
        if folder_of(place).is_dir() and not is_unfinished(place):
            with WriterLock(place):
                clear(folder_of(place))


def clear(folder: Path) -> None:
    """Remove working data: the plan first, without which the rest counts for nothing."""
    try:
        (folder / "plan").unlink(missing_ok=True)
        for file in folder.iterdir():
            if file.name != "lock":
                file.unlink()
    except OSError as error:
        msg = f"{folder}: cannot be emptied ({error.strerror}); delete it"
        raise StorageError(msg) from error
