"""Positions of the joints of an arch in its plane."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.geometry.tolerances import ROUNDING
from blockstruct.model.checks import SHORTEST, checked_count, positive_length
from blockstruct.units import QuantityLike, si

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ArchProfile:
    """Joints of an arch in the plane (x, z): x from the middle of the span, z from the springing line, m.

    Attributes
    ----------
    inner, outer : (n + 1, 2) arrays
        Ends of the joints on the intrados and on the extrados, from left to right.
    """

    inner: Array
    outer: Array

    @classmethod
    def of(
        cls,
        span: QuantityLike,
        thickness: QuantityLike,
        voussoirs: Any,
        rise: QuantityLike | None = None,
        skewback: QuantityLike = "20 deg",
        who: str = "arch",
    ) -> "ArchProfile":
        """Return the profile with a rise of the intrados over its span.

        Half the span (the default) gives a semicircular profile, less a segmental profile. More gives a pointed profile
        of two arcs with centres on the springing line; it has a joint at the crown and an even number of voussoirs.
        Zero gives a flat profile, whose joints meet in one point.

        Parameters
        ----------
        span, thickness : quantity, length
            Clear span and thickness of the ring.
        voussoirs
            Number of wedges with straight sides and corners on the intrados and the extrados.
        rise : quantity, length
            Rise of the intrados over the springing line.
        skewback : quantity, angle
            Angle between the vertical and the end joints of a flat arch.
        who
            Name of the builder in error messages.
        """
        s, t = positive_length(span, f"{who}: span"), positive_length(thickness, f"{who}: thickness")
        n = checked_count(voussoirs, 2, f"{who}: voussoirs")
        f = s / 2 if rise is None else si(rise, "length", f"{who}: rise")
        if f < 0 or 0 < f < SHORTEST:
            msg = f"{who}: rise {f:.6g} m; give zero (flat) or a length of at least {SHORTEST:g} m"
            raise ModelError(msg)
        if f == 0:
            angle = si(skewback, "angle", f"{who}: skewback")
            if not 0 < angle < math.pi / 3:
                msg = f"{who}: skewback {math.degrees(angle):.4g} deg; give an angle between 0 and 60 deg"
                raise ModelError(msg)
            x = np.linspace(-s / 2, s / 2, n + 1)
            # All joints point to one point, (s/2) / tan(skewback) below the middle.
            spread = 1 + t / (s / 2 / math.tan(angle))
            return cls(_points(x, 0 * x), _points(x * spread, 0 * x + t))
        if f <= s / 2 * (1 + ROUNDING):
            radius = (s**2 / 4 + f**2) / (2 * f)
            half = math.pi / 2 if rise is None else math.asin(min(1.0, s / 2 / radius))
            angle_of = np.linspace(-half, half, n + 1)
            direction = _points(np.sin(angle_of), np.cos(angle_of))
            centre = np.array([0.0, f - radius])
            return cls(centre + radius * direction, centre + (radius + t) * direction)
        if n % 2:
            msg = f"{who}: {n} voussoirs; a pointed arch has a joint at the crown, give an even number"
            raise ModelError(msg)
        inner, outer = half_profile(s, f, t, n // 2)
        outer[-1] = 0.0, math.sqrt((pointed_radius(s, f) + t) ** 2 - (pointed_radius(s, f) - s / 2) ** 2)
        mirror = np.array([-1.0, 1.0])
        return cls(np.concatenate([inner * mirror, inner[-2::-1]]), np.concatenate([outer * mirror, outer[-2::-1]]))


def pointed_radius(span: float, rise: float) -> float:
    """Return the radius of the arc from the springing to the crown with its centre on the springing line, m."""
    return (rise**2 + span**2 / 4) / span


def half_profile(span: float, rise: float, thickness: float, parts: int, opening: float = 0.0) -> tuple[Array, Array]:
    """Return the radial joints of the right half of a semicircular or pointed profile.

    The joints run from the springing to the point of the intrados at half an ``opening`` from the axis. All lengths are
    in m. The result is the ends of the joints on the intrados and on the extrados, each of shape (parts + 1, 2).
    """
    radius = pointed_radius(span, rise)
    centre = np.array([span / 2 - radius, 0.0])
    angle = np.linspace(0.0, math.acos((opening / 2 - centre[0]) / radius), parts + 1)
    direction = _points(np.cos(angle), np.sin(angle))
    return centre + radius * direction, centre + (radius + thickness) * direction


def _points(x: Array, z: Array) -> Array:
    return np.column_stack([x, z])
