"""Material of joints."""

import math
from dataclasses import dataclass
from typing import Any

from blockstruct.errors import ModelError
from blockstruct.keywords import checked_keywords
from blockstruct.model.names import checked_name
from blockstruct.units import si, to_quantity

#: Friction coefficient beyond which a number is taken for an angle by mistake.
LARGEST_FRICTION = 10.0


@checked_keywords
@dataclass(frozen=True, slots=True, init=False)
class JointMaterial:
    """Strength of the joints between blocks: Coulomb friction, cohesion, tension and compression.

    Parameters
    ----------
    name
        Unique among the joint materials of a model.
    friction_coefficient : float or dimensionless quantity
        Tangent of the friction angle.
    friction_angle : quantity, angle
        Instead of the friction coefficient.
    dilatancy_angle : quantity, angle
        Between zero (sliding does not open the joint, the default) and the friction angle. It counts in
        cases with ``flow="nonassociative"``; associative flow dilates by the friction angle.
    cohesion, tensile_strength : quantity, stress
        Zero by default.
    compressive_strength : quantity, stress
        Infinite by default.

    Attributes
    ----------
    friction_coefficient : float
    dilatancy_angle : float
        Radians.
    cohesion, tensile_strength, compressive_strength : float
        Pa.

    Raises
    ------
    ModelError
        Neither or both of friction coefficient and angle; a value outside its range.
    UnitError, DimensionError
        A bare number where a unit is due, or a quantity of another dimension.

    Examples
    --------
    >>> JointMaterial("dry", friction_angle="45 deg").friction_coefficient
    0.9999999999999999
    """

    name: str
    friction_coefficient: float
    dilatancy_angle: float
    cohesion: float
    tensile_strength: float
    compressive_strength: float

    def __init__(
        self,
        name: str,
        friction_coefficient: Any = None,
        *,
        friction_angle: Any = None,
        dilatancy_angle: Any = "0 deg",
        cohesion: Any = "0 Pa",
        tensile_strength: Any = "0 Pa",
        compressive_strength: Any = None,
    ) -> None:
        checked_name(name, "joint material")
        who = f"joint material {name!r}"
        if (friction_coefficient is None) == (friction_angle is None):
            msg = f"{who}: give either friction_coefficient or friction_angle"
            raise ModelError(msg)
        if friction_angle is not None:
            mu = math.tan(_angle(friction_angle, f"{who}: friction angle"))
        else:
            mu = si(friction_coefficient, "dimensionless", f"{who}: friction coefficient")
        psi = _angle(dilatancy_angle, f"{who}: dilatancy angle")
        c = si(cohesion, "stress", f"{who}: cohesion")
        ft = si(tensile_strength, "stress", f"{who}: tensile strength")
        fc = math.inf
        if compressive_strength is not None:
            fc = si(compressive_strength, "stress", f"{who}: compressive strength")
        for what, value in (("friction coefficient", mu), ("cohesion", c), ("tensile strength", ft)):
            if value < 0:
                msg = f"{who}: {what} {value:.6g} is negative; give zero or more"
                raise ModelError(msg)
        if mu > LARGEST_FRICTION:
            msg = (
                f"{who}: friction coefficient {mu:.6g} exceeds {LARGEST_FRICTION:g}; "
                "give the tangent of the friction angle, or friction_angle with its unit"
            )
            raise ModelError(msg)
        if fc <= 0:
            msg = f"{who}: compressive strength {fc:.6g} Pa; give more than zero, or leave it out for infinite"
            raise ModelError(msg)
        if mu * ft > c * (1 + 1e-12):
            msg = (
                f"{who}: tensile strength {ft:.6g} Pa exceeds cohesion / friction coefficient, {c / mu:.6g} Pa, where "
                "the friction cone ends; raise the cohesion or lower the tensile strength"
            )
            raise ModelError(msg)
        if math.tan(psi) > mu * (1 + 1e-12):
            msg = (
                f"{who}: tangent of the dilatancy angle {math.tan(psi):.6g} exceeds the friction coefficient {mu:.6g}; "
                "give a dilatancy angle between zero and the friction angle"
            )
            raise ModelError(msg)
        values: tuple[object, ...] = (name, mu, psi, c, ft, fc)
        for attribute, field in zip(self.__slots__, values, strict=True):
            object.__setattr__(self, attribute, field)

    def varied(self, **values: Any) -> "JointMaterial":
        """The same joint with other values, given as to the constructor.

        >>> JointMaterial("lime", 0.6, cohesion="50 kPa").varied(compressive_strength="4 MPa").cohesion
        50000.0
        """
        own: dict[str, Any] = {
            "friction_coefficient": self.friction_coefficient,
            "dilatancy_angle": to_quantity(self.dilatancy_angle, "angle"),
            "cohesion": to_quantity(self.cohesion, "stress"),
            "tensile_strength": to_quantity(self.tensile_strength, "stress"),
            "compressive_strength": None,
        }
        if math.isfinite(self.compressive_strength):
            own["compressive_strength"] = to_quantity(self.compressive_strength, "stress")
        if "friction_angle" in values:
            del own["friction_coefficient"]
        return type(self)(self.name, **(own | values))

    @property
    def dilatancy(self) -> float:
        """Tangent of the dilatancy angle."""
        return math.tan(self.dilatancy_angle)


def _angle(value: Any, what: str) -> float:
    angle = float(si(value, "angle", what))
    if not 0 <= angle < math.pi / 2:
        msg = f"{what}: {math.degrees(angle):.6g} degrees; give an angle from 0 up to, but not including, 90 degrees"
        raise ModelError(msg)
    return angle
