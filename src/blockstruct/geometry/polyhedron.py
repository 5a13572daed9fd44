"""Closed polyhedra with planar polygon faces, convex or not."""

import operator
import reprlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array, Index
from blockstruct.errors import GeometryError
from blockstruct.geometry.polygon import Corners, Planes, cross, polygon_area
from blockstruct.geometry.tolerances import LARGEST_DEVIATION, NO_AREA

#: Vertices of each face.
Loops = tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True)
class Polyhedron:
    """A closed polyhedron.

    Attributes
    ----------
    vertices : (n, 3) array
    faces
        Vertex indices of each face, counter-clockwise seen from outside.
    volume, centroid
        Exact for planar faces (divergence theorem). Other faces count as triangles about their first vertex.
    normals : (f, 3) array
        Outward unit normals of the mean planes.
    areas : (f,) array
    deviations : (f,) array
        Largest distance of a vertex of each face from the mean plane.
    """

    vertices: Array
    faces: tuple[tuple[int, ...], ...]
    volume: float
    centroid: Array
    normals: Array
    areas: Array
    deviations: Array

    @property
    def nonplanar_faces(self) -> list[int]:
        """Faces that deviate from a plane by more than rounding."""
        size = float(np.ptp(self.vertices, axis=0).max())
        return [int(f) for f in np.flatnonzero(self.deviations > NEGLIGIBLE * size)]

    @property
    def second_moments(self) -> Array:
        """Integral of ``r rᵀ`` over the volume, (3, 3), r from the centroid: over cones from there to the faces."""
        moments = np.zeros((3, 3))
        for face in self.faces:
            for second, third in pairwise(face[1:]):
                corners = self.vertices[[face[0], second, third]] - self.centroid
                total = corners.sum(axis=0)
                moments += np.linalg.det(corners) / 120 * (np.outer(total, total) + corners.T @ corners)
        return moments

    def face_centroid(self, face: int) -> Array:
        """Return the centroid (3,) of a face."""
        return polygon_area(self.vertices[list(self.faces[face])])[1]


#: Outward faces of a hexahedron with eight corners, four below and four above, each in order.
BOX_FACES: tuple[tuple[int, ...], ...] = (
    (0, 3, 2, 1),
    (4, 5, 6, 7),
    (0, 1, 5, 4),
    (1, 2, 6, 5),
    (2, 3, 7, 6),
    (3, 0, 4, 7),
)


def box(origin: Sequence[float], size: Sequence[float]) -> tuple[Array, tuple[tuple[int, ...], ...]]:
    """Return vertices (8, 3) and outward faces of an axis-parallel box with its smallest corner at ``origin``."""
    corners = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float
    )
    return np.asarray(origin, dtype=float) + corners * np.asarray(size, dtype=float), BOX_FACES


def lofted(first: Array, second: Array) -> tuple[Array, tuple[tuple[int, ...], ...]]:
    """Return vertices (2n, 3) and outward faces of the body between two outlines (n, 3) with matching corners.

    The faces are the two outlines and then the sides, for either order of rotation of the outlines.
    """
    n = len(first)
    low, high = range(n), range(n, 2 * n)
    sides = [(k, (k + 1) % n, n + (k + 1) % n, n + k) for k in range(n)]
    if polygon_area(first)[2] @ (second - first).mean(axis=0) > 0:
        faces = [tuple(low[::-1]), tuple(high), *sides]
    else:
        faces = [tuple(low), tuple(high[::-1]), *(side[::-1] for side in sides)]
    return np.concatenate([first, second]), tuple(faces)


