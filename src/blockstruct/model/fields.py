"""Fields of model objects: quantities in, SI floats stored, units printed.

The metadata of a field are the further arguments of its converter. ``dimension`` is a key of
:data:`blockstruct.units.SI_UNITS`; ``absent`` is the stored value of an argument that is None.
"""

import functools
import re
from collections.abc import Callable, Iterable, Sequence
from copy import copy
from enum import StrEnum
from typing import Any, ClassVar, TypeVar

import attrs

from blockstruct.errors import ModelError, check_known, shown
from blockstruct.model.checks import (
    checked_count,
    checked_direction,
    checked_name,
    checked_text,
    checked_tuple,
    is_name,
)
from blockstruct.units import QuantityLike, VectorLike, quantity_text, si, si_vector, to_quantity

Vector = tuple[float, float, float]
#: Name of a block, and a point in m. Without a name the model finds the block.
Anchor = tuple[str, Vector]
#: Default of an argument that None leaves out: the field then stores its ``absent`` value.
LEFT_OUT: Any = None
_Name = TypeVar("_Name", bound=StrEnum)


class ModelObject:
    """Base of the frozen objects of a model: they print their units and give quantities."""

    __slots__ = ()
    #: Dimension of each computed property.
    computed: ClassVar[dict[str, str]] = {}

    def quantity(self, name: str) -> Any:
        """Return a dimensional attribute as a pint quantity.

        Parameters
        ----------
        name
            Name of the attribute. The quantity of an anchor is its point.

        Returns
        -------
        Quantity or None
            In coherent SI units; None if the attribute is None.

        Raises
        ------
        UnknownNameError
            If the object has no dimensional attribute of this name.

        Examples
        --------
        >>> from blockstruct.model import Material
        >>> f"{Material('tuff', '12 kN/m^3').quantity('unit_weight').to('kN/m^3'):.1f~P}"
        '12.0 kN/m³'
        """
        known = dimensions(type(self)) | self.computed
        check_known(name, known, f"{label(self)}: no dimensional attribute")
        value = getattr(self, name)
        if value is None:
            return None
        return to_quantity(value[1] if is_anchor(value) else value, known[name])

    def __repr__(self) -> str:
        texts: list[str] = []
        kind: Any = type(self)
        for field in attrs.fields(kind):
            value = getattr(self, field.name)
            if field.name == "name":
                texts.insert(0, repr(value))
            elif field.repr and not _is_default(value, field):
                texts.append(f"{field.name}={_text(value, field.metadata.get('dimension'))}")
        return f"{type(self).__name__}({', '.join(texts)})"


def named_arguments(_: type, fields: list[Any]) -> list[Any]:
    """Give each converter its metadata and the name of its argument: a ``field_transformer`` of attrs."""
    return [
        field.evolve(converter=_in_context(field.converter))
        if field.converter and not isinstance(field.converter, attrs.Converter)
        else field
        for field in fields
    ]


def label(thing: Any) -> str:
    """Return the words by which errors name an object.

    >>> from blockstruct.model import JointMaterial, Moment
    >>> label(JointMaterial("lime", 0.6)), label(Moment("b1", "[1, 0, 0] kN*m"))
    ("joint material 'lime'", "Moment on 'b1'")
    """
    kind = type(thing).__name__
    if hasattr(thing, "name"):
        return f"{snake_case(kind).replace('_', ' ')} {shown(thing.name)}"
    block = getattr(thing, "block", None)
    return kind if block is None else f"{kind} on {shown(block)}"


@functools.cache
def snake_case(name: str) -> str:
    """Return the name of a class as documents and files write it.

    >>> snake_case("SelfWeight")
    'self_weight'
    """
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


def dimensions(kind: Any) -> dict[str, str]:
    """Return the dimension of each dimensional field of a class."""
    return {f.name: f.metadata["dimension"] for f in attrs.fields(kind) if "dimension" in f.metadata}


def absent_value(field: Any) -> Any:
    """Return the stored value of a field whose argument is left out, or ``attrs.NOTHING`` if it is required."""
    return field.metadata.get("absent", field.default)


def changed(thing: Any, **values: Any) -> Any:
    """Return a copy of a frozen object with other stored values, checked again by the validators."""
    other = copy(thing)
    store(other, **values)
    attrs.validate(other)
    return other


def store(thing: object, **values: Any) -> None:
    """Store computed values in a frozen object."""
    for name, value in values.items():
        object.__setattr__(thing, name, value)


# Converters: the first argument has the type that the constructor takes.


def scalar(value: QuantityLike, dimension: str = "", what: str = "") -> float:
    """Return the SI float of a quantity."""
    return si(value, dimension, what)


def optional_scalar(value: QuantityLike | None, dimension: str = "", absent: Any = None, what: str = "") -> Any:
    """Return the SI float of a quantity that may be left out."""
    return absent if value is None else si(value, dimension, what)


