"""The collapse mechanism, with blocks coloured by displacement or by body."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgba_array
from matplotlib.patches import Patch

import blockstruct as bs
from blockstruct.arrays import Array
from blockstruct.units import readable, si
from blockstruct.views.figures.canvas import Canvas, legend_above, stones
from blockstruct.views.selection import chosen_iteration, given_result, moving_bodies
from blockstruct.views.solids import Solids, driving, push
from blockstruct.views.style import AMPLITUDE, ARROW, BODY_COLOURS, DISPLACEMENT, EDGE, FORCE, SUPPORT

#: Half the width of a letter of the text of a push, relative to the extent of the structure.
_LETTER = 0.014


def mechanism(
    result: bs.CaseResult,
    *,
    colour: str = "displacement",
    color: str | None = None,
    amplitude: Any = None,
    iteration: int = -1,
    look: Any = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the blocks displaced by a mechanism, in colours, and the push with its load factor.

    Displacements are to first order, so closed joints stay closed in the picture. Their size is
    arbitrary: colours are shares of the largest. An elevation shows the outline of the structure at rest, too.

    Parameters
    ----------
    result
        The result of a case.
    colour, color
        ``"displacement"``: mean displacement of a block. ``"macro-block"``: its body
        (:func:`blockstruct.results.macro_blocks`), named in the legend with its weight.
    amplitude : quantity, length
        The largest translation of a centroid. By default the corner that moves farthest moves by 10 % of the
        structure's largest extent.
    iteration, look, ax
        As in :func:`structure`.

    Raises
    ------
    ModelError, UnknownNameError, UnitError, DimensionError
        As :func:`structure`, and if the amplitude is not a length.
    """
    colour = color or colour
    if colour not in ("displacement", "macro-block"):
        msg = f"mechanism: colour {colour!r}; give 'displacement' or 'macro-block'"
        raise bs.errors.ModelError(msg)
    index = chosen_iteration(given_result(result, "mechanism"), iteration)
    model, solids = result.model, Solids.of(result.model)
    length = None if amplitude is None else si(amplitude, "length", "mechanism: amplitude")
    displacement = solids.displacement(result, index)
    if not np.isfinite(displacement).all():
        msg = (
            f"case {result.name!r}: no mechanism in iteration {index}, {result.status.words}; choose another iteration"
        )
        raise bs.errors.ModelError(msg)
    factor = AMPLITUDE * solids.size * solids.drawn_share(displacement) if length is None else length
    moved = solids.vertices + factor * displacement
    canvas = Canvas.of(result, ax, look)
    canvas.ghost(model, solids)
    if colour == "displacement":
        canvas.bodies(model, solids, moved, _by_displacement(canvas, solids, model, displacement, factor))
    else:
        fill, handles = _by_body(result, index)
        canvas.bodies(model, solids, moved, fill)
    canvas.ties(result, index, factor)
    drawn = _push(canvas, result, index, solids, moved)
    canvas.frame(np.concatenate([solids.vertices, moved, drawn]))
    if colour == "macro-block":
        legend_above(canvas.ax, handles, [str(handle.get_label()) for handle in handles])
    return canvas.ax  # type: ignore[no-any-return]


def _by_displacement(canvas: Canvas, solids: Solids, model: bs.Model, displacement: Array, amplitude: float) -> Array:
    """Return the colours (B, 4) of the blocks by mean displacement; draw their scale with the amplitude, m."""
    starts = np.searchsorted(solids.block_of_vertex, np.arange(len(model.blocks)))
    counts = np.bincount(solids.block_of_vertex)
    size = np.linalg.norm(np.add.reduceat(displacement, starts) / counts[:, None], axis=1)
    scale = LinearSegmentedColormap.from_list("displacement", DISPLACEMENT)
    share = size / max(size.max(), np.finfo(float).tiny)
    fixed = np.array([b.fixed for b in model.blocks])
    label = f"displacement, share of the largest [-]\nlargest translation drawn as {amplitude:.2g} m"
    canvas.scale(ScalarMappable(Normalize(0, 1), scale), label)
    return np.where(fixed[:, None], to_rgba_array(SUPPORT), scale(share))


