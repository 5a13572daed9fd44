"""Forces between blocks, with the thrust line, and the loads of a case."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

import blockstruct as bs
from blockstruct.arrays import Array
from blockstruct.text.mechanism import SMALL
from blockstruct.units import readable
from blockstruct.views.figures.canvas import Canvas, legend_above, verbatim
from blockstruct.views.selection import application_points, chosen_iteration, contact_forces, given_result
from blockstruct.views.solids import Solids, TieLines, block_pairs, load_arrows, round_value
from blockstruct.views.style import ACCENT, ARROW, FORCE, PALE_EDGE, PALE_STONE, TIE


def forces(
    result: bs.CaseResult, *, at: str = "interfaces", iteration: int = -1, look: Any = None, ax: Axes | None = None
) -> Axes:
    """Draw forces on the plus blocks and in ties, and the thrust line.

    Length and width of arrows are proportional to forces; a round force is the key. Forces below 2 % of the
    largest are left out. Forces inside are drawn over the blocks.

    Parameters
    ----------
    result
        The result of a case.
    at
        ``"interfaces"``: the resultant of each compressed interface, with the thrust line.
        ``"contact points"``: the force at each contact point. Forces within rounding are left out.
    iteration, look, ax
        As in :func:`structure`.

    Raises
    ------
    ModelError, UnknownNameError
        As :func:`structure`, and if ``at`` is unknown or the iteration has no forces.
    """
    index = chosen_iteration(given_result(result, "forces"), iteration)
    if at == "interfaces":
        points, force = application_points(result, index)
        acts = np.isfinite(points).all(axis=1)
    elif at == "contact points":
        history = result.history.isel(iteration=index)
        points, force = history["contact_point_position"].to_numpy(), contact_forces(history)
        acts = np.linalg.norm(force, axis=1) > bs.results.NO_FORCE * history["contact_force_unit"].to_numpy()
    else:
        msg = f"forces: at {at!r}; give 'interfaces' or 'contact points'"
        raise bs.errors.ModelError(msg)
    if not acts.any():
        msg = f"case {result.name!r}: no forces in iteration {index}; choose another iteration"
        raise bs.errors.ModelError(msg)

    model = result.model
    solids = Solids.of(model)
    canvas = Canvas.of(result, ax, look)
    canvas.bodies(model, solids, solids.vertices, [PALE_STONE] * len(model.blocks), edge=(PALE_EDGE, 0.4))
    if at == "interfaces":
        lines = canvas.view.project(_thrust_segments(model, points))
        # If few blocks have just two compressed joints, the segments do not form a line.
        if len(lines) >= sum(not b.fixed for b in model.blocks) / 2:
            canvas.add(LineCollection(list(lines), colors=ACCENT, linewidths=1.3))
    size = np.where(acts, np.linalg.norm(force, axis=1), 0.0)
    shown = np.flatnonzero(size > SMALL * size.max())
    shown = shown[np.argsort(size[shown])]
    canvas.ties(result, index)
    _tie_forces(canvas, result, index)
    scale = ARROW * solids.size / size.max()
    canvas.arrows(points[shown], force[shown] * scale, FORCE)
    drawn = np.concatenate([solids.vertices, points[shown], (points + force * scale)[shown]])
    factor, unit = readable(size, "N")
    known = round_value(float(size.max()) * factor) / factor
    key = _key(canvas, drawn, known * scale, f"{known * factor:g} {unit}")
    canvas.frame(np.concatenate([drawn, key]))
    return canvas.ax  # type: ignore[no-any-return]


def _tie_forces(canvas: Canvas, result: bs.CaseResult, iteration: int) -> None:
    """Write the force of each tie next to it."""
    if not result.model.ties:
        return
    force = bs.results.tie_forces(result.history)[iteration]
    factor, unit = readable(force, "N")
    right, up = 0.02 * Solids.of(result.model).size * canvas.view.basis[:2]
    for ends, value in zip(TieLines.of(result.model).ends, force, strict=True):
        across, along = np.abs(canvas.view.project(ends[1] - ends[0]))
        away, place = (up, ("center", "bottom")) if across > along else (right, ("left", "center"))
        behind = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
        text = f"{value * factor:.3g} {unit}"
        canvas.text(ends.mean(axis=0) + away, text, color=TIE, ha=place[0], va=place[1], bbox=behind)


def _key(canvas: Canvas, points: Array, length: float, text: str) -> Array:
    """Draw an arrow with a round force above the structure; return its ends."""
    right, up = canvas.view.basis[:2]
    seen = canvas.view.project(points)
    high, size = seen.max(axis=0), float(np.ptp(seen, axis=0).max())
    tail = np.array([seen[:, 0].min(), high[1] + 0.07 * size]) @ canvas.view.basis[:2]
    canvas.arrows(tail[None], length * right[None], FORCE)
    canvas.text(tail + (length + 0.02 * size) * right, text, color=FORCE, ha="left", va="center")
    return np.array([tail, tail + length * right + 0.03 * size * up])


def _thrust_segments(model: bs.Model, points: Array) -> Array:
    """Return segments (S, 2, 3) between the two compressed points of every free block that has just two."""
    fixed = np.array([b.fixed for b in model.blocks])
    pressed = np.flatnonzero(np.isfinite(points).all(axis=1))
    blocks, interfaces = block_pairs(model)[pressed].T.ravel(), np.tile(pressed, 2)
    order = np.argsort(blocks, kind="stable")
    block_of, starts, counts = np.unique(blocks[order], return_index=True, return_counts=True)
    # A support may be pressed at several places without thrust between them.
    first = starts[(counts == 2) & ~fixed[block_of]]
    pairs = np.stack([interfaces[order][first], interfaces[order][first + 1]], axis=1)
    return np.asarray(points[pairs])


def loads(result: bs.CaseResult, *, look: Any = None, ax: Axes | None = None) -> Axes:
    """Draw the dead load without block weights, and the variable load.

    Arrows end where the forces act. Their lengths are proportional to the forces, to one scale for each load; arrows
    below 2 % of the longest are left out. The legend has the resultants. Forces on supports and couples are not drawn.

    Parameters
    ----------
    result
        The result of a case, with or without iterations.
    look, ax
        As in :func:`structure`.

    Raises
    ------
    ModelError
        If it is not the result of a case.
    """
    model = given_result(result, "loads").model
    solids = Solids.of(model)
    canvas = Canvas.of(result, ax, look)
    canvas.bodies(model, solids, solids.vertices, [PALE_STONE] * len(model.blocks), edge=(PALE_EDGE, 0.4))
    drawn, handles = [solids.vertices], {}
    for arrows in load_arrows(result):
        colour, times = (FORCE, " × load factor") if arrows.grows else (ACCENT, "")
        vectors = arrows.force * (ARROW * solids.size / arrows.largest)
        tails = arrows.point - vectors
        canvas.arrows(tails, vectors, colour)
        drawn.append(tails)
        factor, unit = readable(np.array([arrows.largest]), "N")
        text = f"{verbatim(arrows.name)}: {arrows.total * factor:.4g} {unit}{times}"
        handles[text] = Line2D([], [], color=colour, lw=2)
    canvas.frame(np.concatenate(drawn))
    legend_above(canvas.ax, list(handles.values()), list(handles))
    return canvas.ax  # type: ignore[no-any-return]
