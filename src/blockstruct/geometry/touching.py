"""Contact points of moved bodies that touch or nearly touch, with normals and gaps; their corners may be rounded."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array, Flags, Index
from blockstruct.errors import GeometryError
from blockstruct.geometry.neighbours import box_pairs, expanded
from blockstruct.geometry.polygon import plane_axes
from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.geometry.tolerances import DEEP, FACING, LARGEST_DEVIATION, LOOKS, NO_CROSSING
from blockstruct.geometry.triangles import triangulated


@dataclass(frozen=True, slots=True)
class Clipped:
    """Common areas of P pairs of convex polygons, with at most N corners.

    Attributes
    ----------
    corner : (P, N, 2) array
        Corners in order, counter-clockwise. Entries beyond the count are arbitrary.
    edge : (P, N) array
        Edge that starts at each corner: ``i`` is edge i of the first polygon, ``M + j`` is edge j of the second. M is
        the largest number of corners of a first polygon.
    count : (P,) array
    """

    corner: Array
    edge: Index
    count: Index

    def __getitem__(self, chosen: Flags) -> "Clipped":
        return Clipped(self.corner[chosen], self.edge[chosen], self.count[chosen])

    @property
    def within(self) -> Flags:
        """Whether each corner is within the count, (P, N)."""
        return np.asarray(np.arange(self.corner.shape[1]) < self.count[:, None])

    @property
    def edges(self) -> Array:
        """Vector (P, N, 2) from each corner to the next; zero beyond the count."""
        along = _following(self.corner, self.count) - self.corner
        return np.where(self.within[:, :, None], along, 0.0)

    @property
    def area(self) -> Array:
        """Area (P,)."""
        twice = cross(self.corner, _following(self.corner, self.count))
        return np.asarray(np.where(self.within, twice, 0.0).sum(axis=1) / 2)

    @property
    def arriving(self) -> Index:
        """Edge that ends at each corner, (P, N)."""
        number = np.arange(self.corner.shape[1])
        before = np.where(number > 0, number - 1, np.maximum(self.count[:, None] - 1, 0))
        return np.take_along_axis(self.edge, before, 1)

    def without_short_edges(self, shortest: float) -> "Clipped":
        """Return the areas without corners whose edge is at most ``shortest`` long."""
        keep = self.within & (np.linalg.norm(self.edges, axis=2) > shortest)
        return _packed(self.corner, self.edge, keep)


def clipped(first: Array, n_first: Index, second: Array, n_second: Index, flush: float) -> Clipped:
    """Clip polygons by polygons (I. E. Sutherland, G. W. Hodgman (1974), doi:10.1145/360767.360802).

    A point outside by rounding counts as inside. Otherwise coincident edges, as in the face of a wall, would cross at
    arbitrary points, which differ between the front and the back of the wall.

    Parameters
    ----------
    first, second : (P, M, 2), (P, G, 2) arrays
        Convex polygons, counter-clockwise.
    n_first, n_second : (P,) arrays
        Numbers of corners.
    flush
        Distance outside an edge that counts as rounding.
    """
    M = first.shape[1]
    labels = np.broadcast_to(np.arange(M), first.shape[:2])
    result = Clipped(first, labels, n_first)
    pairs = np.arange(len(first))
    for k in range(second.shape[1]):
        a, b = second[:, k], second[pairs, np.where(k + 1 < n_second, k + 1, 0)]
        # A polygon stops clipping after its last edge.
        idle = (k >= n_second)[:, None]
        height = cross((b - a)[:, None], result.corner - a[:, None])
        outside = -flush * np.linalg.norm(b - a, axis=1, keepdims=True)
        inside, following = (height >= outside) | idle, _following(height, result.count)
        next_inside = (following >= outside) | idle
        span = height - following
        share = np.clip(height / np.where(span == 0, 1.0, span), 0.0, 1.0)
        crossing = result.corner + share[:, :, None] * (_following(result.corner, result.count) - result.corner)
        keep = np.stack([result.within & inside, result.within & (inside != next_inside)], axis=2)
        corner = np.stack([result.corner, crossing], axis=2)
        # An outline that leaves the polygon continues along the clipping edge.
        edge = np.stack([result.edge, np.where(inside, M + k, result.edge)], axis=2)
        shape = (len(first), 2 * result.corner.shape[1])
        result = _packed(corner.reshape(*shape, 2), edge.reshape(shape), keep.reshape(shape))
    return result


def cross(a: Array, b: Array) -> Array:
    """Return the cross product of vectors (…, 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _following(values: Array, count: Index) -> Array:
    """Return the value at the next corner."""
    number = np.arange(values.shape[1])
    after = np.where(number + 1 < count[:, None], number + 1, 0)
    return np.take_along_axis(values, after.reshape(after.shape + (1,) * (values.ndim - 2)), 1)


def _packed(corner: Array, edge: Index, keep: Flags) -> Clipped:
    """Move the corners to keep to the front."""
    count = keep.sum(axis=1)
    order = np.argsort(~keep, axis=1, kind="stable")[:, : max(int(count.max(initial=0)), 1)]
    return Clipped(np.take_along_axis(corner, order[:, :, None], 1), np.take_along_axis(edge, order, 1), count)


def inset(corner: Array, normal: Array, others: Array, radius: float) -> Array | None:
    """Return the region of the centre of a ball that rolls inside a body along a face, one radius below the face.

    Towards an edge the region ends where the ball touches the adjacent face, at ``r tan(ε / 2)`` from the edge, with
    the outer angle ε between the normals. The distance is r for a right angle, and zero for a flat or inner edge.

    Parameters
    ----------
    corner : (k, 3) array
        Corners of a convex face, counter-clockwise seen from outside.
    normal : (3,) array
    others : (k, 3) array
        Normals of the adjacent faces, at the edges that start at the corners.
    radius
        Radius of the ball, m.

    Returns
    -------
    (k, 3) array or None
        Corners of the region; None if it is empty.
    """
    along, moves = _moves(corner, normal, others)
    points = corner + radius * moves
    left = np.roll(points, -1, axis=0) - points
    if not np.all(np.einsum("ki,ki->k", left, along) > 0):
        return None
    return np.asarray(points)


def largest_radius(corner: Array, normal: Array, others: Array) -> float:
    """Return the radius, m, from which on :func:`inset` is empty; infinite if the face keeps its size."""
    along, moves = _moves(corner, normal, others)
    # Edges shorten in proportion to the radius.
    length = np.linalg.norm(np.roll(corner, -1, axis=0) - corner, axis=1)
    shorter = -np.einsum("ki,ki->k", np.roll(moves, -1, axis=0) - moves, along)
    return float(np.min(length[shorter > 0] / shorter[shorter > 0], initial=np.inf))


def _moves(corner: Array, normal: Array, others: Array) -> tuple[Array, Array]:
    """Return the directions of the edges from the corners, and the moves of the corners per unit of radius."""
    along = np.roll(corner, -1, axis=0) - corner
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    inwards = np.cross(normal, along)
    lean = -np.einsum("ki,ki->k", others, inwards)
    away = np.maximum(lean, 0.0) / np.maximum(1 + others @ normal, 1e-9)
    rows = np.stack([inwards, np.roll(inwards, 1, axis=0), np.tile(normal, (len(corner), 1))], axis=1)
    moved = np.stack([away, np.roll(away, 1), np.full(len(corner), -1.0)], axis=1)
    # Collinear edges repeat one condition, hence the pseudo-inverse.
    return along, np.einsum("kij,kj->ki", np.linalg.pinv(rows, rcond=1e-9), moved)


@dataclass(frozen=True, slots=True)
class Touching:
    """Contact points of pairs of bodies.

    Attributes
    ----------
    minus, plus : (K,) arrays
        Indices of the two bodies.
    position : (K, 3) array
    normal : (K, 3) array
        From minus to plus.
    gap : (K,) array
        Distance along the normal; negative for a penetration.
    level : (K,) array
        1 where a vertex of plus is above a face of minus, 0 where a vertex of minus is above a face of plus, and ½ at
        crossings of edges. The position is at the vertex, or midway.
    part : (K, 2) array
        Parts of faces of minus and of plus.
    """

    minus: Index
    plus: Index
    position: Array
    normal: Array
    gap: Array
    level: Array
    part: Index


@dataclass(frozen=True, slots=True)
class MovingBodies:
    """Faces of rigid bodies, in convex parts, relative to the centroids of the bodies.

    Corners may be rounded. Each body is then the region that a ball covers when it rolls inside. A face ends where the
    ball leaves it: at a right angle, one radius from the edge. The stored face is the region of the centre of the ball,
    one radius inside.

    Attributes
    ----------
    corner : (f, M, 3) array
        Corners of each part of a face, counter-clockwise seen from outside; the last corner is repeated.
    count : (f,) array
        Number of corners of each part.
    normal : (f, 3) array
    of_part : (f,) array
        Body of each part, ascending.
    flat : (f, M) array
        Whether the surface continues flat across each edge.
    depth : (f,) array
        Extent of the body along the normal of each part.
    looks : (f,) array
        Largest angle between the normal of each part and opposite faces, radians.
    edged : (f,) array
        Half the angle, radians, between the normals at the sharpest edge of the body.
    fixed : (B,) array
        Whether each body is fixed. Fixed bodies have no contacts with each other.
    radius : float
        Radius of the corners, m.
    """

    corner: Array
    count: Index
    normal: Array
    of_part: Index
    flat: Flags
    depth: Array
    looks: Array
    edged: Array
    fixed: Flags
    radius: float

    @classmethod
    def of(cls, bodies: Mapping[str, Polyhedron], fixed: Flags, radius: float) -> Self:
        """Return the faces of named polyhedra. A face that is not convex is cut into triangles.

        Raises
        ------
        GeometryError
            If a face is too small for the radius.
        """
        corners: list[Array] = []
        normals, owner, flat, depth, looks, edged = [], [], [], [], [], []
        least = (np.inf, "")
        for i, (name, body) in enumerate(bodies.items()):
            parts = [(f, part) for f, face in enumerate(body.faces) for part in _convex_parts(body, f, face)]
            beyond = {(a, b): f for f, part in parts for a, b in zip(part, (*part[1:], part[0]), strict=True)}
            edge_angle, corner_angle = _sharpest(body, beyond)
            for f, part in parts:
                others = body.normals[[beyond[b, a] for a, b in zip(part, (*part[1:], part[0]), strict=True)]]
                points = body.vertices[list(part)] - body.centroid
                rest = inset(points, body.normals[f], others, radius) if radius else points
                if rest is None:
                    least = min((largest_radius(points, body.normals[f], others), name), least)
                    continue
                corners.append(rest)
                normals.append(body.normals[f])
                owner.append(i)
                depth.append(np.ptp(body.vertices @ body.normals[f]))
                looks.append(max(FACING, edge_angle, corner_angle))
                edged.append(edge_angle)
                flat.append([bool(body.normals[f] @ other > 1 - ROUNDING) for other in others])
        if least[0] < np.inf:
            # The factor keeps the rounded number in the message below the limit.
            msg = (
                f"block {least[1]!r}: the corner radius {radius:.6g} m is too large for a face; give a radius of at "
                f"most {0.99 * least[0]:.3g} m, which fits all faces"
            )
            raise GeometryError(msg)
        most = max(map(len, corners))
        return cls(
            corner=np.array([np.concatenate([c, np.repeat(c[-1:], most - len(c), axis=0)]) for c in corners]),
            count=np.array([len(c) for c in corners]),
            normal=np.array(normals),
            of_part=np.array(owner),
            flat=np.array([row + [False] * (most - len(row)) for row in flat]),
            depth=np.array(depth),
            looks=np.array(looks),
            edged=np.array(edged),
            fixed=fixed,
            radius=radius,
        )

    def face_at(self, body: int, point: Array, normal: Array) -> Index:
        """Return the parts of the face of a body that is nearest to a plane through a point, m, with a normal."""
        own = np.flatnonzero(self.of_part == body)
        size = np.ptp(self.corner[own], axis=(0, 1)).max()
        tilt = np.linalg.norm(self.normal[own] - normal, axis=1)
        off = _dots(self.corner[own, 0] - point, self.normal[own]) / size
        nearest = (tilt + np.abs(off)).argmin()
        same = np.linalg.norm(self.normal[own] - self.normal[own[nearest]], axis=1) <= NEGLIGIBLE
        return np.asarray(own[same & (np.abs(off - off[nearest]) <= LARGEST_DEVIATION)])

    def area(self, parts: Index) -> float:
        """Return the total area of parts, m²."""
        corner = self.corner[parts]
        twice = np.cross(corner - corner[:, :1], np.roll(corner, -1, axis=1) - corner[:, :1]).sum(axis=1)
        return float(_dots(twice, self.normal[parts]).sum() / 2)

    def pair(self, one: Index, other: Index) -> Index:
        """Return a number for each pair of parts, in any order."""
        return np.asarray(np.minimum(one, other) * len(self.count) + np.maximum(one, other))

    def touching(self, position: Array, rotation: Array, reach: float, size: float) -> Touching:
        """Return the contact points of the bodies at their positions.

        Two parts of faces that look at each other are projected along the mean of their normals. The corners of their
        common area are contact points. A vertex of one part within the other has the normal of the other; at a
        crossing of two edges the normal is perpendicular to both. A body that rocks on its edge is thus supported by
        the face below, and a body that overhangs rests with its face on the edge below.

        Faces on the far sides of two bodies do not count: they are deeper than their common area is wide, or than a
        body is thick. Vertices that meet vertices or edges sideways, without a common area, do not count until one has
        passed the other.

        Parameters
        ----------
        position : (B, 3) array
            Positions of the centroids.
        rotation : (B, 3, 3) array
        reach
            Largest gap.
        size
            Mean size of a block, the reference of the tolerances.
        """
        turn = rotation[self.of_part]
        normal = np.einsum("fij,fj->fi", turn, self.normal)
        corner = np.einsum("fij,fvj->fvi", turn, self.corner) + position[self.of_part, None]
        first, second = self._facing(corner, normal, reach + 2 * self.radius)
        middle = normal[second] - normal[first]
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        axes = np.stack(plane_axes(middle), axis=1)
        origin = corner[second, 0]
        # In this projection the first part has the opposite order of rotation.
        count, number = self.count[first], np.arange(corner.shape[1])
        back = np.where(number < count[:, None], count[:, None] - 1 - number, 0)
        one = np.take_along_axis(corner[first], back[:, :, None], 1)
        other = corner[second]
        seen = [np.einsum("pvi,pai->pva", corners - origin[:, None], axes) for corners in (one, other)]
        shared = clipped(seen[0], count, seen[1], self.count[second], flush=ROUNDING * size)

        lengths = np.linalg.norm(shared.edges, axis=2).sum(axis=1)
        width = 2 * shared.area / np.maximum(lengths, 1e-300)
        wide = width > NEGLIGIBLE * size
        shared, width = shared[wide].without_short_edges(ROUNDING * size), width[wide]
        first, second, middle, axes, origin, one, other, back = (
            a[wide] for a in (first, second, middle, axes, origin, one, other, back)
        )
        place = origin[:, None] + np.einsum("pva,pai->pvi", shared.corner, axes)
        heights = [
            np.einsum("pvi,pi->pv", points[:, :1] - place, normal[part] / _dots(normal[part], middle)[:, None])
            for points, part in ((one, first), (other, second))
        ]
        apart = heights[0] - heights[1]
        deepest = 2 * self.radius - np.where(shared.within, apart, np.inf).min(axis=1)
        towards, level, aside = self._normals(shared, (first, second), (one, other), back, normal, middle)
        gap = apart * _along(towards, middle) - 2 * self.radius
        extent = np.minimum.reduce([width, self.depth[first], self.depth[second]])
        keep = shared.within & (deepest <= DEEP * extent)[:, None] & (gap <= reach)
        # A vertex acts at its position, a crossing midway between the edges, a rounded corner on its surface.
        height = level * heights[0] + (1 - level) * heights[1]
        points = place + height[:, :, None] * middle[:, None] + apart[:, :, None] * aside
        points += ((1 - 2 * level) * self.radius)[:, :, None] * towards
        pair, k = np.nonzero(keep)
        return Touching(
            minus=self.of_part[second][pair],
            plus=self.of_part[first][pair],
            position=points[pair, k],
            normal=towards[pair, k],
            gap=gap[pair, k],
            level=level[pair, k],
            part=np.column_stack([second, first])[pair],
        )

    def _facing(self, corner: Array, normal: Array, reach: float) -> tuple[Index, Index]:
        """Return the pairs of close parts of different bodies that look at each other."""
        begin = np.searchsorted(self.of_part, np.arange(len(self.fixed) + 1))
        lowest, highest = corner.min(axis=1) - reach / 2, corner.max(axis=1) + reach / 2
        i, j = box_pairs(np.minimum.reduceat(lowest, begin[:-1]), np.maximum.reduceat(highest, begin[:-1]))
        free = ~(self.fixed[i] & self.fixed[j])
        i, j = i[free], j[free]
        count = np.diff(begin)
        pair, first, _ = expanded(begin[i], count[i])
        row, second, _ = expanded(begin[j[pair]], count[j[pair]])
        first = first[row]
        # At a crossing of two edges, each tilts its nearest face in its own plane: for boxes by 60 degrees in total.
        crossing = (1 - ROUNDING) * np.arccos(np.cos(self.edged[first]) * np.cos(self.edged[second]))
        looks = np.minimum(np.maximum.reduce([self.looks[first], self.looks[second], crossing]), LOOKS)
        facing = _dots(normal[first], normal[second]) < -np.cos(looks)
        first, second = first[facing], second[facing]
        close = np.all((lowest[first] <= highest[second]) & (lowest[second] <= highest[first]), axis=1)
        return first[close], second[close]

    def _normals(
        self,
        shared: Clipped,
        parts: tuple[Index, Index],
        points: tuple[Array, Array],
        back: Index,
        normal: Array,
        middle: Array,
    ) -> tuple[Array, Array, Array]:
        """Return normals (P, N, 3) at the corners of common areas, the share (P, N) of the first part, and offsets.

        Edges that cross in the projection are closest at an offset from the crossing, (P, N, 3) per unit of their
        distance along the mean normal.
        """
        M = self.corner.shape[1]
        ends = np.stack([shared.arriving, shared.edge])
        of_first = ends < M
        # At a crossing, the edge of each part.
        edges = [
            np.where(of_first[0], ends[0], np.where(of_first[1], ends[1], 0)),
            np.where(~of_first[0], ends[0], np.where(~of_first[1], ends[1], M)) - M,
        ]
        counts = [self.count[part] for part in parts]
        along, flat = [], []
        for k, (edge, part, corner, count) in enumerate(zip(edges, parts, points, counts, strict=True)):
            after = np.where(edge + 1 < count[:, None], edge + 1, 0)
            vector = np.take_along_axis(corner, after[:, :, None], 1) - np.take_along_axis(corner, edge[:, :, None], 1)
            along.append(vector / np.maximum(np.linalg.norm(vector, axis=2, keepdims=True), 1e-300))
            # In the reversed loop, edge i starts at the next vertex.
            original = np.take_along_axis(back, after, 1) if k == 0 else edge
            flat.append(np.take_along_axis(self.flat[part], original, 1))
        square = np.cross(*along)
        size = np.linalg.norm(square, axis=2)
        upward = _along(square, middle)
        sine = np.where(upward < 0, -1, 1) * np.maximum(size, 1e-300)
        square /= sine[:, :, None]
        # Nearly parallel edges.
        vague = (size < NO_CROSSING) | (np.abs(upward) < size / 2)
        vertex, other = of_first.all(axis=0), ~of_first.any(axis=0)
        # The edge of one part is in the face of the other, or continues flat in its own face.
        on_second = vertex | (~other & flat[1])
        on_first = (other | flat[0]) & ~on_second
        chosen = np.where(vague[:, :, None], middle[:, None], square)
        chosen = np.where(on_second[:, :, None], normal[parts[1]][:, None], chosen)
        chosen = np.where(on_first[:, :, None], -normal[parts[0]][:, None], chosen)
        crossing = ~(on_first | on_second | vague)
        across = middle[:, None] - _along(chosen, middle)[:, :, None] * chosen
        one, two = along
        shares = (np.einsum("pvi,pvi->pv", np.cross(*pair), chosen) / sine for pair in ((one, across), (across, two)))
        b, a = (np.where(crossing, share, 0.0)[:, :, None] for share in shares)
        return chosen, np.where(on_second, 1.0, np.where(on_first, 0.0, 0.5)), (b * two - a * one) / 2


def _along(vectors: Array, direction: Array) -> Array:
    """Return the components (P, N) of vectors (P, N, 3) along the direction (P, 3) of each row."""
    return np.asarray(np.einsum("pvi,pi->pv", vectors, direction))


def _dots(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("pi,pi->p", a, b))


def _sharpest(body: Polyhedron, beyond: Mapping[tuple[int, int], int]) -> tuple[float, float]:
    """Return the angles, radians, between the directions of the sharpest convex edge and corner and their nearest face.

    The face of an edge is on its left, seen from outside.
    """
    normals, corners = body.normals, body.vertices
    start, one, other = np.array([(a, f, beyond[b, a]) for (a, b), f in beyond.items()]).T
    # Parts of one face share corners.
    at = np.unique(np.column_stack([start, one]), axis=0)
    centre = np.array([corners[list(face)].mean(axis=0) for face in body.faces])
    cosine = _dots(normals[one], normals[other])
    out = (_dots(normals[one], centre[other] - corners[start]) <= 0) | (cosine > 1 - ROUNDING)
    halves = np.arccos(np.clip(cosine, -1.0, 1.0)) / 2
    points = np.zeros_like(corners)
    np.add.at(points, at[:, 0], normals[at[:, 1]])
    points /= np.maximum(np.linalg.norm(points, axis=1, keepdims=True), 1e-300)
    nearest = np.full(len(corners), -1.0)
    np.maximum.at(nearest, at[:, 0], _dots(points[at[:, 0]], normals[at[:, 1]]))
    corner = np.isin(np.arange(len(corners)), at[:, 0]) & ~np.isin(np.arange(len(corners)), start[~out])
    angles = np.arccos(np.clip(nearest[corner], -1.0, 1.0))
    return float(halves[out].max(initial=0.0)), float(angles.max(initial=0.0))


def _convex_parts(body: Polyhedron, face: int, loop: tuple[int, ...]) -> list[tuple[int, ...]]:
    points = body.vertices[list(loop)]
    edges = np.roll(points, -1, axis=0) - points
    turns = np.cross(edges, np.roll(edges, -1, axis=0)) @ body.normals[face]
    return [loop] if turns.min() >= 0 else triangulated(body.vertices, loop)
