"""The verdict of a check: the ratio to rely on, taken over every way to find it."""

from dataclasses import dataclass, field

import numpy as np

from blockstruct.arrays import SLIGHT, Array
from blockstruct.assess.limit_states import LimitState
from blockstruct.text import assessment
from blockstruct.text.note import Note
from blockstruct.vocabulary import Way


@dataclass(frozen=True, slots=True, eq=False)
class WayOfChecking:
    """One way to find capacity over demand.

    Attributes
    ----------
    way : Way
    alpha : float
        Multiplier of the weights P + Q.
    e_star : float
        Share of the mass that takes part.
    state : LimitState
        The limit state that the method relies on.
    motion : (blocks, 6) array or None
        Velocity of the centroids and angular velocity, SI; None for the collapse mechanism.
    load_factor : float
        Load factor of this way, relative to the one of the collapse state.
    is_estimate : bool
        Whether the first steps of a loading path give this load factor.
    """

    way: Way
    alpha: float
    e_star: float
    state: LimitState
    motion: Array | None = None
    load_factor: float = 1.0
    is_estimate: bool = False

    @property
    def name(self) -> str:
        """Name of the way."""
        return f"{self.way}{', estimated' * self.is_estimate}"

    def effect(self, ratio: float) -> float:
        """Return the relative change of a ratio, by the load factor or by the motion of this way."""
        return abs(1 - self.load_factor) if self.load_factor != 1 else abs(1 - self.state.ratio / ratio)


@dataclass(frozen=True, slots=True)
class Verdict:
    """The outcome of a check; ``print(verdict)`` gives the sentence that every output shows.

    Attributes
    ----------
    case : str
        Name of the case.
    direction : str
        Direction of its push, such as ``"+x"``.
    ways : tuple of WayOfChecking
        All ways that have a ratio, the lowest first. The verdict relies on the first.
    floor : float
        Ratio of a motion with e* = 1 that begins at the lowest load factor of the ways; no motion has less. NaN by
        displacement.
    open : tuple of Note
        Warnings to settle first. The check is not satisfied while there is one.
    settled : bool
        Whether the load factor has settled.
    run : str
        The variant of the path, or the remedy, that is relied on; empty for the case as given.
    """

    case: str
    direction: str
    ways: tuple[WayOfChecking, ...] = field(repr=False)
    floor: float
    open: tuple[Note, ...]
    settled: bool
    run: str = ""

    @property
    def governing(self) -> WayOfChecking:
        """The way with the lowest ratio."""
        return self.ways[0]

    @property
    def relied_on(self) -> str:
        """Name of that way, and of its run."""
        return f"{self.governing.name} [{self.run}]" if self.run else self.governing.name

    @property
    def state(self) -> LimitState:
        """Limit state of that way."""
        return self.governing.state

    @property
    def ratio(self) -> float:
        """Capacity over demand to rely on: the lowest."""
        return self.state.ratio

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest ratio over the load factors, each with the motion that needs the least acceleration."""
        least = {way.load_factor: way.state.ratio for way in reversed(self.ways)}
        return self.ratio, max(least.values())

    @property
    def alphas(self) -> tuple[float, float]:
        """Lowest and highest multiplier of all ways."""
        return min(way.alpha for way in self.ways), max(way.alpha for way in self.ways)

    @property
    def ag(self) -> float:
        """Ground acceleration that the structure bears in every way, m/s²."""
        return min(one.state.ag for one in self.ways)

    @property
    def satisfied(self) -> bool:
        """Whether every way satisfies the limit state, and no warning is open."""
        return self.settled and not self.open and all(one.state.satisfied for one in self.ways)

    @property
    def share(self) -> float:
        """Ground acceleration borne over the one of the site."""
        return self.ag / self.state.ag_site

    @property
    def outcome(self) -> str:
        """Whether the check is satisfied, and why if its ratio does not show it."""
        if not self.settled:
            return assessment.UNSETTLED
        state = self.state
        if self.open and state.satisfied:
            return assessment.open_warnings(len(self.open))
        return state.outcome

    @property
    def figures(self) -> str:
        """Clause on the motion that governs: its multiplier, its e* and the range of the ratio."""
        return assessment.governing_way(
            self.governing.way,
            self.governing.alpha,
            self.governing.e_star,
            run=self.run,
            ends=self.range,
            floor=self.floor if np.isfinite(self.floor) and self.floor < (1 - SLIGHT) * self.ratio else None,
            is_estimate=self.governing.is_estimate,
        )

    def __str__(self) -> str:
        state = self.state
        sentence = assessment.verdict(
            state.name, self.ratio, self.outcome, state.ag, state.ag_texts(), of_sld=state.of_sld
        )
        return " ".join(filter(None, [sentence, self.figures]))
