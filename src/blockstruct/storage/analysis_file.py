"""One analysis file, opened once: its groups, each checked before it is read."""

import contextlib
import json
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import xarray as xr

from blockstruct.errors import BlockstructError, FormatError, StorageError, UnverifiedWarning
from blockstruct.results import restored_value
from blockstruct.schema import listed_violations, violations
from blockstruct.storage.case_group import group_name
from blockstruct.storage.consistency import Finding
from blockstruct.storage.file_outline import outline, plain
from blockstruct.storage.lock import folder_of
from blockstruct.storage.netcdf import dimension_number, read_group
from blockstruct.storage.snapshot import Snapshot, Stamp
from blockstruct.vocabulary import FORMAT, FORMAT_VERSION


class AnalysisFile:
    """A file that says it is an analysis of a version that can be read, with the bytes that were written.

    Parameters
    ----------
    path
        The file.
    verify
        Whether a file whose seal does not match is refused; otherwise a warning is given.
    verified
        Stamp at which the seal was found to match before.

    Raises
    ------
    StorageError
        If the file is missing or cannot be read.
    FormatError
        If the file is not an analysis, was changed, or comes from a newer major version.
    """

    def __init__(self, path: str | Path, *, verify: bool = True, verified: Stamp | None = None) -> None:
        self.path = path = Path(path)
        try:
            self._snapshot = Snapshot(path, verified)
        except StorageError as error:
            if not path.exists() and folder_of(path).is_dir():
                remedy = (
                    f"goes on or was killed; keep what it has found with 'blockstruct recover {path}', or go on with "
                    f"'blockstruct resume {path}'"
                    if (folder_of(path) / "plan").is_file()
                    else "begins or has ended before it kept anything; wait, or run it again"
                )
                msg = f"{path}: not written, its run {remedy}"
                raise StorageError(msg) from error
            raise
        if not self._snapshot.sealed:
            if verify:
                raise FormatError(_unsealed(path, self._snapshot))
            warnings.warn(
                f"{path}: its bytes do not match its seal: it was changed after it was written, and nothing vouches "
                "for its numbers",
                UnverifiedWarning,
                stacklevel=3,
            )
        with self.opened() as file:
            self.attrs = _checked_root(file, path)
            self.cases = {name: f"/cases/{group_name(name)}" for name in json.loads(self.attrs["cases"])}
            self.curves = {place: f"{place}/capacity" for place in self.cases.values() if _has_curve(file, place)}
        self.stamp = self._snapshot.stamp

    @property
    def seal(self) -> str:
        """The seal at its end."""
        return self._snapshot.seal.decode("ascii", "replace")

    @property
    def major(self) -> int:
        """Major version of its format."""
        return major(self.attrs["format_version"])

    @contextlib.contextmanager
    def opened(self) -> Iterator[h5py.File]:
        """The HDF5 file; whatever the libraries make of damaged bytes becomes a FormatError."""
        try:
            with h5py.File(self._snapshot.stream(), "r") as file:
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

    def root_findings(self) -> list[Finding]:
        """What the root and the list of cases violate."""
        with self.opened() as file:
            found = self._violations("/", outline(file), "")
            held = file.get("cases", ())
            if len(held) != len(self.cases) or set(held) != {group_name(name) for name in self.cases}:
                found.append(("/cases", "the groups are not those that the attribute cases of / lists"))
        return found

    def group(
        self, place: str, part: str, read: Callable[[h5py.Group, Mapping[str, Any]], xr.Dataset] = read_group
    ) -> tuple[xr.Dataset | None, list[Finding]]:
        """A group, or what keeps it from being read.

        Parameters
        ----------
        place
            Its path.
        part
            What the schema calls it: model, case, history or capacity.
        read
            Makes a Dataset of a group and its outline.
        """
        with self.opened() as file:
            try:
                group = member(file, place)
                lines = outline(group)
            except FormatError as error:
                return None, [(place, str(error))]
            found = self._violations(place, lines, part)
            return None if found else read(group, lines), found

    def load_factors(self, case: str) -> Any:
        """Load factors of the history of a case, whose group is named, without the rest of it."""
        with self.opened() as file:
            values = member(file, f"{case}/history/load_factor")
            if values.dtype != np.float64 or values.ndim != 1 or values.nbytes > self.stamp.size:
                msg = f"{case}/history/load_factor: {values.dtype} {values.shape} is not a list of numbers"
                raise FormatError(msg)
            return values[()]

    def repeats_dimensions(self) -> bool:
        """Return whether the numbers of dimensions begin anew in each group.

        netCDF-4 wants one numbering of the whole file. Without it netCDF's own library reads arrays short.
        """
        with self.opened() as file:
            numbers = {dimension_number(scale) for scale in member(file, "/model").values()} - {None}
            histories = [f"{place}/history/iteration" for place in self.cases.values()]
            return any(dimension_number(member(file, place)) in numbers for place in histories[:1])

    def _violations(self, place: str, found: dict[str, Any], part: str) -> list[Finding]:
        return [(placed(place, where), what) for where, what in violations(found, f"analysis-{self.major}", part)]


