"""Bodies, interfaces and ties of a model as flat arrays, for all views."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.geometry.triangles import triangulated

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Displacement of a corner, relative to the largest translation, from which a mechanism is drawn smaller.
LEVER = 3.0


@dataclass(frozen=True)
class Solids:
    """Faces of all blocks.

    Attributes
    ----------
    vertices : (V, 3) array
        m; no two blocks share a vertex.
    block_of_vertex : (V,) array
    centroids : (B, 3) array
        m.
    loops
        Vertices of each face, counter-clockwise from outside.
    block_of_face : (F,) array
    normals : (F, 3) array
        Outward unit normals.
    """

    vertices: Array
    block_of_vertex: Index
    centroids: Array
    loops: tuple[Index, ...]
    block_of_face: Index
    normals: Array

    @classmethod
    def of(cls, model: bs.Model) -> "Solids":
        """Return the faces of the blocks of a model, in its order."""
        shapes = [b.shape for b in model.blocks]
        counts = [len(s.vertices) for s in shapes]
        starts = np.cumsum([0, *counts[:-1]])
        loops = [np.asarray(loop) + start for s, start in zip(shapes, starts, strict=True) for loop in s.faces]
        return cls(
            vertices=np.concatenate([s.vertices for s in shapes]),
            block_of_vertex=np.repeat(np.arange(len(shapes)), counts),
            centroids=np.array([s.centroid for s in shapes]),
            loops=tuple(loops),
            block_of_face=np.repeat(np.arange(len(shapes)), [len(s.faces) for s in shapes]),
            normals=np.concatenate([s.normals for s in shapes]),
        )

    @cached_property
    def size(self) -> float:
        """Largest extent along an axis, m."""
        return float(np.ptp(self.vertices, axis=0).max())

    @cached_property
    def edges(self) -> Index:
        """Vertices (E, 2) of the edges, each once."""
        pairs = np.concatenate([np.stack([loop, np.roll(loop, -1)], axis=1) for loop in self.loops])
        return np.unique(np.sort(pairs, axis=1), axis=0)

    def displacement(self, result: bs.CaseResult, iteration: int) -> Array:
        """Return the displacement (V, 3) of the vertices in the mechanism of an iteration, to first order.

        The largest translation of a centroid is 1 m: multiply by the amplitude in m. To first order, closed joints stay
        closed in the picture at any amplitude.
        """
        return _displacement(result, iteration, self.block_of_vertex, self.vertices)

    def drawn_share(self, displacement: Array) -> float:
        """Return the share of the amplitude: 1, or less if corners move far.

        Otherwise the ends of a beam that turns about a support below its centroid would fill the picture.
        """
        farthest = float(np.linalg.norm(displacement, axis=1).max())
        return min(1.0, LEVER / farthest) if farthest > 0 else 1.0


@dataclass(frozen=True, slots=True)
class Patches:
    """Polygons of all interfaces.

    Attributes
    ----------
    vertices : (V, 3) array
        m; no two interfaces share a vertex.
    of_vertex : (V,) array
        Interface of each vertex.
    corners : (T, 3) array
        Vertices of the triangles of the polygons.
    of_triangle : (T,) array
        Interface of each triangle.
    """

    vertices: Array
    of_vertex: Index
    corners: Index
    of_triangle: Index

    @classmethod
    def of(cls, model: bs.Model) -> "Patches":
        """Return the polygons of the interfaces of a model, in its order."""
        polygons = [np.asarray(i.polygon) for i in model.interfaces]
        ends = np.cumsum([0, *(len(p) for p in polygons)])
        vertices = np.concatenate(polygons)
        corners, of_triangle = triangles(vertices, [np.arange(a, b) for a, b in pairwise(ends)])
        return cls(vertices, np.repeat(np.arange(len(polygons)), np.diff(ends)), corners, of_triangle)


@dataclass(frozen=True, slots=True)
class TieLines:
    """Stretches of the ties of a model as lines.

    Attributes
    ----------
    names : list of str
    blocks : (M, 2) array
        Block of each end.
    ends : (M, 2, 3) array
        m.
    """

    names: list[str]
    blocks: Index
    ends: Array

    @classmethod
    def of(cls, model: bs.Model) -> "TieLines":
        """Return the lines of a model, in the order of the ties in its histories."""
        segments = bs.ties.tie_segments(model.ties, model.blocks)
        number = {b.name: i for i, b in enumerate(model.blocks)}
        return cls(
            names=[s.name for s in segments],
            blocks=np.array([[number[b] for b in s.blocks] for s in segments], dtype=np.int64).reshape(-1, 2),
            ends=np.array([(s.start, s.end) for s in segments], dtype=float).reshape(-1, 2, 3),
        )

    def displacement(self, result: bs.CaseResult, iteration: int) -> Array:
        """Return the displacement (M, 2, 3) of the ends: see :meth:`Solids.displacement`."""
        return _displacement(result, iteration, self.blocks, self.ends)


def _displacement(result: bs.CaseResult, iteration: int, blocks: Index, points: Array) -> Array:
    """Return the displacement (…, 3) of points (…, 3) of blocks (…,) in the mechanism of an iteration."""
    moves = bs.results.mechanism(result.history.isel(iteration=[iteration]))
    shift, turn = (moves[name].transpose("block", "axis").to_numpy() for name in ("translation", "rotation"))
    arms = points - np.array([block.centroid for block in result.model.blocks])[blocks]
    return np.asarray(shift[blocks] + np.cross(turn[blocks], arms))


def triangles(vertices: Array, loops: Sequence[Index]) -> tuple[Index, Index]:
    """Return the triangles (T, 3) of plane polygons, convex or not, and the polygon (T,) of each.

    Parameters
    ----------
    vertices : (V, 3) array
    loops
        Vertices of each polygon, in turn about its normal.
    """
    parts = [_parts(vertices[loop]) for loop in loops]
    corners = np.concatenate([loop[part] for loop, part in zip(loops, parts, strict=True)])
    return corners, np.repeat(np.arange(len(loops)), [len(p) for p in parts])


def _parts(polygon: Array) -> Index:
    """Return the triangles of one polygon: a fan if it is convex."""
    following = np.roll(polygon, -1, axis=0)
    normal = np.cross(polygon - polygon[0], following - polygon[0]).sum(axis=0)
    corner = np.cross(polygon - np.roll(polygon, 1, axis=0), following - polygon) @ normal
    if np.all(corner >= 0):
        return np.array([(0, i, i + 1) for i in range(1, len(polygon) - 1)])
    return np.array(triangulated(polygon, range(len(polygon))))
