"""Common areas of faces that a third body lies between."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import copysign

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.geometry.coplanar import FacePair
from blockstruct.geometry.polygon import plane_axes, uncrossed
from blockstruct.geometry.tolerances import ALIKE

Array = NDArray[np.float64]
#: Face pairs of two bodies, by both, in both orders.
OfBodies = dict[int, dict[int, list[FacePair]]]


def parts_not_hidden(
    pairs: Sequence[FacePair], faces: Iterable[FacePair], rounding: float, least: float
) -> list[tuple[FacePair, tuple[int, ...]]]:
    """Face pairs without the parts where another body lies between the two faces, and these parts.

    A body lies between where one face of it looks at the one face of a pair and another at the other.

    Parameters
    ----------
    pairs
        Those to judge: the ones whose gap is more than rounding.
    faces
        All common areas of faces, as :func:`coplanar_face_pairs` finds them with a reach of no less than the gaps.
    rounding
        Gap in which nothing lies.
    least
        Area up to which nothing is hidden.

    Returns
    -------
    list of (FacePair, tuple of int)
        Without bodies what is left, in parts without holes; nothing is that is nowhere wider than its gap. With bodies
        what they hide: of such a pair the area counts, its polygon is that of the whole.
    """
    found: list[tuple[FacePair, tuple[int, ...]]] = []
    of_bodies: OfBodies = defaultdict(lambda: defaultdict(list))
    if any(pair.gap > rounding for pair in pairs):
        for face in faces:
            of_bodies[face.minus][face.plus].append(face)
            of_bodies[face.plus][face.minus].append(face)
    for pair in pairs:
        hidden = dict(_hidden(pair, of_bodies, least)) if pair.gap > rounding else {}
        if hidden:
            outline = _flat(pair, [pair])
            left = shapely.difference(outline, shapely.union_all(list(hidden.values())))
            kept = [part for part in _without_holes(left) if not shapely.buffer(part, -pair.gap / 2).is_empty]
            found += [(_lifted(pair, part), ()) for part in kept]
            area = pair.area - sum(float(part.area) for part in kept)
            found.append((replace(pair, area=area), tuple(hidden)))
        else:
            found.append((pair, ()))
    return found


def without_far_sides(pairs: Sequence[FacePair], rounding: float) -> list[FacePair]:
    """Face pairs but for those that seem to penetrate each other through the whole of two thin bodies.

    The upper face of one sheet on another looks at the lower face of the other one, from the wrong side: where faces of
    the same bodies that look at each other the other way round are closer, those are the joint.
    """
    of_bodies: dict[frozenset[int], list[FacePair]] = defaultdict(list)
    for pair in pairs:
        of_bodies[frozenset((pair.minus, pair.plus))].append(pair)
    return [
        pair
        for pair in pairs
        if pair.gap >= -rounding
        or not any(_is_nearer(other, pair) for other in of_bodies[frozenset((pair.minus, pair.plus))])
    ]


def _is_nearer(other: FacePair, pair: FacePair) -> bool:
    """Whether another pair of the same bodies is their joint, and a pair its far sides."""
    sense = 1 if other.minus == pair.minus else -1
    if abs(other.gap) >= abs(pair.gap) or sense * float(other.normal @ pair.normal) > -ALIKE:
        return False
    return bool(_flat(pair, [pair]).intersection(_flat(pair, [other])).area > pair.area / 2)


def _hidden(pair: FacePair, of_bodies: OfBodies, least: float) -> Iterator[tuple[int, shapely.Geometry]]:
    """Bodies between the faces of a pair, and the part of it that each hides, in its plane."""
    for body in of_bodies[pair.minus].keys() & of_bodies[pair.plus].keys():
        below = _between(pair, pair.minus, of_bodies[pair.minus][body], 1.0)
        above = _between(pair, pair.plus, of_bodies[pair.plus][body], -1.0) if below else []
        if above:
            part = shapely.intersection(_flat(pair, below), _flat(pair, above))
            part = shapely.intersection(part, _flat(pair, [pair]))
            if part.area > least:
                yield body, part


def _between(pair: FacePair, end: int, faces: Sequence[FacePair], sense: float) -> list[FacePair]:
    """Of the faces that look at one body of a pair those that look at its face, from before the other one's."""
    return [
        face
        for face in faces
        if sense * (1 if face.minus == end else -1) * float(face.normal @ pair.normal) > ALIKE
        and copysign(face.closest, face.gap) < pair.gap
    ]


def _flat(pair: FacePair, faces: Sequence[FacePair]) -> shapely.Geometry:
    """Polygons of faces, as one, in the plane of a pair."""
    axes = np.stack(plane_axes(pair.normal))
    middle = pair.polygon.mean(axis=0)
    outlines = uncrossed(np.array([shapely.Polygon((face.polygon - middle) @ axes.T) for face in faces]))
    return shapely.union_all(outlines)


def _lifted(pair: FacePair, part: shapely.Geometry) -> FacePair:
    """A part of a pair."""
    axes = np.stack(plane_axes(pair.normal))
    corners = shapely.get_coordinates(shapely.orient_polygons(part))[:-1]
    return replace(pair, polygon=pair.polygon.mean(axis=0) + corners @ axes, area=float(part.area))


def _without_holes(shape: shapely.Geometry) -> list[shapely.Geometry]:
    """Polygons of a shape, cut across their holes."""
    whole: list[shapely.Geometry] = []
    rest = list(shapely.get_parts(shape))
    while rest:
        part = rest.pop()
        if shapely.get_type_id(part) != shapely.GeometryType.POLYGON or part.is_empty:
            continue
        if not part.interiors:
            whole.append(part)
            continue
        x, (low_x, low_y, high_x, high_y) = part.interiors[0].centroid.x, part.bounds
        sides = shapely.box(low_x, low_y, x, high_y), shapely.box(x, low_y, high_x, high_y)
        rest += [piece for side in sides for piece in shapely.get_parts(shapely.intersection(part, side))]
    return whole
