"""Axes of figures: structures in elevation, plan or space, drawn from back to front, and diagrams."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import Collection, LineCollection, PathCollection, PolyCollection
from matplotlib.colors import to_rgba_array
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.textpath import TextPath

import blockstruct as bs
from blockstruct.arrays import NEGLIGIBLE, Array, Flags, Index
from blockstruct.geometry.neighbours import expanded
from blockstruct.geometry.polygon import next_corners
from blockstruct.views.solids import Solids, TieLines, View, round_value
from blockstruct.views.style import ARROW, CURVES, EDGE, GHOST, LINE, STONE, SUPPORT, TIE, TIE_COLOURS

#: Light in the axes of the view (right, up, toward the reader), and the share of brightness without it.
_LIGHT, _AMBIENT = np.array([-0.3, 0.5, 0.81]), 0.62
#: Distance from a face, relative to its size, that counts as on it.
_ON = 1e-2


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
    """

    ends: Array
    interface: Index
    colours: Array
    dashes: list[Any]


def _normals(model: bs.Model) -> Array:
    """Return the normals (I, 3) of the interfaces, from the minus to the plus block."""
    return np.array([i.normal for i in model.interfaces], dtype=float).reshape(-1, 3)


def _ranks(model: bs.Model, solids: Solids, seen: Array, basis: Array) -> Index:
    """Return the order (B,) of drawing: after the blocks in contact further away, the farthest first."""
    starts = np.searchsorted(solids.block_of_vertex, np.arange(len(model.blocks)))
    depth = np.add.reduceat(seen[:, 2], starts) / np.bincount(solids.block_of_vertex)
    pairs, toward = bs.results.block_pairs(model), _normals(model) @ basis[2]
    pairs = np.where(toward[:, None] > 0, pairs, pairs[:, ::-1])[np.abs(toward) > NEGLIGIBLE]
    before = np.bincount(pairs[:, 1], minlength=len(depth))
    ahead: list[list[int]] = [[] for _ in depth]
    for behind, ahead_of_it in pairs.tolist():
        ahead[behind].append(ahead_of_it)
    # Interlocking blocks each lie partly in front of the next: if all wait, the farthest goes first.
    place = depth + (np.ptp(depth) + 1) * (before > 0)
    rank = np.empty(len(depth), dtype=np.int64)
    for turn in range(len(depth)):
        k = int(place.argmin())
        rank[k], place[k] = turn, np.inf
        for other in ahead[k]:
            before[other] -= 1
            if before[other] == 0 and np.isfinite(place[other]):
                place[other] = depth[other]
    return rank


def _line_ranks(model: bs.Model, solids: Solids, lines: Lines, rank: Index, front: Flags) -> Index:
    """Return the rank (L,) of the last block whose shown face holds a line; −1 without one."""
    blocks = bs.results.block_pairs(model)[lines.interface].ravel()
    first = np.searchsorted(solids.block_of_face, blocks)
    counts = np.searchsorted(solids.block_of_face, blocks, side="right") - first
    of, face, _ = expanded(first, counts)
    line, face = of[front[face]] // 2, face[front[face]]
    place = np.array([solids.vertices[loop[0]] for loop in solids.loops])
    size = np.array([np.ptp(solids.vertices[loop], axis=0).max() for loop in solids.loops])
    away = lines.ends[line] - place[face][:, None]
    height = np.abs(np.einsum("kec,kc->ke", away, solids.normals[face])).max(axis=1)
    beside = np.abs(np.einsum("kc,kc->k", solids.normals[face], _normals(model)[lines.interface[line]])) < 0.99
    lies = beside & (height < _ON * size[face])
    key = np.full(len(lines.ends), -1)
    np.maximum.at(key, line[lies], rank[solids.block_of_face[face[lies]]])
    return key


#: Width of the shaft of the longest arrow, relative to its length; width of the shortest, relative to that.
_SHAFT, _SHORTEST = 0.05, 0.3


