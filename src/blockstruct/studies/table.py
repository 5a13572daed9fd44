"""The rows of a study as an xarray.Dataset."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.studies.design import GRID, Design

#: Status of a case of a run that failed: no status of a limit case.
FAILED = "failed"
_NONE = {"units": "dimensionless"}
_NUMBERS: Mapping[str, dict[str, str]] = {
    "load_factor": _NONE | {"long_name": "load factor α"},
    "bound": _NONE | {"long_name": "associative load factor, an upper bound of every flow rule"},
    "flow_rule_gap": _NONE | {"long_name": "flow-rule gap of the certificate"},
    "n_iterations": _NONE | {"long_name": "programs"},
    "duration": {"units": "second", "long_name": "wall-clock time of the case"},
}
_TEXTS = ("status", "flow", "message")
_COLUMNS = {"bound": "associative_load_factor"}


def dataset_of(design: Design, rows: Sequence[Sequence[Mapping[str, Any]]], problems: Sequence[str]) -> xr.Dataset:
    """Dataset of a study.

    Parameters
    ----------
    design
        Its runs.
    rows
        Of the archive, for each run.
    problems
        Why a run failed; empty if it did not.
    """
    cases = list(dict.fromkeys(str(row["case"]) for of_run in rows for row in of_run))
    dims, shape = list(design.dims), list(design.dims.values())
    at = {case: j for j, case in enumerate(cases)}
    size = (len(rows), len(cases))
    numbers = {name: np.full(size, np.nan) for name in _NUMBERS}
    texts = {name: np.full(size, "", dtype=object) for name in _TEXTS}
    texts["status"][[bool(p) for p in problems]] = FAILED
    paths = np.array([of_run[0]["path"] if of_run else "" for of_run in rows], dtype=object)
    for i, of_run in enumerate(rows):
        for row in of_run:
            for name, values in (*numbers.items(), *texts.items()):
                values[i, at[row["case"]]] = row.get(_COLUMNS.get(name, name), values[i, at[row["case"]]])
    along = [*dims, "case"]
    variables: dict[str, Any] = {n: (along, v.reshape(*shape, -1), _NUMBERS[n]) for n, v in numbers.items()}
    variables |= {n: (along, v.reshape(*shape, -1)) for n, v in texts.items()}
    variables["problem"] = (dims, np.array(problems, dtype=object).reshape(shape), {"long_name": "why a run failed"})
    variables["path"] = (dims, paths.reshape(shape), {"long_name": "file in the store"})
    coords: dict[str, Any] = {"case": np.array(cases, dtype=object)}
    if design.sampling != GRID:
        coords["run"] = np.arange(len(rows))
    for name, axis in design.axes.items():
        attrs = {"units": axis.unit} if axis.unit else {}
        coords[name] = (name if design.sampling == GRID else "run", axis.coordinate, attrs)
    for name, value in design.fixed.items():
        quantity = hasattr(value, "magnitude")
        coords[name] = ((), value.magnitude, {"units": str(value.units)}) if quantity else ((), value)
    attrs = {"sampling": design.sampling} | ({} if design.seed is None else {"seed": design.seed})
    return xr.Dataset(variables, coords=coords, attrs=attrs)
