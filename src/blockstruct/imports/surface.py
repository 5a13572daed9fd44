"""Make a closed surface of planar outward polygons from the loose faces of one body."""

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.errors import GeometryError
from blockstruct.geometry import triangulated
from blockstruct.geometry.planes import Planes
from blockstruct.geometry.polygon import plane_axes
from blockstruct.geometry.tolerances import CHUNK, NEGLIGIBLE
from blockstruct.imports.flatten import flattened
from blockstruct.imports.merge import merged_faces
from blockstruct.imports.soup import compact
from blockstruct.imports.tolerances import EXACT, MERGE, MOST_FACES_OF_BODY, POLYGON
from blockstruct.vocabulary import counted

Array = NDArray[np.float64]
Face = tuple[int, ...]


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
    whole, repairs["no area"] = merged_faces(vertices, outward, tolerance or MERGE * size, size)
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
    axes = np.stack(plane_axes(planes.normal), axis=1)[planes.face]
    flat = np.einsum("kaj,kj->ka", axes, vertices[planes.corner] - planes.centre[planes.face])
    simple = shapely.is_valid(shapely.polygons(shapely.linearrings(flat, indices=planes.face)))
    if not simple.all():
        wrong = int(np.argmin(simple))
        u, v = _crossing_of_outline(flat[planes.face == wrong])
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


def _passage(vertices: Array, edges: NDArray[np.int64], triangles: NDArray[np.int64], size: float) -> Array | None:
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
