"""Sidewalls and buttresses of a wall."""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import shapely
from attrs import field, frozen

from blockstruct.arrays import ROUNDING
from blockstruct.errors import ModelError
from blockstruct.model.fields import (
    LEFT_OUT,
    ModelObject,
    has_name,
    is_truth,
    items,
    label,
    named_arguments,
    scalar,
    store,
)
from blockstruct.structures.bond import Bond, Panel
from blockstruct.structures.builder import LENGTH, count, length, optional_length
from blockstruct.structures.openings import QUARTER, AnyOpening, check_openings
from blockstruct.structures.rubble import RubbleJoints


@frozen(repr=False, field_transformer=named_arguments)
class Sidewall(ModelObject):
    """A wall along +y at the back of a wall along x.

    Parameters
    ----------
    name
        Prefix of its units.
    at : quantity, length
        Start of its thickness along the wall: zero for a return at the left end, length minus thickness of the wall for
        a return at the right end (L), a value in between for a T.
    length : quantity, length
        Length from the back of the wall.
    openings
        Openings; their ``start`` is measured from the back of the wall.
    bonded
        Whether every second course extends through the wall to its face. Otherwise the sidewall butts against the wall.
    """

    behind: ClassVar[bool] = True

    name: str = field(validator=has_name)
    at: float = field(converter=scalar, metadata=LENGTH)
    length: float = field(converter=length, metadata=LENGTH)
    openings: tuple[AnyOpening, ...] = field(default=(), converter=items, metadata={"kind": AnyOpening})
    bonded: bool = field(default=True, validator=is_truth)

    def width_in(self, wall: Bond) -> float:
        """Return the width along a wall, which is its thickness, m."""
        return wall.thickness

    def panel(self, wall: Bond, heads: Sequence[float], rubble: RubbleJoints | None) -> Panel:
        """Return the panel of the sidewall, from the back of a wall with courses up to ``heads``."""
        name, t = f"{self.name}.", wall.thickness
        axes = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [self.at, t, 0.0]])
        extent, openings = (0.0, self.length), self.openings
        if not self.bonded:
            return Panel(name, wall, axes, heads, extent, openings, rubble=rubble)
        # A whole unit starts at the face of the wall, or half a unit from the face if a joint would otherwise be near
        # the back. A unit then joins both walls.
        beyond = t / wall.unit_length - np.floor(t / wall.unit_length)
        origin = -t if QUARTER <= beyond <= 1 - QUARTER else -t + wall.unit_length / 2
        return Panel(name, wall, axes, heads, extent, openings, back=t, origin=origin, shifts_odd=True, rubble=rubble)


@frozen(repr=False, field_transformer=named_arguments)
class Buttress(ModelObject):
    """A pier in front of or at the back of a wall along x, vertical or battered.

    Parameters
    ----------
    name
        Prefix of its units.
    at, width : quantity, length
        Start along the wall, and width.
    courses
        Number of courses.
    projection : quantity, length
        Projection from the wall at the foot.
    top_projection : quantity, length
        Projection at the top; equal to ``projection`` by default. The outer face is plane.
    behind
        True: at the back of the wall (+y). False: in front of its face (−y).
    bonded
        Whether every second course extends through the wall. Otherwise the buttress butts against the wall.
    """

    name: str = field(validator=has_name)
    at: float = field(converter=scalar, metadata=LENGTH)
    width: float = field(converter=length, metadata=LENGTH)
    courses: int = field(converter=count, metadata={"least": 1})
    projection: float = field(converter=length, metadata=LENGTH)
    top_projection: float = field(default=LEFT_OUT, converter=optional_length, metadata=LENGTH)
    behind: bool = field(default=False, validator=is_truth)
    bonded: bool = field(default=True, validator=is_truth)

    def __attrs_post_init__(self) -> None:
        if self.top_projection is None:
            store(self, top_projection=self.projection)
        if self.top_projection > self.projection * (1 + ROUNDING):
            msg = (
                f"{label(self)}: top_projection {self.top_projection:.6g} m is beyond the projection at the foot, "
                f"{self.projection:.6g} m; give at most that"
            )
            raise ModelError(msg)

    @property
    def length(self) -> float:
        """Largest projection from the wall, m."""
        return self.projection

    def width_in(self, wall: Bond) -> float:
        """Return the width along a wall, m."""
        return self.width

    def panel(self, wall: Bond, heads: Sequence[float], rubble: RubbleJoints | None) -> Panel:
        """Return the panel of the buttress, from the face or the back of a wall with courses up to ``heads``."""
        outwards, foot = (1.0, wall.thickness) if self.behind else (-1.0, 0.0)
        height = self.courses * wall.course_height
        # In courses that extend through the wall, half of a unit is in the wall.
        back = -wall.thickness
        slope = [(back, 0.0), (self.projection, 0.0), (self.top_projection, height), (back, height)]
        return Panel(
            name=f"{self.name}.",
            bond=Bond(wall.unit_length, wall.course_height, self.width),
            axes=np.array([[0.0, outwards, 0.0], [1.0, 0.0, 0.0], [self.at, foot, 0.0]]),
            heads=heads[: self.courses],
            extent=(0.0, self.projection),
            back=wall.thickness if self.bonded else 0.0,
            within=shapely.Polygon(slope),
            rubble=rubble,
        )


Side = Sidewall | Buttress


def check_sides(sides: Sequence[Side], openings: Sequence[AnyOpening], end: float, courses: int, wall: Bond) -> None:
    """Refuse sidewalls and buttresses off the wall or too high, or that overlap each other or an opening."""
    slack = ROUNDING * wall.thickness
    for k, side in enumerate(sides):
        width, place = side.width_in(wall), "at the back of" if side.behind else "in front of"
        who = f"wall: {label(side)} at {side.at:.6g} m"
        if not -slack <= side.at <= end - width + slack:
            msg = f"{who} is not {place} the wall; give a position between 0 m and {end - width:.6g} m"
            raise ModelError(msg)
        for other in sides[:k]:
            beyond = other.at + other.width_in(wall)
            if side.name == other.name or (side.at < beyond - slack and other.at < side.at + width - slack):
                msg = f"{who} has the name or the position of {other.name!r} at {other.at:.6g} m; rename or move it"
                raise ModelError(msg)
        for opening in openings:
            low, _, high, _ = opening.outline(wall.course_height).bounds
            if low < side.at + width - slack and side.at < high - slack:
                msg = f"{who} is {place} the opening at {opening.start:.6g} m; move one of them"
                raise ModelError(msg)
        if isinstance(side, Sidewall):
            check_openings(side.openings, side.length, wall.course_height, courses, label(side))
        elif side.courses > courses:
            msg = f"{who} has {side.courses} courses, the wall {courses}; give at most as many as the wall has"
            raise ModelError(msg)


def gable_levels(length: float, foot: float, rise: float, course: float, smallest: float) -> list[float]:
    """Return the upper sides of the courses of a gable; the last is the apex.

    A piece smaller than the ``smallest`` area at the apex is joined to the course below.
    """
    # The triangle above z has the area (apex − z)² L / (2 rise).
    tip = float(np.sqrt(2 * rise * smallest / length))
    number = max(1, int(np.floor((rise - tip) / course * (1 + ROUNDING))) + 1)
    return [*(foot + k * course for k in range(1, number)), foot + rise]
