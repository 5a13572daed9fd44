"""Resultants of the contact forces on each interface."""

import numpy as np
import xarray as xr

from blockstruct.units import SI_UNITS


def interface_resultants(history: xr.Dataset) -> xr.Dataset:
    """Return the resultants of every interface in every iteration.

    Forces act on the plus block; moments are about the centroid of the interface.

    Parameters
    ----------
    history
        History of a case, or a selection of its iterations.

    Returns
    -------
    xarray.Dataset
        ``force`` and ``moment``, component (n, s, t): N and V, torsion and bending. ``eccentricity``, component
        (s, t): point of action of N from the centroid; NaN unless N is compression.
    """
    index = history["interface_of_contact_point"].to_numpy()
    frame = history["interface_frame"].to_numpy()
    arm = history["contact_point_position"].to_numpy() - history["interface_position"].to_numpy()[index]
    local = xr.DataArray(np.einsum("kca,ka->kc", frame[index], arm), dims=("contact_point", "component"))
    f = history["contact_force"].transpose(..., "contact_point", "component")
    moment_at_point = xr.DataArray(
        np.cross(local.to_numpy(), f.to_numpy()), dims=f.dims, coords={"component": history["component"]}
    )

    starts = np.searchsorted(index, np.arange(history.sizes["interface"]))
    dims = (*f.dims[:-2], "interface", "component")
    coords = {
        n: history[n] for n in ("iteration", "stage", "interface", "component") if set(history[n].dims) <= set(dims)
    }

    def summed(values: xr.DataArray) -> xr.DataArray:
        return xr.DataArray(np.add.reduceat(values.to_numpy(), starts, axis=-2), dims=dims, coords=coords)

    force, moment = summed(f), summed(moment_at_point)
    normal = force.sel(component="n", drop=True)
    compressed = normal.where(normal > 0)
    # With r = e_s s + e_t t, r × N n = N (e_t s − e_s t).
    eccentricity = xr.concat(
        [
            -moment.sel(component="t", drop=True) / compressed,
            moment.sel(component="s", drop=True) / compressed,
        ],
        dim=xr.Variable("in_plane", np.array(["s", "t"], dtype=object)),
    ).transpose(..., "interface", "in_plane")
    return xr.Dataset(
        {
            "force": force.assign_attrs(units=SI_UNITS["force"], long_name="N, V_s, V_t on the plus block"),
            "moment": moment.assign_attrs(units=SI_UNITS["moment"], long_name="torsion M_n, bending M_s, M_t"),
            "eccentricity": eccentricity.assign_attrs(units=SI_UNITS["length"], long_name="e_s, e_t of N"),
        }
    )
