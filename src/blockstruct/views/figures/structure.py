"""Pictures of a structure: its blocks and states, its dimensions, mechanism, forces and loads."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgba_array
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.arrays import Array, Index
from blockstruct.text.mechanism import SMALL, weight_text
from blockstruct.units import readable, si
from blockstruct.views import style
from blockstruct.views.figures.canvas import Canvas, Lines, legend_above, stones, verbatim
from blockstruct.views.selection import (
    application_points,
    chosen_iteration,
    given_result,
    moving_bodies,
)
from blockstruct.views.solids import Solids, TieLines, View, driving, load_arrows, push, round_value

#: Length of a dash, in widths of its line.
_DASH = 2.5
#: Distance of dimension lines from the structure, relative to its size.
_OFF = 0.06
_LINE: Any = {"arrowstyle": "<->", "color": "0.35", "lw": 0.8, "shrinkA": 0, "shrinkB": 0}


def structure(
    shown: bs.Model | bs.CaseResult,
    *,
    colour: str = "state",
    color: str | None = None,
    iteration: int = -1,
    look: Any = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw a model with its ties; for a result, joints by state or utilisation, and ties by state.

    Joints are drawn where they meet the surface, hidden by blocks in front. Sticking joints are drawn as
    the edges of the blocks.

    Parameters
    ----------
    shown
        A result, or a model alone.
    colour, color
        ``"state"``: :func:`blockstruct.results.contact_state`; dashes combine two states or more.
        ``"sliding"``: utilisation of sliding by :func:`blockstruct.results.utilisation`, with a separate colour from
        0.999. ``"crushing"``: the stress block that the normal force of a joint needs at its compressive
        strength, ``N / (f_c b)`` deep about the resultant; a lightly loaded hinge is a point.
    iteration
        Index from zero, or from the end if negative: numerical iterations, not steps of load.
    look
        ``"y"`` and ``"x"`` give elevations (seen from −y and from +x), ``"z"`` a plan, ``"3d"`` space in orthographic
        projection, and so do azimuth and elevation in degrees, as ``(-60, 25)``. By default an elevation of a thin
        structure that moves in its plane, and space otherwise, obliquely against the push.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError, UnknownNameError
        If neither model nor result is given, the result has no iterations, the iteration, colour or look is unknown, or
        stress blocks are asked for and no joint has a compressive strength.
    """
    colour = color or colour
    draw = {"state": _states, "sliding": _sliding, "crushing": _stress_blocks}
    bs.errors.check_known(colour, draw, "structure: colour")
    lines, handles, index = None, dict[str, Any](), -1
    if isinstance(shown, bs.Model):
        model = shown
    else:
        result = given_result(shown, "structure")
        index = chosen_iteration(result, iteration)
        lines, handles = draw[colour](result, index)
        model = result.model
    canvas = Canvas.of(shown, ax, look)
    canvas.bodies(canvas.solids.vertices, stones(model), lines)
    handles |= canvas.ties(shown, index)
    canvas.frame(canvas.solids.vertices)
    if colour == "sliding" and lines is not None:
        canvas.scale(ScalarMappable(Normalize(0, 1), _sliding_scale()), "utilisation of sliding [-]", extend="max")
    legend_above(canvas.ax, list(handles.values()), list(handles))
    return canvas.ax  # type: ignore[no-any-return]


def _edges(model: bs.Model) -> tuple[Array, Index]:
    """Return the ends (L, 2, 3) of the edges of all interfaces, m, and the interface (L,) of each."""
    polygons = [np.asarray(i.polygon) for i in model.interfaces]
    interface = np.repeat(np.arange(len(polygons)), [len(p) for p in polygons])
    return np.concatenate([np.stack([p, np.roll(p, -1, axis=0)], axis=1) for p in polygons]), interface


def _states(result: bs.CaseResult, iteration: int) -> tuple[Lines, dict[str, Any]]:
    ends, interface = _edges(result.model)
    states = shown_states(result, iteration)[interface]
    moving = sorted(set(states.tolist()) - {bs.vocabulary.ContactState.STICKING.value}, key=_rank)
    # Each line, once for every part of its state.
    drawn = [
        (line, part, _dash(k, len(style.parts(state))))
        for state in moving
        for k, part in enumerate(style.parts(state))
        for line in np.flatnonzero(states == state)
    ]
    line = np.array([line for line, _, _ in drawn], dtype=int)
    colours = to_rgba_array([style.STATE_COLOURS[part] for _, part, _ in drawn])
    handles = {state.replace(" + ", ", "): _handle(style.parts(state)) for state in moving}
    return Lines(ends[line], interface[line], colours, [dash for _, _, dash in drawn]), handles


