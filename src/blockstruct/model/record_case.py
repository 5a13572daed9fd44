"""Record cases: the response to an acceleration of the ground."""

from typing import Any

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from blockstruct.errors import DimensionError, ModelError
from blockstruct.model.checks import checked_direction
from blockstruct.model.fields import (
    ModelObject,
    Vector,
    changed,
    has_name,
    instance_of,
    label,
    named_arguments,
    optional_scalar,
    positive,
)
from blockstruct.model.loads import LoadPattern
from blockstruct.units import si_array
from blockstruct.vocabulary import Flow

#: Largest number of samples of a record.
MOST_SAMPLES = 1_000_000


def _values(value: Any, dimension: str, what: str, remedy: str) -> NDArray[np.float64]:
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
    if array.ndim == 1 and 2 <= len(array) <= MOST_SAMPLES:
        return tuple(array.tolist())
    if array.ndim == 2 and array.shape[1] == 3 and 2 <= len(array) <= MOST_SAMPLES:
        return tuple((x, y, z) for x, y, z in array.tolist())
    msg = (
        f"{what} has the shape {array.shape}; give 2 to {MOST_SAMPLES} samples: (n,) with a direction, or (n, 3) along "
        "x, y and z"
    )
    raise ModelError(msg)


def _time(value: Any, dimension: str = "", what: str = "") -> tuple[float, ...] | float:
    array = _values(value, dimension, what, "Give times in seconds, as in Q_(times, 's') or '0.005 s'.")
    return float(array) if array.ndim == 0 else tuple(array.ravel().tolist())


def _direction(value: Any, dimension: str = "", what: str = "") -> Vector | None:
    return None if value is None else checked_direction(value, what)


@frozen(repr=False, field_transformer=named_arguments)
class RecordCase(ModelObject):
    """The motion of a structure under its dead load while the ground accelerates.

    Blocks are rigid and have mass. They open, slide and strike each other without bounce. Weights of the dead load
    move with their blocks, with their ``mass_share``. The response says whether the structure stands.

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
        Longest step of the calculation. By default it follows from the size of the blocks.

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
    time: Any = field(converter=_time, metadata={"dimension": "time"})
    direction: Vector | None = field(default=None, converter=_direction, metadata={"dimension": "dimensionless"})
    interval: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata={"dimension": "time"}
    )
    time_step: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata={"dimension": "time"}
    )

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

    @property
    def flow(self) -> Flow:
        """Flow rule: joints slide with their own dilatancy."""
        return Flow.NONASSOCIATIVE

    @property
    def patterns(self) -> tuple[LoadPattern, ...]:
        """Load patterns of the case."""
        return (self.dead,)

    @property
    def times(self) -> NDArray[np.float64]:
        """Times (n,) of the samples, s."""
        if isinstance(self.time, float):
            return np.asarray(np.arange(len(self.acceleration)) * self.time, dtype=np.float64)
        return np.array(self.time)

    @property
    def ground(self) -> NDArray[np.float64]:
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
        'dead, ground acceleration up to 3 m/s² for 2 s'
        """
        return f"{self.dead.name}, ground acceleration up to {self.peak:.4g} m/s² for {self.duration:.4g} s"

    def renamed(self, name: str, flow: Flow | None = None) -> "RecordCase":
        """Return the same case with another name."""
        other: RecordCase = changed(self, name=name)
        return other

    def scaled(self, factor: float, name: str = "") -> "RecordCase":
        """Return the case with the acceleration times a factor.

        Its name is ``name``, or by default that of the case with the factor: ``"pulse × 1.5"``.
        """
        values = np.array(self.acceleration) * factor
        acceleration = tuple(map(tuple, values.tolist())) if values.ndim == 2 else tuple(values.tolist())
        other: RecordCase = changed(self, name=name or f"{self.name} × {factor:g}", acceleration=acceleration)
        return other

    def __repr__(self) -> str:
        along = "" if self.direction is None else f", direction={self.direction}"
        return f"RecordCase({self.name!r}, dead={self.dead.name!r}, {len(self.acceleration)} samples{along})"
