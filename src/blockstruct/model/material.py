"""Material of blocks."""

import warnings
from dataclasses import dataclass

from blockstruct.errors import ModelError, UnusualValueWarning
from blockstruct.model.checks import checked_name, checked_source
from blockstruct.units import QuantityLike, si

#: Standard acceleration of free fall, m/s² (CGPM 1901).
STANDARD_GRAVITY = 9.80665
#: Unit weights of masonry, N/m³: pumice and aerated blocks to lead. Any other is probably a slip of the unit.
USUAL_UNIT_WEIGHT = (5e3, 90e3)


@dataclass(frozen=True, slots=True, init=False)
class Material:
    """Material of rigid blocks: its weight is all that matters.

    Parameters
    ----------
    name
        Unique among the materials of a model.
    unit_weight : quantity, force/volume
        Weight per volume.
    density : quantity, mass/volume
        Mass per volume, instead of the unit weight: its weight is taken at 9.80665 m/s².
    source
        Where the value comes from, as :mod:`blockstruct.library` says it: stored and printed with the material.

    Attributes
    ----------
    unit_weight : float
        N/m³.

    Raises
    ------
    ModelError
        If neither or both of unit weight and density are given, or the value is negative.
    UnitError, DimensionError
        If a bare number is given, or a quantity of another dimension.

    Warns
    -----
    UnusualValueWarning
        If the unit weight is outside 5 to 90 kN/m³ and not zero.

    Examples
    --------
    >>> Material("tuff", unit_weight="12 kN/m^3").unit_weight
    12000.0
    """

    name: str
    unit_weight: float
    source: str

    def __init__(
        self,
        name: str,
        unit_weight: QuantityLike | None = None,
        *,
        density: QuantityLike | None = None,
        source: str = "",
    ) -> None:
        checked_name(name, "material")
        if (unit_weight is None) == (density is None):
            msg = f"material {name!r}: give either unit_weight or density"
            raise ModelError(msg)
        if density is not None:
            value = si(density, "density", f"material {name!r}: density") * STANDARD_GRAVITY
        else:
            value = si(unit_weight, "force/volume", f"material {name!r}: unit weight")
        if value < 0:
            msg = f"material {name!r}: unit weight {value:.6g} N/m^3 is negative; give zero or more"
            raise ModelError(msg)
        low, high = USUAL_UNIT_WEIGHT
        if value and not low <= value <= high:
            msg = (
                f"material {name!r}: a unit weight of {value / 1e3:.6g} kN/m^3 is not one of masonry, which is from "
                f"{low / 1e3:g} to {high / 1e3:g} kN/m^3; is its unit right?"
            )
            warnings.warn(msg, UnusualValueWarning, stacklevel=2)
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "unit_weight", value)
        object.__setattr__(self, "source", checked_source(source, f"material {name!r}"))
