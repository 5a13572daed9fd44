"""Bodies, interfaces and ties of a model as flat arrays, the view on them, and their loads, for all views."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

import blockstruct as bs
from blockstruct.arrays import Array, Index
from blockstruct.geometry.triangles import triangulated
from blockstruct.text.mechanism import SMALL


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
        """Return the share at which the corner that moves farthest moves by one."""
        farthest = float(np.linalg.norm(displacement, axis=1).max())
        return 1 / farthest if farthest > 0 else 1.0


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
        segments, index = bs.ties.tie_segments(model.ties, model.blocks), model.block_index
        return cls(
            names=[s.name for s in segments],
            blocks=np.array([[index[b] for b in s.blocks] for s in segments], dtype=np.int64).reshape(-1, 2),
            ends=np.array([(s.start, s.end) for s in segments], dtype=float).reshape(-1, 2, 3),
        )

    def displacement(self, result: bs.CaseResult, iteration: int) -> Array:
        """Return the displacement (M, 2, 3) of the ends: see :meth:`Solids.displacement`."""
        return _displacement(result, iteration, self.blocks, self.ends)


def _displacement(result: bs.CaseResult, iteration: int, blocks: Index, points: Array) -> Array:
    """Return the displacement (…, 3) of points (…, 3) of blocks (…,) in the mechanism of an iteration."""
    moves = bs.results.mechanism(result.history.isel(iteration=[iteration]))
    return bs.results.velocities(result.model, bs.results.twists(moves), blocks, points)


def triangles(vertices: Array, loops: Sequence[Index]) -> tuple[Index, Index]:
    """Return the triangles (T, 3) of plane polygons, convex or not, and the polygon (T,) of each.

    Parameters
    ----------
    vertices : (V, 3) array
    loops
        Vertices of each polygon, in turn about its normal.
    """
    parts = [triangulated(vertices, loop.tolist()) for loop in loops]
    return np.concatenate(parts), np.repeat(np.arange(len(loops)), [len(p) for p in parts])


#: Right, up, and toward the reader.
_PLANE = {
    "x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
}
_LABELS = {"x": ("y [m]", "z [m]"), "y": ("x [m]", "z [m]"), "z": ("x [m]", "y [m]")}
#: Thickness, relative to its extent, below which a structure is drawn in elevation, unless something moves across it by
#: more than the second share.
_THIN, _ACROSS = 0.25, 0.1
#: Angles of a view in space, degrees: downwards, and from the push to the side, so that motion comes nearer and
#: sideways.
_ELEVATION, _BESIDE = 24.0, 55.0


@dataclass(frozen=True, slots=True)
class View:
    """Orthographic projection.

    Attributes
    ----------
    basis : (3, 3) array
        Unit vectors to the right, up and toward the reader.
    labels
        Labels of the two axes; none in space.
    """

    basis: Array
    labels: tuple[str, str] | None

    @classmethod
    def of(cls, shown: bs.Model | bs.CaseResult, look: Any = None) -> "View":
        """Return the view for a look; without one, the view that suits the structure.

        Raises
        ------
        ModelError
            If the look is not one of :func:`blockstruct.views.figures.structure`.
        """
        if look is None:
            look = best_look(shown)
        if isinstance(look, str) and look in _PLANE:
            return cls(np.array(_PLANE[look], dtype=float), _LABELS[look])
        if isinstance(look, str) and look == "3d":
            return cls(_basis(_azimuth(shown), _ELEVATION), None)
        try:
            azimuth, elevation = (float(angle) for angle in look)
        except (TypeError, ValueError):
            msg = (
                f"figure: look {look!r}; give 'x' or 'y' for an elevation, 'z' for a plan, '3d' for space, "
                "or azimuth and elevation in degrees as (-60, 25)"
            )
            raise bs.errors.ModelError(msg) from None
        return cls(_basis(azimuth, elevation), None)

    @property
    def flat(self) -> bool:
        """Whether the view is an elevation or a plan."""
        return self.labels is not None

    def project(self, points: Array) -> Array:
        """Return right and up coordinates (…, 2) of points or vectors (…, 3)."""
        return np.asarray(points @ self.basis[:2].T)


def best_look(shown: bs.Model | bs.CaseResult) -> str:
    """Return an elevation for a thin structure without motion or push across it; otherwise space."""
    model = shown if isinstance(shown, bs.Model) else shown.model
    extent = np.ptp(Solids.of(model).vertices, axis=0)
    thin = int(np.argmin(extent[:2]))
    if extent[thin] > _THIN * extent.max():
        return "3d"
    if isinstance(shown, bs.CaseResult):
        across = [abs(push(shown)[thin])]
        if shown.n_iterations:
            motion = np.abs(np.nan_to_num(shown.mechanism["translation"].transpose("block", "axis"))).max(axis=0)
            across.append(motion[thin] / max(motion.max(), np.finfo(float).tiny))
        if max(across) > _ACROSS:
            return "3d"
    return "xy"[thin]


def eye(shown: bs.Model | bs.CaseResult) -> Array:
    """Return the unit vector (3,) toward the reader in space."""
    look = best_look(shown)
    azimuth = _azimuth(shown) if look == "3d" else {"x": 15.0, "y": -75.0}[look]
    return np.asarray(_basis(azimuth, _ELEVATION if look == "3d" else 12.0)[2])


def _azimuth(shown: bs.Model | bs.CaseResult) -> float:
    """Return a direction of view oblique to a horizontal push, that shows most of the structure."""
    direction = push(shown)[:2] if isinstance(shown, bs.CaseResult) else np.zeros(2)
    if np.linalg.norm(direction) < 0.1:
        return -_BESIDE
    towards = float(np.degrees(np.arctan2(direction[1], direction[0])))
    model = shown.model if isinstance(shown, bs.CaseResult) else shown
    vertices = Solids.of(model).vertices

    def seen(azimuth: float) -> tuple[float, float]:
        width = float(np.ptp(vertices @ _basis(azimuth, 0)[0]))
        # From −y if both sides are alike, as in elevations.
        return round(width, 6), -float(np.sin(np.radians(azimuth)))

    return max((towards - _BESIDE, towards + _BESIDE), key=seen)


def _basis(azimuth: float, elevation: float) -> Array:
    a, e = np.radians([azimuth, elevation])
    toward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return np.array([right, np.cross(toward, right), toward])


def round_value(value: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that does not exceed a value.

    >>> round_value(314.0), round_value(0.07)
    (200.0, 0.05)
    """
    power = 10.0 ** np.floor(np.log10(value))
    steps: Sequence[int] = (5, 2, 1)
    return float(next((s * power for s in steps if s * power <= value * (1 + 1e-9)), power))


