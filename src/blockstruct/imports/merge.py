"""Merge faces of one body that lie in one plane."""

from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.geometry.neighbours import connected, expanded
from blockstruct.geometry.planes import Planes
from blockstruct.geometry.polygon import plane_axes
from blockstruct.imports.tolerances import EXACT, NO_AREA, ONE_PLANE

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Face = tuple[int, ...]


def merged_faces(vertices: Array, faces: list[Face], tolerance: float, size: float) -> tuple[list[Face], int]:
    """Merge neighbours in one plane, and faces without area with a neighbour.

    If the merged face would have a hole, or would be a curved chain of faces, only faces exactly in one plane are
    merged. If this face has a hole too, its faces stay separate.

    Parameters
    ----------
    vertices : (n, 3) array
    faces
        Vertex indices of a closed surface, with a consistent orientation.
    tolerance
        Largest distance of a vertex from the common plane.
    size
        Largest extent of the body.

    Returns
    -------
    faces, int
        Merged faces, without vertices inside straight edges, and the number of faces without area.
    """
    planes = Planes.of(vertices, faces)
    empty = planes.area <= NO_AREA * planes.longest**2
    normals = np.where(empty[:, None], 0.0, planes.normal)
    pairs = _neighbours(faces)
    if empty.any():
        _lend_normals(vertices, faces, normals, empty)
    merged: list[Face] = []
    rest = np.arange(len(faces))
    for limit in (tolerance, EXACT * size):
        close = _in_one_plane(vertices, planes, normals, empty, pairs, limit) & np.isin(pairs, rest).all(axis=1)
        label = connected(pairs[close], len(faces))
        order = rest[np.argsort(label[rest], kind="stable")]
        refused = []
        for group in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
            face: Face | None = faces[group[0]]
            if len(group) > 1:
                vectors = planes.area[group, None] * planes.normal[group]
                face = _outline(vertices, [faces[i] for i in group], vectors, limit)
            if face is None:
                refused.extend(group.tolist())
            else:
                merged.append(face)
        rest = np.array(refused, dtype=int)
        if not refused:
            break
    merged += [faces[i] for i in rest]
    return _without_middles(vertices, merged, tolerance), int(empty.sum())


def _neighbours(faces: list[Face]) -> Index:
    """Return the pairs (m, 2) of faces on the two sides of each edge."""
    left = {edge: index for index, face in enumerate(faces) for edge in pairwise((*face, face[0]))}
    pairs = [(index, left[edge[::-1]]) for edge, index in left.items() if edge[0] < edge[1]]
    return np.array(pairs, dtype=int).reshape(-1, 2)


def _lend_normals(vertices: Array, faces: list[Face], normals: Array, empty: NDArray[np.bool_]) -> None:
    """Give a face without area the plane of its neighbour at its longest edge."""
    left = {edge: index for index, face in enumerate(faces) for edge in pairwise((*face, face[0]))}
    lender = {}
    for index in np.flatnonzero(empty):
        edges = list(pairwise((*faces[index], faces[index][0])))
        edge = max(edges, key=lambda e: float(np.linalg.norm(vertices[e[1]] - vertices[e[0]])))
        lender[index] = left[edge[::-1]]
    # The neighbour may not have a plane yet. Each pass completes at least one more face of a row.
    for _ in lender:
        for index, neighbour in lender.items():
            normals[index] = normals[neighbour]


def _in_one_plane(
    vertices: Array, planes: Planes, normals: Array, empty: NDArray[np.bool_], pairs: Index, limit: float
) -> NDArray[np.bool_]:
    """Whether the vertices of each of two neighbours lie in the plane of the other."""
    # Some readers make fans over polygons that are not convex. They contain triangles with opposite normals.
    close = np.abs(np.einsum("ij,ij->i", normals[pairs[:, 0]], normals[pairs[:, 1]])) > ONE_PLANE
    count = np.bincount(planes.face)
    for one, other in (pairs.T, pairs.T[::-1]):
        of_pair, corner, _ = expanded(planes.start[other], count[other])
        arms = vertices[planes.corner[corner]] - planes.centre[one][of_pair]
        far = np.zeros(len(pairs))
        np.maximum.at(far, of_pair, np.abs(np.einsum("ij,ij->i", arms, normals[one][of_pair])))
        close &= far <= np.where(empty[one], np.inf, limit)
    return np.asarray(close)


def _outline(vertices: Array, group: list[Face], vectors: Array, limit: float) -> Face | None:
    """Return the outline of a group of faces with their area vectors, if it is a plane, simple polygon."""
    edges = {edge for face in group for edge in pairwise((*face, face[0]))}
    following: dict[int, int] = {}
    for a, b in edges:
        if (b, a) not in edges:
            if a in following:
                return None
            following[a] = b
    if not following:
        return None
    loop = [min(following)]
    while (vertex := following[loop[-1]]) != loop[0]:
        loop.append(vertex)
    if len(loop) < max(3, len(following)):
        return None
    area = vectors.sum(axis=0)
    normal = area / max(np.linalg.norm(area), np.finfo(float).tiny)
    points = vertices[loop] - vertices[loop].mean(axis=0)
    if not np.any(area) or np.abs(points @ normal).max() > limit:
        return None
    # Two triangles with the same orientation cannot overlap.
    simple = len(loop) == 4 and bool(np.all(vectors @ normal >= 0))
    return tuple(loop) if simple or shapely.Polygon(points @ np.stack(plane_axes(normal)).T).is_valid else None


def _without_middles(vertices: Array, faces: list[Face], tolerance: float) -> list[Face]:
    """Drop vertices on a straight line where only two faces meet."""
    met = np.bincount([i for f in faces for i in f], minlength=len(vertices))
    straight = set()
    for face in faces:
        for a, b, c in zip((face[-1], *face[:-1]), face, (*face[1:], face[0]), strict=True):
            along = vertices[c] - vertices[a]
            length = np.linalg.norm(along)
            if met[b] == 2 and length > 0:
                share = (vertices[b] - vertices[a]) @ along / length**2
                off = np.linalg.norm(vertices[b] - vertices[a] - share * along)
                if 0 < share < 1 and off <= tolerance:
                    straight.add(b)
    if not straight:
        return faces
    kept = [tuple(i for i in face if i not in straight) for face in faces]
    # A face with only two remaining corners is a thin sliver of the body: keep all faces.
    return kept if min(len(face) for face in kept) >= 3 else faces
