"""Notes: sentences about a result, each with a code and a severity; those on the number of a case and its joints."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from blockstruct.limit import Outcome
from blockstruct.text.numbers import Answer
from blockstruct.vocabulary import FEW, Status, counted, listed


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
    RUN_UNSETTLED = "run_unsettled"
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
    change : float or None
        Relative change of the number by the remedy that the note names, if it is known.
    """

    code: NoteCode
    severity: Severity
    text: str
    change: float | None = field(default=None, compare=False)

    def __str__(self) -> str:
        return self.text


#: Change of a number, relative to the number, below which it has no note.
EFFECT = 0.01
#: Fact of an outcome with the number that the remedy of a note gives.
EFFECTS = {
    NoteCode.CORNER_TORSION: "uniform_torsion",
    NoteCode.CORNER_TORSION_POSSIBLE: "uniform_torsion",
    NoteCode.ELLIPSOID_TORSION: "lowered_friction",
    NoteCode.ELLIPSOID_TORSION_POSSIBLE: "lowered_friction",
    NoteCode.BIAXIAL_CRUSHING: "biaxial_crushing",
    NoteCode.JAMMED: "other_procedure",
    NoteCode.JAMMED_PART: "other_procedure",
}
#: Remedies of notes whose effect is measured, as words after "with".
REMEDIES = {
    NoteCode.CORNER_TORSION: 'torsion="uniform pressure" in the joints',
    NoteCode.ELLIPSOID_TORSION: "the friction of each joint divided by its excess of torsion",
    NoteCode.BIAXIAL_CRUSHING: "crushing about both axes together (biaxial)",
}


def torsion_note(joints: Sequence[str], times: float, share: float | None, answer: str, *, at_corners: bool) -> Note:
    """Return the note on joints that carry more torsion and shear than a uniformly pressed joint.

    Parameters
    ----------
    joints
        Names, the most loaded first.
    times
        Multiple of the torsion and shear that uniform pressure carries.
    share
        Share of the answer that the excess accounts for; None if the joints hardly move in the mechanism.
    answer
        ``"load factor"`` or ``"reaction"``.
    at_corners
        Whether the joints limit torsion at their contact points alone, and not by an ellipsoid.
    """
    names, most = listed(joints, FEW), "" if share is not None else "up to "
    if at_corners:
        code = NoteCode.CORNER_TORSION
        excess = f"Friction at contact points carries {most}{times:.3g} times the torsion and shear"
        remedy = 'Joint materials with torsion="uniform pressure" limit it, but hardly in narrow joints.'
    else:
        code = NoteCode.ELLIPSOID_TORSION
        excess = f'The ellipsoid of torsion="uniform pressure" allows {most}{times:.3g} times the torsion and shear'
        remedy = "Lower the friction coefficient of these joints by this factor to see how much it matters."
    text = f"{excess} of a uniformly pressed joint ({names})."
    if share is not None:
        return Note(code, Severity.CAUTION, f"{text} About {share:.0%} of the {answer} comes from it. {remedy}")
    text += f" The {answer} may depend on it: these joints hardly move in the mechanism, so their share is unknown."
    return Note(NoteCode(f"{code}_possible"), Severity.CAUTION, f"{text} {remedy}")


def effect_note(
    code: NoteCode, load_factor: float, changed: float, answer: Answer, *, is_estimate: bool = False
) -> Note | None:
    """Return the note on the change of a number by the remedy of a note; None below one percent.

    Parameters
    ----------
    code
        ``corner_torsion``, ``ellipsoid_torsion`` or ``biaxial_crushing``.
    load_factor, changed
        Load factor of the case, and load factor that its remedy gives.
    answer
        Name of the number.
    is_estimate
        Whether the first steps of a loading path give ``changed``.
    """
    change = abs(changed) / abs(load_factor) - 1 if load_factor else np.inf * abs(changed)
    if not abs(change) >= EFFECT:
        return None
    side = "more" if change > 0 else "less"
    about, source = ("about ", ", estimated by the first steps of its loading path") if is_estimate else ("", "")
    number = answer.text(changed, digits=2 if is_estimate else 4)
    text = f"With {REMEDIES[code]} the {answer.name} is {about}{number}, {abs(change):.0%} {side}{source}."
    return Note(code, Severity.CAUTION, text, float(change))


def biaxial_note(joints: Sequence[str], times: float, *, is_reaction: bool) -> Note:
    """Return the note on joints that bear a larger eccentricity than their effective rectangle.

    Parameters
    ----------
    joints
        Names, the largest eccentricity first.
    times
        Largest eccentricity, in multiples of the limit of the effective rectangle.
    is_reaction
        Whether the answer is a reaction, which stronger joints make smaller.
    """
    side = "too small" if is_reaction else "too large"
    text = (
        f"Joints bent about both axes ({listed(joints, FEW)}) bear up to {times:.3g} times the eccentricity of "
        "their effective rectangle, because this case limits crushing about each axis separately. "
        f"The number may be {side}, by at most this factor if one joint governs. "
        'Run the case with crushing="conic" and crushing_interaction="biaxial".'
    )
    return Note(NoteCode.BIAXIAL_CRUSHING, Severity.CAUTION, text)


