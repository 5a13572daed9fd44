"""The number of a case with its range and its bound."""

from dataclasses import dataclass, field

import numpy as np

from blockstruct.limit import Outcome
from blockstruct.text import LOAD_FACTOR, Answer, range_text, sentence
from blockstruct.vocabulary import Flow, Status


@dataclass(frozen=True, slots=True)
class Headline:
    """Load factor of a case, with its range and the associative bound.

    Attributes
    ----------
    outcome : Outcome
        How the case ended.
    flow : Flow
    associative : float
        Load factor with associative flow, an upper bound of every other flow rule; infinite if unbounded, NaN if
        unknown.
    path_range : tuple of float or None
        Lowest and highest load factor of the variants of the loading path; None if they were not run.
    answer : Answer
        Name and unit of the number. The reaction of a settlement is minus its load factor times a force, so the lowest
        load factor is the largest reaction.
    hung : tuple of str
        Blocks whose dead load depends on self-stress.
    """

    outcome: Outcome
    flow: Flow
    associative: float = np.nan
    path_range: tuple[float, float] | None = None
    answer: Answer = field(default=LOAD_FACTOR, repr=False)
    hung: tuple[str, ...] = ()

    @property
    def status(self) -> Status:
        """How the case ended."""
        return self.outcome.status

    @property
    def settled(self) -> bool:
        """Whether the load factor had settled when the procedure ended."""
        return self.outcome.settled

    @property
    def load_factor(self) -> float:
        """Load factor; infinite if unbounded, NaN with any other status."""
        return self.outcome.load_factor

    @property
    def lowest(self) -> float:
        """Load factor, or the lowest of the loading paths if that is lower."""
        return self.load_factor if self.path_range is None else min(self.load_factor, self.path_range[0])

    @property
    def number(self) -> str:
        """Load factor or reaction to four digits, ``infinite`` or ``none``."""
        return self.answer.text(self.load_factor, 4)

    @property
    def range(self) -> str:
        """Text of the range; empty without variants of the loading path."""
        return range_text(self.path_range, self.answer)

    @property
    def bound(self) -> str:
        """Text of the bound of a non-associative case; empty if unknown."""
        if self.flow is Flow.ASSOCIATIVE or np.isnan(self.associative):
            return ""
        bounded = np.isfinite(self.associative)
        return f"associative bound {self.answer.text(self.associative)}" if bounded else "no associative bound"

    def text(self, digits: int = 4) -> str:
        """Return the sentence on the case, with a number of significant digits."""
        return sentence(
            self.outcome, self.answer, bound=self.associative, path_range=self.path_range, hung=self.hung, digits=digits
        )

    def __str__(self) -> str:
        return self.text()
