"""Cases of an analysis: limit cases, settlements, pushovers and records."""

from collections.abc import Iterable, Sequence
from math import hypot
from typing import Any, NamedTuple, Self, TypeGuard

import numpy as np
from attrs import evolve, field, frozen

from blockstruct.arrays import Array
from blockstruct.errors import BlockstructError, DimensionError, ModelError, shown
from blockstruct.files import MOST_READ
from blockstruct.model.fields import (
    AXES_BY_NAME,
    LENGTH,
    NUMBER,
    TIME,
    ModelObject,
    Vector,
    changed,
    checked_direction,
    checked_tuple,
    has_name,
    instance_of,
    label,
    limit,
    member,
    named_arguments,
    optional_positive,
    optional_vector,
    steps,
    unit_vector,
    unit_vector_along,
)
from blockstruct.model.loads import LoadPattern
from blockstruct.model.model import Model
from blockstruct.units import QuantityLike, VectorLike, quantity_text, si, si_array, si_vector, to_quantity
from blockstruct.vocabulary import Flow, axis_text

#: Largest share of intervals that miss samples, in a record that is otherwise sampled evenly.
RARE = 0.1
#: Usual number of steps of a curve.
STEPS = 60


def flow_rule(value: Flow | str, what: str = "") -> Flow:
    """Return the flow rule of a name."""
    return member(value, Flow, what)


@frozen(repr=False, field_transformer=named_arguments)
class LimitCase(ModelObject):
    """A dead load that stays and a variable load that grows until collapse.

    Parameters
    ----------
    name
        Unique in an analysis.
    dead
        Loads that act in full.
    variable
        Loads that act times the load factor.
    flow
        ``"nonassociative"`` (sliding dilates by each joint's dilatancy angle, zero by default) or
        ``"associative"`` (sliding dilates by the friction angle: an upper bound, solved in one program).
    """

    name: str = field(validator=has_name)
    dead: LoadPattern = field(validator=instance_of(LoadPattern))
    variable: LoadPattern = field(validator=instance_of(LoadPattern))
    flow: Flow = field(default=Flow.NONASSOCIATIVE, converter=flow_rule)

    @property
    def patterns(self) -> tuple[LoadPattern, ...]:
        """Load patterns of the case."""
        return (self.dead, self.variable)

    @property
    def question(self) -> str:
        """Loads and flow rule in words.

        >>> LimitCase("pushed", LoadPattern("dead", []), LoadPattern("push", [])).question
        'dead + load factor × push, nonassociative flow'
        """
        return f"{self.dead.name} + load factor × {self.variable.name}, {self.flow} flow"

    def renamed(self, name: str, flow: Flow | None = None) -> "LimitCase":
        """Return a limit case with the same loads, another name and, if given, another flow rule."""
        return LimitCase(name, self.dead, self.variable, flow or self.flow)


def _names(value: Iterable[str], what: str = "") -> tuple[str, ...]:
    return checked_tuple((value,) if isinstance(value, str) else value, str, what)


def _each_once(case: Any, _: Any, supports: tuple[str, ...]) -> None:
    if not supports or len(set(supports)) < len(supports):
        problem = f"supports {', '.join(supports)} repeat a name" if supports else "there is no support"
        msg = f"{label(case)}: {problem}; name each support that moves once"
        raise ModelError(msg)


