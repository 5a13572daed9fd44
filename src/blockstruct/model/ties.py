"""Ties: bars between two anchors, strips over joints, bars bonded along their length, and the table of these kinds."""

import math
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, ClassVar, get_args

import numpy as np
from attrs import field, frozen

from blockstruct.arrays import NEGLIGIBLE, Array
from blockstruct.errors import ModelError, UnknownNameError
from blockstruct.geometry.triangles import stretches_inside
from blockstruct.model.block import Block
from blockstruct.model.fields import (
    AREA,
    FORCE,
    LEFT_OUT,
    LENGTH,
    NUMBER,
    STRESS,
    Anchor,
    ModelObject,
    Vector,
    anchor,
    changed,
    check_at_block,
    dimensions,
    has_name,
    is_anchor,
    label,
    named_arguments,
    optional_positive,
    optional_scalar,
    positive,
    scalar,
    snake_case,
    vector,
)
from blockstruct.model.fit import NEAR
from blockstruct.units import quantity_text, to_quantity
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
    start: Vector = field(metadata=LENGTH)
    end: Vector = field(metadata=LENGTH)
    direction: Vector = field(metadata=NUMBER)
    capacity: float = field(metadata=FORCE)
    governing: str
    bond: tuple[float, float] = field(default=(math.inf, math.inf), metadata=FORCE)
    prestress: float = field(default=0.0, metadata=FORCE)
    elongation_limit: float = field(default=math.inf, metadata=LENGTH)


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
        named = {end: (block_at(to_quantity(point, "length")).name, point) for end, point in unnamed.items()}
    except ModelError as error:
        error.add_note(f"at an end of {label(tie)}")
        raise
    return changed(tie, **named) if named else tie


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


