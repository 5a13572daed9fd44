"""Makes models: interface detection, walls in courses, model documents.

>>> from blockstruct.model import JointMaterial, Material, Model
>>> tuff, dry = Material("tuff", "12 kN/m^3"), JointMaterial("dry", 0.65)
>>> blocks = courses([[1, 1], [0.5, 1, 0.5]], unit_length="0.4 m", unit_height="0.2 m", depth="0.1 m", material=tuff)
>>> found = detect_interfaces(blocks, joint_material=dry)
>>> model = Model("wall", blocks, found.interfaces)
>>> len(model.blocks), len(model.interfaces)
(6, 9)
"""

from blockstruct.builders.arch import arch, arch_on_piers, barrel_vault
from blockstruct.builders.assembly import read_assembly
from blockstruct.builders.column import column, stack, tilted
from blockstruct.builders.courses import courses
from blockstruct.builders.cross_vault import cross_vault
from blockstruct.builders.detection import Detection, detect_interfaces
from blockstruct.builders.document import Document, read_document
from blockstruct.builders.document_writer import write_document, write_draft
from blockstruct.builders.dome import dome
from blockstruct.builders.drawing import read_drawing
from blockstruct.builders.import_report import Imported, ImportReport, Repair
from blockstruct.builders.mesh import read_mesh
from blockstruct.builders.obj import write_obj
from blockstruct.builders.openings import Opening
from blockstruct.builders.pier_spandrel import pier_spandrel
from blockstruct.builders.wall import Sidewall, wall

__all__ = [
    # interfaces
    "Detection",
    "detect_interfaces",
    # structures
    "Opening",
    "Sidewall",
    "arch",
    "arch_on_piers",
    "barrel_vault",
    "column",
    "courses",
    "cross_vault",
    "dome",
    "pier_spandrel",
    "stack",
    "tilted",
    "wall",
    # files of geometry
    "ImportReport",
    "Imported",
    "Repair",
    "read_assembly",
    "read_drawing",
    "read_mesh",
    "write_obj",
    # documents
    "Document",
    "read_document",
    "write_document",
    "write_draft",
]