@frozen(repr=False, field_transformer=named_arguments)
class SettlementCase(ModelObject):
    """Supports that give way under the dead load, as one rigid body and in one direction.

    The result is the reaction that remains when the structure begins to follow: the least reaction for which forces in
    equilibrium, within the strength of the joints, are the forces of a mechanism. The reaction is the force of the
    joints and the ties on the supports along the motion, positive against the motion. It does not include the weight of
    the supports.

    With a ``displacement`` the supports move on, and the structure is followed through large displacements: see
    :attr:`CaseResult.capacity`.

    Parameters
    ----------
    name
        Unique in an analysis.
    dead
        Loads that act in full.
    supports
        Names of the supports that move.
    direction : three floats or str
        Direction of the motion, of length 1. ``(0, 0, -1)`` and ``"-z"`` are a settlement. A horizontal direction is a
        spreading support, and the reaction is its thrust. With ``about``, the axis of a right-handed rotation.
    about : quantity, length, three components
        A point of the axis, if the supports turn. The reaction is then a moment about the axis.
    flow
        As for :class:`LimitCase`. With associative flow the reaction is the least that statics allows.
    displacement : quantity, length
        Displacement up to which the structure is followed. Without it, the case ends when the structure begins to
        follow.
    steps
        Approximate number of steps in which the supports reach this displacement.

    Attributes
    ----------
    direction : three floats
        Of length 1.
    about : three floats or None
        m.
    displacement : float or None
        m.

    Raises
    ------
    ModelError
        If there is no support, a support is repeated, or the direction is not of length 1. If supports turn or flow is
        associative, and there is a displacement. If there are steps and no displacement.

    Examples
    --------
    >>> dead = LoadPattern("dead", [])
    >>> SettlementCase("left pier", dead, ["left pier"], "-z").direction
    (0.0, 0.0, -1.0)
    """

    name: str = field(validator=has_name)
    dead: LoadPattern = field(validator=instance_of(LoadPattern))
    supports: tuple[str, ...] = field(converter=_names, validator=_each_once)
    direction: Vector = field(converter=unit_vector, metadata=NUMBER)
    about: Vector | None = field(default=None, kw_only=True, converter=optional_vector, metadata=LENGTH)
    flow: Flow = field(default=Flow.NONASSOCIATIVE, kw_only=True, converter=flow_rule)
    displacement: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=LENGTH)
    steps: int = field(default=STEPS, kw_only=True, converter=steps)

    def __attrs_post_init__(self) -> None:
        if self.displacement is None:
            if self.steps != STEPS:
                msg = f"{label(self)}: {self.steps} steps divide no displacement; give one, or leave out steps"
                raise ModelError(msg)
            return
        if self.about is not None:
            msg = f"{label(self)}: supports that turn have no displacement; leave out about or displacement"
            raise ModelError(msg)
        if self.flow is Flow.ASSOCIATIVE:
            msg = f"{label(self)}: associative flow would lift blocks without end; leave out flow or displacement"
            raise ModelError(msg)

    @property
    def patterns(self) -> tuple[LoadPattern, ...]:
        """Load patterns of the case."""
        return (self.dead,)

    @property
    def question(self) -> str:
        """Load, motion and flow rule in words.

        >>> SettlementCase("left", LoadPattern("dead", []), ["left pier"], "-z").question
        'dead, left pier moves along -z, nonassociative flow'
        """
        return f"{self.dead.name}, {self.motion}, {self.flow} flow"

    @property
    def motion(self) -> str:
        """Motion of the supports in words.

        >>> SettlementCase("left", LoadPattern("dead", []), ["left pier"], "-z").motion
        'left pier moves along -z'
        """
        who, one = ", ".join(self.supports), len(self.supports) == 1
        axis = axis_text(self.direction)
        if self.about is None:
            by = "" if self.displacement is None else f" by {quantity_text(self.displacement, 'length')}"
            return f"{who} {'moves' if one else 'move'} along {axis}{by}"
        point = "({:.4g}, {:.4g}, {:.4g}) m".format(*self.about)
        return f"{who} {'turns' if one else 'turn'} about {axis} through {point}"

    def renamed(self, name: str, flow: Flow | None = None) -> Self:
        """Return the case without a displacement, with another name and, if given, another flow rule."""
        other: Self = changed(self, name=name, flow=flow or self.flow, displacement=None)
        return other


class Point(NamedTuple):
    """A point in global coordinates, m."""

    x: float
    y: float
    z: float


def _control(value: Any, what: str = "") -> tuple[str, Vector]:
    """Return a block and a unit direction; a direction alone has an empty name."""
    msg = (
        f"{what} is {shown(value)}; give the name of a block and a direction, as in "
        'control=("top", "+x") or control=("top", (0.6, 0.8, 0))'
    )
    is_alone = value in AXES_BY_NAME if isinstance(value, str) else isinstance(value, Sequence) and len(value) == 3
    try:
        block, direction = ("", value) if is_alone else value
        if isinstance(direction, str):
            direction = AXES_BY_NAME.get(direction.strip(), direction)
        x, y, z = si_vector(direction, "dimensionless", what)
    except (BlockstructError, TypeError, ValueError):
        raise ModelError(msg) from None
    if not isinstance(block, str) or not (block or is_alone) or not np.finfo(float).tiny <= hypot(x, y, z) < np.inf:
        raise ModelError(msg)
    return block, unit_vector_along(x, y, z)