def polyhedron(vertices: Array, faces: Sequence[Sequence[int]], name: str) -> Polyhedron:
    """Check a shape and integrate its volume and centroid.

    Parameters
    ----------
    vertices : (n, 3) array
    faces
        Vertex indices of each face, counter-clockwise seen from outside. Slight deviations from a plane are allowed.
    name
        Name of the block in error messages.

    Raises
    ------
    GeometryError
        If a face names an unknown vertex, is degenerate or far from planar, or the surface is open, inside out or has
        no volume.
    """
    vertices = np.array(vertices, dtype=float)
    if vertices.ndim != 2 or vertices.shape[1:] != (3,) or len(vertices) < 4:
        msg = f"block {name!r}: vertices of shape {vertices.shape}; give at least four points, shape (n, 3)"
        raise GeometryError(msg)
    if not np.isfinite(vertices).all():
        msg = f"block {name!r}: vertex {int(np.argmin(np.isfinite(vertices).all(axis=1)))} is not finite; correct it"
        raise GeometryError(msg)
    try:
        loops = tuple(tuple(operator.index(i) for i in face) for face in faces)
    except TypeError:
        msg = f"block {name!r}: faces {reprlib.repr(faces)}; give a list of faces, each a list of whole vertex numbers"
        raise GeometryError(msg) from None
    if fault := _fault_of_faces(loops, len(vertices)):
        msg = f"block {name!r}: {fault}"
        raise GeometryError(msg)

    corners, fan = _corners_and_fan(loops)
    origin = vertices.mean(axis=0)
    a, b, c = (vertices - origin)[fan]
    planes = Planes.of(vertices, loops, corners)
    size = float(np.ptp(vertices, axis=0).max())
    if np.any(planes.area <= NO_AREA * size**2):
        face = int(np.argmin(planes.area))
        msg = f"block {name!r}: face {face} {loops[face]} has no area; remove it or correct its vertices"
        raise GeometryError(msg)
    if planes.deviation.max() > LARGEST_DEVIATION * size:
        face = int(np.argmax(planes.deviation))
        msg = (
            f"block {name!r}: face {face} is not planar, a vertex is {planes.deviation[face]:.3g} m off "
            f"its plane (limit {LARGEST_DEVIATION * size:.3g} m); split the face into triangles or correct the vertex"
        )
        raise GeometryError(msg)
    if fault := _fault_of_edges(loops):
        msg = f"block {name!r}: {fault}"
        raise GeometryError(msg)

    tetrahedra = np.einsum("ij,ij->i", a, cross(b, c)) / 6
    volume = float(tetrahedra.sum())
    if abs(volume) <= ROUNDING * size**3:
        msg = f"block {name!r}: the volume is zero; give a body with thickness in all three directions"
        raise GeometryError(msg)
    if volume < 0:
        msg = (
            f"block {name!r}: inside out, its signed volume is {volume:.6g} m^3; list the vertices of each face "
            "counter-clockwise seen from outside (reverse every face)"
        )
        raise GeometryError(msg)
    centroid = origin + (tetrahedra @ (a + b + c)) / (4 * volume)
    arrays = vertices, centroid, planes.normal, planes.area, planes.deviation
    for array in arrays:
        array.setflags(write=False)
    return Polyhedron(vertices, loops, volume, *arrays[1:])


# The blocks of a structure share their lists of faces, which are looked at once.


@lru_cache
def _corners_and_fan(loops: Loops) -> tuple[Corners, Index]:
    """Return the corners of faces, and the vertices (3, t) of triangles from the first vertex of each face.

    The triangles are exact for any planar polygon, convex or not, because the signed parts outside the polygon cancel.
    """
    return Corners.of(loops), np.array([(f[0], a, b) for f in loops for a, b in pairwise(f[1:])]).T


@lru_cache
def _fault_of_faces(loops: Loops, n_vertices: int) -> str:
    """Return why faces cannot make a body of n vertices; empty if they can."""
    if len(loops) < 4:
        return f"{len(loops)} faces; a closed body has at least four"
    for index, loop in enumerate(loops):
        if len(set(loop)) < max(3, len(loop)):
            return f"face {index} {loop} needs at least three different vertices"
        if min(loop) < 0 or max(loop) >= n_vertices:
            return f"face {index} {loop} names a vertex outside 0..{n_vertices - 1}"
    unused = sorted(set(range(n_vertices)).difference(*loops))
    return f"no face uses the vertices {unused[:10]}; remove them, or add the missing faces" if unused else ""


@lru_cache
def _fault_of_edges(loops: Loops) -> str:
    """Return why faces do not close; empty if they do."""
    edges = Counter((a, b) for loop in loops for a, b in pairwise((*loop, loop[0])))
    if max(edges.values()) > 1:
        edge = max(edges, key=lambda e: edges[e])
        return (
            f"edge {edge} runs the same way in {edges[edge]} faces; list every face counter-clockwise seen from outside"
        )
    loose = next((edge for edge in edges if edge[::-1] not in edges), None)
    return "" if loose is None else f"the surface is open at edge {loose}; add the missing face"
