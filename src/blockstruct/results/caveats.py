"""What one must know before using a number, as sentences."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from blockstruct.model import Case, SettlementCase
from blockstruct.results.crushing_cells import lost_lever
from blockstruct.results.utilisation import beyond_rectangle
from blockstruct.vocabulary import NO_STATE, OF_CURVE, OF_HUNG, OF_JAMMED, Status, counted, listed

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

_HUNG = (
    "Friction between supports may hold blocks under the dead load, or may not ({names}): in some states of "
    "self-stress, which the model does not determine, they fall before the variable load acts. This {answer} is one of "
    "states in which they are held."
)
_JAMMED_PART = (
    "With dilatancy no {answer} moves some blocks ({names}). Without it, how firmly they are jammed (self-stress), "
    "which the model does not determine, decides whether they move before the others: other schedules may find a lower "
    "{answer}, or a higher one."
)
_NO_STATE = (
    "The loading path found no state under dead load, which it begins with, and is not followed: this {answer} is that "
    "of the iteration that took its place."
)

#: Eccentricity, in multiples of that of the effective rectangle, from which it is told, and joints that are named.
_BEYOND, _LISTED = 1.005, 3


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


def self_stressed(hung: Sequence[str], jammed: Sequence[str]) -> str:
    """End of the message of a case that names blocks on which self-stress decides; empty without any."""
    parts = ((OF_HUNG, hung), (OF_JAMMED, jammed))
    return "".join(what + listed(names, _LISTED) for what, names in parts if names)


def told_by_message(message: str, answer: str, *, unbounded: bool) -> tuple[str, ...]:
    """Warnings of what the message of a case without dilatancy says.

    Parameters
    ----------
    message
        Of the case.
    answer
        What its number is called.
    unbounded
        Whether another warning tells already that blocks are jammed.
    """
    before, _, jammed = message.partition(OF_CURVE)[0].partition(OF_JAMMED)
    hung = before.partition(OF_HUNG)[2]
    found = [(_HUNG, hung), (_JAMMED_PART, "" if unbounded else jammed), (_NO_STATE, NO_STATE in message)]
    return tuple(text.format(names=names, answer=answer) for text, names in found if names)


def cell_words(history: xr.Dataset, *, is_reaction: bool = False) -> str:
    """How many joints crush in cells, and by how much that is on the safe side, as sentences; empty without any.

    Parameters
    ----------
    history
        Of a case: its contact points are corners or the centroids of cells.
    is_reaction
        Whether its answer is the least reaction of a support, which what joints do not take makes larger.
    """
    strength, joint = history["cell_strength"].to_numpy(), history["compressive_strength"].to_numpy()
    index, is_cell = history["interface_of_contact_point"].to_numpy(), np.isfinite(strength)
    counts = np.bincount(index[is_cell], minlength=len(joint))
    in_cells, crushing = np.flatnonzero(counts), int(np.isfinite(joint).sum())
    if not len(in_cells):
        return ""
    lost = max(lost_lever(history, int(j)) for j in in_cells)
    least, most = counts[in_cells].min(), counts[in_cells].max()
    each = counted(most, "cell") if least == most else f"{least} to {most} cells"
    others = "; the others by exact conditions" if len(in_cells) < crushing else ""
    side = "They leave too much of a reaction, and too narrow a range" if is_reaction else "Cells are on the safe side"
    return (
        f"Joints that crush in cells: {len(in_cells)} of {crushing}, {each} each{others}. {side}: a block that "
        f"rocks on them turns about the middle of their outer row, and loses up to about {100 * lost:.0f} % of its "
        "lever, less with more crushing_cells."
    )


def beyond_rectangle_words(history: xr.Dataset, *, is_reaction: bool = False) -> str:
    """Which joints bear more by their edges than by their effective rectangle, as sentences; empty if none do.

    Parameters
    ----------
    history
        Of a case whose rectangles crush by their edges, which bound bending about each axis by itself.
    is_reaction
        Whether its answer is the least reaction of a support, which what joints bear makes smaller.
    """
    found = beyond_rectangle(history)
    beyond = found[found > _BEYOND].sort_values(ascending=False)
    if beyond.empty:
        return ""
    names = listed([str(name) for name in beyond.index], _LISTED)
    side = "too small" if is_reaction else "too large"
    return (
        f"Joints bent about both axes ({names}) bear their force at up to {beyond.iloc[0]:.3g} times the eccentricity "
        "that their effective rectangle takes, as uniaxial interaction bounds bending about each axis by itself: the "
        f"number may be {side}, by no more than that where one joint decides. "
        'Run the case with crushing="conic" and crushing_interaction="biaxial".'
    )
