"""Whether a file is what it must be: its schema, and what a schema cannot say."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from blockstruct.errors import FormatError, StorageError
from blockstruct.schema import listed_violations, violations
from blockstruct.storage.case_group import group_of
from blockstruct.storage.file_outline import plain, skeleton
from blockstruct.storage.lock import folder_of
from blockstruct.storage.seal import is_intact
from blockstruct.vocabulary import FORMAT, FORMAT_VERSION

#: Index variables and the dimension each must stay within; −1 means none where it is allowed.
_INDICES = {
    "material_of_block": ("material", 0),
    "block_of_vertex": ("block", 0),
    "block_of_face": ("block", 0),
    "face_of_corner": ("face", 0),
    "vertex_of_corner": ("vertex", 0),
    "minus_block": ("block", 0),
    "plus_block": ("block", 0),
    "joint_material_of_interface": ("joint_material", 0),
    "interface_of_contact_point": ("interface", 0),
    "pattern_of_load": ("load_pattern", 0),
    "block_of_load": ("block", -1),
    "minus_of_contact": ("block", 0),
    "plus_of_contact": ("block", 0),
    "interface_of_contact": ("interface", -1),
    "first_of_overlap": ("block", 0),
    "second_of_overlap": ("block", 0),
    "first_of_close_pair": ("block", 0),
    "second_of_close_pair": ("block", 0),
    "block_of_nonplanar_face": ("block", 0),
}
_ASCENDING = ("block_of_vertex", "block_of_face", "face_of_corner", "interface_of_contact_point")


def check_file(path: str | Path) -> dict[str, Any]:
    """Check a file against ``schemas/analysis-1.json`` and give its root attributes.

    Raises
    ------
    StorageError
        A file that is missing or cannot be read.
    FormatError
        A file that is no valid analysis; every violation is listed with its HDF5 path.
    """
    path = Path(path)
    if not path.is_file():
        if not path.exists() and folder_of(path).is_dir():
            msg = (
                f"{path}: not written, its run goes on or was killed; keep what it has found with "
                f"'blockstruct recover {path}', or go on with 'blockstruct resume {path}'"
            )
            raise StorageError(msg)
        what = "is a folder" if path.is_dir() else "no such file"
        msg = f"{path}: {what}; give the path of a blockstruct analysis"
        raise StorageError(msg)
    try:
        with h5py.File(path, "r") as file:
            attrs = checked_root(file, path)
            if not is_intact(path):
                msg = f"{path}: /: its bytes do not match its seal; it was changed or is damaged, use the original"
                raise FormatError(msg)
            schema = f"analysis-{major(attrs['format_version'])}"
            found = [(_place(where), what) for where, what in violations(skeleton(file), schema)]
            found = found or _inconsistencies(file)
    except FormatError:
        raise
    except PermissionError as error:
        msg = f"{path}: cannot be read ({error.strerror or error}); ask its owner for the right to read it"
        raise StorageError(msg) from error
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, MemoryError) as error:
        msg = f"{path}: no readable HDF5 file ({error}); it is damaged or of another kind"
        raise FormatError(msg) from error
    if found:
        msg = f"{path}: {listed_violations(found)}"
        raise FormatError(msg)
    return attrs


def major(version: str) -> int:
    """Major number of a format version."""
    return int(version.partition(".")[0])


def is_analysis(path: Path) -> bool:
    """Whether a file says of itself that it is a blockstruct analysis."""
    try:
        with h5py.File(path, "r") as file:
            return bool(plain(file.attrs.get("format", "")) == FORMAT)
    except OSError:
        return False


def checked_root(file: h5py.File, path: Path) -> dict[str, Any]:
    """Root attributes of a file that is an analysis of a version that can be read."""
    attrs = {name: plain(value) for name, value in file.attrs.items()}
    if attrs.get("format") != FORMAT:
        msg = f"{path}: /: attribute format is {attrs.get('format')!r}, not {FORMAT!r}: no blockstruct analysis"
        raise FormatError(msg)
    version = str(attrs.get("format_version", ""))
    if not re.fullmatch(r"[1-9][0-9]{0,3}\.[0-9]{1,4}", version):
        msg = f"{path}: /: attribute format_version is {version!r}, which is no version"
        raise FormatError(msg)
    if major(version) > major(FORMAT_VERSION):
        msg = f"{path}: /: format version {version}, this blockstruct reads up to {FORMAT_VERSION}; update blockstruct"
        raise FormatError(msg)
    for name in ("versions", "content_hash", "solver_options"):
        if not _is_object(attrs.get(name)):
            msg = f"{path}: /: attribute {name} is no JSON object"
            raise FormatError(msg)
    if _texts(attrs.get("tags")) is None:
        msg = f"{path}: /: attribute tags is no JSON list of texts"
        raise FormatError(msg)
    return attrs


def _place(where: str) -> str:
    """HDF5 path of a place in the skeleton, ``/groups/model/variables/fixed/kind``, with what is wrong there."""
    parts, path = where.strip("/").split("/"), ""
    while len(parts) > 1 and parts[0] == "groups":
        path, parts = f"{path}/{parts[1]}", parts[2:]
    if len(parts) > 1 and parts[0] == "variables":
        path, parts = f"{path}/{parts[1]}", parts[2:]
    if len(parts) > 1 and parts[0] == "attrs":
        parts = [f"attribute {parts[1]}"]
    return ": ".join([path or "/", *filter(None, parts)])


def _is_object(text: Any) -> bool:
    try:
        return isinstance(json.loads(text), dict)
    except (TypeError, ValueError):
        return False


def _inconsistencies(file: h5py.File) -> list[tuple[str, str]]:
    """What the schema cannot say: index ranges, sizes across groups, the list of cases."""
    model, cases = file["model"], dict(file.get("cases", {}))
    groups = {"/model": model} | {f"/cases/{name}/history": case["history"] for name, case in cases.items()}
    found = []
    listed = case_names(file)
    if listed is None or sorted(map(group_of, listed)) != sorted(cases):
        found.append(("/cases", "the groups are not those that the attribute cases of / lists"))
    for name, case in cases.items():
        found += [(f"/cases/{name}", what) for what in _contradictions(name, case, model)]
    for path, group in groups.items():
        found += [
            (path, f"{len(group[dim])} along {dim}, but /model has {len(model[dim])}")
            for dim in ("block", "interface")
            if len(group[dim]) != len(model[dim])
        ]
        for name, (dim, least) in _INDICES.items():
            if name not in group:
                continue
            values = group[name][()]
            if values.size and (values.min() < least or values.max() >= len(group[dim])):
                found.append((f"{path}/{name}", f"an index is outside {least}..{len(group[dim]) - 1}"))
            if name in _ASCENDING and np.any(np.diff(values) < 0):
                found.append((f"{path}/{name}", "the indices are not in ascending order"))
    return found


def _contradictions(name: str, case: h5py.Group, model: h5py.Group) -> Iterator[str]:
    """What a result says against its own history, its name or the model."""
    history = case["history"]
    if int(case["n_iterations"][()]) != len(history["iteration"]):
        yield "n_iterations is not the length of the history"
    if group_of(str(plain(case.attrs["name"]))) != name:
        yield "the attribute name is not that of the group"
    if plain(case.attrs["status"]) == "converged":
        last = history["load_factor"][-1] if len(history["load_factor"]) else np.nan
        if "holds" not in case or not int(case["holds"][()]) or float(case["load_factor"][()]) != max(last, 0.0):
            yield "converged, but the certificate does not hold or the load factor is not the last of the history"
    for names in ("block", "interface"):
        if history[names].shape == model[names].shape and np.any(history[names][()] != model[names][()]):
            yield f"the {names} names of the history are not those of /model"


def case_names(file: h5py.File) -> list[str] | None:
    """Names of the cases that a file lists, in order; None where it lists none."""
    return _texts(file.attrs.get("cases"))


def _texts(text: Any) -> list[str] | None:
    try:
        texts = json.loads(text)
    except (ValueError, TypeError):
        return None
    return texts if isinstance(texts, list) and all(isinstance(t, str) for t in texts) else None