@dataclass(frozen=True, slots=True)
class Canvas:
    """Axes with the structure and the view that they show. Later drawings cover earlier ones; texts cover drawings."""

    ax: Any
    view: View
    model: bs.Model
    solids: Solids

    @classmethod
    def of(cls, shown: bs.Model | bs.CaseResult, ax: Axes | None, look: Any) -> "Canvas":
        """Return a canvas for a look, with new Axes if none are given.

        Raises
        ------
        ModelError
            If the look is unknown, or the Axes have a projection.
        """
        view = View.of(shown, look)
        if ax is None:
            ax = plt.figure(layout="constrained").add_subplot()
        if ax.name != "rectilinear":
            msg = f"figure: Axes of projection {ax.name!r}; give plain Axes, space is projected on them"
            raise bs.errors.ModelError(msg)
        model = shown if isinstance(shown, bs.Model) else shown.model
        return cls(ax, view, model, Solids.of(model))

    def bodies(
        self, vertices: Array, fill: npt.ArrayLike, lines: Lines | None = None, *, edge: tuple[str, float] = (EDGE, 0.4)
    ) -> Any:
        """Draw the faces of all blocks that face the reader, and the lines on them; return the collection.

        Blocks are drawn in turn. Of two in contact, the one on the reader's side of their joint is in front; of others,
        the nearer one.

        Parameters
        ----------
        vertices : (V, 3) array
            Positions of their vertices, m.
        fill
            Colour of each block.
        lines
            Lines on the faces, of blocks that are not displaced.
        edge
            Colour and width of the edges of faces.
        """
        solids, basis = self.solids, self.view.basis
        seen = vertices @ basis.T
        corners = [seen[loop] for loop in solids.loops]
        counts = np.array([len(c) for c in corners])
        starts = np.cumsum([0, *counts[:-1]])
        points = np.concatenate(corners)
        following = next_corners(starts, counts)
        away = points - np.repeat(points[starts], counts, axis=0)
        normals = np.add.reduceat(np.cross(away, away[following]), starts)
        normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
        front = normals[:, 2] > NEGLIGIBLE

        light = _AMBIENT + (1 - _AMBIENT) * np.clip(normals @ _LIGHT / _LIGHT[2], 0, 1.1)
        colour = to_rgba_array(fill)[solids.block_of_face]
        colour[:, :3] = np.clip(colour[:, :3] * light[:, None], 0, 1)

        rank = _ranks(self.model, solids, seen, basis)
        depth = np.add.reduceat(points[:, 2], starts) / counts
        shown = np.flatnonzero(front)
        paths = [Path(np.vstack([corners[k], corners[k][:1]])[:, :2], closed=True) for k in shown]
        # Faces of rank r come first, then the lines after all faces of that rank.
        ranks, depths = rank[solids.block_of_face[shown]].astype(float), depth[shown]
        colours, edges = colour[shown], np.repeat(to_rgba_array(edge[0]), len(shown), axis=0)
        widths, dashes = np.full(len(shown), edge[1]), ["-"] * len(shown)
        if lines is not None:
            key = _line_ranks(self.model, solids, lines, rank, front)
            drawn = np.flatnonzero(key >= 0)
            paths += [Path(p) for p in (lines.ends[drawn] @ basis.T)[..., :2]]
            ranks, depths = np.concatenate([ranks, key[drawn] + 0.5]), np.concatenate([depths, np.zeros(len(drawn))])
            colours = np.concatenate([colours, np.zeros((len(drawn), 4))])
            edges = np.concatenate([edges, lines.colours[drawn]])
            widths = np.append(widths, np.full(len(drawn), LINE))
            dashes += [lines.dashes[k] for k in drawn]
        order = np.lexsort((depths, ranks))
        faces = PathCollection(
            [paths[k] for k in order],
            facecolors=colours[order],
            edgecolors=edges[order],
            linewidths=widths[order],
            linestyles=[dashes[k] for k in order],
            capstyle="butt",
            joinstyle="round",
        )
        return self.add(faces)

    def ghost(self) -> None:
        """Draw the faint outline of the blocks at rest under everything, in elevations only."""
        if self.view.flat:
            still = self.bodies(self.solids.vertices, ["white"] * len(self.model.blocks), edge=(GHOST, 0.6))
            still.set(facecolors="none")

    def arrows(self, tails: Array, vectors: Array, colour: str) -> None:
        """Draw arrows (n, 3), m. The longer an arrow, the wider its shaft."""
        length = np.linalg.norm(vectors, axis=1)
        widths = _SHAFT * (_SHORTEST * length.max() + (1 - _SHORTEST) * length)
        shapes = _arrow(self.view.project(tails), self.view.project(vectors), widths)
        self.add(PolyCollection(list(shapes), facecolors=colour, edgecolors="white", linewidths=0.3))

    def ties(self, shown: bs.Model | bs.CaseResult, iteration: int = -1, factor: float = 0.0) -> dict[str, Any]:
        """Draw ties over the blocks, coloured by state for a result; return handles of a legend.

        Parameters
        ----------
        shown
            A model, or a result.
        iteration
            Iteration of the result.
        factor
            Amplitude of its mechanism, m.
        """
        if not self.model.ties:
            return {}
        lines, states = TieLines.of(self.model), None
        ends = lines.ends
        if not isinstance(shown, bs.Model):
            states = bs.ties.tie_state(shown.history.isel(iteration=[iteration])).to_numpy()[0].tolist()
            if factor:
                ends = ends + factor * lines.displacement(shown, iteration)
        seen = self.view.project(ends)
        colours = [TIE] * len(ends) if states is None else [TIE_COLOURS[state] for state in states]
        # A white margin separates the line from edges next to it.
        self.add(LineCollection(list(seen), colors="white", linewidths=2 * LINE, capstyle="round"))
        self.add(LineCollection(list(seen), colors=colours, linewidths=LINE, capstyle="round"))
        ends_of = self.ax.scatter(*seen.reshape(-1, 2).T, s=9, c=np.repeat(colours, 2), marker="s", clip_on=False)
        ends_of.set_zorder(len(self.ax.collections))
        named = (
            {"tie": TIE} if states is None else {f"tie, {state}": TIE_COLOURS[state] for state in sorted(set(states))}
        )
        return {name: Line2D([], [], color=colour, lw=LINE) for name, colour in named.items()}

    def text(self, point: Array, text: str, **style: Any) -> None:
        """Write a text at a point (3,)."""
        x, y = self.view.project(point)
        self.ax.text(x, y, text, fontsize="small", zorder=np.inf, clip_on=False, **style)

    def add(self, collection: Collection) -> Any:
        """Add a collection without changing the limits, which :meth:`frame` sets."""
        collection.set_zorder(len(self.ax.collections))
        return self.ax.add_collection(collection, autolim=False)

    def scale(self, mapping: ScalarMappable, label: str, extend: str = "neither") -> None:
        """Draw a colour scale on the right."""
        # Keep it near a narrow structure.
        place = {"shrink": 0.7, "aspect": 28, "pad": 0.02, "panchor": (0.7, 0.5)}
        bar = self.ax.figure.colorbar(mapping, ax=self.ax, extend=extend, **place)
        bar.set_label(label, fontsize="small")

    def frame(self, points: Array) -> None:
        """Fit the axes to points (n, 3), with equal scales and labels with units."""
        shown = self.view.project(points)
        low, high = shown.min(axis=0), shown.max(axis=0)
        margin = 0.03 * (high - low).max()
        self.ax.set_aspect("equal")
        if self.view.labels is None:
            low = self._triad(points, low, high)
            self.ax.set_axis_off()
        else:
            self.ax.set(xlabel=self.view.labels[0], ylabel=self.view.labels[1])
            self.ax.spines[["top", "right"]].set_visible(False)
        self.ax.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))

    def _triad(self, points: Array, low: Array, high: Array) -> Array:
        """Draw the axes in the lower left corner; return the lower left end of the drawing."""
        size = float((high - low).max())
        length = round_value(ARROW * size)
        axes = length * np.eye(3)
        ends = self.view.project(axes)
        # Next to the structure, as low as it is.
        place = np.array([low[0] - ends[:, 0].max() - 0.06 * size, low[1] - min(ends[:, 1].min(), 0)])
        origin = place @ self.view.basis[:2]
        self.arrows(np.repeat(origin[None], 3, axis=0), axes, "0.35")
        for name, axis in zip("xyz", axes, strict=True):
            self.text(origin + 1.22 * axis, name, color="0.35", ha="center", va="center")
        self.text(origin - np.array([0, 0, 0.07 * size]), f"{length:g} m", color="0.35", ha="center", va="top")
        return np.array([place[0] + min(ends[:, 0].min(), 0), low[1] - 0.06 * size])


