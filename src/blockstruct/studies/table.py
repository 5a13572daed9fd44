"""The rows of a study as an xarray.Dataset."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from blockstruct.errors import ModelError
from blockstruct.studies.design import GRID, Design
from blockstruct.studies.plan import Problem

#: Status of a case of a failed run, or of a run that another study is carrying out. It is not a status of a limit case.
FAILED, ELSEWHERE = "failed", "elsewhere"
_NONE = {"units": "dimensionless"}
_NUMBERS: Mapping[str, dict[str, str]] = {
    "load_factor": _NONE | {"long_name": "load factor α"},
    "bound": _NONE | {"long_name": "associative load factor, an upper bound of every flow rule"},
    "settled": _NONE | {"long_name": "1 if the load factor had settled when the procedure ended"},
    "flow_rule_gap": _NONE | {"long_name": "flow-rule gap of the certificate"},
    "n_iterations": _NONE | {"long_name": "programs"},
    "reaction": {"units": "newton", "long_name": "reaction of a settlement"},
    "reaction_moment": {"units": "newton * meter", "long_name": "reaction of a settlement that turns"},
    "d0": {"units": "meter", "long_name": "displacement of a pushover at which the load factor is zero"},
    "curve_end": {"units": "meter", "long_name": "displacement of the last state of a pushover"},
    "peak_displacement": {"units": "meter", "long_name": "largest displacement of a block under a record"},
    "collapse_time": {"units": "second", "long_name": "time of a record at which a block has fallen"},
    "duration": {"units": "second", "long_name": "wall-clock time of the case"},
}
_TEXTS = ("status", "flow", "reason", "procedure", "curve_ended")
#: Variables that every case of a run has.
_OF_CASE = (*_NUMBERS, *_TEXTS)
_OF_RUN = ("problem", "path", "elsewhere")
_TAKEN = {"run", "case", "missing_curve", *_OF_CASE, *_OF_RUN}
_REACTIONS = {"reaction", "reaction_moment"}
#: Numbers that only some kinds of cases have.
_OF_SOME = (*_REACTIONS, "d0", "curve_end", "peak_displacement", "collapse_time")
_COLUMNS = {"bound": "associative_load_factor"}


def check_parameter_names(names: Iterable[str]) -> None:
    """Refuse parameters with the names of variables of a study.

    Raises
    ------
    ModelError
    """
    taken = [name for name in names if name in _TAKEN]
    if taken:
        msg = (
            f"study: {'parameter' if len(taken) == 1 else 'parameters'} {', '.join(taken)}: what a study gives has "
            f"these names itself: {', '.join(sorted(_TAKEN))}; give build other ones, as {taken[0]}_of_build"
        )
        raise ModelError(msg)


def dataset_of(design: Design, rows: Sequence[Sequence[Mapping[str, Any]]], problems: Sequence[Problem]) -> xr.Dataset:
    """Return the dataset of a study.

    Parameters
    ----------
    design
        Design of its runs.
    rows
        Rows of the archive, for each run.
    problems
        Why a run has no results; false if it has results.
    """
    cases = list(dict.fromkeys(str(row["case"]) for of_run in rows for row in of_run))
    dims, shape = list(design.dims), list(design.dims.values())
    at = {case: j for j, case in enumerate(cases)}
    size = (len(rows), len(cases))
    numbers = {name: np.full(size, np.nan) for name in _NUMBERS}
    texts = {name: np.full(size, "", dtype=object) for name in _TEXTS}
    for statuses, problem in zip(texts["status"], problems, strict=True):
        if problem:
            statuses[:] = _status_of(problem.is_elsewhere)
    paths = np.array([of_run[0]["path"] if of_run else "" for of_run in rows], dtype=object)
    for i, of_run in enumerate(rows):
        for row in of_run:
            for name, values in (*numbers.items(), *texts.items()):
                values[i, at[row["case"]]] = row.get(_COLUMNS.get(name, name), values[i, at[row["case"]]])
            if not _REACTIONS.isdisjoint(row):
                # The bound of a reaction is not a load factor.
                numbers["bound"][i, at[row["case"]]] = np.nan
    along = [*dims, "case"]
    for name in _OF_SOME:
        if np.isnan(numbers[name]).all():
            del numbers[name]
    variables: dict[str, Any] = {n: (along, v.reshape(*shape, -1), _NUMBERS[n]) for n, v in numbers.items()}
    variables |= {n: (along, v.reshape(*shape, -1)) for n, v in texts.items()}
    why, elsewhere = np.array([p.text for p in problems], dtype=object), np.array([p.is_elsewhere for p in problems])
    variables["problem"] = (dims, why.reshape(shape), {"long_name": "why a run has no results"})
    variables["elsewhere"] = (dims, elsewhere.reshape(shape), {"long_name": "another study is carrying the run out"})
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
    of_all: dict[str, Any] = {"sampling": design.sampling} | ({} if design.seed is None else {"seed": design.seed})
    return xr.Dataset(variables, coords=coords, attrs=of_all)


def _status_of(is_elsewhere: bool) -> str:
    """Return the status of the cases of a run without results."""
    return ELSEWHERE if is_elsewhere else FAILED


def frame_of(data: xr.Dataset) -> pd.DataFrame:
    """Return the rows of a study as a table, one per case of each run.

    A run that failed before it had cases has one row.

    Parameters
    ----------
    data
        Dataset from :func:`blockstruct.study`.

    Returns
    -------
    pandas.DataFrame
        ``run``, the parameters, ``case``, the variables of the study. ``settled`` is false if the load factor had not
        settled when the procedure ended. ``missing_curve`` is why a pushover with a collapse state has no capacity
        curve, otherwise empty. ``attrs["units"]`` has the units.
    """
    of_case = [name for name in _OF_CASE if name in data]
    parameters = [str(name) for name in data.coords if name not in ("run", "case")]
    cases, along = data["case"].to_numpy(), data["problem"].dims
    of_run = {name: data[name].broadcast_like(data["problem"]).transpose(*along) for name in (*parameters, *_OF_RUN)}
    runs = {name: values.to_numpy().ravel() for name, values in of_run.items()}
    # If every run failed, there are no cases.
    size = (data["problem"].size, len(cases))
    columns = {name: data[name].transpose(*along, "case").to_numpy().reshape(size) for name in of_case}
    rows = []
    for k, problem in enumerate(runs["problem"]):
        held = {name: runs[name][k] for name in parameters}
        present = [j for j in range(len(cases)) if columns["status"][k, j] not in ("", FAILED, ELSEWHERE)]
        held |= {"run": k, "problem": problem, "path": runs["path"][k]}
        rows += [{**held, "case": cases[j], **{name: columns[name][k, j] for name in of_case}} for j in present]
        if not present:
            rows.append({**held, "case": "", "load_factor": np.nan, "status": _status_of(runs["elsewhere"][k])})
    table = pd.DataFrame(rows, columns=["run", *parameters, "case", *of_case, "problem", "path"])
    table["settled"] = table["settled"] == 1
    without = table["curve_end"].isna() if "curve_end" in table else np.ones(len(table), dtype=bool)
    table["missing_curve"] = [
        str(ended) if is_missing else "" for ended, is_missing in zip(table["curve_ended"], without, strict=True)
    ]
    units = {name: data[name].attrs.get("units") for name in (*parameters, *of_case)}
    table.attrs["units"] = {name: unit for name, unit in units.items() if unit}
    return table
