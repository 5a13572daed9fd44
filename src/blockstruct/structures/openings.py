"""Openings in walls."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from blockstruct.errors import ModelError
from blockstruct.keywords import checked_keywords
from blockstruct.model.checks import positive_length
from blockstruct.units import si

#: Deviation from a bed joint, as a part of the height of a course, that is rounding.
LEVEL = 1e-6


@checked_keywords
@dataclass(frozen=True, slots=True)
class Opening:
    """A rectangular opening through a wall.

    Parameters
    ----------
    start, sill : quantity, length
        Where it begins along the wall, and its height over the foot of the wall.
    width, height : quantity, length
        Clear size. Sill and head lie on bed joints.
    bearing : quantity, length
        How far the lintel, one unit in the course above, reaches into the wall on both sides; half a unit of the
        wall by default. Zero leaves the lintel out: the bond goes on over the opening.

    Attributes
    ----------
    start, sill, width, height : float
        m.
    bearing : float or None
        m.

    Raises
    ------
    ModelError
        If a size is not above zero, or a place or bearing below zero.
    """

    start: Any
    sill: Any
    width: Any
    height: Any
    bearing: Any = None

    def __post_init__(self) -> None:
        for name in ("start", "sill", "bearing"):
            given = getattr(self, name)
            if given is None and name == "bearing":
                continue
            value = si(given, "length", f"opening: {name}")
            if value < 0:
                msg = f"opening: {name} {value:.6g} m; give a length of zero or above"
                raise ModelError(msg)
            object.__setattr__(self, name, value)
        for name in ("width", "height"):
            object.__setattr__(self, name, positive_length(getattr(self, name), f"opening: {name}"))

    @property
    def end(self) -> float:
        """Where it ends along the wall, m."""
        return float(self.start + self.width)

    def courses(self, course_height: float) -> tuple[int, int]:
        """First course that it cuts, and first above it."""
        return round(self.sill / course_height), round((self.sill + self.height) / course_height)


def check_openings(openings: Sequence[Opening], length: float, course_height: float, courses: int, who: str) -> None:
    """Refuse openings that do not lie within a wall, between its courses and apart from each other."""
    for k, opening in enumerate(openings, start=1):
        what = f"{who}: opening {k} at {opening.start:.6g} m"
        if opening.end > length * (1 + 1e-9):
            msg = f"{what} ends at {opening.end:.6g} m, beyond the wall of {length:.6g} m; move it or make it narrower"
            raise ModelError(msg)
        head, top = opening.sill + opening.height, courses * course_height
        if head > top * (1 + LEVEL):
            msg = (
                f"{what}: its head at {head:.6g} m exceeds the height of the wall, {top:.6g} m in {courses} courses; "
                "make the opening lower or the wall higher"
            )
            raise ModelError(msg)
        for name, z in (("sill", opening.sill), ("head", head)):
            if abs(z / course_height - round(z / course_height)) > LEVEL:
                nearest = round(z / course_height) * course_height
                msg = (
                    f"{what}: {name} at {z:.6g} m is on no bed joint of {courses} courses of {course_height:.6g} m; "
                    f"the nearest is at {nearest:.6g} m"
                )
                raise ModelError(msg)
        for other in openings[: k - 1]:
            beside = opening.end <= other.start or other.end <= opening.start
            above = opening.sill >= other.sill + other.height or other.sill >= opening.sill + opening.height
            if not (beside or above):
                msg = f"{what} overlaps the one at {other.start:.6g} m; move one of them"
                raise ModelError(msg)
