"""Bonds and the panels of a wall: positions of the joints of a course, and cuts at rings and slopes."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import shapely

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array
from blockstruct.errors import ModelError
from blockstruct.geometry.polyhedron import box, lofted
from blockstruct.geometry.tolerances import GRID
from blockstruct.model import Block, Material
from blockstruct.structures.builder import block
from blockstruct.structures.openings import QUARTER, AnyOpening, Opening
from blockstruct.structures.rubble import RubbleJoints


def cut(region: Any, joints: Sequence[float], smallest: float) -> list[Array]:
    """Return the outlines (k, 2) of the pieces between vertical joints of a region, in the order of their centroids.

    A joint is dropped if a piece next to it would be smaller than the ``smallest`` area or not connected. A separate
    part of the region stays a piece even if it is smaller.

    Raises
    ------
    ModelError
        If a hole of the region lies within one piece.
    """
    outlines = []
    for part in shapely.get_parts(region):
        if part.area <= ROUNDING * smallest:
            continue
        low, foot, high, top = part.bounds
        lines = [low, *sorted(x for x in joints if low + ROUNDING < x < high - ROUNDING), high]
        while True:
            pieces = [shapely.intersection(part, shapely.box(a, foot, b, top)) for a, b in pairwise(lines)]
            bad = [k for k, piece in enumerate(pieces) if piece.area < smallest or not _is_whole(piece)]
            if not bad or len(lines) == 2:
                break
            k = bad[0]
            # The bad piece joins its smaller neighbour. Piece k lies between lines k and k + 1.
            neighbours = [(pieces[j].area, line) for j, line in ((k - 1, k), (k + 1, k + 1)) if 0 <= j < len(pieces)]
            del lines[min(neighbours)[1]]
        if not all(map(_is_whole, pieces)):
            msg = (
                f"wall: between {low:.6g} and {high:.6g} m along the wall a ring of voussoirs lies within one unit of "
                f"the course from {foot:.6g} to {top:.6g} m; give lower courses, or a larger opening"
            )
            raise ModelError(msg)
        outlines += pieces
    outlines.sort(key=lambda piece: piece.centroid.x)
    return [_clean(shapely.get_coordinates(piece)[:-1]) for piece in outlines]


def _clean(outline: Array) -> Array:
    """Return the outline without repeated corners and without corners on a line with their neighbours."""
    size = float(np.ptp(outline, axis=0).max())
    kept = list(outline)
    k = 0
    while len(kept) > 3 and k < len(kept):
        before, here, after = kept[k - 1], kept[k], kept[(k + 1) % len(kept)]
        base = after - before
        off = (here - before)[0] * base[1] - (here - before)[1] * base[0]
        if np.linalg.norm(here - before) < ROUNDING * size or abs(off) < ROUNDING * size * np.linalg.norm(base):
            del kept[k]
            k = max(k - 1, 0)
        else:
            k += 1
    return np.array(kept)


def _is_whole(piece: Any) -> bool:
    return piece.geom_type == "Polygon" and not len(piece.interiors)


Interval = tuple[float, float]


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
    """Sizes of a wall in running bond or of rubble, m: the grid of its units."""

    unit_length: float
    course_height: float
    thickness: float
    leaves: int = 1
    header_every: int | None = None

    @property
    def smallest(self) -> float:
        """Area of the smallest piece that a cut may leave, m²."""
        return QUARTER * self.unit_length * self.course_height

    def layers(self, number: int, shifted: bool) -> list[tuple[str, Interval, float, float]]:
        """Return name, extent through the wall, unit length and shift of the joints for each leaf, or for headers."""
        half, thin = self.unit_length / 2, self.thickness / self.leaves
        if self.header_every and number % self.header_every == 0:
            return [("", (0.0, self.thickness), half, half / 2)]
        return [
            (
                chr(ord("a") + leaf) if self.leaves > 1 else "",
                (leaf * thin, (leaf + 1) * thin),
                self.unit_length,
                half * ((leaf + shifted) % 2),
            )
            for leaf in range(self.leaves)
        ]

    def clear(self, joints: Sequence[float], faces: Sequence[float]) -> list[float]:
        """Return the joints that are not near a face of a wall that crosses, so that a unit joins both walls."""
        shortest = QUARTER * self.unit_length * (1 - ROUNDING)
        return [x for x in joints if all(abs(x - face) >= shortest for face in faces)]

    def apart(self, part: Interval, joints: Sequence[float]) -> list[float]:
        """Return the joints that leave no short piece at an end of a part."""
        shortest = QUARTER * self.unit_length * (1 - ROUNDING)
        return [x for x in joints if part[0] + shortest <= x <= part[1] - shortest]


@dataclass(frozen=True, slots=True)
class Panel:
    """A straight part of a wall on the grid of its bond: the wall itself, a sidewall or a buttress.

    Attributes
    ----------
    name
        Start of the names of its units.
    bond
        Sizes of the units.
    axes : (3, 3) array
        Direction along the panel (u), direction through it (v), and its origin, m.
    heads
        Upper side of each course, m.
    extent
        Start and end along u.
    openings
        All openings of the panel.
    crossings
        Start and end of each panel that extends through this one in every second course, and the last such course.
    back, ahead
        Lengths by which every second course of this panel extends beyond its start and its end.
    origin
        Start of a whole unit in courses that are not shifted.
    shifts_odd
        Whether courses of odd numbers are shifted by half a unit. Otherwise courses of even numbers are.
    within
        Polygon of the panel along and up, if it is not a rectangle.
    rubble
        Joints of rubble, instead of the regular joints.
    """

    name: str
    bond: Bond
    axes: Array
    heads: Sequence[float]
    extent: Interval
    openings: Sequence[AnyOpening] = ()
    crossings: Sequence[tuple[float, float, int]] = ()
    back: float = 0.0
    ahead: float = 0.0
    origin: float = 0.0
    shifts_odd: bool = False
    within: Any = None
    rubble: RubbleJoints | None = None

    def units(self, number: int) -> Iterator[Unit]:
        """Yield the units of one course, named ``number.k``. Courses are numbered from one.

        Rubble remembers the joints of the course below: its courses are taken in order, once each.
        """
        bond, is_odd = self.bond, number % 2 == 1
        lintels = [span for part in self._parts(number) for span in _common(part, self._lintels(number))]
        between_lintels = _without(self._parts(number), lintels)
        foot, head = (number - 1) * bond.course_height, self.heads[number - 1]
        shapes = [o.outline(bond.course_height) for o in self.openings if o.voussoirs is not None]
        shapes = [shape for shape in shapes if shape.bounds[1] < head and shape.bounds[3] > foot]
        self._check_bearings(number, lintels)
        for a, b in lintels:
            self._check_lintel(number, shapely.box(a, foot, b, head), shapes)
        # The grid closes slits and necks of rounding between rings that touch.
        grid = float(np.exp2(np.floor(np.log2(GRID * bond.course_height))))
        for layer, v, length, shift in bond.layers(number, is_odd == self.shifts_odd):
            units: list[tuple[Interval, Array | None]] = []
            for part in between_lintels:
                joints = self._joints(number, layer, part, length, shift)
                region = shapely.box(part[0], foot, part[1], head)
                remaining = shapely.difference(region, shapely.union_all(shapes), grid_size=grid) if shapes else region
                if self.within is not None:
                    remaining = shapely.intersection(remaining, self.within, grid_size=grid)
                if region.area - remaining.area <= ROUNDING * region.area:
                    lines = [part[0], *(joints if self.rubble else bond.apart(part, joints)), part[1]]
                    units += [(u, None) for u in pairwise(lines)]
                else:
                    outlines = cut(remaining, joints, bond.smallest * (1 - ROUNDING))
                    units += [((float(o[:, 0].min()), float(o[:, 0].max())), o) for o in outlines]
            for k, (u, outline) in enumerate(sorted(units, key=lambda unit: sum(unit[0])), start=1):
                yield Unit(f"{number}.{k}{layer}", u, v, outline)
        for k, u in enumerate(lintels, start=1):
            yield Unit(f"{number}.lintel{k}", u, (0.0, bond.thickness))

    def _parts(self, number: int) -> list[Interval]:
        """Return the parts of a course between openings and panels that cross it."""
        start, end = self.extent
        parts = [(start, end)]
        if number % 2 == 0:
            crossed = [(a, b) for a, b, last in self.crossings if number <= last]
            parts = _without([(start - self.back, end + self.ahead)], crossed)
        height = self.bond.course_height
        plain = [(o, o.courses(height)) for o in self.openings if isinstance(o, Opening)]
        return _without(parts, [(o.start, o.end) for o, (low, high) in plain if low < number <= high])

    def _lintels(self, number: int) -> list[Interval]:
        """Return the lintels of a course, where the openings below it end."""
        half, height = self.bond.unit_length / 2, self.bond.course_height
        flat = [o for o in self.openings if isinstance(o, Opening) and o.rise is None]
        bearings = [(o, half if o.bearing is None else o.bearing) for o in flat if o.courses(height)[1] == number - 1]
        return [(o.start - bearing, o.end + bearing) for o, bearing in bearings if bearing > 0]

    def _joints(self, number: int, layer: str, part: Interval, length: float, shift: float) -> list[float]:
        """Return the joints within a part of a course: of rubble, or every ``length`` from the origin."""
        if self.rubble is None:
            origin = self.origin + shift
            first, last = np.ceil((part[0] - origin) / length), np.floor((part[1] - origin) / length)
            joints: list[float] = (origin + length * np.arange(first, last + 1)).tolist()
            return self.bond.clear(joints, self._faces())
        lintels = [x for span in (*self._lintels(number - 1), *self._lintels(number + 1)) for x in span]
        return self.rubble.joints(number, layer, part, [*self._faces(), *lintels])

    def _faces(self) -> list[float]:
        """Return the faces of the panels that this one is bonded with, along u."""
        ends = zip(self.extent, (self.back, self.ahead), strict=True)
        return [x for a, b, _ in self.crossings for x in (a, b)] + [end for end, beyond in ends if beyond > 0]

    @property
    def _wall(self) -> str:
        """Name of the panel in messages."""
        return f"{self.name.rstrip('.')} wall".strip()

    def _check_bearings(self, course: int, spans: Sequence[Interval]) -> None:
        for (_, end), (start, _) in pairwise(sorted(spans)):
            if start < end - ROUNDING * self.bond.unit_length:
                msg = (
                    f"{self._wall}: two lintels of course {course} overlap from {start:.6g} to {end:.6g} m; give the "
                    "openings a shorter bearing: zero, or at most half the wall between them"
                )
                raise ModelError(msg)

    def _check_lintel(self, course: int, lintel: Any, shapes: Sequence[Any]) -> None:
        slack = ROUNDING * lintel.area
        meets = any(shapely.intersection(lintel, shape).area > slack for shape in shapes)
        if meets or (self.within is not None and shapely.difference(lintel, self.within).area > slack):
            a, _, b, _ = lintel.bounds
            obstacle = "a ring of voussoirs" if meets else "a slope"
            msg = (
                f"{self._wall}: the lintel of course {course}, from {a:.6g} to {b:.6g} m, meets {obstacle}; move the "
                "opening, or make its bearing shorter or zero"
            )
            raise ModelError(msg)


def _common(part: Interval, others: Sequence[Interval]) -> list[Interval]:
    """Return the overlaps of an interval with others."""
    shared = [(max(a, part[0]), min(b, part[1])) for a, b in others]
    return [(a, b) for a, b in shared if b > a]


def _without(parts: Sequence[Interval], holes: Sequence[Interval]) -> list[Interval]:
    """Subtract holes from parts of a line; slivers of rounding are dropped."""
    remaining = list(parts)
    for low, high in holes:
        remaining = [
            piece
            for a, b in remaining
            for piece in ((a, min(b, low)), (max(a, high), b))
            if piece[1] - piece[0] > ROUNDING * (b - a)
        ]
    return remaining


@dataclass(slots=True)
class Pieces:
    """Blocks of a wall with its sidewalls and buttresses, in building order."""

    prefix: str
    material: Material
    course_height: float
    blocks: list[Block] = field(default_factory=list)

    def box(self, name: str, corner: Sequence[float], size: Sequence[float], *, fixed: bool = False) -> None:
        """Lay a box with its smallest corner at ``corner``."""
        self.blocks.append(block(self.prefix + name, box(corner, size), self.material, fixed=fixed))

    def panel(self, panel: Panel) -> None:
        """Lay the courses of a panel, and the voussoirs of its openings."""
        axes, height = panel.axes, self.course_height
        for number in range(1, len(panel.heads) + 1):
            for unit in panel.units(number):
                if unit.outline is not None:
                    self._extruded(panel.name + unit.name, unit.outline, unit.v, axes)
                    continue
                (u0, u1), (v0, v1) = unit.u, unit.v
                x, y, _ = np.minimum(axes[2] + u0 * axes[0] + v0 * axes[1], axes[2] + u1 * axes[0] + v1 * axes[1])
                a, b, _ = np.abs((u1 - u0) * axes[0] + (v1 - v0) * axes[1])
                self.box(panel.name + unit.name, (x, y, (number - 1) * height), (a, b, height))
        for i, opening in enumerate(panel.openings, start=1):
            for k, outline in enumerate(opening.voussoir_outlines(height), start=1):
                self._extruded(f"{panel.name}voussoir {i}.{k}", outline, (0.0, panel.bond.thickness), axes)

    def _extruded(self, name: str, outline: Array, v: tuple[float, float], axes: Array) -> None:
        foot = axes[2] + outline[:, :1] * axes[0] + outline[:, 1:] * np.array([0.0, 0.0, 1.0])
        body = lofted(foot + v[0] * axes[1], foot + v[1] * axes[1])
        self.blocks.append(block(self.prefix + name, body, self.material))


def divided_wall(elevation: Any, unit_length: float, unit_height: float) -> list[tuple[str, Array]]:
    """Return the names ``course.k`` and outlines (k, 2) of the units of a wall in running bond.

    All courses have one height: the height of the wall over the nearest whole number of courses. Every second course is
    shifted by half a unit. Units are cut at openings and slopes. In the course above the head of an opening, one unit
    spans the opening with a bearing of half a unit on each side.

    Parameters
    ----------
    elevation : shapely.Polygon
        Wall along and up, with its openings.
    unit_length, unit_height
        Size of a whole unit, in the unit of the elevation.

    Raises
    ------
    ModelError
        If an opening lies within one unit.
    """
    low, foot, high, top = elevation.bounds
    courses = max(1, round((top - foot) / unit_height))
    course, smallest = (top - foot) / courses, QUARTER * unit_length * unit_height * (1 - ROUNDING)
    voids = shapely.get_parts(shapely.difference(shapely.box(low, foot, high, top), elevation))
    spans: dict[int, list[tuple[float, float]]] = {}
    for a, _, b, head in (void.bounds for void in voids if void.area > NEGLIGIBLE * smallest):
        above = math.floor((head - foot) / course + NEGLIGIBLE)
        if above < courses:
            spans.setdefault(above, []).append((a - unit_length / 2, b + unit_length / 2))
    units = []
    for j in range(courses):
        strip = shapely.box(low, foot + j * course, high, foot + (j + 1) * course)
        lines = low + unit_length * (np.arange(1, math.ceil((high - low) / unit_length) + 1) - j % 2 / 2)
        ends = [end for span in spans.get(j, []) for end in span]
        joints = [x for x in (*lines.tolist(), *ends) if not any(a < x < b for a, b in spans.get(j, []))]
        outlines = cut(shapely.intersection(elevation, strip), joints, smallest)
        units += [(f"{j + 1}.{k}", outline) for k, outline in enumerate(outlines, start=1)]
    return units
