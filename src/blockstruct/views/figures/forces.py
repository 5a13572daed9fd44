"""Forces between blocks: arrows and the thrust line."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.views.figures.canvas import Canvas
from blockstruct.views.selection import ROUNDING, application_points, chosen_iteration, same_model
from blockstruct.views.solids import Solids
from blockstruct.views.style import ACCENT, FORCE, readable

Array = NDArray[np.float64]

#: Length of the longest arrow, in multiples of the largest extent of the structure.
LONGEST = 0.15


def forces(
    model: bs.Model,
    result: bs.CaseResult,
    *,
    at: str = "interfaces",
    iteration: int = -1,
    look: str = "y",
    ax: Axes | None = None,
) -> Axes:
    """Draw the forces on the plus blocks, and the line of thrust through blocks pressed at two interfaces.

    Parameters
    ----------
    model, result
        The structure and a case of it.
    at
        ``"interfaces"``: the resultant of each compressed interface, where it acts, with the line of thrust.
        ``"contact points"``: the force at each contact point. Forces that are rounding are left out.
    iteration, look, ax
        As in :func:`structure`.

    Raises
    ------
    ModelError, UnknownNameError
        As :func:`structure`, an unknown ``at``, or an iteration without forces.
    """
    same_model(model, result)
    index = chosen_iteration(result, iteration)
    if at == "interfaces":
        points, force = application_points(result, index)
        acts = np.isfinite(points).all(axis=1)
    elif at == "contact points":
        history = result.history.isel(iteration=index)
        frame = history["interface_frame"].to_numpy()[history["interface_of_contact_point"].to_numpy()]
        points = history["contact_position"].to_numpy()
        force = np.einsum("kc,kca->ka", history["contact_force"].transpose("contact_point", "component"), frame)
        acts = np.linalg.norm(force, axis=1) > ROUNDING * history["unit_of_force"].to_numpy()
    else:
        msg = f"forces: at {at!r}; give 'interfaces' or 'contact points'"
        raise bs.ModelError(msg)
    if not acts.any():
        msg = f"case {result.name!r}: no forces in iteration {index}; choose another iteration"
        raise bs.ModelError(msg)

    solids = Solids.of(model)
    canvas = Canvas.of(ax, look)
    canvas.bodies(solids, [b.fixed for b in model.blocks], solids.vertices, ghost=not canvas.flat)
    size = np.where(acts, np.linalg.norm(force, axis=1), 0.0)
    shown = size > 1e-3 * size.max()
    scale = LONGEST * solids.size / size.max()
    tails = canvas.project(points[shown])
    arrows = canvas.project(force[shown] * scale)
    if canvas.flat:
        style = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.0035, "zorder": 4}
        canvas.ax.quiver(*tails.T, *arrows.T, color=FORCE, **style)
    else:
        canvas.ax.quiver(*tails.T, *arrows.T, color=FORCE, linewidth=0.9, arrow_length_ratio=0.2)
    if at == "interfaces":
        _thrust(canvas, _thrust_segments(model, points))
    canvas.frame(np.concatenate([solids.vertices, (points + force * scale)[shown]]))
    factor, unit = readable(size, "N")
    text = f"longest arrow {size.max() * factor:.3g} {unit}"
    canvas.ax.set_title(text, fontsize="small", color="0.35")
    return canvas.ax  # type: ignore[no-any-return]


def _thrust(canvas: Canvas, segments: Array) -> None:
    lines = canvas.project(segments)
    if not len(lines):
        return
    if canvas.flat:
        canvas.add(LineCollection(list(lines), colors=ACCENT, linewidths=1.4, zorder=3))
    else:
        canvas.add(Line3DCollection(list(lines), colors=ACCENT, linewidths=1.4))


def _thrust_segments(model: bs.Model, points: Array) -> Array:
    """Segments (S, 2, 3) between the two pressed points of every free block that has just two."""
    number = {b.name: i for i, b in enumerate(model.blocks)}
    fixed = np.array([b.fixed for b in model.blocks])
    pressed = np.flatnonzero(np.isfinite(points).all(axis=1))
    ends = np.array([(number[model.interfaces[i].minus], number[model.interfaces[i].plus]) for i in pressed])
    blocks, interfaces = ends.T.ravel(), np.tile(pressed, 2)
    order = np.argsort(blocks, kind="stable")
    found, starts, counts = np.unique(blocks[order], return_index=True, return_counts=True)
    # A support may be pressed at any number of places: between two of them nothing is thrust.
    first = starts[(counts == 2) & ~fixed[found]]
    pairs = np.stack([interfaces[order][first], interfaces[order][first + 1]], axis=1)
    return np.asarray(points[pairs])
