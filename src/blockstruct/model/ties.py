"""Ties between two anchors: bars, and strips over joints."""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from attrs import field, frozen

from blockstruct.errors import ModelError
from blockstruct.geometry.tolerances import NEGLIGIBLE
from blockstruct.model.block import Block
from blockstruct.model.fields import (
    LEFT_OUT,
    Anchor,
    ModelObject,
    anchor,
    has_name,
    label,
    named_arguments,
    optional_scalar,
    positive,
    scalar,
)
from blockstruct.model.tie_segments import TieSegment, check_anchors
from blockstruct.units import quantity_text

#: Distance of the end of a strip from the faces of its block, relative to the block: rounding and thickness.
_OFF_FACE = 1e-2

_LENGTH, _FORCE, _AREA, _STRESS = ({"dimension": d} for d in ("length", "force", "area", "stress"))


@frozen(repr=False, field_transformer=named_arguments)
class Tie(ModelObject):
    """A bar between two anchors that pulls two blocks together, without compression and with unlimited yield.

    Parameters
    ----------
    name
        Unique among the ties of a model.
    start, end : quantity, length, three components; or (str, quantity)
        The point of the anchor in global coordinates, or the name of a block and the point. Without a name, the model
        finds the block at the point. The force acts along the line between the two points.
    yield_force : quantity, force
        Of the bar.
    area, strength : quantities, area and stress
        Cross-section and yield strength of the bar, instead of the yield force.
    punching_force, bond_force : quantity, force
        Further limits of the force: strength of the masonry under an anchor plate, and bond of a grouted end.
    prestress : quantity, force
        Least force of the bar, which acts with the dead load.
    elongation_limit : quantity, length
        Elongation at which the bar breaks, at least a millionth of its length. A result states when a mechanism
        reaches it.

    Attributes
    ----------
    start, end : (str, three floats)
        Block, and point in m.
    yield_force, area, strength, punching_force, bond_force, elongation_limit : float or None
        N, m², Pa and m; None if not given.
    prestress : float
        N.

    Raises
    ------
    ModelError
        If a strength is missing or not above zero, the prestress reaches the capacity, or the elongation limit is too
        small for the length.
    UnitError, DimensionError
        If a value has no unit, or its unit has another dimension.

    Examples
    --------
    >>> Tie("tie", start=("b1", "[0, 0, 3] m"), end=("b9", "[4, 0, 3] m"), yield_force="40 kN")
    Tie('tie', start=('b1', (0, 0, 3) m), end=('b9', (4, 0, 3) m), yield_force=40 kN)
    """

    computed: ClassVar = {"capacity": "force"}

    name: str = field(validator=has_name)
    start: Anchor = field(converter=anchor, metadata=_LENGTH)
    end: Anchor = field(converter=anchor, metadata=_LENGTH)
    yield_force: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata=_FORCE
    )
    area: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata=_AREA
    )
    strength: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata=_STRESS
    )
    punching_force: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata=_FORCE
    )
    bond_force: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata=_FORCE
    )
    prestress: float = field(
        default=LEFT_OUT, kw_only=True, converter=optional_scalar, metadata={"dimension": "force", "absent": 0.0}
    )
    elongation_limit: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata=_LENGTH
    )

    def __attrs_post_init__(self) -> None:
        who = label(self)
        if (self.yield_force is None) == (self.area is None) or (self.area is None) != (self.strength is None):
            msg = f"{who}: give either yield_force, or area and strength"
            raise ModelError(msg)
        if not 0 <= self.prestress < self.capacity:
            msg = (
                f"{who}: prestress {quantity_text(self.prestress, 'force')}; give zero or more, and less than the "
                f"capacity of {quantity_text(self.capacity, 'force')} ({self.governing})"
            )
            raise ModelError(msg)
        least = NEGLIGIBLE * math.dist(self.start[1], self.end[1])
        if self.elongation_limit is not None and self.elongation_limit < least:
            msg = (
                f"{who}: elongation_limit {self.elongation_limit:.6g} m; give {least:.3g} m or more, a millionth of "
                "the length, or leave the tie out"
            )
            raise ModelError(msg)

    @property
    def limits(self) -> dict[str, float]:
        """Given limits of the force, N: ``yield``, ``punching``, ``bond``."""
        bar = self.yield_force if self.area is None or self.strength is None else self.area * self.strength
        limits = {"yield": bar, "punching": self.punching_force, "bond": self.bond_force}
        return {name: value for name, value in limits.items() if value is not None}

    @property
    def capacity(self) -> float:
        """Least of the limits, N."""
        return min(self.limits.values())

    @property
    def governing(self) -> str:
        """Name of the least limit."""
        return min(self.limits, key=self.limits.__getitem__)

    def segments(self, blocks: Mapping[str, Block]) -> tuple[TieSegment, ...]:
        """Return the one segment of the tie, if it fits the blocks of a model.

        Raises
        ------
        UnknownNameError
            If a block is unknown.
        ModelError
            If the ends are at one block, at one point or at two supports, or an anchor is outside its block.
        """
        check_anchors(label(self), self.start, self.end, blocks)
        return (_segment(self, self.prestress),)


