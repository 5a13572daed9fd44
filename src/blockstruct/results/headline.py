"""The one number of a case that every text, figure and table shows."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from blockstruct.results.answer import LOAD_FACTOR, Answer
from blockstruct.vocabulary import DRIFTING, Flow, Status

#: Statuses of one run that are the answer to the case, whatever its other runs find: they are about the dead load.
_OF_DEAD_LOAD = (Status.UNSTABLE, Status.SELF_STRESS)
#: Relative difference of load factors up to which they are the same number, found twice.
_SAME = 1e-6


@dataclass(frozen=True, slots=True)
class Headline:
    """Load factor of a case to rely on, its range over the schedules that were run, and the associative bound.

    Attributes
    ----------
    status : Status
        Of the runs that the load factor stands for. ``depends_on_self_stress`` if any run ended so: it is a finding
        about the dead load.
    lowest, highest : float
        Lowest and highest certified load factor of the runs that settled, or of all where none has, or only those of
        the shift; NaN without any.
        The run as given counts as the lowest where no other is below it by more than a millionth.
    certified, schedules : int
        How many runs ended with a certified load factor, of how many.
    associative : float
        Load factor with associative flow, above all non-associative ones; infinite where that is unbounded, so that it
        bounds nothing; NaN where it was not found.
    flow : Flow
    drifting : tuple of float
        Certified load factors that were still drifting when their runs were stopped, sorted. Another schedule would
        have stopped at another one, so that they count only where no run has settled, or those of the shift alone.
    shift_alone : bool
        Whether the runs that settled are all of the shifted objective, above runs that drift. It does not drift, and
        often ends high: jammed blocks carry a multiple of what other procedures find. So all certified runs count.
    answer : Answer
        What the number is called and how it is written. The reaction of a settlement is minus its load factor times a
        force: the lowest load factor is the largest reaction.
    """

    status: Status
    lowest: float
    highest: float
    certified: int
    schedules: int
    associative: float
    flow: Flow
    drifting: tuple[float, ...] = ()
    shift_alone: bool = False
    answer: Answer = field(default=LOAD_FACTOR, repr=False)

    @classmethod
    def of(
        cls,
        ends: Sequence[tuple[Status, float, bool]],
        flow: Flow,
        associative: float,
        answer: Answer = LOAD_FACTOR,
        *,
        shift_alone: bool = False,
    ) -> Self:
        """Headline of the runs of one case: status, load factor and whether it settled, the one as given first."""
        certified = [load_factor for status, load_factor, _ in ends if status is Status.CONVERGED]
        settled = [load_factor for status, load_factor, at_rest in ends if status is Status.CONVERGED and at_rest]
        drifting = [load_factor for status, load_factor, at_rest in ends if status is Status.CONVERGED and not at_rest]
        statuses = [status for status, *_ in ends]
        counted = certified if shift_alone else settled or certified
        lowest = min(counted, default=np.nan)
        # The run as given is the first: its number is among those that count, or it did not converge, or drifts.
        if ends[0][1] in counted and is_same(ends[0][1], lowest):
            lowest = ends[0][1]
        of_dead_load = [status for status in statuses if status in _OF_DEAD_LOAD]
        status = of_dead_load[0] if of_dead_load else Status.CONVERGED if certified else statuses[0]
        return cls(
            status=status,
            lowest=lowest,
            highest=max(counted, default=np.nan),
            certified=len(certified),
            schedules=len(ends),
            associative=associative,
            flow=flow,
            drifting=tuple(sorted(drifting)),
            shift_alone=shift_alone,
            answer=answer,
        )

    @property
    def load_factor(self) -> float:
        """The load factor to rely on: :attr:`lowest`; infinite if unbounded, NaN with any other status."""
        if self.status is Status.CONVERGED:
            return self.lowest
        return np.inf if self.status is Status.UNBOUNDED else np.nan

    @property
    def number(self) -> str:
        """The load factor, or the reaction, to four digits, ``infinite`` or ``none``."""
        return self.answer.text(self.load_factor, 4)

    @property
    def range(self) -> str:
        """How far the schedules lie apart, and how many were certified or drifted; empty for a run that settled."""
        return self._range(4)

    @property
    def bound(self) -> str:
        """The associative bound of a non-associative case in words; empty where it was not found."""
        return self._bound(4)

    @property
    def first(self) -> str:
        """Which of several answers counts: the lowest load factor is the largest reaction."""
        return "largest" if self.answer.is_reaction else "lowest"

    @property
    def among(self) -> str:
        """Among which runs the number counts, and where those are that do not count; empty for a single run."""
        if self.schedules == 1 or not self.certified:
            return ""
        if self.shift_alone:
            return f"the {self.first} of {self.certified} certified runs, of which none but the shift had settled"
        settled, drifting = self.certified - len(self.drifting), len(self.drifting)
        counted = settled or drifting
        said = f"the {self.first} of {counted} certified runs" if counted > 1 else "that of the only certified run"
        if not drifting:
            return said
        if not settled:
            return f"{said}, {'none of which had' if drifting > 1 else 'which had not'} settled"
        ends = dict.fromkeys(self.answer.text(end, 4) for end in (self.drifting[0], self.drifting[-1]))
        return (
            f"{said} that settled ({drifting} more, at {' to '.join(ends)}, "
            f"{'was' if drifting == 1 else 'were'} still drifting when stopped)"
        )

    def text(self, digits: int = 4) -> str:
        """Number, range and bound, with so many digits."""
        number = self.answer.text(self.load_factor, digits)
        if self.status not in (Status.CONVERGED, Status.UNBOUNDED):
            number = f"{number}, {self.status.words}"
        more = "; ".join(filter(None, (self._range(digits), self._bound(digits))))
        return f"{number} ({more})" if more else number

    @property
    def of_one_schedule(self) -> str:
        """That another schedule may find a worse answer, as a sentence; empty of several, and with associative flow."""
        if self.schedules > 1 or self.flow is not Flow.NONASSOCIATIVE or self.status is not Status.CONVERGED:
            return ""
        worse = "larger" if self.answer.is_reaction else "lower"
        return f"One schedule found it; another may find a {worse} one: run a spread (spread=True)."

    def _range(self, digits: int) -> str:
        if self.schedules == 1:
            return f"{DRIFTING} when it was stopped" if self.drifting else ""
        settled = 0 if self.shift_alone else self.certified - len(self.drifting)
        said = f"{settled or self.certified} of {self.schedules} schedules certified"
        if self.drifting:
            which = "all but the shift " if self.shift_alone else "all " * (self.certified > 1)
            said += " and settled" if settled else f", {which}{DRIFTING}"
        if (settled or self.certified) > 1 and self.status is Status.CONVERGED:
            on = "down" if self.answer.is_reaction else "up"
            said = f"{self.first} of {said}, {on} to {self.answer.text(self.highest, digits)}"
        if self.drifting and settled:
            ends = (self.drifting[0], self.drifting[-1])
            apart = " to ".join(dict.fromkeys(self.answer.text(end, digits) for end in ends))
            said += f"; {len(self.drifting)} more {DRIFTING}, at {apart}"
        return said

    def _bound(self, digits: int) -> str:
        if self.flow is Flow.ASSOCIATIVE or np.isnan(self.associative):
            return ""
        bounded = np.isfinite(self.associative)
        return f"associative bound {self.answer.text(self.associative, digits)}" if bounded else "no associative bound"

    def __str__(self) -> str:
        return self.text()


def is_same(one: float, other: float) -> bool:
    """Whether two load factors are the same number, found twice."""
    return abs(one - other) <= _SAME * abs(other)


def path_text(found: tuple[float, float], answer: Answer) -> str:
    """What a load factor depends on along the loading path, in words."""
    ends = " to ".join(answer.text(end) for end in found)
    return f"along the loading path {ends} (by its steps and the shear stiffness of joints)"
