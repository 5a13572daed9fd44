"""Histories and capacity curves as pandas tables."""

from collections.abc import Collection, Hashable

import pandas as pd
import xarray as xr

from blockstruct.errors import ModelError, UnknownNameError, shown
from blockstruct.results.interfaces import contact_state, interface_resultants


def history_frame(history: xr.Dataset, variable: str | None = None) -> pd.DataFrame:
    """Return the history of a case as a table, units in the column names.

    Parameters
    ----------
    history
        History of a case, or a selection of its iterations.
    variable
        A variable of the history, or ``state``, ``force``, ``moment`` or ``eccentricity`` of the interfaces. None
        gives all variables that have one value per iteration.

    Raises
    ------
    UnknownNameError
        If there is no such variable.
    """
    if variable is None:
        data = history[[name for name in history.data_vars if history[name].dims == ("iteration",)]]
    elif variable in history.data_vars:
        data = history[[variable]]
    elif variable == "state":
        data = contact_state(history).to_dataset(name="state")
    elif variable in ("force", "moment", "eccentricity"):
        data = interface_resultants(history)[[variable]]
    else:
        known = [*map(str, history.data_vars), "state", "force", "moment", "eccentricity"]
        msg = f"history: no variable {shown(variable)}; it has {', '.join(known)}"
        raise UnknownNameError(msg)
    if "contact_point" in data.dims:
        of_point = ("contact_point", data["contact_point"].to_numpy())
        data = data.drop_vars("contact_point").assign_coords(interface_of_contact_point=of_point)
    return _frame(data, {*data.dims, "stage", "interface_of_contact_point"})


def capacity_frame(capacity: xr.Dataset, variable: str | None = None) -> pd.DataFrame:
    """Return a capacity curve as a table, units in the column names.

    Parameters
    ----------
    capacity
        The curve, or a selection of its states.
    variable
        A variable of the curve, such as ``tie_force``. None gives all that have one value per state.

    Raises
    ------
    UnknownNameError
        If there is no such variable.
    ModelError
        If the argument is not a curve, such as the None of a case without one.
    """
    if not isinstance(capacity, xr.Dataset):
        msg = f"capacity_frame: the curve is a {type(capacity).__name__}; give result.capacity of a case with one"
        raise ModelError(msg)
    names = [str(name) for name in capacity.data_vars if "step" in capacity[name].dims]
    if variable is not None and variable not in names:
        msg = f"capacity curve: no variable {shown(variable)}; it has {', '.join(names)}"
        raise UnknownNameError(msg)
    chosen = [variable] if variable else [name for name in names if capacity[name].dims == ("step",)]
    data = capacity[chosen].reset_coords("displacement")
    return _frame(data[["displacement", *chosen]], set(data.dims))


def _frame(data: xr.Dataset, keep: Collection[Hashable]) -> pd.DataFrame:
    """Return the table of the variables, with some coordinates."""
    units = {str(name): data[name].attrs.get("units", "dimensionless") for name in data.data_vars}
    frame = data.drop_vars([c for c in data.coords if c not in keep]).to_dataframe()
    return frame.rename(columns={name: f"{name} [{unit}]" for name, unit in units.items() if unit != "dimensionless"})