def shown_states(result: bs.CaseResult, iteration: int) -> NDArray[Any]:
    """Return the states (I,) of the interfaces in an iteration."""
    return np.asarray(bs.results.contact_state(result.history.isel(iteration=[iteration])).to_numpy()[0])


def _rank(state: str) -> list[int]:
    order = list(style.STATE_COLOURS)
    return [len(style.parts(state)), *(order.index(p) for p in style.parts(state))]


def _dash(k: int, n: int) -> Any:
    return "-" if n == 1 else (k * _DASH, (_DASH, _DASH * (n - 1)))


def _handle(single: list[str]) -> Any:
    lines = tuple(
        Line2D([], [], color=style.STATE_COLOURS[p], lw=style.LINE, ls=_dash(k, len(single)), dash_capstyle="butt")
        for k, p in enumerate(single)
    )
    return lines if len(lines) > 1 else lines[0]


def _sliding_scale() -> LinearSegmentedColormap:
    return LinearSegmentedColormap.from_list("utilisation", style.UTILISATION).with_extremes(over=style.FORCE)  # type: ignore[return-value]


def _sliding(result: bs.CaseResult, iteration: int) -> tuple[Lines, dict[str, Any]]:
    ends, interface = _edges(result.model)
    used = bs.results.utilisation(result.history.isel(iteration=[iteration]))["sliding"].to_numpy()[0]
    full = used >= bs.results.FULLY_USED
    line = np.flatnonzero(np.isfinite(used[interface]))
    # Above the scale, the colour of full utilisation.
    colours = _sliding_scale()(np.where(full, 2.0, np.minimum(used, 1.0)))[interface[line]]
    handles = {f"fully used (≥ {bs.results.FULLY_USED})": Line2D([], [], color=style.FORCE, lw=style.LINE)}
    return Lines(ends[line], interface[line], colours, ["-"] * len(line)), handles if full.any() else {}


def _stress_blocks(result: bs.CaseResult, iteration: int) -> tuple[Lines, dict[str, Any]]:
    strength = np.array([i.joint_material.compressive_strength for i in result.model.interfaces])
    if not np.isfinite(strength).any():
        msg = (
            f"case {result.name!r}: no joint material has a compressive strength, so there is no stress block to draw; "
            "give the JointMaterial one, or choose another colour"
        )
        raise bs.errors.ModelError(msg)
    ends, interface = _edges(result.model)
    point, force = application_points(result, iteration)
    area = np.array([i.area for i in result.model.interfaces])
    share = np.einsum("ic,ic->i", force, result.history["interface_frame"].to_numpy()[:, 0]) / (strength * area)
    vector = np.diff(ends, axis=1)[:, 0]
    middle = np.einsum("lc,lc->l", point[interface] - ends[:, 0], vector) / np.linalg.norm(vector, axis=1) ** 2
    # The stress block is as wide as the joint, so its share of the area equals its share of the depth.
    span = np.clip(middle[:, None] + 0.5 * share[interface, None] * (-1, 1), 0, 1)
    line = np.flatnonzero(np.isfinite(middle) & (share[interface] > 0))
    bars = (ends[:, :1] + span[..., None] * vector[:, None])[line]
    crushes = np.array([bs.vocabulary.ContactState.CRUSHING in s for s in shown_states(result, iteration)], dtype=bool)
    colours = np.where(crushes[interface[line], None], to_rgba_array(style.FORCE), to_rgba_array(style.ACCENT))
    handles = {"stress block at $f_c$": Line2D([], [], color=style.ACCENT, lw=style.LINE)}
    if crushes.any():
        handles["of a joint that crushes"] = Line2D([], [], color=style.FORCE, lw=style.LINE)
    return Lines(bars, interface[line], colours, ["-"] * len(line)), handles


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
        # Such an edge points at the reader.
        if np.linalg.norm(ends[1] - ends[0]) < SMALL * size:
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
    bs.errors.check_known(colour, ("displacement", "macro-block"), "mechanism: colour")
    index = chosen_iteration(given_result(result, "mechanism"), iteration)
    solids = Solids.of(result.model)
    length = None if amplitude is None else si(amplitude, "length", "mechanism: amplitude")
    displacement = solids.displacement(result, index)
    if not np.isfinite(displacement).all():
        msg = (
            f"case {result.name!r}: no mechanism in iteration {index}, {result.status.words}; choose another iteration"
        )
        raise bs.errors.ModelError(msg)
    factor = style.AMPLITUDE * solids.size * solids.drawn_share(displacement) if length is None else length
    moved = solids.vertices + factor * displacement
    canvas = Canvas.of(result, ax, look)
    canvas.ghost()
    if colour == "displacement":
        canvas.bodies(moved, _by_displacement(canvas, displacement, factor))
    else:
        fill, handles = _by_body(result, index)
        canvas.bodies(moved, fill)
    canvas.ties(result, index, factor)
    drawn = _push(canvas, result, index, moved)
    canvas.frame(np.concatenate([solids.vertices, moved, drawn]))
    if colour == "macro-block":
        legend_above(canvas.ax, handles, [str(handle.get_label()) for handle in handles])
    return canvas.ax  # type: ignore[no-any-return]


