"""Diagrams of one result: its iterations, its certificate, its curve, its response, its check."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

import blockstruct as bs
from blockstruct.units import readable
from blockstruct.views.figures.canvas import legend_above, new_axes, verbatim
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
#: Height of the drawn ground acceleration, relative to the largest displacement.
_GROUND = 0.25
#: Longest drawn period of a demand, relative to the last limit state; largest drawn acceleration, relative to the
#: largest of the capacity curve.
_BEYOND, _TALLEST = 1.3, 6.0


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
        alpha = result.load_factor
        height, number = scale * answer.factor * alpha, f"{answer.symbol} = {answer.text(alpha)}"
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


def response(result: bs.CaseResult, *, block: str = "", ax: Axes | None = None) -> Axes:
    """Draw the displacement of a block relative to the ground over time.

    The component is the one along which the block moves furthest. The acceleration of the ground in the same direction
    is drawn in grey, without a scale. A dotted line marks the time of collapse.

    Parameters
    ----------
    result
        The result of a :class:`~blockstruct.RecordCase`.
    block
        Name of the block; by default the one with the largest displacement.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError
        If the result has no response.
    UnknownNameError
        If the model does not have the block.
    """
    moved = given_result(result, "response").response
    if moved is None:
        msg = f"case {result.name!r}: no response, {result.headline}; run a RecordCase that stands under its dead load"
        raise bs.errors.ModelError(msg)
    names = moved["block"].to_numpy().tolist()
    if block and block not in names:
        msg = f"response: no block {block!r} in model {result.model.name!r}"
        raise bs.errors.UnknownNameError(msg)
    chosen = names.index(block) if block else int(moved["peak_displacement"].isel(time=-1).to_numpy().argmax())
    displacement = moved["displacement"].isel(block=chosen).to_numpy()
    axis = int(np.abs(displacement).max(axis=0).argmax())
    time, factor, unit = moved["time"].to_numpy(), *_readable(displacement)
    ax = new_axes(ax)
    ground = result.case.ground[:, axis] if isinstance(result.case, bs.RecordCase) else np.zeros(1)
    if np.abs(ground).max() > 0 and isinstance(result.case, bs.RecordCase):
        height = _GROUND * np.abs(displacement).max() * factor / np.abs(ground).max()
        ax.plot(result.case.times, ground * height, color="0.75", lw=0.6, label="ground acceleration, no scale")
    name = verbatim(names[chosen])
    ax.plot(time, displacement[:, axis] * factor, color=ACCENT, lw=1.2, label=f"displacement of {name}")
    if np.isfinite(result.collapse_time):
        ax.axvline(result.collapse_time, color=FORCE, lw=0.8, ls=":", label="collapse")
    ax.set(xlabel="time [s]", ylabel=f"displacement along {'xyz'[axis]} [{unit}]")
    legend_above(ax)
    return ax


def _readable(values: np.ndarray) -> tuple[float, str]:
    """Return the factor and unit of displacements: millimetres below one metre."""
    return (1e3, "mm") if np.abs(values).max() < 1 else readable(values, "m")


def verification(check: bs.assess.LocalMechanismCheck, *, ax: Axes | None = None) -> Axes:
    """Draw the capacity curve, its limit states, and the spectrum at SLV.

    The spectrum has the damping of the mechanism at SLV. The ray of the equivalent period meets it at the
    demand, to compare with the displacement at SLV.

    Parameters
    ----------
    check
        A check with a capacity curve.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError
        If the mechanism has no capacity curve.
    """
    curve = check.curve
    state = check.limit_states.get("SLV, by displacement")
    if curve is None or state is None:
        msg = f"case {check.result.name!r}: {check.missing_curve or 'no check by displacement'}; there is none to draw"
        raise bs.errors.ModelError(msg)
    axes, c = new_axes(ax), check.coefficients
    axes.plot(curve.displacement, curve.acceleration, color=ACCENT, label="capacity a(d)")
    T = c.slv_period * np.pi * np.sqrt(state.capacity / curve.at(state.capacity))
    periods = np.linspace(0.02 * T, _BEYOND * T, 400)
    try:
        demand = check.spectrum.displacement(periods, c.slv_damping)
    except bs.errors.ModelError:
        # A table may end before this period.
        periods = np.linspace(0.02 * T, T, 400)
        demand = check.spectrum.displacement(periods, c.slv_damping)
    spectral = demand * (2 * np.pi / periods) ** 2
    axes.plot(demand, spectral, color=FORCE, label=f"demand, ξ = {100 * c.slv_damping:g} %")
    ray = np.array([0.0, max(state.capacity, state.demand)])
    axes.plot(ray, ray * (2 * np.pi / T) ** 2, color="0.6", lw=0.8, label=f"T = {T:.3g} s")
    axes.plot(state.demand, state.demand * (2 * np.pi / T) ** 2, "o", color=FORCE, ms=5)
    for name, marker in (("SLV", "o"), ("SLC", "s")):
        other = check.limit_states.get(f"{name}, by displacement")
        if other is not None:
            d = other.capacity
            axes.plot(d, curve.at(d), marker, color=ACCENT, ms=5, label=f"{name}: d = {d:.3g} m")
    axes.axvline(state.capacity, color=ACCENT, lw=0.8, ls=":")
    axes.axvline(state.demand, color=FORCE, lw=0.8, ls=":")
    # A larger demand at short periods would leave no room for the curve.
    top = min(1.05 * spectral.max(), _TALLEST * curve.acceleration.max())
    axes.set(
        xlabel="spectral displacement d [m]", ylabel="spectral acceleration a [m/s²]", xlim=(0, None), ylim=(0, top)
    )
    legend_above(axes)
    return axes