def violated(path: Path, found: list[Finding]) -> FormatError:
    """Error of a file with findings."""
    in_order = sorted(found, key=lambda finding: finding[0].split(": "))
    return FormatError(f"{path}: {listed_violations(in_order)}")


def member(file: h5py.File, place: str) -> Any:
    """Member of a file by its path, never by a link out of it or to elsewhere in it."""
    item = file
    for name in place.strip("/").split("/"):
        link = item.get(name, getlink=True) if isinstance(item, h5py.Group) else None
        if not isinstance(link, h5py.HardLink):
            msg = f"{place}: {name!r} is missing, or a link to elsewhere"
            raise FormatError(msg)
        item = item[name]
    return item


def _has_curve(file: h5py.File, case: str) -> bool:
    """Whether the group of a case holds a capacity curve, or something of that name."""
    try:
        return "capacity" in member(file, case)
    except (FormatError, TypeError):
        return False


def major(version: str) -> int:
    """Major number of a format version."""
    return int(version.partition(".")[0])


def _unsealed(path: Path, snapshot: Snapshot) -> str:
    start = snapshot.head(8)
    if start != b"\x89HDF\r\n\x1a\n":
        return f"{path}: not a readable HDF5 file; it is damaged or of another kind"
    return (
        f"{path}: /: its bytes do not match its seal, or it has none: the file is damaged, was changed, or is not a "
        "blockstruct analysis. Use an intact copy, or open a file that was changed on purpose with verify=False"
    )


def _checked_root(file: h5py.File, path: Path) -> dict[str, Any]:
    """Root attributes of a file that is an analysis of a version that can be read."""
    attrs = {name: plain(value) for name, value in file.attrs.items()}
    if attrs.get("format") != FORMAT:
        msg = (
            f"{path}: /: attribute format is {attrs.get('format')!r}, not {FORMAT!r}: it is not a blockstruct analysis"
        )
        raise FormatError(msg)
    version = str(attrs.get("format_version", ""))
    if not re.fullmatch(r"[1-9][0-9]{0,3}\.[0-9]{1,4}", version):
        msg = f"{path}: /: attribute format_version is {version!r}, which is not a version"
        raise FormatError(msg)
    if major(version) > major(FORMAT_VERSION):
        msg = f"{path}: /: format version {version}, this blockstruct reads up to {FORMAT_VERSION}; update blockstruct"
        raise FormatError(msg)
    for name in ("versions", "solver_options"):
        if not isinstance(_parsed(attrs.get(name)), dict):
            msg = f"{path}: /: attribute {name} is not a JSON object"
            raise FormatError(msg)
    for name in ("cases", "tags"):
        texts = _parsed(attrs.get(name))
        if not isinstance(texts, list) or not all(isinstance(t, str) for t in texts):
            msg = f"{path}: /: attribute {name} is not a JSON list of texts"
            raise FormatError(msg)
    try:
        parameters_of(attrs)
    except (BlockstructError, ArithmeticError, AttributeError, TypeError, ValueError, RecursionError) as error:
        msg = f"{path}: /: attribute parameters is not a JSON object of values ({error})"
        raise FormatError(msg) from error
    return attrs


def parameters_of(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters of an analysis by its root attributes; those of an older file are none."""
    stored = json.loads(attrs.get("parameters", "{}"))
    return {name: restored_value(value, f"parameter {name!r}") for name, value in stored.items()}


def _parsed(text: Any) -> Any:
    try:
        return json.loads(text)
    except (TypeError, ValueError, RecursionError):
        return None


def placed(group: str, where: str) -> str:
    """HDF5 path of a place in the outline of a group, ``/variables/fixed/kind``, with what is wrong there."""
    parts, path = where.strip("/").split("/"), group.rstrip("/")
    if len(parts) > 1 and parts[0] in ("variables", "groups"):
        path, parts = f"{path}/{parts[1]}", parts[2:]
    elif len(parts) > 1 and parts[0] == "attrs":
        parts = [f"attribute {parts[1]}"]
    return ": ".join([path or "/", *filter(None, parts)])
