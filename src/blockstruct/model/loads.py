"""Loads on blocks, weights among them, and load patterns, their named sums."""

import math
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, ClassVar, get_args

from attrs import field, frozen
from attrs.validators import optional

from blockstruct.errors import ModelError, shown
from blockstruct.model.fields import (
    FORCE,
    LEFT_OUT,
    LENGTH,
    NUMBER,
    STRESS,
    UNIT_WEIGHT,
    ModelObject,
    Vector,
    checked_tuple,
    has_name,
    is_truth,
    label,
    limit,
    named_arguments,
    not_negative,
    number,
    optional_positive,
    optional_scalar,
    optional_vector,
    scalar,
    snake_case,
    unit_vector,
    vector,
)

_is_downwards = limit(
    lambda weight: weight > 0,
    "give more than zero: weights act downwards. For a lifting force use a PointLoad or a FaceLoad",
)
_is_share = limit(lambda share: 0 <= share <= 1, "give a share of the mass from 0 to 1")


@frozen(repr=False, field_transformer=named_arguments)
class Weight(ModelObject):
    """A concentrated weight on a block: a truss, a statue, a bell.

    It acts along −z. In cases with this weight in the dead load, a mass-proportional push (:class:`BodyForce`) also
    acts on its mass.

    Parameters
    ----------
    block
        Name of the block that carries the weight. Without it, the block at the point carries the weight.
    point : quantity, length, three components
        Centre of mass, within the block in plan. With the name of the block, it may be above or below the block. It
        moves with the block.
    weight : quantity, force
        Above zero.
    mass_share : float
        Share of the mass that a push acts on, from 0 to 1 (the default).

    Attributes
    ----------
    point, weight
        m and N.

    Examples
    --------
    >>> Weight("3.1", ["0.2 m", "0.1 m", "1.5 m"], "12 kN")
    Weight(block='3.1', point=(0.2, 0.1, 1.5) m, weight=12 kN)
    >>> Weight(point="[0.2, 0.1, 1.5] m", weight="12 kN")
    Weight(point=(0.2, 0.1, 1.5) m, weight=12 kN)
    """

    block: str | None = field(default=None, validator=optional(has_name))
    point: Vector = field(default=LEFT_OUT, converter=vector, metadata=LENGTH)
    weight: float = field(default=LEFT_OUT, converter=scalar, validator=_is_downwards, metadata=FORCE)
    mass_share: float = field(default=1.0, converter=number, validator=_is_share, metadata=NUMBER)


@frozen(repr=False, field_transformer=named_arguments)
class LineLoad(ModelObject):
    """A weight along a line, on a block or on all blocks under the line: the edge of a floor, a row of rafters.

    A mass-proportional push acts on its mass as on the mass of a :class:`Weight`.

    Parameters
    ----------
    weight_per_length : quantity, force/length
        Above zero.
    start, end : quantity, length, three components
        Ends of the line. Without a block, the line is level and lies on upper faces of blocks at its height. If it runs
        between two blocks, each carries half. Along an edge, the block with the edge carries the whole load. The
        tolerance of heights and edges is a thousandth of a block.
    block
        Name of the one block that carries the load. The line lies within its extent.
    spanning
        True: parts of the line without a block below load the other blocks in proportion to the lengths on them.
        False: such parts are refused.
    mass_share : float
        Share of the mass that a push acts on, from 0 to 1.

    Attributes
    ----------
    weight_per_length
        N/m.
    start, end
        m.
    """

    block: str | None = field(default=None, kw_only=True, validator=optional(has_name))
    weight_per_length: float = field(converter=scalar, validator=_is_downwards, metadata={"dimension": "force/length"})
    start: Vector = field(converter=vector, metadata=LENGTH)
    end: Vector = field(converter=vector, metadata=LENGTH)
    spanning: bool = field(default=False, kw_only=True, validator=is_truth)
    mass_share: float = field(default=1.0, kw_only=True, converter=number, validator=_is_share, metadata=NUMBER)

    def __attrs_post_init__(self) -> None:
        if self.start[:2] == self.end[:2]:
            msg = (
                f"{label(self)}: start {self.start} m and end {self.end} m are one point in plan; give a line, or a "
                "Weight at the point"
            )
            raise ModelError(msg)
        if self.block is None:
            _check_level(self, "give a level line, or name the block that carries an inclined one")


