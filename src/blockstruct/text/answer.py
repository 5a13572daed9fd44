"""What the number of a case is called, and how it is written."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from blockstruct.limit import reaction_unit
from blockstruct.model import Case, Model, SettlementCase
from blockstruct.units import readable, to_quantity


@dataclass(frozen=True, slots=True)
class Answer:
    """The number that a case asks for: its load factor or, of a settlement, its reaction.

    Attributes
    ----------
    name : str
        ``"load factor"`` or ``"reaction"``.
    symbol : str
    dimension : str
        A key of :data:`blockstruct.units.SI_UNITS`.
    factor : float
        Of a load factor α: the answer is ``factor α``, in SI.
    """

    name: str = "load factor"
    symbol: str = "α"
    dimension: str = "dimensionless"
    factor: float = 1.0

    @classmethod
    def of(cls, model: Model, case: Case) -> Self:
        """Answer to a case."""
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
        """Symbol of the unit of the answer; empty for a load factor."""
        return {"force": "N", "moment": "N·m"}.get(self.dimension, "")

    def quantity(self, alpha: Any) -> Any:
        """Answer, or answers, at load factors."""
        values = self.factor * np.asarray(alpha, dtype=float) + 0.0
        return to_quantity(values if values.ndim else float(values), self.dimension)

    def text(self, alpha: float, digits: int = 4) -> str:
        """The answer at a load factor to so many digits, ``infinite`` or ``none``."""
        return self.said(self.factor * alpha + 0.0, digits)

    def ends(self, alphas: tuple[float, float], digits: int = 4) -> tuple[str, str]:
        """Both ends of a range of load factors, the smaller number first and in one unit."""
        low, high = sorted(self.factor * alpha + 0.0 for alpha in alphas)
        return self.said(low, digits, beside=high), self.said(high, digits, beside=low)

    def said(self, value: float, digits: int = 4, *, beside: float = 0.0) -> str:
        """A value of the answer, in SI, as :meth:`text`; in the unit of the larger one beside which it stands."""
        if np.isnan(value):
            return "none"
        if np.isinf(value):
            return "infinite" if value > 0 else "minus infinite"
        if not self.is_reaction:
            return f"{value:.{digits}g}"
        scale, unit = readable(max(value, beside, key=abs) if np.isfinite(beside) else value, self.unit)
        return f"{value * scale:.{digits}g} {unit}"


#: The answer to a limit case.
LOAD_FACTOR = Answer()
