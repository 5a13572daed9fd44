"""Many analysis files as one table."""

import os
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from blockstruct.errors import BlockstructError, StorageError
from blockstruct.results import relative_difference
from blockstruct.storage.analysis_file import AnalysisFile
from blockstruct.storage.archive_rows import REACTIONS, Row, rows_of, short_columns, table_of
from blockstruct.storage.case_group import group_name
from blockstruct.storage.claim import SUFFIX
from blockstruct.storage.lazy import lazy_history
from blockstruct.storage.lock import PARTIAL
from blockstruct.storage.snapshot import Stamp, unreadable
from blockstruct.storage.where import rows_where

#: Relative difference of the ends of two pushovers that are the same.
SAME_END = 1e-2


class Archive:
    """The analysis files of a folder and of its subfolders; links to folders are not followed.

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

    @property
    def paths(self) -> list[Path]:
        """All files ``*.h5``, in order."""
        return self._found()[0]

    def table(self, *, all_columns: bool = False) -> pd.DataFrame:
        """One row per case.

        Columns: ``path`` (relative to the folder), ``case``, ``model``, a column ``parameter_…`` for each parameter
        that an analysis was made with, ``load_factor`` of limit cases, ``reaction`` (N) or ``reaction_moment`` (N·m) of
        settlements, ``d0`` and ``curve_end`` (m) of pushovers, of which the second is the displacement of their last
        state, ``status``, ``settled``, false where the load factor had not settled when the procedure
        ended, ``flow``, ``n_iterations`` and ``problem``: why a file, which has one row then, cannot be read. A run
        that is under way or was killed has a row of that kind, too. The units of columns, coherent SI, are in
        ``table.attrs["units"]``.

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
        """Rows of one file of the archive: by the names of all columns, those that it has."""
        relative = path.relative_to(self.folder).as_posix()
        try:
            stamp = Stamp.at(path)
            known = self._known.get(path)
            if known is None or stamp != known[0]:
                file = self._opened(path)
                self._known[path] = known = (file.stamp, [{"path": relative, **row} for row in rows_of(file)])
            return known[1]
        except BlockstructError as error:
            problem = str(error)
        except OSError as error:
            problem = str(unreadable(path, error))
        return [{"path": relative, "problem": problem.removeprefix(f"{path}: ")}]

    def select(
        self,
        where: str | None = None,
        *,
        model_hash: str | None = None,
        tags: str | list[str] | tuple[str, ...] = (),
        since: str | None = None,
        until: str | None = None,
        all_columns: bool = False,
    ) -> pd.DataFrame:
        """Return rows of the table by a condition, model, tags and date.

        Parameters
        ----------
        where
            Comparisons of any columns with numbers or texts, in SI units, joined by ``and``, ``or`` and ``not``:
            ``"status == 'converged' and load_factor < 0.3"``, ``"case in ['push +x', 'push -x']"``, ``"'north' in
            tags"``, ``"created_at >= '2026-01-31'"``. Other characters of a name than letters and digits are written
            as ``_``: ``"parameter_blocks_top_height < 2"``. It is parsed, and never run as code.
        model_hash
            The hash, or how it begins.
        tags
            Tags that an analysis must all have.
        since, until
            Dates, or times, of creation in ISO 8601, UTC unless they say otherwise; both belong to the selection.
        all_columns
            As in :meth:`table`.

        Raises
        ------
        StorageError
            If a text is not a date, or the condition is anything else, names no column, or compares one with a value
            of another kind.
        """
        table = self.table(all_columns=True)
        if where is not None:
            table = rows_where(table, where)
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
        rows = table[keep.astype(bool)]
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
            Indexed by path and case: ``load_factor`` (of a settlement its reaction), its ``unit`` (N or N·m, empty of a
            load factor), ``status``, ``model_hash`` and ``problem`` of each, with ``_other`` for the other one's;
            ``relative_difference`` of the load factor (0 where both are the same); of pushovers ``d0``, ``curve_end``
            and ``end_difference``, the relative difference of d0 or, where the load factor did not come down to zero,
            of ``curve_end``; and whether they ``agree``: both there and readable, of one model and status, and
            pushovers to the same end, within 1 %.
        """
        columns = ["load_factor", "unit", "status", "model_hash", "problem", "d0", "curve_end"]
        tables = (a.table(all_columns=True).astype({"case": object}).fillna({"case": ""}) for a in (self, other))
        one, two = (_answered(table).set_index(["path", "case"])[columns] for table in tables)
        joined = one.join(two.add_suffix("_other"), how="outer").fillna({"unit": "", "unit_other": ""})
        joined["relative_difference"] = relative_difference(joined["load_factor"], joined["load_factor_other"])
        ends = [joined[f"d0{suffix}"].fillna(joined[f"curve_end{suffix}"]) for suffix in ("", "_other")]
        joined["end_difference"] = relative_difference(*ends)
        joined["agree"] = joined["problem"].eq("") & joined["problem_other"].eq("")
        joined["agree"] &= joined["end_difference"].abs().le(SAME_END) & joined["d0"].isna().eq(
            joined["d0_other"].isna()
        )
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


def _time(text: str) -> pd.Timestamp:
    try:
        return pd.to_datetime(text, utc=True, format="ISO8601")
    except (ValueError, TypeError) as error:
        msg = f"{text!r} is not a date; write ISO 8601, as in '2026-01-31' or '2026-01-31T12:00'"
        raise StorageError(msg) from error


def _answered(table: pd.DataFrame) -> pd.DataFrame:
    """A table whose load factors are reactions where the cases are settlements, with their units."""
    answers = table[["load_factor", *REACTIONS.values()]]
    unit = pd.Series("", index=table.index)
    for column, symbol in zip(REACTIONS.values(), ("N", "N·m"), strict=True):
        unit = unit.mask(table[column].notna(), symbol)
    return table.assign(load_factor=answers.bfill(axis=1).iloc[:, 0], unit=unit)
