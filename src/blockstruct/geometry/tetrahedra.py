"""Tetrahedra from the centroids of bodies to their surfaces, and overlaps of bodies that follow from them."""

from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.geometry.neighbours import expanded
from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.geometry.tolerances import CHUNK, NEGLIGIBLE, NO_AREA
from blockstruct.geometry.triangles import triangulated

Array = NDArray[np.float64]
Index = NDArray[np.int64]
#: Vertices of the triangles of a face.
Triangles = list[tuple[int, ...]]

#: Corners of the faces of a tetrahedron, counter-clockwise seen from outside, and of its edges.
_FACES, _EDGES = np.array([(1, 2, 3), (0, 2, 1), (0, 3, 2), (0, 1, 3)]), np.array(list(combinations(range(4), 2)))


def may_overlap(bodies: list[Polyhedron], i: Index, j: Index, tolerance: float) -> NDArray[np.bool_]:
    """Return whether the bodies i (m,) and j (m,) may overlap by more than a tolerance.

    The answer is exact for two bodies whose centroids see their whole surfaces, as of convex and of curved blocks. For
    other bodies it is always true.
    """
    if not len(i):
        return np.zeros(0, dtype=bool)
    near, place = np.unique(np.concatenate([i, j]), return_inverse=True)
    one, other = place.reshape(2, -1)
    parts, count = Tetrahedra.of([bodies[k] for k in near], tolerance)
    low, high = parts.corners.min(axis=1) + tolerance / 2, parts.corners.max(axis=1) - tolerance / 2
    start = np.cumsum(count) - count
    lows, highs = (np.array([f(bodies[k].vertices, axis=0) for k in near]) for f in (np.min, np.max))
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
        kept = seen[body_of] & (volumes > 0.0)
        corners = corners[kept]
        a, b, c = (corners[:, _FACES[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=2, keepdims=True)
        edges = corners[:, _EDGES[:, 1]] - corners[:, _EDGES[:, 0]]
        edges /= np.linalg.norm(edges, axis=2, keepdims=True)
        heights = np.einsum("tfj,tfj->tf", normals, a)
        return cls(corners, normals, heights, edges), np.bincount(body_of[kept], minlength=len(bodies))

    def overlap(self, i: Index, j: Index, tolerance: float) -> NDArray[np.bool_]:
        """Return whether the tetrahedra i (m,) and j (m,) overlap by more than a tolerance, by separating axes."""
        answer = np.ones(len(i), dtype=bool)
        for one, other in ((i, j), (j, i)):
            rows = np.flatnonzero(answer)
            beyond = np.einsum("mfj,mkj->mfk", self.normals[one[rows]], self.corners[other[rows]]).min(axis=2)
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
) -> tuple[Array, Array, Index, NDArray[np.bool_]]:
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
