"""Reads a damaged file, item by item, and tells of each before it touches it: a process of its own, for it may crash.

Run as ``python -I salvage_child.py FILE FOLDER``, with a JSON list of the places to leave out on standard input. It
imports nothing of blockstruct, so that it starts quickly and is lost alone.
"""

import contextlib
import json
import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np

#: Bytes of memory that reading may take, where the system can limit it, and of one variable at most.
_MEMORY = 8 << 30
_LARGEST = 1 << 30
_DEEPEST = 4


def main(path: str, folder: Path, skip: set[str]) -> None:
    """Read what there is."""
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    with (folder / "log").open("a", encoding="utf-8") as log:
        reader = _Reader(log, folder, skip)
        with reader.at("/"), h5py.File(path, "r") as file:
            reader.group(file, "", 0)
        reader.tell(done=True)


class _Reader:
    def __init__(self, log: Any, folder: Path, skip: set[str]) -> None:
        self.log, self.folder, self.skip, self.number = log, folder, skip, len(list(folder.glob("*.npy")))

    def tell(self, **words: Any) -> None:
        print(json.dumps(words), file=self.log, flush=True)

    @contextlib.contextmanager
    def at(self, place: str) -> Any:
        """Tell where reading is; what an item makes of its reader is its own loss."""
        self.tell(at=place)
        try:
            yield
        except Exception as error:  # Whatever the libraries make of damaged bytes.
            self.tell(at=place, lost=str(error) or type(error).__name__)

    def group(self, group: Any, place: str, depth: int) -> None:
        names: list[str] = []
        if f"{place}/" not in self.skip:
            with self.at(f"{place}/"):
                self.tell(at=f"{place}/", number=-1, attrs=_attrs(group))
        if f"{place}/*" in self.skip:
            return
        with self.at(f"{place}/*"):
            names = [name for name in group if isinstance(group.get(name, getlink=True), h5py.HardLink)]
        for name in names:
            if f"{place}/{name}" not in self.skip:
                with self.at(f"{place}/{name}"):
                    item = group[name]
                    if isinstance(item, h5py.Dataset):
                        self.dataset(item, f"{place}/{name}")
                    elif depth < _DEEPEST:
                        self.group(item, f"{place}/{name}", depth + 1)

    def dataset(self, ds: Any, place: str) -> None:
        if b"not a netCDF variable" in bytes(ds.attrs.get("NAME", b"")):
            return
        if ds.nbytes > _LARGEST or ds.external or ds.is_virtual:
            self.tell(at=place, lost=f"of an absurd size or in another file, {ds.shape}")
            return
        dims = [_dimension(ds, k) for k in range(ds.ndim)]
        values = np.asarray(ds.asstr()[()] if h5py.check_string_dtype(ds.dtype) else ds[()])
        values = values.astype("U") if values.dtype.kind == "O" else values
        np.save(self.folder / f"{self.number}.npy", values, allow_pickle=False)
        self.tell(at=place, number=self.number, dims=dims, attrs=_attrs(ds))
        self.number += 1


def _dimension(ds: Any, k: int) -> str:
    own = str(ds.name).rpartition("/")[2]
    if ds.ndim == 1 and ds.is_scale:
        return own
    with contextlib.suppress(Exception):
        return str(ds.dims[k][0].name).rpartition("/")[2]
    return f"{own}_{k}"


def _attrs(item: Any) -> dict[str, str]:
    found = {}
    for name in item.attrs:
        if not name.startswith("_") and name not in ("CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST"):
            with contextlib.suppress(Exception):
                value = item.attrs[name]
                found[name] = value if isinstance(value, str) else str(value)
    return found


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), set(json.load(sys.stdin)))
