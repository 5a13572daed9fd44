"""Axes of figures: structures in elevation, plan or space, and diagrams."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import Collection, LineCollection, PolyCollection
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.textpath import TextPath

import blockstruct as bs
from blockstruct.views.figures.bodies import Lines, bodies
from blockstruct.views.solids import Solids, TieLines
from blockstruct.views.style import ARROW, CURVES, EDGE, GHOST, LINE, STONE, SUPPORT, TIE, TIE_COLOURS
from blockstruct.views.view import View, round_value

Array = npt.NDArray[np.float64]

#: Width of the shaft of the longest arrow, relative to its length; width of the shortest, relative to that.
_SHAFT, _SHORTEST = 0.05, 0.3


@dataclass(frozen=True, slots=True)
class Canvas:
    """Axes with the view that they show. Later drawings cover earlier ones, and texts cover drawings."""

    ax: Any
    view: View

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
        return cls(ax, view)

    def bodies(
        self,
        model: bs.Model,
        solids: Solids,
        vertices: Array,
        fill: npt.ArrayLike,
        lines: Lines | None = None,
        *,
        edge: tuple[str, float] = (EDGE, 0.4),
    ) -> None:
        """Draw all blocks from back to front, with lines on their faces."""
        self.add(bodies(model, solids, vertices, self.view.basis, fill, edge, lines))

    def ghost(self, model: bs.Model, solids: Solids) -> None:
        """Draw the faint outline of the blocks at rest under everything, in elevations only."""
        if self.view.flat:
            edge = (GHOST, 0.6)
            still = bodies(model, solids, solids.vertices, self.view.basis, ["white"] * len(model.blocks), edge)
            still.set(facecolors="none")
            self.add(still)

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
        model = shown if isinstance(shown, bs.Model) else shown.model
        if not model.ties:
            return {}
        lines, states = TieLines.of(model), None
        ends = lines.ends
        if not isinstance(shown, bs.Model):
            states = bs.ties.tie_state(shown.history.isel(iteration=[iteration])).to_numpy()[0].tolist()
            if factor:
                ends = ends + factor * lines.displacement(shown, iteration)
        seen = self.view.project(ends)
        colours = [TIE] * len(ends) if states is None else [TIE_COLOURS[state] for state in states]
        # A white margin separates the line from edges next to it.
        self.add(LineCollection(list(seen), colors="white", linewidths=LINE + 1.6, capstyle="round"))
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
