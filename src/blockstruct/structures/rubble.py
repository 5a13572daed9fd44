"""Rubble: units of random lengths, with a least overlap from course to course."""

import operator
import random
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

from blockstruct.errors import ModelError, shown
from blockstruct.model.checks import positive_length
from blockstruct.units import si

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Rubble:
    """Units of random lengths: the same seed gives the same wall, on every machine.

    Parameters
    ----------
    seed
        A whole number.
    shortest, longest : quantity, length
        Limits of the lengths of units, the longest at least twice the shortest. Only a part of a course that is shorter
        by itself, and what stays with a neighbour beside a ring or a slope, is beyond them.
    overlap : quantity, length
        Least distance of a head joint from those in the course below.

    Attributes
    ----------
    shortest, longest, overlap : float
        m.

    Raises
    ------
    ModelError
        If the seed is not a whole number, or no wall can keep the limits.
    """

    seed: Any
    shortest: Any
    longest: Any
    overlap: Any

    def __post_init__(self) -> None:
        try:
            seed = operator.index(self.seed)
        except TypeError:
            seed = None
        if seed is None or isinstance(self.seed, bool):
            msg = f"rubble: seed {shown(self.seed)}; give a whole number, by which the wall can be built again"
            raise ModelError(msg)
        object.__setattr__(self, "seed", seed)
        for name in ("shortest", "longest"):
            object.__setattr__(self, name, positive_length(getattr(self, name), f"rubble: {name}"))
        object.__setattr__(self, "overlap", si(self.overlap, "length", "rubble: overlap"))
        if self.longest < 2 * self.shortest * (1 - 1e-9):
            msg = (
                f"rubble: longest {self.longest:.6g} m is less than twice the shortest, {self.shortest:.6g} m: not "
                "every length can be made of such units; widen the limits"
            )
            raise ModelError(msg)
        if not 0 <= self.overlap <= self.longest / 2:
            msg = (
                f"rubble: overlap {self.overlap:.6g} m; give zero or more, up to half the longest unit, "
                f"{self.longest / 2:.6g} m"
            )
            raise ModelError(msg)


@dataclass(slots=True)
class RubbleJoints:
    """Head joints of the rubble of one wall, drawn from below, leaf by leaf."""

    rubble: Rubble
    wall: str
    chance: random.Random = field(init=False)
    below: dict[str, list[float]] = field(default_factory=dict)
    own: dict[str, list[float]] = field(default_factory=dict)
    course: int = 0

    def __post_init__(self) -> None:
        # Python keeps the numbers of random() for a seed; those of numpy's distributions may change.
        self.chance = random.Random(f"{self.rubble.seed} {self.wall}")

    def joints(self, course: int, layer: str, part: Interval, others: Sequence[float]) -> list[float]:
        """Joints within a part of a course, in ascending order; they overlap with those below, and with others, too.

        Raises
        ------
        ModelError
            If units within the limits cannot fill the part with the overlap.
        """
        if course != self.course:
            self.below, self.own, self.course = self.own, {}, course
        # Leaves bond with their own course below; a course through all leaves with all of them.
        lower = self.below.get(layer, list(chain.from_iterable(self.below.values())))
        found = self._drawn(part, [*lower, *others])
        if found is None:
            limits = self.rubble
            msg = (
                f"rubble: course {course} from {part[0]:.6g} to {part[1]:.6g} m cannot be filled with units of "
                f"{limits.shortest:.6g} to {limits.longest:.6g} m that overlap by {limits.overlap:.6g} m; give a "
                "smaller overlap or wider limits"
            )
            raise ModelError(msg)
        self.own.setdefault(layer, []).extend(found)
        return found

    def _drawn(self, part: Interval, below: list[float]) -> list[float] | None:
        start, end = part
        least, most = self.rubble.shortest, self.rubble.longest
        if end - start < 2 * least:
            # Two units would be too short, one is not too long.
            return []
        free = [(start + least, end - least)]
        for x in below:
            free = _without(free, (x - self.rubble.overlap, x + self.rubble.overlap))
        reaching = _reaching(free, end, least, most)
        found: list[float] = []
        at = start
        while True:
            ends_here = at + least <= end <= at + most
            choice = [(max(a, at + least), min(b, at + most)) for a, b in reaching]
            choice = [(a, b) for a, b in choice if a <= b]
            if ends_here and (not choice or self.chance.random() < 0.5):
                return found
            if not choice:
                return None
            at = self._one_of(choice)
            found.append(at)

    def _one_of(self, intervals: list[Interval]) -> float:
        along = self.chance.random() * sum(b - a for a, b in intervals)
        for a, b in intervals:
            if along <= b - a:
                return a + along
            along -= b - a
        return intervals[-1][1]


def _reaching(free: list[Interval], end: float, least: float, most: float) -> list[Interval]:
    """Where a joint may lie so that others within the limits lead on to the end."""
    reached: list[Interval] = []
    goal = [(end, end)]
    while goal:
        back = [(a - most, b - least) for a, b in goal]
        new = [(max(a, low), min(b, high)) for low, high in back for a, b in free if min(b, high) >= max(a, low)]
        goal = [piece for piece in _union(new) if not any(a <= piece[0] and piece[1] <= b for a, b in reached)]
        reached = _union(reached + goal)
    return reached


def _union(intervals: list[Interval]) -> list[Interval]:
    joined: list[Interval] = []
    for a, b in sorted(intervals):
        if joined and a <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(b, joined[-1][1]))
        else:
            joined.append((a, b))
    return joined


def _without(intervals: list[Interval], hole: Interval) -> list[Interval]:
    low, high = hole
    pieces = [piece for a, b in intervals for piece in ((a, min(b, low)), (max(a, high), b))]
    return [(a, b) for a, b in pieces if a <= b]
