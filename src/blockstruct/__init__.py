"""Collapse load of masonry structures: rigid-block limit analysis in 3D, with units and a full history.

Define a structure:

>>> import blockstruct as bs
>>> from blockstruct import Q_
>>> tuff = bs.Material("tuff", unit_weight=Q_(12, "kN/m^3"))
>>> lime = bs.JointMaterial("lime mortar", friction_coefficient=0.65)
>>> rows = [[1, 1], [0.5, 1, 0.5], [1, 1], [0.5, 1, 0.5]]
>>> blocks = bs.courses(
...     rows, unit_length=Q_(40, "cm"), unit_height=Q_(17.5, "cm"), depth=Q_(10, "cm"), material=tuff
... )
>>> found = bs.detect_interfaces(blocks, joint_material=lime)
>>> model = bs.Model("small wall", blocks, found)

Find its collapse load:

>>> dead = bs.LoadPattern("dead", [bs.SelfWeight()])
>>> push = bs.LoadPattern("push +y", [bs.BodyForce(direction=(0, 1, 0))])
>>> case = bs.LimitCase("out of plane", dead=dead, variable=push, flow="nonassociative")
>>> analysis = bs.AnalysisManager(model).run([case])
>>> result = analysis["out of plane"]
>>> print(result.status, round(result.load_factor, 4))
converged 0.1429

Look at every iteration:

>>> sorted(result.history.sizes)
['axis', 'block', 'component', 'contact_point', 'interface', 'interface_corner', 'iteration']
>>> result.certificate.holds
True
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from blockstruct import errors
from blockstruct.units import Q_, ureg
from blockstruct.vocabulary import (
    ContactState,
    Flow,
    JointOrientation,
    PathEnd,
    Procedure,
    Reason,
    SolverStatus,
    Stage,
    Status,
)

if TYPE_CHECKING:
    from blockstruct import assess, contacts, imports, library, results, structures, studies
    from blockstruct.analysis import (
        AnalysisManager,
        least_tie_force,
        log_to,
        print_lines,
        recover,
        reproduce,
        run,
        ties,
    )
    from blockstruct.contacts import Detection, detect_interfaces
    from blockstruct.documents import Document, read_document, write_document, write_draft
    from blockstruct.limit import SCHEDULES, Certificate, FictitiousSchedule, Numerics, ProcedureSettings
    from blockstruct.model import (
        AreaLoad,
        Block,
        BodyForce,
        FaceLoad,
        FillLoad,
        Interface,
        JointMaterial,
        LimitCase,
        LineLoad,
        LoadPattern,
        Material,
        Model,
        Moment,
        PointLoad,
        Pushover,
        SelfWeight,
        SettlementCase,
        Tie,
        Weight,
    )
    from blockstruct.results import Analysis, CaseResult, Spread, compare
    from blockstruct.storage import Archive, check_file, open_analysis, save_analysis
    from blockstruct.structures import (
        Opening,
        Sidewall,
        arch,
        arch_on_piers,
        barrel_vault,
        column,
        courses,
        cross_vault,
        dome,
        pier_spandrel,
        stack,
        tilted,
        wall,
    )
    from blockstruct.studies import study
    from blockstruct.studies.by_direction import directions

__version__ = "0.1.0"

__all__ = [
    # namespaces
    "assess",
    "contacts",
    "errors",
    "imports",
    "library",
    "results",
    "structures",
    "studies",
    "ties",
    # units
    "Q_",
    "ureg",
    # model
    "AreaLoad",
    "Block",
    "BodyForce",
    "FaceLoad",
    "FillLoad",
    "Interface",
    "JointMaterial",
    "JointOrientation",
    "LimitCase",
    "LineLoad",
    "LoadPattern",
    "Material",
    "Model",
    "Moment",
    "PointLoad",
    "Pushover",
    "SelfWeight",
    "SettlementCase",
    "Tie",
    "Weight",
    # interfaces and documents
    "Detection",
    "Document",
    "detect_interfaces",
    "read_document",
    "write_document",
    "write_draft",
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
    # analysis
    "AnalysisManager",
    "Flow",
    "SCHEDULES",
    "FictitiousSchedule",
    "Numerics",
    "ProcedureSettings",
    "least_tie_force",
    "log_to",
    "print_lines",
    "reproduce",
    "directions",
    "run",
    "study",
    # results
    "Analysis",
    "CaseResult",
    "Spread",
    "Certificate",
    "ContactState",
    "PathEnd",
    "Procedure",
    "Reason",
    "SolverStatus",
    "Stage",
    "Status",
    "compare",
    # storage
    "Archive",
    "check_file",
    "open_analysis",
    "recover",
    "save_analysis",
]

#: What is loaded when it is first asked for, to keep the import light: rooms, and the names that come from them.
_ROOMS_LATER = {
    "assess": (),
    "analysis": ("AnalysisManager", "least_tie_force", "log_to", "print_lines", "recover", "reproduce", "run", "ties"),
    "contacts": ("Detection", "detect_interfaces"),
    "documents": ("Document", "read_document", "write_document", "write_draft"),
    "imports": (),
    "library": (),
    "limit": ("SCHEDULES", "Certificate", "FictitiousSchedule", "Numerics", "ProcedureSettings"),
    "model": (
        *("AreaLoad", "Block", "BodyForce", "FaceLoad", "FillLoad", "Interface", "JointMaterial", "LimitCase"),
        *("LineLoad", "LoadPattern", "Material", "Model", "Moment", "PointLoad", "Pushover", "SelfWeight"),
        *("SettlementCase", "Tie", "Weight"),
    ),
    "results": ("Analysis", "CaseResult", "Spread", "compare"),
    "storage": ("Archive", "check_file", "open_analysis", "save_analysis"),
    "structures": (
        *("Opening", "Sidewall", "arch", "arch_on_piers", "barrel_vault", "column", "courses", "cross_vault", "dome"),
        *("pier_spandrel", "stack", "tilted", "wall"),
    ),
    "studies": ("directions", "study"),
}
_LATER = {name: f"blockstruct.{room}" for room, names in _ROOMS_LATER.items() for name in names}


def __getattr__(name: str) -> Any:
    if name in _ROOMS_LATER:
        return import_module(f"blockstruct.{name}")
    if name in _LATER:
        return getattr(import_module(_LATER[name]), name)
    msg = f"module {__name__!r} has no attribute {name!r}"
    raise AttributeError(msg)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
