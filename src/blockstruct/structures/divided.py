"""Division of an existing wall into units in running bond."""

import math
from typing import Any

import numpy as np
import shapely

from blockstruct.arrays import Array
from blockstruct.geometry.tolerances import NEGLIGIBLE, ROUNDING
from blockstruct.structures.bond import cut
from blockstruct.structures.openings import QUARTER


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