def _by_body(result: bs.CaseResult, iteration: int) -> tuple[Array, list[Patch]]:
    """Return the colours (B, 4) of the blocks by macro-block, and the entries of a legend."""
    index, moving = moving_bodies(result, iteration)
    fill, palette = to_rgba_array(stones(result.model)), to_rgba_array(BODY_COLOURS)
    fill[index >= 0] = palette[index[index >= 0] % len(palette)]
    handles = [
        Patch(facecolor=colour, edgecolor=EDGE, label=f"{body.name}: {_weight(body)}")
        for body, colour in zip(moving, BODY_COLOURS, strict=False)
    ]
    if (more := len(moving) - len(handles)) > 0:
        handles.append(Patch(facecolor="none", edgecolor="none", label=f"and {more} more"))
    return fill, handles


def _weight(body: bs.results.MacroBlock) -> str:
    factor, unit = readable(body.total, "N")
    carried = f", {body.carried * factor:.4g} {unit} of it carried" if body.carried else ""
    return f"{body.total * factor:.4g} {unit}{carried}"


def _push(canvas: Canvas, result: bs.CaseResult, iteration: int, solids: Solids, moved: Array) -> Array:
    """Draw the load or the reaction with its size; return the ends of the arrow."""
    if bs.vocabulary.Stage(result.history["stage"].to_numpy()[iteration]).is_of_dead_load:
        return np.empty((0, 3))
    at, forces = driving(result)
    supports = result.case.supports if isinstance(result.case, bs.SettlementCase) else ()
    # A reaction acts against the motion of its support.
    direction = -push(result) if supports else push(result)
    text = _answer(result, iteration)
    size = float(np.ptp(moved, axis=0).max())
    length, gap = ARROW * size, 0.025 * size
    if np.linalg.norm(canvas.view.project(direction)) < 0.3:
        canvas.ax.set_title(text, fontsize="small", color=FORCE, loc="right")
        return np.empty((0, 3))
    weight = np.linalg.norm(forces, axis=1)
    centre = weight @ at / weight.sum()
    loads = () if supports else result.case.patterns[-1].loads
    if supports:
        moving = np.array([b.name in supports for b in result.model.blocks])
        of_supports = moving[solids.block_of_vertex]
        tip = centre + (float(((moved[of_supports] - centre) @ direction).min()) - gap) * direction
    elif all(isinstance(load, bs.PointLoad) for load in loads) and np.ptp(at, axis=0).max() < 1e-6 * size:
        tip = centre
    elif canvas.view.flat or abs(direction[2]) > 0.7:
        tip = centre + (float(((moved - centre) @ direction).min()) - gap) * direction
    else:
        # In space, an arrow above the structure hides nothing and is not hidden.
        seen = canvas.view.project(moved)
        above = np.array([(seen[:, 0].min() + seen[:, 0].max()) / 2, seen[:, 1].max() + 3 * gap])
        tip = above @ canvas.view.basis[:2] + length / 2 * direction
    tail = tip - length * direction
    canvas.arrows(tail[None], length * direction[None], FORCE)
    right, up = canvas.view.project(direction)
    beyond = tail - (0.01 * size * direction if abs(up) > abs(right) else -0.045 * size * canvas.view.basis[1])
    align: dict[str, Any] = {"ha": "center", "va": "bottom" if up <= 0 or abs(right) >= abs(up) else "top"}
    # The text is wider than the arrow: next to the structure it ends where the arrow does.
    across, upward = _LETTER * len(text) * size * canvas.view.basis[0], 0.05 * size * canvas.view.basis[1]
    centre_of_text = beyond
    if abs(right) >= abs(up):
        beside = canvas.view.flat
        beyond = (tip if beside else (tail + tip) / 2) + 0.03 * size * canvas.view.basis[1]
        align["ha"] = ("right" if right > 0 else "left") if beside else "center"
        centre_of_text = beyond - np.sign(right) * across if beside else beyond
    canvas.text(beyond, text, color=FORCE, fontweight="bold", **align)
    away = upward if align["va"] == "bottom" else -upward
    return np.array([tail, tip, centre_of_text - across, centre_of_text + across, centre_of_text + away])


def _answer(result: bs.CaseResult, iteration: int) -> str:
    answer = result.answer
    if result.status is bs.Status.CONVERGED and iteration == result.n_iterations - 1:
        return f"{answer.symbol} = {answer.text(result.load_factor)}"
    value = float(result.history["load_factor"].to_numpy()[iteration])
    if not np.isfinite(value):
        return f"iteration {iteration}"
    return f"{answer.symbol} = {answer.text(value)} (iteration {iteration})"
