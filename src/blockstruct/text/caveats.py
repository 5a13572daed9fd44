"""What must be known before a number is used."""

from collections.abc import Sequence

import numpy as np

from blockstruct.limit import Outcome
from blockstruct.text.answer import Answer
from blockstruct.vocabulary import Status, listed

_JAMMED = (
    "With dilatancy the joints carry any multiple of the variable load, so this load factor has no upper bound. "
    "It depends on how firmly the blocks are jammed (self-stress), which the model does not determine."
)
_JAMMED_SUPPORT = (
    "With dilatancy the joints resist this motion of the supports with any force, so this reaction has no lower bound. "
    "It depends on how firmly the blocks are jammed (self-stress), which the model does not determine."
)
_NOT_PROVEN = (
    "The proof that {what} holds for joints that dilate by their friction angle. For joints that do not, the "
    "procedure found that its {answer} grows without limit."
)
_JAMMED_PART = (
    "With dilatancy no {answer} moves {names}. Without it, self-stress decides whether they move first, which the "
    "model does not determine. Other procedures may find another {answer}."
)
_NOT_SETTLED = (
    "The {answer} had not settled when the procedure ended: it is certified as a collapse state, and another state at "
    "another {answer} may come first. Do not rely on it."
)
_RAISED = (
    "With crushing the procedure ended at a higher {answer} than without: at another collapse state, to which crushing "
    "has led it. The {answer} is the one without crushing, of which there is no history here. Do not rely on the state."
)
_STANDS_IN = "The loading path did not finish, and this {answer} is from another procedure."
#: Names of blocks that a sentence lists.
_LISTED = 3


def caveats(
    outcome: Outcome,
    answer: Answer,
    *,
    bound: float,
    is_searched: bool,
    jammed: Sequence[str],
) -> tuple[str, ...]:
    """Return what must be known before the number of a non-associative case is used, as sentences.

    Parameters
    ----------
    outcome, answer
        How the case ended, and the name of its number.
    bound
        Load factor with associative flow.
    is_searched
        Whether a procedure without dilatancy found a load factor on its way.
    jammed
        Blocks whose share of the variable load depends on self-stress.
    """
    found, unbounded = list[str](), bound == np.inf
    if outcome.status is Status.CONVERGED:
        if np.isfinite(outcome.without_crushing):
            found.append(_RAISED)
        elif not outcome.settled:
            found.append(_NOT_SETTLED)
        if outcome.stands_in:
            found.append(_STANDS_IN)
        if unbounded:
            found.append(_JAMMED_SUPPORT if answer.is_reaction else _JAMMED)
    if unbounded and is_searched and outcome.status is Status.UNBOUNDED:
        found.append(_NOT_PROVEN)
    if jammed and not unbounded:
        found.append(_JAMMED_PART)
    what = "the supports never move that way" if answer.is_reaction else "no load causes collapse"
    return tuple(t.format(answer=answer.name, what=what, names=listed(jammed, _LISTED)) for t in found)
