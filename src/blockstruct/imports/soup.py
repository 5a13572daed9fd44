"""Assemble closed bodies from the loose faces of meshes and drawings."""

from itertools import chain, pairwise

import numpy as np

from blockstruct.arrays import Array, Flags, Index
from blockstruct.geometry.neighbours import connected
from blockstruct.geometry.planes import Corners
from blockstruct.imports.tolerances import LEAST_FACES, WELD

Face = tuple[int, ...]


def compact(vertices: Array, faces: list[Face]) -> tuple[Array, list[Face]]:
    """Return only the vertices of some faces, in their order, and the faces with new indices."""
    corners = Corners.of(faces)
    used, number = np.unique(corners.corner, return_inverse=True)
    loops = number.ravel().tolist()
    return vertices[used], [tuple(loops[a:b]) for a, b in pairwise([*corners.start.tolist(), len(loops)])]


def welded(vertices: Array, faces: list[Face]) -> tuple[Array, list[Face], int]:
    """Join corners within a ten-thousandth of the median edge; drop vertices without faces.

    Returns
    -------
    vertices, faces, int
        Faces do not repeat a corner joined with the next. The number counts the corners joined with a corner at
        different coordinates.
    """
    from scipy.spatial import cKDTree

    corner, _, following, start, _ = Corners.of(faces)
    edges = vertices[corner] - vertices[corner[following]]
    distance = WELD * float(np.median(np.linalg.norm(edges, axis=1)))

    points, of_corner = np.unique(vertices[corner], axis=0, return_inverse=True)
    label = connected(cKDTree(points).query_pairs(distance, output_type="ndarray"), len(points))
    # One vertex per cluster: the first in the file, in the order of the file.
    cluster = label[of_corner.ravel()]
    first = np.full(label.max() + 1, len(vertices))
    np.minimum.at(first, cluster, corner)
    new = np.argsort(np.argsort(first))[cluster]
    kept = new != new[following]
    ends = np.cumsum(np.add.reduceat(kept.astype(int), start))
    loops = new[kept].tolist()
    return (
        vertices[np.sort(first)],
        [tuple(loops[a:b]) for a, b in pairwise([0, *ends.tolist()])],
        len(points) - len(first),
    )


def collapsed(vertices: Array, faces: list[Face], dropped: Flags) -> list[Face]:
    """Return a face of each body without any remaining face: all its faces lack an area.

    Parameters
    ----------
    vertices : (n, 3) array
        Vertices in the file.
    faces
        All faces.
    dropped : (m,) array of bool
        Whether each face is dropped.
    """
    corner, face, *_ = Corners.of(faces)
    same = np.unique(vertices, axis=0, return_inverse=True)[1].ravel()
    label = _parts(face, same[corner])
    total, kept = np.bincount(label), np.bincount(label, ~dropped)
    # A single sliver between bodies is not a body.
    lost = (kept == 0) & ((total >= LEAST_FACES) | dropped.all())
    first = np.unique(label, return_index=True)
    return [faces[i] for body, i in zip(*first, strict=True) if lost[body]]


def gathered(faces: list[Face]) -> list[Face]:
    """Order faces so that faces connected by common vertices are contiguous.

    Readers of meshes sort faces by their number of corners. Bodies without common vertices are separate anyway.
    """
    corner, face, *_ = Corners.of(faces)
    _, first, label = np.unique(_parts(face, corner), return_index=True, return_inverse=True)
    return [faces[i] for i in np.argsort(first[label], kind="stable")]


def closed_bodies(faces: list[Face]) -> tuple[list[list[int]], int, int]:
    """Return the face indices of each body, the number of duplicate faces, and the number of duplicate bodies.

    Files list one body after the other. A body ends when its surface closes, whatever the orientation of its faces.
    Blocks that touch, and share corners, thus stay separate. A body of several pieces without a common edge is divided
    into the pieces. Duplicates belong to no body.
    """
    # If one of two blocks is inside out, their common face looks like a duplicate: compare within a body first.
    for whole_file in (False, True):
        bodies, closed, twins = _scanned(faces, whole_file)
        if closed:
            break
    pieces = [piece for body in bodies for piece in _pieces(faces, body)]
    # A duplicate body closes a second time, perhaps inside out.
    once = {frozenset(frozenset(faces[i]) for i in piece): piece for piece in reversed(pieces)}
    kept = sorted(once.values())
    doubled = len(pieces) - len(kept)
    if twins and twins == len(faces) - twins:
        doubled, twins = len(kept), 0
    return kept, twins, doubled


def _scanned(faces: list[Face], whole_file: bool) -> tuple[list[list[int]], bool, int]:
    """Return bodies in file order, whether the last is closed, and the number of duplicate faces."""
    bodies: list[list[int]] = [[]]
    loose: set[tuple[int, int]] = set()
    seen: set[Face] = set()
    awaited: Face = ()
    twins = of_body = 0
    for index, face in enumerate(faces):
        # Neighbours list their common face in opposite orientations; one body never lists a face in both.
        key = _from_least(face) if whole_file else min(_from_least(face), _from_least(face[::-1]))
        if key in seen or key == awaited:
            twins += 1
            of_body += 1
            continue
        seen.add(key)
        awaited = ()
        bodies[-1].append(index)
        for edge in _edges(face):
            if edge in loose:
                loose.remove(edge)
            else:
                loose.add(edge)
        if not loose:
            # If a duplicate followed each face, the duplicate of the last face follows now.
            awaited = key if of_body == len(bodies[-1]) - 1 else ()
            bodies.append([])
            of_body = 0
            if not whole_file:
                seen.clear()
    return [body for body in bodies if body], not bodies[-1], twins


def _from_least(face: Face) -> Face:
    """Rotate a face so that it begins with its smallest vertex index."""
    start = face.index(min(face))
    return face[start:] + face[:start]


def _edges(face: Face) -> list[tuple[int, int]]:
    return [(a, b) if a < b else (b, a) for a, b in pairwise((*face, face[0]))]


def _pieces(faces: list[Face], members: list[int]) -> list[list[int]]:
    number: dict[tuple[int, int], int] = {}
    edges = [[number.setdefault(edge, len(number)) for edge in _edges(faces[index])] for index in members]
    row = np.repeat(np.arange(len(members)), [len(e) for e in edges])
    label = _parts(row, np.array(list(chain.from_iterable(edges))))
    pieces: dict[int, list[int]] = {}
    for index, piece in zip(members, label.tolist(), strict=True):
        pieces.setdefault(piece, []).append(index)
    return list(pieces.values())


def _parts(face: Index, place: Index) -> Index:
    """Return the number of the part of each face. Faces with a common place, such as a vertex, are in one part."""
    n = face[-1] + 1
    return connected(np.column_stack([face, n + place]), n + place.max() + 1)[:n]
