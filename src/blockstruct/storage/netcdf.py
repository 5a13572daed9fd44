"""Datasets as groups of a netCDF-4 file, and back, without trust in the file.

h5py alone writes and reads them: h5netcdf looks every dimension up by its name, which takes time that grows with the
square of the number of groups.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import count
from typing import Any, NamedTuple

import h5py
import numpy as np
import xarray as xr

from blockstruct.errors import FormatError

_TEXT = h5py.string_dtype()
_TEXT_TYPE, _ONE = h5py.h5t.py_create(_TEXT, logical=True), h5py.h5s.create(h5py.h5s.SCALAR)
_NUMBER_TYPE = h5py.h5t.py_create(np.dtype(np.int32))
#: What netCDF calls the scale of a dimension without a coordinate; its length follows.
_BARE = "This is a netCDF dimension but not a netCDF variable."
#: Attribute of a group that names the coordinates which are not dimensions, as xarray reads and writes it.
_COORDINATES = "coordinates"
#: Attribute of a scale: the number of its dimension, which no other dimension of the file has.
_DIMENSION = "_Netcdf4Dimid"
#: Attributes of variables by which HDF5 knows scales.
_OF_HDF5 = ("CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST")
_NUMBERS = count()
#: Variables keep the order of their attributes, as netCDF-4 demands.
_IN_ORDER = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
_IN_ORDER.set_attr_creation_order(h5py.h5p.CRT_ORDER_TRACKED | h5py.h5p.CRT_ORDER_INDEXED)
#: Members that a group has at most.
_MEMBERS = 1000
#: Bytes of text that are read at once, at most, if the file is larger than its longest text.
_CHUNK = 1_000_000_000


def netcdf_image(tree: Mapping[str, xr.Dataset]) -> bytes:
    """Return the bytes of a netCDF-4 file with a Dataset in each group; parents stand before their children.

    The file is made in memory: libhdf5 crashes the process on a full disk.
    """
    numbers = count()
    # libhdf5 takes two files of one name for the same, in other threads too.
    name = f"image-{next(_NUMBERS)}"
    with h5py.File(name, "w", driver="core", backing_store=False, track_order=True) as file:
        for path, ds in tree.items():
            _write(file if path == "/" else _created(file, path), ds, numbers)
        file.flush()
        image: bytes = file.id.get_file_image()
    return image


class Outline(NamedTuple):
    """A group without its values.

    Attributes
    ----------
    lines : dict
        Attributes, variables (dimensions, kind and units) and names of the groups of a group, for the schema.
    variables : dict
        Dataset and attributes of each variable.
    """

    lines: dict[str, Any]
    variables: dict[str, tuple[h5py.h5d.DatasetID, dict[str, Any]]]


def read_dataset(outline: Outline, values: Callable[[h5py.h5d.DatasetID, str], Any] | None = None) -> xr.Dataset:
    """Return the Dataset of a group whose outline is valid; its values are read, or as a function gives them."""
    variables = {}
    for name, variable in outline.lines["variables"].items():
        ds, attrs = outline.variables[name]
        variables[name] = (tuple(variable["dims"]), values(ds, name) if values else _read(ds, variable["kind"]), attrs)
    attrs = dict(outline.lines["attrs"])
    coordinates = {*str(attrs.pop(_COORDINATES, "")).split(), *(d for dims, _, _ in variables.values() for d in dims)}
    coords = {name: variables.pop(name) for name in [n for n in variables if n in coordinates]}
    return xr.Dataset(variables, coords, attrs)


def read_values(ds: h5py.Dataset, key: Any = ()) -> Any:
    """Return the values of a variable, or a part; texts as objects."""
    return ds.asstr()[key] if h5py.check_string_dtype(ds.dtype) else ds[key]


def read_numbers(item: h5py.h5d.DatasetID) -> np.ndarray:
    """Return all values of a variable of numbers; several times as fast as the higher interface of h5py."""
    values = np.empty(item.shape, item.dtype)
    if values.size:
        item.read(h5py.h5s.ALL, h5py.h5s.ALL, values)
    return values


def _read(item: h5py.h5d.DatasetID, kind: str) -> Any:
    return read_values(h5py.Dataset(item)) if kind == "text" else read_numbers(item)


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


def outline(group: h5py.Group) -> Outline:
    """Return the outline of a group.

    A variable that leads out of the file, or to more data than the file has bytes, gets a kind that no schema has.

    Raises
    ------
    FormatError
        If the group has an absurd number of members.
    """
    if len(group) > _MEMBERS:
        msg = f"{len(group)} members are absurd, more than {_MEMBERS}"
        raise FormatError(msg)
    file, lines, members = group.id, dict[str, Any](), dict[str, Any]()
    for key in file:
        name = key.decode()
        if file.links.get_info(key).type == h5py.h5l.TYPE_HARD:
            members[name] = h5py.h5o.open(file, key)
        else:
            lines[name] = {"kind": "link"}
    names = {_address(item): name for name, item in members.items()}
    variables: dict[str, tuple[h5py.h5d.DatasetID, dict[str, Any]]] = {}
    left = size = int(group.file.id.get_filesize())
    for name, item in members.items():
        if isinstance(item, h5py.h5d.DatasetID) and not _is_bare(item):
            attrs, dtype = attributes(item), item.dtype
            n_bytes = math.prod(item.shape) * int(dtype.itemsize)
            is_text = h5py.check_string_dtype(dtype) is not None
            left -= n_bytes + (_bytes_of_texts(item, left - n_bytes, size) if is_text else 0)
            kind = _fault(item, n_bytes, is_absurd=left < 0) or ("text" if is_text else dtype.kind)
            # Units are compared as they stand: a text from a file is never given to a parser.
            units = {"units": str(attrs["units"])} if "units" in attrs else {}
            lines[name], variables[name] = {"dims": _dimensions(item, names), "kind": kind, **units}, (item, attrs)
    content = {
        "attrs": attributes(file),
        "variables": lines,
        "groups": {name: {} for name, item in members.items() if not isinstance(item, h5py.h5d.DatasetID)},
    }
    return Outline(content, variables)


def _is_bare(item: h5py.h5d.DatasetID) -> bool:
    """Return whether a variable is the scale of a dimension without a coordinate, which holds nothing."""
    return h5py.h5ds.is_scale(item) and _BARE.encode() in h5py.h5ds.get_scale_name(item)


def attributes(item: h5py.h5d.DatasetID | h5py.h5g.GroupID) -> dict[str, Any]:
    """Return the attributes of a variable or a group that are not HDF5's or netCDF's own."""
    names: list[bytes] = []
    h5py.h5a.iterate(item, names.append)
    attrs = {}
    for key in names:
        name = key.decode()
        if name.startswith("_") or name in _OF_HDF5:
            continue
        attribute = h5py.h5a.open(item, key)
        if attribute.shape == () and attribute.get_type() == _TEXT_TYPE:
            text = np.empty((), _TEXT)
            attribute.read(text)
            attrs[name] = plain(text.item())
        else:
            holder = h5py.Dataset if isinstance(item, h5py.h5d.DatasetID) else h5py.Group
            attrs[name] = plain(holder(item).attrs[name])
    return attrs


def _fault(item: h5py.h5d.DatasetID, n_bytes: int, *, is_absurd: bool) -> str:
    """Return why the values of a variable are not read; empty if they are stored whole in this file."""
    stored_by = item.get_create_plist()
    if stored_by.get_layout() == h5py.h5d.VIRTUAL or stored_by.get_external_count():
        return "stored in another file"
    if is_absurd:
        return f"of an absurd size, {item.shape}"
    # h5py would read missing values as the fill value.
    return "not stored whole" if item.get_storage_size() < n_bytes else ""


def _dimensions(item: h5py.h5d.DatasetID, names: Mapping[int, str]) -> list[str]:
    """Return the names of the scales of a variable in its own group, which are found by their address."""
    if item.rank == 1 and h5py.h5ds.is_scale(item):
        return [names[_address(item)]]
    dims = []
    for k, size in enumerate(item.shape):
        scales: list[h5py.h5d.DatasetID] = []
        if h5py.h5ds.get_num_scales(item, k):
            h5py.h5ds.iterate(item, k, scales.append)
        fits = bool(scales) and scales[0].shape == (size,)
        dims.append(names.get(_address(scales[0]), "?") if fits else "?")
    return dims


def _bytes_of_texts(item: h5py.h5d.DatasetID, most: int, file_size: int) -> int:
    """Return the bytes of the texts of a list; counted until they are more than the given number."""
    total = 0
    if most >= 0 and item.rank == 1:
        # Many elements can point to one long text.
        step, ds = max(1, _CHUNK // file_size), h5py.Dataset(item)
        for start in range(0, len(ds), step):
            total += sum(map(len, ds[start : start + step]))
            if total > most:
                break
    return total


def _address(item: Any) -> int:
    return int(h5py.h5o.get_info(item).addr)


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
    """Write a Dataset, whose dimensions take the next numbers of the file.

    By the lower interface of h5py, because a small file is mostly headers and attributes, at which the other is slow.
    """
    scales, place = {}, group.id
    for dim, size in ds.sizes.items():
        name = str(dim)
        scales[name] = scale = _stored(place, name, ds.variables[dim].values if dim in ds.variables else None, size)
        h5py.h5ds.set_scale(scale, (name if dim in ds.variables else f"{_BARE}{size:10d}").encode())
        h5py.h5a.create(scale, _DIMENSION.encode(), _NUMBER_TYPE, _ONE).write(np.array(next(numbers), np.int32))
    for key, variable in ds.variables.items():
        item = scales.get(str(key))
        if item is None:
            item = _stored(place, str(key), variable.values)
            for k, dim in enumerate(variable.dims):
                h5py.h5ds.attach_scale(item, scales[str(dim)], k)
        _describe(item, variable.attrs)
    others = [str(name) for name in ds.coords if name not in ds.sizes]
    _describe(place, ds.attrs | ({_COORDINATES: " ".join(others)} if others else {}))


def _stored(place: h5py.h5g.GroupID, name: str, values: Any, size: int = 0) -> h5py.h5d.DatasetID:
    if values is None:
        kind, shape = h5py.h5t.IEEE_F32BE, (size,)
    elif values.dtype.kind in "OU":
        values = np.array(values, dtype=_TEXT)
        kind, shape = _TEXT_TYPE, values.shape
    else:
        kind, shape = h5py.h5t.py_create(values.dtype), values.shape
    space = h5py.h5s.create_simple(shape) if shape else _ONE
    item = h5py.h5d.create(place, name.encode(), kind, space, dcpl=_IN_ORDER)
    if values is not None and values.size:
        item.write(h5py.h5s.ALL, h5py.h5s.ALL, np.ascontiguousarray(values))
    return item


def _describe(item: Any, attrs: Mapping[Any, Any]) -> None:
    for name, value in attrs.items():
        is_text = isinstance(value, str)
        values = np.array(value, dtype=_TEXT if is_text else None)
        kind = _TEXT_TYPE if is_text else h5py.h5t.py_create(values.dtype)
        space = h5py.h5s.create_simple(values.shape) if values.shape else _ONE
        h5py.h5a.create(item, str(name).encode(), kind, space).write(values)
