"""Joints that crush in cells, and what that leaves of the lever of a block that rocks on them."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]


def cell_words(history: xr.Dataset) -> str:
    """How many joints crush in cells, and by how much that is on the safe side, as sentences; empty without any.

    Parameters
    ----------
    history
        Of a case: its contact points are corners or the centroids of cells.
    """
    strength, joint = history["cell_strength"].to_numpy(), history["compressive_strength"].to_numpy()
    index, is_cell = history["interface_of_contact_point"].to_numpy(), np.isfinite(strength)
    counts = np.bincount(index[is_cell], minlength=len(joint))
    in_cells, crushing = np.flatnonzero(counts), int(np.isfinite(joint).sum())
    if not len(in_cells):
        return ""
    largest = np.zeros(len(joint))
    np.maximum.at(largest, index[is_cell], strength[is_cell] / joint[index[is_cell]])
    lost = min(1.0, max(float(np.sqrt(largest[j])) / _width(history, int(j)) for j in in_cells))
    least, most = counts[in_cells].min(), counts[in_cells].max()
    each = f"{most}" if least == most else f"{least} to {most}"
    others = "; the others by exact conditions" if len(in_cells) < crushing else ""
    return (
        f"Joints that crush in cells: {len(in_cells)} of {crushing}, {each} cells each{others}. Cells are on the safe "
        "side: a block that rocks on them turns about the middle of their outer row, and loses up to about "
        f"{100 * lost:.0f} % of its lever, less with more crushing_cells."
    )


def _width(history: xr.Dataset, interface: int) -> float:
    """Least extent of an interface across one of its edges, m: half of it is the lever of a block that rocks there."""
    of_interface = history["interface_of_interface_corner"].to_numpy() == interface
    corners: Array = history["interface_corner_position"].to_numpy()[of_interface]
    across = np.cross(np.roll(corners, -1, axis=0) - corners, history["interface_frame"].to_numpy()[interface, 0])
    lengths = np.linalg.norm(across, axis=1)
    along = corners @ (across[lengths > 0] / lengths[lengths > 0, None]).T
    return float(np.ptp(along, axis=0).min())
