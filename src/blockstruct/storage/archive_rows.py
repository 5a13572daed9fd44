"""Rows of an archive: what attributes and scalars of a file tell of each of its cases."""

import json
from collections.abc import Iterable, Iterator
from typing import Any

import h5py
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from blockstruct.errors import FormatError
from blockstruct.model import JOINT_PROPERTIES
from blockstruct.results import CERTIFICATE_MEASURES, plain_value
from blockstruct.storage.analysis_file import AnalysisFile, member, parameters_of
from blockstruct.storage.case_group import versions_of
from blockstruct.storage.file_outline import plain
from blockstruct.units import SI_UNITS

#: A row of the table: a case, or a file that cannot be read.
Row = dict[str, Any]

#: Reactions of settlements, by their unit.
REACTIONS = {SI_UNITS["force"]: "reaction", SI_UNITS["moment"]: "reaction_moment"}
_NUMBERS = ("load_factor", "associative_load_factor", "n_iterations", "duration", *CERTIFICATE_MEASURES)
_TEXTS = ("status", "flow", "dead", "variable", "reason", "procedure", "started_at")
_FIRST = (
    "path",
    "case",
    "model",
    "model_hash",
    "load_factor",
    *REACTIONS.values(),
    "d0",
    "curve_end",
    *_NUMBERS[1:],
    "curve_ended",
    "settled",
    *_TEXTS,
    "created_at",
    "version",
    "tags",
    "study",
    "problem",
    *(f"joint_{name}" for name in JOINT_PROPERTIES),
)
#: Columns of the short view, before and behind the parameters.
_SHORT = (
    ("path", "case", "model"),
    ("load_factor", *REACTIONS.values(), "d0", "curve_end", "status", "settled", "flow", "n_iterations", "problem"),
)
#: Units of the columns that have one.
_UNITS = {
    "load_factor": "dimensionless",
    "associative_load_factor": "dimensionless",
    "duration": "second",
    "d0": "meter",
    "curve_end": "meter",
    **{name: unit for unit, name in REACTIONS.items()},
    **{f"joint_{name}": SI_UNITS[p.dimension] for name, p in JOINT_PROPERTIES.items()},
}
#: Values that a row is made of, at most: of joint materials.
_MOST = 1_000_000
#: Column that holds the units of the parameters of a row, which is none of the table.
_UNITS_OF_ROW = "units"


def rows_of(file: AnalysisFile) -> Iterator[Row]:
    """Rows of one file, without its path."""
    with file.opened() as groups:
        model = member(groups, "/model")
        of_file = {
            "model": plain(model.attrs["name"]),
            "model_hash": str(file.attrs["model_hash"]),
            "created_at": file.attrs["created_at"],
            "tags": tuple(json.loads(file.attrs["tags"])),
            "study": str(file.attrs.get("study", "")),
            "problem": "",
            **{f"joint_{name}": _of_all_joints(model, name) for name in JOINT_PROPERTIES},
            _UNITS_OF_ROW: {},
        }
        for name, value in parameters_of(file.attrs).items():
            of_file[f"parameter_{name}"], unit = plain_value(value)
            of_file[_UNITS_OF_ROW] |= {f"parameter_{name}": unit} if unit else {}
        for name, place in file.cases.items():
            case = member(groups, place)
            settings = json.loads(plain(case.attrs["settings"]))
            texts = {text: plain(case.attrs[text]) for text in _TEXTS}
            own = {key: plain(case.attrs[key]) for key in ("versions",) if key in case.attrs}
            made_by = [str(each.get("blockstruct")) for each in versions_of(own, json.loads(file.attrs["versions"]))]
            yield {
                **of_file,
                "case": name,
                "version": ", ".join(dict.fromkeys(made_by)),
                **{number: _scalar(case, place, number) for number in _NUMBERS if number in case},
                **_reaction(case, place),
                **(_curve(groups, file.curves[place]) if place in file.curves else {}),
                **texts,
                "curve_ended": plain(case.attrs["curve_ended"]) if "curve_ended" in case.attrs else "",
                "settled": bool(_scalar(case, place, "settled")),
                **flat("settings", settings),
            }


