"""Running bond: where the joints of a course lie."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from blockstruct.structures.openings import Opening

Interval = tuple[float, float]

#: Shortest piece that a joint may cut off, as a part of the unit.
SHORTEST = 0.25


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of a wall in its own plan: name, and where it lies along (u) and through (v) the wall, m."""

    name: str
    u: Interval
    v: Interval


@dataclass(frozen=True, slots=True)
class Bond:
    """Sizes of a wall in running bond, m."""

    unit_length: float
    course_height: float
    depth: float
    leaves: int
    header_every: int | None

    def course(
        self, number: int, parts: Sequence[Interval], origin: float, shifted: bool, openings: Sequence[Opening]
    ) -> Iterator[Unit]:
        """Units of one course, named ``number.k``.

        Parameters
        ----------
        number
            Of the course, from one.
        parts
            Where there is wall along u, but for openings.
        origin
            Where a whole unit begins, in courses that are not shifted by half a unit.
        shifted
            Whether this course is.
        openings
            All openings of the wall.
        """
        half = self.unit_length / 2
        cut = [o.courses(self.course_height) for o in openings]
        voids = [(o.start, o.end) for o, (low, high) in zip(openings, cut, strict=True) if low < number <= high]
        bearings = [half if o.bearing is None else float(o.bearing) for o in openings]
        lintels = [
            (o.start - bearing, o.end + bearing)
            for o, (_, high), bearing in zip(openings, cut, bearings, strict=True)
            if high == number - 1 and bearing > 0
        ]
        solid = without(parts, voids)
        spans = [(max(a, p), min(b, q)) for p, q in solid for a, b in lintels if min(b, q) > max(a, p)]
        rest = without(solid, spans)
        thin = self.depth / self.leaves
        if self.header_every and number % self.header_every == 0:
            layers = [("", (0.0, self.depth), half, half / 2)]
        else:
            layers = [
                (
                    chr(ord("a") + leaf) if self.leaves > 1 else "",
                    (leaf * thin, (leaf + 1) * thin),
                    self.unit_length,
                    half * ((leaf + shifted) % 2),
                )
                for leaf in range(self.leaves)
            ]
        for layer, v, length, shift in layers:
            pieces = [piece for part in rest for piece in self._pieces(part, length, origin + shift)]
            for k, u in enumerate(sorted(pieces), start=1):
                yield Unit(f"{number}.{k}{layer}", u, v)
        for k, u in enumerate(spans, start=1):
            yield Unit(f"{number}.lintel{k}", u, (0.0, self.depth))

    def _pieces(self, part: Interval, length: float, origin: float) -> list[Interval]:
        """A part of a course cut by the joints ``origin + k length``."""
        start, end = part
        shortest = SHORTEST * self.unit_length * (1 - 1e-9)
        first, last = np.ceil((start + shortest - origin) / length), np.floor((end - shortest - origin) / length)
        joints = [start, *(origin + length * np.arange(first, last + 1)).tolist(), end]
        return list(pairwise(joints))


def without(parts: Sequence[Interval], holes: Sequence[Interval]) -> list[Interval]:
    """What holes leave of parts of a line; slivers of rounding are left out."""
    left = list(parts)
    for low, high in holes:
        left = [
            piece
            for a, b in left
            for piece in ((a, min(b, low)), (max(a, high), b))
            if piece[1] - piece[0] > 1e-9 * (b - a)
        ]
    return left
