"""Bodies that overlap: tetrahedra that may meet, and the depth at sampled points."""

from dataclasses import dataclass
from functools import cache
from itertools import combinations, pairwise, product
from typing import Self

import numpy as np

from blockstruct.arrays import CHUNK, NEGLIGIBLE, Array, Flags, Index
from blockstruct.geometry.neighbours import box_pairs, expanded, separations
from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.geometry.tolerances import NO_AREA, SAMPLES
from blockstruct.geometry.triangles import between_crossings, distances, half_solid_angles, triangulated

#: Vertices of the triangles of a face.
Triangles = list[tuple[int, ...]]

#: Corners of the faces of a tetrahedron, counter-clockwise seen from outside, and of its edges.
_FACES, _EDGES = np.array([(1, 2, 3), (0, 2, 1), (0, 3, 2), (0, 1, 3)]), np.array(list(combinations(range(4), 2)))
#: Unit vectors (3, 13) to the faces, edges and corners of a cube, without their opposites, those along the axes first.
#: Of oblique bodies whose boxes meet, a third have no gap along any of them.
_DIRECTIONS = np.array(
    sorted((d for d in product((0.0, 1.0, -1.0), repeat=3) if d > (0.0, 0.0, 0.0)), key=np.count_nonzero)
).T
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=0)


def may_overlap(bodies: list[Polyhedron], i: Index, j: Index, tolerance: float) -> Flags:
    """Return whether the bodies i (m,) and j (m,) may overlap by more than a tolerance.

    The answer is exact for two bodies whose centroids see their whole surfaces, as of convex and of curved blocks. For
    other bodies it is always true.
    """
    if not len(i):
        return np.zeros(0, dtype=bool)
    near, place = np.unique(np.concatenate([i, j]), return_inverse=True)
    one, other = place.reshape(2, -1)
    parts, count = Tetrahedra.of([bodies[k] for k in near], tolerance)
    along = parts.corners @ _DIRECTIONS
    low, high = along.min(axis=1) + tolerance / 2, along.max(axis=1) - tolerance / 2
    start = np.cumsum(count) - count
    lows, highs = (np.array([f(bodies[k].vertices @ _DIRECTIONS, axis=0) for k in near]) for f in (np.min, np.max))
    answer = (count[one] == 0) | (count[other] == 0)
    open_pairs = np.flatnonzero(~answer)
    # A pair of tetrahedra takes about a hundred values.
    chunk = np.cumsum(count[one[open_pairs]] * count[other[open_pairs]]) // (CHUNK // 100)
    for pairs in np.split(open_pairs, np.flatnonzero(np.diff(chunk)) + 1):
        chosen = []
        for of, box in ((one[pairs], other[pairs]), (other[pairs], one[pairs])):
            pair, part, _ = expanded(start[of], count[of])
            meets = np.all((low[part] <= highs[box[pair]]) & (high[part] >= lows[box[pair]]), axis=1)
            chosen.append((pair[meets], part[meets]))
        (pair, part), (pair_of_other, part_of_other) = chosen
        number = np.bincount(pair_of_other, minlength=len(pairs))
        row, column, _ = expanded((np.cumsum(number) - number)[pair], number[pair])
        pair, a, b = pair[row], part[row], part_of_other[column]
        meets = np.all((low[a] <= high[b]) & (high[a] >= low[b]), axis=1)
        pair, a, b = pair[meets], a[meets], b[meets]
        answer[pairs[pair[parts.overlap(a, b, tolerance)]]] = True
    return np.asarray(answer)


