"""One analysis file: its bytes under a seal, its groups under a schema, an analysis from them, and back to bytes.

The seal is a checksum of all bytes of a file. It stands after the end of the HDF5 data, where no reader of HDF5 looks.
It is checked before libhdf5 reads a byte, because on damaged bytes libhdf5 may run for ever.
"""

import contextlib
import hashlib
import json
import os
import re
import warnings
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Self

import h5py
import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from blockstruct.errors import BlockstructError, FormatError, ModelError, StorageError, UnverifiedWarning
from blockstruct.files import open_file, unreadable
from blockstruct.model import Case, LoadPattern, checked_text
from blockstruct.results import stored_value
from blockstruct.results.analysis import Analysis, checked_tags, restored_value
from blockstruct.results.case_result import LazyHistory
from blockstruct.schema import listed_violations, schema, violations
from blockstruct.storage import layout, netcdf
from blockstruct.vocabulary import FORMAT, FORMAT_VERSION

#: What contents that satisfy the schema can still raise in constructors.
DAMAGE = (BlockstructError, ArithmeticError, IndexError, KeyError, TypeError, ValueError, RecursionError)
#: Ending of the folder of a run.
PARTIAL = ".partial"
SCHEMA = "analysis-2"
#: Groups that only some cases have.
PARTS = layout.PARTS[1:]
#: The kind of file, for messages.
ANALYSIS = "a blockstruct analysis"
_SEAL = b"\nblockstruct sha256 "
_SEAL_LENGTH = len(_SEAL) + 64 + 1
#: Bytes up to which a file is kept in memory: nothing can change it then, and no descriptor is needed. A larger one is
#: read in parts of this size.
_SMALL = 16 << 20


def folder_of(path: Path) -> Path:
    """Return the folder next to a file that holds its lock and the working data of its run."""
    return path.with_name(f"{path.name}{PARTIAL}")


def named_instead(path: Path) -> str:
    """Return the end of a message for the folder of a run, with the file to name instead; empty for another path."""
    name = path.name.removesuffix(PARTIAL)
    if name in (path.name, ""):
        return ""
    return f"a folder with the working data of a run; give the name of its file, {path.with_name(name)}"


def seal_of(image: bytes | memoryview) -> bytes:
    """Return the seal of the bytes of a file."""
    return _SEAL + hashlib.sha256(image).hexdigest().encode() + b"\n"


class Stamp(NamedTuple):
    """Device, inode, size and time of a file, which change with the file."""

    device: int
    inode: int
    size: int
    modified: int

    @classmethod
    def of(cls, status: os.stat_result) -> Self:
        """Return the stamp of a result of :func:`os.stat`."""
        return cls(status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns)

    @classmethod
    def at(cls, path: Path) -> Self | None:
        """Return the stamp of the file at a path; None without one."""
        try:
            return cls.of(path.stat())
        except FileNotFoundError:
            return None


