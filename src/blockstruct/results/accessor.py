"""The methods of a history, ``history.blockstruct``, and histories and capacity curves as pandas tables."""

import importlib.util
from collections.abc import Collection, Hashable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from blockstruct.errors import ModelError, StorageError, UnknownNameError, check_known, shown
from blockstruct.files import csv_text, writing
from blockstruct.results import interfaces
from blockstruct.units import Q_
from blockstruct.vocabulary import ContactState, listed


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
        data = interfaces.contact_state(history).to_dataset(name="state")
    else:
        resultants = interfaces.interface_resultants(history)
        check_known(variable, [*map(str, history.data_vars), "state", *map(str, resultants)], "history: no variable")
        data = resultants[[variable]]
    if "contact_point" in data.dims:
        of_point = ("contact_point", data["contact_point"].to_numpy())
        data = data.drop_vars("contact_point").assign_coords(interface_of_contact_point=of_point)
    return _frame(data, {*data.dims, "stage", "interface_of_contact_point"})


def capacity_frame(capacity: xr.Dataset, variable: str | None = None) -> pd.DataFrame:
    """Return a capacity curve or a response as a table, units in the column names.

    Parameters
    ----------
    capacity
        The curve, the response to a record, or a selection of its states.
    variable
        A variable of it, such as ``tie_force``. None gives all that have one value per state, and for a response the
        ``largest_displacement`` of a block in each.

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
    what, dim, place = "capacity curve", "step", ["displacement"]
    if "time" in capacity.dims:
        what, dim, place = "response", "time", []
        largest = (capacity["displacement"] ** 2).sum("axis").max("block") ** 0.5
        capacity = capacity.assign(largest_displacement=largest.assign_attrs(units="meter"))
    names = [str(name) for name in capacity.data_vars if dim in capacity[name].dims]
    if variable is not None:
        check_known(variable, names, f"{what}: no variable")
    chosen = [variable] if variable else [name for name in names if capacity[name].dims == (dim,)]
    data = capacity[chosen].reset_coords(place)
    return _frame(data[[*place, *chosen]], set(data.dims))


def _frame(data: xr.Dataset, keep: Collection[Hashable]) -> pd.DataFrame:
    """Return the table of the variables, with some coordinates."""
    units = {str(name): data[name].attrs.get("units", "dimensionless") for name in data.variables}
    titles = {name: f"{name} [{unit}]" for name, unit in units.items() if unit != "dimensionless"}
    frame = data.drop_vars([c for c in data.coords if c not in keep]).to_dataframe()
    return frame.rename(columns=titles).rename_axis([titles.get(str(name), str(name)) for name in frame.index.names])


@xr.register_dataset_accessor("blockstruct")  # type: ignore[no-untyped-call]
class HistoryAccessor:
    """Methods of the history of a case, in memory or lazily on disk.

    Every Dataset has them as ``ds.blockstruct`` once blockstruct is imported.

    >>> import xarray as xr
    >>> xr.Dataset({"x": 1.0}).blockstruct
    Traceback (most recent call last):
        ...
    blockstruct.errors.ModelError: not the history of a case: it has no contact_force; give CaseResult.history
    """

    def __init__(self, ds: xr.Dataset) -> None:
        if "contact_force" not in ds:
            msg = "not the history of a case: it has no contact_force; give CaseResult.history"
            raise ModelError(msg)
        self._ds = ds

    def convergence(self) -> pd.DataFrame:
        """Return load factor, relative change and certificate by iteration.

        Returns
        -------
        pandas.DataFrame
            Indexed by iteration: ``stage``, ``load_factor``, ``change`` relative to the last load factor before it,
            ``equilibrium_residual``, ``yield_excess``, ``interpenetration``, ``flow_rule_gap``. A settlement also has
            its ``reaction`` (N or N·m).
        """
        names = ("load_factor", "equilibrium_residual", "yield_excess", "interpenetration", "flow_rule_gap")
        frame = self._ds[["stage", *names]].to_dataframe()[["stage", *names]]
        solved = frame["load_factor"].replace([np.inf, -np.inf], np.nan)
        # A loading path starts from zero; a relative change from zero is undefined.
        frame.insert(2, "change", solved / solved.ffill().shift().replace(0.0, np.nan) - 1)
        if "reaction" in self._ds:
            frame.insert(1, "reaction", self._ds["reaction"].to_numpy())
        return frame

    def interfaces(self, state: str, iteration: int = -1) -> list[str]:
        """Return the interfaces in a state, such as ``"sliding"``.

        The state may be combined with others. One iteration counts.

        Raises
        ------
        UnknownNameError
            If there is no such state or iteration.
        """
        position = self._position(iteration)
        history = self._ds.isel(iteration=[position])
        return [str(name) for name in history["interface"].to_numpy()[self._in_state(history, state)[0]]]

    def first(self, state: str) -> pd.Series:
        """Return the iteration in which each interface first had a state.

        Returns
        -------
        pandas.Series
            Iterations, indexed by the name of the interface, the earliest first.

        Raises
        ------
        UnknownNameError
            If there is no such state.
        """
        within = self._in_state(self._ds, state)
        ever = within.any(axis=0)
        first = self._ds["iteration"].to_numpy()[within.argmax(axis=0)[ever]] if len(within) else np.zeros(0, int)
        index = pd.Index(self._ds["interface"].to_numpy()[ever], name="interface")
        return pd.Series(first, index=index, name="iteration").sort_values(kind="stable")

    def top(self, n: int = 10, *, by: xr.DataArray | None = None, iteration: int = -1) -> pd.Series:
        """Return the interfaces with the largest values in one iteration.

        Parameters
        ----------
        n
            Number of interfaces.
        by
            Values that rank them, dimensions iteration and interface. By default the
            utilisation of sliding, :func:`blockstruct.results.utilisation`.
        iteration
            Which iteration.

        Returns
        -------
        pandas.Series
            Values, indexed by the name of the interface, the largest first; those without a value are left out.

        Raises
        ------
        UnknownNameError
            If there is no such iteration.
        """
        ranked = interfaces.utilisation(self._ds)["sliding"].transpose("iteration", "interface") if by is None else by
        position = self._position(iteration)
        values = ranked.isel(iteration=position).to_numpy()
        index = pd.Index(self._ds["interface"].to_numpy(), name="interface")
        series = pd.Series(values, index=index, name=ranked.name)
        return series.dropna().sort_values(ascending=False, kind="stable").head(n)

    def resultants(self, interface: str) -> dict[str, Any]:
        """Return the resultants of the forces on an interface in every iteration.

        Returns
        -------
        dict
            ``force`` (N, V_s, V_t) and ``moment`` (torsion M_n, bending M_s, M_t), each (iteration, component), and
            ``eccentricity`` (e_s, e_t) of N, (iteration, 2), as quantities.
        """
        resultants = interfaces.interface_resultants(self._ds).isel(interface=self._index_of(interface))
        return {str(name): _quantity(array) for name, array in resultants.data_vars.items()}

    def quantity(self, variable: str, **selection: Any) -> Any:
        """Return a variable as a quantity.

        For example ``quantity("contact_force", iteration=-1, component="n")``.

        Parameters
        ----------
        variable
            Its name.
        **selection
            Position in each dimension, or a name if the dimension has names.

        Raises
        ------
        UnknownNameError
            If the history does not have the variable or a name.
        """
        check_known(variable, map(str, self._ds.variables), "history: no variable")
        array = self._ds[variable]
        try:
            names = {d: v for d, v in selection.items() if isinstance(v, str)}
            array = array.sel(names).isel({d: v for d, v in selection.items() if d not in names})
        except (KeyError, ValueError, IndexError) as error:
            msg = f"history: {variable} has no {selection} ({error}); its dimensions are {dict(array.sizes)}"
            raise UnknownNameError(msg) from error
        return _quantity(array)

    def frame(self, variable: str | None = None) -> pd.DataFrame:
        """Return a variable as a table: :func:`blockstruct.results.history_frame`."""
        return history_frame(self._ds, variable)

    def export(self, path: str | Path, variable: str | None = None) -> Path:
        """Write the history to a ``.csv``, ``.parquet`` or ``.nc`` file.

        Parameters
        ----------
        path
            Its suffix sets the format. Parquet needs the package pyarrow. In a ``.csv`` file, a name that a spreadsheet
            would run as a formula begins with an apostrophe.
        variable
            See :meth:`frame`. Without a variable, a ``.nc`` file holds the whole history.

        Raises
        ------
        StorageError
            If the suffix is unknown, a package is missing, or the file cannot be written.
        """
        path = Path(path)
        kind = path.suffix.lower()
        if kind not in (".csv", ".parquet", ".nc"):
            msg = f"{path}: give a name that ends in .csv, .parquet or .nc"
            raise StorageError(msg)
        if kind == ".parquet" and importlib.util.find_spec("pyarrow") is None:
            msg = f"{path}: Parquet needs the package pyarrow; install it by `pip install pyarrow`, or give a .csv file"
            raise StorageError(msg)
        with writing(path):
            if kind == ".nc":
                ds = self._ds if variable is None else self._ds[[variable]]
                path.write_bytes(ds.to_netcdf(engine="h5netcdf"))
            elif kind == ".csv":
                path.write_text(csv_text(self.frame(variable)), encoding="utf-8")
            else:
                self.frame(variable).to_parquet(path)
        return path

    def _position(self, iteration: int) -> int:
        n = self._ds.sizes["iteration"]
        if not -n <= iteration < n:
            msg = f"history: no iteration {iteration}; it has {n}, from 0"
            raise UnknownNameError(msg)
        return iteration % n

    def _index_of(self, interface: str) -> int:
        names = self._ds["interface"].to_numpy()
        places = np.flatnonzero(names == interface)
        if not len(places):
            msg = f"history: no interface {shown(interface)}; it has {listed(names.tolist())}"
            raise UnknownNameError(msg)
        return int(places[0])

    @staticmethod
    def _in_state(history: xr.Dataset, state: str) -> np.ndarray:
        """Return whether interfaces have a state, (iteration, interface).

        The state may be alone or combined.
        """
        check_known(state, list(ContactState), "history: no state")
        states = interfaces.contact_state(history).transpose("iteration", "interface")
        return np.asarray(states.str.contains(state))


def _quantity(array: xr.DataArray) -> Any:
    return Q_(array.to_numpy(), array.attrs.get("units", "dimensionless"))
