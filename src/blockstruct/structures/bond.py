"""Bonds: positions of the joints of a course."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.geometry.tolerances import GRID
from blockstruct.structures.cut import cut
from blockstruct.structures.openings import AnyOpening, Opening
from blockstruct.structures.rubble import RubbleJoints

Array = NDArray[np.float64]
Interval = tuple[float, float]

#: Shortest piece at the end of a course, as a fraction of the unit.
SHORTEST = 0.25


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of a wall: its name, and its extent along (u) and through (v) the wall, m.

    A unit that is not a box has an outline (k, 2), along and up the wall.
    """

    name: str
    u: Interval
    v: Interval
    outline: Array | None = None


@dataclass(frozen=True, slots=True)
class Bond:
    """Sizes of a wall in running bond or of rubble, m."""

    unit_length: float
    course_height: float
    depth: float
    leaves: int
    header_every: int | None

    def course(
        self,
        number: int,
        parts: Sequence[Interval],
        origin: float,
        shifted: bool,
        openings: Sequence[AnyOpening],
        *,
        rubble: RubbleJoints | None = None,
        gaps: Sequence[Interval] = (),
        within: Any = None,
        top: float | None = None,
    ) -> Iterator[Unit]:
        """Yield the units of one course, named ``number.k``.

        Parameters
        ----------
        number
            Number of the course, from one.
        parts
            Parts of the course along u, before openings are subtracted.
        origin
            Start of a whole unit in courses that are not shifted.
        shifted
            Whether this course is shifted by half a unit.
        openings
            All openings of the wall.
        rubble
            Joints of rubble, instead of the regular joints.
        gaps
            Extents of other walls that cross this wall, in this course or the next.
        within
            Polygon of the wall, along and up the wall, if it is not a rectangle.
        top
            Upper side of the course, if its height differs from the other courses.
        """
        half = self.unit_length / 2
        plain = [o for o in openings if isinstance(o, Opening)]
        cut_by = [o.courses(self.course_height) for o in plain]
        voids = [(o.start, o.end) for o, (low, high) in zip(plain, cut_by, strict=True) if low < number <= high]
        lintels = {
            at: [
                (o.start - bearing, o.end + bearing)
                for o, (_, high) in zip(plain, cut_by, strict=True)
                if high == at - 1
                and (bearing := half if o.bearing is None else float(o.bearing)) > 0
                and o.rise is None
            ]
            for at in (number - 1, number, number + 1)
        }
        solid = without(parts, voids)
        spans = [(max(a, p), min(b, q)) for p, q in solid for a, b in lintels[number] if min(b, q) > max(a, p)]
        rest = without(solid, spans)
        foot, head = (number - 1) * self.course_height, top or number * self.course_height
        shapes = [o.outline(self.course_height) for o in openings if o.voussoirs is not None]
        shapes = [shape for shape in shapes if shape.bounds[1] < head and shape.bounds[3] > foot]
        self._check_bearings(number, spans)
        for a, b in spans:
            self._check_lintel(number, shapely.box(a, foot, b, head), shapes, within)
        if rubble is not None:
            known = [x for ends in (*gaps, *lintels[number - 1], *lintels[number + 1]) for x in ends]
        # The grid closes slits and necks of rounding between rings that touch.
        grid = float(np.exp2(np.floor(np.log2(GRID * self.course_height))))
        for layer, v, length, shift in self._layers(number, shifted):
            units: list[tuple[Interval, Array | None]] = []
            for part in rest:
                if rubble is None:
                    joints = self._joints(part, length, origin + shift)
                else:
                    joints = rubble.joints(number, layer, part, known)
                region = shapely.box(part[0], foot, part[1], head)
                remaining = shapely.difference(region, shapely.union_all(shapes), grid_size=grid) if shapes else region
                remaining = remaining if within is None else shapely.intersection(remaining, within, grid_size=grid)
                if top is None and region.area - remaining.area <= 1e-9 * region.area:
                    lines = [part[0], *(joints if rubble else self._apart(part, joints)), part[1]]
                    units += [(u, None) for u in pairwise(lines)]
                else:
                    smallest = SHORTEST * self.unit_length * self.course_height * (1 - 1e-9)
                    outlines = cut(remaining, joints, smallest)
                    units += [((float(o[:, 0].min()), float(o[:, 0].max())), o) for o in outlines]
            for k, (u, outline) in enumerate(sorted(units, key=lambda unit: sum(unit[0])), start=1):
                yield Unit(f"{number}.{k}{layer}", u, v, outline)
        for k, u in enumerate(spans, start=1):
            yield Unit(f"{number}.lintel{k}", u, (0.0, self.depth))

    def _layers(self, number: int, shifted: bool) -> list[tuple[str, Interval, float, float]]:
        """Return name, extent through the wall, unit length and shift of the joints for each leaf, or for headers."""
        half, thin = self.unit_length / 2, self.depth / self.leaves
        if self.header_every and number % self.header_every == 0:
            return [("", (0.0, self.depth), half, half / 2)]
        return [
            (
                chr(ord("a") + leaf) if self.leaves > 1 else "",
                (leaf * thin, (leaf + 1) * thin),
                self.unit_length,
                half * ((leaf + shifted) % 2),
            )
            for leaf in range(self.leaves)
        ]

    def _joints(self, part: Interval, length: float, origin: float) -> list[float]:
        """Return the joints ``origin + k length`` within a part of a course."""
        first, last = np.ceil((part[0] - origin) / length), np.floor((part[1] - origin) / length)
        joints: list[float] = (origin + length * np.arange(first, last + 1)).tolist()
        return joints

    def _apart(self, part: Interval, joints: Sequence[float]) -> list[float]:
        """Return the joints that leave no short piece at an end of a part."""
        shortest = SHORTEST * self.unit_length * (1 - 1e-9)
        return [x for x in joints if part[0] + shortest <= x <= part[1] - shortest]

    def _check_bearings(self, course: int, spans: Sequence[Interval]) -> None:
        for (_, end), (start, _) in pairwise(sorted(spans)):
            if start < end - 1e-9 * self.unit_length:
                msg = (
                    f"wall: two lintels of course {course} overlap from {start:.6g} to {end:.6g} m; give the openings "
                    "a shorter bearing: zero, or at most half the wall between them"
                )
                raise ModelError(msg)

    def _check_lintel(self, course: int, lintel: Any, shapes: Sequence[Any], within: Any) -> None:
        slack = 1e-9 * lintel.area
        meets = any(shapely.intersection(lintel, shape).area > slack for shape in shapes)
        if meets or (within is not None and shapely.difference(lintel, within).area > slack):
            a, _, b, _ = lintel.bounds
            obstacle = "a ring of voussoirs" if meets else "a slope"
            msg = (
                f"wall: the lintel of course {course}, from {a:.6g} to {b:.6g} m, meets {obstacle}; move the opening, "
                "or make its bearing shorter or zero"
            )
            raise ModelError(msg)


def without(parts: Sequence[Interval], holes: Sequence[Interval]) -> list[Interval]:
    """Subtract holes from parts of a line; slivers of rounding are dropped."""
    left = list(parts)
    for low, high in holes:
        left = [
            piece
            for a, b in left
            for piece in ((a, min(b, low)), (max(a, high), b))
            if piece[1] - piece[0] > 1e-9 * (b - a)
        ]
    return left
