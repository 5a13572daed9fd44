"""What an archive remembers of its files between two sessions: the rows of each, as long as it does not change."""

import contextlib
import json
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from blockstruct.storage.archive_rows import Row
from blockstruct.storage.snapshot import Stamp

#: Name of the file in the folder of the archive, and the version of what it holds.
NAME, VERSION = ".blockstruct-index.json", 3

#: Stamp and rows of the files of an archive.
Known = dict[Path, tuple[Stamp, list[Row]]]


def read_index(folder: Path) -> Known:
    """What the index of a folder remembers; nothing if there is none, or none that can be read.

    It only saves time: a row counts as long as the stamp of its file is still the same, and never for a file that is
    opened.
    """
    try:
        content = json.loads((folder / NAME).read_bytes())
        if content["version"] != VERSION:
            return {}
        return {
            folder / path: (Stamp(*map(int, stamp)), [_row(row) for row in rows])
            for path, (stamp, rows) in content["files"].items()
        }
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return {}


def write_index(folder: Path, known: Mapping[Path, tuple[Stamp, list[Row]]]) -> None:
    """Remember rows, if the folder can be written to: another index is replaced in one step."""
    files = {path.relative_to(folder).as_posix(): (stamp, rows) for path, (stamp, rows) in known.items()}
    content = json.dumps({"version": VERSION, "files": files}, separators=(",", ":"))
    with contextlib.suppress(OSError):
        descriptor, draft = tempfile.mkstemp(prefix=f"{NAME}.", dir=folder)
        try:
            with os.fdopen(descriptor, "w", encoding="utf-8") as stream:
                stream.write(content)
            Path(draft).replace(folder / NAME)
        except OSError:
            Path(draft).unlink(missing_ok=True)


def _row(stored: Mapping[str, Any]) -> Row:
    return {**stored, "tags": tuple(stored["tags"]), "units": dict(stored["units"])}
