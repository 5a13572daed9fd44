"""Many analysis files as one table, its rows by a condition, and their histories."""

import ast
import json
import operator
import os
import re
import warnings
from collections.abc import Callable, Iterable, Iterator
from functools import reduce
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from blockstruct.errors import BlockstructError, FormatError, StorageError, shown
from blockstruct.files import MOST_READ, unreadable
from blockstruct.model import JOINT_PROPERTIES
from blockstruct.motion.state import CurveOutcome
from blockstruct.results import CERTIFICATE_MEASURES
from blockstruct.results.analysis import plain_value
from blockstruct.results.comparison import APART, relative_difference
from blockstruct.storage.file import ANALYSIS, PARTIAL, AnalysisFile, Stamp, parameters_of
from blockstruct.storage.layout import group_name, versions_of
from blockstruct.storage.netcdf import attributes, member, plain, read_numbers
from blockstruct.storage.run_folder import SUFFIX, is_unfinished
from blockstruct.units import SI_UNITS

#: A row of the table, a case or a file that cannot be read, by column.
Row = dict[str, Any]

#: Reactions of settlements, by their unit.
REACTIONS = {SI_UNITS["force"]: "reaction", SI_UNITS["moment"]: "reaction_moment"}
_OF_RECORDS = ("peak_displacement", "collapse_time")
_NUMBERS = ("load_factor", "associative_load_factor", "n_iterations", "duration", *CERTIFICATE_MEASURES, *_OF_RECORDS)
_TEXTS = ("status", "flow", "dead", "variable", "reason", "procedure", "started_at")
_JOINTS = {f"joint_{name}": p.dimension for name, p in JOINT_PROPERTIES.items()}
_FIRST = (
    *("path", "case", "model", "model_hash", "load_factor", *REACTIONS.values(), "d0", "curve_end", *_NUMBERS[1:]),
    *("curve_ended", "settled", *_TEXTS, "created_at", "version", "tags", "study", "problem", *_JOINTS),
)
#: Columns of the short table, before and after the parameters.
_SHORT = (
    ("path", "case", "model"),
    (
        *("load_factor", *REACTIONS.values(), "d0", "curve_end", *_OF_RECORDS),
        *("status", "settled", "flow", "n_iterations", "problem"),
    ),
)
#: Units of the columns that have one.
_UNITS = {
    **dict.fromkeys(("load_factor", "associative_load_factor"), "dimensionless"),
    **dict.fromkeys(("d0", "curve_end", "peak_displacement"), "meter"),
    **dict.fromkeys(("duration", "collapse_time"), "second"),
    **{name: unit for unit, name in REACTIONS.items()},
    **{name: SI_UNITS[dimension] for name, dimension in _JOINTS.items()},
}
#: Member of a row with the units of its parameters; it is no column of the table.
_UNITS_OF_ROW = "units"
_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}


