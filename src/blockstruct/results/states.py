"""State of the interfaces: open, hinge, sliding or sticking."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.vocabulary import ContactState

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


def contact_state(history: xr.Dataset, tolerance: float = 1e-4) -> xr.DataArray:
    """State of every interface in every iteration, read from its forces and its part in the mechanism.

    ``open``: no contact point stays closed, or none is compressed. ``sliding``: a point that stays closed slips.
    ``hinge``: some points open, the others stay closed. ``sticking``: no relative motion. ``unknown``: the solver
    found no forces.

    Parameters
    ----------
    history
        History of a case, or a selection of its iterations.
    tolerance
        Relative velocity, and normal force, that count as zero: relative to the largest of the iteration.

    Returns
    -------
    xarray.DataArray
        Texts, dimensions (iteration, interface).
    """
    index = history["interface_of_contact_point"].to_numpy()
    starts = np.searchsorted(index, np.arange(history.sizes["interface"]))
    v = history["relative_velocity"].transpose(..., "contact_point", "component").to_numpy()
    n = history["contact_force"].sel(component="n").transpose(..., "contact_point").to_numpy()

    def threshold(values: Array) -> Array:
        return np.asarray(np.maximum(tolerance * values.max(axis=-1, keepdims=True), np.finfo(float).tiny))

    def any_of(points: Flags) -> Flags:
        return np.logical_or.reduceat(points, starts, axis=-1)

    speed = np.linalg.norm(v, axis=-1)
    opening = v[..., 0] > threshold(speed)
    slipping = ~opening & (np.linalg.norm(v[..., 1:], axis=-1) > threshold(speed))
    pressed = n > threshold(n)
    is_open = ~any_of(~opening) | ~any_of(pressed)
    state = np.select(
        [any_of(np.isnan(n)), is_open, any_of(slipping), any_of(opening)],
        [ContactState.UNKNOWN.value, ContactState.OPEN.value, ContactState.SLIDING.value, ContactState.HINGE.value],
        ContactState.STICKING.value,
    ).astype(object)
    dims = (
        *(d for d in history["contact_force"].dims if d not in ("contact_point", "component")),
        "interface",
    )
    coords = {
        name: history[name] for name in ("iteration", "stage", "interface") if set(history[name].dims) <= set(dims)
    }
    return xr.DataArray(state, dims=dims, coords=coords, name="contact_state")