@frozen(repr=False, field_transformer=named_arguments)
class AreaLoad(ModelObject):
    """A weight per area in plan, on a block or on all blocks under a level rectangle: a floor, a roof, snow.

    A mass-proportional push acts on its mass as on the mass of a :class:`Weight`.

    Parameters
    ----------
    weight_per_area : quantity, stress
        Per area in plan, above zero.
    start, end : quantity, length, three components
        Opposite corners of the rectangle, along x and y, both at its level. The load lies on upper faces of blocks at
        this height, to a thousandth of a block. Blocks on these faces do not reduce the load: a floor bears in a pocket
        of the wall. Without a rectangle, the load acts on all upper faces of ``block`` that touch no other block.
    block
        Name of the one block that carries the load. Without it, all blocks with such faces carry it.
    spanning
        True: the blocks also carry the load of parts of the rectangle without a block below, in proportion to their
        areas, as under a floor that spans from wall to wall. False: such parts are refused.
    mass_share : float
        Share of the mass that a push acts on, from 0 to 1.

    Attributes
    ----------
    weight_per_area
        Pa.
    start, end
        m, or None.
    """

    block: str | None = field(default=None, kw_only=True, validator=optional(has_name))
    weight_per_area: float = field(converter=scalar, validator=_is_downwards, metadata=STRESS)
    start: Vector | None = field(default=None, converter=optional_vector, metadata=LENGTH)
    end: Vector | None = field(default=None, converter=optional_vector, metadata=LENGTH)
    spanning: bool = field(default=False, kw_only=True, validator=is_truth)
    mass_share: float = field(default=1.0, kw_only=True, converter=number, validator=_is_share, metadata=NUMBER)

    def __attrs_post_init__(self) -> None:
        if (self.start is None) != (self.end is None) or (self.start is None and self.block is None):
            msg = (
                f"{label(self)}: give start and end, opposite corners of a level rectangle, or the block that carries "
                "the load"
            )
            raise ModelError(msg)
        if self.start is not None:
            _check_rectangle(self)
            _check_level(self, "give both at the level of the load")
        elif self.spanning:
            msg = f"{label(self)}: spanning needs a rectangle; give start and end"
            raise ModelError(msg)


@frozen(repr=False, field_transformer=named_arguments)
class FillLoad(ModelObject):
    """Fill on a vault: its weight from the blocks up to a level, and its pressure on their faces.

    Each face that looks upwards into the box from ``start`` to ``end`` carries the fill right above it, up to the upper
    side of the box. A mass-proportional push acts on the mass of the fill as on the mass of a :class:`Weight`. Its
    centre of mass is at the place of the fill, which moves with the block below.

    Parameters
    ----------
    unit_weight : quantity, force/volume
        Above zero.
    start, end : quantity, length, three components
        Opposite corners of a box. Its upper side is the level of the fill. Faces below its lower side carry no fill.
    block
        Name of the only block that carries fill. By default, all blocks do.
    lateral_coefficient : float
        Coefficient K of the horizontal pressure K γ h on the faces that carry fill, at the depth h below the level.
        Zero by default. Vertical faces carry no fill: give their pressure as a :class:`FaceLoad` with a unit weight.
    mass_share : float
        Share of the mass that a push acts on, from 0 to 1.

    Attributes
    ----------
    unit_weight
        N/m³.
    start, end
        m.
    """

    computed: ClassVar = {"level": "length"}

    block: str | None = field(default=None, kw_only=True, validator=optional(has_name))
    unit_weight: float = field(converter=scalar, validator=_is_downwards, metadata=UNIT_WEIGHT)
    start: Vector = field(converter=vector, metadata=LENGTH)
    end: Vector = field(converter=vector, metadata=LENGTH)
    lateral_coefficient: float = field(
        default=0.0, kw_only=True, converter=number, validator=not_negative, metadata=NUMBER
    )
    mass_share: float = field(default=1.0, kw_only=True, converter=number, validator=_is_share, metadata=NUMBER)

    def __attrs_post_init__(self) -> None:
        _check_rectangle(self)
        if self.start[2] == self.end[2]:
            msg = f"{label(self)}: start and end are both at z = {self.end[2]:.6g} m; give opposite corners of a box"
            raise ModelError(msg)

    @property
    def level(self) -> float:
        """Upper side of the fill, m."""
        return max(self.start[2], self.end[2])


