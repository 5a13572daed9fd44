"""Write an analysis."""

import contextlib
import json
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path

import xarray as xr

from blockstruct.errors import ModelError, StorageError
from blockstruct.model import Case, LoadPattern
from blockstruct.results import Analysis, confirm, stored_value
from blockstruct.schema import schema_text, violations
from blockstruct.storage.analysis_file import placed, violated
from blockstruct.storage.case_group import case_dataset, group_name
from blockstruct.storage.claim import claim, put_in_place, sync
from blockstruct.storage.consistency import (
    Finding,
    capacity_findings,
    case_findings,
    history_findings,
    index_findings,
)
from blockstruct.storage.file_outline import outline_of
from blockstruct.storage.lock import WriterLock, folder_of
from blockstruct.storage.model_group import model_dataset
from blockstruct.storage.netcdf import netcdf_image
from blockstruct.storage.snapshot import Stamp, seal_of
from blockstruct.storage.unfinished import clear, refuse_killed
from blockstruct.vocabulary import FORMAT, FORMAT_VERSION

SCHEMA = "analysis-2"


def save_analysis(analysis: Analysis, path: str | Path) -> Path:
    """Write an analysis to one file, in one step: readers see the whole new file or what was there before.

    Parameters
    ----------
    analysis
        Model and results.
    path
        Where, with a name that ends in ``.h5``; an existing analysis is replaced, any other existing file is refused.

    Returns
    -------
    pathlib.Path
        Absolute, behind all symbolic links.

    Raises
    ------
    StorageError
        If the path cannot be written, another process is writing it, or a killed run has iterations for it.
    ModelError
        If load patterns of the cases share a name but not their loads.
    FormatError
        If results contradict each other.
    CertificateError
        If results contradict their own forces and velocities: :func:`blockstruct.results.contradictions`.
    """
    place = claim(path)
    confirm(analysis)
    with WriterLock(place):
        refuse_killed(place)
        clear(folder_of(place))
        replaced = Stamp.at(place)
        write_file(analysis, place, () if replaced is None else (replaced,))
    return place


def write_file(
    analysis: Analysis,
    place: Path,
    replaced: Sequence[Stamp],
    tell: Callable[[Stamp], None] | None = None,
) -> None:
    """Write an analysis to a place that is claimed and held, in the place of nothing but what it replaces.

    The stamp of the file is told before it takes its name.
    """
    draft = folder_of(place) / "draft"
    write_draft(sealed_image(analysis, place), draft)
    try:
        if tell is not None:
            tell(Stamp.of(draft.stat()))
        put_in_place(draft, place, replaced)
    except OSError as error:
        if isinstance(error, StorageError):
            raise
        msg = f"{place}: cannot be written ({error.strerror or error}); choose another folder"
        raise StorageError(msg) from error
    finally:
        with contextlib.suppress(OSError):
            draft.unlink()


def save_image(image: bytes, path: str | Path) -> Path:
    """Write the bytes of an analysis file that was made elsewhere, as :func:`save_analysis` does.

    Raises
    ------
    StorageError
        If the path cannot be written, or another process is writing it.
    """
    place = claim(path)
    with WriterLock(place):
        clear(folder_of(place))
        replaced, draft = Stamp.at(place), folder_of(place) / "draft"
        write_draft([image], draft)
        put_in_place(draft, place, () if replaced is None else (replaced,))
    return place


def write_draft(parts: Iterable[bytes | memoryview], draft: Path) -> None:
    """Write bytes to a file that has not got its name yet, and wait until they are on the disk."""
    try:
        with draft.open("wb") as stream:
            stream.writelines(parts)
        sync(draft)
    except OSError as error:
        with contextlib.suppress(OSError):
            draft.unlink()
        moved = isinstance(error, FileNotFoundError | NotADirectoryError)
        remedy = "its folder was moved or removed, move it back" if moved else "free some space"
        msg = f"{draft}: cannot be written ({error.strerror or error}); {remedy} or choose another folder"
        raise StorageError(msg) from error


def sealed_image(analysis: Analysis, path: Path, *, is_plan: bool = False) -> tuple[memoryview, bytes]:
    """Bytes of the file of an analysis, and their seal; a plan leaves histories without iterations out.

    Raises
    ------
    FormatError
        If results violate the schema or contradict each other.
    """
    model = model_dataset(analysis.model, patterns(analysis.cases))
    # Histories and curves tell their own, and are kept as they are.
    tree = {"/": _root(analysis), "/model": _described(model, "model")}
    found = [*_violations("/", tree["/"], "", ("model", "cases")), *_violations("/model", model, "model")]
    found += index_findings("/model", model)
    for name, result in analysis.items():
        place = f"/cases/{group_name(name)}"
        case = case_dataset(result, analysis.versions)
        tree |= {place: _described(case, "case"), f"{place}/history": xr.Dataset()}
        held = ("history",) if result.capacity is None else ("history", "capacity")
        found += _violations(place, case, "case", held)
        if result.capacity is not None:
            tree[f"{place}/capacity"] = result.capacity
            found += _violations(f"{place}/capacity", result.capacity, "capacity")
            found += capacity_findings(f"{place}/capacity", result.capacity, model)
        if result.n_iterations or not is_plan:
            tree[f"{place}/history"] = history = result.history
            wrong = _violations(f"{place}/history", history, "history")
            found += wrong or history_findings(f"{place}/history", history, model)
            load_factors, has_curve = history["load_factor"].to_numpy(), result.capacity is not None
            found += [] if wrong else case_findings(place, case, load_factors, has_curve=has_curve)
    if found:
        raise violated(path, found)
    image = netcdf_image(tree)
    return image, seal_of(image)


@cache
def _meanings(part: str) -> dict[str, str]:
    variables = json.loads(schema_text(SCHEMA))["$defs"][part]["properties"]["variables"]["properties"]
    return {name: variable["description"] for name, variable in variables.items()}


def _described(ds: xr.Dataset, part: str) -> xr.Dataset:
    """A Dataset whose variables tell what they are, as xarray shows them."""
    described = ds.copy()
    for name, meaning in _meanings(part).items():
        if name in described.variables:
            described[name].attrs.setdefault("long_name", meaning)
    return described


def patterns(cases: Iterable[Case]) -> list[LoadPattern]:
    """The different load patterns of cases.

    Raises
    ------
    ModelError
        If two patterns of one name have different loads.
    """
    found: dict[str, LoadPattern] = {}
    for case in cases:
        for pattern in case.patterns:
            if found.setdefault(pattern.name, pattern) != pattern:
                msg = f"load pattern {pattern.name!r}: two patterns of this name have different loads; rename one"
                raise ModelError(msg)
    return list(found.values())


def _violations(place: str, ds: xr.Dataset, part: str, groups: Iterable[str] = ()) -> list[Finding]:
    return [(placed(place, where), what) for where, what in violations(outline_of(ds, groups), SCHEMA, part)]


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
        "parameters": json.dumps({name: stored_value(value) for name, value in analysis.parameters.items()}),
        "study": analysis.study,
    }
    schema = json.dumps(json.loads(schema_text(SCHEMA)), separators=(",", ":"))
    return xr.Dataset({"schema": ((), schema)}, attrs=attrs)
