"""Histories whose values stay in their file until they are used."""

from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from blockstruct.storage.analysis_file import AnalysisFile, member, violated
from blockstruct.storage.netcdf import read_dataset, read_values


def lazy_history(file: AnalysisFile, case: str) -> xr.Dataset:
    """History of a case, whose group is named.

    Raises
    ------
    FormatError
        If the history violates the schema.
    """
    place = f"{case}/history"

    def stored(ds: Any, name: str) -> Any:
        return indexing.LazilyIndexedArray(_Stored(file, f"{place}/{name}", ds.shape, ds.dtype))

    history, found = file.group(place, "history", lambda group, outline: read_dataset(group, outline, stored))
    if history is None:
        raise violated(file.path, found)
    return history


class _Stored(BackendArray):
    """Values of one variable."""

    def __init__(self, file: AnalysisFile, place: str, shape: tuple[int, ...], dtype: Any) -> None:
        self._file, self._place, self.shape, self.dtype = file, place, shape, np.dtype(dtype)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)

    def _read(self, key: Any) -> Any:
        with self._file.opened() as groups:
            return read_values(member(groups, self._place), key)
