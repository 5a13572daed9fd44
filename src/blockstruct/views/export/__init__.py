"""Export to other programs: GLB, OBJ, STL, COMPAS, Excel and CSV.

ParaView files are written by :func:`blockstruct.views.paraview.write_paraview`. Analysis files are netCDF already.
"""

from blockstruct.views.export.assembly import write_assembly
from blockstruct.views.export.motion import write_glb, write_moved
from blockstruct.views.export.tables import tables, write_tables

__all__ = ["tables", "write_assembly", "write_glb", "write_moved", "write_tables"]
