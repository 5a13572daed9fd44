"""Materials of blocks and of joints."""

import math
import warnings
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Self

import attrs
from attrs import field, frozen

from blockstruct.arrays import ROUNDING
from blockstruct.errors import ModelError, UnusualValueWarning, shown
from blockstruct.model.fields import (
    NUMBER,
    UNIT_WEIGHT,
    ModelObject,
    has_name,
    has_source,
    limit,
    member,
    named_arguments,
    not_negative,
    optional_scalar,
    scalar,
)
from blockstruct.units import QuantityLike, quantity_text, si, to_quantity
from blockstruct.vocabulary import Torsion

#: Standard acceleration of free fall, m/s² (CGPM 1901).
STANDARD_GRAVITY = 9.80665
#: Usual unit weights of masonry, N/m³: from pumice and aerated blocks to lead.
USUAL_UNIT_WEIGHT = (5e3, 90e3)


@frozen(repr=False, init=False, field_transformer=named_arguments)
class Material(ModelObject):
    """Material of rigid blocks.

    Parameters
    ----------
    name
        Unique among the materials of a model.
    unit_weight : quantity, force/volume
        Weight per volume.
    density : quantity, mass/volume
        Mass per volume, instead of the unit weight. The weight is the mass times 9.80665 m/s².
    source
        Origin of the value. It is stored and printed with the material.

    Attributes
    ----------
    unit_weight : float
        N/m³.

    Raises
    ------
    ModelError
        If neither or both of unit weight and density are given, or the value is negative.
    UnitError, DimensionError
        If the value has no unit, or the unit has another dimension.

    Warns
    -----
    UnusualValueWarning
        If the unit weight is outside 5 to 90 kN/m³ and not zero.

    Examples
    --------
    >>> tuff = Material("tuff", unit_weight="12 kN/m^3")
    >>> tuff
    Material('tuff', unit_weight=12 kN/m³)
    >>> tuff.unit_weight
    12000.0
    """

    name: str = field(validator=has_name)
    unit_weight: float = field(converter=scalar, validator=not_negative, metadata=UNIT_WEIGHT)
    source: str = field(default="", validator=has_source)

    def __init__(
        self,
        name: str,
        unit_weight: QuantityLike | None = None,
        *,
        density: QuantityLike | None = None,
        source: str = "",
    ) -> None:
        if density is not None and unit_weight is None:
            mass = si(density, "density", f"material {shown(name)}: density")
            unit_weight = to_quantity(mass * STANDARD_GRAVITY, "force/volume")
        elif unit_weight is None or density is not None:
            msg = f"material {shown(name)}: give either unit_weight or density"
            raise ModelError(msg)
        self.__attrs_init__(name, unit_weight, source)
        low, high = USUAL_UNIT_WEIGHT
        if self.unit_weight and not low <= self.unit_weight <= high:
            msg = (
                f"material {name!r}: unit_weight {self.unit_weight / 1e3:.6g} kN/m³ is outside the range of masonry, "
                f"{low / 1e3:g} to {high / 1e3:g} kN/m³; check its unit"
            )
            warnings.warn(msg, UnusualValueWarning, stacklevel=2)


#: Largest friction coefficient. A larger number is probably an angle in degrees.
LARGEST_FRICTION = 10.0

_is_friction = limit(
    lambda mu: 0 <= mu <= LARGEST_FRICTION or mu == math.inf,
    f"give the tangent of the friction angle, from 0 to {LARGEST_FRICTION:g}, friction_angle with its unit, or math.inf"
    " for a joint that never slides",
)
_is_strength = limit(lambda value: value > 0, "give more than zero, or leave it out for infinite")
_is_angle = limit(lambda angle: 0 <= angle < math.pi / 2, "give an angle from 0° to less than 90°")
_STRESS, _STRENGTH = {"dimension": "stress", "absent": 0.0}, {"dimension": "stress", "absent": math.inf}
_STIFFNESS = {"dimension": "stress/length", "absent": math.inf}


