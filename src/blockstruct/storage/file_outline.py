"""The skeleton of a file, as the schema describes it: read without trusting the file."""

from typing import Any

import h5py
import numpy as np

#: Largest size of all data together, in multiples of the size of the file: compression may make some of that.
EXPANSION = 100
#: Bytes of text that are read at once, at most, if the file is larger than its longest text.
_CHUNK = 1_000_000_000


def skeleton(file: h5py.File) -> dict[str, Any]:
    """Attributes, variables (dimensions, kind and units) and groups of a file.

    What could lead out of the file, round in it, or to more data than fit in memory gets a kind that no schema has.
    """
    return _Walk(file).group(file)


def plain(value: Any) -> Any:
    """Attribute as plain Python: netCDF keeps a number as an array of one."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value.item() if isinstance(value, np.generic) else value


class _Walk:
    def __init__(self, file: h5py.File) -> None:
        self.file_size = int(file.id.get_filesize())
        self.left = EXPANSION * self.file_size
        self.seen: set[int] = set()

    def group(self, group: h5py.Group) -> dict[str, Any]:
        self.seen.add(h5py.h5o.get_info(group.id).addr)
        variables: dict[str, Any] = {}
        groups: dict[str, Any] = {}
        for name in group:
            # A link out of the file, or to elsewhere in it, is nothing blockstruct writes: it is never followed.
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                variables[name] = {"kind": "link"}
            elif isinstance(group[name], h5py.Group):
                twice = h5py.h5o.get_info(group[name].id).addr in self.seen
                groups[name] = {"variables": {name: {"kind": "link"}}} if twice else self.group(group[name])
            elif not _is_bare_dimension(group[name]):
                variables[name] = self.variable(group[name], name)
        attrs = {k: plain(v) for k, v in group.attrs.items() if not k.startswith("_")}
        return {"attrs": attrs, "variables": variables, "groups": groups}

    def variable(self, ds: h5py.Dataset, name: str) -> dict[str, Any]:
        kind = "text" if h5py.check_string_dtype(ds.dtype) else ds.dtype.kind
        if ds.ndim == 1 and ds.is_scale:
            dims = [name]
        else:
            scales = [ds.dims[k][0] if len(ds.dims[k]) else None for k in range(ds.ndim)]
            dims = [
                str(scale.name).rpartition("/")[2] if scale is not None and len(scale) == size else "?"
                for scale, size in zip(scales, ds.shape, strict=True)
            ]
        variable = {"dims": dims, "kind": kind}
        if "units" in ds.attrs:
            # Compared as it stands: a text from a file is never given to a parser.
            variable["units"] = str(plain(ds.attrs["units"]))
        if ds.is_virtual or ds.external:
            variable["kind"] = "stored in another file"
        elif not self._affords(ds):
            variable["kind"] = f"of an absurd size, {ds.shape}"
        return variable

    def _affords(self, ds: h5py.Dataset) -> bool:
        """Whether a dataset and all before it may be read."""
        self.left -= ds.size * ds.dtype.itemsize
        if self.left >= 0 and ds.ndim == 1 and h5py.check_string_dtype(ds.dtype):
            # Many elements can point to one long text.
            step = max(1, _CHUNK // self.file_size)
            for start in range(0, len(ds), step):
                self.left -= sum(map(len, ds[start : start + step]))
                if self.left < 0:
                    break
        return self.left >= 0


def _is_bare_dimension(ds: h5py.Dataset) -> bool:
    """Whether a dataset only stands for a netCDF dimension without coordinate values."""
    return b"not a netCDF variable" in bytes(ds.attrs.get("NAME", b""))
