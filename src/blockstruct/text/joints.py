"""Notes on torsion and crushing at the joints of a case."""

from collections.abc import Sequence

import numpy as np

from blockstruct.text.answer import Answer
from blockstruct.text.note import Note, NoteCode, Severity
from blockstruct.text.numbers import FEW
from blockstruct.vocabulary import counted, listed

#: Change of a number, relative to the number, below which it has no note.
EFFECT = 0.01
_REMEDIES = {
    NoteCode.CORNER_TORSION: 'torsion="uniform pressure" in the joints',
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


def effect_note(code: NoteCode, load_factor: float, changed: float, answer: Answer) -> Note | None:
    """Return the note on the change of a number by the remedy of a note; None below one percent.

    Parameters
    ----------
    code
        ``corner_torsion`` or ``biaxial_crushing``.
    load_factor, changed
        Load factor of the case, and load factor that its remedy gives.
    answer
        Name of the number.
    """
    change = abs(changed) / abs(load_factor) - 1 if load_factor else np.inf * abs(changed)
    if not abs(change) >= EFFECT:
        return None
    side = "more" if change > 0 else "less"
    text = f"With {_REMEDIES[code]} the {answer.name} is {answer.text(changed)}, {abs(change):.0%} {side}."
    return Note(code, Severity.CAUTION, text)


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