def _by_displacement(canvas: Canvas, displacement: Array, amplitude: float) -> Array:
    """Return the colours (B, 4) of the blocks by mean displacement; draw their scale with the amplitude, m."""
    of_vertex, blocks = canvas.solids.block_of_vertex, canvas.model.blocks
    starts, counts = np.searchsorted(of_vertex, np.arange(len(blocks))), np.bincount(of_vertex)
    size = np.linalg.norm(np.add.reduceat(displacement, starts) / counts[:, None], axis=1)
    scale = LinearSegmentedColormap.from_list("displacement", style.DISPLACEMENT)
    share = size / max(size.max(), np.finfo(float).tiny)
    fixed = np.array([b.fixed for b in blocks])
    label = f"displacement, share of the largest [-]\nlargest translation drawn as {amplitude:.2g} m"
    canvas.scale(ScalarMappable(Normalize(0, 1), scale), label)
    return np.where(fixed[:, None], to_rgba_array(style.SUPPORT), scale(share))


def _by_body(result: bs.CaseResult, iteration: int) -> tuple[Array, list[Patch]]:
    """Return the colours (B, 4) of the blocks by macro-block, and the entries of a legend."""
    index, moving = moving_bodies(result, iteration)
    fill, palette = to_rgba_array(stones(result.model)), to_rgba_array(style.BODY_COLOURS)
    fill[index >= 0] = palette[index[index >= 0] % len(palette)]
    handles = [
        Patch(facecolor=colour, edgecolor=style.EDGE, label=f"{body.name}: {weight_text(body.total, body.carried)}")
        for body, colour in zip(moving, style.BODY_COLOURS, strict=False)
    ]
    if (more := len(moving) - len(handles)) > 0:
        handles.append(Patch(facecolor="none", edgecolor="none", label=f"and {more} more"))
    return fill, handles


