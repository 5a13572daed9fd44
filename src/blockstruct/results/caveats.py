"""What one must know before using a number, as sentences."""

from blockstruct.model import Case, SettlementCase
from blockstruct.vocabulary import Status

_JAMMED = (
    "With dilatancy the joints carry any multiple of the variable load, so nothing bounds this load factor from above: "
    "it depends on how firmly the blocks are jammed (self-stress), which the model does not determine; other schedules "
    "may find multiples of it, or a fraction."
)
_JAMMED_SUPPORT = (
    "With dilatancy the joints resist this motion of the supports with any force, so nothing bounds this reaction from "
    "below: it depends on how firmly the blocks are jammed (self-stress), which the model does not determine."
)
_MOTION_NOT_PROVEN = (
    "That the supports never move that way is proven for joints that dilate by their friction angle; for joints that "
    "do not, it is what the iteration found: the force against the motion grew without limit."
)
_NOT_PROVEN = (
    "That no load causes collapse is proven for joints that dilate by their friction angle; for joints that do not, it "
    "is what the iteration found: its load factor grew without limit."
)


def unbounded_with_dilatancy(case: Case, status: Status, *, searched: bool) -> tuple[str, ...]:
    """Warnings of a case without dilatancy whose associative program is unbounded.

    Parameters
    ----------
    case, status
        The case, and how it ended.
    searched
        Whether an iteration without dilatancy found a load factor.
    """
    settles = isinstance(case, SettlementCase)
    if status is Status.CONVERGED:
        return (_JAMMED_SUPPORT if settles else _JAMMED,)
    return (_MOTION_NOT_PROVEN if settles else _NOT_PROVEN,) if status is Status.UNBOUNDED and searched else ()
