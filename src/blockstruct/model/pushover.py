"""Pushovers: what is asked of a model beyond its collapse."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot
from numbers import Integral, Real
from typing import Any, NamedTuple

import numpy as np

from blockstruct.errors import ModelError, shown
from blockstruct.model.checks import AXES_BY_NAME
from blockstruct.model.limit_case import LimitCase
from blockstruct.units import si, si_vector
from blockstruct.vocabulary import Flow

#: Most steps that a curve may be asked for.
MOST_STEPS = 10_000


class Point(NamedTuple):
    """A point in global coordinates, m."""

    x: float
    y: float
    z: float


@dataclass(frozen=True, slots=True)
class Pushover(LimitCase):
    """A limit case, and what follows its collapse: displacements that grow until the load factor is zero.

    Parameters
    ----------
    name, dead, variable
        As of :class:`LimitCase`.
    flow
        Non-associative: blocks that dilate by the friction angle would rise without end.
    control
        Name of a block, and a direction, three numbers or the name of an axis such as ``"+x"``: the curve is drawn over
        the displacement of its centroid along it.
    control_point : quantity, length, three components
        Another point of that block, where the model has it: not outside the block.
    steps
        Number of steps, about, in which the load factor comes down to zero.
    corner_rounding : quantity, length
        Radius of the corners of all blocks, once they move: faces that turn over an edge roll on it. Sharp by default.
        The load factor of the collapse state is that of the interfaces, whatever the corners.

    Attributes
    ----------
    control_point
        m; None for the centroid.
    corner_rounding : float
        m.
    """

    control: tuple[str, tuple[float, float, float]] = ("", (0.0, 0.0, 0.0))
    control_point: Point | None = None
    steps: int = 60
    corner_rounding: float = 0.0

    def __post_init__(self) -> None:
        # Classes with slots are made anew by dataclass: super() without arguments would look for the first one.
        LimitCase.__post_init__(self)
        object.__setattr__(self, "control", _control(self.control, self.name))
        if self.control_point is not None and not isinstance(self.control_point, Point):
            point = si_vector(self.control_point, "length", f"pushover {self.name!r}: control_point")
            object.__setattr__(self, "control_point", Point(*point))
        if self.flow is not Flow.NONASSOCIATIVE:
            msg = (
                f"pushover {self.name!r}: flow {self.flow.value!r}; blocks that dilate by the friction angle would "
                "rise without end: leave it out, and give joints a dilatancy angle if they have one"
            )
            raise ModelError(msg)
        if isinstance(self.steps, bool) or not isinstance(self.steps, Integral) or not 3 <= self.steps <= MOST_STEPS:
            msg = f"pushover {self.name!r}: steps is {shown(self.steps)}; give a whole number from 3 to {MOST_STEPS}"
            raise ModelError(msg)
        object.__setattr__(self, "steps", int(self.steps))
        what = f"pushover {self.name!r}: corner_rounding"
        # Of all lengths, zero needs no unit.
        radius = 0.0 if self.corner_rounding == 0 else si(self.corner_rounding, "length", what)
        if radius < 0:
            msg = f"{what} is {radius:.6g} m; give a radius from 0"
            raise ModelError(msg)
        object.__setattr__(self, "corner_rounding", radius)


def _control(given: Any, name: str) -> tuple[str, tuple[float, float, float]]:
    """A block and a unit direction."""
    msg = (
        f"pushover {name!r}: control is {shown(given)}; give the name of a block and a direction, as in "
        'control=("top", "+x") or control=("top", (0.6, 0.8, 0))'
    )
    if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != 2:
        raise ModelError(msg)
    block, direction = given
    if isinstance(direction, str):
        direction = AXES_BY_NAME.get(direction.strip(), direction)
    numbers = np.iterable(direction) and not isinstance(direction, str)
    values = list(direction) if numbers else []
    if not isinstance(block, str) or not block or len(values) != 3:
        raise ModelError(msg)
    if not all(isinstance(v, Real) and not isinstance(v, bool) and np.isfinite(float(v)) for v in values):
        raise ModelError(msg)
    length = hypot(*map(float, values))
    if not np.finfo(float).tiny <= length < np.inf:
        raise ModelError(msg)
    # A unit vector stays what it is to the last digit, however often it is written and read.
    unit = 1.0 if abs(length - 1) <= 4 * np.finfo(float).eps else length
    x, y, z = (float(v) / unit for v in values)
    return block, (x, y, z)
