"""Make closed surfaces of planar outward polygons from loose faces."""

from collections import Counter
from dataclasses import dataclass
from itertools import chain, pairwise

import numpy as np
import shapely

from blockstruct.arrays import CHUNK, NEGLIGIBLE, Array, Flags, Index
from blockstruct.errors import GeometryError
from blockstruct.geometry.neighbours import connected, expanded
from blockstruct.geometry.polygon import Corners, Face, Planes, plane_axes
from blockstruct.geometry.tolerances import PARALLEL
from blockstruct.geometry.triangles import triangulated
from blockstruct.imports.tolerances import (
    EXACT,
    LEAST_FACES,
    MOST_FACES_OF_BODY,
    POLYGON,
    SHALLOW,
    WELD,
)
from blockstruct.vocabulary import counted


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


def flattened(vertices: Array, faces: list[Face], tolerance: float, size: float) -> tuple[Array, list[Face], int]:
    """Make every face planar to rounding.

    Each polygon within the tolerance gets a plane, and every vertex moves to the nearest common point of its planes.
    Two blocks with a common face thus keep a common face. Other polygons are divided into triangles by their shortest
    diagonals, so that two blocks divide a common warped face in the same way.

    Parameters
    ----------
    vertices : (n, 3) array
    faces
        Vertex indices of each face.
    tolerance
        Largest deviation from a plane of a polygon that is flattened.
    size
        Largest extent of the body.

    Returns
    -------
    vertices, faces, int
        Moved vertices, planar faces, and the number of polygons divided into triangles.
    """
    off = Planes.of(vertices, faces).deviation
    limit = EXACT * size
    if np.all(off <= limit):
        return vertices, faces, 0
    warped = off > tolerance
    kept = [f for f, bad in zip(faces, warped, strict=True) if not bad]
    points = _moved(vertices, kept, limit)
    move = float(np.linalg.norm(points - vertices, axis=1).max())
    if move > 2 * tolerance or (kept and Planes.of(points, kept).deviation.max() > limit):
        points, warped = vertices, off > limit
    loops = [t for f, bad in zip(faces, warped, strict=True) for t in (triangulated(points, f) if bad else [f])]
    return points, loops, int(warped.sum())


def _moved(vertices: Array, faces: list[Face], limit: float) -> Array:
    """Move vertices to the nearest common points of the planes of their polygons, until all are planar."""
    polygons = [f for f in faces if len(f) > 3]
    points = vertices.copy()
    if not polygons:
        return points
    planes = Planes.of(points, polygons)
    corner, of_face = planes.corners.corner, planes.corners.face
    order = np.argsort(corner, kind="stable")
    vertex, count = np.unique(corner, return_counts=True)
    slot = np.arange(len(corner)) - np.repeat(np.cumsum(count) - count, count)
    row = np.repeat(np.arange(len(vertex)), count)
    before, off = np.inf, planes.deviation.max()
    while limit < off < before:
        height = np.einsum("ij,ij->i", points[corner] - planes.centre[of_face], planes.normal[of_face])
        normals = np.zeros((len(vertex), count.max(), 3))
        offsets = np.zeros((len(vertex), count.max(), 1))
        normals[row, slot] = planes.normal[of_face[order]]
        offsets[row, slot, 0] = -height[order]
        points[vertex] += (np.linalg.pinv(normals, rcond=SHALLOW) @ offsets)[:, :, 0]
        planes = Planes.of(points, polygons)
        before, off = off, planes.deviation.max()
    return points


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
    empty = planes.area <= NEGLIGIBLE * planes.longest**2
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


def _lend_normals(vertices: Array, faces: list[Face], normals: Array, empty: Flags) -> None:
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


def _in_one_plane(vertices: Array, planes: Planes, normals: Array, empty: Flags, pairs: Index, limit: float) -> Flags:
    """Whether the vertices of each of two neighbours lie in the plane of the other."""
    # Some readers make fans over polygons that are not convex. They contain triangles with opposite normals.
    close = np.abs(np.einsum("ij,ij->i", normals[pairs[:, 0]], normals[pairs[:, 1]])) > PARALLEL
    corners = planes.corners
    for one, other in (pairs.T, pairs.T[::-1]):
        of_pair, corner, _ = expanded(corners.start[other], corners.sides[other])
        arms = vertices[corners.corner[corner]] - planes.centre[one][of_pair]
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


@dataclass(frozen=True, slots=True)
class Surface:
    """A closed surface, and the repairs of its faces.

    Attributes
    ----------
    vertices : (n, 3) array
    moves : (n, 3) array
        Move of each vertex.
    faces
        Vertex indices of each planar face, counter-clockwise seen from outside.
    repairs : dict
        Number of repairs of each kind or, for ``"flattened"``, the largest move of a vertex.
    """

    vertices: Array
    moves: Array
    faces: list[Face]
    repairs: dict[str, float]


