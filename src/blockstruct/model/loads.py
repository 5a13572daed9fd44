"""Loads on blocks, and load patterns, their named sums."""

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, get_args

import attrs
from attrs import field, frozen
from attrs.validators import optional

from blockstruct.errors import ModelError, shown
from blockstruct.model.checks import checked_tuple
from blockstruct.model.fields import (
    LEFT_OUT,
    ModelObject,
    Vector,
    absent_value,
    dimensions,
    has_name,
    label,
    limit,
    named_arguments,
    number,
    optional_scalar,
    optional_vector,
    positive,
    snake_case,
    unit_vector,
    vector,
)
from blockstruct.model.weights import AreaLoad, FillLoad, LineLoad, Weight


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
        metadata={"dimension": "dimensionless"},
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
    point: Vector = field(default=LEFT_OUT, converter=vector, metadata={"dimension": "length"})
    force: Vector = field(default=LEFT_OUT, converter=vector, metadata={"dimension": "force"})


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
        converter=optional_scalar,
        validator=positive,
        metadata={"dimension": "force/volume"},
    )
    level: float | None = field(default=None, kw_only=True, converter=optional_scalar, metadata={"dimension": "length"})

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


@frozen
class LoadKind:
    """A kind of load, as documents and files need it.

    Parameters
    ----------
    type
        Class of the load. Its constructor takes all attributes below by name.
    vectors, quantities
        Dimension of each vector and of each single quantity, a key of :data:`blockstruct.units.SI_UNITS`.
    named
        Attributes that are names or indices.
    plain
        Defaults of plain numbers and of booleans.
    absent
        Values of optional attributes that were left out.
    """

    type: Callable[..., Load]
    vectors: Mapping[str, str]
    named: tuple[str, ...]
    plain: Mapping[str, float | bool]
    quantities: Mapping[str, str]
    absent: Mapping[str, Any]

    @classmethod
    def of(cls, kind: Any) -> "LoadKind":
        """Return the table row of a class of loads."""
        measured, fields = dimensions(kind), attrs.fields_dict(kind)
        vectors = {n: d for n, d in measured.items() if Vector in (fields[n].type, *get_args(fields[n].type))}
        defaults = {n: absent_value(f) for n, f in fields.items() if f.default is not attrs.NOTHING}
        plain = {n: v for n, v in defaults.items() if isinstance(v, bool) or measured.get(n) == "dimensionless"}
        return cls(
            type=kind,
            vectors=vectors,
            named=tuple(n for n in fields if n not in measured | plain),
            plain=plain,
            quantities={n: d for n, d in measured.items() if n not in vectors | plain},
            absent={n: v for n, v in defaults.items() if n not in plain},
        )


#: Row of each kind of load, by its name in documents and files.
LOAD_KINDS: Mapping[str, LoadKind] = MappingProxyType(
    {snake_case(kind.__name__): LoadKind.of(kind) for kind in get_args(Load)}
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