def _push(canvas: Canvas, result: bs.CaseResult, iteration: int, moved: Array) -> Array:
    """Draw the load or the reaction with its size; return the ends of the arrow."""
    if bs.vocabulary.Stage(result.history["stage"].to_numpy()[iteration]).is_of_dead_load:
        return np.empty((0, 3))
    at, forces = driving(result)
    supports = result.case.supports if isinstance(result.case, bs.SettlementCase) else ()
    # A reaction acts against the motion of its support.
    direction = -push(result) if supports else push(result)
    text = _answer(result, iteration)
    size = float(np.ptp(moved, axis=0).max())
    length, gap = style.ARROW * size, 0.025 * size
    if np.linalg.norm(canvas.view.project(direction)) < 0.3:
        canvas.ax.set_title(text, fontsize="small", color=style.FORCE, loc="right")
        return np.empty((0, 3))
    weight = np.linalg.norm(forces, axis=1)
    centre = weight @ at / weight.sum()
    loads = () if supports else result.case.patterns[-1].loads
    if supports:
        moving = np.array([b.name in supports for b in result.model.blocks])
        of_supports = moving[canvas.solids.block_of_vertex]
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
    canvas.arrows(tail[None], length * direction[None], style.FORCE)
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
    canvas.text(beyond, text, color=style.FORCE, fontweight="bold", **align)
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
    bs.errors.check_known(at, ("interfaces", "contact points"), "forces: at")
    if at == "interfaces":
        points, force = application_points(result, index)
        acts = np.isfinite(points).all(axis=1)
    else:
        history = result.history.isel(iteration=index)
        points, force = history["contact_point_position"].to_numpy(), bs.results.contact_forces(history)
        acts = np.linalg.norm(force, axis=1) > bs.results.NO_FORCE * history["contact_force_unit"].to_numpy()
    if not acts.any():
        msg = f"case {result.name!r}: no forces in iteration {index}; choose another iteration"
        raise bs.errors.ModelError(msg)

    model = result.model
    canvas = Canvas.of(result, ax, look)
    solids = canvas.solids
    canvas.bodies(solids.vertices, [style.PALE_STONE] * len(model.blocks), edge=(style.PALE_EDGE, 0.4))
    if at == "interfaces":
        lines = canvas.view.project(_thrust_segments(model, points))
        # If few blocks have just two compressed joints, the segments do not form a line.
        if len(lines) >= sum(not b.fixed for b in model.blocks) / 2:
            canvas.add(LineCollection(list(lines), colors=style.ACCENT, linewidths=1.3))
    size = np.where(acts, np.linalg.norm(force, axis=1), 0.0)
    shown = np.flatnonzero(size > SMALL * size.max())
    shown = shown[np.argsort(size[shown])]
    canvas.ties(result, index)
    _tie_forces(canvas, result, index)
    scale = style.ARROW * solids.size / size.max()
    canvas.arrows(points[shown], force[shown] * scale, style.FORCE)
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
    right, up = 0.02 * canvas.solids.size * canvas.view.basis[:2]
    for ends, value in zip(TieLines.of(result.model).ends, force, strict=True):
        across, along = np.abs(canvas.view.project(ends[1] - ends[0]))
        away, place = (up, ("center", "bottom")) if across > along else (right, ("left", "center"))
        behind = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
        text = f"{value * factor:.3g} {unit}"
        canvas.text(ends.mean(axis=0) + away, text, color=style.TIE, ha=place[0], va=place[1], bbox=behind)


def _key(canvas: Canvas, points: Array, length: float, text: str) -> Array:
    """Draw an arrow with a round force above the structure; return its ends."""
    right, up = canvas.view.basis[:2]
    seen = canvas.view.project(points)
    high, size = seen.max(axis=0), float(np.ptp(seen, axis=0).max())
    tail = np.array([seen[:, 0].min(), high[1] + 0.07 * size]) @ canvas.view.basis[:2]
    canvas.arrows(tail[None], length * right[None], style.FORCE)
    canvas.text(tail + (length + 0.02 * size) * right, text, color=style.FORCE, ha="left", va="center")
    return np.array([tail, tail + length * right + 0.03 * size * up])


def _thrust_segments(model: bs.Model, points: Array) -> Array:
    """Return segments (S, 2, 3) between the two compressed points of every free block that has just two."""
    fixed = np.array([b.fixed for b in model.blocks])
    pressed = np.flatnonzero(np.isfinite(points).all(axis=1))
    blocks, interfaces = bs.results.block_pairs(model)[pressed].T.ravel(), np.tile(pressed, 2)
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
    canvas = Canvas.of(result, ax, look)
    solids = canvas.solids
    canvas.bodies(solids.vertices, [style.PALE_STONE] * len(model.blocks), edge=(style.PALE_EDGE, 0.4))
    drawn, handles = [solids.vertices], {}
    for arrows in load_arrows(result):
        colour, times = (style.FORCE, " × load factor") if arrows.grows else (style.ACCENT, "")
        vectors = arrows.force * (style.ARROW * solids.size / arrows.largest)
        tails = arrows.point - vectors
        canvas.arrows(tails, vectors, colour)
        drawn.append(tails)
        factor, unit = readable(np.array([arrows.largest]), "N")
        text = f"{verbatim(arrows.name)}: {arrows.total * factor:.4g} {unit}{times}"
        handles[text] = Line2D([], [], color=colour, lw=2)
    canvas.frame(np.concatenate(drawn))
    legend_above(canvas.ax, list(handles.values()), list(handles))
    return canvas.ax  # type: ignore[no-any-return]
