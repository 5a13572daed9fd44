"""From the layout of an older major version to that of today, step by step."""

from collections.abc import Callable, Mapping

import xarray as xr

from blockstruct.errors import FormatError

#: All groups of a file, by their path.
Groups = Mapping[str, xr.Dataset]

#: What turns the groups of a file of one major version into those of the next, by (from, to). There is one version yet.
MIGRATIONS: dict[tuple[int, int], Callable[[Groups], Groups]] = {}


def migrated(groups: Groups, version: int, current: int) -> Groups:
    """Groups of a file as the current major version has them.

    Parameters
    ----------
    groups
        As they are in the file.
    version, current
        Major version of the file, and of what is wanted, which is not older.

    Raises
    ------
    FormatError
        If no step leads away from a version.
    """
    for older in range(version, current):
        step = (older, older + 1)
        if step not in MIGRATIONS:
            msg = f"format version {older}: no migration to {older + 1}; read it with an older blockstruct"
            raise FormatError(msg)
        groups = MIGRATIONS[step](groups)
    return groups
