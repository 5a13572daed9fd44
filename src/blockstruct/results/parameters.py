"""Parameters of an analysis: numbers, texts and quantities by name."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from blockstruct.errors import ModelError, UnitError, shown
from blockstruct.model import checked_name, checked_text, checked_tuple
from blockstruct.units import Q_, in_si, parse

#: A number, a text, a truth value, None or a pint quantity of one number.
Parameter = Any


def checked_parameters(given: Mapping[str, Any], who: str) -> dict[str, Parameter]:
    """Return parameters as plain Python values or quantities of blockstruct.

    Raises
    ------
    ModelError
        If this is not a mapping of names, or a value has another type.
    UnitError
        If a quantity has several numbers.
    """
    if not isinstance(given, Mapping):
        msg = f"{who}: {shown(given)} are not parameters; give a mapping of names to values"
        raise ModelError(msg)
    return {checked_name(name, f"{who}: parameter"): checked_value(v, f"{who}: {name}") for name, v in given.items()}


def checked_tags(tags: Any, who: str) -> tuple[str, ...]:
    """Return tags as a tuple of texts.

    Raises
    ------
    ModelError
        If a tag is not a printable text, or too long to be stored.
    """
    return tuple(checked_text(tag, f"{who}: tag") for tag in checked_tuple(tags, str, f"{who}: tags"))


def checked_value(value: Any, what: str) -> Parameter:
    """Return one parameter as :func:`checked_parameters` does."""
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        magnitude = np.asarray(value.magnitude)
        if magnitude.shape != () or magnitude.dtype.kind not in "fiu":
            msg = f"{what}: {shown(value)} is not a quantity of one number; give one, as in Q_(4, 'MPa')"
            raise UnitError(msg)
        return Q_(_finite(float(magnitude), what), str(value.units))
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return _finite(value, what)
    if isinstance(value, str):
        return checked_text(value, what)
    if value is None or isinstance(value, bool | int):
        return value
    msg = f"{what}: {shown(value)} is not a parameter; give a number, a text, a truth value or a quantity"
    raise ModelError(msg)


def stored_value(value: Parameter) -> Any:
    """Return a parameter as JSON; quantities get the long unit name."""
    return {"value": value.magnitude, "units": str(value.units)} if hasattr(value, "magnitude") else value


def restored_value(stored: Any, what: str) -> Parameter:
    """Return the parameter of a JSON value from :func:`stored_value`."""
    if isinstance(stored, dict):
        if set(stored) != {"value", "units"} or not isinstance(stored["units"], str):
            msg = f"{what}: {shown(stored)} is not a quantity"
            raise ModelError(msg)
        # The unit comes from a file: parse it, never evaluate it as an expression.
        return checked_value(parse(f"{float(stored['value'])!r} {stored['units']}", what), what)
    return checked_value(stored, what)


def plain_value(value: Parameter) -> tuple[Any, str]:
    """Return the value in SI units and its long unit; empty without a unit."""
    if hasattr(value, "magnitude"):
        return in_si(value)
    return value, "dimensionless" if isinstance(value, int | float) and not isinstance(value, bool) else ""


def _finite(value: float, what: str) -> float:
    if not math.isfinite(value):
        msg = f"{what}: {value} is not finite; give a number, or None for an absent value"
        raise ModelError(msg)
    return value
