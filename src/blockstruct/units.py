"""The one pint registry, and conversion to coherent-SI floats.

>>> si(Q_(12, "kN/m^3"), "force/volume", "unit weight")
12000.0
>>> si("0.4 m", "length", "height")
0.4
"""

import functools
import math
import re
from collections.abc import Sequence
from tokenize import TokenError
from typing import Any, TypeAlias, cast

import numpy as np
import pint
from numpy.typing import NDArray

from blockstruct.errors import DimensionError, UnitError, decimal_point, shown

#: Accepted quantities: ``Q_(0.4, "m")`` of any registry, or a text such as ``"0.4 m"``.
QuantityLike: TypeAlias = pint.Quantity[Any] | str
#: Accepted vectors: one quantity of three numbers, a text, or a quantity per component.
VectorLike: TypeAlias = pint.Quantity[Any] | str | Sequence[Any] | NDArray[np.float64]

#: Reads its definitions at the first use, because they take half the time of an import.
ureg: Any = cast(Any, pint).LazyRegistry()


def Q_(value: Any, units: Any = None) -> Any:  # noqa: N802 - the name that pint's users know
    """Return a quantity of the one pint registry: ``Q_(12, "kN/m^3")``."""
    return ureg.Quantity(value, units)


#: Coherent SI unit of each physical dimension, spelled in full as stored on disk.
SI_UNITS = {
    "length": "meter",
    "area": "meter ** 2",
    "volume": "meter ** 3",
    "force": "newton",
    "moment": "newton * meter",
    "energy": "joule",
    "stress": "pascal",
    "stress/length": "pascal / meter",
    "force/length": "newton / meter",
    "force/volume": "newton / meter ** 3",
    "density": "kilogram / meter ** 3",
    "angle": "radian",
    "dimensionless": "dimensionless",
    "velocity": "meter / second",
    "angular velocity": "radian / second",
    "acceleration": "meter / second ** 2",
    "time": "second",
}
_EXAMPLES = {
    "length": "0.4 m",
    "force": "10 kN",
    "moment": "5 kN*m",
    "stress": "4 MPa",
    "stress/length": "10 GPa/m",
    "force/length": "8 kN/m",
    "force/volume": "12 kN/m^3",
    "density": "1800 kg/m^3",
    "angle": "30 deg",
    "acceleration": "0.15 g_0",
    "time": "0.3 s",
}
#: Names of units with small powers, multiplied and divided. A parser cannot read them as an expression.
_FACTOR = r"(g_0|[^\W\d]+)((\s*(\*\*|\^)\s*)?-?\d(\.\d{1,6})?)?"
_UNIT = re.compile(rf"(1\s*/\s*)?({_FACTOR}((\s*[*/]\s*|\s+){_FACTOR}){{0,9}})?")
#: Units as engineers write them, and their names in pint: ``m3``, ``N·m``, ``KN``, ``kNm``.
_AS_TYPED = (
    (re.compile(r"(?<=[^\W\d_])(?=-?\d)"), "**"),
    (re.compile("·"), "*"),
    (re.compile(r"\bK(?=(N|Pa|g|m)+\b)"), "k"),
    (re.compile(r"\b((da|k|M)?N)m\b"), r"\1*m"),
)
#: Names of the ton, which in pint is the American short ton.
_TON = re.compile(r"(?<![A-Za-z_])(kilo|mega)?(force_)?ton(?![A-Za-z_])")
#: Largest number in SI units; no building needs more, and powers of larger numbers overflow.
LARGEST_NUMBER = 1e30
#: Largest number of characters of a quantity: three components with all digits and a long unit.
LONGEST_TEXT = 250


def si(value: Any, dimension: str, what: str) -> float:
    """Return the coherent-SI float of a quantity.

    Parameters
    ----------
    value
        A pint quantity of any registry, or a text such as ``"0.4 m"``. A bare number is accepted only for
        ``dimension="dimensionless"``.
    dimension
        A key of :data:`SI_UNITS`.
    what
        Name of the value, for an error message.

    Raises
    ------
    UnitError
        If a bare number lacks its unit, or the value is not a single number.
    DimensionError
        If the quantity has another dimension, or the value is not finite.
    """
    array = si_array(value, dimension, what)
    if array.ndim:
        msg = f"{what}: {shown(value)} holds {array.size} numbers; give one"
        raise UnitError(msg)
    return float(array)