class Snapshot:
    """The bytes of one file, opened once: a file that takes its name afterwards is not read.

    Parameters
    ----------
    path
        The file.

    Attributes
    ----------
    sealed : bool
        Whether the seal matches the bytes.

    Raises
    ------
    StorageError
        If there is no regular file at the path, or it cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._stream = open_file(path, ANALYSIS)
        except StorageError as error:
            if path.is_dir() and (instead := named_instead(path)):
                msg = f"{path}: is {instead}"
                raise StorageError(msg) from error
            raise
        close = weakref.finalize(self, self._stream.close)
        self.stamp = Stamp.of(os.fstat(self._stream.fileno()))
        self._image: bytes | None = None
        try:
            if self.stamp.size <= _SMALL:
                self._image = self._stream.read()
                close()
            self.sealed = self._is_sealed()
        except OSError as error:
            close()
            raise unreadable(path, error, ANALYSIS) from error

    def file(self) -> h5py.File:
        """Return the bytes as an HDF5 file.

        Raises
        ------
        FormatError
            If the file was written to after it was opened; a file that was replaced does no harm.
        """
        if self._image is not None:
            return h5py.File(h5py.h5f.open_file_image(self._image))
        self.check_unchanged()
        return h5py.File(self._stream, "r")

    @property
    def seal(self) -> bytes:
        """The bytes in the place of the seal."""
        return self.bytes_at(max(self.stamp.size - _SEAL_LENGTH, 0), _SEAL_LENGTH)

    def check_unchanged(self) -> None:
        """Refuse a file that was written to since it was opened."""
        if self._image is None and Stamp.of(os.fstat(self._stream.fileno())) != self.stamp:
            msg = f"{self.path}: was written to by another program while it was open; use the original"
            raise FormatError(msg)

    def bytes_at(self, start: int, count: int) -> bytes:
        """Return bytes from a place on; fewer at the end of the file."""
        if self._image is not None:
            return self._image[start : start + count]
        self._stream.seek(start)
        return self._stream.read(count)

    def _is_sealed(self) -> bool:
        digest, end = hashlib.sha256(), self.stamp.size - _SEAL_LENGTH
        for place in range(0, end, _SMALL):
            digest.update(self.bytes_at(place, min(_SMALL, end - place)))
        return end > 0 and self.seal == _SEAL + digest.hexdigest().encode() + b"\n"


class AnalysisFile:
    """A sealed file of an analysis of a readable version; each group is checked before it is read.

    Parameters
    ----------
    path
        The file.
    verify
        Whether a file whose seal does not match is refused; otherwise a warning is given.

    Raises
    ------
    StorageError
        If the file is missing or cannot be read.
    FormatError
        If the file is not an analysis, was changed, or comes from a newer major version.
    """

    def __init__(self, path: str | Path, *, verify: bool = True) -> None:
        self.path = path = Path(path)
        try:
            self._snapshot = Snapshot(path)
        except StorageError as error:
            if path.exists() or not folder_of(path).is_dir():
                raise
            remedy = (
                f"goes on or was killed; keep what it has found with 'blockstruct recover {path}', or go on with "
                f"'blockstruct resume {path}'"
                if (folder_of(path) / "plan").is_file()
                else "begins or has ended before it kept anything; wait, or run it again"
            )
            msg = f"{path}: not written, its run {remedy}"
            raise StorageError(msg) from error
        if not self._snapshot.sealed:
            if verify:
                raise FormatError(_unsealed(path, self._snapshot))
            warnings.warn(
                f"{path}: its bytes do not match its seal: the file was changed after it was written, and its numbers "
                "are not verified",
                UnverifiedWarning,
                stacklevel=3,
            )
        self.stamp, self.seal = self._snapshot.stamp, self._snapshot.seal.decode("ascii", "replace")
        with self.opened() as file:
            self.attrs = _checked_root(file, path)
            self.major = major(self.attrs["format_version"])
            self.cases = {name: f"/cases/{layout.group_name(name)}" for name in json.loads(self.attrs["cases"])}
            self.parts = {p: [part for part in PARTS if _has(file, p, part)] for p in self.cases.values()}

    @contextlib.contextmanager
    def opened(self) -> Iterator[h5py.File]:
        """Open the HDF5 file; any error of the libraries on damaged bytes becomes a FormatError."""
        try:
            with self._snapshot.file() as file:
                yield file
            self._snapshot.check_unchanged()
        except StorageError:
            raise
        except FormatError as error:
            msg = str(error)
            raise FormatError(msg if msg.startswith(str(self.path)) else f"{self.path}: {msg}") from error
        except Exception as error:
            msg = f"{self.path}: not a readable HDF5 file ({error}); it is damaged or of another kind"
            raise FormatError(msg) from error

    def root_findings(self) -> list[layout.Finding]:
        """Return the violations of the root and of the list of cases."""
        with self.opened() as file:
            violations = self._violations("/", netcdf.outline(file).lines, "")
            held = file.get("cases", ())
            if len(held) != len(self.cases) or set(held) != {layout.group_name(name) for name in self.cases}:
                violations.append(("/cases", "the groups are not those that the attribute cases of / lists"))
        return violations

    def groups(self, *, histories: bool) -> tuple[dict[str, xr.Dataset], list[layout.Finding]]:
        """Return all groups by their path, with or without histories, and every violation of the schema."""
        places, violations = {"/model": "model"}, self.root_findings()
        for place, parts in self.parts.items():
            places |= {place: "case"} | {f"{place}/{part}": part for part in (*["history"] * histories, *parts)}
        found = {"/": xr.Dataset(attrs=self.attrs)}
        for place, part in places.items():
            ds, wrong = self.group(place, part)
            violations += wrong
            found |= {} if ds is None else {place: ds}
        return found, violations

    def group(
        self, place: str, part: str, read: Callable[[netcdf.Outline], xr.Dataset] = netcdf.read_dataset
    ) -> tuple[xr.Dataset | None, list[layout.Finding]]:
        """Return a group, or the violations that keep it from being read.

        Parameters
        ----------
        place
            Its path.
        part
            Its name in the schema: model, case, history or capacity.
        read
            Makes a Dataset of the outline of a group.
        """
        with self.opened() as file:
            try:
                contents = netcdf.outline(netcdf.member(file, place))
            except FormatError as error:
                return None, [(place, str(error))]
            wrong = self._violations(place, contents.lines, part)
            return None if wrong else read(contents), wrong

    def load_factors(self, case: str) -> Any:
        """Return only the load factors of the history of a case by the path of its group."""
        with self.opened() as file:
            values = netcdf.member(file, f"{case}/history/load_factor")
            if values.dtype != np.float64 or values.ndim != 1 or values.nbytes > self.stamp.size:
                msg = f"{case}/history/load_factor: {values.dtype} {values.shape} is not a list of numbers"
                raise FormatError(msg)
            return values[()]

    def lazy_history(self, case: str) -> xr.Dataset:
        """Return the history of a case by the path of its group; values stay in the file until they are used.

        Raises
        ------
        FormatError
            If the history violates the schema.
        """
        place = f"{case}/history"

        def stored(ds: Any, name: str) -> Any:
            return indexing.LazilyIndexedArray(_Stored(self, f"{place}/{name}", ds.shape, ds.dtype))

        history, found = self.group(place, "history", lambda found: netcdf.read_dataset(found, stored))
        if history is None:
            raise violated(self.path, found)
        return history

    def _violations(self, place: str, found: dict[str, Any], part: str) -> list[layout.Finding]:
        return [(_placed(place, where), what) for where, what in violations(found, f"analysis-{self.major}", part)]


class _Stored(BackendArray):
    """Values of one variable, which stay in the file."""

    def __init__(self, file: AnalysisFile, place: str, shape: tuple[int, ...], dtype: Any) -> None:
        self._file, self._place, self.shape, self.dtype = file, place, shape, np.dtype(dtype)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)

    def _read(self, key: Any) -> Any:
        with self._file.opened() as groups:
            return netcdf.read_values(netcdf.member(groups, self._place), key)


def violated(path: Path, found: list[layout.Finding]) -> FormatError:
    """Return the error of a file with findings."""
    in_order = sorted(found, key=lambda finding: finding[0].split(": "))
    return FormatError(f"{path}: {listed_violations(in_order)}")


def major(version: str) -> int:
    """Return the major number of a format version."""
    return int(version.partition(".")[0])


def parameters_of(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of an analysis by its root attributes; an older file has none."""
    stored = json.loads(attrs.get("parameters", "{}"))
    return {name: restored_value(value, f"parameter {name!r}") for name, value in stored.items()}


