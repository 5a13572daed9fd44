"""Loads on blocks, and load patterns: named sums of them."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from blockstruct.errors import ModelError, shown
from blockstruct.model.checks import checked_direction, checked_name, checked_tuple
from blockstruct.model.weights import AreaLoad, FillLoad, LineLoad, Weight
from blockstruct.units import QuantityLike, VectorLike, si, si_vector

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class SelfWeight:
    """The weight of every block, acting along −z."""


@dataclass(frozen=True, slots=True, init=False)
class BodyForce:
    """Mass-proportional force on every block at its centroid, and on every weight that the dead load carries.

    The weights are those of :class:`Weight`, :class:`LineLoad`, :class:`AreaLoad` and :class:`FillLoad` in the dead
    load of the case, each times its ``mass_share``, at its centre of mass. A :class:`PointLoad` or a :class:`FaceLoad`
    is a force without mass.

    Parameters
    ----------
    direction : three floats or str
        Of length 1, or the name of an axis: ``(1, 0, 0)`` and ``"+x"`` are the same. A vector of another length would
        scale the load factor unseen and is refused.
    share : float
        Force in multiples of each block's weight.

    Raises
    ------
    ModelError
        If the direction is zero or not of length 1, or the share is zero.

    Examples
    --------
    >>> BodyForce("-y").direction
    (0.0, -1.0, 0.0)
    >>> BodyForce((0.6, 0.8, 0), share=0.5).share
    0.5
    """

    direction: Vector
    share: float

    def __init__(self, direction: VectorLike, share: Any = 1.0) -> None:
        remedy = ", and share={length:.6g} if {length:.6g} times the weight is meant"
        vector = checked_direction(direction, "BodyForce: direction", remedy)
        of_weight = si(share, "dimensionless", "BodyForce: share")
        if of_weight == 0:
            msg = "BodyForce: share 0; give a share of the weight that acts"
            raise ModelError(msg)
        object.__setattr__(self, "direction", vector)
        object.__setattr__(self, "share", of_weight)


@dataclass(frozen=True, slots=True, init=False)
class PointLoad:
    """A force at a point of a block.

    Parameters
    ----------
    block
        Name of the block that carries the load.
    point : quantity, length, three components
        Where the force acts, in global coordinates; it moves with the block.
    force : quantity, force, three components

    Attributes
    ----------
    point, force
        m and N.
    """

    block: str
    point: Vector
    force: Vector

    def __init__(self, block: str, point: VectorLike, force: VectorLike) -> None:
        who = f"PointLoad on {checked_name(block, 'block')!r}"
        object.__setattr__(self, "block", block)
        object.__setattr__(self, "point", si_vector(point, "length", f"{who}: point"))
        object.__setattr__(self, "force", si_vector(force, "force", f"{who}: force"))


@dataclass(frozen=True, slots=True, init=False)
class FaceLoad:
    """A traction or a pressure on a face of a block: wind, water, earth.

    Its forces are those on the face where the model has it. In a :class:`Pushover` they keep their size and direction,
    and act on the same points of the block: a pressure does not turn with the face, nor change with its depth.

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
        A pressure that grows by the unit weight (of water; of earth times its coefficient of lateral pressure) with the
        depth below a level z; above the level there is none. Both or none.

    Attributes
    ----------
    traction, pressure
        Pa.
    unit_weight, level
        N/m³ and m; None without a level.

    Examples
    --------
    >>> FaceLoad("b1", 2, unit_weight="9.81 kN/m^3", level="3 m").level
    3.0
    """

    block: str
    face: int
    traction: Vector
    pressure: float
    unit_weight: float | None
    level: float | None

    def __init__(
        self,
        block: str,
        face: int,
        traction: VectorLike | None = None,
        *,
        pressure: QuantityLike | None = None,
        unit_weight: QuantityLike | None = None,
        level: QuantityLike | None = None,
    ) -> None:
        who = f"FaceLoad on {checked_name(block, 'block')!r}"
        if not isinstance(face, int) or face < 0:
            msg = f"{who}: face {shown(face)}; give the index of a face, zero or more"
            raise ModelError(msg)
        if traction is None and pressure is None and unit_weight is None and level is None:
            msg = f"{who}: give a traction, a pressure, or a unit_weight with its level"
            raise ModelError(msg)
        if (unit_weight is None) != (level is None):
            msg = f"{who}: give both unit_weight and level, below which the pressure grows, or none of them"
            raise ModelError(msg)
        grows = None if unit_weight is None else si(unit_weight, "force/volume", f"{who}: unit_weight")
        if grows is not None and grows <= 0:
            msg = f"{who}: unit_weight {grows:.6g} N/m^3; give more than zero"
            raise ModelError(msg)
        values = (
            block,
            face,
            (0.0, 0.0, 0.0) if traction is None else si_vector(traction, "stress", f"{who}: traction"),
            0.0 if pressure is None else si(pressure, "stress", f"{who}: pressure"),
            grows,
            None if level is None else si(level, "length", f"{who}: level"),
        )
        for name, value in zip(self.__slots__, values, strict=True):
            object.__setattr__(self, name, value)


@dataclass(frozen=True, slots=True, init=False)
class Moment:
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

    block: str
    moment: Vector

    def __init__(self, block: str, moment: VectorLike) -> None:
        who = f"Moment on {checked_name(block, 'block')!r}"
        object.__setattr__(self, "block", block)
        object.__setattr__(self, "moment", si_vector(moment, "moment", f"{who}: moment"))


Load = SelfWeight | BodyForce | PointLoad | FaceLoad | Moment | Weight | LineLoad | AreaLoad | FillLoad


@dataclass(frozen=True, slots=True)
class LoadKind:
    """What documents and files need to know of a kind of load.

    Parameters
    ----------
    type
        Its class, whose constructor takes all of the following by name.
    vectors, quantities
        Dimension of each vector and of each single quantity, a key of :data:`blockstruct.units.SI_UNITS`.
    named
        Attributes that are names or indices.
    plain
        Plain numbers, and truths, with their defaults.
    absent
        Values of attributes that were not given.
    """

    type: Callable[..., Load]
    vectors: Mapping[str, str] = field(default_factory=dict)
    named: tuple[str, ...] = ()
    plain: Mapping[str, float | bool] = field(default_factory=dict)
    quantities: Mapping[str, str] = field(default_factory=dict)
    absent: Mapping[str, Any] = field(default_factory=dict)


_ENDS, _ANYWHERE = {"start": "length", "end": "length"}, {"block": None}

#: The one table of loads: kind of each, as documents and files write it.
LOAD_KINDS: Mapping[str, LoadKind] = MappingProxyType(
    {
        "self_weight": LoadKind(SelfWeight),
        "body_force": LoadKind(BodyForce, {"direction": "dimensionless"}, plain={"share": 1.0}),
        "point_load": LoadKind(PointLoad, {"point": "length", "force": "force"}, ("block",)),
        "face_load": LoadKind(
            FaceLoad,
            {"traction": "stress"},
            ("block", "face"),
            quantities={"pressure": "stress", "unit_weight": "force/volume", "level": "length"},
            absent={"traction": (0.0, 0.0, 0.0), "pressure": 0.0, "unit_weight": None, "level": None},
        ),
        "moment": LoadKind(Moment, {"moment": "moment"}, ("block",)),
        "weight": LoadKind(Weight, {"point": "length"}, ("block",), {"mass_share": 1.0}, {"weight": "force"}),
        "line_load": LoadKind(
            LineLoad,
            _ENDS,
            ("block",),
            {"spanning": False, "mass_share": 1.0},
            {"weight_per_length": "force/length"},
            _ANYWHERE,
        ),
        "area_load": LoadKind(
            AreaLoad,
            _ENDS,
            ("block",),
            {"spanning": False, "mass_share": 1.0},
            {"weight_per_area": "stress"},
            _ANYWHERE | {"start": None, "end": None},
        ),
        "fill_load": LoadKind(
            FillLoad,
            _ENDS,
            ("block",),
            {"lateral_coefficient": 0.0, "mass_share": 1.0},
            {"unit_weight": "force/volume"},
            _ANYWHERE,
        ),
    }
)
_KINDS = {kind.type: name for name, kind in LOAD_KINDS.items()}


def kind_of(load: Load) -> str:
    """Kind of a load: a key of :data:`LOAD_KINDS`."""
    return _KINDS[type(load)]


@dataclass(frozen=True, slots=True, init=False)
class LoadPattern:
    """A named sum of loads.

    Parameters
    ----------
    name
        Unique among the patterns of an analysis.
    loads
        Weight, LineLoad, AreaLoad, FillLoad, BodyForce, PointLoad, FaceLoad or Moment, in any number; SelfWeight once.

    Raises
    ------
    ModelError
        If a load is none of these, or the weight of the blocks is given more than once.

    Examples
    --------
    >>> LoadPattern("dead", [SelfWeight()]).loads
    (SelfWeight(),)
    """

    name: str
    loads: tuple[Load, ...]

    def __init__(self, name: str, loads: Iterable[Load]) -> None:
        checked_name(name, "load pattern")
        loads = checked_tuple(loads, Load, f"load pattern {name!r}: loads")
        weights = sum(isinstance(load, SelfWeight) for load in loads)
        if weights > 1:
            msg = (
                f"load pattern {name!r}: SelfWeight (self_weight) is given {weights} times, and blocks would weigh as "
                "many times what their materials say; give it once, or other materials"
            )
            raise ModelError(msg)
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "loads", loads)