class Archive:
    """The analysis files of a folder and of its subfolders; links to folders are not followed.

    Files are read on demand, and for a table only their attributes and scalars. Every method looks for files anew. Rows
    are kept until their file changes.

    Parameters
    ----------
    folder
        Folder of files ``*.h5``.

    Raises
    ------
    StorageError
        If there is no such folder.

    Examples
    --------
    >>> archive = Archive(".")
    >>> weakest = archive.select("status == 'converged' and load_factor < 0.2")  # doctest: +SKIP
    >>> histories = archive.history(weakest)  # doctest: +SKIP
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        if not self.folder.is_dir():
            msg = f"{self.folder}: no such folder; give the folder of the analysis files"
            raise StorageError(msg)
        self._known: dict[Path, tuple[Stamp, list[Row]]] = {}

    def __repr__(self) -> str:
        return f"Archive({str(self.folder)!r})"

    def table(self, *, all_columns: bool = False) -> pd.DataFrame:
        """One row per case.

        Columns: ``path`` (relative to the folder), ``case``, ``model``, a column ``parameter_…`` for each parameter
        that an analysis was made with, ``load_factor`` of limit cases, ``reaction`` (N) or ``reaction_moment`` (N·m) of
        settlements, ``d0`` and ``curve_end`` (m) of pushovers, of which the second is the displacement of their last
        state, ``peak_displacement`` (m) and ``collapse_time`` (s) of records, ``status``, ``settled``, false where the
        load factor had not settled when the procedure ended, ``flow``, ``n_iterations`` and ``problem``: why a file,
        which has one row then, cannot be read. A run that is under way or was killed has a row of that kind, too. The
        units of columns, coherent SI, are in ``table.attrs["units"]``.

        Parameters
        ----------
        all_columns
            Also ``model_hash``, ``associative_load_factor``, ``duration`` (s), the measures of the certificate and
            whether it ``holds``, ``curve_ended``, why a pushover went no further, ``dead``, ``variable``, ``reason``,
            ``procedure``, ``started_at`` and ``created_at`` (UTC), ``version``, ``tags``, ``study``, a column
            ``joint_…`` for each property of joints (NaN where the joint materials of a model differ in it) and
            ``settings_…`` for each setting.
        """
        paths, problems = self._found()
        rows = [row for path in paths for row in self.rows(path)]
        rows += [
            {"path": path.relative_to(self.folder).as_posix(), "problem": problems[path]} for path in sorted(problems)
        ]
        table = table_of(rows)
        return table if all_columns else short_columns(table)

    def rows(self, path: Path) -> list[dict[str, Any]]:
        """Return the rows of one file of the archive, by the names of the columns that it has."""
        relative = path.relative_to(self.folder).as_posix()
        try:
            stamp = Stamp.at(path)
            known = self._known.get(path)
            if known is None or stamp != known[0]:
                file = AnalysisFile(path)
                self._known[path] = known = (file.stamp, [{"path": relative, **row} for row in rows_of(file)])
            return known[1]
        except BlockstructError as error:
            problem = str(error)
        except OSError as error:
            problem = str(unreadable(path, error, ANALYSIS))
        return [{"path": relative, "problem": problem.removeprefix(f"{path}: ")}]

    def select(self, where: str | None = None, *, all_columns: bool = False) -> pd.DataFrame:
        """Return rows of the table by a condition.

        Parameters
        ----------
        where
            Comparisons of any columns with numbers or texts, in SI units, joined by ``and``, ``or`` and ``not``:
            ``"status == 'converged' and load_factor < 0.3"``, ``"case in ['push +x', 'push -x']"``, ``"'north' in
            tags"``, ``"created_at >= '2026-01-31'"``. Other characters of a name than letters and digits are written
            as ``_``: ``"parameter_blocks_top_height < 2"``. It is parsed, and never run as code.
        all_columns
            As in :meth:`table`.

        Raises
        ------
        StorageError
            If the condition is anything else, names no column, or compares one with a value of another kind.
        """
        table = self.table(all_columns=True)
        rows = table if where is None else rows_where(table, where)
        return rows if all_columns else short_columns(rows)

    def history(self, selection: pd.DataFrame | str) -> xr.DataTree:
        """Histories of cases, as one lazy tree: a value is read from its file when it is used, and nothing else.

        Parameters
        ----------
        selection
            Rows of :meth:`table`, or a condition as ``where`` of :meth:`select`.

        Returns
        -------
        xarray.DataTree
            A node ``<path>/<case>`` for each case, its name escaped as in the file.

        Raises
        ------
        FormatError
            If a selected file violates its schema.
        """
        rows = self.select(selection) if isinstance(selection, str) else selection
        rows = rows[rows["case"].notna()]
        files = {path: AnalysisFile(self.folder / path) for path in rows["path"].unique()}
        nodes = {}
        for path, case in zip(rows["path"], rows["case"], strict=True):
            nodes[f"{path}/{group_name(case)}"] = files[path].lazy_history(f"/cases/{group_name(case)}")
        return xr.DataTree.from_dict(nodes)

    def difference(self, other: "Archive") -> pd.DataFrame:
        """Compare the cases of two archives by path and name.

        Returns
        -------
        pandas.DataFrame
            Indexed by path and case: ``load_factor`` (of a settlement its reaction), its ``unit`` (N or N·m, empty of a
            load factor), ``status``, ``model_hash`` and ``problem`` of each, with ``_other`` for the other one's;
            ``relative_difference`` of the load factor (0 where both are the same); of pushovers ``d0``, ``curve_end``
            and ``end_difference``, the relative difference of d0 or, where the load factor did not come down to zero,
            of ``curve_end``, and of records that of ``peak_displacement``; and whether they ``agree``: both there and
            readable, of one model and status, and motions to the same end, within 1 %.
        """
        columns = ["load_factor", "unit", "status", "model_hash", "problem", "d0", "curve_end", "peak_displacement"]
        tables = (a.table(all_columns=True).astype({"case": object}).fillna({"case": ""}) for a in (self, other))
        one, two = (_answered(table).set_index(["path", "case"])[columns] for table in tables)
        joined = one.join(two.add_suffix("_other"), how="outer").fillna({"unit": "", "unit_other": ""})
        joined["relative_difference"] = relative_difference(joined["load_factor"], joined["load_factor_other"])
        ends = [
            joined[f"d0{suffix}"].fillna(joined[f"curve_end{suffix}"]).fillna(joined[f"peak_displacement{suffix}"])
            for suffix in ("", "_other")
        ]
        joined["end_difference"] = relative_difference(*ends)
        joined["agree"] = joined["problem"].eq("") & joined["problem_other"].eq("")
        joined["agree"] &= joined["end_difference"].abs().le(APART)
        joined["agree"] &= joined["d0"].isna().eq(joined["d0_other"].isna())
        for column in ("status", "model_hash"):
            joined["agree"] &= joined[column].eq(joined[f"{column}_other"])
        return joined

    def _found(self) -> tuple[list[Path], dict[Path, str]]:
        """Return files, and unfinished runs and closed folders with their problem."""
        files, problems = [], {}

        def locked(error: OSError) -> None:
            # A folder that vanishes meanwhile belonged to a run which has ended.
            if not isinstance(error, FileNotFoundError):
                problems[Path(error.filename)] = f"a folder that cannot be looked into ({error.strerror})"

        for place, folders, names in os.walk(self.folder, onerror=locked):
            files += [Path(place, name) for name in names if name.endswith(SUFFIX)]
            for name in [name for name in folders if name.endswith(PARTIAL)]:
                folders.remove(name)
                path = Path(place, name.removesuffix(PARTIAL))
                try:
                    if is_unfinished(path):
                        problems[path] = "a run that is under way, or was killed: recover or resume it"
                except StorageError as error:
                    problems[path] = str(error)
        return sorted(files), problems


def _answered(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with the reactions of settlements as load factors, and their units."""
    answers = table[["load_factor", *REACTIONS.values()]]
    unit = pd.Series("", index=table.index)
    for column, symbol in zip(REACTIONS.values(), ("N", "N·m"), strict=True):
        unit = unit.mask(table[column].notna(), symbol)
    return table.assign(load_factor=answers.bfill(axis=1).iloc[:, 0], unit=unit)