def _has(file: h5py.File, case: str, part: str) -> bool:
    """Return whether the group of a case has a part, ``capacity`` or ``response``."""
    try:
        return part in netcdf.member(file, case)
    except (FormatError, TypeError):
        return False


def _unsealed(path: Path, snapshot: Snapshot) -> str:
    if snapshot.bytes_at(0, 8) != b"\x89HDF\r\n\x1a\n":
        return f"{path}: not a readable HDF5 file; it is damaged or of another kind"
    return (
        f"{path}: /: its bytes do not match its seal, or it has none: the file is damaged, was changed, or is not a "
        "blockstruct analysis. Use an intact copy, or open a file that was changed on purpose with verify=False"
    )


def _checked_root(file: h5py.File, path: Path) -> dict[str, Any]:
    """Return the root attributes of an analysis of a version that can be read."""
    attrs = {name: netcdf.plain(value) for name, value in file.attrs.items()}
    version, wrong = str(attrs.get("format_version", "")), ""
    if attrs.get("format") != FORMAT:
        wrong = f"attribute format is {attrs.get('format')!r}, not {FORMAT!r}: it is not a blockstruct analysis"
    elif not re.fullmatch(r"[1-9][0-9]{0,3}\.[0-9]{1,4}", version):
        wrong = f"attribute format_version is {version!r}, which is not a version"
    elif major(version) > major(FORMAT_VERSION):
        wrong = f"format version {version}, this blockstruct reads up to {FORMAT_VERSION}; update blockstruct"
    if wrong:
        msg = f"{path}: /: {wrong}"
        raise FormatError(msg)
    try:
        for name, kind in (("versions", dict), ("solver_options", dict), ("cases", list), ("tags", list)):
            value = json.loads(attrs[name])
            if not isinstance(value, kind) or not all(isinstance(text, str) for text in value):
                msg = f"{name} is not a JSON {'object' if kind is dict else 'list of texts'}"
                raise TypeError(msg)
        parameters_of(attrs)
        checked_tags(json.loads(attrs["tags"]), "attribute tags")
        checked_text(attrs.get("study", ""), "attribute study")
    except (*DAMAGE, AttributeError) as error:
        msg = f"{path}: /: attributes of the analysis cannot be read ({error})"
        raise FormatError(msg) from error
    return attrs


