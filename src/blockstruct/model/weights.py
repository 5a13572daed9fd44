"""Loads that are weights: what a structure carries, with its mass."""

from dataclasses import dataclass
from typing import Any

from blockstruct.errors import ModelError, shown
from blockstruct.model.checks import checked_name
from blockstruct.units import QuantityLike, VectorLike, si, si_vector, symbol

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, init=False)
class Weight:
    """A concentrated weight that a block carries: a truss, a statue, a bell.

    It pulls along −z, and its mass takes part in a mass-proportional push (:class:`BodyForce`) of the cases whose dead
    load it belongs to.

    Parameters
    ----------
    block
        Name of the block that carries it.
    point : quantity, length, three components
        Its centre of mass, above, in or below the block: in plan within it. It moves with the block.
    weight : quantity, force
        Above zero.
    mass_share : float
        Share of the weight whose mass takes part in a push: 1 by default, 0 for none.

    Attributes
    ----------
    point, weight
        m and N.

    Examples
    --------
    >>> Weight("3.1", ["0.2 m", "0.1 m", "1.5 m"], "12 kN").weight
    12000.0
    """

    block: str
    point: Vector
    weight: float
    mass_share: float

    def __init__(self, block: str, point: VectorLike, weight: QuantityLike, mass_share: Any = 1.0) -> None:
        who = f"Weight on {checked_name(block, 'block')!r}"
        object.__setattr__(self, "block", block)
        object.__setattr__(self, "point", si_vector(point, "length", f"{who}: point"))
        object.__setattr__(self, "weight", _above_zero(weight, "force", f"{who}: weight"))
        object.__setattr__(self, "mass_share", _share(mass_share, who))


@dataclass(frozen=True, slots=True, init=False)
class LineLoad:
    """A weight along a line, on a block or on all blocks under it: the edge of a floor, a row of rafters.

    Its mass takes part in a mass-proportional push as that of a :class:`Weight`, where the weight acts.

    Parameters
    ----------
    weight_per_length : quantity, force/length
        Above zero.
    start, end : quantity, length, three components
        Ends of the line. Without a block it is level, and lies on upper faces of blocks at its height. Where it runs
        between two blocks, each has its half; along an edge, the block beside it bears it all. Heights and edges count
        to a thousandth of a block.
    block
        Name of the one block that carries it all; the line lies within its extent.
    spanning
        Whether parts of the line without a block below are borne by the others, in proportion of their lengths.
        Otherwise such parts are refused.
    mass_share : float
        Share of the weight whose mass takes part in a push, from 0 to 1.

    Attributes
    ----------
    weight_per_length
        N/m.
    start, end
        m.
    """

    weight_per_length: float
    start: Vector
    end: Vector
    block: str | None
    spanning: bool
    mass_share: float

    def __init__(
        self,
        weight_per_length: QuantityLike,
        start: VectorLike,
        end: VectorLike,
        *,
        block: str | None = None,
        spanning: bool = False,
        mass_share: Any = 1.0,
    ) -> None:
        who = f"LineLoad{_on(block)}"
        value = _above_zero(weight_per_length, "force/length", f"{who}: weight_per_length")
        first, last = (si_vector(v, "length", f"{who}: {what}") for v, what in ((start, "start"), (end, "end")))
        if first[:2] == last[:2]:
            msg = (
                f"{who}: start {first} m and end {last} m are one point in plan; give a line, or a Weight at the point"
            )
            raise ModelError(msg)
        if block is None and abs(first[2] - last[2]) > 1e-9 * max(abs(first[2]), abs(last[2])):
            msg = (
                f"{who}: start at z = {first[2]:.6g} m, end at {last[2]:.6g} m; give a level line, or name the block "
                "that carries an inclined one"
            )
            raise ModelError(msg)
        values = (value, first, last, block, _flag(spanning, f"{who}: spanning"), _share(mass_share, who))
        for name, field in zip(self.__slots__, values, strict=True):
            object.__setattr__(self, name, field)