#: Loads with a mass.
WeightLoad = Weight | LineLoad | AreaLoad | FillLoad


def _check_level(load: Any, remedy: str) -> None:
    first, last = load.start[2], load.end[2]
    if not math.isclose(first, last):
        msg = f"{label(load)}: start at z = {first:.6g} m, end at {last:.6g} m; {remedy}"
        raise ModelError(msg)


def _check_rectangle(load: Any) -> None:
    first, last = load.start, load.end
    if first[0] == last[0] or first[1] == last[1]:
        msg = (
            f"{label(load)}: from ({first[0]:.6g}, {first[1]:.6g}) m to ({last[0]:.6g}, {last[1]:.6g}) m in plan there "
            "is no area; give opposite corners, or a LineLoad along a line"
        )
        raise ModelError(msg)


@frozen(repr=False, field_transformer=named_arguments)
class SelfWeight(ModelObject):
    """The weight of every block, acting along −z."""


@frozen(repr=False, field_transformer=named_arguments)
class BodyForce(ModelObject):
    """Mass-proportional force on every block at its centroid, and on every weight in the dead load.

    It acts on each :class:`Weight`, :class:`LineLoad`, :class:`AreaLoad` and :class:`FillLoad` in the dead load of the
    case, times its ``mass_share``, at its centre of mass. A :class:`PointLoad` or a :class:`FaceLoad` has no mass.

    Parameters
    ----------
    direction : three floats or str
        Of length 1, or the name of an axis: ``(1, 0, 0)`` and ``"+x"`` are the same. A vector of another length is
        refused, because it would scale the load factor.
    share : float
        Force in multiples of each block's weight.

    Raises
    ------
    ModelError
        If the direction is zero or not of length 1, or the share is zero.

    Examples
    --------
    >>> BodyForce("-y")
    BodyForce(direction=(0, -1, 0))
    >>> BodyForce((0.6, 0.8, 0), share=0.5).share
    0.5
    """

    direction: Vector = field(
        converter=unit_vector,
        metadata={
            "dimension": "dimensionless",
            "remedy": ", and share={length:.6g} if {length:.6g} times the weight is meant",
        },
    )
    share: float = field(
        default=1.0,
        converter=number,
        validator=limit(lambda share: share != 0, "give a share of the weight that acts"),
        metadata=NUMBER,
    )


@frozen(repr=False, field_transformer=named_arguments)
class PointLoad(ModelObject):
    """A force at a point of a block.

    Parameters
    ----------
    block
        Name of the block that carries the load. Without it, the block at the point carries the load.
    point : quantity, length, three components
        Point of action in global coordinates. It moves with the block.
    force : quantity, force, three components

    Attributes
    ----------
    point, force
        m and N.
    """

    block: str | None = field(default=None, validator=optional(has_name))
    point: Vector = field(default=LEFT_OUT, converter=vector, metadata=LENGTH)
    force: Vector = field(default=LEFT_OUT, converter=vector, metadata=FORCE)


def _is_index(load: Any, _: Any, face: Any) -> None:
    if not isinstance(face, int) or face < 0:
        msg = f"{label(load)}: face {shown(face)}; give the index of a face, zero or more"
        raise ModelError(msg)