def stones(model: bs.Model) -> list[str]:
    """Return the colour of each block: stone or support."""
    return [SUPPORT if b.held else STONE for b in model.blocks]


def _arrow(tails: Array, vectors: Array, widths: Array) -> Array:
    """Return outlines (n, 7, 2) of arrows with visible heads."""
    length = np.linalg.norm(vectors, axis=1)
    along = vectors / np.maximum(length, np.finfo(float).tiny)[:, None]
    side = along[:, ::-1] * (-1, 1)
    head = np.minimum(4.0 * widths, 0.65 * length)
    # Short arrows become slender, not blunt.
    half = 0.5 * widths * head / np.maximum(4.0 * widths, np.finfo(float).tiny)
    across = np.array([1, 1, 3.2, 0, -3.2, -1, -1])
    back = np.stack([np.zeros_like(length), *[length - head] * 2, length, *[length - head] * 2, np.zeros_like(length)])
    return np.asarray(
        tails[:, None] + back.T[..., None] * along[:, None] + (across * half[:, None])[..., None] * side[:, None]
    )


def legend_above(ax: Axes, handles: Sequence[Any] | None = None, labels: Sequence[str] | None = None) -> None:
    """Draw the legend in rows above the Axes, so that it takes no width from them."""
    if handles is None or labels is None:
        handles, labels = ax.get_legend_handles_labels()
    if not handles:
        return
    size, spacing = FontProperties(size="small").get_size_in_points(), 1.4
    rc = plt.rcParams
    key = (rc["legend.handlelength"] + rc["legend.handletextpad"] + spacing) * size
    entry = key + max(TextPath((0, 0), label, size=size).get_extents().width for label in labels)
    figure = ax.get_figure(root=True)
    width = ax.get_position(original=True).width * figure.get_size_inches()[0]  # type: ignore[union-attr]
    ax.legend(
        handles,
        labels,
        ncols=max(1, int(72 * width / entry)),
        loc="lower left",
        bbox_to_anchor=(0, 1.01),
        borderaxespad=0,
        frameon=False,
        fontsize="small",
        columnspacing=spacing,
    )


def verbatim(name: str) -> str:
    """Return a user's name for matplotlib, which would read text between dollar signs as a formula."""
    return name.replace("$", r"\$")


def new_axes(ax: Axes | None) -> Axes:
    """Return Axes for a diagram without a box, new ones if none are given."""
    axes = ax if ax is not None else plt.figure(figsize=(5, 3.4), layout="constrained").add_subplot()
    axes.spines[["top", "right"]].set_visible(False)
    return axes


def next_colour(ax: Axes) -> str:
    """Return the colour of the next named curve on the Axes."""
    return CURVES[len(ax.get_legend_handles_labels()[1]) % len(CURVES)]