@dataclass(frozen=True, slots=True)
class Tetrahedra:
    """Tetrahedra, with the directions that may separate them from others.

    Attributes
    ----------
    corners : (t, 4, 3) array
    normals, heights : (t, 4, 3) and (t, 4) arrays
        Planes of their faces, outward.
    edges : (t, 6, 3) array
        Unit vectors.
    """

    corners: Array
    normals: Array
    heights: Array
    edges: Array

    @classmethod
    def of(cls, bodies: list[Polyhedron], tolerance: float) -> tuple[Self, Index]:
        """Return the tetrahedra of bodies, and the number of each body.

        A body whose centroid does not see its whole surface has none. Faces with a deviation above the tolerance are
        divided as their neighbours divide them.
        """
        faces = [(k, face) for k, body in enumerate(bodies) for face in body.faces]
        triangles: list[Triangles] = [[(face[0], a, b) for a, b in pairwise(face[1:])] for _, face in faces]
        uneven = np.concatenate([b.deviations for b in bodies]) > tolerance
        *_, of_face, is_hidden = _cones(bodies, faces, triangles)
        # The fan of a face that is not convex has triangles outside the face.
        uneven[of_face[is_hidden]] = True
        for f in np.flatnonzero(uneven).tolist():
            body, face = faces[f]
            triangles[f] = triangulated(bodies[body].vertices, face)
        corners, volumes, of_face, is_hidden = _cones(bodies, faces, triangles)
        body_of = np.array([k for k, _ in faces])[of_face]
        seen = np.ones(len(bodies), dtype=bool)
        seen[body_of[is_hidden]] = False
        is_kept = seen[body_of] & (volumes > 0.0)
        corners = corners[is_kept]
        a, b, c = (corners[:, _FACES[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=2, keepdims=True)
        edges = corners[:, _EDGES[:, 1]] - corners[:, _EDGES[:, 0]]
        edges /= np.linalg.norm(edges, axis=2, keepdims=True)
        heights = np.einsum("tfj,tfj->tf", normals, a)
        return cls(corners, normals, heights, edges), np.bincount(body_of[is_kept], minlength=len(bodies))

    def overlap(self, i: Index, j: Index, tolerance: float) -> Flags:
        """Return whether the tetrahedra i (m,) and j (m,) overlap by more than a tolerance, by separating axes."""
        answer = np.ones(len(i), dtype=bool)
        for one, other in ((i, j), (j, i)):
            rows = np.flatnonzero(answer)
            beyond = np.matmul(self.normals[one[rows]], self.corners[other[rows]].transpose(0, 2, 1)).min(axis=2)
            answer[rows] = np.all(self.heights[one[rows]] - beyond > tolerance, axis=1)
        rows = np.flatnonzero(answer)
        axes = np.cross(self.edges[i[rows], :, None], self.edges[j[rows], None]).reshape(-1, len(_EDGES) ** 2, 3)
        length = np.linalg.norm(axes, axis=2)
        axes /= np.maximum(length, NEGLIGIBLE)[..., None]
        along, others = (np.einsum("maj,mkj->mak", axes, self.corners[of[rows]]) for of in (i, j))
        depth = np.minimum(along.max(axis=2) - others.min(axis=2), others.max(axis=2) - along.min(axis=2))
        answer[rows] = np.all((depth > tolerance) | (length <= NEGLIGIBLE), axis=1)
        return answer


def _cones(
    bodies: list[Polyhedron], faces: list[tuple[int, tuple[int, ...]]], triangles: list[Triangles]
) -> tuple[Array, Array, Index, Flags]:
    """Return the tetrahedra (t, 4, 3) on triangles, six times their volumes, their faces, and which are inverted.

    A volume of rounding is zero.
    """
    first = np.cumsum([0, *(len(b.vertices) for b in bodies[:-1])])
    of_face = np.repeat(np.arange(len(faces)), [len(some) for some in triangles])
    of_body = np.array([k for k, _ in faces])[of_face]
    corners = np.concatenate([b.vertices for b in bodies])[
        np.array([triangle for some in triangles for triangle in some]) + first[of_body, None]
    ]
    apex = np.array([b.centroid for b in bodies])[of_body, None]
    arms = corners - apex
    volumes = np.einsum("ij,ij->i", arms[:, 0], np.cross(arms[:, 1], arms[:, 2]))
    volumes[np.abs(volumes) <= NO_AREA * np.array([b.volume for b in bodies])[of_body]] = 0.0
    return np.concatenate([apex, corners], axis=1), volumes, of_face, volumes < 0.0


def overlapping_pairs(bodies: list[Polyhedron], tolerance: float) -> list[tuple[int, int, float]]:
    """Return the pairs of bodies whose interiors meet, with a penetration depth.

    Convex pairs are decided exactly, by separating axes. If a body is not convex, the test follows grids of lines
    through the common bounding box, and the edges of both bodies. It may miss an overlap without an edge of either
    body that is smaller than a twelfth of this box in two directions.

    Parameters
    ----------
    bodies
        Polyhedra.
    tolerance
        Largest depth that counts as touching.

    Returns
    -------
    list of (i, j, depth)
        ``i < j``. The depth is the depth of the convex hulls in the shallowest direction. If a body is not convex, it
        is at most the thickness of the common part.
    """
    if len(bodies) < 2:
        return []
    extents = [b.vertices @ _DIRECTIONS for b in bodies]
    low = np.array([extent.min(axis=0) for extent in extents]) + tolerance / 2
    high = np.array([extent.max(axis=0) for extent in extents]) - tolerance / 2
    i, j = box_pairs(low[:, :3], high[:, :3])
    close = np.all((low[i] <= high[j]) & (low[j] <= high[i]), axis=1)
    i, j = i[close], j[close]
    # A plane along a face separates nearly all neighbours, and planes between parts nearly all others that only touch.
    close = separations(bodies, i, j) < -tolerance
    i, j = i[close], j[close]
    close = may_overlap(bodies, i, j, tolerance)
    pairs = []
    surface = cache(lambda k: _Surface.of(bodies[k], tolerance))
    for one, other in zip(i[close].tolist(), j[close].tolist(), strict=True):
        depth = _hull_depth(bodies[one], bodies[other])
        if depth > tolerance and not (surface(one).convex and surface(other).convex):
            depth = min(depth, _sampled_depth(surface(one), surface(other)))
        if depth > tolerance:
            pairs.append((one, other, depth))
    return pairs


def bodies_at(bodies: list[Polyhedron], point: Array, tolerance: float) -> tuple[list[int], list[int]]:
    """Return the bodies with a point (3,) in their interior, and the bodies with the point on their surface.

    A point belongs to a surface up to a distance of ``tolerance``.
    """
    within, on = [], []
    for k, body in enumerate(bodies):
        low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
        if np.any(point < low - tolerance) or np.any(point > high + tolerance):
            continue
        triangles = _Surface.of(body, tolerance).triangles
        if distances(point[None], triangles)[0] <= tolerance:
            on.append(k)
        elif half_solid_angles(triangles, point[None])[0] > np.pi:
            within.append(k)
    return within, on


@dataclass(frozen=True, slots=True)
class _Surface:
    """Surface of a body, for tests of points inside.

    Attributes
    ----------
    low, high : (3,) arrays
    normals, heights : (h, 3) and (h,) arrays
        Planes of faces with the whole body on one side.
    convex
        Whether all faces are such faces.
    triangles : (t, 3, 3) array
        Corners of the triangles with an area.
    edges : (e, 2, 3) array
        Ends of the edges of faces.
    """

    low: Array
    high: Array
    normals: Array
    heights: Array
    convex: bool
    triangles: Array
    edges: Array

    @classmethod
    def of(cls, body: Polyhedron, tolerance: float) -> Self:
        v = body.vertices
        heights = np.einsum("ij,ij->i", body.normals, v[[face[0] for face in body.faces]])
        hull = (body.normals @ v.T - heights[:, None]).max(axis=1) <= tolerance
        corners = v[[t for face in body.faces for t in triangulated(v, face)]]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        triangles = corners[areas > NO_AREA * areas.max()]
        edges = v[[edge for face in body.faces for edge in pairwise((*face, face[0])) if edge[0] < edge[1]]]
        return cls(v.min(axis=0), v.max(axis=0), body.normals[hull], heights[hull], bool(hull.all()), triangles, edges)


def _directions(body: Polyhedron) -> Array:
    edges = np.concatenate([body.vertices[list(f)] - body.vertices[[*f[1:], f[0]]] for f in body.faces])
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    sign = np.where(edges[np.arange(len(edges)), np.argmax(np.abs(edges), axis=1)] < 0, -1.0, 1.0)
    return np.unique(np.round(edges * sign[:, None], 9), axis=0)


def _hull_depth(a: Polyhedron, b: Polyhedron) -> float:
    axes = [a.normals, b.normals]
    edges, others = _directions(a), _directions(b)
    # For finely faceted bodies the normals are enough.
    if len(edges) * len(others) * (len(a.vertices) + len(b.vertices)) <= CHUNK:
        cross = np.cross(edges[:, None], others[None]).reshape(-1, 3)
        length = np.linalg.norm(cross, axis=1)
        axes.append(cross[length > NEGLIGIBLE] / length[length > NEGLIGIBLE, None])
    directions = np.concatenate(axes).T
    pa, pb = a.vertices @ directions, b.vertices @ directions
    return float(np.minimum(pa.max(axis=0) - pb.min(axis=0), pb.max(axis=0) - pa.min(axis=0)).min())


def _sampled_depth(a: _Surface, b: _Surface) -> float:
    """Return the largest thickness of the common part of two bodies at sampled points, from face to face."""
    low, high = np.maximum(a.low, b.low), np.minimum(a.high, b.high)
    near = [_meeting(body.triangles, low, high) for body in (a, b)]
    points = _between(_grid_lines(low, high), np.concatenate(near))
    points = _inside(_inside(points, a), b)
    samples = [points]
    # A part thinner than the grid in two directions usually contains an edge of one body.
    for body, other, triangles in ((a, b, near[1]), (b, a, near[0])):
        samples.append(_inside(_between(_meeting(body.edges, low, high), triangles), other))
    points = np.concatenate(samples)
    if not len(points):
        return 0.0
    parts = np.array_split(points, max(a.triangles.size, b.triangles.size) * len(points) // CHUNK + 1)
    return max(float((distances(p, a.triangles) + distances(p, b.triangles)).max()) for p in parts if len(p))


def _meeting(shapes: Array, low: Array, high: Array) -> Array:
    """Select the shapes (k, n, 3) whose box meets the box between two corners."""
    return shapes[np.all((shapes.min(axis=1) <= high) & (shapes.max(axis=1) >= low), axis=1)]


def _grid_lines(low: Array, high: Array) -> Array:
    """Return a grid of lines (m, 2, 3) through a box along each of its three axes."""
    # Offset from regular positions, where blocks often have faces and edges.
    steps = (np.arange(SAMPLES) + 0.5 + 0.013 * np.sqrt(2)) / (SAMPLES + 0.1)
    first, second = (grid.ravel() for grid in np.meshgrid(steps, steps + 1e-3, indexing="ij"))
    lines = []
    for axis in range(3):
        shares = np.zeros((len(first), 2, 3))
        shares[:, :, (axis + 1) % 3], shares[:, :, (axis + 2) % 3] = first[:, None], second[:, None]
        shares[:, 1, axis] = 1.0
        lines.append(shares)
    return np.asarray(low + np.concatenate(lines) * (high - low))


def _between(lines: Array, triangles: Array) -> Array:
    parts = np.array_split(lines, 3 * len(lines) * len(triangles) // CHUNK + 1)
    return np.concatenate([between_crossings(part, triangles) for part in parts])


def _inside(points: Array, body: _Surface) -> Array:
    """Select the points (k, 3) inside a body."""
    points = points[np.all(points @ body.normals.T < body.heights, axis=1)]
    parts = np.array_split(points, body.triangles.size * len(points) // CHUNK + 1)
    return np.concatenate([part[half_solid_angles(body.triangles, part) > np.pi] for part in parts])
