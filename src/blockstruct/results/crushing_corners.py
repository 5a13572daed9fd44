"""Crushing about both axes that the edges of rectangular joints bear, and their area at its strength would not."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import crushing_dissipation
from blockstruct.model import Model, listed
from blockstruct.results.torsion import sliding_rates

Array = NDArray[np.float64]

#: Share of the number from which on it is told: a bound from below, which may be a sixth of what a program finds.
WORTH_TELLING, LISTED = 0.005, 3
#: Part of that share from which on a joint is named.
_OF_ALL = 0.01


def corner_crushing(model: Model, history: xr.Dataset, cells: int) -> pd.Series:
    """Share of the load factor that each joint bears by its edges and not by the effective rectangle, at least.

    Each edge of a rectangle bounds bending about one axis, whatever that about the other is. The mechanism of the last
    iteration is one of joints that crush by the effective rectangle, too, ``N ≤ f_c (b1 − 2 |e1|)(b2 − 2 |e2|)``, and
    there it dissipates less. With associative flow the difference is what their load factor is less by, or it is less
    by more, as they will find another mechanism. It is in multiples of the load factor or, where it is larger, of the
    work of crushing.

    Parameters
    ----------
    model, history
        The structure, and the history of a case with a mechanism whose rectangles crush by their edges.
    cells
        Into which interfaces are divided, ``settings.crushing_cells``.

    Returns
    -------
    pandas.Series
        Indexed by interface, of those that crush by their edges.
    """
    last = history.isel(iteration=-1)
    index, J = last["interface_of_contact_point"].to_numpy(), last.sizes["interface"]
    starts = np.searchsorted(index, np.arange(J))
    strength = last["compressive_strength"].to_numpy()
    joints = np.flatnonzero(np.isfinite(strength) & ~np.isfinite(last["cell_strength"].to_numpy()[starts]))
    opening = last["relative_velocity"].sel(component="n").to_numpy()
    rate = last["dilatancy"].to_numpy() * sliding_rates(model, last, cells) - opening
    capacity = strength * last["interface_area"].to_numpy() + np.bincount(index, last["tensile_strength"].to_numpy(), J)
    at_corners = rate[starts[joints][:, None] + np.arange(4)]
    edges, rectangle = (crushing_dissipation(at_corners, capacity[joints], biaxial=b) for b in (False, True))
    scale = max(abs(float(last["load_factor"])), float(edges.sum()), np.finfo(float).tiny)
    names = pd.Index(last["interface"].to_numpy()[joints], name="interface")
    return pd.Series((edges - rectangle) / scale, index=names, name="share")


def corner_crushing_words(model: Model, history: xr.Dataset, cells: int, *, is_reaction: bool = False) -> str:
    """What the number of a case owes to edges that do not know of each other, as sentences; empty if it is little.

    ``is_reaction`` is whether it is the least reaction of a support, which is the smaller the more joints bear.
    """
    found = corner_crushing(model, history, cells).sort_values(ascending=False)
    share = float(found.sum())
    if not share > WORTH_TELLING:
        return ""
    names = listed([str(name) for name in found[found > share * _OF_ALL].index], LISTED)
    owed = "the reaction is too small" if is_reaction else f"some {share:.1%} of the load factor or more is due to it"
    return (
        f"Joints crush about both axes ({names}), and the conditions of their edges bear more there than their area at "
        f'its strength: {owed}. Run the case with crushing_interaction="biaxial" in the settings.'
    )
