"""Import of blocks from meshes, drawings, Rhino files, building models and COMPAS, with a report of every repair."""

from blockstruct.imports.assembly import read_assembly
from blockstruct.imports.drawing import read_drawing
from blockstruct.imports.ifc import read_ifc
from blockstruct.imports.mesh import read_mesh, write_obj
from blockstruct.imports.rhino import read_rhino
from blockstruct.imports.several import read_files
from blockstruct.imports.source import Imported, ImportReport, Repair

__all__ = ["read_files", "read_assembly", "read_drawing", "read_ifc", "read_mesh", "read_rhino", "write_obj"]
__all__ += ["ImportReport", "Imported", "Repair"]