def _placed(group: str, where: str) -> str:
    """Return the HDF5 path of a place in the outline of a group, ``/variables/fixed/kind``, and its property."""
    parts, path = where.strip("/").split("/"), group.rstrip("/")
    if len(parts) > 1 and parts[0] in ("variables", "groups"):
        path, parts = f"{path}/{parts[1]}", parts[2:]
    elif len(parts) > 1 and parts[0] == "attrs":
        parts = [f"attribute {parts[1]}"]
    return ": ".join([path or "/", *filter(None, parts)])


def open_analysis(path: str | Path, *, verify: bool = True) -> Analysis:
    """Read an analysis: the model and its cases. A history is read when it is first used.

    Parameters
    ----------
    path
        A file that :class:`blockstruct.AnalysisManager` or :func:`blockstruct.save_analysis` wrote.
    verify
        Whether a file whose seal does not match its bytes is refused. Without, it is opened with a warning: this is
        for a file that was changed on purpose. On damaged bytes it may take for ever.

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
    """
    return read_analysis(AnalysisFile(path, verify=verify))


def check_file(path: str | Path) -> dict[str, Any]:
    """Check all of a file, its histories included, and return its root attributes.

    Raises
    ------
    StorageError
        If the file is missing or cannot be read.
    FormatError
        If the file is not a valid analysis; every violation is listed with its HDF5 path.
    """
    file = AnalysisFile(path)
    groups, violations = file.groups(histories=True)
    violations += layout.findings(groups)
    if not violations:
        violations += layout.model_findings("/model", groups["/model"], read_analysis(file).model)
    if violations:
        raise violated(file.path, violations)
    return file.attrs


def read_analysis(file: AnalysisFile) -> Analysis:
    """Return the analysis of a file."""
    is_old = file.major < major(FORMAT_VERSION)
    groups, violations = file.groups(histories=is_old)
    if violations:
        raise violated(file.path, violations)
    if not is_old:
        return _analysis(file, groups)
    with _damage_at(file, "/"):
        return _analysis(file, dict(layout.migrated(groups, file.major, major(FORMAT_VERSION))))


@contextlib.contextmanager
def _damage_at(file: AnalysisFile, place: str) -> Iterator[None]:
    """Name the file and a place in errors of constructors."""
    try:
        with np.errstate(all="ignore"):  # Numbers that overflow end in an error of a constructor.
            yield
    except DAMAGE as error:
        msg = f"{file.path}: {place}: {error}"
        raise FormatError(msg) from error