def _point(value: VectorLike | Point | None, dimension: str = "", what: str = "") -> Point | None:
    return value if value is None or isinstance(value, Point) else Point(*si_vector(value, dimension, what))


def _radius(value: QuantityLike | float, dimension: str = "", what: str = "") -> float:
    # Zero needs no unit: all lengths of zero are equal.
    return 0.0 if value == 0 else si(value, dimension, what)


@frozen(repr=False, field_transformer=named_arguments)
class Pushover(LimitCase):
    """A limit case and the displacements after collapse, which grow until the load factor is zero.

    Parameters
    ----------
    name, dead, variable
        As for :class:`LimitCase`.
    flow
        Non-associative. With associative flow blocks would rise without end.
    control
        Name of a block and a direction: three numbers, or the name of an axis such as ``"+x"``. The curve shows the
        load factor over the displacement of the block's centroid along this direction. With a ``control_point``, the
        direction alone is enough.
    control_point : quantity, length, three components
        Another point of the block, within it, at its place in the model. Without the name of a block, the model finds
        the block at the point.
    steps
        Approximate number of steps in which the load factor falls to zero.
    corner_rounding : quantity, length
        Radius of the corners of all blocks during motion. A face that turns over an edge rolls on it. Zero by default:
        corners are sharp. The load factor at collapse does not depend on it.

    Attributes
    ----------
    control_point
        m; None for the centroid.
    corner_rounding : float
        m.
    """

    control: tuple[str, Vector] = field(default=("", (0.0, 0.0, 0.0)), converter=_control)
    control_point: Point | None = field(default=None, converter=_point, metadata=LENGTH)
    steps: int = field(default=STEPS, converter=steps)
    corner_rounding: float = field(
        default=0.0,
        converter=_radius,
        validator=limit(lambda radius: radius >= 0, "give a radius of zero or more"),
        metadata=LENGTH,
    )

    def __attrs_post_init__(self) -> None:
        if self.flow is not Flow.NONASSOCIATIVE:
            msg = (
                f"pushover {self.name!r}: flow {self.flow.value!r}; with it blocks would rise without end. Leave flow "
                "out, and give the joints a dilatancy angle if they have one"
            )
            raise ModelError(msg)
        if not self.control[0] and self.control_point is None:
            msg = f"pushover {self.name!r}: control names no block; give a control_point, or control=(block, direction)"
            raise ModelError(msg)

    def located(self, model: Model) -> Self:
        """Return the case with the name of the block at its control point.

        Raises
        ------
        ModelError
            If no block is at the point, or several blocks share it.
        """
        block, direction = self.control
        if block or self.control_point is None:
            return self
        try:
            nearest = model.block_at(to_quantity(self.control_point, "length"))
        except ModelError as error:
            error.add_note(f"at the control point of pushover {self.name!r}")
            raise
        return evolve(self, control=(nearest.name, direction))


def _values(value: Any, dimension: str, what: str, remedy: str) -> Array:
    """Return the SI floats of an array of quantities; name the first one that is not finite."""
    magnitude = getattr(value, "magnitude", None)
    if magnitude is not None:
        try:
            wrong = np.argwhere(~np.isfinite(np.asarray(magnitude, dtype=float)))
        except (TypeError, ValueError):
            wrong = np.empty((0, 1), dtype=int)
        if len(wrong):
            msg = f"{what}: sample {wrong[0][0]} is not finite ({len(wrong)} in all); fill the gaps, or cut the record"
            raise DimensionError(msg)
    try:
        return si_array(value, dimension, what)
    except DimensionError as error:
        error.add_note(remedy)
        raise


