"""Datasets as groups of a netCDF-4 file, and back, without trust in the file.

h5py alone writes and reads them: h5netcdf looks every dimension up by its name, which takes time that grows with the
square of the number of groups.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import count
from typing import Any, NamedTuple

import h5py
import numpy as np
import xarray as xr

from blockstruct.errors import FormatError

_TEXT = h5py.string_dtype()
_TEXT_TYPE, _ONE = h5py.h5t.py_create(_TEXT, logical=True), h5py.h5s.create(h5py.h5s.SCALAR)
#: What netCDF calls the scale of a dimension without a coordinate; its length follows.
_BARE = "This is a netCDF dimension but not a netCDF variable."
#: Attribute of a group that names the coordinates which are not dimensions, as xarray reads and writes it.
_COORDINATES = "coordinates"
#: Attribute of a scale: the number of its dimension, which no other dimension of the file has.
_DIMENSION = "_Netcdf4Dimid"
_OF_HDF5 = ("CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST")
_NUMBERS = count()
#: Variables keep the order of their attributes, as netCDF-4 demands.
_IN_ORDER = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
_IN_ORDER.set_attr_creation_order(h5py.h5p.CRT_ORDER_TRACKED | h5py.h5p.CRT_ORDER_INDEXED)
#: Members that a group has at most.
_MEMBERS = 1000
#: Bytes of text that are read at once, at most, if the file is larger than its longest text.
_CHUNK = 1_000_000_000


class Image(NamedTuple):
    """The bytes of a netCDF-4 file, and the number of its dimensions."""

    content: bytes
    dimensions: int


def netcdf_image(tree: Mapping[str, xr.Dataset], start: Image | None = None) -> Image:
    """Return a netCDF-4 file with a Dataset in each group; parents stand before their children.

    The file is made in memory: libhdf5 crashes the process on a full disk. It has the groups of another image, too, if
    one is given.
    """
    if start is None:
        # libhdf5 takes two files of one name for the same, in other threads too.
        name = f"image-{next(_NUMBERS)}"
        opened = h5py.File(name, "w", driver="core", backing_store=False, track_order=True)
    else:
        opened = h5py.File(h5py.h5f.open_file_image(start.content, h5py.h5f.FILE_IMAGE_OPEN_RW))
    with opened as file:
        numbers = count(start.dimensions if start else 0)
        for path, ds in tree.items():
            _write(file if path == "/" else _created(file, path), ds, numbers)
        file.flush()
        return Image(file.id.get_file_image(), next(numbers))


def read_dataset(
    group: h5py.Group, outline: Mapping[str, Any], values: Callable[[h5py.Dataset, str], Any] | None = None
) -> xr.Dataset:
    """Return the Dataset of a group whose outline is valid; its values are read, or as a function gives them."""
    variables = {}
    for name, variable in outline["variables"].items():
        ds = group[name]
        own = {key: plain(ds.attrs[key]) for key in ds.attrs if not key.startswith("_") and key not in _OF_HDF5}
        variables[name] = (tuple(variable["dims"]), values(ds, name) if values else read_values(ds), own)
    attrs = dict(outline["attrs"])
    coordinates = {*str(attrs.pop(_COORDINATES, "")).split(), *(d for dims, _, _ in variables.values() for d in dims)}
    coords = {name: variables.pop(name) for name in [n for n in variables if n in coordinates]}
    return xr.Dataset(variables, coords, attrs)


def read_values(ds: h5py.Dataset, key: Any = ()) -> Any:
    """Return the values of a variable, or a part; texts as objects."""
    return ds.asstr()[key] if h5py.check_string_dtype(ds.dtype) else ds[key]


def dimension_number(scale: h5py.Dataset) -> int | None:
    """Return the number by which netCDF finds a dimension, if it has one."""
    number = scale.attrs.get(_DIMENSION)
    return None if number is None else int(number)


def member(file: h5py.Group, place: str) -> Any:
    """Return a member by its path; a link out of the file or to elsewhere in it is refused."""
    item = file
    for name in place.strip("/").split("/"):
        link = item.get(name, getlink=True) if isinstance(item, h5py.Group) else None
        if not isinstance(link, h5py.HardLink):
            msg = f"{place}: {name!r} is missing, or a link to elsewhere"
            raise FormatError(msg)
        item = item[name]
    return item


def plain(value: Any) -> Any:
    """Return an attribute as plain Python: netCDF keeps a number as an array of one."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value.item() if isinstance(value, np.generic) else value


