"""The collapse mechanism."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.model import Model, tie_segments
from blockstruct.vocabulary import AXES

#: Translation, relative to the motion by rotation, that counts as rounding.
ROUNDING = 1e-3


def motion_of(iteration: xr.Dataset) -> NDArray[np.float64]:
    """Return velocities and angular velocities, (blocks, 6), SI."""
    of_blocks = [iteration[name].transpose("block", "axis") for name in ("block_velocity", "block_angular_velocity")]
    return np.hstack([motion.to_numpy() for motion in of_blocks])


def largest_motion(history: xr.Dataset) -> float:
    """Return the velocity that scales the mechanism, m/s; one at rest.

    The last iteration counts.
    """
    from scipy.spatial import cKDTree

    u = motion_of(history.isel(iteration=-1))
    arms, _ = cKDTree(history["contact_point_position"].to_numpy()).query(history["block_position"].to_numpy())
    translation, turning = np.linalg.norm(u[:, :3], axis=1).max(), (arms * np.linalg.norm(u[:, 3:], axis=1)).max()
    largest = float(translation if translation > ROUNDING * turning else turning)
    return largest if largest > 0 else 1.0


def mechanism(history: xr.Dataset) -> xr.Dataset:
    """Return the mechanism of the last iteration, scaled.

    The largest translation of a centroid is one.

    If all centroids rest within rounding, rotations set the scale. Each rotation is multiplied by the distance from
    the block's centroid to the nearest contact point. The largest product is then one.

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
        If the history has no iterations.
    """
    u = motion_of(history.isel(iteration=-1)) / largest_motion(history)
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


def with_motion(model: Model, history: xr.Dataset, motion: NDArray[np.float64]) -> xr.Dataset:
    """Return the last iteration with another motion of the blocks, (blocks, 6) as in :func:`motion_of`."""
    found = history.isel(iteration=[-1]).load().copy()
    centroid = np.array([block.centroid for block in model.blocks])

    def velocity(blocks: NDArray[np.int64], points: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(motion[blocks, :3] + np.cross(motion[blocks, 3:], points - centroid[blocks]))

    index, of_point = model.block_index, found["interface_of_contact_point"].to_numpy()
    sides = (np.array([index[getattr(i, side)] for i in model.interfaces]) for side in ("minus", "plus"))
    minus, plus = (blocks[of_point] for blocks in sides)
    points, frame = found["contact_point_position"].to_numpy(), found["interface_frame"].to_numpy()[of_point]
    apart = np.einsum("kij,kj->ki", frame, velocity(plus, points) - velocity(minus, points))
    values: dict[str, tuple[tuple[str, ...], NDArray[np.float64]]] = {
        "block_velocity": (("iteration", "block", "axis"), motion[None, :, :3]),
        "block_angular_velocity": (("iteration", "block", "axis"), motion[None, :, 3:]),
        "relative_velocity": (("iteration", "contact_point", "component"), apart[None]),
    }
    if model.ties:
        ties = tie_segments(model.ties, model.blocks)
        start, end = (np.array([getattr(tie, name) for tie in ties]) for name in ("start", "end"))
        along = (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
        blocks = np.array([[index[name] for name in tie.blocks] for tie in ties])
        rate = np.einsum("ta,ta->t", along, velocity(blocks[:, 1], end) - velocity(blocks[:, 0], start))
        values["tie_elongation_rate"] = (("iteration", "tie"), rate[None])
    for name, (dims, array) in values.items():
        found[name] = (dims, array, found[name].attrs)
    return found