def _acceleration(value: Any, dimension: str = "", what: str = "") -> tuple[float, ...] | tuple[Vector, ...]:
    remedy = "The unit of gravity is 'g_0': 'g' is a gram."
    array = _values(value, dimension, what, remedy)
    if array.ndim == 1 and 2 <= len(array) <= MOST_READ:
        return tuple(array.tolist())
    if array.ndim == 2 and array.shape[1] == 3 and 2 <= len(array) <= MOST_READ:
        return tuple((x, y, z) for x, y, z in array.tolist())
    msg = (
        f"{what} has the shape {array.shape}; give 2 to {MOST_READ} samples: (n,) with a direction, or (n, 3) along "
        "x, y and z"
    )
    raise ModelError(msg)


def _time(value: Any, dimension: str = "", what: str = "") -> tuple[float, ...] | float:
    array = _values(value, dimension, what, "Give times in seconds, as in Q_(times, 's') or '0.005 s'.")
    return float(array) if array.ndim == 0 else tuple(array.ravel().tolist())


def _ground_direction(value: Any, dimension: str = "", what: str = "") -> Vector | None:
    return None if value is None else checked_direction(value, what)


@frozen(repr=False, field_transformer=named_arguments)
class RecordCase(ModelObject):
    """The motion of a structure under its dead load while the ground accelerates.

    Blocks are rigid and have mass. They open, slide and strike each other without bounce. Weights of the dead load
    move with their blocks, with their ``mass_share``. The result is whether the structure stands.

    Parameters
    ----------
    name
        Unique in an analysis.
    dead
        Loads that act in full.
    acceleration : quantity, acceleration, shape (n,) or (n, 3)
        Acceleration of the ground, as in ``Q_(values, "g_0")`` or ``Q_(values, "m/s^2")``. It is linear between
        samples and zero after the last one.
    time : quantity, time, shape (n,) or a single one
        Times of the samples, ascending; or the interval between samples, which then begin at zero.
    direction : three floats or str
        Direction of an acceleration of shape (n,): of length 1, or the name of an axis such as ``"+x"``.
    interval : quantity, time
        Time between two states that are kept. By default up to 200 states span the record, at least 10 ms apart.
    time_step : quantity, time
        Longest step of the calculation. By default it follows from the size of the blocks and from what they bear.

    Attributes
    ----------
    acceleration : tuple
        m/s²: floats, or vectors of three.
    time : tuple of float or float
        s.
    direction : three floats or None
    interval, time_step : float or None
        s.

    Raises
    ------
    ModelError
        If times do not ascend or are not as many as accelerations, or the direction is missing or not needed.
    DimensionError
        If a sample is not finite or has another unit.

    Examples
    --------
    >>> from blockstruct import Q_
    >>> pulse = RecordCase("pulse", LoadPattern("dead", []), Q_([0, 0.3, 0], "g_0"), "0.5 s", "+x")
    >>> pulse.duration, round(pulse.peak, 4)
    (1.0, 2.942)
    """

    name: str = field(validator=has_name)
    dead: LoadPattern = field(validator=instance_of(LoadPattern))
    acceleration: Any = field(converter=_acceleration, metadata={"dimension": "acceleration"})
    time: Any = field(converter=_time, metadata=TIME)
    direction: Vector | None = field(default=None, converter=_ground_direction, metadata=NUMBER)
    interval: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=TIME)
    time_step: float | None = field(default=None, kw_only=True, converter=optional_positive, metadata=TIME)

    def __attrs_post_init__(self) -> None:
        n, who = len(self.acceleration), label(self)
        is_vector = isinstance(self.acceleration[0], tuple)
        if is_vector == (self.direction is not None):
            given = f"an acceleration of shape ({n}, 3) and a direction" if is_vector else "no direction"
            remedy = (
                "leave the direction out" if is_vector else "give direction='+x', or an acceleration of shape (n, 3)"
            )
            msg = f"{who}: {given}; {remedy}"
            raise ModelError(msg)
        if isinstance(self.time, float):
            if self.time <= 0:
                msg = f"{who}: the time between samples is {self.time:.6g} s; give more than zero"
                raise ModelError(msg)
            return
        if len(self.time) != n:
            msg = f"{who}: {len(self.time)} times and {n} accelerations; give as many of each, or a single interval"
            raise ModelError(msg)
        short = np.flatnonzero(np.diff(self.time) <= 0)
        if len(short):
            k = int(short[0])
            msg = (
                f"{who}: time does not ascend at sample {k + 1}, {self.time[k + 1]:.6g} s after {self.time[k]:.6g} s; "
                "sort the record, and leave repeated samples out"
            )
            raise ModelError(msg)
        self._check_gaps(who)

    def _check_gaps(self, who: str) -> None:
        """Refuse a record that is sampled evenly but for gaps in which the ground accelerates."""
        intervals, moves = np.diff(self.times), np.abs(self.ground).max(axis=1) > 0
        misses = np.rint(intervals / np.median(intervals)) > 1
        gaps = np.flatnonzero(misses & (moves[1:] | moves[:-1]))
        if len(gaps) and misses.mean() <= RARE:
            k = int(gaps[0])
            msg = (
                f"{who}: no samples from {self.time[k]:.6g} to {self.time[k + 1]:.6g} s, and the ground accelerates "
                "there; fill the gap with samples, or cut the record"
            )
            raise ModelError(msg)

    @property
    def flow(self) -> Flow:
        """Flow rule: joints slide with their own dilatancy."""
        return Flow.NONASSOCIATIVE

    @property
    def patterns(self) -> tuple[LoadPattern, ...]:
        """Load patterns of the case."""
        return (self.dead,)

    @property
    def times(self) -> Array:
        """Times (n,) of the samples, s."""
        if isinstance(self.time, float):
            return np.asarray(np.arange(len(self.acceleration)) * self.time, dtype=np.float64)
        return np.array(self.time)

    @property
    def ground(self) -> Array:
        """Acceleration (n, 3) of the ground, m/s²."""
        values = np.array(self.acceleration)
        return np.asarray(values if self.direction is None else values[:, None] * np.array(self.direction))

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, s."""
        return float(self.times[-1] - self.times[0])

    @property
    def peak(self) -> float:
        """Largest acceleration, m/s²."""
        return float(np.linalg.norm(self.ground, axis=1).max())

    @property
    def question(self) -> str:
        """Dead load and record in words.

        >>> from blockstruct import Q_
        >>> RecordCase("pulse", LoadPattern("dead", []), Q_([0, 3, 0], "m/s^2"), "1 s", "+x").question
        'dead, ground acceleration along +x up to 3 m/s² for 2 s'
        """
        along = "" if self.direction is None else f"along {axis_text(self.direction)} "
        return f"{self.dead.name}, ground acceleration {along}up to {self.peak:.4g} m/s² for {self.duration:.4g} s"

    def renamed(self, name: str, flow: Flow | None = None) -> "RecordCase":
        """Return the same case with another name."""
        other: RecordCase = changed(self, name=name)
        return other

    def scaled(self, factor: float, name: str = "") -> "RecordCase":
        """Return the case with the acceleration times a factor.

        Its name is ``name``, or by default the name of the case and the factor: ``"pulse × 1.5"``.
        """
        if not np.isfinite(factor):
            msg = f"{label(self)}: scaled by {factor:g}; give a finite number"
            raise ModelError(msg)
        values = np.array(self.acceleration) * factor
        acceleration = tuple(map(tuple, values.tolist())) if values.ndim == 2 else tuple(values.tolist())
        other: RecordCase = changed(self, name=name or f"{self.name} × {factor:g}", acceleration=acceleration)
        return other

    def __repr__(self) -> str:
        along = "" if self.direction is None else f", direction={self.direction}"
        return f"RecordCase({self.name!r}, dead={self.dead.name!r}, {len(self.acceleration)} samples{along})"


#: Any case of an analysis.
Case = LimitCase | SettlementCase | RecordCase
#: A case whose blocks may be followed through large displacements.
MovingCase = Pushover | SettlementCase


def has_curve(case: Case) -> TypeGuard[MovingCase]:
    """Return whether the blocks of a case are followed through large displacements."""
    return isinstance(case, Pushover) or (isinstance(case, SettlementCase) and case.displacement is not None)
