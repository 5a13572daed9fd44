"""Where bodies that have moved touch, or are about to: contact points with normals and gaps."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.geometry.clipping import Clipped, clipped
from blockstruct.geometry.neighbours import box_pairs, expanded
from blockstruct.geometry.polygon import plane_axes
from blockstruct.geometry.polyhedron import Polyhedron
from blockstruct.geometry.tolerances import DEEP, FACING, FLAT, NO_CROSSING, NO_EDGE, NO_WIDTH
from blockstruct.geometry.triangles import triangulated

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Touching:
    """Contact points of pairs of bodies.

    Attributes
    ----------
    minus, plus : (K,) arrays
        The two bodies.
    position : (K, 3) array
    normal : (K, 3) array
        From minus to plus.
    gap : (K,) array
        Distance along the normal; negative for a penetration.
    """

    minus: Index
    plus: Index
    position: Array
    normal: Array
    gap: Array


@dataclass(frozen=True, slots=True)
class MovingBodies:
    """Faces of rigid bodies, in convex parts, relative to the centroids of the bodies.

    Attributes
    ----------
    vertex : (v, 3) array
        Vertices of all bodies, one body after the other.
    of_vertex : (v,) array
    loop : (f, M) array
        Vertices of each part of a face, the last one repeated; counter-clockwise seen from outside.
    count : (f,) array
        Number of vertices of each.
    normal : (f, 3) array
    of_part : (f,) array
        Body of each part, ascending.
    flat : (f, M) array
        Whether the surface goes on without a bend beyond each edge.
    fixed : (B,) array
        Bodies that do not move; those touch each other nowhere.
    """

    vertex: Array
    of_vertex: Index
    loop: Index
    count: Index
    normal: Array
    of_part: Index
    flat: Flags
    fixed: Flags

    @classmethod
    def of(cls, bodies: Sequence[Polyhedron], fixed: Flags) -> Self:
        """Faces of polyhedra; a face that is not convex is cut into triangles."""
        start = np.cumsum([0, *(len(b.vertices) for b in bodies)])
        loops: list[list[int]] = []
        normals, owner, flat = [], [], []
        for i, body in enumerate(bodies):
            parts = [(f, part) for f, face in enumerate(body.faces) for part in _convex_parts(body, f, face)]
            beyond = {(a, b): f for f, part in parts for a, b in zip(part, (*part[1:], part[0]), strict=True)}
            for f, part in parts:
                loops.append([int(v + start[i]) for v in part])
                normals.append(body.normals[f])
                owner.append(i)
                neighbours = [beyond[b, a] for a, b in zip(part, (*part[1:], part[0]), strict=True)]
                flat.append([bool(body.normals[f] @ body.normals[g] > FLAT) for g in neighbours])
        most = max(map(len, loops))
        return cls(
            vertex=np.concatenate([b.vertices - b.centroid for b in bodies]),
            of_vertex=np.repeat(np.arange(len(bodies)), np.diff(start)),
            loop=np.array([loop + loop[-1:] * (most - len(loop)) for loop in loops]),
            count=np.array([len(loop) for loop in loops]),
            normal=np.array(normals),
            of_part=np.array(owner),
            flat=np.array([row + [False] * (most - len(row)) for row in flat]),
            fixed=fixed,
        )

    def touching(self, position: Array, rotation: Array, reach: float, size: float) -> Touching:
        """Contact points of the bodies at their places.

        Every two parts of faces that look at each other are laid over each other along the mean of their normals;
        the corners of what they share are contact points. A vertex of one that lies on the other has the normal of
        the other; where two edges cross it is square to both. So a body that rocks on its edge stands on the face
        below it, and one that overhangs rests with its own face on the edge below.

        What faces of convex bodies share lies outside both bodies, or it belongs to their far sides: then it is
        further through them than it is wide, and does not count. Vertices that meet vertices or edges sideways,
        without sharing an area, do not count either; they do once one has passed the other, by its penetration.

        Parameters
        ----------
        position : (B, 3) array
            Of the centroids.
        rotation : (B, 3, 3) array
        reach
            Largest gap.
        size
            Mean size of a block, to which tolerances are relative.
        """
        vertex = np.einsum("vij,vj->vi", rotation[self.of_vertex], self.vertex) + position[self.of_vertex]
        normal = np.einsum("fij,fj->fi", rotation[self.of_part], self.normal)
        corner = vertex[self.loop]
        first, second = self._facing(vertex, corner, normal, reach)
        middle = normal[second] - normal[first]
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        axes = np.stack(plane_axes(middle), axis=1)
        origin = corner[second, 0]
        # Seen along the mean normal, the first turns the other way.
        count, number = self.count[first], np.arange(self.loop.shape[1])
        back = np.where(number < count[:, None], count[:, None] - 1 - number, 0)
        one = np.take_along_axis(corner[first], back[:, :, None], 1)
        other = corner[second]
        flat = np.einsum("pvi,pai->pva", one - origin[:, None], axes)
        shared = clipped(flat, count, np.einsum("pvi,pai->pva", other - origin[:, None], axes), self.count[second])

        lengths = np.linalg.norm(shared.edges, axis=2).sum(axis=1)
        width = 2 * shared.area / np.maximum(lengths, 1e-300)
        wide = width > NO_WIDTH * size
        shared, width = shared[wide].without_short_edges(NO_EDGE * size), width[wide]
        first, second, middle, axes, origin, one, other, back = (
            a[wide] for a in (first, second, middle, axes, origin, one, other, back)
        )
        place = origin[:, None] + np.einsum("pva,pai->pvi", shared.corner, axes)
        heights = [
            np.einsum("pvi,pi->pv", points[:, :1] - place, normal[part] / _dots(normal[part], middle)[:, None])
            for points, part in ((one, first), (other, second))
        ]
        apart = heights[0] - heights[1]
        deepest = -np.where(shared.within, apart, np.inf).min(axis=1)
        towards, level = self._normals(shared, (first, second), (one, other), back, normal, middle)
        gap = apart * np.einsum("pvi,pi->pv", towards, middle)
        keep = shared.within & (deepest <= DEEP * width)[:, None] & (gap <= reach)
        # A vertex acts where it is, a crossing of edges half-way between them.
        height = level * heights[0] + (1 - level) * heights[1]
        pair, k = np.nonzero(keep)
        return Touching(
            minus=self.of_part[second][pair],
            plus=self.of_part[first][pair],
            position=(place + height[:, :, None] * middle[:, None])[pair, k],
            normal=towards[pair, k],
            gap=gap[pair, k],
        )

    def _facing(self, vertex: Array, corner: Array, normal: Array, reach: float) -> tuple[Index, Index]:
        """Pairs of parts of different bodies that look at each other and come close."""
        starts = np.searchsorted(self.of_vertex, np.arange(len(self.fixed)))
        low, high = np.minimum.reduceat(vertex, starts), np.maximum.reduceat(vertex, starts)
        i, j = box_pairs(low - reach / 2, high + reach / 2)
        free = ~(self.fixed[i] & self.fixed[j])
        i, j = i[free], j[free]
        begin = np.searchsorted(self.of_part, np.arange(len(self.fixed) + 1))
        count = np.diff(begin)
        pair, first, _ = expanded(begin[i], count[i])
        row, second, _ = expanded(begin[j[pair]], count[j[pair]])
        first = first[row]
        facing = _dots(normal[first], normal[second]) < -np.cos(FACING)
        first, second = first[facing], second[facing]
        low, high = corner.min(axis=1) - reach / 2, corner.max(axis=1) + reach / 2
        close = np.all((low[first] <= high[second]) & (low[second] <= high[first]), axis=1)
        return first[close], second[close]

    def _normals(
        self,
        shared: Clipped,
        parts: tuple[Index, Index],
        points: tuple[Array, Array],
        back: Index,
        normal: Array,
        middle: Array,
    ) -> tuple[Array, Array]:
        """Normals (P, N, 3) at the corners of what parts share, and the share of the first in their place (P, N)."""
        M = self.loop.shape[1]
        ends = np.stack([shared.arriving, shared.edge])
        of_first = ends < M
        # Of a corner where edges of both cross, the one of each.
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
            # Reversed, edge i is the one that leaves the next vertex of the loop.
            own = np.take_along_axis(back, after, 1) if k == 0 else edge
            flat.append(np.take_along_axis(self.flat[part], own, 1))
        square = np.cross(*along)
        size = np.linalg.norm(square, axis=2)
        upward = np.einsum("pvi,pi->pv", square, middle)
        square *= (np.sign(upward) / np.maximum(size, 1e-300))[:, :, None]
        # Edges nearly along each other.
        vague = (size < NO_CROSSING) | (np.abs(upward) < size / 2)
        own, other = of_first.all(axis=0), ~of_first.any(axis=0)
        # The edge of one lies in the face of the other, or in its own where that goes on.
        on_second = own | (~other & flat[1])
        on_first = (other | flat[0]) & ~on_second
        chosen = np.where(vague[:, :, None], middle[:, None], square)
        chosen = np.where(on_second[:, :, None], normal[parts[1]][:, None], chosen)
        chosen = np.where(on_first[:, :, None], -normal[parts[0]][:, None], chosen)
        return chosen, np.where(own, 1.0, np.where(other, 0.0, 0.5))


def _dots(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("pi,pi->p", a, b))


def _convex_parts(body: Polyhedron, face: int, loop: tuple[int, ...]) -> list[tuple[int, ...]]:
    points = body.vertices[list(loop)]
    edges = np.roll(points, -1, axis=0) - points
    turns = np.cross(edges, np.roll(edges, -1, axis=0)) @ body.normals[face]
    return [loop] if turns.min() >= 0 else triangulated(body.vertices, loop)
