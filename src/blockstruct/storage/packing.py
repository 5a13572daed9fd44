"""Datasets as bytes, for the records of a run: arrays in the format of NumPy, which is quick and holds no code."""

import json
import zipfile
from io import BytesIO
from typing import Any

import numpy as np
import xarray as xr

#: What damaged bytes can make of their reader.
_DAMAGED = (ArithmeticError, EOFError, KeyError, MemoryError, OSError, RecursionError, TypeError, zipfile.BadZipFile)
_OUTLINE = "outline of the dataset"


def packed(ds: xr.Dataset) -> bytes:
    """Bytes of a Dataset."""
    variables = {str(name): v for name, v in ds.variables.items()}
    outline = {
        "variables": {name: [[str(d) for d in v.dims], v.attrs] for name, v in variables.items()},
        "coords": [str(name) for name in ds.coords],
        "attrs": ds.attrs,
    }
    arrays: dict[str, Any] = {
        name: v.values.astype("U") if v.dtype.kind == "O" else v.values for name, v in variables.items()
    }
    arrays[_OUTLINE] = np.array(json.dumps(outline))
    stream = BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def unpacked(content: bytes) -> xr.Dataset:
    """Dataset of bytes.

    Raises
    ------
    ValueError
        Bytes that are none.
    """
    try:
        with np.load(BytesIO(content), allow_pickle=False) as stored:
            if any(item.compress_type != zipfile.ZIP_STORED for item in stored.zip.infolist()):
                msg = "it is compressed"
                raise ValueError(msg)
            arrays = {name: stored[name] for name in stored.files}
        outline = json.loads(str(arrays[_OUTLINE]))
        variables = {
            name: (tuple(dims), _texts(arrays[name]), attrs) for name, (dims, attrs) in outline["variables"].items()
        }
        coords = {name: variables.pop(name) for name in outline["coords"]}
        return xr.Dataset(variables, coords, outline["attrs"])
    except _DAMAGED as error:
        msg = f"it is no record of arrays: {error}"
        raise ValueError(msg) from error


def _texts(values: Any) -> Any:
    return values.astype(object) if values.dtype.kind == "U" and values.size else values
