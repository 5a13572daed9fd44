"""Many analysis files as one table."""

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from blockstruct.errors import BlockstructError, FormatError, StorageError
from blockstruct.results import CERTIFICATE_MEASURES, relative_difference
from blockstruct.storage.analysis_file import AnalysisFile, member
from blockstruct.storage.case_group import group_name
from blockstruct.storage.claim import SUFFIX
from blockstruct.storage.file_outline import plain
from blockstruct.storage.lazy import lazy_history
from blockstruct.storage.lock import PARTIAL
from blockstruct.storage.query import selected
from blockstruct.storage.snapshot import Stamp, unreadable
from blockstruct.units import SI_UNITS

_NUMBERS = ("load_factor", "n_iterations", "duration", *CERTIFICATE_MEASURES)
_TEXTS = ("status", "flow", "dead", "variable", "message", "started_at")
#: Reactions of settlements, by their unit.
_REACTIONS = {SI_UNITS["force"]: "reaction", SI_UNITS["moment"]: "reaction_moment"}
#: Units of the columns that have one.
_UNITS = {"load_factor": "dimensionless", "duration": "second", **{name: unit for unit, name in _REACTIONS.items()}}


class Archive:
    """The analysis files of a folder and of its subfolders.

    Nothing is read before it is asked for, and for a table only attributes and scalars. Every question looks for files
    anew; what was read of a file is kept as long as the file does not change.

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
    >>> weakest = archive.query("status == 'converged' and load_factor < 0.2")  # doctest: +SKIP
    >>> histories = archive.history(weakest)  # doctest: +SKIP
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        if not self.folder.is_dir():
            msg = f"{self.folder}: no such folder; give the folder of the analysis files"
            raise StorageError(msg)
        self._known: dict[Path, tuple[Stamp, list[dict[str, Any]]]] = {}

    def __repr__(self) -> str:
        return f"Archive({str(self.folder)!r})"

    @property
    def paths(self) -> list[Path]:
        """All files ``*.h5``, in order."""
        return self._found()[0]

    def table(self) -> pd.DataFrame:
        """One row per case.

        Columns: ``path`` (relative to the folder), ``case``, ``model``, ``model_hash``, ``load_factor`` of limit cases,
        ``reaction`` (N) or ``reaction_moment`` (N·m) of settlements, ``status``, ``flow``, ``dead``,
        ``variable``, the measures of the certificate and whether it ``holds``, ``n_iterations``, ``started_at`` and
        ``created_at`` (UTC), ``duration`` (s), ``version`` of blockstruct, ``tags``, ``message``, a column
        ``settings_…`` for each setting, and ``problem``: why a file, which has one row then, cannot be read.
        A run that is under way or was killed has a row of that kind, too. The units of columns are in
        ``table.attrs["units"]``.
        """
        paths, problems = self._found()
        rows = [row for path in paths for row in self._rows(path)]
        rows += [
            {"path": path.relative_to(self.folder).as_posix(), "problem": problems[path]} for path in sorted(problems)
        ]
        numbers = ("load_factor", *_REACTIONS.values(), *_NUMBERS[1:])
        first = ("path", "case", "model", "model_hash", *numbers, *_TEXTS, "created_at", "version", "tags", "problem")
        table = pd.DataFrame(rows)
        table = table.reindex(columns=[*first, *(c for c in table.columns if c not in first)])
        for column in ("started_at", "created_at"):
            table[column] = pd.to_datetime(table[column], utc=True, errors="coerce", format="ISO8601")
        table.attrs["units"] = dict(_UNITS)
        return table

    def query(self, expression: str) -> pd.DataFrame:
        """Rows of the table by an expression, which is parsed and never evaluated.

        Parameters
        ----------
        expression
            Comparisons (``==``, ``!=``, ``<``, ``<=``, ``>``, ``>=``, ``in``, ``not in``) of columns with numbers,
            texts, True or False, joined by ``and``, ``or``, ``not``: ``"status == 'converged' and load_factor < 0.3"``,
            ``"case in ['push +x', 'push -x']"``, ``"'north' in tags"``, ``"created_at >= '2026-01-31'"``.

        Raises
        ------
        StorageError
            If the expression is any other, names a column that the table does not have, or compares one with a value of
            another kind.
        """
        return selected(self.table(), expression)

    def select(
        self,
        *,
        model_hash: str | None = None,
        tags: str | list[str] | tuple[str, ...] = (),
        since: str | None = None,
        until: str | None = None,
    ) -> pd.DataFrame:
        """Rows of the table by model, tags and date.

        Parameters
        ----------
        model_hash
            The hash, or how it begins.
        tags
            Tags that an analysis must all have.
        since, until
            Dates, or times, of creation in ISO 8601, UTC unless they say otherwise; both belong to the selection.

        Raises
        ------
        StorageError
            If a text is not a date.
        """
        table = self.table()
        wanted = {tags} if isinstance(tags, str) else set(tags)
        keep = table["tags"].map(lambda found: wanted <= set(found) if isinstance(found, tuple) else not wanted)
        if model_hash is not None:
            keep &= table["model_hash"].fillna("").str.startswith(model_hash)
        if since is not None:
            keep &= table["created_at"] >= _time(since)
        if until is not None:
            # A date alone means its whole day.
            day = pd.Timedelta(days=1) if len(until) == len("2026-01-31") else pd.Timedelta(microseconds=1)
            keep &= table["created_at"] < _time(until) + day
        return table[keep.astype(bool)]

    def history(self, selection: pd.DataFrame | str) -> xr.DataTree:
        """Histories of cases, as one lazy tree: a value is read from its file when it is used, and nothing else.

        Parameters
        ----------
        selection
            Rows of :meth:`table`, or an expression of :meth:`query`.

        Returns
        -------
        xarray.DataTree
            A node ``<path>/<case>`` for each case, its name escaped as in the file.

        Raises
        ------
        FormatError
            If a selected file violates its schema.
        """
        rows = self.query(selection) if isinstance(selection, str) else selection
        rows = rows[rows["case"].notna()]
        files = {path: self._opened(self.folder / path) for path in rows["path"].unique()}
        nodes = {}
        for path, case in zip(rows["path"], rows["case"], strict=True):
            nodes[f"{path}/{group_name(case)}"] = lazy_history(files[path], f"/cases/{group_name(case)}")
        return xr.DataTree.from_dict(nodes)

    def difference(self, other: "Archive") -> pd.DataFrame:
        """Cases of two archives side by side: of the same path and name, or in one of them only.

        Returns
        -------
        pandas.DataFrame
            Indexed by path and case: ``load_factor``, ``status``, ``model_hash`` and ``problem`` of each, with
            ``_other`` for the other one's; ``relative_difference`` of the load factor (0 where both are the same);
            and whether they ``agree``: both there and readable, of one model and status.
        """
        columns = ["load_factor", "status", "model_hash", "problem"]
        tables = (a.table().astype({"case": object}).fillna({"case": ""}) for a in (self, other))
        one, two = (table.set_index(["path", "case"])[columns] for table in tables)
        joined = one.join(two.add_suffix("_other"), how="outer")
        joined["relative_difference"] = relative_difference(joined["load_factor"], joined["load_factor_other"])
        joined["agree"] = joined["problem"].eq("") & joined["problem_other"].eq("")
        for column in ("status", "model_hash"):
            joined["agree"] &= joined[column].eq(joined[f"{column}_other"])
        return joined

    def _opened(self, path: Path) -> AnalysisFile:
        """A file, whose seal is checked once as long as the file stays what it is."""
        known = self._known.get(path)
        return AnalysisFile(path, verified=None if known is None else known[0])

    def _found(self) -> tuple[list[Path], dict[Path, str]]:
        """Files, and what else there is that is worth a row, with its problem."""
        files, problems = [], {}

        def locked(error: OSError, path: Path | None = None) -> None:
            # A folder that vanishes meanwhile is that of a run which has ended.
            if not isinstance(error, FileNotFoundError):
                problems[path or Path(error.filename)] = f"a folder that cannot be looked into ({error.strerror})"

        for place, folders, names in os.walk(self.folder, onerror=locked):
            files += [Path(place, name) for name in names if name.endswith(SUFFIX)]
            for name in [name for name in folders if name.endswith(PARTIAL)]:
                folders.remove(name)
                path = Path(place, name)
                try:
                    if (path / "plan").is_file():
                        problems[path.with_suffix("")] = "a run that is under way, or was killed: recover or resume it"
                except OSError as error:
                    locked(error, path.with_suffix(""))
        return sorted(files), problems

    def _rows(self, path: Path) -> list[dict[str, Any]]:
        relative = path.relative_to(self.folder).as_posix()
        try:
            known = self._known.get(path)
            if known is None or Stamp.at(path) != known[0]:
                file = self._opened(path)
                self._known[path] = known = (file.stamp, [{"path": relative, **row} for row in _cases(file)])
            return known[1]
        except BlockstructError as error:
            problem = str(error)
        except OSError as error:
            problem = str(unreadable(path, error))
        return [{"path": relative, "problem": problem.removeprefix(f"{path}: ")}]


def _cases(file: AnalysisFile) -> Iterator[dict[str, Any]]:
    """Rows of one file, from its attributes and scalars alone."""
    with file.opened() as groups:
        of_file = {
            "model": plain(member(groups, "/model").attrs["name"]),
            "model_hash": str(file.attrs["model_hash"]),
            "created_at": file.attrs["created_at"],
            "version": json.loads(file.attrs["versions"]).get("blockstruct"),
            "tags": tuple(json.loads(file.attrs["tags"])),
            "problem": "",
        }
        for name, place in file.cases.items():
            case = member(groups, place)
            settings = json.loads(plain(case.attrs["settings"]))
            yield {
                **of_file,
                "case": name,
                **{number: _scalar(groups, f"{place}/{number}") for number in _NUMBERS if number in case},
                **_reaction(groups, place),
                **{text: plain(case.attrs[text]) for text in _TEXTS},
                **{f"settings_{key}": value for key, value in settings.items()},
            }


def _reaction(groups: Any, place: str) -> dict[str, Any]:
    """The reaction of a settlement in the column of its unit; a load factor is none of its answers."""
    if "reaction" not in member(groups, place):
        return {}
    unit = plain(member(groups, f"{place}/reaction").attrs["units"])
    return {"load_factor": np.nan, _REACTIONS[unit]: _scalar(groups, f"{place}/reaction")}


def _scalar(groups: Any, place: str) -> Any:
    number = member(groups, place)
    if number.shape != () or number.dtype.kind not in "fiu":
        msg = f"{place}: {number.dtype} {number.shape} is not a number"
        raise FormatError(msg)
    value = np.asarray(number[()]).item()
    return bool(value) if place.endswith("/holds") else value


def _time(text: str) -> pd.Timestamp:
    try:
        return pd.to_datetime(text, utc=True, format="ISO8601")
    except (ValueError, TypeError) as error:
        msg = f"{text!r} is not a date; write ISO 8601, as in '2026-01-31' or '2026-01-31T12:00'"
        raise StorageError(msg) from error
