"""What cells leave of the lever of a block that rocks on them."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Mean pressures, in multiples of the strength, between which lost levers are told.
_LEAST, _MOST = 0.001, 0.5
#: Directions of bending beside those across edges, and depths of stress blocks, in multiples of that of the joint.
_ANGLES = np.linspace(0, 2 * np.pi, 24, endpoint=False)
_AROUND = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
_DEPTHS = (1 - np.cos(np.linspace(0, np.pi, 101))) / 2


def lost_lever(history: xr.Dataset, interface: int) -> float:
    """Largest share of the lever M / N of the stress block that cells lose, in any direction at the usual pressures."""
    axes = history["interface_frame"].to_numpy()[interface, 1:]
    centroid = history["interface_position"].to_numpy()[interface]
    of_corner = history["interface_of_interface_corner"].to_numpy() == interface
    of_point = history["interface_of_contact_point"].to_numpy() == interface
    corners = (history["interface_corner_position"].to_numpy()[of_corner] - centroid) @ axes.T
    cells = (history["contact_point_position"].to_numpy()[of_point] - centroid) @ axes.T
    strength: Array = history["cell_strength"].to_numpy()[of_point]
    edges = np.roll(corners, -1, axis=0) - corners
    across = edges[np.linalg.norm(edges, axis=1) > 0] @ np.array([[0.0, -1], [1, 0]])
    lost = 0.0
    for u in (*across, *-across, *_AROUND):
        pressed, moment = _stress_blocks(corners, u)
        usual = (pressed >= _LEAST) & (pressed <= _MOST)
        order = np.argsort(-(cells @ u))
        borne = np.cumsum(strength[order]) / strength.sum()
        of_cells = np.cumsum((strength * (cells @ u))[order]) / strength.sum()
        found = np.interp(pressed, np.append(0, borne), np.append(0, of_cells))
        lost = max(lost, float((1 - found[usual] / moment[usual]).max(initial=0.0)))
    return lost


def _stress_blocks(corners: Array, u: Array) -> tuple[Array, Array]:
    """Shares of the area of a polygon beyond lines across a direction, from none to all, and their moments.

    Parameters
    ----------
    corners : (k, 2) array
        About the centroid of the polygon.
    u : (2,) array
        The direction, with lengths in multiples of its own.

    Returns
    -------
    shares, moments : (m,) arrays
        The moment is that about the centroid, per area of the polygon.
    """
    along, side = corners @ u, corners @ np.array([u[1], -u[0]])
    lines = along.max() - np.ptp(along) * _DEPTHS
    y0 = along - lines[:, None]
    y1, dx = np.roll(y0, -1, axis=1), np.roll(side, -1) - side
    p, q = np.maximum(y0, 0), np.maximum(y1, 0)
    # The part of each edge beyond the line.
    part = dx * np.divide(q - p, y1 - y0, out=(p > 0).astype(float), where=y1 != y0)
    area, moment = (part * (p + q)).sum(axis=1) / 2, (part * (p**2 + p * q + q**2)).sum(axis=1) / 6
    return area / area[-1], (moment + lines * area) / area[-1]
