"""Read an analysis."""

import json
from pathlib import Path

import xarray as xr

from blockstruct.errors import BlockstructError, FormatError
from blockstruct.results import Analysis
from blockstruct.storage.case_group import group_of, result_of
from blockstruct.storage.check import check_file
from blockstruct.storage.model_group import model_of, patterns_of

#: What contents that satisfy the schema can still make of constructors.
DAMAGE = (BlockstructError, ArithmeticError, IndexError, KeyError, TypeError, ValueError)


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
    try:
        ds = _load(path, "/model")
        model, patterns = model_of(ds), patterns_of(ds)
    except DAMAGE as error:
        msg = f"{path}: /model: {error}"
        raise FormatError(msg) from error
    if model.hash != attrs["model_hash"]:
        msg = f"{path}: /model: its content does not match model_hash; the file was changed, use the original"
        raise FormatError(msg)
    results = {}
    for name in json.loads(attrs["cases"]):
        group = f"/cases/{group_of(name)}"
        try:
            results[name] = result_of(_load(path, group), _load(path, f"{group}/history"), patterns)
        except DAMAGE as error:
            msg = f"{path}: {group}: {error}"
            raise FormatError(msg) from error
    return Analysis(model, results, attrs["created_at"], json.loads(attrs["versions"]))


def _load(path: str | Path, group: str) -> xr.Dataset:
    with xr.open_dataset(path, group=group, engine="h5netcdf") as ds:
        return ds.load()
