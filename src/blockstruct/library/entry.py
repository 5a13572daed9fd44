"""What entries of the library are made of: ranges of values, and where they come from."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, TypeVar

from blockstruct.errors import ModelError, UnknownNameError, shown
from blockstruct.keywords import did_you_mean, made_again
from blockstruct.units import parse, si, to_quantity

_Entry = TypeVar("_Entry", bound="Entry")

_CHOICES = ("min", "mean", "max")


@dataclass(frozen=True, slots=True)
class Range:
    """Least and greatest value of a property, as published.

    Attributes
    ----------
    low, high : float
        In ``unit``.
    unit : str
        As published.
    dimension : str
        A key of :data:`blockstruct.units.SI_UNITS`.
    meaning : str
        What the property is.
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
        """Least and greatest value in coherent SI units."""
        low, high = (si(parse(f"{v!r} {self.unit}", self.meaning), self.dimension, self.meaning) for v in self.ends)
        return low, high

    @property
    def ends(self) -> tuple[float, float]:
        """Least and greatest value, as published."""
        return float(self.low), float(self.high)


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A kind of masonry, or of joints, with ranges of values and their source.

    Attributes
    ----------
    name : str
    original : str
        Name in the source, if that is in another language, or what the entry stands for.
    ranges : dict of str to Range
        By the symbol of the property.
    source : str
        Author, title, year and place in it.
    verified : str
        In which texts these values were read.
    notes : tuple of str
        Conditions that the source attaches to them.
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
        lines += [f"  {symbol}: {found} – {found.meaning}" for symbol, found in self.ranges.items()]
        lines += [f"  source: {self.source}", f"  read in: {self.verified}"]
        return "\n".join(lines + [f"  note: {note}" for note in self.notes])

    def choose(self, symbol: str, choice: Any) -> tuple[Any, str]:
        """Value of a property, and the words that say how it was chosen.

        Parameters
        ----------
        symbol
            Of the property, a key of ``ranges``.
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
            If the choice is none of these, or beyond the range.
        """
        if symbol not in self.ranges:
            msg = f"library: {self.name!r} has no {symbol!r}; {did_you_mean(str(symbol), self.ranges)}"
            raise UnknownNameError(msg)
        found = self.ranges[symbol]
        low, high = found.si
        if isinstance(choice, str) and choice in _CHOICES:
            weight = _CHOICES.index(choice) / 2
            value = (1 - weight) * low + weight * high
            published = (1 - weight) * found.low + weight * found.high
            chosen = Range(published, published, found.unit, found.dimension, found.meaning)
            how = str(found) if low == high else f"{chosen}, {choice} of {found}"
        else:
            if choice is None or (isinstance(choice, str) and not choice[:1].isdigit()):
                msg = (
                    f"library: {symbol} of {self.name!r}: {shown(choice)} chooses no value; give 'min', 'mean' or "
                    f"'max', or a value within {found}"
                )
                raise ModelError(msg)
            value = si(choice, found.dimension, f"library: {symbol} of {self.name!r}")
            if not low * (1 - 1e-9) <= value <= high * (1 + 1e-9):
                msg = (
                    f"library: {symbol} of {self.name!r}: {shown(choice)} is beyond {found}; choose within it, or give "
                    "the value to the material itself, with a source of your own"
                )
                raise ModelError(msg)
            how = f"{choice} within {found}"
        return to_quantity(value, found.dimension), f"{symbol} = {how}"

    def cited(self, words: list[str]) -> str:
        """Text on chosen values and their source, for a material."""
        return f"{self.name}: {'; '.join(words)} ({self.source})"


def looked_up(name: Any, known: Mapping[str, _Entry], kind: str) -> _Entry:
    """Entry of a name, in English or as in its source, in upper or lower case.

    Raises
    ------
    UnknownNameError
        If there is none.
    """
    if isinstance(name, str):
        for entry in known.values():
            if name.strip().casefold() in (entry.name.casefold(), entry.original.casefold()):
                return entry
    msg = f"library: no {kind} {shown(name)}; {did_you_mean(name if isinstance(name, str) else '', known)}"
    raise UnknownNameError(msg)
