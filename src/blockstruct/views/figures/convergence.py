"""Load factor and certificate over the iterations."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

import blockstruct as bs
from blockstruct.units import readable
from blockstruct.views.figures.canvas import legend_above, new_axes
from blockstruct.views.selection import chosen_iteration, given_result
from blockstruct.views.style import ACCENT, FORCE, MEASURES

_MARKERS = {
    bs.vocabulary.Stage.DEAD_LOAD.value: "x",
    bs.vocabulary.Stage.DEAD_LOAD_COLLAPSE.value: "X",
    bs.vocabulary.Stage.LARGEST_REACTION.value: "v",
    bs.vocabulary.Stage.ASSOCIATIVE.value: "s",
    bs.vocabulary.Stage.NONASSOCIATIVE.value: "o",
    bs.vocabulary.Stage.ADMISSIBLE.value: "D",
    bs.vocabulary.Stage.SHIFTED.value: "^",
    bs.vocabulary.Stage.LOADING_PATH.value: ".",
}
#: Measures below this are drawn at this value, since their size is rounding.
_FLOOR = 1e-12
#: Relative difference of load factors below which they are drawn as level.
_LEAST_SPAN = 0.01


def convergence(result: bs.CaseResult, *, ax: Axes | None = None) -> Axes:
    """Draw the load factor, or reaction, of every iteration.

    A non-associative case also shows the load factor of its associative program, an upper bound, as a dashed line.

    Raises
    ------
    ModelError
        If no result is given, or the case has no iterations.
    """
    chosen_iteration(given_result(result, "convergence"))
    ax = new_axes(ax)
    answer = result.answer
    values = answer.factor * result.history["load_factor"].to_numpy()
    scale, unit = readable(values, answer.unit) if answer.is_reaction else (1.0, "-")
    values = scale * values
    stages = result.history["stage"].to_numpy()
    iterations = np.arange(len(values))
    ax.plot(iterations, values, color=ACCENT, lw=1, zorder=1)
    for stage in dict.fromkeys(stages.tolist()):
        at = stages == stage
        label = stage.replace("_", " ")
        ax.plot(iterations[at], values[at], _MARKERS[stage], color=ACCENT, ls="none", ms=5, label=label)
    bound = result.associative_load_factor
    if result.case.flow is bs.Flow.NONASSOCIATIVE and np.isfinite(bound):
        height, number = scale * answer.factor * bound, answer.text(bound)
        ax.axhline(height, color="0.35", lw=1, ls="--", label=f"associative bound {number}", zorder=0)
    if result.status is bs.Status.CONVERGED:
        found = result.load_factor
        height, number = scale * answer.factor * found, f"{answer.symbol} = {answer.text(found)}"
        ax.axhline(height, color=FORCE, lw=1, ls=":", label=f"certified, {number}", zorder=0)
    _iterations(ax, result)
    ax.set_ylabel(f"{answer.name} {answer.symbol} [{unit}]")
    ax.ticklabel_format(axis="y", useOffset=False)
    low, high = ax.get_ylim()
    # An unbounded case has no last load factor.
    least = _LEAST_SPAN * float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
    if high - low < least:
        ax.set_ylim((low + high - least) / 2, (low + high + least) / 2)
    legend_above(ax)
    return ax


def certificate(result: bs.CaseResult, *, ax: Axes | None = None) -> Axes:
    """Draw the certificate of every iteration, with its tolerances.

    Measures within rounding, and negative ones such as a yield excess inside the true conditions, lie at the lower end.

    Raises
    ------
    ModelError
        If no result is given, or the case has no iterations.
    """
    chosen_iteration(given_result(result, "certificate"))
    ax = new_axes(ax)
    history, settings = result.history, result.settings
    for name, (label, colour, marker) in MEASURES.items():
        values = np.maximum(history[name].to_numpy(), _FLOOR)
        ax.semilogy(values, color=colour, marker=marker, markersize=3.5, lw=1, label=label)
        is_gap = name == "flow_rule_gap"
        limit = history["flow_rule_gap_limit"][-1] if is_gap else getattr(settings.numerics, _tolerance(name))
        ax.axhline(float(limit), color=colour, lw=0.9, ls=(0, (5, 3)), zorder=0)
    _iterations(ax, result)
    ax.set_ylabel("certificate [-]")
    handles, labels = ax.get_legend_handles_labels()
    dashed = Line2D([], [], color="0.35", lw=0.9, ls=(0, (5, 3)))
    legend_above(ax, [*handles, dashed], [*labels, "tolerance of each"])
    return ax


def _tolerance(measure: str) -> str:
    return f"{measure.removesuffix('_residual').removesuffix('_excess')}_tolerance"


def _iterations(ax: Axes, result: bs.CaseResult) -> None:
    ax.set(xlabel="numerical iteration [-]", xlim=(-0.5, result.n_iterations - 0.5))
    # At least one tick: a single iteration has no two integers to show.
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
