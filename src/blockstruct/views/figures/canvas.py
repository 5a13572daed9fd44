"""The Axes of figures: elevations, plans and space."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection, PolyCollection
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from mpl_toolkits.mplot3d.proj3d import proj_transform
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.views.solids import Solids
from blockstruct.views.style import EDGE, GHOST, STONE, SUPPORT

Array = NDArray[np.float64]

_AXES = {
    "x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
}
#: Share of half the Axes that the farther side of a box in space reaches to: beyond it are the labels.
_FILLED = 0.8
_LABELS = {"x": ("y [m]", "z [m]"), "y": ("x [m]", "z [m]"), "z": ("x [m]", "y [m]")}


@dataclass(frozen=True, slots=True)
class Canvas:
    """Axes with the direction it looks along: ``"x"``, ``"y"`` (elevations), ``"z"`` (plan) or ``"3d"``."""

    ax: Any
    look: str

    @classmethod
    def of(cls, ax: Axes | None, look: str) -> "Canvas":
        """Axes for a look, made anew if there is none.

        Raises
        ------
        ModelError
            A look that is none of the four, or Axes that are not of its kind.
        """
        if look not in (*_AXES, "3d"):
            msg = f"figure: look {look!r}; give 'x' or 'y' for an elevation, 'z' for a plan, '3d' for space"
            raise bs.ModelError(msg)
        kind = "3d" if look == "3d" else None
        if ax is None:
            ax = plt.figure(layout="constrained").add_subplot(projection=kind)
        if (ax.name == "3d") != (look == "3d"):
            msg = f"figure: look {look!r} on Axes of projection {ax.name!r}; make them with projection={kind!r}"
            raise bs.ModelError(msg)
        return cls(ax, look)

    @property
    def flat(self) -> bool:
        """Whether points are projected."""
        return self.look != "3d"

    def project(self, points: Array) -> Array:
        """Right and up coordinates (…, 2) of points or vectors (…, 3); in space they stay as they are."""
        return points @ np.array(_AXES[self.look][:2], dtype=float).T if self.flat else points

    def bodies(self, solids: Solids, supports: Sequence[bool], vertices: Array, *, ghost: bool = False) -> None:
        """Draw the faces of all blocks, those in front over those behind; or only their faint ghost."""
        fill = np.where(np.asarray(supports)[solids.block_of_face], SUPPORT, STONE)
        if ghost:
            fill = np.full(len(fill), "none")
        edge, width = (GHOST, 0.6) if ghost else (EDGE, 0.4)
        if not self.flat:
            if ghost:
                # Faces, however faint, add up to a veil over what is inside.
                self.add(Line3DCollection(vertices[solids.edges], colors=edge, linewidths=width))
                return
            faces = [vertices[loop] for loop in solids.loops]
            self.add(Poly3DCollection(faces, facecolors=fill, edgecolors=edge, linewidths=width, shade=True))
            return
        toward = np.array(_AXES[self.look][2], dtype=float)
        front = np.flatnonzero(solids.normals @ toward > 1e-6)
        depth = [float((vertices[solids.loops[f]] @ toward).mean()) for f in front]
        order = front[np.argsort(depth, kind="stable")]
        faces = [self.project(vertices[solids.loops[f]]) for f in order]
        layer = 0 if ghost else 1
        self.add(PolyCollection(faces, facecolors=fill[order], edgecolors=edge, linewidths=width, zorder=layer))

    def polygons(self, polygons: Sequence[Array], **style: Any) -> Any:
        """Draw plane polygons (k, 3); gives the collection."""
        flat = [self.project(p) for p in polygons]
        return self.add((PolyCollection if self.flat else Poly3DCollection)(flat, **style))

    def add(self, collection: Collection) -> Any:
        """Add a collection, which leaves the limits to :meth:`frame`.

        ``add_collection3d`` would take limits from the unused ends of faces with fewer corners than others, which
        matplotlib 3.11 does not initialise.
        """
        return self.ax.add_collection(collection, autolim=False)

    def frame(self, points: Array) -> None:
        """Fit the axes to points (n, 3), with equal scales and labels with units."""
        shown = self.project(points)
        low, high = shown.min(axis=0), shown.max(axis=0)
        margin = 0.04 * (high - low).max()
        if self.flat:
            self.ax.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
            self.ax.set_aspect("equal")
            self.ax.set(xlabel=_LABELS[self.look][0], ylabel=_LABELS[self.look][1])
            self.ax.spines[["top", "right"]].set_visible(False)
            return
        self.ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        self._fill(np.maximum(high - low, 0.02 * (high - low).max()), low, high)
        self.ax.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
        self.ax.grid(visible=False)
        for axis, extent in zip((self.ax.xaxis, self.ax.yaxis, self.ax.zaxis), high - low, strict=True):
            axis.set_pane_color((1, 1, 1, 0))
            # A short axis has room for its ends only.
            axis.set_major_locator(MaxNLocator(3 if extent > 0.4 * (high - low).max() else 1))

    def _fill(self, aspect: Array, low: Array, high: Array) -> None:
        """Zoom so that a box fills the Axes: by its own choice matplotlib cuts off what is high or long."""
        corners = np.array(list(product(*zip(low, high, strict=True))))
        zoom = 1.0
        # In perspective a larger box is also nearer: its size is found in some steps.
        for _ in range(4):
            self.ax.set_box_aspect(aspect, zoom=zoom)
            *plane, _depth = proj_transform(*corners.T, self.ax.get_proj())
            zoom *= _FILLED * np.abs(self.ax.viewLim.extents).min() / np.abs(plane).max()


def new_axes(ax: Axes | None) -> Axes:
    """Axes of a diagram, made anew if there is none, without a box."""
    axes = ax if ax is not None else plt.figure(figsize=(5, 3.4), layout="constrained").add_subplot()
    axes.spines[["top", "right"]].set_visible(False)
    return axes
