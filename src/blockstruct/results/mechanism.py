"""The collapse mechanism."""

import numpy as np
import xarray as xr

from blockstruct.vocabulary import AXES


def mechanism(history: xr.Dataset) -> xr.Dataset:
    """Collapse mechanism of the last iteration, scaled so that the largest translation of a centroid is one.

    Parameters
    ----------
    history
        History of a case.

    Returns
    -------
    xarray.Dataset
        ``translation`` of the centroid and ``rotation`` about it (small-angle vector) of every block, global
        axes. With a translation in metres, the rotation is in radians per metre of the largest translation.

    Raises
    ------
    IndexError
        A history without iterations.
    """
    u = history["block_velocity"].isel(iteration=-1).transpose("block", "dof").to_numpy()
    largest = np.linalg.norm(u[:, :3], axis=1).max()
    u = u / (largest if largest > 0 else 1.0)
    dims = ("block", "axis")
    return xr.Dataset(
        {
            "translation": (
                dims,
                u[:, :3],
                {"units": "dimensionless", "long_name": "translation of the centroid"},
            ),
            "rotation": (
                dims,
                u[:, 3:],
                {"units": "radian / meter", "long_name": "rotation about the centroid"},
            ),
        },
        coords={"block": history["block"], "axis": np.array(AXES, dtype=object)},
    )
