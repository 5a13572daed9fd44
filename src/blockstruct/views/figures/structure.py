"""The structure, with its interfaces coloured by what they do."""

from collections import defaultdict
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.lines import Line2D
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.views.figures.canvas import Canvas
from blockstruct.views.selection import chosen_iteration, same_model
from blockstruct.views.solids import Solids
from blockstruct.views.style import STATE_COLOURS, UTILISATION, parts

Array = NDArray[np.float64]

_DASH = 3.0
_UTILISATION = LinearSegmentedColormap.from_list("utilisation", UTILISATION)


def structure(
    model: bs.Model,
    result: bs.CaseResult | None = None,
    *,
    colour: str = "state",
    iteration: int = -1,
    look: str = "y",
    ax: Axes | None = None,
) -> Axes:
    """Draw a structure; with a result, its interfaces in the colour of their state or utilisation.

    Parameters
    ----------
    model
        The structure.
    result
        A case of it; None draws the blocks alone.
    colour
        ``"state"``; or ``"sliding"`` or ``"crushing"`` for the utilisation, 0 to 1, by
        :func:`blockstruct.utilisation`. Interfaces that combine states are dashed in their colours.
    iteration
        Index from zero, or from the end if negative.
    look
        Along which axis one looks: ``"y"`` and ``"x"`` give elevations (seen from −y and from +x), ``"z"`` a plan,
        ``"3d"`` space.
    ax
        Axes to draw on, of projection ``"3d"`` for that look.

    Raises
    ------
    ModelError, UnknownNameError
        A result of another model or without iterations, an unknown iteration, colour or look.
    """
    if colour not in ("state", "sliding", "crushing"):
        msg = f"structure: colour {colour!r}; give 'state', 'sliding' or 'crushing'"
        raise bs.ModelError(msg)
    history = None
    if result is not None:
        same_model(model, result)
        history = result.history.isel(iteration=[chosen_iteration(result, iteration)])
    canvas = Canvas.of(ax, look)
    solids = Solids.of(model)
    # In space the blocks would hide their joints.
    ghost = history is not None and not canvas.flat
    canvas.bodies(solids, [b.fixed for b in model.blocks], solids.vertices, ghost=ghost)
    if history is not None:
        polygons = [np.asarray(i.polygon) for i in model.interfaces]
        if colour == "state":
            _states(canvas, polygons, bs.contact_state(history).to_numpy()[0])
        else:
            _utilisation(canvas, polygons, bs.utilisation(history)[colour].to_numpy()[0], colour)
    canvas.frame(solids.vertices)
    return canvas.ax  # type: ignore[no-any-return]


def _states(canvas: Canvas, polygons: list[Array], states: NDArray[Any]) -> None:
    groups = defaultdict(list)
    for polygon, state in zip(polygons, states.tolist(), strict=True):
        groups[state].append(polygon)
    seen = set()
    for state, members in groups.items():
        single = parts(state)
        # A face in space has one colour: that of the gravest of its states.
        seen.update(single if canvas.flat else single[:1])
        if not canvas.flat:
            quiet = single[0] == bs.ContactState.STICKING
            canvas.polygons(members, facecolors=STATE_COLOURS[single[0]], linewidths=0, alpha=0.25 if quiet else 0.9)
            continue
        for k, part in enumerate(single):
            quiet = part == bs.ContactState.STICKING
            dashes: Any = "-" if len(single) == 1 else (k * _DASH, (_DASH, _DASH * (len(single) - 1)))
            canvas.polygons(
                members,
                facecolors="none",
                edgecolors=STATE_COLOURS[part],
                linewidths=0.6 if quiet else 1.8,
                linestyles=[dashes],
                zorder=2 if quiet else 3,
                capstyle="butt",
            )
    handles = [Line2D([], [], color=c, lw=2, label=s) for s, c in STATE_COLOURS.items() if s in seen]
    canvas.ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1, 1), frameon=False, fontsize="small")


def _utilisation(canvas: Canvas, polygons: list[Array], values: Array, kind: str) -> None:
    shown = np.flatnonzero(np.isfinite(values))
    style: dict[str, Any] = {"array": values[shown], "cmap": _UTILISATION, "clim": (0, 1)}
    if canvas.flat:
        style |= {"facecolors": "none", "linewidths": 1.8, "zorder": 3}
    drawn = canvas.polygons([polygons[i] for i in shown], **style)
    canvas.ax.figure.colorbar(drawn, ax=canvas.ax, shrink=0.7, label=f"utilisation of {kind} [-]")