@dataclass(frozen=True, slots=True)
class LoadArrows:
    """Forces of a load pattern that are drawn, without the weight of the blocks.

    Attributes
    ----------
    name : str
        Name of the pattern.
    grows : bool
        Whether the load factor multiplies it.
    block : (n,) array
        Index of the block of each force.
    point, force : (n, 3) arrays
        m and N, at a load factor of 1.
    largest, total : float
        Largest force, and resultant of all forces including the ones too small to draw, N.
    """

    name: str
    grows: bool
    block: Index
    point: Array
    force: Array
    largest: float
    total: float


def load_arrows(result: bs.CaseResult) -> list[LoadArrows]:
    """Return the forces of the dead and the variable load of a case, without patterns that have none.

    Forces below 2 % of the largest of their pattern are left out, and couples, too.
    """
    arrows_of = []
    for k, pattern in enumerate(result.case.patterns):
        carried = [load for load in pattern.loads if not isinstance(load, bs.SelfWeight)]
        block, point, force = _acting(bs.LoadPattern(pattern.name, carried), result.model, result.case.dead)
        size = np.linalg.norm(force, axis=1)
        if len(size):
            shown = size > SMALL * size.max()
            total = float(np.linalg.norm(force.sum(axis=0)))
            arrows = (block[shown], point[shown], force[shown], float(size.max()), total)
            arrows_of.append(LoadArrows(pattern.name, k > 0, *arrows))
    return arrows_of


def _acting(pattern: bs.LoadPattern, model: bs.Model, dead: bs.LoadPattern) -> tuple[Index, Array, Array]:
    """Return blocks (n,), points (n, 3) in m and forces (n, 3) in N of a load pattern on free blocks, without couples.

    A mass-proportional force also moves the weights of the dead load.
    """
    loads = bs.results.applied_loads(model, pattern, dead)
    free = np.array([not b.fixed for b in model.blocks])
    acts = free[loads.block] & loads.force.any(axis=1)
    return loads.block[acts], loads.point[acts], loads.force[acts]


def driving(result: bs.CaseResult) -> tuple[Array, Array]:
    """Return points (n, 3) in m and vectors (n, 3) of the variable load in N, or of moving supports.

    The vectors of supports are their motions. A support that turns has none: its reaction is a couple.
    """
    case = result.case
    if not isinstance(case, bs.SettlementCase):
        return _acting(case.patterns[-1], result.model, case.dead)[1:]
    points = np.array([result.model.block(name).centroid for name in case.supports])
    motion = np.array(case.direction if case.about is None else (0.0, 0.0, 0.0))
    return points, np.broadcast_to(motion, points.shape)


def push(result: bs.CaseResult) -> Array:
    """Return the unit vector (3,) of the resultant of :func:`driving`; zero if its vectors cancel."""
    _, forces = driving(result)
    total = forces.sum(axis=0)
    size = float(np.linalg.norm(total))
    return total / size if size > 1e-9 * np.linalg.norm(forces, axis=1).sum() else np.zeros(3)
