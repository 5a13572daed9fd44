"""Rubble: units of random lengths with a minimum overlap between courses."""

import random
from collections.abc import Sequence
from itertools import chain
from numbers import Integral

from attrs import Factory, define, field, frozen

from blockstruct.arrays import ROUNDING
from blockstruct.errors import ModelError, shown
from blockstruct.model.fields import LENGTH, ModelObject, named_arguments, scalar
from blockstruct.structures.builder import length

Interval = tuple[float, float]


def _seed(value: int, what: str = "") -> int:
    if isinstance(value, bool) or not isinstance(value, Integral):
        msg = f"{what} is {shown(value)}; give a whole number"
        raise ModelError(msg)
    return int(value)


@frozen(repr=False, field_transformer=named_arguments)
class Rubble(ModelObject):
    """Units of random lengths. The same seed gives the same wall on every machine.

    Parameters
    ----------
    seed
        A whole number.
    shortest, longest : quantity, length
        Limits of the lengths of units; the longest is at least twice the shortest. Two kinds of units may exceed the
        limits: a short separate part of a course, and a unit next to a ring or a slope.
    overlap : quantity, length
        Smallest distance of a head joint from the head joints of the course below.

    Attributes
    ----------
    shortest, longest, overlap : float
        m.

    Raises
    ------
    ModelError
        If the seed is not a whole number, or the limits contradict each other.
    """

    seed: int = field(converter=_seed)
    shortest: float = field(converter=length, metadata=LENGTH)
    longest: float = field(converter=length, metadata=LENGTH)
    overlap: float = field(converter=scalar, metadata=LENGTH)

    def __attrs_post_init__(self) -> None:
        if self.longest < 2 * self.shortest * (1 - ROUNDING):
            msg = (
                f"Rubble: longest {self.longest:.6g} m is less than twice the shortest, {self.shortest:.6g} m; widen "
                "the limits, so that units can fill every length"
            )
            raise ModelError(msg)
        if not 0 <= self.overlap <= self.longest / 2:
            msg = (
                f"Rubble: overlap {self.overlap:.6g} m; give zero or more, up to half the longest unit, "
                f"{self.longest / 2:.6g} m"
            )
            raise ModelError(msg)


@define
class RubbleJoints:
    """Random head joints of one rubble wall, from the bottom up, leaf by leaf."""

    rubble: Rubble
    wall: str
    below: dict[str, list[float]] = Factory(dict)
    current: dict[str, list[float]] = Factory(dict)
    course: int = 0
    chance: random.Random = field(init=False)

    @chance.default
    def _seeded(self) -> random.Random:
        # Python guarantees the numbers of random() for a seed. The distributions of numpy may change.
        return random.Random(f"{self.rubble.seed} {self.wall}")

    def joints(self, course: int, layer: str, part: Interval, others: Sequence[float]) -> list[float]:
        """Return the joints of a part of a course, in ascending order, with the overlap to lower and other joints.

        Raises
        ------
        ModelError
            If units within the limits cannot fill the part with the overlap.
        """
        if course != self.course:
            self.below, self.current, self.course = self.current, {}, course
        # A leaf bonds with the same leaf below. A course through all leaves bonds with all leaves.
        lower = self.below.get(layer, list(chain.from_iterable(self.below.values())))
        joints = self._drawn(part, [*lower, *others])
        if joints is None:
            limits = self.rubble
            msg = (
                f"rubble: course {course} from {part[0]:.6g} to {part[1]:.6g} m cannot be filled with units of "
                f"{limits.shortest:.6g} to {limits.longest:.6g} m that overlap by {limits.overlap:.6g} m; give a "
                "smaller overlap or wider limits"
            )
            raise ModelError(msg)
        self.current.setdefault(layer, []).extend(joints)
        return joints

    def _drawn(self, part: Interval, below: list[float]) -> list[float] | None:
        start, end = part
        least, most = self.rubble.shortest, self.rubble.longest
        if end - start < 2 * least:
            # Two units would be too short; one unit is within the limits.
            return []
        free = [(start + least, end - least)]
        for x in below:
            free = _without(free, (x - self.rubble.overlap, x + self.rubble.overlap))
        reaching = _reaching(free, end, least, most)
        joints: list[float] = []
        at = start
        while True:
            ends_here = at + least <= end <= at + most
            choice = [(max(a, at + least), min(b, at + most)) for a, b in reaching]
            choice = [(a, b) for a, b in choice if a <= b]
            if ends_here and (not choice or self.chance.random() < 0.5):
                return joints
            if not choice:
                return None
            at = self._one_of(choice)
            joints.append(at)

    def _one_of(self, intervals: list[Interval]) -> float:
        along = self.chance.random() * sum(b - a for a, b in intervals)
        for a, b in intervals:
            if along <= b - a:
                return a + along
            along -= b - a
        return intervals[-1][1]


def _reaching(free: list[Interval], end: float, least: float, most: float) -> list[Interval]:
    """Return the positions of a joint from which units within the limits can fill the rest up to the end."""
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
