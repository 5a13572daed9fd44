"""The structure with its overall dimensions."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct.views.figures.structure import structure
from blockstruct.views.view import View

#: Distance of dimension lines from the structure, relative to its size.
_OFF = 0.06
#: Length on the page, relative to the size, below which an edge points at the reader and has no dimension.
_VISIBLE = 0.02
_LINE: Any = {"arrowstyle": "<->", "color": "0.35", "lw": 0.8, "shrinkA": 0, "shrinkB": 0}


def dimensions(model: bs.Model, *, look: Any = None, ax: Axes | None = None) -> Axes:
    """Draw a model with the overall dimensions of its free blocks, m.

    Parameters
    ----------
    model
        The structure.
    look, ax
        As in :func:`structure`.
    """
    ax = structure(model, look=look, ax=ax)
    view = View.of(model, look)
    vertices = np.concatenate([b.shape.vertices for b in model.blocks if not b.fixed])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    corners = np.array([(x, y, low[2]) for x in (low[0], high[0]) for y in (low[1], high[1])])
    seen = view.project(vertices)
    size = float(np.ptp(seen, axis=0).max())
    # Horizontal edges meet at the bottom corner nearest to the reader; the vertical one is at the right end.
    near = corners[np.argmax(corners @ view.basis[2] - 1e-6 * corners @ view.basis[1])]
    right = corners[np.argmax(view.project(corners)[:, 0] + 1e-6 * (corners @ view.basis[2]))]
    for axis in range(3):
        start = near if axis < 2 else right
        end = start.copy()
        end[axis] = low[axis] + high[axis] - start[axis]
        ends = view.project(np.array([start, end]))
        if np.linalg.norm(ends[1] - ends[0]) < _VISIBLE * size:
            continue
        ends += _OFF * size * (np.array([1.0, 0.0]) if axis == 2 else np.array([0.0, -1.0]))
        ax.annotate("", ends[0], ends[1], arrowprops=_LINE, annotation_clip=False)
        ax.annotate(
            f"{high[axis] - low[axis]:.4g} m",
            ends.mean(axis=0),
            ha="center",
            va="center",
            fontsize="small",
            annotation_clip=False,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5},
        )
        grown = [np.array(ax.get_xlim()), np.array(ax.get_ylim())]
        for k, (limits, margin) in enumerate(zip(grown, (0.12, 0.04), strict=True)):
            limits[0] = min(limits[0], ends[:, k].min() - margin * size * (k == 1))
            limits[1] = max(limits[1], ends[:, k].max() + margin * size * (axis == 2 and k == 0))
        ax.set(xlim=grown[0], ylim=grown[1])
    return ax
