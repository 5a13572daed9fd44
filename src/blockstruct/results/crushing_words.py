"""What crushing does to a number, as sentences."""

import numpy as np
import xarray as xr

from blockstruct.results.crushing_cells import lost_lever
from blockstruct.results.utilisation import beyond_rectangle
from blockstruct.vocabulary import counted, listed

#: Eccentricity, in multiples of the limit of the effective rectangle, from which it is reported.
_BEYOND = 1.005
#: Names of joints that a sentence lists.
_LISTED = 3


def cell_words(history: xr.Dataset, *, is_reaction: bool = False) -> str:
    """How many joints crush in cells, and by how much that is on the safe side, as sentences; empty without any.

    Parameters
    ----------
    history
        Of a case: its contact points are corners or the centroids of cells.
    is_reaction
        Whether its answer is the least reaction of a support, which what joints do not take makes larger.
    """
    strength, joint = history["cell_strength"].to_numpy(), history["compressive_strength"].to_numpy()
    index, is_cell = history["interface_of_contact_point"].to_numpy(), np.isfinite(strength)
    counts = np.bincount(index[is_cell], minlength=len(joint))
    in_cells, crushing = np.flatnonzero(counts), int(np.isfinite(joint).sum())
    if not len(in_cells):
        return ""
    lost = max(lost_lever(history, int(j)) for j in in_cells)
    least, most = counts[in_cells].min(), counts[in_cells].max()
    each = counted(most, "cell") if least == most else f"{least} to {most} cells"
    others = "; the others by exact conditions" if len(in_cells) < crushing else ""
    side = "They leave too much of a reaction, and too narrow a range" if is_reaction else "Cells are on the safe side"
    return (
        f"Joints that crush in cells: {len(in_cells)} of {crushing}, {each} each{others}. {side}: a block that "
        f"rocks on them turns about the middle of their outer row, and loses up to about {100 * lost:.0f} % of its "
        "lever, less with more crushing_cells."
    )


def beyond_rectangle_words(history: xr.Dataset, *, is_reaction: bool = False) -> str:
    """Which joints bear more by their edges than by their effective rectangle, as sentences; empty if none do.

    Parameters
    ----------
    history
        Of a case whose rectangles crush by their edges, which bound bending about each axis by itself.
    is_reaction
        Whether its answer is the least reaction of a support, which what joints bear makes smaller.
    """
    found = beyond_rectangle(history)
    beyond = found[found > _BEYOND].sort_values(ascending=False)
    if beyond.empty:
        return ""
    names = listed([str(name) for name in beyond.index], _LISTED)
    side = "too small" if is_reaction else "too large"
    return (
        f"Joints bent about both axes ({names}) bear their force at up to {beyond.iloc[0]:.3g} times the eccentricity "
        "that their effective rectangle takes, as uniaxial interaction bounds bending about each axis by itself: the "
        f"number may be {side}, by no more than that where one joint decides. "
        'Run the case with crushing="conic" and crushing_interaction="biaxial".'
    )
