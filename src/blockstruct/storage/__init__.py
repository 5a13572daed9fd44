"""One analysis, one netCDF-4/HDF5 file, readable without blockstruct.

``/model`` holds the structure, ``/cases/<name>`` a result and ``/cases/<name>/history`` its iterations. The contract
is ``schemas/analysis-2.json``, checked on writing and on reading, and embedded in every file.
"""

from blockstruct.storage.archive import Archive
from blockstruct.storage.checkpoint import Checkpoint
from blockstruct.storage.claim import claim
from blockstruct.storage.reader import check_file, open_analysis, planned_analysis
from blockstruct.storage.unfinished import is_unfinished, tidy
from blockstruct.storage.writer import patterns, save_analysis, save_image

__all__ = [
    "Archive",
    "Checkpoint",
    "check_file",
    "claim",
    "is_unfinished",
    "open_analysis",
    "patterns",
    "planned_analysis",
    "save_analysis",
    "save_image",
    "tidy",
]
