"""Read an analysis."""

import json
import warnings
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.errors import BlockstructError, FormatError, FormatWarning
from blockstruct.model import LoadPattern, Model
from blockstruct.results import Analysis, CaseResult, LazyHistory
from blockstruct.storage.analysis_file import AnalysisFile, major, parameters_of, violated
from blockstruct.storage.case_group import read_result
from blockstruct.storage.claim import place_of
from blockstruct.storage.consistency import (
    Finding,
    bound_findings,
    capacity_findings,
    case_findings,
    history_findings,
    index_findings,
    model_findings,
    reaction_findings,
)
from blockstruct.storage.lock import folder_of
from blockstruct.storage.migration import migrated
from blockstruct.storage.model_group import read_model, read_patterns
from blockstruct.vocabulary import FORMAT_VERSION

#: What contents that satisfy the schema can still make of constructors.
DAMAGE = (BlockstructError, ArithmeticError, IndexError, KeyError, TypeError, ValueError, RecursionError)

#: Makes the history of a case without iterations, which a plan leaves out.
Blank = Callable[[Model, CaseResult], xr.Dataset]


def open_analysis(path: str | Path, *, verify: bool = True) -> Analysis:
    """Read an analysis back: the model and its cases. A history is read when it is first looked at.

    Parameters
    ----------
    path
        A file that :class:`blockstruct.AnalysisManager` or :func:`blockstruct.save_analysis` wrote.
    verify
        Whether a file whose seal does not match its bytes is refused. Without, it is opened with a warning: this is
        for a file that somebody has added something to on purpose. On damaged bytes it may take for ever.

    Raises
    ------
    StorageError
        If the file is missing or cannot be read.
    FormatError
        If the file is not a blockstruct analysis, was changed, comes from a newer major version, or violates its
        schema.

    Warns
    -----
    UnverifiedWarning
        If the seal of the file does not match.
    FormatWarning
        If the file was written before files were valid netCDF-4.
    """
    file = AnalysisFile(path, verify=verify)
    analysis = read_analysis(file)
    if file.repeats_dimensions():
        remedy = "bs.save_analysis(bs.open_analysis(path), path), or 'blockstruct migrate FILE'"
        msg = f"{path}: netCDF's own library reads this file short; write it anew: {remedy}"
        warnings.warn(msg, FormatWarning, stacklevel=2)
    return analysis


def planned_analysis(path: str | Path) -> Analysis:
    """What a run is of that is under way or was killed, by its working data: model, cases and study, no histories."""
    return read_analysis(AnalysisFile(folder_of(place_of(path)) / "plan"), lambda *_: xr.Dataset())


def check_file(path: str | Path) -> dict[str, Any]:
    """Check all of a file, its histories included, and give its root attributes.

    Raises
    ------
    StorageError
        If the file is missing or cannot be read.
    FormatError
        If the file is not a valid analysis; every violation is listed with its HDF5 path.
    """
    file = AnalysisFile(path)
    found = findings(file)
    if found:
        raise violated(file.path, found)
    analysis, (model, _) = read_analysis(file), file.group("/model", "model")
    if model is not None and (found := list(model_findings("/model", model, analysis.model))):
        raise violated(file.path, found)
    return file.attrs


def findings(file: AnalysisFile) -> list[Finding]:
    """Everything that a file violates, of its schema and beyond."""
    found = file.root_findings()
    model, wrong = file.group("/model", "model")
    found += wrong if model is None else index_findings("/model", model)
    for place in file.cases.values():
        case, wrong = file.group(place, "case")
        history, wrong_too = file.group(f"{place}/history", "history")
        found += [*wrong, *wrong_too]
        if case is not None and history is not None:
            found += case_findings(place, case, history["load_factor"].to_numpy(), has_curve=place in file.curves)
            found += bound_findings(place, case, history)
        if history is not None and model is not None:
            found += history_findings(f"{place}/history", history, model)
        if place in file.curves:
            curve, wrong = file.group(file.curves[place], "capacity")
            found += wrong
            if curve is not None and model is not None:
                found += capacity_findings(file.curves[place], curve, model)
    return found


