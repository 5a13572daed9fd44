"""Notes that qualify the load factor of a case."""

from collections.abc import Sequence

import numpy as np

from blockstruct.limit import Outcome
from blockstruct.text.answer import Answer
from blockstruct.text.joints import EFFECT
from blockstruct.text.note import Note, NoteCode, Severity
from blockstruct.text.numbers import FEW
from blockstruct.vocabulary import Status, listed

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
    "With crushing the procedure ended at a higher {answer}, in another collapse state, which is the one shown. The "
    "{answer} given is without crushing: an upper limit, as no strength raises it. Check the mechanism by hand, too, "
    "with its pressed edge (bs.assess.overturning), and rely on the lower number."
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
