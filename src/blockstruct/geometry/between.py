"""Common areas of faces with a third body in between."""

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
#: Face pairs by their two bodies, in both orders.
OfBodies = dict[int, dict[int, list[FacePair]]]


def parts_not_hidden(
    pairs: Sequence[FacePair], faces: Iterable[FacePair], rounding: float, least: float
) -> list[tuple[FacePair, tuple[int, ...]]]:
    """Split face pairs into parts without and parts with another body between the two faces.

    A body is between the faces of a pair if it has a face that looks at each of them.

    Parameters
    ----------
    pairs
        Pairs to split. Pairs with a gap of rounding stay whole.
    faces
        All common areas of faces from :func:`coplanar_face_pairs`, with a reach of at least the gaps.
    rounding
        Gap that is rounding: no body is in it.
    least
        Smallest area that a body hides.

    Returns
    -------
    list of (FacePair, tuple of int)
        Without bodies: a free part, without holes. Parts nowhere wider than their gap are dropped. With bodies: the
        part that they hide. Its area is exact; its polygon is the polygon of the whole pair.
    """
    parts: list[tuple[FacePair, tuple[int, ...]]] = []
    of_bodies: OfBodies = defaultdict(lambda: defaultdict(list))
    if any(pair.gap > rounding for pair in pairs):
        for face in faces:
            of_bodies[face.minus][face.plus].append(face)
            of_bodies[face.plus][face.minus].append(face)
    for pair in pairs:
        hidden = dict(_hidden(pair, of_bodies, least)) if pair.gap > rounding else {}
        if hidden:
            outline = _flat(pair, [pair])
            free = shapely.difference(outline, shapely.union_all(list(hidden.values())))
            kept = [part for part in _without_holes(free) if not shapely.buffer(part, -pair.gap / 2).is_empty]
            parts += [(_lifted(pair, part), ()) for part in kept]
            area = pair.area - sum(float(part.area) for part in kept)
            parts.append((replace(pair, area=area), tuple(hidden)))
        else:
            parts.append((pair, ()))
    return parts


def without_far_sides(pairs: Sequence[FacePair], rounding: float) -> list[FacePair]:
    """Drop face pairs that seem to penetrate through the whole thickness of two thin bodies.

    For two sheets, one on the other, the outer faces also look at each other, through both sheets. If two other faces
    of the same bodies look at each other in the opposite direction and are closer, they are the joint.
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
    """Whether another pair of the same bodies is their joint, and ``pair`` their outer faces."""
    sense = 1 if other.minus == pair.minus else -1
    if abs(other.gap) >= abs(pair.gap) or sense * float(other.normal @ pair.normal) > -ALIKE:
        return False
    return bool(_flat(pair, [pair]).intersection(_flat(pair, [other])).area > pair.area / 2)


def _hidden(pair: FacePair, of_bodies: OfBodies, least: float) -> Iterator[tuple[int, shapely.Geometry]]:
    """Yield the bodies between the faces of a pair, and the part that each hides, in the plane of the pair."""
    for body in of_bodies[pair.minus].keys() & of_bodies[pair.plus].keys():
        below = _between(pair, pair.minus, of_bodies[pair.minus][body], 1.0)
        above = _between(pair, pair.plus, of_bodies[pair.plus][body], -1.0) if below else []
        if above:
            part = shapely.intersection(_flat(pair, below), _flat(pair, above))
            part = shapely.intersection(part, _flat(pair, [pair]))
            if part.area > least:
                yield body, part


def _between(pair: FacePair, end: int, faces: Sequence[FacePair], sense: float) -> list[FacePair]:
    """Select faces that look at the face of one body of a pair and are nearer than the other face of the pair."""
    return [
        face
        for face in faces
        if sense * (1 if face.minus == end else -1) * float(face.normal @ pair.normal) > ALIKE
        and copysign(face.closest, face.gap) < pair.gap
    ]


def _flat(pair: FacePair, faces: Sequence[FacePair]) -> shapely.Geometry:
    """Return the union of the polygons of faces in the plane of a pair."""
    axes = np.stack(plane_axes(pair.normal))
    middle = pair.polygon.mean(axis=0)
    outlines = uncrossed(np.array([shapely.Polygon((face.polygon - middle) @ axes.T) for face in faces]))
    return shapely.union_all(outlines)


def _lifted(pair: FacePair, part: shapely.Geometry) -> FacePair:
    """Return a part of a pair as a pair in space."""
    axes = np.stack(plane_axes(pair.normal))
    corners = shapely.get_coordinates(shapely.orient_polygons(part))[:-1]
    return replace(pair, polygon=pair.polygon.mean(axis=0) + corners @ axes, area=float(part.area))


def _without_holes(shape: shapely.Geometry) -> list[shapely.Geometry]:
    """Return the polygons of a shape, cut at their holes."""
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