@frozen(repr=False, field_transformer=named_arguments)
class Tie(ModelObject):
    """A bar between two anchors that pulls two blocks together; it bears no compression, and yields at its capacity.

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
    start: Anchor = field(converter=anchor, metadata=LENGTH)
    end: Anchor = field(converter=anchor, metadata=LENGTH)
    yield_force: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=FORCE)
    area: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=AREA)
    strength: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=STRESS)
    punching_force: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=FORCE)
    bond_force: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=FORCE)
    prestress: float = field(
        default=LEFT_OUT, kw_only=True, converter=optional_scalar, metadata={"dimension": "force", "absent": 0.0}
    )
    elongation_limit: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=LENGTH)

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
    governing: ClassVar = "strength"

    name: str = field(validator=has_name)
    start: Anchor = field(converter=anchor, metadata=LENGTH)
    end: Anchor = field(converter=anchor, metadata=LENGTH)
    area: float = field(kw_only=True, converter=scalar, validator=positive, metadata=AREA)
    strength: float = field(kw_only=True, converter=scalar, validator=positive, metadata=STRESS)
    elongation_limit: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=LENGTH)

    @property
    def capacity(self) -> float:
        """``A_f f_fd``, N."""
        return self.area * self.strength

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
            if depth > NEAR * float(np.ptp(shape.vertices, axis=0).max()):
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


@frozen(repr=False, field_transformer=named_arguments)
class BondedBar(ModelObject):
    """A straight bar, bonded along its length to all blocks that it crosses.

    It has one force in each segment from one block to the next. From segment to segment the force changes by at most
    the bond in the block between them, ``π d τ_b ℓ``, with the length ℓ inside the block. The force of the first and
    the last segment is at most the bond of the end in its block.

    Parameters
    ----------
    name
        Unique among the ties of a model.
    start, end : quantity, length, three components
        Ends of the bar, in global coordinates, inside or outside the blocks. The bar is bonded to a block where its
        whole cross-section is inside. It is not bonded where it runs in a joint, or where its axis is within half the
        diameter of a joint or a free surface.
    diameter : quantity, length
        Diameter d of the bonded surface, and of the cross-section for ``strength``.
    bond_strength : quantity, stress
        τ_b.
    yield_force : quantity, force
        Of the bar.
    strength : quantity, stress
        Yield strength of the full cross-section, instead of the yield force.
    elongation_limit : quantity, length
        Elongation of a segment at which the bar breaks. A result states when a mechanism reaches it.

    Attributes
    ----------
    start, end : three floats
        m.
    diameter, bond_strength : float
        m and Pa.
    yield_force, strength, elongation_limit : float or None
        N, Pa and m; None if not given.

    Raises
    ------
    ModelError
        If a strength is missing or not above zero, or both ends are at one point.
    UnitError, DimensionError
        If a value has no unit, or its unit has another dimension.
    """

    computed: ClassVar = {"capacity": "force"}
    governing: ClassVar = "yield"

    name: str = field(validator=has_name)
    start: Vector = field(converter=vector, metadata=LENGTH)
    end: Vector = field(converter=vector, metadata=LENGTH)
    diameter: float = field(kw_only=True, converter=scalar, validator=positive, metadata=LENGTH)
    bond_strength: float = field(kw_only=True, converter=scalar, validator=positive, metadata=STRESS)
    yield_force: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=FORCE)
    strength: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=STRESS)
    elongation_limit: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=LENGTH)

    def __attrs_post_init__(self) -> None:
        if (self.yield_force is None) == (self.strength is None):
            msg = f"{label(self)}: give either yield_force or strength"
            raise ModelError(msg)
        if self.start == self.end:
            msg = f"{label(self)}: both ends are at {self.start} m; give two points"
            raise ModelError(msg)

    @property
    def capacity(self) -> float:
        """Yield force of the bar, N."""
        if self.yield_force is not None:
            return self.yield_force
        return math.pi * self.diameter**2 / 4 * (self.strength or 0.0)

    def segments(self, blocks: Mapping[str, Block]) -> tuple[TieSegment, ...]:
        """Return the segments of the bar from one block to the next.

        Raises
        ------
        ModelError
            If the bar crosses fewer than two blocks, or supports only.
        """
        start, end = np.array(self.start), np.array(self.end)
        d = (end - start) / np.linalg.norm(end - start)
        inside = sorted(
            (stretch, name)
            for name, b in blocks.items()
            for stretch in stretches_inside(b.shape, start, end, self.diameter / 2)
        )
        names = list(dict.fromkeys(name for _, name in inside))
        if len(inside) < 2 or all(blocks[name].fixed for name in names):
            through = listed([f"{name!r}" for name in names]) or "no block at all"
            msg = (
                f"bonded bar {self.name!r} from {self.start} to {self.end} m crosses {through}, so it joins "
                "nothing; give ends between which it is inside two blocks or more, one of them free, with its axis at "
                f"least {self.diameter / 2:g} m from their faces, half its diameter"
            )
            raise ModelError(msg)
        bond = [math.pi * self.diameter * self.bond_strength * (b - a) for (a, b), _ in inside]
        last = len(inside) - 1
        ends = [min(bond[0] if k == 0 else math.inf, bond[-1] if k + 1 == last else math.inf) for k in range(last)]
        # Two segments meet in the middle of the block between them.
        at = [inside[0][0][0], *((a + b) / 2 for (a, b), _ in inside[1:-1]), inside[-1][0][1]]
        return tuple(
            TieSegment(
                tie=self.name,
                name=f"{self.name} [{inside[k][1]}|{inside[k + 1][1]}]",
                blocks=(inside[k][1], inside[k + 1][1]),
                start=_point(start + at[k] * d),
                end=_point(start + at[k + 1] * d),
                direction=_point(d),
                capacity=min(self.capacity, ends[k]),
                governing=self.governing if self.capacity <= ends[k] else "bond",
                bond=(bond[k] if k > 0 else math.inf, bond[k + 1] if k + 1 < last else math.inf),
                elongation_limit=math.inf if self.elongation_limit is None else self.elongation_limit,
            )
            for k in range(last)
        )


def _point(values: Array) -> Vector:
    x, y, z = values.tolist()
    return x, y, z


AnyTie = Tie | Strip | BondedBar


def _quantities(kind: Any) -> dict[str, str]:
    return {name: dimension for name, dimension in dimensions(kind).items() if name not in ("start", "end")}


#: Class of each kind of tie, by its name in documents and files.
TIE_KINDS: Mapping[str, Callable[..., AnyTie]] = MappingProxyType(
    {snake_case(kind.__name__): kind for kind in get_args(AnyTie)}
)
#: Dimension of each quantity of ties, a key of :data:`blockstruct.units.SI_UNITS`.
TIE_QUANTITIES: Mapping[str, str] = MappingProxyType(
    {name: dimension for kind in get_args(AnyTie) for name, dimension in _quantities(kind).items()}
)


def tie_kind_of(tie: AnyTie) -> str:
    """Return the kind of a tie, a key of :data:`TIE_KINDS`."""
    return snake_case(type(tie).__name__)


def given_quantities(tie: AnyTie) -> dict[str, float]:
    """Return the SI quantities that define a tie, by name."""
    values = {name: getattr(tie, name) for name in _quantities(type(tie))}
    # A prestress of zero is the same as no prestress.
    return {name: value for name, value in values.items() if value}


def tie_segments(ties: Iterable[AnyTie], blocks: Iterable[Block]) -> list[TieSegment]:
    """Return the segments of ties, tie by tie; each segment has one force.

    Raises
    ------
    UnknownNameError, ModelError
        If a tie does not fit the blocks.
    """
    by_name = {b.name: b for b in blocks}
    return [segment for tie in ties for segment in tie.segments(by_name)]
