"""Notes: sentences about a result, each with a code and a severity."""

from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    """How much a note matters to whoever uses the number."""

    #: Read it before using the number.
    WARNING = "warning"
    #: The number may be off, or depends on a choice that the note names.
    CAUTION = "caution"
    #: An explanation that does not change the number.
    INFO = "info"


class NoteCode(StrEnum):
    """Identity of a note, independent of its words."""

    # The load factor of a case.
    NOT_SETTLED = "not_settled"
    RAISED_BY_CRUSHING = "raised_by_crushing"
    STANDS_IN = "stands_in"
    JAMMED = "jammed"
    NOT_PROVEN = "not_proven"
    JAMMED_PART = "jammed_part"
    # Its joints and loads.
    CORNER_TORSION = "corner_torsion"
    CORNER_TORSION_POSSIBLE = "corner_torsion_possible"
    ELLIPSOID_TORSION = "ellipsoid_torsion"
    ELLIPSOID_TORSION_POSSIBLE = "ellipsoid_torsion_possible"
    BIAXIAL_CRUSHING = "biaxial_crushing"
    CRUSHING_CELLS = "crushing_cells"
    MASSES = "masses"
    # The check of its mechanism.
    ANCHORAGES = "anchorages"
    ASSOCIATIVE_BOUND = "associative_bound"
    COEFFICIENTS = "coefficients"
    CONTROL_POINT = "control_point"
    CURVE_DOUBT = "curve_doubt"
    CURVE_END = "curve_end"
    DIRECTION_WITHOUT = "direction_without"
    EDGE_IS_HIGH = "edge_is_high"
    EDGE_IS_LONG = "edge_is_long"
    EDGE_OVERHANGS = "edge_overhangs"
    FLOOR_BELOW_GROUND = "floor_below_ground"
    FLOOR_ON_GROUND = "floor_on_ground"
    GROUND_AT_HEIGHT = "ground_at_height"
    HAND_IS_HIGHER = "hand_is_higher"
    HAND_IS_LOWER = "hand_is_lower"
    MASSES_DIFFER = "masses_differ"
    OTHER_MOTION = "other_motion"
    OUT_OF_PLANE = "out_of_plane"
    OVERTURNS_ALONE = "overturns_alone"
    RANGE = "range"
    ROUNDED_CORNERS = "rounded_corners"
    SEPARATE_MECHANISMS = "separate_mechanisms"
    SMALL_MOTIONS = "small_motions"
    STATE_LEFT_OUT = "state_left_out"
    STATE_MISSED = "state_missed"
    UNIT_SIZE = "unit_size"


@dataclass(frozen=True, slots=True)
class Note:
    """A sentence about a result.

    Attributes
    ----------
    code : NoteCode
    severity : Severity
    text : str
        One to three sentences, each with a full stop.
    """

    code: NoteCode
    severity: Severity
    text: str

    def __str__(self) -> str:
        return self.text
