"""Pairs of faces that look at each other and have a common area: joined over facets, without bodies in between."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import copysign

import numpy as np
import shapely

from blockstruct.arrays import CHUNK, SLIGHT, Array, Flags, Index
from blockstruct.geometry.faces import Faces
from blockstruct.geometry.neighbours import expanded, facing_pairs
from blockstruct.geometry.polygon import next_corners, plane_axes, uncrossed
from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.geometry.tolerances import ALIKE, GRID


@dataclass(frozen=True, slots=True)
class FacePair:
    """The common area of two faces.

    Attributes
    ----------
    minus, plus
        Indices of the two bodies; the normal points from minus to plus.
    polygon : (k, 3) array
        Corners of the common area, midway between the faces, counter-clockwise about the normal.
    normal : (3,) array
        Unit normal midway between the normals of the faces.
    area
        Area of the polygon.
    gap
        Largest distance of the faces along the normal over the polygon; negative for a penetration.
    closest
        Smallest distance of the faces over the polygon; zero if they cross.
    angle
        Between the planes of the faces, radians.
    """

    minus: int
    plus: int
    polygon: Array
    normal: Array
    area: float
    gap: float
    closest: float
    angle: float


def coplanar_face_pairs(
    bodies: list[Polyhedron], reach: float, angle: float, *, rounding: float | None = None
) -> list[FacePair]:
    """Return all common areas of faces of different bodies, whatever their number and size.

    Each pair of faces is tested on its own, with the mean planes. The faces look at each other, and their smallest
    distance over the common area is at most the reach.

    Parameters
    ----------
    bodies
        Polyhedra.
    reach
        Largest gap, and largest penetration, at the closest point.
    angle
        Largest angle between two faces, radians.
    rounding
        Deviation from a straight outline that counts as rounding; the reach by default.
    """
    if len(bodies) < 2:
        return []
    faces = Faces.of(bodies)
    front, back = _candidates(faces, reach, angle)
    n = faces.normal[front] - faces.normal[back]
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    middle = (faces.centre[front] + faces.centre[back]) / 2
    axes = np.stack(plane_axes(n), axis=1)
    extent = np.maximum(faces.extent[front], faces.extent[back])
    outlines = [uncrossed(faces.outlines(f, axes, middle, extent)) for f in (front, back)]
    parts, of_pair = shapely.get_parts(shapely.intersection(*outlines), return_index=True)
    # Faces are simple polygons, so their common area has no holes. Coincident edges leave spurious corners of rounding,
    # which would become contact points.
    parts = shapely.simplify(shapely.normalize(parts), reach if rounding is None else rounding)
    keep = (shapely.get_type_id(parts) == shapely.GeometryType.POLYGON) & ~shapely.is_empty(parts)
    parts, of_pair = shapely.orient_polygons(parts[keep]), of_pair[keep]
    if not len(parts):
        return []
    rings, of_part = shapely.get_coordinates(parts, return_index=True)
    # Rings of shapely repeat their first point.
    last = np.append(np.diff(of_part) > 0, [True])
    rings, of_part = rings[~last], of_part[~last]
    start = np.flatnonzero(np.append([True], np.diff(of_part) > 0))
    k = of_pair[of_part]
    points = middle[k] + np.einsum("ia,iaj->ij", rings, axes[k])
    # Heights of the two faces over the common corners, along n: the plane between them is the interface.
    low, high = (
        np.einsum("ij,ij->i", faces.centre[f[k]] - points, faces.normal[f[k]])
        / np.einsum("ij,ij->i", n[k], faces.normal[f[k]])
        for f in (front, back)
    )
    least, most = np.minimum.reduceat(high - low, start), np.maximum.reduceat(high - low, start)
    gap = np.where(np.abs(least) > np.abs(most), least, most)
    closest = np.where(least * most < 0, 0.0, np.minimum(np.abs(least), np.abs(most)))
    points = points + ((low + high) / 2)[:, None] * n[k]
    polygons = np.split(points, start[1:])
    angles = _angle(faces.normal[front], faces.normal[back])[of_pair]
    measures = np.column_stack([shapely.area(parts), gap, closest, angles])
    pairs = [
        FacePair(int(faces.body[front[k]]), int(faces.body[back[k]]), polygon, n[k], *numbers)
        for k, polygon, numbers in zip(of_pair, polygons, measures.tolist(), strict=True)
        if numbers[2] <= reach
    ]
    pairs.sort(key=lambda p: (p.minus, p.plus, *p.polygon[0]))
    return pairs


def crossed_faces(bodies: list[Polyhedron]) -> list[tuple[int, int]]:
    """Return the faces whose outline crosses itself, as (body, face); their common areas are undefined."""
    if not bodies:
        return []
    faces = Faces.of(bodies)
    every = np.arange(len(faces.body))
    axes = np.stack(plane_axes(faces.normal), axis=1)
    bad = ~shapely.is_valid(faces.outlines(every, axes, faces.centre, faces.extent))
    first = np.searchsorted(faces.body, faces.body)
    return [(int(faces.body[f]), int(f - first[f])) for f in np.flatnonzero(bad)]


def _candidates(faces: Faces, reach: float, angle: float) -> tuple[Index, Index]:
    """Return pairs of faces (front, back) of different bodies that look at each other and may have a common area.

    The front face looks up (or, if level, along +y or +x).
    """
    i, j = facing_pairs(faces.low - reach, faces.high + reach, faces.normal, angle)
    keep = faces.body[i] != faces.body[j]
    i, j = i[keep], j[keep]
    tilt = _angle(faces.normal[i], faces.normal[j])
    away = np.abs(np.einsum("ij,ij->i", faces.centre[j] - faces.centre[i], faces.normal[i]))
    # No point of a face is further from its centre than the diagonal of its box.
    keep = (tilt <= angle) & (away - np.sin(tilt) * faces.extent[j] * np.sqrt(3) <= reach)
    i, j = i[keep], j[keep]
    up = _half_space_sign(faces.normal[i] - faces.normal[j]) > 0
    front, back = np.where(up, i, j), np.where(up, j, i)
    chunks = np.array_split(np.arange(len(front)), 100 * len(front) // CHUNK + 1)
    keep = ~np.concatenate([_side_by_side(faces, front[some], back[some]) for some in chunks])
    return front[keep], back[keep]


def _side_by_side(faces: Faces, front: Index, back: Index) -> Flags:
    """Return whether the edge of the front face that is nearest to the back face parts the two."""
    if not len(front):
        return np.zeros(0, dtype=bool)
    normal = faces.normal[front] - faces.normal[back]
    pair, corner, first = expanded(faces.start[front], faces.count[front])
    following = next_corners(first, faces.count[front])
    corners = faces.corners[corner]
    outward = np.cross(corners[following] - corners, normal[pair])
    # An edge without length gives NaN, which comes last and parts nothing.
    with np.errstate(invalid="ignore"):
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    beyond = np.einsum("ij,ij->i", outward, faces.centre[back][pair] - corners)
    nearest = np.lexsort((beyond, pair))[first + faces.count[front] - 1]

    def heights(face: Index) -> tuple[Array, Index]:
        of, corner, first = expanded(faces.start[face], faces.count[face])
        return np.einsum("ij,ij->i", outward[nearest[of]], faces.corners[corner]), first

    gap = np.minimum.reduceat(*heights(back)) - np.maximum.reduceat(*heights(front))
    return np.asarray(gap >= -GRID * np.maximum(faces.extent[front], faces.extent[back]))


def _angle(one: Array, other: Array) -> Array:
    """Return the angle between opposite faces from unit normals (m, 3), accurate for small angles."""
    return np.asarray(2 * np.arcsin(np.minimum(np.linalg.norm(one + other, axis=1) / 2, 1.0)))


def _half_space_sign(normals: Array) -> Array:
    """Return +1 for a normal that points up (or, if level, along +y, then +x), else −1."""
    x, y, z = np.where(np.abs(normals) < SLIGHT, 0.0, normals).T
    lead = np.where(z != 0, z, np.where(y != 0, y, x))
    return np.where(lead > 0, 1.0, -1.0)


def joined_pairs(pairs: Sequence[FacePair], gap: float, angle: float, rounding: float) -> list[FacePair]:
    """Join face pairs of the same bodies that lie in one plane and touch.

    Pieces lie in one plane if their normals are within the angle of the mean normal, and their corners within the gap
    of the mean plane. Pieces around a hole stay separate, because an interface has no holes.

    Parameters
    ----------
    pairs
        In the order of :func:`coplanar_face_pairs`.
    gap, angle, rounding
        Tolerances of the detection; angle in radians.
    """
    joined: list[FacePair] = []
    of_bodies: dict[frozenset[int], list[FacePair]] = {}
    for pair in pairs:
        of_bodies.setdefault(frozenset((pair.minus, pair.plus)), []).append(pair)
    for rest in of_bodies.values():
        while len(rest) > 1:
            in_plane = _in_one_plane(rest, rest, gap, angle)
            if not in_plane.all():
                in_plane = _in_one_plane(rest, [max(rest, key=lambda p: p.area)], gap, angle)
            joined += _whole([p for p, fits in zip(rest, in_plane, strict=True) if fits], gap, rounding)
            rest = [p for p, fits in zip(rest, in_plane, strict=True) if not fits]
        joined += rest
    joined.sort(key=lambda p: (p.minus, p.plus, *p.polygon[0]))
    return joined


def _plane(pieces: Sequence[FacePair]) -> tuple[Array, Array]:
    """Return the middle (3,) and the unit normal (3,) of pieces, weighted by their areas."""
    weight = np.array([p.area for p in pieces])
    normal = weight @ _normals(pieces, pieces[int(np.argmax(weight))])
    middle = weight @ np.array([p.polygon.mean(axis=0) for p in pieces]) / weight.sum()
    return middle, normal / np.linalg.norm(normal)


def _normals(pieces: Sequence[FacePair], like: FacePair) -> Array:
    """Return the normals (m, 3) towards the plus side of one piece; in a rough vertical joint the sides may differ."""
    return np.array([p.normal if p.minus == like.minus else -p.normal for p in pieces])


def _in_one_plane(pieces: Sequence[FacePair], reference: Sequence[FacePair], gap: float, angle: float) -> Flags:
    """Return which pieces lie in the mean plane of a reference. A single reference piece always does."""
    middle, normal = _plane(reference)
    normals = _normals(pieces, max(reference, key=lambda p: p.area))
    tilt = 2 * np.arcsin(np.minimum(np.linalg.norm(normals - normal, axis=1) / 2, 1.0))
    off = np.array([np.abs((p.polygon - middle) @ normal).max() for p in pieces])
    is_reference = np.array([len(reference) == 1 and p is reference[0] for p in pieces])
    return np.asarray(((tilt <= angle) & (off <= gap)) | is_reference)


def _whole(pieces: list[FacePair], gap: float, rounding: float) -> list[FacePair]:
    if len(pieces) == 1:
        return pieces
    middle, normal = _plane(pieces)
    axes = np.stack(plane_axes(normal))
    outlines = uncrossed(np.array([shapely.Polygon((p.polygon - middle) @ axes.T) for p in pieces]))
    union = shapely.union_all(outlines, grid_size=SLIGHT * rounding)
    pieced = union
    if _has_holes(union) or len(shapely.get_parts(union)) > 1:
        # Close slits between pieces of a rough face that are no wider than the gap.
        closed = shapely.buffer(union, gap, join_style="mitre", mitre_limit=20)
        union = shapely.buffer(closed, -gap, join_style="mitre", mitre_limit=20)
    parts = shapely.get_parts(uncrossed(shapely.get_parts(shapely.simplify(shapely.normalize(union), rounding))))
    parts = parts[(shapely.get_type_id(parts) == shapely.GeometryType.POLYGON) & ~shapely.is_empty(parts)]
    # Closed slits may leave corners outside all pieces.
    parts = parts[shapely.area(shapely.intersection(parts, pieced)) > 0.5 * shapely.area(parts)]
    if _has_holes(union) or not 0 < len(parts) < len(pieces):
        return pieces
    largest = max(pieces, key=lambda p: p.area)
    return [
        FacePair(
            largest.minus,
            largest.plus,
            middle + shapely.get_coordinates(part)[:-1] @ axes,
            normal,
            float(part.area),
            max((p.gap for p in pieces), key=abs),
            min(p.closest for p in pieces),
            max(p.angle for p in pieces),
        )
        for part in shapely.orient_polygons(parts)
    ]


def _has_holes(shape: shapely.Geometry) -> bool:
    return bool(shapely.get_num_interior_rings(shapely.get_parts(shape)).any())


#: Face pairs by their two bodies, in both orders.
OfBodies = dict[int, dict[int, list[FacePair]]]


def parts_not_hidden(
    pairs: Sequence[FacePair], faces: Iterable[FacePair], rounding: float, least: float
) -> list[tuple[FacePair, tuple[int, ...]]]:
    """Split face pairs into parts without and parts with another body between the two faces.

    A body is between the faces of a pair if its faces look at both.

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
            solid = [part for part in _without_holes(free) if not shapely.buffer(part, -pair.gap / 2).is_empty]
            parts += [(_lifted(pair, part), ()) for part in solid]
            area = pair.area - sum(float(part.area) for part in solid)
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
