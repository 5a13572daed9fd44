"""One analysis, one netCDF-4/HDF5 file, readable without blockstruct.

``/model`` holds the structure, ``/cases/<name>`` a result and ``/cases/<name>/history`` its iterations. The contract
is ``schemas/analysis-2.json``, checked on writing and on reading, and embedded in every file.

Five files, each built on those before: ``netcdf`` (Datasets as groups), ``layout`` (model and results as Datasets),
``file`` (seal, schema, reading), ``run_folder`` (lock, writing, the journal of a run), ``archive`` (many files).
"""

from blockstruct.storage.archive import Archive
from blockstruct.storage.file import check_file, open_analysis, patterns
from blockstruct.storage.run_folder import (
    Checkpoint,
    claim,
    is_unfinished,
    planned_analysis,
    save_analysis,
    save_image,
    tidy,
)

__all__ = ["Archive", "Checkpoint", "check_file", "claim", "is_unfinished", "open_analysis", "patterns"]
__all__ += ["planned_analysis", "save_analysis", "save_image", "tidy"]
