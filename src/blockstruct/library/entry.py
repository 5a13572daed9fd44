"""Entries of the library: ranges of values and their sources."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, TypeVar

from blockstruct.errors import ModelError, UnknownNameError, check_known, did_you_mean, made_again, shown
from blockstruct.units import parse, si, to_quantity

_Entry = TypeVar("_Entry", bound="Entry")

_CHOICES = ("min", "mean", "max")


@dataclass(frozen=True, slots=True)
class Range:
    """Smallest and largest published value of a property.

    Attributes
    ----------
    low, high : float
        In ``unit``.
    unit : str
        Published unit.
    dimension : str
        A key of :data:`blockstruct.units.SI_UNITS`.
    meaning : str
        Meaning of the property.
    """

    low: float
    high: float
    unit: str
    dimension: str
    meaning: str

    def __str__(self) -> str:
        number = f"{self.low:g}" if self.low == self.high else f"{self.low:g} to {self.high:g}"
        return f"{number} {self.unit.replace('^3', '³')}"

    @property
    def si(self) -> tuple[float, float]:
        """Smallest and largest value in coherent SI units."""
        low, high = (si(parse(f"{v!r} {self.unit}", self.meaning), self.dimension, self.meaning) for v in self.ends)
        return low, high

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest published value."""
        return float(self.low), float(self.high)


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A kind of masonry or of joints, with ranges of values and their source.

    Attributes
    ----------
    name : str
    original : str
        Name in the source if in another language, or a description.
    ranges : dict of str to Range
        Ranges by the symbol of the property.
    source : str
        Author, title, year and page or table.
    verified : str
        Texts in which the values were checked.
    notes : tuple of str
        Conditions in the source.
    """

    name: str
    original: str
    source: str
    verified: str
    ranges: Mapping[str, Range] = field(hash=False)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "ranges", MappingProxyType(dict(self.ranges)))

    def __reduce__(self) -> tuple[Any, ...]:
        return made_again(self)

    def __str__(self) -> str:
        lines = [f"{self.name} ({self.original})"]
        lines += [f"  {symbol}: {values} – {values.meaning}" for symbol, values in self.ranges.items()]
        lines += [f"  source: {self.source}", f"  read in: {self.verified}"]
        return "\n".join(lines + [f"  note: {note}" for note in self.notes])

    def choose(self, symbol: str, choice: Any) -> tuple[Any, str]:
        """Return the value of a property, and a text on the choice.

        Parameters
        ----------
        symbol
            Symbol of the property, a key of ``ranges``.
        choice
            ``"min"``, ``"mean"`` (the middle of the range) or ``"max"``, or a quantity within the range.

        Returns
        -------
        quantity, str

        Raises
        ------
        UnknownNameError
            If the entry has no such property.
        ModelError
            If the choice is of another kind, or outside the range.
        """
        check_known(symbol, self.ranges, f"library: {self.name!r} has no")
        published = self.ranges[symbol]
        low, high = published.si
        if isinstance(choice, str) and choice in _CHOICES:
            weight = _CHOICES.index(choice) / 2
            value = (1 - weight) * low + weight * high
            number = (1 - weight) * published.low + weight * published.high
            chosen = Range(number, number, published.unit, published.dimension, published.meaning)
            text = str(published) if low == high else f"{chosen}, {choice} of {published}"
        else:
            if choice is None or (isinstance(choice, str) and not choice[:1].isdigit()):
                msg = (
                    f"library: {symbol} of {self.name!r}: {shown(choice)} is not a choice; give 'min', 'mean' or "
                    f"'max', or a value within {published}"
                )
                raise ModelError(msg)
            value = si(choice, published.dimension, f"library: {symbol} of {self.name!r}")
            if not low * (1 - 1e-9) <= value <= high * (1 + 1e-9):
                msg = (
                    f"library: {symbol} of {self.name!r}: {shown(choice)} is outside {published}; choose within the "
                    "range, or give the value to the material directly, with its own source"
                )
                raise ModelError(msg)
            text = f"{choice} within {published}"
        return to_quantity(value, published.dimension), f"{symbol} = {text}"

    def cited(self, words: list[str]) -> str:
        """Return the source of a material: chosen values and their source."""
        return f"{self.name}: {'; '.join(words)} ({self.source})"


def looked_up(name: Any, known: Mapping[str, _Entry], kind: str) -> _Entry:
    """Return the entry with a name, in English or as in the source, in upper or lower case.

    Raises
    ------
    UnknownNameError
        If no entry has this name.
    """
    if isinstance(name, str):
        for entry in known.values():
            if name.strip().casefold() in (entry.name.casefold(), entry.original.casefold()):
                return entry
    msg = f"library: no {kind} {shown(name)}; {did_you_mean(name if isinstance(name, str) else '', known)}"
    raise UnknownNameError(msg)
