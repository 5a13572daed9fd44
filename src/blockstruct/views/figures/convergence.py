"""Load factor and certificate over the iterations."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

import blockstruct as bs
from blockstruct.views.figures.canvas import new_axes
from blockstruct.views.selection import chosen_iteration
from blockstruct.views.style import ACCENT, MEASURES

_MARKERS = {
    bs.Stage.DEAD_LOAD.value: "x",
    bs.Stage.ASSOCIATIVE.value: "s",
    bs.Stage.NONASSOCIATIVE.value: "o",
    bs.Stage.ADMISSIBLE.value: "D",
    bs.Stage.SHIFTED.value: "^",
}
#: Measures below this are drawn here: rounding has no size.
_FLOOR = 1e-16
#: Load factors that differ by less, relatively, are drawn as level.
_LEAST_SPAN = 0.01


def convergence(result: bs.CaseResult, *, ax: Axes | None = None) -> Axes:
    """Draw the load factor of every iteration, by the stage of its program.

    Raises
    ------
    ModelError
        A case without iterations.
    """
    chosen_iteration(result)
    ax = new_axes(ax)
    load_factor = result.history["load_factor"].to_numpy()
    stages = result.history["stage"].to_numpy()
    iterations = np.arange(len(load_factor))
    ax.plot(iterations, load_factor, color=ACCENT, lw=1, zorder=1)
    for stage in dict.fromkeys(stages.tolist()):
        at = stages == stage
        label = stage.replace("_", " ")
        ax.plot(iterations[at], load_factor[at], _MARKERS[stage], color=ACCENT, ls="none", ms=5, label=label)
    _iterations(ax, result)
    ax.set_ylabel("load factor α [-]")
    ax.ticklabel_format(axis="y", useOffset=False)
    low, high = ax.get_ylim()
    # An unbounded case has no last load factor.
    least = _LEAST_SPAN * float(np.abs(load_factor[np.isfinite(load_factor)]).max(initial=0.0))
    if high - low < least:
        ax.set_ylim((low + high - least) / 2, (low + high + least) / 2)
    ax.legend(frameon=False, fontsize="small")
    return ax


def certificate(result: bs.CaseResult, *, ax: Axes | None = None) -> Axes:
    """Draw the four measures of the certificate of every iteration, on a logarithmic scale.

    A yield excess that is negative, inside the true conditions, is drawn at the lower end.

    Raises
    ------
    ModelError
        A case without iterations.
    """
    chosen_iteration(result)
    ax = new_axes(ax)
    for name, (label, colour, marker) in MEASURES.items():
        values = np.maximum(result.history[name].to_numpy(), _FLOOR)
        ax.semilogy(values, color=colour, marker=marker, markersize=3.5, lw=1, label=label)
    _iterations(ax, result)
    ax.set_ylabel("certificate [-]")
    ax.legend(frameon=False, fontsize="small", loc="upper left", bbox_to_anchor=(1, 1))
    return ax


def _iterations(ax: Axes, result: bs.CaseResult) -> None:
    ax.set(xlabel="iteration [-]", xlim=(-0.5, result.n_iterations - 0.5))
    # At least one tick: of a single iteration there are no two integers to show.
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