def rows_of(file: AnalysisFile) -> Iterator[Row]:
    """Return the rows of one file, without its path."""
    with file.opened() as groups:
        model, versions = member(groups, "/model"), json.loads(file.attrs["versions"])
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
            attrs = attributes(case.id)
            outcome = CurveOutcome.read(attrs.get("curve_ended", ""))
            made_by = [str(each.get("blockstruct")) for each in versions_of(attrs, versions)]
            yield {
                **of_file,
                "case": name,
                "version": ", ".join(dict.fromkeys(made_by)),
                **{number: _scalar(case, place, number) for number in _NUMBERS if number in case},
                **_reaction(case, place),
                **(_curve(groups, f"{place}/capacity") if "capacity" in file.parts[place] else {}),
                **{text: attrs[text] for text in _TEXTS},
                "curve_ended": outcome.end.value if outcome else "",
                "settled": bool(_scalar(case, place, "settled")),
                **flat("settings", json.loads(attrs["settings"])),
            }


def flat(name: str, value: Any) -> Row:
    """Return settings by the names of their columns, as ``settings_schedule_slope``."""
    if not isinstance(value, dict):
        return {name: value}
    return {key: v for part, within in value.items() for key, v in flat(f"{name}_{part}", within).items()}


def table_of(rows: Iterable[Row]) -> pd.DataFrame:
    """Return the table of rows, with all columns."""
    rows = list(rows)
    table = pd.DataFrame([{name: v for name, v in row.items() if name != _UNITS_OF_ROW} for row in rows])
    varied = sorted(c for c in table.columns if c.startswith("parameter_"))
    others = [c for c in table.columns if c not in (*_FIRST, *varied)]
    table = table.reindex(columns=[*_FIRST, *varied, *others])
    for column in ("started_at", "created_at"):
        table[column] = pd.to_datetime(table[column], utc=True, errors="coerce", format="ISO8601")
    units = {name: {row[_UNITS_OF_ROW].get(name) for row in rows if _UNITS_OF_ROW in row} for name in varied}
    # One name may hold values of several dimensions, each with its unit.
    joined = {name: " or ".join(sorted(filter(None, of_column))) for name, of_column in units.items()}
    table.attrs["units"] = _UNITS | {name: unit for name, unit in joined.items() if unit}
    return table


def short_columns(table: pd.DataFrame) -> pd.DataFrame:
    """Return the short table: names, parameters, load factor and status."""
    before, after = _SHORT
    return table[[*before, *(c for c in table.columns if c.startswith("parameter_")), *after]]


def _of_all_joints(model: h5py.Group, name: str) -> float:
    """Return a property that all joint materials of a model share; NaN if they differ."""
    values = _values(model, "/model", name)
    return float(values.flat[0]) if values.size and (values == values.flat[0]).all() else np.nan


def _reaction(case: h5py.Group, place: str) -> Row:
    """Return the reaction of a settlement in the column of its unit, and no load factor."""
    if "reaction" not in case:
        return {}
    reaction = _scalar(case, place, "reaction")
    return {"load_factor": np.nan, REACTIONS[plain(case["reaction"].attrs["units"])]: reaction}


