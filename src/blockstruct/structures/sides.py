"""Sidewalls and buttresses of a wall."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from blockstruct.errors import ModelError, shown
from blockstruct.model import checked_tuple
from blockstruct.model.checks import checked_count, checked_name, positive_length
from blockstruct.structures.openings import AnyOpening
from blockstruct.units import si


@dataclass(frozen=True, slots=True)
class Sidewall:
    """A wall along +y at the back of a wall along x.

    Parameters
    ----------
    name
        Prefix of its units.
    at : quantity, length
        Start of its thickness along the wall: zero for a return at the left end, length minus depth of the wall for a
        return at the right end (L), a value in between for a T.
    length : quantity, length
        Length from the back of the wall.
    openings
        Openings; their ``start`` is measured from the back of the wall.
    bonded
        Whether every second course extends through the wall to its face. Otherwise the sidewall butts against the wall.
    """

    name: str
    at: Any
    length: Any
    openings: Sequence[AnyOpening] = ()
    bonded: bool = True

    def __post_init__(self) -> None:
        who = f"sidewall {checked_name(self.name, 'sidewall')!r}"
        if not isinstance(self.bonded, bool):
            msg = f"{who}: bonded is {shown(self.bonded)}; give True or False"
            raise ModelError(msg)
        object.__setattr__(self, "at", si(self.at, "length", f"{who}: at"))
        object.__setattr__(self, "length", positive_length(self.length, f"{who}: length"))
        object.__setattr__(self, "openings", checked_tuple(self.openings, AnyOpening, f"{who}: openings"))


@dataclass(frozen=True, slots=True)
class Buttress:
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

    name: str
    at: Any
    width: Any
    courses: Any
    projection: Any
    top_projection: Any = None
    behind: bool = False
    bonded: bool = True

    def __post_init__(self) -> None:
        who = f"buttress {checked_name(self.name, 'buttress')!r}"
        for name in ("behind", "bonded"):
            if not isinstance(getattr(self, name), bool):
                msg = f"{who}: {name} is {shown(getattr(self, name))}; give True or False"
                raise ModelError(msg)
        object.__setattr__(self, "at", si(self.at, "length", f"{who}: at"))
        object.__setattr__(self, "courses", checked_count(self.courses, 1, f"{who}: courses"))
        top = self.projection if self.top_projection is None else self.top_projection
        for name, value in (("width", self.width), ("projection", self.projection), ("top_projection", top)):
            object.__setattr__(self, name, positive_length(value, f"{who}: {name}"))
        if self.top_projection > self.projection * (1 + 1e-9):
            msg = (
                f"{who}: top_projection {self.top_projection:.6g} m is beyond the projection at the foot, "
                f"{self.projection:.6g} m; give at most that"
            )
            raise ModelError(msg)

    @property
    def length(self) -> float:
        """Largest projection from the wall, m."""
        return float(self.projection)

    def outline(self, depth: float, course_height: float) -> Any:
        """Return the polygon along the projection and up, including the part of bonded courses within the wall."""
        height = self.courses * course_height
        corners = [(-depth, 0.0), (self.projection, 0.0), (self.top_projection, height), (-depth, height)]
        return shapely.Polygon(corners)


Side = Sidewall | Buttress


def check_sides(
    sides: Sequence[Side], openings: Sequence[AnyOpening], length: float, depth: float, course_height: float
) -> None:
    """Refuse sidewalls and buttresses off the wall, or that overlap each other or an opening."""
    slack = 1e-9 * depth
    for k, side in enumerate(sides):
        width = depth if isinstance(side, Sidewall) else side.width
        kind = "sidewall" if isinstance(side, Sidewall) else "buttress"
        who = f"wall: {kind} {side.name!r} at {side.at:.6g} m"
        if not -slack <= side.at <= length - width + slack:
            msg = f"{who} is not {_place(side)} the wall; give a position between 0 m and {length - width:.6g} m"
            raise ModelError(msg)
        for other in sides[:k]:
            beyond = other.at + (depth if isinstance(other, Sidewall) else other.width)
            if side.name == other.name or (side.at < beyond - slack and other.at < side.at + width - slack):
                msg = f"{who} has the name or the position of {other.name!r} at {other.at:.6g} m; rename or move it"
                raise ModelError(msg)
        for opening in openings:
            low, _, high, _ = opening.outline(course_height).bounds
            if low < side.at + width - slack and side.at < high - slack:
                msg = f"{who} is {_place(side)} the opening at {opening.start:.6g} m; move one of them"
                raise ModelError(msg)


def _place(side: Side) -> str:
    return "at the back of" if isinstance(side, Sidewall) or side.behind else "in front of"


def gable_levels(length: float, foot: float, rise: float, course: float, smallest: float) -> list[float]:
    """Return the upper sides of the courses of a gable; the last is the apex.

    A piece smaller than the ``smallest`` area at the apex is joined to the course below.
    """
    # The triangle above z has the area (apex − z)² L / (2 rise).
    tip = float(np.sqrt(2 * rise * smallest / length))
    number = max(1, int(np.floor((rise - tip) / course * (1 + 1e-9))) + 1)
    return [*(foot + k * course for k in range(1, number)), foot + rise]
