"""Openings in walls: rectangular, arched and round."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from attrs import field, frozen

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array
from blockstruct.errors import ModelError, shown
from blockstruct.model.fields import LENGTH, ModelObject, named_arguments, not_negative, optional_scalar, scalar
from blockstruct.structures.builder import count, length, optional_count, optional_length
from blockstruct.structures.vaults import ArchProfile
from blockstruct.units import si, to_quantity
from blockstruct.vocabulary import counted

#: Smallest part of a unit or of a course that is left between a joint and an end, an opening or a ring.
QUARTER = 0.25


@frozen(repr=False, field_transformer=named_arguments)
class Opening(ModelObject):
    """A rectangular opening through a wall, with a lintel or an arch of voussoirs.

    Parameters
    ----------
    start, sill : quantity, length
        Start along the wall, and height over the foot of the wall.
    width, height : quantity, length
        Clear size. The height extends to the head or, below an arch, to the springing. Sill and head lie on bed joints.
    bearing : quantity, length
        Length of the lintel, one unit in the course above, in the wall on each side; half a unit of the wall by
        default. Zero means no lintel: the bond continues over the opening.
    rise : quantity, length
        Rise of the intrados of an arch over the head: half the width for a round arch, less for a segmental arch, more
        for a pointed arch. Without a rise there is no arch.
    ring : quantity, length
        Thickness of the arch. The voussoirs extend through the wall.
    voussoirs
        Number of voussoirs.

    Attributes
    ----------
    start, sill, width, height : float
        m.
    bearing, rise, ring : float or None
        m.

    Raises
    ------
    ModelError
        If a size is not above zero, or a position or bearing is below zero. If an arch lacks its ring or voussoirs, has
        a bearing, or has no rise.
    """

    start: float = field(converter=scalar, validator=not_negative, metadata=LENGTH)
    sill: float = field(converter=scalar, validator=not_negative, metadata=LENGTH)
    width: float = field(converter=length, metadata=LENGTH)
    height: float = field(converter=length, metadata=LENGTH)
    bearing: float | None = field(default=None, converter=optional_scalar, validator=not_negative, metadata=LENGTH)
    rise: float | None = field(default=None, converter=optional_length, metadata=LENGTH)
    ring: float | None = field(default=None, converter=optional_length, metadata=LENGTH)
    voussoirs: int | None = field(default=None, converter=optional_count, metadata={"least": 2})

    def __attrs_post_init__(self) -> None:
        arch = ("rise", "ring", "voussoirs")
        missing = [name for name in arch if getattr(self, name) is None]
        if len(missing) == len(arch):
            return
        if missing or self.bearing is not None:
            problem = f"an arch needs {' and '.join(missing)}" if missing else "an arch has no bearing"
            msg = f"Opening: {problem}; give rise, ring and voussoirs for an arch, or only a bearing for a lintel"
            raise ModelError(msg)
        ArchProfile.of(*self._profile(), who="Opening")

    def _profile(self) -> tuple[Any, Any, Any, Any]:
        width, ring, rise = (to_quantity(v, "length") for v in (self.width, self.ring, self.rise))
        return width, ring, self.voussoirs, rise

    @property
    def end(self) -> float:
        """End along the wall, m."""
        return self.start + self.width

    def voussoir_outlines(self, course_height: float) -> list[Array]:
        """Return the outlines (4, 2) of the voussoirs along and up the wall, from left to right, m.

        The list is empty without an arch. A keystone extends to a bed joint less than a quarter of a course above it.
        """
        if self.rise is None:
            return []
        profile = ArchProfile.of(*self._profile())
        shift = np.array([self.start + self.width / 2, self.sill + self.height])
        inner, outer = profile.inner + shift, profile.outer + shift
        ring = [np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]]) for k in range(len(inner) - 1)]
        return _levelled(_with_keystone(ring, len(ring) // 2, 1.0, course_height), course_height)

    def outline(self, course_height: float) -> Any:
        """Return the polygon of the opening and its arch, along and up the wall."""
        left, right, foot, head = self.start, self.end, self.sill, self.sill + self.height
        ring = self.voussoir_outlines(course_height)
        if not ring:
            return shapely.box(left, foot, right, head)
        extrados = [corner for outline in ring for corner in outline[1:3]]
        corners = np.array([(left, foot), (right, foot), (right, head), *extrados[::-1], (left, head)])
        return shapely.Polygon(*_levelled([corners], course_height))

    def courses(self, course_height: float) -> tuple[int, int]:
        """Return the first course that the opening cuts, and the first course above its head."""
        return round(self.sill / course_height), round((self.sill + self.height) / course_height)


def _centre(value: Any, dimension: str = "", what: str = "") -> tuple[float, float]:
    try:
        u, z = value
    except (TypeError, ValueError):
        msg = f"{what} is {shown(value)}; give two lengths, along the wall and over its foot"
        raise ModelError(msg) from None
    return si(u, dimension, what), si(z, dimension, what)


@frozen(repr=False, field_transformer=named_arguments)
class RoundOpening(ModelObject):
    """A round opening through a wall, in a ring of voussoirs with straight sides, one voussoir at the top.

    Parameters
    ----------
    centre : quantity, length, two components
        Position along the wall, and height over its foot.
    diameter : quantity, length
        Clear diameter: the circle through the inner corners of the voussoirs.
    ring : quantity, length
        Thickness of the ring.
    voussoirs
        Number of voussoirs, at least 6.

    Attributes
    ----------
    centre : (float, float)
        m.
    diameter, ring : float
        m.

    Raises
    ------
    ModelError
        If a size is not above zero, or there are fewer than 6 voussoirs.
    """

    centre: tuple[float, float] = field(converter=_centre, metadata=LENGTH)
    diameter: float = field(converter=length, metadata=LENGTH)
    ring: float = field(converter=length, metadata=LENGTH)
    voussoirs: int = field(converter=count, metadata={"least": 6})

    @property
    def start(self) -> float:
        """Start along the wall, m."""
        return self.centre[0] - self.diameter / 2

    @property
    def end(self) -> float:
        """End along the wall, m."""
        return self.centre[0] + self.diameter / 2

    def voussoir_outlines(self, course_height: float) -> list[Array]:
        """Return the outlines (4, 2) of the voussoirs along and up the wall, clockwise from the top, m.

        The voussoirs at the top and at the bottom extend to bed joints less than a quarter of a course away.
        """
        n = self.voussoirs
        angle = np.pi / 2 + (0.5 - np.arange(n + 1)) * 2 * np.pi / n
        circle = np.column_stack([np.cos(angle), np.sin(angle)])
        circle[-1] = circle[0]
        inner, outer = (np.array(self.centre) + r * circle for r in (self.diameter / 2, self.diameter / 2 + self.ring))
        ring = [np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]]) for k in range(n)]
        crowned = _with_keystone(ring, 0, 1.0, course_height)
        return _levelled(_with_keystone(crowned, n // 2, -1.0, course_height), course_height)

    def outline(self, course_height: float) -> Any:
        """Return the polygon of the opening and its ring, along and up the wall."""
        return shapely.Polygon([corner for outline in self.voussoir_outlines(course_height) for corner in outline[1:3]])


AnyOpening = Opening | RoundOpening


def check_openings(
    openings: Sequence[AnyOpening], end: float, course_height: float, courses: int, who: str, within: Any = None
) -> None:
    """Refuse openings outside the wall, off the bed joints, or that overlap.

    ``within`` is the polygon of the wall if it is not a rectangle.
    """
    top = courses * course_height
    for k, opening in enumerate(openings, start=1):
        what = f"{who}: opening {k} at {opening.start:.6g} m"
        if opening.end > end * (1 + ROUNDING):
            msg = f"{what} ends at {opening.end:.6g} m, beyond the wall of {end:.6g} m; move it or make it narrower"
            raise ModelError(msg)
        if isinstance(opening, Opening):
            _check_levels(opening, course_height, courses, what)
        if opening.voussoirs is not None:
            _check_ring(opening, within or shapely.box(0.0, 0.0, end, top), course_height, what)
        for other in openings[: k - 1]:
            shared = opening.outline(course_height).intersection(other.outline(course_height))
            if shared.area > NEGLIGIBLE * course_height**2:
                msg = f"{what} overlaps the opening at {other.start:.6g} m; move one of them"
                raise ModelError(msg)


def _check_levels(opening: Opening, course_height: float, courses: int, what: str) -> None:
    head, top = opening.sill + opening.height, courses * course_height
    if head > top * (1 + NEGLIGIBLE):
        msg = (
            f"{what}: its head at {head:.6g} m exceeds the height of the wall, {top:.6g} m in "
            f"{counted(courses, 'course')}; make the opening lower or the wall higher"
        )
        raise ModelError(msg)
    for name, z in (("sill", opening.sill), ("head", head)):
        if abs(z / course_height - round(z / course_height)) > NEGLIGIBLE:
            nearest = round(z / course_height) * course_height
            msg = (
                f"{what}: {name} at {z:.6g} m is not on a bed joint of {counted(courses, 'course')} of "
                f"{course_height:.6g} m; the nearest is at {nearest:.6g} m"
            )
            raise ModelError(msg)


def _check_ring(opening: AnyOpening, wall: Any, course_height: float, what: str) -> None:
    outline = opening.outline(course_height)
    beyond = outline.difference(wall).area
    if beyond > NEGLIGIBLE * course_height**2:
        low, foot, high, crown = outline.bounds
        msg = (
            f"{what}: with its ring it extends from {low:.6g} to {high:.6g} m along the wall and from {foot:.6g} to "
            f"{crown:.6g} m up, beyond the wall; move it or make it smaller"
        )
        raise ModelError(msg)
    ends = {"crown": (outline.bounds[3], 1.0)}
    if isinstance(opening, RoundOpening):
        ends["foot"] = (outline.bounds[1], -1.0)
    for name, (z, sense) in ends.items():
        left = _to_joint(z, sense, course_height)
        if NEGLIGIBLE < left < QUARTER:
            msg = (
                f"{what}: the {name} of its ring at {z:.6g} m leaves {left:.1%} of a course to the bed joint at "
                f"{z + sense * left * course_height:.6g} m; give it a keystone (for an arch, an odd number of "
                "voussoirs), or change the ring so that a quarter of a course is left"
            )
            raise ModelError(msg)


def _to_joint(z: float, sense: float, course_height: float) -> float:
    """Return the distance up (sense 1) or down (sense −1) to the next bed joint, in courses; zero on a bed joint."""
    at = sense * z / course_height
    return max(float(np.ceil(at - NEGLIGIBLE) - at), 0.0)


def _with_keystone(ring: list[Array], k: int, sense: float, course_height: float) -> list[Array]:
    """Return the ring with its k-th voussoir extended to a near bed joint, if its back is level."""
    inner, back = ring[k][[0, 3]], ring[k][1:3]
    gap = _to_joint(float(back[0, 1]), sense, course_height)
    if abs(back[0, 1] - back[1, 1]) > NEGLIGIBLE * course_height or not gap < QUARTER:
        return ring
    along = back - inner
    joint = back[0, 1] + sense * gap * course_height
    raised = inner + along * ((joint - inner[:, 1]) / along[:, 1])[:, None]
    stone = np.array([inner[0], *raised, inner[1]])
    return [*ring[:k], stone, *ring[k + 1 :]]


def _levelled(outlines: Sequence[Array], course_height: float) -> list[Array]:
    """Return the outlines with corners near a bed joint moved to its height.

    Otherwise rounding would join the units on both sides of a keystone above or below it.
    """
    levelled = []
    for outline in outlines:
        u, z = outline.T
        joint = np.round(z / course_height) * course_height
        levelled.append(np.column_stack([u, np.where(np.abs(z - joint) <= NEGLIGIBLE * course_height, joint, z)]))
    return levelled
