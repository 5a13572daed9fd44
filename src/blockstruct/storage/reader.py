"""Read an analysis."""

import json
from pathlib import Path

import numpy as np
import xarray as xr

from blockstruct.errors import BlockstructError, FormatError
from blockstruct.results import Analysis
from blockstruct.storage.case_group import group_of, result_of
from blockstruct.storage.check import check_file, major
from blockstruct.storage.content import content_hash
from blockstruct.storage.migration import migrated
from blockstruct.storage.model_group import model_of, patterns_of
from blockstruct.vocabulary import FORMAT_VERSION

#: What contents that satisfy the schema can still make of constructors.
DAMAGE = (BlockstructError, ArithmeticError, IndexError, KeyError, TypeError, ValueError)

_CHANGED = "the file was changed or is damaged, use the original"


def open_analysis(path: str | Path) -> Analysis:
    """Read an analysis back, whole: the model, its cases and their histories.

    Parameters
    ----------
    path
        A file that :class:`blockstruct.AnalysisManager` or :func:`blockstruct.save_analysis` wrote.

    Raises
    ------
    StorageError
        A file that is missing or cannot be read.
    FormatError
        A file that is no blockstruct analysis, comes from a newer major version, or violates its schema.
    """
    attrs = check_file(path)
    cases = {name: f"/cases/{group_of(name)}" for name in json.loads(attrs["cases"])}
    names = ["/", "/model", *(name for case in cases.values() for name in (case, f"{case}/history"))]
    stored = {name: _load(path, name) for name in names}
    try:
        groups = migrated(stored, major(attrs["format_version"]), major(FORMAT_VERSION))
    except DAMAGE as error:
        msg = f"{path}: /: {error}"
        raise FormatError(msg) from error
    try:
        with np.errstate(all="ignore"):  # ProgramData that overflow end in an error below.
            model, patterns = model_of(groups["/model"]), patterns_of(groups["/model"])
    except DAMAGE as error:
        msg = f"{path}: /model: {error}"
        raise FormatError(msg) from error
    results = {}
    for name, case in cases.items():
        try:
            results[name] = result_of(groups[case], groups[f"{case}/history"], model, patterns)
        except DAMAGE as error:
            msg = f"{path}: {case}: {error}"
            raise FormatError(msg) from error
    if model.hash != attrs["model_hash"]:
        msg = f"{path}: /model: its content does not match model_hash; {_CHANGED}"
        raise FormatError(msg)
    hashes = json.loads(attrs["content_hash"])
    for name, ds in stored.items():
        if content_hash(ds) != hashes.get(name):
            msg = f"{path}: {name}: its content does not match content_hash; {_CHANGED}"
            raise FormatError(msg)
    root = groups["/"].attrs
    return Analysis(
        model,
        results,
        root["created_at"],
        json.loads(root["versions"]),
        solver_options=json.loads(root["solver_options"]),
        document_hash=root["document_hash"],
        tags=json.loads(root["tags"]),
    )


def _load(path: str | Path, group: str) -> xr.Dataset:
    try:
        with xr.open_dataset(path, group=group, engine="h5netcdf") as ds:
            return ds.load()
    except Exception as error:  # Whatever the libraries make of damaged bytes.
        msg = f"{path}: {group}: cannot be read ({error}); the file is damaged, use a copy"
        raise FormatError(msg) from error