@frozen(repr=False, field_transformer=named_arguments)
class FaceLoad(ModelObject):
    """A traction or a pressure on a face of a block: wind, water, earth.

    The forces follow from the place of the face in the model. In a :class:`Pushover` they keep their size and
    direction, and act on the same points of the block: a pressure does not turn with the face.

    Parameters
    ----------
    block
        Name of the block that carries the load.
    face
        Index of the face in the block's list of faces, see :meth:`Block.face_towards`.
    traction : quantity, stress, three components
        Force per area of the face, in global coordinates.
    pressure : quantity, stress
        Against the face from outside, along its inward normal; negative for suction.
    unit_weight, level : quantity, force/volume and quantity, length
        Pressure that grows with the depth below the level z by the unit weight: of water, or of earth times its
        coefficient of lateral pressure. Zero above the level. Give both, or neither.

    Attributes
    ----------
    traction, pressure
        Pa.
    unit_weight, level
        N/m³ and m; None without a level.

    Examples
    --------
    >>> FaceLoad("b1", 2, unit_weight="9.81 kN/m^3", level="3 m")
    FaceLoad(block='b1', face=2, unit_weight=9.81 kN/m³, level=3 m)
    """

    block: str = field(validator=has_name)
    face: int = field(validator=_is_index)
    traction: Vector = field(
        default=LEFT_OUT, converter=optional_vector, metadata={"dimension": "stress", "absent": (0.0, 0.0, 0.0)}
    )
    pressure: float = field(
        default=LEFT_OUT, kw_only=True, converter=optional_scalar, metadata={"dimension": "stress", "absent": 0.0}
    )
    unit_weight: float | None = field(
        default=None,
        kw_only=True,
        converter=optional_positive,
        metadata=UNIT_WEIGHT,
    )
    level: float | None = field(default=None, kw_only=True, converter=optional_scalar, metadata=LENGTH)

    def __attrs_pre_init__(
        self, block: Any, face: Any, traction: Any, pressure: Any, unit_weight: Any, level: Any
    ) -> None:
        who = f"FaceLoad on {shown(block)}"
        if traction is None and pressure is None and unit_weight is None and level is None:
            msg = f"{who}: give a traction, a pressure, or a unit_weight with its level"
            raise ModelError(msg)
        if (unit_weight is None) != (level is None):
            msg = f"{who}: give both unit_weight and level, below which the pressure grows, or neither"
            raise ModelError(msg)


@frozen(repr=False, field_transformer=named_arguments)
class Moment(ModelObject):
    """A couple on a block.

    Parameters
    ----------
    block
        Name of the block that carries the couple.
    moment : quantity, moment, three components
        About the global axes, right-handed.

    Attributes
    ----------
    moment
        N·m.
    """

    block: str = field(validator=has_name)
    moment: Vector = field(converter=vector, metadata={"dimension": "moment"})


Load = SelfWeight | BodyForce | PointLoad | FaceLoad | Moment | Weight | LineLoad | AreaLoad | FillLoad


#: Class of each kind of load, by its name in documents and files.
LOAD_KINDS: Mapping[str, Callable[..., Load]] = MappingProxyType(
    {snake_case(kind.__name__): kind for kind in get_args(Load)}
)


def kind_of(load: Load) -> str:
    """Return the kind of a load, a key of :data:`LOAD_KINDS`."""
    return snake_case(type(load).__name__)


def _loads(value: Iterable[Load], what: str = "") -> tuple[Load, ...]:
    return checked_tuple(value, Load, what)


@frozen(repr=False, field_transformer=named_arguments)
class LoadPattern(ModelObject):
    """A named sum of loads.

    Parameters
    ----------
    name
        Unique among the patterns of an analysis.
    loads
        Any number of Weight, LineLoad, AreaLoad, FillLoad, BodyForce, PointLoad, FaceLoad or Moment; one SelfWeight.

    Raises
    ------
    ModelError
        If an object is not a load, or SelfWeight appears twice.

    Examples
    --------
    >>> LoadPattern("dead", [SelfWeight()])
    LoadPattern('dead', loads=(SelfWeight(),))
    """

    name: str = field(validator=has_name)
    loads: tuple[Load, ...] = field(converter=_loads)

    def __attrs_post_init__(self) -> None:
        weights = sum(isinstance(load, SelfWeight) for load in self.loads)
        if weights > 1:
            msg = (
                f"load pattern {self.name!r}: SelfWeight (self_weight) appears {weights} times. Use it once: each one "
                "adds the full weight of every block"
            )
            raise ModelError(msg)