def read_analysis(file: AnalysisFile, blank: Blank | None = None) -> Analysis:
    """Analysis of a file; of a plan, if what its cases without iterations look like is told."""
    found = file.root_findings()
    groups: dict[str, xr.Dataset] = {"/": xr.Dataset(attrs=file.attrs)}
    places = {"/model": "model", **dict.fromkeys(file.cases.values(), "case")}
    places |= dict.fromkeys(file.curves.values(), "capacity")
    is_old = file.major < major(FORMAT_VERSION)
    if is_old:
        places |= {f"{place}/history": "history" for place in file.cases.values()}
    for place, part in places.items():
        ds, wrong = file.group(place, part)
        found += wrong
        if ds is not None:
            groups[place] = ds
    if found:
        raise violated(file.path, found)
    if not is_old:
        return _analysis(file, groups, blank)
    try:
        return _analysis(file, dict(migrated(groups, file.major, major(FORMAT_VERSION))), blank)
    except DAMAGE as error:
        msg = f"{file.path}: /: {error}"
        raise FormatError(msg) from error


def _analysis(file: AnalysisFile, groups: Mapping[str, xr.Dataset], blank: Blank | None) -> Analysis:
    root, held = groups["/"].attrs, groups["/model"]
    found = list(index_findings("/model", held))
    for place in file.cases.values():
        if f"{place}/capacity" in groups:
            found += capacity_findings(f"{place}/capacity", groups[f"{place}/capacity"], held)
        if blank is None or int(groups[place]["n_iterations"]):
            found += case_findings(
                place, groups[place], _load_factors(file, groups, place), has_curve=place in file.curves
            )
    if found:
        raise violated(file.path, found)
    try:
        with np.errstate(all="ignore"):  # Numbers that overflow end in an error below.
            model, patterns = read_model(held), read_patterns(held)
    except DAMAGE as error:
        msg = f"{file.path}: /model: {error}"
        raise FormatError(msg) from error
    if model.hash != root["model_hash"]:
        msg = f"{file.path}: /model: its content does not match model_hash; the file was changed, use the original"
        raise FormatError(msg)
    names = held[["block", "interface"]]
    results = {}
    for name, place in file.cases.items():
        try:
            results[name] = _result(file, groups, place, patterns, model, names, blank)
            found += reaction_findings(place, groups[place], results[name])
        except DAMAGE as error:
            msg = f"{file.path}: {place}: {error}"
            raise FormatError(msg) from error
    if found:
        raise violated(file.path, found)
    return Analysis(
        model,
        results,
        root["created_at"],
        json.loads(root["versions"]),
        solver_options=json.loads(root["solver_options"]),
        document_hash=root["document_hash"],
        tags=json.loads(root["tags"]),
        parameters=parameters_of(root),
        study=root.get("study", ""),
    )


def _load_factors(file: AnalysisFile, groups: Mapping[str, xr.Dataset], place: str) -> Any:
    history = groups.get(f"{place}/history")
    return file.load_factors(place) if history is None else history["load_factor"].to_numpy()


def _result(
    file: AnalysisFile,
    groups: Mapping[str, xr.Dataset],
    place: str,
    patterns: Mapping[str, LoadPattern],
    model: Model,
    names: xr.Dataset,
    blank: Blank | None,
) -> CaseResult:
    n = int(groups[place]["n_iterations"])

    def result(history: xr.Dataset | LazyHistory) -> CaseResult:
        versions = json.loads(file.attrs["versions"])
        return read_result(groups[place], history, model, patterns, versions, groups.get(f"{place}/capacity"))

    if f"{place}/history" in groups:
        return result(groups[f"{place}/history"])
    if n == 0 and blank is not None:
        return result(LazyHistory(0, partial(blank, model, result(LazyHistory(0, xr.Dataset)))))
    return result(LazyHistory(n, partial(_history, file, place, names)))


def _history(file: AnalysisFile, place: str, names: xr.Dataset) -> xr.Dataset:
    place = f"{place}/history"
    history, found = file.group(place, "history")
    if history is not None:
        found = list(history_findings(place, history, names))
        if not found:
            return history
    raise violated(file.path, found)
