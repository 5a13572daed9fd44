"""What an answer means where friction with dilatancy would jam the blocks: no program bounds it."""

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
_NOT_PROVEN = (
    "That no load causes collapse is proven for joints that dilate by their friction angle; for joints that do not, it "
    "is what the iteration found: its load factor grew without limit."
)
_MOTION_NOT_PROVEN = (
    "That the supports never move that way is proven for joints that dilate by their friction angle; for joints that "
    "do not, it is what the iteration found: the force against the motion grew without limit."
)


def jamming_words(status: Status, settles: bool, searched: bool) -> tuple[str, ...]:
    """What to know before using the answer of a case whose associative program is unbounded, as sentences.

    Parameters
    ----------
    status
        How the case without dilatancy ended.
    settles
        Whether its supports give way, so that its answer is a reaction.
    searched
        Whether load factors without dilatancy were found on the way.
    """
    if status is Status.CONVERGED:
        return (_JAMMED_SUPPORT if settles else _JAMMED,)
    if status is Status.UNBOUNDED and searched:
        return (_MOTION_NOT_PROVEN if settles else _NOT_PROVEN,)
    return ()