@frozen(repr=False, field_transformer=named_arguments)
class Strip(ModelObject):
    """A strip of fabric glued to two blocks over a joint: it pulls them together at their surface.

    Parameters
    ----------
    name
        Unique among the ties of a model.
    start, end : quantity, length, three components; or (str, quantity)
        A point of the centre line of the strip on the surface of a block, in global coordinates, or the name of the
        block and the point. A strip spans one joint. Model a strip over several joints as one strip per joint.
    area, strength : quantities, area and stress
        Cross-section A_f of the strip, and its design strength f_fd, reduced for debonding.
    elongation_limit : quantity, length
        Elongation at which the strip breaks. A result states when a mechanism reaches it.

    Attributes
    ----------
    start, end : (str, three floats)
        Block, and point in m.
    area, strength : float
        m² and Pa.
    elongation_limit : float or None
        m.

    Raises
    ------
    ModelError
        If an area or a strength is not above zero.
    UnitError, DimensionError
        If a value has no unit, or its unit has another dimension.
    """

    computed: ClassVar = {"capacity": "force"}

    name: str = field(validator=has_name)
    start: Anchor = field(converter=anchor, metadata=_LENGTH)
    end: Anchor = field(converter=anchor, metadata=_LENGTH)
    area: float = field(kw_only=True, converter=scalar, validator=positive, metadata=_AREA)
    strength: float = field(kw_only=True, converter=scalar, validator=positive, metadata=_STRESS)
    elongation_limit: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata=_LENGTH
    )

    @property
    def capacity(self) -> float:
        """``A_f f_fd``, N."""
        return self.area * self.strength

    @property
    def governing(self) -> str:
        """Name of the limit."""
        return "strength"

    def segments(self, blocks: Mapping[str, Block]) -> tuple[TieSegment, ...]:
        """Return the one segment of the strip, if it fits the blocks of a model, as :meth:`Tie.segments` does.

        Raises
        ------
        UnknownNameError
            If a block is unknown.
        ModelError
            As for a tie, or if an end is inside its block.
        """
        check_anchors(label(self), self.start, self.end, blocks)
        for block, point in (self.start, self.end):
            shape = blocks[block].shape
            corners = shape.vertices[[face[0] for face in shape.faces]]
            depth = float(np.abs(np.einsum("ij,ij->i", shape.normals, point - corners)).min())
            if depth > _OFF_FACE * float(np.ptp(shape.vertices, axis=0).max()):
                msg = (
                    f"{label(self)}: its end at block {block!r} is {point} m, {depth:.3g} m inside the block; "
                    "give a point on its surface"
                )
                raise ModelError(msg)
        return (_segment(self, 0.0),)


def _segment(tie: Tie | Strip, prestress: float) -> TieSegment:
    (first, a), (second, b) = tie.start, tie.end
    length = math.dist(a, b)
    x, y, z = ((q - p) / length for p, q in zip(a, b, strict=True))
    return TieSegment(
        tie=tie.name,
        name=tie.name,
        blocks=(first, second),
        start=a,
        end=b,
        direction=(x, y, z),
        capacity=tie.capacity,
        governing=tie.governing,
        prestress=prestress,
        elongation_limit=math.inf if tie.elongation_limit is None else tie.elongation_limit,
    )
