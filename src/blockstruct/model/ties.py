"""Ties between two anchors: bars, and strips over joints."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from blockstruct.errors import ModelError
from blockstruct.model.block import Block
from blockstruct.model.checks import checked_name
from blockstruct.model.tie_segments import (
    Anchor,
    TieSegment,
    anchor,
    check_anchors,
    positive_quantities,
    set_fields,
)
from blockstruct.units import QuantityLike, VectorLike, si

#: Distance of the end of a strip from the faces of its block, relative to the block: rounding and thickness.
_OFF_FACE = 1e-2
#: Least elongation limit of a tie, relative to its length: a pushover has a state just before it and one just behind,
#: by differences of lengths.
_LEAST_LIMIT = 1e-6


@dataclass(frozen=True, slots=True, init=False)
class Tie:
    """A bar between two anchors, which pulls two blocks together: no compression, and yield without limit.

    Parameters
    ----------
    name
        Unique among the ties of a model.
    start, end : (str, quantity, length, three components)
        Name of a block, and where the bar is anchored to it, in global coordinates. The force acts along the line
        between the two points.
    yield_force : quantity, force
        Of the bar.
    area, strength : quantities, area and stress
        Instead of the yield force: its cross-section and yield strength.
    punching_force, bond_force : quantity, force
        Further limits of the force: that of the masonry under an anchor plate, and that of the bond of a grouted end.
    prestress : quantity, force
        With which the bar is put in; its force never falls below. It acts with the dead load.
    elongation_limit : quantity, length
        Beyond which the bar breaks: a result tells when a mechanism reaches it. At least a millionth of its length.

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
        If there is no strength, it is not above zero, or the prestress reaches it; or if the elongation limit is
        lost in the length.
    UnitError, DimensionError
        If a bare number is given where a unit is due, or a quantity of another dimension.

    Examples
    --------
    >>> tie = Tie("tie", start=("b1", "[0, 0, 3] m"), end=("b9", "[4, 0, 3] m"), yield_force="40 kN")
    >>> tie.capacity, tie.governing
    (40000.0, 'yield')
    """

    name: str
    start: Anchor
    end: Anchor
    yield_force: float | None
    area: float | None
    strength: float | None
    punching_force: float | None
    bond_force: float | None
    prestress: float
    elongation_limit: float | None

    def __init__(
        self,
        name: str,
        start: tuple[str, VectorLike],
        end: tuple[str, VectorLike],
        *,
        yield_force: QuantityLike | None = None,
        area: QuantityLike | None = None,
        strength: QuantityLike | None = None,
        punching_force: QuantityLike | None = None,
        bond_force: QuantityLike | None = None,
        prestress: QuantityLike = "0 N",
        elongation_limit: QuantityLike | None = None,
    ) -> None:
        who = f"tie {checked_name(name, 'tie')!r}"
        given = {
            "yield_force": yield_force,
            "area": area,
            "strength": strength,
            "punching_force": punching_force,
            "bond_force": bond_force,
            "elongation_limit": elongation_limit,
        }
        values = positive_quantities(given, who)
        if (yield_force is None) == (area is None) or (area is None) != (strength is None):
            msg = f"{who}: give either yield_force, or area and strength"
            raise ModelError(msg)
        least = si(prestress, "force", f"{who}: prestress")
        set_fields(self, name=name, start=anchor(start, f"{who}: start"), end=anchor(end, f"{who}: end"))
        set_fields(self, **values, prestress=least)
        if not 0 <= least < self.capacity:
            msg = (
                f"{who}: prestress {least:.6g} N; give zero or more, and less than its capacity of "
                f"{self.capacity:.6g} N ({self.governing})"
            )
            raise ModelError(msg)
        limit, length = self.elongation_limit, math.dist(self.start[1], self.end[1])
        if limit is not None and limit < _LEAST_LIMIT * length:
            msg = (
                f"{who}: elongation limit {limit:.6g} m; give {_LEAST_LIMIT * length:.3g} m or more, a millionth of "
                "its length, or leave the tie out"
            )
            raise ModelError(msg)

    @property
    def limits(self) -> dict[str, float]:
        """Limits of the force that were given, N: ``yield``, ``punching``, ``bond``."""
        area, strength = self.area, self.strength
        of_bar = self.yield_force if area is None or strength is None else area * strength
        given = {"yield": of_bar, "punching": self.punching_force, "bond": self.bond_force}
        return {name: value for name, value in given.items() if value is not None}

    @property
    def capacity(self) -> float:
        """Least of the limits, N."""
        return min(self.limits.values())

    @property
    def governing(self) -> str:
        """Name of the least limit."""
        return min(self.limits, key=self.limits.__getitem__)

    def segments(self, blocks: Mapping[str, Block]) -> tuple[TieSegment, ...]:
        """The one stretch of the tie, if it fits the blocks of a model.

        Raises
        ------
        UnknownNameError
            If a block is not among them.
        ModelError
            If the ends are at one block, at one point or at two supports, or an anchor lies outside its block.
        """
        check_anchors(f"tie {self.name!r}", self.start, self.end, blocks)
        return (_segment(self, self.prestress),)


@dataclass(frozen=True, slots=True, init=False)
class Strip:
    """A strip of fabric over a joint, glued to the surface of two blocks: it pulls them together there.

    Parameters
    ----------
    name
        Unique among the ties of a model.
    start, end : (str, quantity, length, three components)
        Name of a block, and a point of the centre line of the strip on its surface, in global coordinates. One strip
        spans one joint: of a strip over several, each joint has its own.
    area, strength : quantities, area and stress
        Cross-section A_f of the strip, and its design strength f_fd, with debonding where that is less.
    elongation_limit : quantity, length
        Beyond which the strip breaks: a result tells when a mechanism reaches it.

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
        If a bare number is given where a unit is due, or a quantity of another dimension.
    """

    name: str
    start: Anchor
    end: Anchor
    area: float
    strength: float
    elongation_limit: float | None

    def __init__(
        self,
        name: str,
        start: tuple[str, VectorLike],
        end: tuple[str, VectorLike],
        *,
        area: QuantityLike,
        strength: QuantityLike,
        elongation_limit: QuantityLike | None = None,
    ) -> None:
        who = f"strip {checked_name(name, 'strip')!r}"
        given = {"area": area, "strength": strength, "elongation_limit": elongation_limit}
        set_fields(self, name=name, start=anchor(start, f"{who}: start"), end=anchor(end, f"{who}: end"))
        set_fields(self, **positive_quantities(given, who))

    @property
    def capacity(self) -> float:
        """``A_f f_fd``, N."""
        return self.area * self.strength

    @property
    def governing(self) -> str:
        """Name of the limit."""
        return "strength"

    def segments(self, blocks: Mapping[str, Block]) -> tuple[TieSegment, ...]:
        """The one stretch of the strip, if it fits the blocks of a model: as of :meth:`Tie.segments`.

        Raises
        ------
        UnknownNameError
            If a block is not among them.
        ModelError
            As of a tie, or an end inside its block.
        """
        check_anchors(f"strip {self.name!r}", self.start, self.end, blocks)
        for block, point in (self.start, self.end):
            shape = blocks[block].shape
            corners = shape.vertices[[face[0] for face in shape.faces]]
            depth = float(np.abs(np.einsum("ij,ij->i", shape.normals, point - corners)).min())
            if depth > _OFF_FACE * float(np.ptp(shape.vertices, axis=0).max()):
                msg = (
                    f"strip {self.name!r}: its end at block {block!r} is {point} m, {depth:.3g} m inside the block; "
                    "give a point on its surface"
                )
                raise ModelError(msg)
        return (_segment(self, 0.0),)


def _segment(tie: Tie | Strip, prestress: float) -> TieSegment:
    (one, a), (other, b) = tie.start, tie.end
    length = math.dist(a, b)
    x, y, z = ((q - p) / length for p, q in zip(a, b, strict=True))
    return TieSegment(
        tie=tie.name,
        name=tie.name,
        blocks=(one, other),
        start=a,
        end=b,
        direction=(x, y, z),
        capacity=tie.capacity,
        governing=tie.governing,
        prestress=prestress,
        elongation_limit=math.inf if tie.elongation_limit is None else tie.elongation_limit,
    )
