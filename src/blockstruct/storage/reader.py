"""Read an analysis."""

import json
from pathlib import Path

import numpy as np
import xarray as xr

from blockstruct.errors import BlockstructError, FormatError
from blockstruct.results import Analysis
from blockstruct.storage.case_group import group_of, result_of
from blockstruct.storage.check import check_file
from blockstruct.storage.content import content_hash
from blockstruct.storage.model_group import model_of, patterns_of

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
    hashes = json.loads(attrs["content_hash"])
    ds = _load(path, "/model")
    try:
        with np.errstate(all="ignore"):  # Numbers that overflow end in an error below.
            model, patterns = model_of(ds), patterns_of(ds)
    except DAMAGE as error:
        msg = f"{path}: /model: {error}"
        raise FormatError(msg) from error
    if model.hash != attrs["model_hash"]:
        msg = f"{path}: /model: its content does not match model_hash; {_CHANGED}"
        raise FormatError(msg)
    found = {"/": _load(path, "/"), "/model": ds}
    results = {}
    for name in json.loads(attrs["cases"]):
        group = f"/cases/{group_of(name)}"
        found[group], found[f"{group}/history"] = _load(path, group), _load(path, f"{group}/history")
        try:
            results[name] = result_of(found[group], found[f"{group}/history"], patterns)
        except DAMAGE as error:
            msg = f"{path}: {group}: {error}"
            raise FormatError(msg) from error
    for group, ds in found.items():
        if content_hash(ds) != hashes.get(group):
            msg = f"{path}: {group}: its content does not match content_hash; {_CHANGED}"
            raise FormatError(msg)
    return Analysis(
        model,
        results,
        attrs["created_at"],
        json.loads(attrs["versions"]),
        solver_options=json.loads(attrs["solver_options"]),
        document_hash=attrs["document_hash"],
        tags=json.loads(attrs["tags"]),
    )


def _load(path: str | Path, group: str) -> xr.Dataset:
    try:
        with xr.open_dataset(path, group=group, engine="h5netcdf") as ds:
            return ds.load()
    except Exception as error:  # Whatever the libraries make of damaged bytes.
        msg = f"{path}: {group}: cannot be read ({error}); the file is damaged, use a copy"
        raise FormatError(msg) from error
