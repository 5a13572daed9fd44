"""Write an analysis."""

import contextlib
import json
import os
import tempfile
from collections.abc import Iterable
from io import BytesIO
from pathlib import Path
from uuid import uuid4

import xarray as xr

from blockstruct.errors import ModelError, StorageError
from blockstruct.model import LimitCase, LoadPattern
from blockstruct.results import Analysis, confirm
from blockstruct.schema import schema_text
from blockstruct.storage.case_group import case_dataset, group_of
from blockstruct.storage.check import check_file, is_analysis
from blockstruct.storage.content import content_hash
from blockstruct.storage.lock import WriterLock
from blockstruct.storage.model_group import model_dataset
from blockstruct.storage.seal import seal_of
from blockstruct.vocabulary import FORMAT, FORMAT_VERSION

SCHEMA = "analysis-1"


def claim(path: str | Path) -> Path:
    """Check, before any work is done, that a file can be written at a path; make its folder if it is missing.

    Raises
    ------
    StorageError
        A path that is a folder, that holds something else than an analysis, or in a folder that cannot be made
        or written to.
    """
    path = Path(path)
    if path.is_dir():
        msg = f"{path}: is a folder; give the path of a file, such as {path / 'analysis.h5'}"
        raise StorageError(msg)
    if path.exists() and not is_analysis(path):
        msg = f"{path}: exists and is no blockstruct analysis, so it is not replaced; choose another name"
        raise StorageError(msg)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        msg = f"{path}: cannot be written ({error.strerror}); choose a folder you can write to"
        raise StorageError(msg) from error
    return path


def save_analysis(analysis: Analysis, path: str | Path) -> Path:
    """Write an analysis to one file, in one step: readers see the whole new file or what was there before.

    Parameters
    ----------
    analysis
        Model and results.
    path
        Where; an existing analysis is replaced, any other existing file is refused.

    Raises
    ------
    StorageError
        A path that cannot be written, or that another process is writing.
    ModelError
        Cases whose load patterns share a name but not their loads.
    CertificateError
        Results that contradict their own forces and velocities: :func:`blockstruct.contradictions`.
    """
    path = claim(path)
    confirm(analysis)
    with WriterLock(path):
        return write_file(analysis, path)


def write_file(analysis: Analysis, path: Path) -> Path:
    """Write an analysis to a path that is claimed and held."""
    tree = {"/model": model_dataset(analysis.model, patterns(analysis.cases))}
    for name, result in analysis.items():
        tree[f"/cases/{group_of(name)}"] = case_dataset(result)
        tree[f"/cases/{group_of(name)}/history"] = result.history
    draft = path.with_name(f".{path.name}.{uuid4().hex}.part")
    root = _root(analysis)
    hashes = {group: content_hash(ds) for group, ds in {"/": root, **tree}.items()}
    tree["/"] = root.assign_attrs(content_hash=json.dumps(hashes))
    # Made in memory: libhdf5 crashes the process on a disk that is full.
    image = BytesIO()
    xr.DataTree.from_dict(tree).to_netcdf(image, engine="h5netcdf")
    seal = seal_of(image.getbuffer())
    image.seek(0, os.SEEK_END)
    image.write(seal)
    try:
        draft.write_bytes(image.getbuffer())
        check_file(draft)
        sync(draft)
        draft.replace(path)
        sync(path.parent)
    except OSError as error:
        msg = f"{path}: cannot be written ({error.strerror or error}); free some space or choose another folder"
        raise StorageError(msg) from error
    finally:
        with contextlib.suppress(FileNotFoundError):
            draft.unlink()
    return path


def patterns(cases: Iterable[LimitCase]) -> list[LoadPattern]:
    """The different load patterns of cases.

    Raises
    ------
    ModelError
        Two patterns of one name with different loads.
    """
    found: dict[str, LoadPattern] = {}
    for case in cases:
        for pattern in (case.dead, case.variable):
            if found.setdefault(pattern.name, pattern) != pattern:
                msg = f"load pattern {pattern.name!r}: two patterns of this name have different loads; rename one"
                raise ModelError(msg)
    return list(found.values())


def _root(analysis: Analysis) -> xr.Dataset:
    attrs = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "created_at": analysis.created_at,
        "versions": json.dumps(dict(analysis.versions), sort_keys=True),
        "model_hash": analysis.model.hash,
        "status": analysis.status,
        "cases": json.dumps(list(analysis)),
        "solver_options": json.dumps(dict(analysis.solver_options), sort_keys=True),
        "document_hash": analysis.document_hash,
        "tags": json.dumps(list(analysis.tags)),
    }
    return xr.Dataset({"schema": ((), schema_text(SCHEMA))}, attrs=attrs)


def sync(path: str | Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