def _friction(value: float | str, dimension: str = "", what: str = "") -> float:
    """Return a friction coefficient, which may be infinite; "inf" in JSON, which has no such number."""
    return math.inf if isinstance(value, float | str) and value in (math.inf, "inf") else si(value, dimension, what)


def _torsion(value: Torsion | str, what: str = "") -> Torsion:
    return member(value, Torsion, what)


@frozen(repr=False, init=False, field_transformer=named_arguments)
class JointMaterial(ModelObject):
    """Strength of the joints between blocks: Coulomb friction, cohesion, tension and compression.

    Parameters
    ----------
    name
        Unique among the joint materials of a model.
    friction_coefficient : float or dimensionless quantity
        Tangent of the friction angle. ``math.inf`` for joints that never slide (Heyman), not even where they open. They
        carry any shear force and may have a tensile strength, but no cohesion, dilatancy or limit of torsion.
    friction_angle : quantity, angle
        Instead of the friction coefficient.
    dilatancy_angle : quantity, angle
        From zero to the friction angle. Zero, the default, means that sliding does not open the joint. Cases with
        ``flow="nonassociative"`` use it; associative flow dilates by the friction angle.
    cohesion, tensile_strength : quantity, stress
        Zero by default.
    compressive_strength : quantity, stress
        Infinite by default.
    normal_stiffness, shear_stiffness : quantity, stress per length
        Stiffness per area before the joint opens or slides. Infinite by default: joints are rigid.
    torsion
        ``"corners"`` (the default): friction at the contact points alone limits the torque about the normal, up to 1.85
        times the torque that a square resists under uniform pressure. ``"uniform pressure"``: the shear force V and the
        torque T about the centroid also satisfy ``V² + (T / r̄)² ≤ R²``, with the sliding resistance R and the mean
        distance r̄ of the area from its centroid.
    source
        Origin of the values. It is stored and printed with the material.

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
        If a value has no unit, or its unit has another dimension.

    Examples
    --------
    >>> JointMaterial("lime", 0.6, cohesion="50 kPa")
    JointMaterial('lime', friction_coefficient=0.6, cohesion=50 kPa)
    """

    name: str = field(validator=has_name)
    friction_coefficient: float = field(converter=_friction, validator=_is_friction, metadata=NUMBER)
    dilatancy_angle: float = field(
        converter=optional_scalar, validator=_is_angle, metadata={"dimension": "angle", "absent": 0.0}
    )
    cohesion: float = field(converter=optional_scalar, validator=not_negative, metadata=_STRESS)
    tensile_strength: float = field(converter=optional_scalar, validator=not_negative, metadata=_STRESS)
    compressive_strength: float = field(converter=optional_scalar, validator=_is_strength, metadata=_STRENGTH)
    normal_stiffness: float = field(converter=optional_scalar, validator=_is_strength, metadata=_STIFFNESS)
    shear_stiffness: float = field(converter=optional_scalar, validator=_is_strength, metadata=_STIFFNESS)
    torsion: Torsion = field(default=Torsion.CORNERS, converter=_torsion)
    source: str = field(default="", validator=has_source)

    def __init__(  # noqa: PLR0913
        self,
        name: str,
        friction_coefficient: Any = None,
        *,
        friction_angle: QuantityLike | None = None,
        dilatancy_angle: QuantityLike | None = None,
        cohesion: QuantityLike | None = None,
        tensile_strength: QuantityLike | None = None,
        compressive_strength: QuantityLike | None = None,
        normal_stiffness: QuantityLike | None = None,
        shear_stiffness: QuantityLike | None = None,
        torsion: Torsion | str = Torsion.CORNERS,
        source: str = "",
    ) -> None:
        if (friction_coefficient is None) == (friction_angle is None):
            msg = f"joint material {shown(name)}: give either friction_coefficient or friction_angle"
            raise ModelError(msg)
        if friction_angle is not None:
            what = f"joint material {shown(name)}: friction_angle"
            angle = si(friction_angle, "angle", what)
            if not 0 <= angle < math.pi / 2:
                msg = f"{what} {quantity_text(angle, 'angle')}; give an angle from 0° to less than 90°"
                raise ModelError(msg)
            friction_coefficient = math.tan(angle)
        strengths = cohesion, tensile_strength, compressive_strength
        stiffnesses = normal_stiffness, shear_stiffness
        self.__attrs_init__(name, friction_coefficient, dilatancy_angle, *strengths, *stiffnesses, torsion, source)

    def __attrs_post_init__(self) -> None:
        who, mu = f"joint material {self.name!r}", self.friction_coefficient
        if mu == math.inf:
            if self.cohesion or self.dilatancy or self.torsion is not Torsion.CORNERS:
                msg = (
                    f"{who}: a joint of infinite friction never slides, whatever its cohesion, dilatancy and torsion; "
                    "leave these out"
                )
                raise ModelError(msg)
            return
        if mu * self.tensile_strength > self.cohesion * (1 + ROUNDING):
            apex = quantity_text(self.cohesion / mu, "stress")
            msg = (
                f"{who}: tensile_strength {quantity_text(self.tensile_strength, 'stress')} exceeds {apex}, the apex of "
                "the friction cone at cohesion / friction_coefficient; raise the cohesion or lower the tensile strength"
            )
            raise ModelError(msg)
        if self.dilatancy > mu * (1 + ROUNDING):
            msg = (
                f"{who}: dilatancy_angle {quantity_text(self.dilatancy_angle, 'angle')} exceeds the friction angle "
                f"{quantity_text(math.atan(mu), 'angle')}; give an angle from 0° to the friction angle"
            )
            raise ModelError(msg)

    def varied(self, **values: Any) -> "JointMaterial":
        """Return the same joint with other values, given as to the constructor; its source lists the changes.

        >>> JointMaterial("lime", 0.6, cohesion="50 kPa").varied(compressive_strength="4 MPa").cohesion
        50000.0
        """
        properties = _quantities({name: getattr(self, name) for name in JOINT_PROPERTIES})
        if "friction_angle" in values:
            del properties["friction_coefficient"]
        if self.source and values and "source" not in values:
            properties["source"] = f"{self.source}; then changed: {', '.join(values)}"
        return type(self)(self.name, **({"torsion": self.torsion, "source": self.source} | properties | values))

    @classmethod
    def from_si(cls, name: str, values: Mapping[str, float], torsion: str = Torsion.CORNERS, source: str = "") -> Self:
        """Return the joint material with the properties of :data:`JOINT_PROPERTIES` as SI floats."""
        return cls(name, **_quantities(values), torsion=torsion, source=source)

    def __str__(self) -> str:
        values = {n: getattr(self, n) for n, p in JOINT_PROPERTIES.items() if getattr(self, n) != p.absent}
        texts = [
            f"{n.replace('_', ' ')} {quantity_text(v, JOINT_PROPERTIES[n].dimension, 4)}" for n, v in values.items()
        ]
        return ", ".join(texts if self.torsion is Torsion.CORNERS else [*texts, f"torsion of {self.torsion}"])

    @property
    def dilatancy(self) -> float:
        """Tangent of the dilatancy angle."""
        return math.tan(self.dilatancy_angle)


@frozen
class JointProperty:
    """A property of joints, as documents, files, reports and sweeps need it.

    Parameters
    ----------
    dimension
        A key of :data:`blockstruct.units.SI_UNITS`.
    absent
        SI value of a joint without this property; None if it is required.
    """

    dimension: str
    absent: float | None


#: Properties of joints, in the order of their columns.
JOINT_PROPERTIES: Mapping[str, JointProperty] = MappingProxyType(
    {
        f.name: JointProperty(f.metadata["dimension"], f.metadata.get("absent"))
        for f in attrs.fields(JointMaterial)
        if "dimension" in f.metadata
    }
)


def _quantities(values: Mapping[str, float]) -> dict[str, Any]:
    return {
        name: value if math.isinf(value) else to_quantity(value, JOINT_PROPERTIES[name].dimension)
        for name, value in values.items()
        if value != JOINT_PROPERTIES[name].absent
    }
