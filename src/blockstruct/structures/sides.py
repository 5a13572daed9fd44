"""What stands behind or before a wall: sidewalls and buttresses."""

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
    """A wall that runs along +y, from behind the wall along x.

    Parameters
    ----------
    name
        Prefix of its units.
    at : quantity, length
        Where its thickness begins along the wall; zero for a return at the left end, the length of the wall less its
        depth for one at the right end (L), anything between for a T.
    length : quantity, length
        From the back of the wall.
    openings
        Openings, with ``start`` counted from the back of the wall.
    bonded
        Whether every other course runs through the wall to its face; else the sidewall butts against it.
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
    """A pier against the wall along x, before its face or behind it, upright or battered.

    Parameters
    ----------
    name
        Prefix of its units.
    at, width : quantity, length
        Where it begins along the wall, and its width.
    courses
        Number of its courses.
    projection : quantity, length
        From the wall, at the foot.
    top_projection : quantity, length
        On top; that at the foot by default. The outer face is plane.
    behind
        Whether it stands behind the wall (+y) and not before its face (−y).
    bonded
        Whether every other course runs through the wall; else the buttress butts against it.
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
        """Farthest from the wall, m."""
        return float(self.projection)

    def outline(self, depth: float, course_height: float) -> Any:
        """Polygon along its length from the wall, and up, with the part of bonded courses within a wall of a depth."""
        height = self.courses * course_height
        corners = [(-depth, 0.0), (self.projection, 0.0), (self.top_projection, height), (-depth, height)]
        return shapely.Polygon(corners)


Side = Sidewall | Buttress


def check_sides(
    sides: Sequence[Side], openings: Sequence[AnyOpening], length: float, depth: float, course_height: float
) -> None:
    """Refuse sidewalls and buttresses that are not at the wall, or in the place of each other or of an opening."""
    slack = 1e-9 * depth
    for k, side in enumerate(sides):
        width = depth if isinstance(side, Sidewall) else side.width
        what = "sidewall" if isinstance(side, Sidewall) else "buttress"
        who = f"wall: {what} {side.name!r} at {side.at:.6g} m"
        if not -slack <= side.at <= length - width + slack:
            msg = f"{who} is not {_place(side)} the wall; give a place between 0 m and {length - width:.6g} m"
            raise ModelError(msg)
        for other in sides[:k]:
            beyond = other.at + (depth if isinstance(other, Sidewall) else other.width)
            if side.name == other.name or (side.at < beyond - slack and other.at < side.at + width - slack):
                msg = f"{who} has the name or the place of another at {other.at:.6g} m; rename or move it"
                raise ModelError(msg)
        for opening in openings:
            low, _, high, _ = opening.outline(course_height).bounds
            if low < side.at + width - slack and side.at < high - slack:
                msg = f"{who} stands {_place(side)} the opening at {opening.start:.6g} m; move one of them"
                raise ModelError(msg)


def _place(side: Side) -> str:
    return "behind" if isinstance(side, Sidewall) or side.behind else "before"


def gable_levels(length: float, foot: float, rise: float, course: float, smallest: float) -> list[float]:
    """Upper sides of the courses of a gable; that of the last is the apex.

    What would be less than the ``smallest`` area at the apex belongs to the course below it.
    """
    # The triangle above z has the area (apex − z)² L / (2 rise).
    tip = float(np.sqrt(2 * rise * smallest / length))
    number = max(1, int(np.floor((rise - tip) / course * (1 + 1e-9))) + 1)
    return [*(foot + k * course for k in range(1, number)), foot + rise]
