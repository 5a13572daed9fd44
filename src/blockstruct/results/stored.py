"""Iterations whose forces and velocities a file was told to leave out, by ``keep_every``."""

from collections.abc import Iterable

import numpy as np
import xarray as xr

from blockstruct.errors import ModelError

#: Iterations that a message names.
_SHOWN = 8


def require_stored(history: xr.Dataset, iterations: Iterable[int], what: str) -> None:
    """Refuse a question about iterations whose forces and velocities a file does not keep.

    Parameters
    ----------
    history
        History of a case, in memory or of a file.
    iterations
        Their positions.
    what
        What is asked for.

    Raises
    ------
    ModelError
        If the file was told to leave one of them out.
    """
    if not history.sizes["contact_point"]:
        return
    # A program has its conditions whatever became of it.
    condition = history["fictitious_slope"].isel(contact_point=0).to_numpy()
    left_out = [int(k) for k in iterations if np.isnan(condition[k])]
    if left_out:
        names = ", ".join(map(str, left_out[:_SHOWN])) + (", …" if len(left_out) > _SHOWN else "")
        kept = np.flatnonzero(~np.isnan(condition))
        some = ", ".join(map(str, kept[:_SHOWN])) + (", …" if len(kept) > _SHOWN else "")
        msg = (
            f"{what}: the file leaves out forces and velocities of iteration {names} (keep_every); ask for one of "
            f"those it has, {some}, or run the case again with keep_every=1"
        )
        raise ModelError(msg)