def number(value: float, dimension: str = "", what: str = "") -> float:
    """Return a number without a unit."""
    return si(value, dimension, what)


def vector(value: VectorLike, dimension: str = "", what: str = "") -> Vector:
    """Return the SI floats of a vector."""
    return si_vector(value, dimension, what)


def optional_vector(value: VectorLike | None, dimension: str = "", absent: Any = None, what: str = "") -> Any:
    """Return the SI floats of a vector that may be left out."""
    return absent if value is None else si_vector(value, dimension, what)


def unit_vector(value: VectorLike, dimension: str = "", remedy: str = "", what: str = "") -> Vector:
    """Return a direction of length 1."""
    return checked_direction(value, what, remedy)


def anchor(value: Any, dimension: str = "", what: str = "") -> Anchor:
    """Return the block and the point in m at which a tie ends; a point alone has an empty name."""
    is_text = isinstance(value, str)
    if hasattr(value, "magnitude") or (value.lstrip().startswith(("[", "(")) if is_text else _has_three(value)):
        return "", si_vector(value, dimension, what)
    if is_text or not isinstance(value, Sequence) or len(value) != 2:
        msg = f"{what} is {shown(value)}; give a point, or a block and a point, as in ('b1', Q_([0, 0, 3], 'm'))"
        raise ModelError(msg)
    block, point = value
    return checked_name(block, f"{what}: block"), si_vector(point, dimension, what)


def _has_three(value: Any) -> bool:
    return isinstance(value, Sequence) and len(value) == 3


def steps(value: int, what: str = "") -> int:
    """Return the number of steps of a curve."""
    return checked_count(value, 3, what)


def items(value: Iterable[Any], kind: Any = object, what: str = "") -> tuple[Any, ...]:
    """Return a collection of objects of one kind as a tuple."""
    return checked_tuple(value, kind, what)


def member(value: Any, kind: type[_Name], what: str) -> _Name:
    """Return the member of an enumeration by its text."""
    try:
        return kind(value)
    except (ValueError, TypeError, RecursionError):
        msg = f"{what} {shown(value)}; give one of {', '.join(map(repr, map(str, kind)))}"
        raise ModelError(msg) from None


# Validators: they run once all fields are converted.

Validator = Callable[[Any, Any, Any], None]


def has_name(thing: Any, field: Any, value: Any) -> None:
    """Refuse a text that cannot be a name."""
    # A thousand interfaces have three names each, and the words of an error take longer than the check.
    if not is_name(value):
        kind = snake_case(type(thing).__name__).replace("_", " ") if field.name == "name" else ""
        checked_name(value, kind or f"{label(thing)}: {field.name}")


def has_source(thing: Any, _: Any, value: Any) -> None:
    """Refuse a source that cannot be printed or stored."""
    checked_text(value, f"{label(thing)}: source")


def instance_of(kind: type, remedy: str = "") -> Validator:
    """Return a validator that refuses objects of another class."""

    def check(thing: Any, field: Any, value: Any) -> None:
        if not isinstance(value, kind):
            article = "an" if kind.__name__[0] in "AEIOU" else "a"
            msg = f"{label(thing)}: {field.name} is {shown(value)}; give {remedy or f'{article} {kind.__name__}'}"
            raise ModelError(msg)

    return check


def limit(is_allowed: Callable[[float], bool], remedy: str) -> Validator:
    """Return a validator that refuses numbers outside a limit."""

    def check(thing: Any, field: Any, value: Any) -> None:
        if value is not None and not is_allowed(value):
            text = quantity_text(value, field.metadata["dimension"])
            msg = f"{label(thing)}: {field.name} {text}; {remedy}"
            raise ModelError(msg)

    return check


is_truth = instance_of(bool, "True or False")
positive = limit(lambda value: value > 0, "give more than zero")
not_negative = limit(lambda value: value >= 0, "give zero or more")


def _in_context(convert: Callable[..., Any]) -> Any:
    @functools.wraps(convert)
    def in_context(value: Any, thing: Any, field: Any) -> Any:
        return convert(value, what=f"{label(thing)}: {field.alias or field.name}", **field.metadata)

    return attrs.Converter(in_context, takes_self=True, takes_field=True)


def is_anchor(value: Any) -> bool:
    """Return whether a stored value is an anchor."""
    return isinstance(value, tuple) and isinstance(value[0], str)


def _is_default(value: Any, field: Any) -> bool:
    absent = absent_value(field)
    return absent is not attrs.NOTHING and bool(value == absent)


def _text(value: Any, dimension: str | None) -> str:
    if dimension is None or value is None:
        return str(value) if isinstance(value, StrEnum) else repr(value)
    if is_anchor(value):
        block, point = value[0], quantity_text(value[1], dimension)
        return f"({block!r}, {point})" if block else point
    return quantity_text(value, dimension)
