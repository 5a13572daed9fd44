"""Notes on joints whose conditions approximate crushing or torsion: cells, rectangles, contact points."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.results.interfaces import beyond_rectangle
from blockstruct.text import Note, biaxial_note, cells_note

Array = NDArray[np.float64]

#: Mean pressures, in multiples of the strength, between which the lost lever is measured.
_LEAST, _MOST = 0.001, 0.5
#: Directions of bending in addition to the normals of the edges; depths of stress blocks relative to the joint's depth.
_ANGLES = np.linspace(0, 2 * np.pi, 24, endpoint=False)
_AROUND = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
_DEPTHS = (1 - np.cos(np.linspace(0, np.pi, 101))) / 2
#: Eccentricity, in multiples of the limit of the effective rectangle, from which it is reported.
_BEYOND = 1.005


def crushing_in_cells(history: xr.Dataset, *, is_reaction: bool = False) -> Note | None:
    """Return the note on joints that crush in cells; None without any.

    Parameters
    ----------
    history
        History of a case.
    is_reaction
        Whether the answer is the least reaction of a support.
    """
    index, is_cell = history["interface_of_contact_point"].to_numpy(), np.isfinite(history["cell_strength"].to_numpy())
    counts = np.bincount(index[is_cell], minlength=history.sizes["interface"])
    in_cells = np.flatnonzero(counts)
    if not len(in_cells):
        return None
    crushing = int(np.isfinite(history["compressive_strength"].to_numpy()).sum())
    lost = max(lost_lever(history, int(j)) for j in in_cells)
    cells = int(counts[in_cells].min()), int(counts[in_cells].max())
    return cells_note(len(in_cells), crushing, cells, lost, is_reaction=is_reaction)


def lost_lever(history: xr.Dataset, interface: int) -> float:
    """Return the largest share of the lever M / N that cells lose.

    All directions are compared.
    """
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
        area, static = parts_beyond(corners, u, _DEPTHS)
        pressed, moment = area / area[-1], static / area[-1]
        usual = (pressed >= _LEAST) & (pressed <= _MOST)
        order = np.argsort(-(cells @ u))
        borne = np.cumsum(strength[order]) / strength.sum()
        of_cells = np.cumsum((strength * (cells @ u))[order]) / strength.sum()
        of_pressed = np.interp(pressed, np.append(0, borne), np.append(0, of_cells))
        lost = max(lost, float((1 - of_pressed[usual] / moment[usual]).max(initial=0.0)))
    return lost


def parts_beyond(corners: Array, direction: Array, depths: Array) -> tuple[Array, Array]:
    """Return areas and first moments of the parts of a polygon beyond lines.

    Parameters
    ----------
    corners : (k, 2) array
        Corners of the polygon, convex or not.
    direction : (2,) array
        Its length is the unit of lengths along it.
    depths : (m,) array
        Depths of the parts, relative to the depth of the polygon.

    Returns
    -------
    areas, moments : (m,) arrays
        Moments are taken about the origin.
    """
    along, side = corners @ direction, corners @ np.array([direction[1], -direction[0]])
    lines = along.max() - np.ptp(along) * depths
    y0 = along - lines[:, None]
    y1, dx = np.roll(y0, -1, axis=1), np.roll(side, -1) - side
    p, q = np.maximum(y0, 0), np.maximum(y1, 0)
    # The part of each edge beyond the line.
    part = dx * np.divide(q - p, y1 - y0, out=(p > 0).astype(float), where=y1 != y0)
    area, moment = (part * (p + q)).sum(axis=1) / 2, (part * (p**2 + p * q + q**2)).sum(axis=1) / 6
    turns = np.sign(area[np.abs(area).argmax()])
    return turns * area, turns * (moment + lines * area)


def biaxial_crushing(history: xr.Dataset, *, is_reaction: bool = False) -> Note | None:
    """Return the note on joints beyond their effective rectangle, or None.

    Parameters
    ----------
    history
        History of a case whose rectangles limit crushing about each axis separately.
    is_reaction
        Whether the answer is the least reaction of a support.
    """
    times = beyond_rectangle(history)
    beyond = times[times > _BEYOND].sort_values(ascending=False)
    if beyond.empty:
        return None
    return biaxial_note([str(name) for name in beyond.index], float(beyond.iloc[0]), is_reaction=is_reaction)