def cells_note(in_cells: int, crushing: int, cells: tuple[int, int], lost: float, *, is_reaction: bool) -> Note:
    """Return the note on joints that crush in cells.

    Parameters
    ----------
    in_cells, crushing
        Joints that crush in cells, and joints with a compressive strength.
    cells
        Smallest and largest number of cells of a joint.
    lost
        Largest share of the lever of a rocking block that cells lose.
    is_reaction
        Whether the answer is a reaction, which weaker joints make larger.
    """
    least, most = cells
    each = counted(most, "cell") if least == most else f"{least} to {most} cells"
    others = ", the others by exact conditions" if in_cells < crushing else ""
    side = "The reaction is too large and its range too narrow" if is_reaction else "Cells are on the safe side"
    text = (
        f"{in_cells} of {counted(crushing, 'joint')} with a compressive strength crush in {each} each{others}. "
        f"{side}: a block rocks about the middle of the outer row and loses up to about {lost:.0%} of its lever. "
        "More crushing_cells reduce this."
    )
    return Note(NoteCode.CRUSHING_CELLS, Severity.INFO, text)


_JAMMED = (
    "With dilatancy the joints carry any multiple of the variable load, so this load factor has no upper bound. "
    "It depends on how firmly the blocks are jammed (self-stress), which the model does not determine.{effect}"
)
_JAMMED_SUPPORT = (
    "With dilatancy the joints resist this motion of the supports with any force, so this reaction has no lower bound. "
    "It depends on how firmly the blocks are jammed (self-stress), which the model does not determine.{effect}"
)
_NOT_PROVEN = (
    "The proof that {claim} holds for joints that dilate by their friction angle. For joints that do not, the "
    "procedure found that its {answer} grows without limit."
)
_JAMMED_PART = (
    "With dilatancy no {answer} moves {names}. Without it, self-stress decides whether they move first, which the "
    "model does not determine.{effect}"
)
_NOT_SETTLED = (
    "The {answer} had not settled when the procedure ended: it is certified as a collapse state, and another state at "
    "another {answer} may come first. Do not rely on it."
)
_RAISED = (
    "With crushing the procedure ended at a higher {answer}, in another collapse state. The {answer}, the forces and "
    "the mechanism are without crushing. Check this mechanism by hand, too, with its pressed edge "
    "(bs.assess.overturning), and rely on the lower number."
)
_STANDS_IN = "The loading path did not finish, and this {answer} is from another procedure."


def caveats(
    outcome: Outcome,
    answer: Answer,
    *,
    bound: float,
    is_searched: bool,
    jammed: Sequence[str],
) -> tuple[Note, ...]:
    """Return the warnings that belong to the number of a non-associative case.

    Parameters
    ----------
    outcome, answer
        How the case ended, and the name of its number.
    bound
        Load factor with associative flow.
    is_searched
        Whether a procedure without dilatancy found load factors before it ended.
    jammed
        Blocks whose share of the variable load depends on self-stress.
    """
    notes, unbounded = list[tuple[NoteCode, str]](), bound == np.inf
    if outcome.status is Status.CONVERGED:
        if np.isfinite(outcome.without_crushing):
            notes.append((NoteCode.RAISED_BY_CRUSHING, _RAISED))
        elif not outcome.settled:
            notes.append((NoteCode.NOT_SETTLED, _NOT_SETTLED))
        if outcome.stands_in:
            notes.append((NoteCode.STANDS_IN, _STANDS_IN))
        if unbounded:
            notes.append((NoteCode.JAMMED, _JAMMED_SUPPORT if answer.is_reaction else _JAMMED))
    if unbounded and is_searched and outcome.status is Status.UNBOUNDED:
        notes.append((NoteCode.NOT_PROVEN, _NOT_PROVEN))
    change = outcome.other_procedure / outcome.load_factor - 1 if outcome.load_factor else np.nan
    # Jammed without an upper bound, two procedures may agree by chance.
    if jammed and not unbounded and not abs(change) < EFFECT:
        notes.append((NoteCode.JAMMED_PART, _JAMMED_PART))
    claim = "the supports never move that way" if answer.is_reaction else "no load causes collapse"
    effect = "" if unbounded else f" Other procedures may find another {answer.name}."
    if np.isfinite(change):
        side = "more" if change > 0 else "less"
        apart = f"{abs(change):.0%} {side}" if abs(change) >= EFFECT else "the same"
        effect = f" Another procedure finds {answer.text(outcome.other_procedure)}, {apart}."
    words = {"answer": answer.name, "claim": claim, "names": listed(jammed, FEW), "effect": effect}
    return tuple(Note(code, Severity.WARNING, text.format(**words)) for code, text in notes)
