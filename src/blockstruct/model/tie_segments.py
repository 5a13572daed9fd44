"""Segments of ties with one force, and the check of anchors."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from attrs import field, frozen

from blockstruct.errors import ModelError, UnknownNameError
from blockstruct.geometry.tolerances import NEGLIGIBLE
from blockstruct.model.block import Block
from blockstruct.model.checks import check_at_block
from blockstruct.model.fields import Anchor, ModelObject, Vector, changed, is_anchor, label, named_arguments
from blockstruct.units import to_quantity
from blockstruct.vocabulary import listed


@frozen(repr=False, field_transformer=named_arguments)
class TieSegment(ModelObject):
    """A part of a tie with one force, between two blocks.

    Attributes
    ----------
    tie, name : str
        Name of the tie, and of this segment.
    blocks : (str, str)
        Blocks that it pulls together.
    start, end : three floats
        Its end in each block, on the line of its force, m.
    direction : three floats
        Unit vector from start to end.
    capacity : float
        Largest force, N.
    governing : str
        Limit that sets the largest force: ``yield``, ``strength``, ``punching`` or ``bond``.
    bond : (float, float)
        Force that bond transfers to each of the two blocks along their length, N; infinite at an anchor.
    prestress : float
        Least force, N.
    elongation_limit : float
        m; infinite by default.
    """

    tie: str
    name: str
    blocks: tuple[str, str]
    start: Vector = field(metadata={"dimension": "length"})
    end: Vector = field(metadata={"dimension": "length"})
    direction: Vector = field(metadata={"dimension": "dimensionless"})
    capacity: float = field(metadata={"dimension": "force"})
    governing: str
    bond: tuple[float, float] = field(default=(math.inf, math.inf), metadata={"dimension": "force"})
    prestress: float = field(default=0.0, metadata={"dimension": "force"})
    elongation_limit: float = field(default=math.inf, metadata={"dimension": "length"})


def anchored(tie: Any, block_at: Callable[[Any], Block]) -> Any:
    """Return a tie with the names of the blocks at ends that are given by a point alone.

    Parameters
    ----------
    tie
    block_at
        Returns the block at a point: :meth:`Model.block_at`.
    """
    ends = {end: getattr(tie, end) for end in ("start", "end") if is_anchor(getattr(tie, end))}
    try:
        unnamed = {end: point for end, (block, point) in ends.items() if not block}
        found = {end: (block_at(to_quantity(point, "length")).name, point) for end, point in unnamed.items()}
    except ModelError as error:
        error.add_note(f"at an end of {label(tie)}")
        raise
    return changed(tie, **found) if found else tie


def check_anchors(who: str, start: Anchor, end: Anchor, blocks: Mapping[str, Block]) -> None:
    """Refuse ends between which a tie joins nothing.

    Raises
    ------
    UnknownNameError
        If a block is unknown.
    ModelError
        If the ends are at one block, at one point or at two supports, or an anchor is outside its block.
    """
    for block, point in (start, end):
        if block not in blocks:
            msg = f"{who}: its anchor is at block {block!r}, which is not in the model; it has {listed(list(blocks))}"
            raise UnknownNameError(msg)
        remedy = "give a point of the block, such as the point under an anchor plate"
        check_at_block(f"{who}: its anchor", point, block, blocks[block].shape.vertices, remedy)
    (first, a), (second, b) = start, end
    if first == second:
        msg = f"{who}: both ends are at block {first!r}; name two blocks"
        raise ModelError(msg)
    if blocks[first].fixed and blocks[second].fixed:
        msg = f"{who}: both ends are at supports, {first!r} and {second!r}; anchor one of them to a free block"
        raise ModelError(msg)
    size = max(float(np.ptp(blocks[name].shape.vertices, axis=0).max()) for name in (first, second))
    if math.dist(a, b) <= NEGLIGIBLE * size:
        msg = f"{who}: both ends are at {a} m, so the tie has no direction; give two points"
        raise ModelError(msg)