def closed_surface(vertices: Array, faces: list[Face], name: str, tolerance: float | None = None) -> Surface:
    """Repair the faces of one body.

    All faces look outward. Neighbours in one plane become one face, and a face without area is merged with a neighbour.
    Vertices near the plane of a face move into the plane. Other warped faces are divided into triangles.

    Parameters
    ----------
    vertices : (n, 3) array
        Vertices of the body.
    faces
        Vertex indices of the faces of one body, in any orientation.
    name
        Name of the block in error messages.
    tolerance
        Largest deviation from the plane of a face. By default it is 0.5 % of the size of the body for polygons, and
        0.01 % for neighbours that become one face.

    Raises
    ------
    GeometryError
        If there are no faces or more than 20,000, or the surface is open, not a manifold, one-sided, or crosses itself.
    """
    if len(faces) > MOST_FACES_OF_BODY:
        msg = (
            f"block {name!r}: {len(faces)} faces, the limit is {MOST_FACES_OF_BODY}; simplify the mesh first "
            "(a rigid block needs the shape of its joints, not the grain of its surface)"
        )
        raise GeometryError(msg)
    if not faces:
        x, y, z = vertices[0] if len(vertices) else (np.nan,) * 3
        msg = (
            f"block {name!r}: no face has an area, at ({x:.6g}, {y:.6g}, {z:.6g}) m: the corners are one "
            "point, or on one line; export it with more digits or nearer to the origin, or exclude it"
        )
        raise GeometryError(msg)
    for face in faces:
        if len(set(face)) < len(face):
            x, y, z = vertices[face[0]]
            msg = (
                f"block {name!r}: a face at ({x:.6g}, {y:.6g}, {z:.6g}) m repeats a corner; divide it, "
                "because a face has no hole and no neck of zero width"
            )
            raise GeometryError(msg)
    repairs: dict[str, float] = {}
    _check_manifold(vertices, faces, name)
    outward, repairs["turned"] = _outward(vertices, faces, name)
    size = float(np.ptp(vertices, axis=0).max())
    whole, repairs["no area"] = merged_faces(vertices, outward, tolerance or WELD * size, size)
    repairs["merged"] = len(outward) - len(whole) - repairs["no area"]
    moved, divided, repairs["split"] = flattened(vertices, whole, tolerance or POLYGON * size, size)
    repairs["flattened"] = float(np.linalg.norm(moved - vertices, axis=1).max())
    rows, loops = compact(np.column_stack([moved, moved - vertices]), divided)
    points, moves = rows[:, :3], rows[:, 3:]
    crossing = first_crossing(points, loops, size)
    if crossing is not None:
        x, y, z = crossing
        msg = (
            f"block {name!r}: its surface crosses itself near ({x:.6g}, {y:.6g}, {z:.6g}) m; "
            "correct the mesh there, or divide the block"
        )
        raise GeometryError(msg)
    return Surface(points, moves, loops, {kind: amount for kind, amount in repairs.items() if amount})


_REMEDY_OF_FACE = "if this face is the ground, make it a support (fixed, --fix), which adds the block behind it"


def _check_manifold(vertices: Array, faces: list[Face], name: str) -> None:
    edges = Counter((min(a, b), max(a, b)) for f in faces for a, b in pairwise((*f, f[0])))
    bad = [edge for edge, count in edges.items() if count != 2]
    if not bad:
        return
    a, b = (", ".join(f"{x:.6g}" for x in vertices[i]) for i in bad[0])
    where = f"edge ({a}) to ({b}) m belongs to"
    edge_count = counted(len(bad), "edge")
    if any(edges[edge] > 2 for edge in bad):
        most = max(edges[edge] for edge in bad)
        msg = (
            f"block {name!r}: not a solid body, {edge_count} not of two faces: {where} {edges[bad[0]]} "
            f"(up to {most}); give each block as a body of its own, without inner faces"
        )
    else:
        msg = (
            f"block {name!r}: the surface is open at {edge_count}: {where} one face; "
            f"{_REMEDY_OF_FACE if len(faces) == 1 else 'add the missing faces, or close the hole in the mesh'}"
        )
    raise GeometryError(msg)


def _outward(vertices: Array, faces: list[Face], name: str) -> tuple[list[Face], int]:
    """Orient all faces outward; return the faces and the number of reversed faces."""
    of_edge: dict[tuple[int, int], list[tuple[int, bool]]] = {}
    for index, face in enumerate(faces):
        for a, b in pairwise((*face, face[0])):
            of_edge.setdefault((min(a, b), max(a, b)), []).append((index, a < b))
    turned: dict[int, bool] = {0: False}
    queue = [0]
    while queue:
        index = queue.pop()
        for a, b in pairwise((*faces[index], faces[index][0])):
            (one, way), (other, other_way) = of_edge[min(a, b), max(a, b)]
            neighbour = other if one == index else one
            sense = turned[index] != (way == other_way)
            if neighbour not in turned:
                turned[neighbour] = sense
                queue.append(neighbour)
            elif turned[neighbour] != sense:
                msg = f"block {name!r}: the surface has only one side, like a Möbius band; correct the mesh"
                raise GeometryError(msg)
    loops = [face[::-1] if turned[index] else face for index, face in enumerate(faces)]
    if _signed_volume(vertices, loops) < 0:
        turned = {index: not sense for index, sense in turned.items()}
        loops = [face[::-1] for face in loops]
    return loops, sum(turned.values())


