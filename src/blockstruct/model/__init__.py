"""Frozen, unit-aware model objects: the only place where pint quantities become floats.

>>> from blockstruct.units import Q_
>>> stone = Material("tuff", unit_weight=Q_(12, "kN/m^3"))
>>> block = Block.box("b", origin=Q_([0, 0, 0], "m"), size=Q_([0.4, 0.2, 0.1], "m"), material=stone)
>>> round(block.weight, 6)
96.0
"""

from blockstruct.model.block import Block
from blockstruct.model.cases import Case, LimitCase, MovingCase, Point, Pushover, RecordCase, SettlementCase, has_curve
from blockstruct.model.compass import direction_cases, direction_of
from blockstruct.model.detection_report import (
    Detection,
    DetectionReport,
    DetectionTolerances,
    FoundContact,
    lies_between,
)
from blockstruct.model.fields import check_unrepeated, checked_name, checked_text, checked_tuple
from blockstruct.model.interface import Interface
from blockstruct.model.loads import (
    LOAD_KINDS,
    AreaLoad,
    BodyForce,
    FaceLoad,
    FillLoad,
    LineLoad,
    Load,
    LoadPattern,
    Moment,
    PointLoad,
    SelfWeight,
    Weight,
    WeightLoad,
    kind_of,
)
from blockstruct.model.materials import JOINT_PROPERTIES, STANDARD_GRAVITY, JointMaterial, Material
from blockstruct.model.model import Model
from blockstruct.model.ties import (
    TIE_KINDS,
    TIE_QUANTITIES,
    AnyTie,
    BondedBar,
    Strip,
    Tie,
    TieSegment,
    given_quantities,
    tie_kind_of,
    tie_segments,
)

__all__ = ["STANDARD_GRAVITY", "JOINT_PROPERTIES", "JointMaterial", "Material", "Block", "Interface", "Model"]
__all__ += ["Detection", "DetectionReport", "DetectionTolerances", "FoundContact", "lies_between"]
__all__ += ["LOAD_KINDS", "Load", "LoadPattern", "SelfWeight", "BodyForce", "PointLoad", "FaceLoad", "Moment"]
__all__ += ["kind_of", "Weight", "LineLoad", "AreaLoad", "FillLoad", "WeightLoad"]
__all__ += ["TIE_KINDS", "TIE_QUANTITIES", "AnyTie", "BondedBar", "Strip", "Tie", "TieSegment"]
__all__ += ["given_quantities", "tie_kind_of", "tie_segments"]
__all__ += ["Case", "LimitCase", "MovingCase", "Point", "Pushover", "RecordCase", "SettlementCase", "has_curve"]
__all__ += ["check_unrepeated", "checked_name", "checked_text", "checked_tuple", "direction_cases", "direction_of"]