def si_array(value: Any, dimension: str, what: str) -> NDArray[np.float64]:
    """Return coherent-SI floats of a quantity of any shape, as :func:`si`."""
    typed = value
    if isinstance(value, str):
        value = parse(value, what)
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        magnitude, factor = value.magnitude, _factor(_name_of(value.units), dimension, what, typed)
    elif isinstance(value, bool):
        msg = f"{what}: {value} is not a number; give one, as in {_EXAMPLES.get(dimension, '0.65')!r}"
        raise UnitError(msg)
    elif dimension == "dimensionless":
        magnitude, factor = value, 1.0
    else:
        given = shown(value)
        msg = (
            f"{what}: {given} has no unit, but {_article(dimension)} {dimension} is needed; "
            f"write Q_({given}, {_example_unit(dimension)!r}) or a text such as {_EXAMPLES.get(dimension, '0.65')!r}"
        )
        raise UnitError(msg)
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            array = np.asarray(magnitude, dtype=float) * factor
    except (TypeError, ValueError, ArithmeticError, RecursionError, pint.PintError):
        example = _EXAMPLES.get(dimension, "0.65")
        msg = f"{what}: {shown(value)} is not a number; give numbers with a unit, as in {example!r}"
        raise UnitError(msg) from None
    if not np.all(np.isfinite(array)):
        msg = f"{what}: {shown(value)} is not finite; give finite numbers"
        raise DimensionError(msg)
    if np.any(np.abs(array) > LARGEST_NUMBER):
        msg = f"{what}: {shown(value)} is above {LARGEST_NUMBER:g} {SI_UNITS[dimension]}; is its unit right?"
        raise DimensionError(msg)
    return np.asarray(array)


def si_vector(value: Any, dimension: str, what: str) -> tuple[float, float, float]:
    """Return three coherent-SI components of a vector quantity.

    The quantity is for example ``Q_([0, 0, -1], "kN")``. A list of texts, one quantity per component, is accepted, too:
    model documents use it.
    """
    if isinstance(value, list | tuple) and any(hasattr(v, "magnitude") or isinstance(v, str) for v in value):
        components = [si(v, dimension, what) for v in value]
    else:
        components = si_array(value, dimension, what).ravel().tolist()
    if len(components) != 3:
        msg = f"{what}: {shown(value)} has {len(components)} components; give three, along x, y and z"
        raise DimensionError(msg)
    x, y, z = components
    return x, y, z


def parse(text: str, what: str) -> Any:
    """Return the quantity of a text such as ``"0.4 m"`` or ``"-10 kN"``.

    A text may hold a vector: ``"[0, 0, -200] kN"``. Number and unit are read separately, so a text is never evaluated
    as an expression.
    """
    if len(text) > LONGEST_TEXT:
        # pint searches a long word for prefixes and suffixes; the time grows with the square of its length.
        msg = f"{what}: a text of {len(text)} characters ({shown(text)}) is not a quantity; write one as '12 kN/m^3'"
        raise UnitError(msg)
    listed = text.strip().startswith("[")
    number, end, unit = text.strip().lstrip("[").partition("]" if listed else " ")
    try:
        if listed and not end:
            msg = "the list has no end"
            raise ValueError(msg)
        # A comma separates the numbers of a list. Within one number it is ambiguous.
        values = np.array([float(v) for v in number.split(",")]) if listed else float(number)
        typed = unit = unit.strip()
        for pattern, written in _AS_TYPED:
            unit = pattern.sub(written, unit)
        if not _UNIT.fullmatch(unit):
            msg = f"{typed!r} is not a unit"
            raise ValueError(msg)
        units = ureg.parse_units(unit)
    except (pint.PintError, ArithmeticError, LookupError, SyntaxError, TypeError, ValueError, TokenError) as error:
        meant = decimal_point(text)
        msg = f"{what}: {text!r} is not a quantity ({'a comma in a number' if meant else error}); write "
        msg += (
            f"{meant!r}, with a decimal point, "
            if meant
            else "a number, a space and a unit, as in '0.4 m' or '12 kN/m^3'"
        )
        raise UnitError(msg) from error
    return Q_(values, units)


def own_registry() -> None:
    """Use the one registry for quantities unpickled in this process."""
    cast(Any, pint).set_application_registry(ureg)


def in_si(quantity: Any) -> tuple[float, str]:
    """Return the magnitude in coherent SI units, and the long unit name.

    >>> in_si(Q_(4, "MPa")), in_si(Q_(2, "m/s**2"))
    ((4000000.0, 'pascal'), (2.0, 'meter / second ** 2'))
    """
    unit = str(quantity.units)
    for dimension, named in SI_UNITS.items():
        if (factor := _conversion(unit, dimension)) is not None:
            return float(quantity.magnitude) * factor, named
    base = quantity.to_base_units()
    return float(base.magnitude), str(base.units)