def _curve(groups: h5py.File, place: str) -> Row:
    """Return the end of a pushover."""
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
    """Return the values of a dataset of a group; links to elsewhere are refused."""
    key = name.encode()
    if key not in group.id or group.id.links.get_info(key).type != h5py.h5l.TYPE_HARD:
        msg = f"{place}/{name}: {name!r} is missing, or a link to elsewhere"
        raise FormatError(msg)
    dataset = h5py.h5o.open(group.id, key)
    if (
        not isinstance(dataset, h5py.h5d.DatasetID)
        or dataset.dtype.kind not in "fiu"
        or np.prod(dataset.shape) > MOST_READ
    ):
        msg = f"{place}/{name}: other than numbers, or too many of them"
        raise FormatError(msg)
    return read_numbers(dataset)


def rows_where(table: pd.DataFrame, where: str) -> pd.DataFrame:
    """Return the rows of a table for which a condition holds.

    Parameters
    ----------
    table
        The table.
    where
        Comparisons of a column with numbers or texts, joined by ``and``, ``or`` and ``not``. A column may be ``in`` a
        list, and a text ``in`` a column of texts or tags. Other characters of a name than letters and digits are
        written as ``_``. A missing value differs from every other, and is neither less nor greater.

    Raises
    ------
    StorageError
        If the condition is anything else, names no column, or compares one with a value of another kind.
    """
    try:
        if not isinstance(where, str) or len(where) > MOST_READ:
            msg = f"it is not a text of at most {MOST_READ} characters"
            raise TypeError(msg)
        with warnings.catch_warnings(action="error"):
            return table[_mask(ast.parse(where.strip(), mode="eval").body, table)]
    except (ArithmeticError, MemoryError, RecursionError, SyntaxError, TypeError, ValueError, Warning) as error:
        example = "\"status == 'converged' and load_factor < 0.3\", \"case in ['push +x']\" or \"'north' in tags\""
        msg = f"where {shown(where)}: {error}; compare columns with numbers or texts, as in {example}"
        raise StorageError(msg) from error


def _mask(node: ast.expr, table: pd.DataFrame) -> "pd.Series[bool]":
    match node:
        case ast.BoolOp(op=op, values=values):
            join = operator.and_ if isinstance(op, ast.And) else operator.or_
            return reduce(join, [_mask(value, table) for value in values])
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return ~_mask(operand, table)
        case ast.Compare(left=left, ops=ops, comparators=comparators):
            sides = [_side(side, table) for side in (left, *comparators)]
            return reduce(operator.and_, map(_compared, sides, ops, sides[1:]))
    msg = f"{type(node).__name__} is no comparison"
    raise ValueError(msg)


def _side(node: ast.expr, table: pd.DataFrame) -> Any:
    """Return the column, number, text or list that a side of a comparison stands for."""
    if isinstance(node, ast.Name):
        columns = [name for name in table.columns if re.sub(r"\W", "_", name) == node.id]
        if len(columns) == 1:
            return table[columns[0]]
        msg = f"{len(columns)} columns are named {node.id!r}, those of the table are {', '.join(table.columns)}"
        raise ValueError(msg)
    value = ast.literal_eval(node)
    return [_constant(each) for each in value] if isinstance(value, list | tuple | set) else _constant(value)


def _constant(value: Any) -> str | float:
    if isinstance(value, str):
        return value
    if isinstance(value, int | float):
        return float(value)
    msg = f"{shown(value)} is neither a number nor a text"
    raise TypeError(msg)


def _compared(one: Any, op: ast.cmpop, other: Any) -> "pd.Series[bool]":
    if isinstance(op, ast.NotIn):
        return ~_compared(one, ast.In(), other)
    compare = _COMPARISONS.get(type(op))
    match one, other:
        case pd.Series(), list() if isinstance(op, ast.In):
            nowhere = pd.Series(False, index=one.index)
            return reduce(operator.or_, [_compared(one, ast.Eq(), value) for value in other], nowhere)
        case str(), pd.Series() if isinstance(op, ast.In):
            return other.map(lambda cell: isinstance(cell, str | tuple) and one in cell).astype(bool)
        case (pd.Series() as column, str() | float() as value) | (str() | float() as value, pd.Series() as column) if (
            compare
        ):
            present = column.dropna()
            mask = pd.Series(isinstance(op, ast.NotEq), index=column.index)
            if not present.empty:
                _check_kind(present, value)
                mask[present.index] = compare(present, value) if column is one else compare(value, present)
            return mask
    msg = "a comparison needs a column on one side, and a number, a text or for 'in' a list on the other"
    raise TypeError(msg)


def _check_kind(column: "pd.Series[Any]", value: str | float) -> None:
    """Refuse a value of another kind: pandas finds it equal to nothing, in silence."""
    try:
        operator.lt(column, value)
    except TypeError as error:
        msg = f"column {column.name!r} holds no values that could be compared with {shown(value)}"
        raise TypeError(msg) from error
