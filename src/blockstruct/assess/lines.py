"""A formula as an engineer hands it in: what it gives, with its numbers, and the paragraph it is from."""

from collections.abc import Sequence
from dataclasses import dataclass

#: Width of the first column on paper.
_WIDTH = 38
#: An acceleration of the ground that was not found among those that were tried.
BEYOND = "more than 10 g"
#: What stands beside formulas whose printed numbers do not give the last digit of the printed result.
ROUNDED = "Numbers are rounded where they are printed alone: each is calculated from unrounded ones."
#: What a check does not tell of its demand.
HIGHER = (
    "parts higher up that may move by themselves, such as gables, have a larger demand as a rule (floor spectra), and "
    "take checks of their own"
)


@dataclass(frozen=True, slots=True)
class Line:
    """One step of a calculation.

    Attributes
    ----------
    what : str
        What is calculated.
    formula : str
        The formula, its numbers and its value with the unit.
    source : str
        Paragraph and number of the formula; empty where there is none.
    """

    what: str
    formula: str
    source: str = ""

    def __str__(self) -> str:
        source = f"   [{self.source}]" if self.source else ""
        return f"{self.what:<{_WIDTH}}  {self.formula}{source}"


@dataclass(frozen=True, slots=True)
class Section:
    """Lines under a heading."""

    title: str
    lines: tuple[Line, ...]

    def __str__(self) -> str:
        return "\n".join([self.title, *(f"  {line}" for line in self.lines)])


def section(title: str, *lines: Line | Sequence[Line]) -> Section:
    """A section of lines, and of sequences of them."""
    flat: list[Line] = []
    for one in lines:
        flat += [one] if isinstance(one, Line) else one
    return Section(title, tuple(flat))


def shown(value: float, unit: str = "") -> str:
    """A number to four digits, with its unit.

    >>> shown(0.123456, "m/s²")
    '0.1235 m/s²'
    """
    return f"{value:.4g} {unit}".rstrip()


def told_apart(value: float, limit: float, digits: int = 4) -> tuple[str, str]:
    """A value and its limit to so many digits, or to as many as it takes to tell which is larger.

    >>> told_apart(0.99996, 1.0)
    ('0.99996', '1')
    >>> told_apart(1.5, 1.0)
    ('1.5', '1')
    """
    # 17 digits tell any two doubles apart.
    texts = [(f"{value:.{n}g}", f"{limit:.{n}g}") for n in range(digits, 18)]
    return next((pair for pair in texts if pair[0] != pair[1]), texts[0])


def in_g(acceleration: float, gravity: float) -> str:
    """An acceleration in m/s² and as a share of gravity; infinite is more than was looked for."""
    if acceleration == float("inf"):
        return BEYOND
    return f"{acceleration:.4g} m/s² = {acceleration / gravity:.4g} g"
