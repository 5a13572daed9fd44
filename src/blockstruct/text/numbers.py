"""Numbers as text, and the name and format of the number of a case."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from blockstruct.arrays import NEGLIGIBLE
from blockstruct.limit.settlement import reaction_unit
from blockstruct.model import Case, Model, SettlementCase
from blockstruct.units import readable, to_quantity


@dataclass(frozen=True, slots=True)
class Answer:
    """Name, symbol and unit of the number of a case.

    The number is a load factor or, for a settlement, a reaction.

    Attributes
    ----------
    name : str
        ``"load factor"`` or ``"reaction"``.
    symbol : str
    dimension : str
        A key of :data:`blockstruct.units.SI_UNITS`.
    factor : float
        SI value of the answer at load factor 1.
    """

    name: str = "load factor"
    symbol: str = "α"
    dimension: str = "dimensionless"
    factor: float = 1.0

    @classmethod
    def of(cls, model: Model, case: Case) -> Self:
        """Return the answer of a case."""
        if not isinstance(case, SettlementCase):
            return cls()
        dimension = "force" if case.about is None else "moment"
        return cls("reaction", "R", dimension, -reaction_unit(model, case))

    @property
    def is_reaction(self) -> bool:
        """Whether the case is a settlement."""
        return self.dimension != "dimensionless"

    @property
    def unit(self) -> str:
        """Symbol of the SI unit; empty for a load factor."""
        return {"force": "N", "moment": "N·m"}.get(self.dimension, "")

    def quantity(self, alpha: Any) -> Any:
        """Return the answers at load factors, as quantities."""
        values = self.factor * np.asarray(alpha, dtype=float) + 0.0
        return to_quantity(values if values.ndim else float(values), self.dimension)

    def text(self, alpha: float, digits: int = 4) -> str:
        """Return the answer at a load factor as text: a number, ``infinite`` or ``none``."""
        return self.format(self._value(alpha), digits)

    def ends(self, alphas: tuple[float, float], digits: int = 4) -> tuple[str, str]:
        """Return both ends of a range of load factors as texts, the smaller number first, in one unit."""
        low, high = sorted(map(self._value, alphas))
        return self.format(low, digits, alongside=high), self.format(high, digits, alongside=low)

    def _value(self, alpha: float) -> float:
        """Return the answer in SI; zero for a reaction that is rounding beside the dead load."""
        return 0.0 if self.is_reaction and abs(alpha) <= NEGLIGIBLE else self.factor * alpha + 0.0

    def format(self, value: float, digits: int = 4, *, alongside: float = 0.0) -> str:
        """Return an answer in SI as text, in the unit that suits the larger of two values."""
        if np.isnan(value):
            return "none"
        if np.isinf(value):
            return "infinite" if value > 0 else "minus infinite"
        if not self.is_reaction:
            return f"{value:.{digits}g}"
        scale, unit = readable(max(value, alongside, key=abs) if np.isfinite(alongside) else value, self.unit)
        return f"{value * scale:.{digits}g} {unit}"


#: Answer of a limit case.
LOAD_FACTOR = Answer()


#: An acceleration beyond the largest that a check tries.
BEYOND = "more than 10 g"


def shown(value: float, unit: str = "") -> str:
    """Return a number to four digits, with its unit.

    >>> shown(0.123456, "m/s²")
    '0.1235 m/s²'
    """
    return f"{value:.4g} {unit}".rstrip()


def told_apart(value: float, limit: float, digits: int = 4) -> tuple[str, str]:
    """Return a value and its limit with enough digits to distinguish them.

    >>> told_apart(0.99996, 1.0)
    ('0.99996', '1')
    >>> told_apart(1.5, 1.0)
    ('1.5', '1')
    """
    # 17 digits distinguish any two doubles.
    texts = [(f"{value:.{n}g}", f"{limit:.{n}g}") for n in range(digits, 18)]
    return next((pair for pair in texts if pair[0] != pair[1]), texts[0])


def ratio_text(ratio: float, digits: int = 4) -> str:
    """Return capacity over demand with enough digits to show on which side of one it lies."""
    return told_apart(ratio, 1.0, digits)[0]


def in_g(acceleration: float, gravity: float) -> str:
    """Return an acceleration in m/s² and as a share of gravity."""
    if np.isinf(acceleration):
        return BEYOND
    return f"{acceleration:.4g} m/s² = {acceleration / gravity:.4g} g"