def flat(name: str, value: Any) -> Row:
    """Settings by the names of their columns, as ``settings_schedule_slope``."""
    if not isinstance(value, dict):
        return {name: value}
    return {key: v for part, within in value.items() for key, v in flat(f"{name}_{part}", within).items()}


def table_of(rows: Iterable[Row]) -> pd.DataFrame:
    """Table of rows, with all columns."""
    rows = list(rows)
    table = pd.DataFrame([{name: v for name, v in row.items() if name != _UNITS_OF_ROW} for row in rows])
    varied = sorted(c for c in table.columns if c.startswith("parameter_"))
    others = [c for c in table.columns if c not in (*_FIRST, *varied)]
    table = table.reindex(columns=[*_FIRST, *varied, *others])
    for column in ("started_at", "created_at"):
        table[column] = pd.to_datetime(table[column], utc=True, errors="coerce", format="ISO8601")
    units = {name: {row[_UNITS_OF_ROW].get(name) for row in rows if _UNITS_OF_ROW in row} for name in varied}
    # Values of other dimensions under one name are told apart by what the unit says.
    found = {name: " or ".join(sorted(filter(None, of_column))) for name, of_column in units.items()}
    table.attrs["units"] = _UNITS | {name: unit for name, unit in found.items() if unit}
    return table


def short_columns(table: pd.DataFrame) -> pd.DataFrame:
    """The columns that one looks at first: names, parameters, load factor and status."""
    before, behind = _SHORT
    return table[[*before, *(c for c in table.columns if c.startswith("parameter_")), *behind]]


def _of_all_joints(model: h5py.Group, name: str) -> float:
    """A property that all joint materials of a model share; NaN if they differ."""
    values = _values(model, "/model", name)
    return float(values.flat[0]) if values.size and (values == values.flat[0]).all() else np.nan


def _reaction(case: h5py.Group, place: str) -> Row:
    """The reaction of a settlement in the column of its unit; a load factor is none of its answers."""
    if "reaction" not in case:
        return {}
    reaction = _scalar(case, place, "reaction")
    return {"load_factor": np.nan, REACTIONS[plain(case["reaction"].attrs["units"])]: reaction}


def _curve(groups: h5py.File, place: str) -> Row:
    """How far a pushover came."""
    curve = member(groups, place)
    displacement = _values(curve, place, "displacement")
    return {
        "d0": _scalar(curve, place, "d0"),
        "curve_end": float(displacement.flat[-1]) if displacement.size else np.nan,
    }


def _scalar(case: h5py.Group, place: str, name: str) -> Any:
    number = _values(case, place, name)
    if number.shape != ():
        msg = f"{place}/{name}: {number.dtype} {number.shape} is not a number"
        raise FormatError(msg)
    value = number.item()
    return bool(value) if name == "holds" else value


def _values(group: h5py.Group, place: str, name: str) -> NDArray[Any]:
    """Values of a dataset of a group, never by a link to elsewhere.

    Read by the lower interface of h5py, which is several times as fast for so few.
    """
    key = name.encode()
    if key not in group.id or group.id.links.get_info(key).type != h5py.h5l.TYPE_HARD:
        msg = f"{place}/{name}: {name!r} is missing, or a link to elsewhere"
        raise FormatError(msg)
    dataset = h5py.h5o.open(group.id, key)
    if not isinstance(dataset, h5py.h5d.DatasetID) or dataset.dtype.kind not in "fiu" or np.prod(dataset.shape) > _MOST:
        msg = f"{place}/{name}: other than numbers, or too many of them"
        raise FormatError(msg)
    values = np.empty(dataset.shape, dataset.dtype)
    if values.size:
        dataset.read(h5py.h5s.ALL, h5py.h5s.ALL, values)
    return values