def short_unit(unit: str) -> str:
    """Return the symbol of a unit from its long name: ``"MPa"``."""
    return f"{ureg.Unit(unit):~C}"


def to_quantity(value: Any, dimension: str) -> Any:
    """Return the pint quantity of coherent-SI floats."""
    return Q_(value, _si_unit(dimension))


def quantity_text(values: Any, dimension: str, digits: int = 6) -> str:
    """Return coherent-SI floats as a text with a readable unit.

    >>> quantity_text(12000.0, "force/volume"), quantity_text((0.0, 0.0, -2500.0), "force")
    ('12 kN/m³', '(0, 0, -2.5) kN')
    """
    quantity = to_quantity(np.asarray(values, dtype=float), dimension)
    if dimension == "angle":
        quantity, unit = quantity.to("degree"), "°"
    else:
        if SI_UNITS[dimension].startswith(("newton", "pascal")):
            finite = np.abs(quantity.magnitude[np.isfinite(quantity.magnitude)])
            quantity = quantity.to(to_quantity(float(finite.max(initial=0.0)), dimension).to_compact().units)
        unit = f" {quantity.units:~P}".rstrip()
    numbers = [f"{value:.{digits}g}" for value in np.ravel(quantity.magnitude).tolist()]
    return (f"({', '.join(numbers)})" if quantity.magnitude.ndim else numbers[0]) + unit


def si_text(value: float, dimension: str) -> str:
    """Return a text that converts back to the same coherent-SI float.

    >>> si_text(50000.0, "stress")
    '50000.0 Pa'
    """
    return f"{float(value)!r} {symbol(dimension)}".rstrip()


def symbol(dimension: str) -> str:
    """Return the symbol of the coherent SI unit of a dimension: ``"Pa"``."""
    return short_unit(SI_UNITS[dimension])


def readable(values: Any, unit: str) -> tuple[float, str]:
    """Return the factor and unit in which SI values are easy to read.

    >>> readable([12e3, 250.0], "N")
    (0.001, 'kN')
    >>> readable([3.1e6], "Pa")
    (1e-06, 'MPa')
    """
    finite = np.abs(np.asarray(values, dtype=float))
    largest = float(finite[np.isfinite(finite)].max(initial=0.0))
    for power, prefix in ((6, "M"), (3, "k")):
        if largest >= 10**power:
            return 10.0**-power, prefix + unit
    return 1.0, unit


def _article(noun: str) -> str:
    return "an" if noun[0] in "aeiou" else "a"


def _factor(unit: str, dimension: str, what: str, typed: Any) -> float:
    if _TON.search(unit):
        msg = (
            f"{what}: a ton is 1000 kg, and 907 kg in the United States; give 't' or 'tf', the mass or the weight of "
            "1000 kg, or 'US_ton' or 'US_force_ton'"
        )
        raise UnitError(msg)
    found = _conversion(unit, dimension)
    if found is None:
        wanted = "a plain number" if dimension == "dimensionless" else f"{_article(dimension)} {dimension}"
        example = _EXAMPLES.get(dimension, "0.65")
        given = f"unit of {shown(typed)}" if isinstance(typed, str) else f"unit {unit!r}"
        msg = f"{what}: the {given} does not fit; give {wanted}, as in {example!r}"
        raise DimensionError(msg)
    return found


# A thousand model objects share a few units, so each unit is named and converted once.
@functools.cache
def _name_of(unit: Any) -> str:
    return str(unit)


@functools.cache
def _si_unit(dimension: str) -> Any:
    return ureg.Unit(SI_UNITS[dimension])


@functools.cache
def _conversion(unit: str, dimension: str) -> float | None:
    """Return the factor to the coherent SI unit; None for other dimensions.

    In pint an angle is a plain number. Here it is not: 35 degrees are not a friction coefficient of 0.61.
    """
    try:
        if Q_(0.0, unit).to_root_units().magnitude != 0.0:
            # Logarithmic or offset unit: decibels are not a plain number.
            return None
        factor: Any
        factor, root = ureg.get_root_units(unit)
        if dimension in ("angle", "dimensionless"):
            return float(factor) if str(root) == SI_UNITS[dimension] else None
        factor = Q_(1.0, unit).to(SI_UNITS[dimension]).magnitude
    except (pint.PintError, ValueError):
        return None
    return float(factor) if math.isfinite(factor) else None


def _example_unit(dimension: str) -> str:
    return _EXAMPLES.get(dimension, "").partition(" ")[2]
