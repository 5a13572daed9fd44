"""Arrays and Datasets as bytes, for the records of a run: the format of NumPy is quick and holds no code."""

import json
import zipfile
from collections.abc import Mapping
from io import BytesIO

import numpy as np
import xarray as xr

#: What damaged bytes can make of their reader.
_DAMAGED = (ArithmeticError, EOFError, KeyError, MemoryError, OSError, RecursionError, TypeError, zipfile.BadZipFile)
_OUTLINE = "outline of the dataset"


def packed(arrays: Mapping[str, np.ndarray]) -> bytes:
    """Bytes of arrays."""
    stream = BytesIO()
    np.savez(stream, **{name: a.astype("U") if a.dtype.kind == "O" else a for name, a in arrays.items()})  # type: ignore[arg-type]
    return stream.getvalue()


def unpacked(content: bytes) -> dict[str, np.ndarray]:
    """Arrays of bytes; texts as objects.

    Raises
    ------
    ValueError
        If the bytes are not such a record.
    """
    try:
        with np.load(BytesIO(content), allow_pickle=False) as stored:
            if any(item.compress_type != zipfile.ZIP_STORED for item in stored.zip.infolist()):
                msg = "it is compressed"
                raise ValueError(msg)
            arrays = {name: stored[name] for name in stored.files}
    except _DAMAGED as error:
        msg = f"it is not a record of arrays: {error}"
        raise ValueError(msg) from error
    return {name: a.astype(object) if a.dtype.kind == "U" and a.size else a for name, a in arrays.items()}


def packed_dataset(ds: xr.Dataset) -> bytes:
    """Bytes of a Dataset."""
    variables = {str(name): v for name, v in ds.variables.items()}
    outline = {
        "variables": {name: [[str(d) for d in v.dims], v.attrs] for name, v in variables.items()},
        "coords": [str(name) for name in ds.coords],
        "attrs": ds.attrs,
    }
    return packed({**{name: v.to_numpy() for name, v in variables.items()}, _OUTLINE: np.array(json.dumps(outline))})


def unpacked_dataset(content: bytes) -> xr.Dataset:
    """Dataset of bytes.

    Raises
    ------
    ValueError
        If the bytes are not such a record.
    """
    arrays = unpacked(content)
    try:
        outline = json.loads(str(arrays[_OUTLINE]))
        variables = {name: (tuple(dims), arrays[name], attrs) for name, (dims, attrs) in outline["variables"].items()}
        coords = {name: variables.pop(name) for name in outline["coords"]}
        return xr.Dataset(variables, coords, outline["attrs"])
    except (*_DAMAGED, AttributeError) as error:
        msg = f"it is not a record of a history: {error}"
        raise ValueError(msg) from error
