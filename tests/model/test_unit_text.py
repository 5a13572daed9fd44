"""Units as people write them and as pint does."""

import pytest

from blockstruct import Q_, units
from blockstruct.errors import UnitError


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("1 newton / meter ** 3", "N/m**3"),
        ("1 kN / m ^ 3", "kN/m**3"),
        ("1 1 / meter ** 2", "1/m**2"),
        ("1 meter ** -1", "1/m"),
        ("1 megapascal * meter ** 0.5", "MPa*m**0.5"),
        ("1 meter**-1.5", "1/m**1.5"),
    ],
)
def test_powers_of_units_with_spaces_and_fractions(text, unit):
    assert units.parse(text, "value") == Q_(1.0, unit)


@pytest.mark.parametrize("unit", ["kN/m**3", "1/m**2", "1/m", "MPa*m**0.5", "m/s**2", "g_0", "kg*m**2/s**2"])
def test_the_text_of_a_quantity_reads_back(unit):
    value = Q_(2.5, unit)
    assert units.parse(f"{value.magnitude!r} {value.units}", "value") == value


@pytest.mark.parametrize("unit", ["m ** 9 ** 9", "m ** 99", "m ** (2)", "m * * 2", "m ** n", "m ** 0.5.5", "m ** 1e5"])
def test_what_is_no_power_of_a_unit_is_refused(unit):
    with pytest.raises(UnitError, match="is not a unit"):
        units.parse(f"1 {unit}", "value")