def _signed_volume(vertices: Array, faces: list[Face]) -> float:
    fan = np.array([(f[0], a, b) for f in faces for a, b in pairwise(f[1:])])
    a, b, c = (vertices - vertices.mean(axis=0))[fan.T]
    return float(np.einsum("ij,ij->", a, np.cross(b, c)))


def first_crossing(vertices: Array, faces: list[Face], size: float) -> Array | None:
    """Return a point (3,) where a closed surface crosses itself, or None.

    The surface crosses itself if an edge passes through a face or the outline of a polygon crosses itself. Convex
    bodies need no search.

    Parameters
    ----------
    vertices : (n, 3) array
    faces
        Vertex indices of each planar face.
    size
        Largest extent of the body.
    """
    planes = Planes.of(vertices, faces)
    corner, face, *_ = planes.corners
    axes = np.stack(plane_axes(planes.normal), axis=1)[face]
    flat = np.einsum("kaj,kj->ka", axes, vertices[corner] - planes.centre[face])
    simple = shapely.is_valid(shapely.polygons(shapely.linearrings(flat, indices=face)))
    if not simple.all():
        wrong = int(np.argmin(simple))
        u, v = _crossing_of_outline(flat[face == wrong])
        return np.asarray(planes.centre[wrong] + np.stack(plane_axes(planes.normal[wrong])).T @ (u, v))
    if planes.heights(vertices).max() <= EXACT * size:
        return None
    triangles = np.array([t for f in faces for t in triangulated(vertices, f)])
    edges = np.array(sorted({(min(a, b), max(a, b)) for f in faces for a, b in pairwise((*f, f[0]))}))
    low_edge, high_edge = vertices[edges].min(axis=1), vertices[edges].max(axis=1)
    low_face, high_face = vertices[triangles].min(axis=1), vertices[triangles].max(axis=1)
    x, y, z = np.argsort(-np.ptp(vertices, axis=0))
    tree = shapely.STRtree(shapely.box(low_face[:, x], low_face[:, y], high_face[:, x], high_face[:, y]))
    e, t = tree.query(shapely.box(low_edge[:, x], low_edge[:, y], high_edge[:, x], high_edge[:, y]))
    keep = (low_edge[e, z] <= high_face[t, z]) & (low_face[t, z] <= high_edge[e, z])
    keep &= ~np.any(edges[e][:, :, None] == triangles[t][:, None, :], axis=(1, 2))
    e, t = e[keep], t[keep]
    for part in np.array_split(np.arange(len(e)), len(e) // (CHUNK // 10) + 1):
        point = _passage(vertices, edges[e[part]], triangles[t[part]], size)
        if point is not None:
            return point
    return None


def _crossing_of_outline(corners: Array) -> tuple[float, float]:
    """Return a point where the outline (n, 2) of a polygon that is not valid meets itself."""
    edges = shapely.linestrings(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1))
    i, j = shapely.STRtree(edges).query(edges, predicate="intersects")
    shared = shapely.intersection(edges[i], edges[j])
    neighbours = np.isin((j - i) % len(corners), (1, len(corners) - 1))
    # Neighbours share a corner, and cross only along a length.
    meet = (i < j) & (~neighbours | (shapely.length(shared) > 0))
    point = shapely.centroid(shared[np.argmax(meet)])
    return float(point.x), float(point.y)


def _passage(vertices: Array, edges: Index, triangles: Index, size: float) -> Array | None:
    """Return a point where one of the edges (m, 2) passes through its triangle (m, 3), or None."""
    start, end = vertices[edges[:, 0]], vertices[edges[:, 1]]
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    normal = normal / np.where(length > 0, length, 1.0)[:, None]
    below, above = np.einsum("ij,ij->i", start - a, normal), np.einsum("ij,ij->i", end - a, normal)
    # Contact within the planarity of faces is not a crossing.
    margin = NEGLIGIBLE * size
    through = (np.minimum(below, above) < -margin) & (np.maximum(below, above) > margin) & (length > 0)
    share = np.where(through, below / np.where(through, below - above, 1.0), 0.0)
    point = start + share[:, None] * (end - start)
    for p, q in ((a, b), (b, c), (c, a)):
        along = (q - p) / np.maximum(np.linalg.norm(q - p, axis=1), margin)[:, None]
        through &= np.einsum("ij,ij->i", np.cross(along, point - p), normal) > -margin
    hits = np.flatnonzero(through)
    return np.asarray(point[hits[0]]) if len(hits) else None
