"""Material of joints."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Self

from blockstruct.errors import ModelError, shown
from blockstruct.model.checks import checked_name, checked_source
from blockstruct.units import QuantityLike, si, symbol, to_quantity
from blockstruct.vocabulary import Torsion


@dataclass(frozen=True, slots=True)
class JointProperty:
    """A property of joints: what documents, files, reports and studies need to know of it.

    Parameters
    ----------
    dimension
        A key of :data:`blockstruct.units.SI_UNITS`.
    absent
        SI value of a joint that was given none; None if it must be given.
    """

    dimension: str
    absent: float | None


#: The one table of joint properties, in the order of their columns.
JOINT_PROPERTIES: Mapping[str, JointProperty] = MappingProxyType(
    {
        "friction_coefficient": JointProperty("dimensionless", None),
        "dilatancy_angle": JointProperty("angle", 0.0),
        "cohesion": JointProperty("stress", 0.0),
        "tensile_strength": JointProperty("stress", 0.0),
        "compressive_strength": JointProperty("stress", math.inf),
        "normal_stiffness": JointProperty("stress/length", math.inf),
        "shear_stiffness": JointProperty("stress/length", math.inf),
    }
)

#: Friction coefficient beyond which a number is taken for an angle by mistake.
LARGEST_FRICTION = 10.0


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
    normal_stiffness, shear_stiffness : quantity, stress per length
        Of the joint before it opens or slides, per area. Infinite by default: joints are rigid.
    torsion
        ``"corners"`` (the default): friction at the contact points alone limits the torque about the normal, up to 1.85
        times that of a square under uniform pressure. ``"uniform pressure"``: the shear force V and the torque T about
        the centroid also keep ``V² + (T / r̄)² ≤ R²``, with R the sliding resistance and r̄ the mean distance of the
        area from its centroid.
    source
        Where the values come from, as :mod:`blockstruct.library` says it: stored and printed with the material.

    Attributes
    ----------
    friction_coefficient : float
    dilatancy_angle : float
        Radians.
    cohesion, tensile_strength, compressive_strength : float
        Pa.
    normal_stiffness, shear_stiffness : float
        Pa/m.

    Raises
    ------
    ModelError
        If neither or both of friction coefficient and angle are given, or a value is outside its range.
    UnitError, DimensionError
        If a bare number is given where a unit is needed, or a quantity of another dimension.

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
    normal_stiffness: float
    shear_stiffness: float
    torsion: Torsion
    source: str

    def __init__(
        self,
        name: str,
        friction_coefficient: Any = None,
        *,
        friction_angle: QuantityLike | None = None,
        dilatancy_angle: QuantityLike = "0 deg",
        cohesion: QuantityLike = "0 Pa",
        tensile_strength: QuantityLike = "0 Pa",
        compressive_strength: QuantityLike | None = None,
        normal_stiffness: QuantityLike | None = None,
        shear_stiffness: QuantityLike | None = None,
        torsion: Torsion | str = Torsion.CORNERS,
        source: str = "",
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
        fc = _or_infinite(compressive_strength, "stress", f"{who}: compressive strength")
        kn = _or_infinite(normal_stiffness, "stress/length", f"{who}: normal stiffness")
        kt = _or_infinite(shear_stiffness, "stress/length", f"{who}: shear stiffness")
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
        try:
            torsion = Torsion(torsion)
        except (ValueError, TypeError, RecursionError):
            msg = f"{who}: torsion {shown(torsion)}; give one of {', '.join(map(repr, map(str, Torsion)))}"
            raise ModelError(msg) from None
        values: tuple[object, ...] = (name, mu, psi, c, ft, fc, kn, kt, torsion, checked_source(source, who))
        for attribute, field in zip(self.__slots__, values, strict=True):
            object.__setattr__(self, attribute, field)

    def varied(self, **values: Any) -> "JointMaterial":
        """The same joint with other values, given as to the constructor; its source says which were changed.

        >>> JointMaterial("lime", 0.6, cohesion="50 kPa").varied(compressive_strength="4 MPa").cohesion
        50000.0
        """
        own = _quantities({name: getattr(self, name) for name in JOINT_PROPERTIES})
        if "friction_angle" in values:
            del own["friction_coefficient"]
        if self.source and values and "source" not in values:
            own["source"] = f"{self.source}; then changed: {', '.join(values)}"
        return type(self)(self.name, **({"torsion": self.torsion, "source": self.source} | own | values))

    @classmethod
    def from_si(cls, name: str, values: Mapping[str, float], torsion: str = Torsion.CORNERS, source: str = "") -> Self:
        """Joint material of the properties of :data:`JOINT_PROPERTIES` in SI floats."""
        return cls(name, **_quantities(values), torsion=torsion, source=source)

    def __str__(self) -> str:
        given = {n: getattr(self, n) for n, p in JOINT_PROPERTIES.items() if getattr(self, n) != p.absent}
        said = ", ".join(f"{n.replace('_', ' ')} {_readable(v, JOINT_PROPERTIES[n])}" for n, v in given.items())
        return said if self.torsion is Torsion.CORNERS else f"{said}, torsion of {self.torsion}"

    @property
    def dilatancy(self) -> float:
        """Tangent of the dilatancy angle."""
        return math.tan(self.dilatancy_angle)


def _readable(value: float, of: JointProperty) -> str:
    if of.dimension == "angle":
        return f"{math.degrees(value):.4g}°"
    return f"{to_quantity(value, of.dimension).to_compact():.4g~P}".strip()


def _quantities(values: Mapping[str, float]) -> dict[str, Any]:
    """Quantities of those properties that were given."""
    return {
        name: to_quantity(value, JOINT_PROPERTIES[name].dimension)
        for name, value in values.items()
        if value != JOINT_PROPERTIES[name].absent
    }


def _or_infinite(value: Any, dimension: str, what: str) -> float:
    found = math.inf if value is None else si(value, dimension, what)
    if found <= 0:
        msg = f"{what} {found:.6g} {symbol(dimension)}; give more than zero, or leave it out for infinite"
        raise ModelError(msg)
    return found


def _angle(value: Any, what: str) -> float:
    angle = float(si(value, "angle", what))
    if not 0 <= angle < math.pi / 2:
        msg = f"{what}: {math.degrees(angle):.6g} degrees; give an angle from 0 up to, but not including, 90 degrees"
        raise ModelError(msg)
    return angle
