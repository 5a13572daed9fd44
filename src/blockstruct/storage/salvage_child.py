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
            # What describes values is in the part of a file that is lost most easily: they come first.
            for look in (reader.values, reader.words):
                reader.walk(file, "", look)
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

    def walk(self, group: Any, place: str, look: Any) -> None:
        """Look at everything in a group, and in the groups in it."""
        look(group, place)
        names: list[str] = []
        if f"{place}/*" not in self.skip:
            with self.at(f"{place}/*"):
                names = [*group]
        for name in names:
            path = f"{place}/{name}"
            item = None
            if path not in self.skip or look == self.words:
                with self.at(path):
                    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                        msg = "a link to elsewhere, which is not followed"
                        raise ValueError(msg)
                    item = group[name]
            if isinstance(item, h5py.Dataset):
                look(item, path)
            elif item is not None and path.count("/") < _DEEPEST:
                self.walk(item, path, look)

    def values(self, item: Any, place: str) -> None:
        """Keep the values of a dataset."""
        if not isinstance(item, h5py.Dataset) or place in self.skip:
            return
        with self.at(place):
            if item.nbytes > _LARGEST or item.external or item.is_virtual:
                self.tell(at=place, lost=f"of an absurd size or in another file, {item.shape}")
                return
            values = np.asarray(item.asstr()[()] if h5py.check_string_dtype(item.dtype) else item[()])
            values = values.astype("U") if values.dtype.kind == "O" else values
            np.save(self.folder / f"{self.number}.npy", values, allow_pickle=False)
            self.tell(at=place, number=self.number)
            self.number += 1

    def words(self, item: Any, place: str) -> None:
        """Tell the dimensions and the attributes of an item."""
        what = f"{place} (attributes)"
        if what in self.skip:
            return
        with self.at(what):
            is_bare = b"not a netCDF variable" in bytes(item.attrs.get("NAME", b""))
            dims = [_dimension(item, k) for k in range(item.ndim)] if isinstance(item, h5py.Dataset) else []
            self.tell(at=what, attrs=_attrs(item), dims=dims, is_bare=is_bare)


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