def outline_of(ds: xr.Dataset, groups: Iterable[str]) -> dict[str, Any]:
    """Return the outline that the group of a Dataset will have."""
    variables = {
        str(name): {"dims": [str(d) for d in v.dims], "kind": "text" if v.dtype.kind in "OU" else v.dtype.kind}
        | ({"units": str(v.attrs["units"])} if "units" in v.attrs else {})
        for name, v in ds.variables.items()
    }
    return {"attrs": dict(ds.attrs), "variables": variables, "groups": {name: {} for name in groups}}


def outline(group: h5py.Group) -> dict[str, Any]:
    """Return attributes, variables (dimensions, kind and units) and names of the groups of a group.

    A variable that leads out of the file, or to more data than the file has bytes, gets a kind that no schema has.

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
    variables: dict[str, Any] = {name: {"kind": "link"} for name in links}
    left = size = int(group.file.id.get_filesize())
    for name, item in members.items():
        # The scale of a dimension without a coordinate holds nothing.
        if isinstance(item, h5py.Dataset) and _BARE not in str(plain(item.attrs.get("NAME", ""))):
            left -= _bytes_of(item, left, size)
            variables[name] = _variable(item, names, is_absurd=left < 0)
    return {
        "attrs": {k: plain(v) for k, v in group.attrs.items() if not k.startswith("_")},
        "variables": variables,
        "groups": {name: {} for name, item in members.items() if not isinstance(item, h5py.Dataset)},
    }


def _variable(ds: h5py.Dataset, names: Mapping[int, str], *, is_absurd: bool) -> dict[str, Any]:
    kind = "text" if h5py.check_string_dtype(ds.dtype) else ds.dtype.kind
    if ds.is_virtual or ds.external:
        kind = "stored in another file"
    elif is_absurd:
        kind = f"of an absurd size, {ds.shape}"
    elif ds.id.get_storage_size() < ds.nbytes:
        # h5py would read missing values as the fill value.
        kind = "not stored whole"
    # Units are compared as they stand: a text from a file is never given to a parser.
    units = {"units": str(plain(ds.attrs["units"]))} if "units" in ds.attrs else {}
    return {"dims": _dimensions(ds, names), "kind": kind, **units}


def _dimensions(ds: h5py.Dataset, names: Mapping[int, str]) -> list[str]:
    """Return the names of the scales of a dataset in its own group, which are found by their address."""
    if ds.ndim == 1 and ds.is_scale:
        return [names[_address(ds)]]
    found = []
    for k, size in enumerate(ds.shape):
        scale = ds.dims[k][0] if len(ds.dims[k]) else None
        fits = scale is not None and scale.shape == (size,)
        found.append(names.get(_address(scale), "?") if fits else "?")
    return found


def _bytes_of(ds: h5py.Dataset, most: int, file_size: int) -> int:
    """Return the bytes of a dataset, its texts included; counted until they are more than the given number."""
    found = int(ds.nbytes)
    if found <= most and ds.ndim == 1 and h5py.check_string_dtype(ds.dtype):
        # Many elements can point to one long text.
        step = max(1, _CHUNK // file_size)
        for start in range(0, len(ds), step):
            found += sum(map(len, ds[start : start + step]))
            if found > most:
                break
    return found


def _address(item: Any) -> int:
    return int(h5py.h5o.get_info(item.id).addr)


def _created(file: h5py.File, path: str) -> h5py.Group:
    """Return a new group that keeps the order of its members, as netCDF-4 demands."""
    kind, parent = h5py.h5p.create(h5py.h5p.GROUP_CREATE), file
    kind.set_link_creation_order(h5py.h5p.CRT_ORDER_TRACKED | h5py.h5p.CRT_ORDER_INDEXED)
    for name in path.strip("/").split("/"):
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
    # The lower interface, because group.create_dataset is slow.
    if values is None:
        kind, shape = h5py.h5t.IEEE_F32BE, (size,)
    elif values.dtype.kind in "OU":
        values = np.array(values, dtype=_TEXT)
        kind, shape = _TEXT_TYPE, values.shape
    else:
        kind, shape = h5py.h5t.py_create(values.dtype), values.shape
    space = h5py.h5s.create_simple(shape) if shape else _ONE
    item = h5py.h5d.create(group.id, name.encode(), kind, space, dcpl=_IN_ORDER)
    if values is not None and values.size:
        item.write(h5py.h5s.ALL, h5py.h5s.ALL, np.ascontiguousarray(values))
    return h5py.Dataset(item)


def _describe(item: Any, attrs: Mapping[Any, Any]) -> None:
    for name, value in attrs.items():
        if isinstance(value, str):
            # The lower interface, because item.attrs is slow and a small file is mostly attributes.
            h5py.h5a.create(item.id, str(name).encode(), _TEXT_TYPE, _ONE).write(np.array(value, dtype=_TEXT))
        else:
            item.attrs[str(name)] = value
