"""Material of blocks."""

import warnings

from attrs import field, frozen

from blockstruct.errors import ModelError, UnusualValueWarning, shown
from blockstruct.model.fields import ModelObject, has_name, has_source, named_arguments, not_negative, scalar
from blockstruct.units import QuantityLike, si, to_quantity

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
        Where the value comes from. It is stored and printed with the material.

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
    unit_weight: float = field(converter=scalar, validator=not_negative, metadata={"dimension": "force/volume"})
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
