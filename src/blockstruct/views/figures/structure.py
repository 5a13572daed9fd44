"""The structure, with joints coloured by state or utilisation, or with its overall dimensions."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgba_array
from matplotlib.lines import Line2D
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.arrays import Array, Index
from blockstruct.text.mechanism import SMALL
from blockstruct.views.figures.canvas import Canvas, Lines, legend_above, stones
from blockstruct.views.selection import application_points, chosen_iteration, given_result
from blockstruct.views.solids import Solids, View
from blockstruct.views.style import ACCENT, FORCE, LINE, STATE_COLOURS, UTILISATION, parts

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
    draw = {"state": _states, "sliding": _sliding, "crushing": _stress_blocks}.get(colour)
    if draw is None:
        msg = f"structure: colour {colour!r}; give 'state', 'sliding' or 'crushing'"
        raise bs.errors.ModelError(msg)
    lines, handles, index = None, dict[str, Any](), -1
    if isinstance(shown, bs.Model):
        model = shown
    else:
        result = given_result(shown, "structure")
        index = chosen_iteration(result, iteration)
        lines, handles = draw(result, index)
        model = result.model
    canvas = Canvas.of(shown, ax, look)
    solids = Solids.of(model)
    canvas.bodies(model, solids, solids.vertices, stones(model), lines)
    handles |= canvas.ties(shown, index)
    canvas.frame(solids.vertices)
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
        (line, part, _dash(k, len(parts(state))))
        for state in moving
        for k, part in enumerate(parts(state))
        for line in np.flatnonzero(states == state)
    ]
    line = np.array([line for line, _, _ in drawn], dtype=int)
    colours = to_rgba_array([STATE_COLOURS[part] for _, part, _ in drawn])
    handles = {state.replace(" + ", ", "): _handle(parts(state)) for state in moving}
    return Lines(ends[line], interface[line], colours, [dash for _, _, dash in drawn]), handles


def shown_states(result: bs.CaseResult, iteration: int) -> NDArray[Any]:
    """Return the states (I,) of the interfaces in an iteration."""
    return np.asarray(bs.results.contact_state(result.history.isel(iteration=[iteration])).to_numpy()[0])


def _rank(state: str) -> list[int]:
    order = list(STATE_COLOURS)
    return [len(parts(state)), *(order.index(p) for p in parts(state))]


def _dash(k: int, n: int) -> Any:
    return "-" if n == 1 else (k * _DASH, (_DASH, _DASH * (n - 1)))


def _handle(single: list[str]) -> Any:
    lines = tuple(
        Line2D([], [], color=STATE_COLOURS[p], lw=LINE, ls=_dash(k, len(single)), dash_capstyle="butt")
        for k, p in enumerate(single)
    )
    return lines if len(lines) > 1 else lines[0]


def _sliding_scale() -> LinearSegmentedColormap:
    return LinearSegmentedColormap.from_list("utilisation", UTILISATION).with_extremes(over=FORCE)  # type: ignore[return-value]


def _sliding(result: bs.CaseResult, iteration: int) -> tuple[Lines, dict[str, Any]]:
    ends, interface = _edges(result.model)
    used = bs.results.utilisation(result.history.isel(iteration=[iteration]))["sliding"].to_numpy()[0]
    full = used >= bs.results.FULLY_USED
    line = np.flatnonzero(np.isfinite(used[interface]))
    # Above the scale, the colour of full utilisation.
    colours = _sliding_scale()(np.where(full, 2.0, np.minimum(used, 1.0)))[interface[line]]
    handles = {f"fully used (≥ {bs.results.FULLY_USED})": Line2D([], [], color=FORCE, lw=LINE)} if full.any() else {}
    return Lines(ends[line], interface[line], colours, ["-"] * len(line)), handles


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
    colours = np.where(crushes[interface[line], None], to_rgba_array(FORCE), to_rgba_array(ACCENT))
    handles = {"stress block at $f_c$": Line2D([], [], color=ACCENT, lw=LINE)}
    if crushes.any():
        handles["of a joint that crushes"] = Line2D([], [], color=FORCE, lw=LINE)
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
