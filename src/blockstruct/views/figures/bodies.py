"""Bodies with lines on them as one collection, drawn from back to front."""

from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgba_array
from matplotlib.path import Path

import blockstruct as bs
from blockstruct.geometry.polygon import next_corners
from blockstruct.views.solids import Solids

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]

#: Light in the axes of the view (right, up, toward the reader), and the share of brightness without it.
_LIGHT, _AMBIENT = np.array([-0.3, 0.5, 0.81]), 0.62
#: Cosine below which planes count as perpendicular to the view; distance from a face, relative to its size, that counts
#: as on it.
_ASIDE, _ON = 1e-6, 1e-2


@dataclass(frozen=True, slots=True)
class Lines:
    """Lines on the surface of bodies.

    Attributes
    ----------
    ends : (L, 2, 3) array
        m.
    interface : (L,) array
        Joint that each line bounds.
    colours, dashes
        Of each line; a dash is ``"-"`` or an offset with lengths on and off.
    width : float
        Points.
    """

    ends: Array
    interface: Index
    colours: Array
    width: float
    dashes: list[Any]


def bodies(
    model: bs.Model,
    solids: Solids,
    vertices: Array,
    basis: Array,
    fill: npt.ArrayLike,
    edge: tuple[str, float],
    lines: Lines | None = None,
    **style: Any,
) -> PathCollection:
    """Return the faces of all blocks that face the reader, and the lines on them.

    Blocks are drawn in turn. Of two in contact, the one on the reader's side of their joint is in front; of others,
    the nearer one.

    Parameters
    ----------
    model, solids
        The blocks and their faces.
    vertices : (V, 3) array
        Positions of their vertices, m.
    basis : (3, 3) array
        Unit vectors to the right, up and toward the reader.
    fill
        Colour of each block.
    edge
        Colour and width of the edges of faces.
    lines
        Lines on the faces, of blocks that are not displaced.
    """
    seen = vertices @ basis.T
    corners = [seen[loop] for loop in solids.loops]
    counts = np.array([len(c) for c in corners])
    starts = np.cumsum([0, *counts[:-1]])
    points = np.concatenate(corners)
    following = next_corners(starts, counts)
    away = points - np.repeat(points[starts], counts, axis=0)
    normals = np.add.reduceat(np.cross(away, away[following]), starts)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
    front = normals[:, 2] > _ASIDE

    light = _AMBIENT + (1 - _AMBIENT) * np.clip(normals @ _LIGHT / _LIGHT[2], 0, 1.1)
    colour = to_rgba_array(fill)[solids.block_of_face]
    colour[:, :3] = np.clip(colour[:, :3] * light[:, None], 0, 1)

    rank = _ranks(model, solids, seen, basis)
    depth = np.add.reduceat(points[:, 2], starts) / counts
    shown = np.flatnonzero(front)
    paths = [Path(np.vstack([corners[k], corners[k][:1]])[:, :2], closed=True) for k in shown]
    # Faces of rank r come first, then the lines after all faces of that rank.
    ranks, depths = rank[solids.block_of_face[shown]].astype(float), depth[shown]
    colours, edges = colour[shown], np.repeat(to_rgba_array(edge[0]), len(shown), axis=0)
    widths, dashes = np.full(len(shown), edge[1]), ["-"] * len(shown)
    if lines is not None:
        key = _line_ranks(model, solids, lines, rank, front)
        drawn = np.flatnonzero(key >= 0)
        paths += [Path(p) for p in (lines.ends[drawn] @ basis.T)[..., :2]]
        ranks, depths = np.concatenate([ranks, key[drawn] + 0.5]), np.concatenate([depths, np.zeros(len(drawn))])
        colours = np.concatenate([colours, np.zeros((len(drawn), 4))])
        edges = np.concatenate([edges, lines.colours[drawn]])
        widths, dashes = (
            np.concatenate([widths, np.full(len(drawn), lines.width)]),
            dashes + [lines.dashes[k] for k in drawn],
        )
    order = np.lexsort((depths, ranks))
    return PathCollection(
        [paths[k] for k in order],
        facecolors=colours[order],
        edgecolors=edges[order],
        linewidths=widths[order],
        linestyles=[dashes[k] for k in order],
        capstyle="butt",
        joinstyle="round",
        **style,
    )


def _pairs(model: bs.Model) -> Index:
    """Return the minus and plus blocks (I, 2) of the interfaces."""
    number = {b.name: k for k, b in enumerate(model.blocks)}
    return np.array([(number[i.minus], number[i.plus]) for i in model.interfaces], dtype=np.int64).reshape(-1, 2)


def _normals(model: bs.Model) -> Array:
    """Return the normals (I, 3) of the interfaces, from the minus to the plus block."""
    return np.array([i.normal for i in model.interfaces], dtype=float).reshape(-1, 3)


def _ranks(model: bs.Model, solids: Solids, seen: Array, basis: Array) -> Index:
    """Return the order (B,) of drawing: after the blocks in contact further away, the farthest first."""
    starts = np.searchsorted(solids.block_of_vertex, np.arange(len(model.blocks)))
    depth = np.add.reduceat(seen[:, 2], starts) / np.bincount(solids.block_of_vertex)
    pairs, toward = _pairs(model), _normals(model) @ basis[2]
    pairs = np.where(toward[:, None] > 0, pairs, pairs[:, ::-1])[np.abs(toward) > _ASIDE]
    before = np.bincount(pairs[:, 1], minlength=len(depth))
    ahead: list[list[int]] = [[] for _ in depth]
    for behind, ahead_of_it in pairs.tolist():
        ahead[behind].append(ahead_of_it)
    waiting = [(depth[k], int(k)) for k in np.flatnonzero(before == 0)]
    heapify(waiting)
    rank, left = np.full(len(depth), -1), np.argsort(depth, kind="stable").tolist()[::-1]
    for turn in range(len(depth)):
        while waiting and rank[waiting[0][1]] >= 0:
            heappop(waiting)
        if waiting:
            _, k = heappop(waiting)
        else:
            # Interlocking blocks each lie partly in front of the next: then the farthest goes first.
            while rank[left[-1]] >= 0:
                left.pop()
            k = left.pop()
        rank[k] = turn
        for other in ahead[k]:
            before[other] -= 1
            if before[other] == 0 and rank[other] < 0:
                heappush(waiting, (depth[other], other))
    return rank


def _line_ranks(model: bs.Model, solids: Solids, lines: Lines, rank: Index, front: npt.NDArray[np.bool_]) -> Index:
    """Return the rank (L,) of the last block whose shown face holds a line; −1 without one."""
    blocks = _pairs(model)[lines.interface].ravel()
    first = np.searchsorted(solids.block_of_face, blocks)
    counts = np.searchsorted(solids.block_of_face, blocks, side="right") - first
    line = np.repeat(np.repeat(np.arange(len(lines.ends)), 2), counts)
    face = np.repeat(first, counts) + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    line, face = line[front[face]], face[front[face]]
    place = np.array([solids.vertices[loop[0]] for loop in solids.loops])
    size = np.array([np.ptp(solids.vertices[loop], axis=0).max() for loop in solids.loops])
    away = lines.ends[line] - place[face][:, None]
    height = np.abs(np.einsum("kec,kc->ke", away, solids.normals[face])).max(axis=1)
    beside = np.abs(np.einsum("kc,kc->k", solids.normals[face], _normals(model)[lines.interface[line]])) < 0.99
    lies = beside & (height < _ON * size[face])
    key = np.full(len(lines.ends), -1)
    np.maximum.at(key, line[lies], rank[solids.block_of_face[face[lies]]])
    return key