def _analysis(file: AnalysisFile, groups: Mapping[str, xr.Dataset]) -> Analysis:
    root, held = groups["/"].attrs, groups["/model"]
    if violations := list(layout.findings(groups, file.load_factors)):
        raise violated(file.path, violations)
    with _damage_at(file, "/model"):
        model, patterns = layout.read_model(held), layout.read_patterns(held)
    if model.hash != root["model_hash"]:
        msg = f"{file.path}: /model: its content does not match model_hash; the file was changed, use the original"
        raise FormatError(msg)
    results, versions, names = {}, json.loads(root["versions"]), held[["block", "interface"]]
    for name, place in file.cases.items():
        with _damage_at(file, place):
            n = int(groups[place]["n_iterations"])
            history = groups.get(f"{place}/history", LazyHistory(n, partial(_history, file, f"{place}/history", names)))
            parts = {part: groups.get(f"{place}/{part}") for part in PARTS}
            results[name] = layout.read_result(groups[place], history, model, patterns, versions, **parts)
            violations += layout.result_findings(place, groups[place], results[name])
    if violations:
        raise violated(file.path, violations)
    return Analysis(
        model,
        results,
        root["created_at"],
        versions,
        solver_options=json.loads(root["solver_options"]),
        document_hash=root["document_hash"],
        tags=json.loads(root["tags"]),
        parameters=parameters_of(root),
        study=root.get("study", ""),
    )


def _history(file: AnalysisFile, place: str, names: xr.Dataset) -> xr.Dataset:
    history, violations = file.group(place, "history")
    if history is not None:
        violations = list(layout.part_findings(place, history, names))
        if not violations:
            return history
    raise violated(file.path, violations)


def sealed_image(analysis: Analysis, path: Path) -> tuple[bytes, bytes]:
    """Return the bytes of the file of an analysis, and their seal.

    Parameters
    ----------
    analysis
        The model and its results.
    path
        File that errors name.

    Raises
    ------
    FormatError
        If the model or results violate the schema or contradict each other.
    """
    text = json.dumps(schema(SCHEMA), separators=(",", ":"))
    tree = {
        "/": xr.Dataset({"schema": ((), text)}, attrs=_root_attributes(analysis)),
        "/model": layout.model_dataset(analysis.model, patterns(analysis.cases)),
    }
    violations = _violations("/", tree["/"], "", ("model", "cases")) + _violations("/model", tree["/model"], "model")
    for of_case, result in analysis.items():
        place, case = f"/cases/{layout.group_name(of_case)}", layout.case_dataset(result, analysis.versions)
        parts = {name: ds for name in layout.PARTS if (ds := getattr(result, name)) is not None}
        violations += _violations(place, case, "case", parts)
        tree[place] = case
        for name, ds in parts.items():
            violations += _violations(f"{place}/{name}", ds, name)
            tree[f"{place}/{name}"] = ds
    violations = violations or list(layout.findings(tree))
    if violations:
        raise violated(path, violations)
    content = netcdf.netcdf_image(tree)
    return content, seal_of(content)


def patterns(cases: Iterable[Case]) -> list[LoadPattern]:
    """Return the different load patterns of cases.

    Raises
    ------
    ModelError
        If two patterns of one name have different loads.
    """
    by_name: dict[str, LoadPattern] = {}
    for case in cases:
        for pattern in case.patterns:
            if by_name.setdefault(pattern.name, pattern) != pattern:
                msg = f"load pattern {pattern.name!r}: two patterns of this name have different loads; rename one"
                raise ModelError(msg)
    return list(by_name.values())


def _violations(place: str, ds: xr.Dataset, part: str, groups: Iterable[str] = ()) -> list[layout.Finding]:
    return [(_placed(place, where), what) for where, what in violations(netcdf.outline_of(ds, groups), SCHEMA, part)]


def _root_attributes(analysis: Analysis) -> dict[str, str]:
    return {
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
