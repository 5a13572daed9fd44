"""What libhdf5 still reads of a damaged file, kept as a file that nobody takes for an analysis."""

import json
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.errors import FormatError, StorageError
from blockstruct.files import write_new_bytes
from blockstruct.storage import salvage_child
from blockstruct.storage.netcdf import netcdf_image
from blockstruct.storage.snapshot import Snapshot
from blockstruct.vocabulary import counted

#: Format of a salvaged file, which open_analysis and Archive refuse.
FORMAT = "blockstruct-salvaged"
#: Seconds without a sign of life after which a process is taken to be lost: while it starts, and while it reads.
_START, _PATIENCE = 20.0, 3.0
_LOST = "HDF5 crashed or did not end"


@dataclass(frozen=True, slots=True)
class Salvaged:
    """What was salvaged of a file.

    Attributes
    ----------
    path : Path
        The file of what could be read.
    read : tuple of str
        HDF5 paths of the variables that could be read. None of them is verified.
    lost : mapping of str to str
        HDF5 paths of what could not, with the reason.
    """

    path: Path
    read: tuple[str, ...]
    lost: dict[str, str]

    def __str__(self) -> str:
        read, lost = counted(len(self.read), "variable"), counted(len(self.lost), "place")
        lines = [f"{self.path}: {read} could be read, {lost} could not"]
        lines += [f"  {place}: {why}" for place, why in self.lost.items()]
        lines.append("nothing in it is verified: a number may differ from the one that was written")
        return "\n".join(lines)


def salvage(path: str | Path, output: str | Path | None = None, *, time_limit: float = 120.0) -> Salvaged:
    """Keep what can still be read of a damaged analysis file.

    It is read by another process, because on damaged bytes libhdf5 may run for ever or crash. The output is a
    netCDF-4 file with the same groups as far as they could be read. It is not an analysis, and its attribute
    ``unverified`` says so: a number in it may differ from the one that was written.

    Parameters
    ----------
    path
        The damaged file.
    output
        File to write; ``NAME.salvaged.nc`` beside it by default. It must not exist.
    time_limit
        Seconds after which the reading is ended, with what was read until then.

    Raises
    ------
    StorageError
        If the file cannot be read, or the output exists or cannot be written.
    FormatError
        If the file is undamaged, or nothing of it can be read.
    """
    path = Path(path)
    output = path.with_suffix(".salvaged.nc") if output is None else Path(output)
    if Snapshot(path).sealed:
        msg = f"{path}: is undamaged, its seal matches its bytes; open it with open_analysis"
        raise FormatError(msg)
    if output.exists():
        msg = f"{output}: exists and is not replaced; choose another name or remove it"
        raise StorageError(msg)
    with tempfile.TemporaryDirectory() as folder:
        found, lost = _read(path, Path(folder), time.monotonic() + time_limit)
        tree = _tree(Path(folder), found, lost)
    read = tuple(f"{'' if group == '/' else group}/{name}" for group, ds in tree.items() for name in ds.variables)
    if not read:
        msg = f"{path}: nothing of it can be read ({'; '.join(f'{p}: {why}' for p, why in lost.items())}); use a copy"
        raise FormatError(msg)
    tree["/"] = tree["/"].assign_attrs(
        format=FORMAT,
        unverified=f"salvaged from {path.name}, whose bytes do not match its seal: any number may be wrong",
    )
    write_new_bytes(output, netcdf_image(tree))
    return Salvaged(output, read, lost)


def _read(path: Path, folder: Path, end: float) -> tuple[dict[str, dict[str, Any]], dict[str, str]]:
    """Items that child processes have read: a place at which one is lost is left out by the next."""
    found: dict[str, dict[str, Any]] = {}
    lost: dict[str, str] = {}
    while time.monotonic() < end:
        skip = json.dumps([*found, *lost])
        place = _one_child(path, folder, skip, end, found, lost)
        if not place or place in lost:
            return found, lost
        lost[place] = _LOST
    lost["/"] = "the time limit has passed; give a longer one"
    return found, lost


def _one_child(
    path: Path, folder: Path, skip: str, end: float, found: dict[str, dict[str, Any]], lost: dict[str, str]
) -> str:
    """Let one process read; the place at which it was lost, empty if it came to its end."""
    log = folder / "log"
    log.write_bytes(b"")
    words = [sys.executable, "-I", salvage_child.__file__, str(path.resolve()), str(folder)]
    child = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        assert child.stdin is not None
        child.stdin.write(skip.encode())
        child.stdin.close()
        size, heard = 0, time.monotonic()
        while child.poll() is None and time.monotonic() < min(end, heard + (_PATIENCE if size else _START)):
            time.sleep(0.02)
            if log.stat().st_size != size:
                size, heard = log.stat().st_size, time.monotonic()
    finally:
        child.kill()
        child.wait()
    at = "/"
    for line in log.read_text(encoding="utf-8").splitlines(keepends=True):
        if not line.endswith("\n"):
            break
        item = json.loads(line)
        at = item.get("at", at)
        if "lost" in item:
            lost[at] = item["lost"]
        elif "number" in item or "attrs" in item:
            found[at] = item
        elif "done" in item:
            return ""
    return at


def _tree(folder: Path, found: dict[str, dict[str, Any]], lost: dict[str, str]) -> dict[str, xr.Dataset]:
    """Datasets of what was read, by group; dimensions that were lost or contradict others get names of their own."""
    tree: dict[str, xr.Dataset] = {"/": xr.Dataset()}
    for place, item in found.items():
        words = found.get(f"{place} (attributes)", {})
        if "number" not in item or words.get("is_bare"):
            continue
        group, _, name = place.rpartition("/")
        ds = tree.get(group or "/", xr.Dataset(attrs=found.get(f"{group} (attributes)", {}).get("attrs", {})))
        try:
            values = np.load(folder / f"{item['number']}.npy", allow_pickle=False)
            values = values.astype(object) if values.dtype.kind == "U" else values
            own = [f"{name}_{k}" for k in range(values.ndim)]
            given = words.get("dims", own)
            # A name that came back for several of its dimensions was damaged.
            sizes = {dim: size for dim, size in zip(given, values.shape, strict=True) if given.count(dim) == 1}
            dims = [
                dim if dim in sizes and ds.sizes.get(dim, sizes[dim]) == sizes[dim] else other
                for dim, other in zip(given, own, strict=True)
            ]
            tree[group or "/"] = ds.assign({name: (dims, values, words.get("attrs", {}))})
        except (OSError, ValueError, EOFError) as error:
            lost[place] = str(error)
    return tree
