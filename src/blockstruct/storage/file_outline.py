"""The outline of a group, as the schema describes it: read without trusting the file."""

from collections.abc import Iterable, Mapping
from typing import Any

import h5py
import numpy as np
import xarray as xr

from blockstruct.errors import FormatError

#: Members that a group has at most.
_MEMBERS = 1000
#: Bytes of text that are read at once, at most, if the file is larger than its longest text.
_CHUNK = 1_000_000_000


def outline(group: h5py.Group) -> dict[str, Any]:
    """Attributes, variables (dimensions, kind and units) and names of the groups of a group.

    What could lead out of the file, round in it, or to more data than fit in memory gets a kind that no schema has.

    Raises
    ------
    FormatError
        If the group has an absurd number of members.
    """
    if len(group) > _MEMBERS:
        msg = f"{len(group)} members are absurd, more than {_MEMBERS}"
        raise FormatError(msg)
    links = [name for name in group if not isinstance(group.get(name, getlink=True), h5py.HardLink)]
    members = {name: group[name] for name in group if name not in links}
    names = {_address(item): name for name, item in members.items()}
    size = int(group.file.id.get_filesize())
    budget = _Budget(size)
    return {
        "attrs": {k: plain(v) for k, v in group.attrs.items() if not k.startswith("_")},
        "variables": {name: {"kind": "link"} for name in links}
        | {
            name: _variable(item, names, budget)
            for name, item in members.items()
            if isinstance(item, h5py.Dataset) and not _is_bare_dimension(item)
        },
        "groups": {name: {} for name, item in members.items() if not isinstance(item, h5py.Dataset)},
    }


def outline_of(ds: xr.Dataset, groups: Iterable[str]) -> dict[str, Any]:
    """Outline that the group of a Dataset will have."""
    return {
        "attrs": dict(ds.attrs),
        "variables": {
            str(name): {
                "dims": [str(d) for d in v.dims],
                "kind": "text" if v.dtype.kind in "OU" else v.dtype.kind,
                **({"units": str(v.attrs["units"])} if "units" in v.attrs else {}),
            }
            for name, v in ds.variables.items()
        },
        "groups": {name: {} for name in groups},
    }


def plain(value: Any) -> Any:
    """Attribute as plain Python: netCDF keeps a number as an array of one."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value.item() if isinstance(value, np.generic) else value


def _variable(ds: h5py.Dataset, names: Mapping[int, str], budget: "_Budget") -> dict[str, Any]:
    kind = "text" if h5py.check_string_dtype(ds.dtype) else ds.dtype.kind
    variable = {"dims": _dimensions(ds, names), "kind": kind}
    if "units" in ds.attrs:
        # Compared as it stands: a text from a file is never given to a parser.
        variable["units"] = str(plain(ds.attrs["units"]))
    if ds.is_virtual or ds.external:
        variable["kind"] = "stored in another file"
    elif not budget.affords(ds):
        variable["kind"] = f"of an absurd size, {ds.shape}"
    elif ds.id.get_storage_size() < ds.nbytes:
        # h5py would read what is missing as the fill value.
        variable["kind"] = "not stored whole"
    return variable


def _dimensions(ds: h5py.Dataset, names: Mapping[int, str]) -> list[str]:
    """Names of the scales of a dataset in its own group: found by address, which takes no search through the file."""
    if ds.ndim == 1 and ds.is_scale:
        return [names[_address(ds)]]
    found = []
    for k, size in enumerate(ds.shape):
        scale = ds.dims[k][0] if len(ds.dims[k]) else None
        fits = scale is not None and scale.shape == (size,)
        found.append(names.get(_address(scale), "?") if fits else "?")
    return found


class _Budget:
    """How much of a group may be read."""

    def __init__(self, file_size: int) -> None:
        self._file_size = file_size
        self._left = file_size

    def affords(self, ds: h5py.Dataset) -> bool:
        """Whether a dataset and all before it may be read."""
        self._left -= ds.size * ds.dtype.itemsize
        if self._left >= 0 and ds.ndim == 1 and h5py.check_string_dtype(ds.dtype):
            # Many elements can point to one long text.
            step = max(1, _CHUNK // self._file_size)
            for start in range(0, len(ds), step):
                self._left -= sum(map(len, ds[start : start + step]))
                if self._left < 0:
                    break
        return self._left >= 0


def _address(item: Any) -> int:
    return int(h5py.h5o.get_info(item.id).addr)


def _is_bare_dimension(ds: h5py.Dataset) -> bool:
    """Whether a dataset only stands for a netCDF dimension without coordinate values."""
    return b"not a netCDF variable" in bytes(ds.attrs.get("NAME", b""))
