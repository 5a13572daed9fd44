"""Frozen, unit-aware model objects: the only place where pint quantities become floats.

>>> from blockstruct.units import Q_
>>> stone = Material("tuff", unit_weight=Q_(12, "kN/m^3"))
>>> block = Block.box("b", origin=Q_([0, 0, 0], "m"), size=Q_([0.4, 0.2, 0.1], "m"), material=stone)
>>> round(block.weight, 6)
96.0
"""

from blockstruct.model.block import Block
from blockstruct.model.cases import Case, LimitCase, MovingCase, Point, Pushover, RecordCase, SettlementCase, has_curve
from blockstruct.model.checks import check_unrepeated, checked_name, checked_text, checked_tuple
from blockstruct.model.compass import direction_cases, direction_of
from blockstruct.model.detection_report import (
    Detection,
    DetectionReport,
    DetectionTolerances,
    FoundContact,
    lies_between,
)
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

__all__ = [
    "JOINT_PROPERTIES",
    "LOAD_KINDS",
    "kind_of",
    # materials
    "STANDARD_GRAVITY",
    "JointMaterial",
    "Material",
    # bodies and contacts
    "Block",
    "Interface",
    "Model",
    # how interfaces were found
    "Detection",
    "DetectionReport",
    "DetectionTolerances",
    "FoundContact",
    "lies_between",
    # loads
    "AreaLoad",
    "BodyForce",
    "FaceLoad",
    "FillLoad",
    "LineLoad",
    "Load",
    "LoadPattern",
    "Moment",
    "PointLoad",
    "SelfWeight",
    # ties
    "TIE_KINDS",
    "TIE_QUANTITIES",
    "AnyTie",
    "BondedBar",
    "Strip",
    "Tie",
    "TieSegment",
    "given_quantities",
    "tie_kind_of",
    "tie_segments",
    "Weight",
    "WeightLoad",
    # cases
    "Case",
    "LimitCase",
    "MovingCase",
    "Point",
    "Pushover",
    "RecordCase",
    "SettlementCase",
    "has_curve",
    # input
    "check_unrepeated",
    "checked_name",
    "checked_text",
    "checked_tuple",
    "direction_cases",
    "direction_of",
]
