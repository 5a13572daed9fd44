"""Lines of a calculation: quantity, formula with its numbers, and paragraph."""

from collections.abc import Sequence
from dataclasses import dataclass

#: Remark on printed numbers that do not reproduce the last digit of a result.
ROUNDED = "Printed numbers are rounded; each result is calculated from unrounded numbers."
#: Remark on demands that a check does not cover.
HIGHER = (
    "parts higher up that may move alone, such as gables, usually have a larger demand (floor spectra) and need "
    "checks of their own"
)


@dataclass(frozen=True, slots=True)
class Line:
    """One step of a calculation.

    Attributes
    ----------
    what : str
        Name of the quantity.
    formula : str
        The formula, its numbers and its value with the unit.
    source : str
        Paragraph and number of the formula; empty without one.
    """

    what: str
    formula: str
    source: str = ""


@dataclass(frozen=True, slots=True)
class Section:
    """Lines under a heading.

    Attributes
    ----------
    title : str
    lines : tuple of Line
    is_detail : bool
        Whether the verdict is independent of them, as of the lines of another limit state.
    """

    title: str
    lines: tuple[Line, ...]
    is_detail: bool = False

    def __str__(self) -> str:
        width = max((len(line.what) for line in self.lines), default=0)
        sources = (f"   [{line.source}]" if line.source else "" for line in self.lines)
        rows = (f"  {x.what:<{width}}  {x.formula}{source}" for x, source in zip(self.lines, sources, strict=True))
        return "\n".join([self.title, *rows])


def section(title: str, *lines: Line | Sequence[Line], is_detail: bool = False) -> Section:
    """Return a section of lines and sequences of lines."""
    flat: list[Line] = []
    for one in lines:
        flat += [one] if isinstance(one, Line) else one
    return Section(title, tuple(flat), is_detail)
