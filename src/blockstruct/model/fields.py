"""Fields of model objects: quantities in, SI floats stored, units printed; and checks of arguments.

The metadata of a field are the further arguments of its converter. ``dimension`` is a key of
:data:`blockstruct.units.SI_UNITS`; ``absent`` is the stored value of an argument that is None.
"""

import functools
import math
import operator
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from copy import copy
from enum import StrEnum
from typing import Any, ClassVar, TypeGuard, TypeVar, get_args

import attrs
import numpy as np

from blockstruct.arrays import SLIGHT, Array
from blockstruct.errors import ModelError, check_known, shown
from blockstruct.units import QuantityLike, VectorLike, quantity_text, si, si_vector, to_quantity
from blockstruct.vocabulary import listed

#: Largest number of characters of a name or another stored text.
LONGEST_TEXT = 5000
#: Smallest and largest length of a builder, m.
SHORTEST, LONGEST = 1e-6, 1e6
#: Largest number of blocks of a structure, of steps of a curve, and of directions.
MOST = 100_000

#: Unit vector of each axis, by its name.
AXES_BY_NAME = {
    f"{sign}{axis}": tuple(float(f"{sign}{int(k == j)}") + 0.0 for k in range(3))
    for j, axis in enumerate("xyz")
    for sign in "+-"
}


def checked_direction(direction: VectorLike, what: str, remedy: str = "") -> tuple[float, float, float]:
    """Return the unit vector of a direction of length 1, or of the name of an axis such as ``"+x"``.

    Raises
    ------
    ModelError
        If the direction is zero, not of length 1, or an unknown name.
    """
    if isinstance(direction, str) and not any(map(str.isdigit, direction)):
        if direction.strip() not in AXES_BY_NAME:
            names = ", ".join(AXES_BY_NAME)
            msg = f"{what} {shown(direction)}: give one of {names}, or three numbers, as (0.6, 0.8, 0)"
            raise ModelError(msg)
        direction = AXES_BY_NAME[direction.strip()]
    x, y, z = si_vector(direction, "dimensionless", what)
    length = math.hypot(x, y, z)
    if length == 0:
        msg = f"{what} {(x, y, z)} is zero; give a direction such as (1, 0, 0) or '+x'"
        raise ModelError(msg)
    if abs(length - 1) > SLIGHT:
        msg = (
            f"{what} {(x, y, z)} has the length {length:.6g}, not 1; give a direction of length 1"
            f"{remedy.format(length=length)}"
        )
        raise ModelError(msg)
    return unit_vector_along(x, y, z)


def unit_vector_along(x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the unit vector along a vector. A unit vector keeps its digits when it is stored and read again."""
    length = math.hypot(x, y, z)
    return (x, y, z) if abs(length - 1) <= 4 * sys.float_info.epsilon else (x / length, y / length, z / length)


def is_name(name: Any) -> TypeGuard[str]:
    """Return whether a value is a name: a text that is not blank, printable on one line, and not too long."""
    return isinstance(name, str) and bool(name.strip()) and name.isprintable() and len(name) <= LONGEST_TEXT


def checked_name(name: Any, kind: str) -> str:
    """Return the name; refuse a blank text, one that is not printable on one line, or one too long to be stored."""
    if not is_name(name):
        msg = f"{kind} {shown(name)}: a name must be a text of 1 to {LONGEST_TEXT} printable characters, not blank"
        raise ModelError(msg)
    return name


def check_unrepeated(names: Iterable[str], what: str) -> None:
    """Refuse repeated names.

    Raises
    ------
    ModelError
        If a name is repeated.
    """
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        msg = f"{what} names used more than once: {listed(twice)}; rename them"
        raise ModelError(msg)


def checked_text(text: Any, what: str) -> str:
    """Return a text that is stored and printed on one line: a source of values, a tag, a parameter.

    Raises
    ------
    ModelError
        If it is not a printable text, or too long to be stored.
    """
    if not isinstance(text, str) or not text.isprintable() or len(text) > LONGEST_TEXT:
        msg = f"{what} is {shown(text)}; give a text of up to {LONGEST_TEXT} printable characters"
        raise ModelError(msg)
    return text


def checked_tuple(items: Any, kind: Any, what: str) -> tuple[Any, ...]:
    """Return the items as a tuple; refuse items that are not of one kind, a class or a union of classes."""
    kinds = get_args(kind) or (kind,)
    names = ", ".join(k.__name__ for k in kinds)
    if isinstance(items, str) or not isinstance(items, Iterable):
        msg = f"{what}: {shown(items)} is not a list; give a list of {names}"
        raise ModelError(msg)
    try:
        members = tuple(items)
    except TypeError:  # quantities and arrays without a dimension claim to be iterable
        members = (items,)
    for item in members:
        if not isinstance(item, kinds):
            msg = f"{what}: {shown(item)} is not one of {names}; give a list of {names}"
            raise ModelError(msg)
    return members


def positive_length(value: Any, what: str) -> float:
    """Return a length in m.

    Raises
    ------
    ModelError
        If the length is outside the range of buildings.
    """
    length = si(value, "length", what)
    if not SHORTEST <= length <= LONGEST:
        msg = f"{what} {length:.6g} m; give a length from {SHORTEST:g} to {LONGEST:g} m, and check its unit"
        raise ModelError(msg)
    return length


def checked_count(value: Any, least: int, what: str) -> int:
    """Return a whole number from ``least`` to :data:`MOST`.

    Raises
    ------
    ModelError
        If it is not a whole number, or outside this range.
    """
    try:
        count = operator.index(value)
    except TypeError:
        count = least - 1
    if not least <= count <= MOST or isinstance(value, bool):
        msg = f"{what} {shown(value)}; give a whole number of at least {least} and at most {MOST}"
        raise ModelError(msg)
    return count


def check_total(blocks: float, what: str) -> None:
    """Refuse a structure with too many blocks before it is built.

    Raises
    ------
    ModelError
        If there are more than :data:`MOST`.
    """
    if blocks > MOST:
        msg = f"{what}: about {blocks:.3g} blocks, the limit is {MOST}; give larger or fewer units"
        raise ModelError(msg)


def check_at_block(what: str, point: tuple[float, float, float], block: str, vertices: Array, remedy: str) -> None:
    """Refuse a point, m, outside the box around the vertices (n, 3) of its block.

    Raises
    ------
    ModelError
        If it is outside by more than rounding.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    slack = SLIGHT * float((high - low).max())
    if np.any(point < low - slack) or np.any(point > high + slack):
        msg = (
            f"{what} at block {block!r} is {tuple(point)} m, outside the block, which extends from "
            f"{low.round(6).tolist()} to {high.round(6).tolist()} m; {remedy}"
        )
        raise ModelError(msg)


#: Metadata of fields: the dimension of their values.
LENGTH, AREA, FORCE, STRESS, UNIT_WEIGHT, TIME, NUMBER = (
    {"dimension": name} for name in ("length", "area", "force", "stress", "force/volume", "time", "dimensionless")
)
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


def optional_positive(value: QuantityLike | None, dimension: str = "", what: str = "") -> float | None:
    """Return the SI float of a quantity above zero that may be left out."""
    number = None if value is None else si(value, dimension, what)
    if number is not None and number <= 0:
        msg = f"{what} {quantity_text(number, dimension)}; give more than zero"
        raise ModelError(msg)
    return number


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
