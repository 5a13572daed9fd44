"""Datasets as groups of a netCDF-4 file, and back.

Written and read with h5py alone, because h5netcdf looks every dimension up by its name, which takes time that grows
with the square of the number of groups.
"""

from collections.abc import Callable, Iterator, Mapping
from itertools import count
from typing import Any

import h5py
import numpy as np
import xarray as xr

from blockstruct.storage.file_outline import plain

_TEXT = h5py.string_dtype()
_TEXT_TYPE, _ONE = h5py.h5t.py_create(_TEXT, logical=True), h5py.h5s.create(h5py.h5s.SCALAR)
#: What netCDF calls the scale of a dimension that has no coordinate, which is followed by its length.
_BARE = "This is a netCDF dimension but not a netCDF variable."
#: Attribute of a group that names the coordinates which are not dimensions, as xarray reads and writes it.
_COORDINATES = "coordinates"
#: Attribute of a scale: the number of its dimension, which no other dimension of the file has.
_DIMENSION = "_Netcdf4Dimid"
_NUMBERS = count()


def netcdf_image(tree: Mapping[str, xr.Dataset]) -> memoryview:
    """Bytes of a netCDF-4 file with a Dataset in each group; parents stand before their children.

    It is made in memory: libhdf5 crashes the process on a disk that is full.

    Parameters
    ----------
    tree
        Dataset of each group.
    """
    # libhdf5 takes two files of one name for the same, in other threads too.
    with h5py.File(f"image-{next(_NUMBERS)}", "w", driver="core", backing_store=False, track_order=True) as file:
        numbers = count()
        for path, ds in tree.items():
            _write(file if path == "/" else _created(file, path), ds, numbers)
        file.flush()
        return memoryview(file.id.get_file_image())


def read_group(group: h5py.Group, outline: Mapping[str, Any]) -> xr.Dataset:
    """Dataset of a group whose outline is as it must be."""
    return read_dataset(group, outline, lambda ds, _: read_values(ds))


def read_dataset(
    group: h5py.Group, outline: Mapping[str, Any], values: Callable[[h5py.Dataset, str], Any]
) -> xr.Dataset:
    """Dataset of a group, its values as a function of a variable and its name gives them."""
    variables = {}
    for name, variable in outline["variables"].items():
        ds = group[name]
        own = {key: plain(ds.attrs[key]) for key in ds.attrs if _is_own(key)}
        variables[name] = (tuple(variable["dims"]), values(ds, name), own)
    attrs = dict(outline["attrs"])
    coordinates = {*str(attrs.pop(_COORDINATES, "")).split(), *(d for dims, _, _ in variables.values() for d in dims)}
    coords = {name: variables.pop(name) for name in [n for n in variables if n in coordinates]}
    return xr.Dataset(variables, coords, attrs)


def read_values(ds: h5py.Dataset, key: Any = ()) -> Any:
    """Values of a variable, or some of them; texts as objects."""
    return ds.asstr()[key] if h5py.check_string_dtype(ds.dtype) else ds[key]


def dimension_number(scale: h5py.Dataset) -> int | None:
    """Return the number by which netCDF finds a dimension, if it has one."""
    number = scale.attrs.get(_DIMENSION)
    return None if number is None else int(number)


def _is_own(attribute: str) -> bool:
    return not attribute.startswith("_") and attribute not in ("CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST")


def _created(file: h5py.File, path: str) -> h5py.Group:
    """New group that keeps the order of what is put into it, as netCDF-4 wants."""
    kind, parent = h5py.h5p.create(h5py.h5p.GROUP_CREATE), file
    kind.set_link_creation_order(h5py.h5p.CRT_ORDER_TRACKED | h5py.h5p.CRT_ORDER_INDEXED)
    names = path.strip("/").split("/")
    for name in names:
        if name not in parent:
            h5py.h5g.create(parent.id, name.encode(), gcpl=kind)
        parent = parent[name]
    return parent


def _write(group: h5py.Group, ds: xr.Dataset, numbers: Iterator[int]) -> None:
    """Write a Dataset, whose dimensions take the next numbers of the file."""
    scales = {}
    for dim, size in ds.sizes.items():
        name = str(dim)
        scales[name] = scale = _stored(group, name, ds.variables[dim].values if dim in ds.variables else None, size)
        scale.make_scale(name if dim in ds.variables else f"{_BARE}{size:10d}")
        scale.attrs[_DIMENSION] = np.int32(next(numbers))
    for key, variable in ds.variables.items():
        item = scales.get(str(key))
        if item is None:
            item = _stored(group, str(key), variable.values)
            for k, dim in enumerate(variable.dims):
                h5py.h5ds.attach_scale(item.id, scales[str(dim)].id, k)
        _describe(item, variable.attrs)
    _describe(group, ds.attrs)
    others = [str(name) for name in ds.coords if name not in ds.sizes]
    if others:
        _describe(group, {_COORDINATES: " ".join(others)})


def _stored(group: h5py.Group, name: str, values: Any, size: int = 0) -> h5py.Dataset:
    if values is None:
        return group.create_dataset(name, (size,), ">f4")
    if values.dtype.kind in "OU":
        return group.create_dataset(name, data=values.astype(object), dtype=_TEXT)
    return group.create_dataset(name, data=values)


def _describe(item: Any, attrs: dict[Any, Any]) -> None:
    for name, value in attrs.items():
        if isinstance(value, str):
            # Straight, for item.attrs takes its time, and a small file is mostly attributes.
            h5py.h5a.create(item.id, str(name).encode(), _TEXT_TYPE, _ONE).write(np.array(value, dtype=_TEXT))
        else:
            item.attrs[str(name)] = value