@dataclass(frozen=True, slots=True, init=False)
class AreaLoad:
    """A weight per area in plan, on a block or on all blocks under a rectangle at a level: a floor, a roof, snow.

    Its mass takes part in a mass-proportional push as that of a :class:`Weight`, where the weight acts.

    Parameters
    ----------
    weight_per_area : quantity, stress
        Per area in plan, above zero.
    start, end : quantity, length, three components
        Opposite corners of the rectangle, along x and y, both at its level: it lies on upper faces of blocks at this
        height, to a thousandth of a block. What stands on these faces does not keep the load off them: a floor bears
        in a pocket of the wall. Left out, the load acts on all of the upper faces of ``block`` that touch no other.
    block
        Name of the one block that carries it; without one, all that have such faces.
    spanning
        Whether the blocks also bear the load on those parts of the rectangle that have no block below, all of it in
        proportion of their areas: a floor that spans from wall to wall. Otherwise such parts are refused.
    mass_share : float
        Share of the weight whose mass takes part in a push, from 0 to 1.

    Attributes
    ----------
    weight_per_area
        Pa.
    start, end
        m, or None.
    """

    weight_per_area: float
    start: Vector | None
    end: Vector | None
    block: str | None
    spanning: bool
    mass_share: float

    def __init__(
        self,
        weight_per_area: QuantityLike,
        start: VectorLike | None = None,
        end: VectorLike | None = None,
        *,
        block: str | None = None,
        spanning: bool = False,
        mass_share: Any = 1.0,
    ) -> None:
        who = f"AreaLoad{_on(block)}"
        value = _above_zero(weight_per_area, "stress", f"{who}: weight_per_area")
        if (start is None) != (end is None) or (start is None and block is None):
            msg = (
                f"{who}: give start and end, opposite corners of a level rectangle, or the block that carries the load"
            )
            raise ModelError(msg)
        first, last = (
            None if v is None else si_vector(v, "length", f"{who}: {what}")
            for v, what in ((start, "start"), (end, "end"))
        )
        if first is not None and last is not None:
            _check_rectangle(first, last, who)
            if abs(first[2] - last[2]) > 1e-9 * max(abs(first[2]), abs(last[2])):
                msg = (
                    f"{who}: start at z = {first[2]:.6g} m, end at {last[2]:.6g} m; give both at the level of the load"
                )
                raise ModelError(msg)
        spans = _flag(spanning, f"{who}: spanning")
        if spans and first is None:
            msg = f"{who}: spanning, but without a rectangle there is nothing to span; give start and end"
            raise ModelError(msg)
        values = (value, first, last, block, spans, _share(mass_share, who))
        for name, field in zip(self.__slots__, values, strict=True):
            object.__setattr__(self, name, field)


@dataclass(frozen=True, slots=True, init=False)
class FillLoad:
    """Fill on a vault: the weight of all that is between the blocks and a level, and its pressure on their faces.

    Each face that looks upwards into the box from ``start`` to ``end`` carries the fill right above it, up to the upper
    side of the box. The mass of the fill takes part in a mass-proportional push as that of a :class:`Weight`, with its
    centre of mass where the fill is, as if it were part of the block below.

    Parameters
    ----------
    unit_weight : quantity, force/volume
        Above zero.
    start, end : quantity, length, three components
        Opposite corners of a box; its upper side is the level of the fill, and faces below its lower side carry none.
    block
        Name of the only block that is to carry fill; all by default.
    lateral_coefficient : float
        K of the horizontal pressure K γ h on the faces that carry fill, h below the level; 0 (none) by default. Faces
        that are vertical carry no fill: their pressure is a :class:`FaceLoad` with a unit weight.
    mass_share : float
        Share of the weight whose mass takes part in a push, from 0 to 1.

    Attributes
    ----------
    unit_weight
        N/m³.
    start, end
        m.
    """

    unit_weight: float
    start: Vector
    end: Vector
    block: str | None
    lateral_coefficient: float
    mass_share: float

    def __init__(
        self,
        unit_weight: QuantityLike,
        start: VectorLike,
        end: VectorLike,
        *,
        block: str | None = None,
        lateral_coefficient: Any = 0.0,
        mass_share: Any = 1.0,
    ) -> None:
        who = f"FillLoad{_on(block)}"
        value = _above_zero(unit_weight, "force/volume", f"{who}: unit_weight")
        first, last = (si_vector(v, "length", f"{who}: {what}") for v, what in ((start, "start"), (end, "end")))
        _check_rectangle(first, last, who)
        if first[2] == last[2]:
            msg = f"{who}: start and end are both at z = {first[2]:.6g} m; give opposite corners of a box"
            raise ModelError(msg)
        lateral = si(lateral_coefficient, "dimensionless", f"{who}: lateral_coefficient")
        if lateral < 0:
            msg = f"{who}: lateral_coefficient {lateral:.6g}; give zero or more"
            raise ModelError(msg)
        for name, field in zip(
            self.__slots__, (value, first, last, block, lateral, _share(mass_share, who)), strict=True
        ):
            object.__setattr__(self, name, field)

    @property
    def level(self) -> float:
        """Upper side of the fill, m."""
        return max(self.start[2], self.end[2])


#: Loads with a mass.
WeightLoad = Weight | LineLoad | AreaLoad | FillLoad


def _on(block: str | None) -> str:
    return "" if block is None else f" on {checked_name(block, 'block')!r}"


def _above_zero(value: Any, dimension: str, what: str) -> float:
    found = si(value, dimension, what)
    if found <= 0:
        msg = (
            f"{what} {found:.6g} {symbol(dimension)}; weights act downwards, give more than zero (for a lifting force, "
            "a PointLoad or a FaceLoad)"
        )
        raise ModelError(msg)
    return found


def _share(value: Any, who: str) -> float:
    found = si(value, "dimensionless", f"{who}: mass_share")
    if not 0 <= found <= 1:
        msg = f"{who}: mass_share {found:.6g}; give from 0 (its mass is not pushed) to 1 (all of it is)"
        raise ModelError(msg)
    return found


def _flag(value: Any, what: str) -> bool:
    if not isinstance(value, bool):
        msg = f"{what} is {shown(value)}; give True or False"
        raise ModelError(msg)
    return value


def _check_rectangle(first: Vector, last: Vector, who: str) -> None:
    if first[0] == last[0] or first[1] == last[1]:
        msg = (
            f"{who}: from ({first[0]:.6g}, {first[1]:.6g}) m to ({last[0]:.6g}, {last[1]:.6g}) m in plan there is no "
            "area; give opposite corners, or a LineLoad along a line"
        )
        raise ModelError(msg)
