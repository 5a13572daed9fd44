"""The collapse mechanism."""

import numpy as np
import xarray as xr

from blockstruct.vocabulary import AXES

#: Translation, relative to the motion by rotation, that is rounding.
ROUNDING = 1e-3


def mechanism(history: xr.Dataset) -> xr.Dataset:
    """Collapse mechanism of the last iteration, scaled so that the largest translation of a centroid is one.

    If blocks turn about centroids that rest but for rounding, the largest rotation of a block times the distance from
    its centroid to the nearest contact point is one.

    Parameters
    ----------
    history
        History of a case.

    Returns
    -------
    xarray.Dataset
        ``translation`` of the centroid and ``rotation`` about it (small-angle vector) of every block, global
        axes. With a translation in metres, the rotation is in radians per metre of the largest motion.

    Raises
    ------
    IndexError
        A history without iterations.
    """
    from scipy.spatial import cKDTree

    u = history["block_velocity"].isel(iteration=-1).transpose("block", "dof").to_numpy()
    arms, _ = cKDTree(history["contact_position"].to_numpy()).query(history["block_position"].to_numpy())
    translation, turning = np.linalg.norm(u[:, :3], axis=1).max(), (arms * np.linalg.norm(u[:, 3:], axis=1)).max()
    largest = translation if translation > ROUNDING * turning else turning
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
