"""Pushovers."""

from collections.abc import Sequence
from math import hypot
from numbers import Real
from typing import Any, NamedTuple, Self

import numpy as np
from attrs import evolve, field, frozen

from blockstruct.errors import ModelError, shown
from blockstruct.model.checks import AXES_BY_NAME, unit_vector_along
from blockstruct.model.fields import Vector, limit, named_arguments, steps
from blockstruct.model.limit_case import LimitCase
from blockstruct.model.model import Model
from blockstruct.units import QuantityLike, VectorLike, si, si_vector, to_quantity
from blockstruct.vocabulary import Flow


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
    if is_alone:
        value = ("", value)
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 2:
        raise ModelError(msg)
    block, direction = value
    if isinstance(direction, str):
        direction = AXES_BY_NAME.get(direction.strip(), direction)
    components = list(direction) if np.iterable(direction) and not isinstance(direction, str) else []
    if not isinstance(block, str) or not (block or is_alone) or len(components) != 3:
        raise ModelError(msg)
    if not all(isinstance(v, Real) and not isinstance(v, bool) and np.isfinite(float(v)) for v in components):
        raise ModelError(msg)
    x, y, z = map(float, components)
    if not np.finfo(float).tiny <= hypot(x, y, z) < np.inf:
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
    control_point: Point | None = field(default=None, converter=_point, metadata={"dimension": "length"})
    steps: int = field(default=60, converter=steps)
    corner_rounding: float = field(
        default=0.0,
        converter=_radius,
        validator=limit(lambda radius: radius >= 0, "give a radius of zero or more"),
        metadata={"dimension": "length"},
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
            found = model.block_at(to_quantity(self.control_point, "length"))
        except ModelError as error:
            error.add_note(f"at the control point of pushover {self.name!r}")
            raise
        return evolve(self, control=(found.name, direction))
