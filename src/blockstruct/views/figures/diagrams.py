"""Diagrams of one result: its iterations, its certificate, its curve, its response, its check, its crushing."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

import blockstruct as bs
from blockstruct.arrays import ROUNDING, Array
from blockstruct.text.note import EFFECT
from blockstruct.units import readable
from blockstruct.views.figures.canvas import legend_above, new_axes, next_colour, verbatim
from blockstruct.views.selection import chosen_interface, chosen_iteration, given_result
from blockstruct.views.style import ACCENT, FORCE, MEASURES
from blockstruct.views.words import without_curve_words
from blockstruct.vocabulary import FEW, listed


def capacity(result: bs.CaseResult, *, label: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw the load factor of a pushover, or the reaction of a settlement, over the displacement.

    The axis names the block of the control point, or the supports. The line falls at tie breaks, which dotted lines
    mark. States whose certificate does not hold are drawn as crosses. ``d0`` is marked: the displacement at which the
    load factor is zero, or the largest one of the supports before blocks fall. If the curve ends before, the last
    state is, with a ring.

    Parameters
    ----------
    result
        The result of a :class:`~blockstruct.Pushover`, or a :class:`~blockstruct.SettlementCase` with a displacement.
    label
        Name in the legend, for several curves on one Axes.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError
        If the result has no capacity curve.
    """
    curve = given_result(result, "capacity").capacity
    if curve is None or not bs.model.has_curve(result.case):
        msg = f"case {result.name!r}: {without_curve_words(result)}"
        raise bs.errors.ModelError(msg)
    settles = result.answer.is_reaction
    if settles:
        # A fall has no reaction of its own.
        curve = curve.isel(step=curve["falls"].to_numpy() == 0)
    displacement, values = (
        curve[name].to_numpy() for name in ("displacement", "reaction" if settles else "load_factor")
    )
    scale, value_unit = readable(values, "N") if settles else (1.0, "-")
    values = values * scale
    holds = curve["holds"].to_numpy() > 0
    factor, unit = readable(displacement, "m")
    ax = new_axes(ax)
    colour = next_colour(ax)
    ax.plot(displacement * factor, values, "-", color=colour, lw=1.2, label=label)
    ax.plot(displacement[holds] * factor, values[holds], "o", color=colour, ms=3)
    ax.plot(displacement[~holds] * factor, values[~holds], "x", color=FORCE, ms=5)
    d0 = float(curve["d0"])
    if np.isfinite(d0):
        ax.annotate(
            f"d0 = {d0 * factor:.4g} {unit}",
            (d0 * factor, 0.0),
            (0, -4),
            textcoords="offset points",
            ha="right",
            va="top",
        )
        if settles:
            ax.axvline(d0 * factor, color=FORCE, lw=0.8, ls="--", zorder=0)
    else:
        ax.plot(displacement[-1:] * factor, values[-1:], "o", mfc="none", mec=FORCE, ms=9)
    broken = result.broken_ties
    for at in broken["displacement [meter]"].unique().tolist():
        names = broken.index[broken["displacement [meter]"] == at]
        ax.axvline(at * factor, color=FORCE, lw=0.8, ls=":", zorder=0)
        label_of_break = f"{verbatim(names[0])} breaks" if len(names) == 1 else f"{len(names)} ties break"
        ax.annotate(
            label_of_break,
            (at * factor, 1.0),
            (3, -4),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            va="top",
            color=FORCE,
        )
    ax.axhline(0.0, color="0.7", lw=0.8, zorder=0)
    if isinstance(result.case, bs.SettlementCase):
        what, ylabel = listed(result.case.supports, FEW), f"reaction R [{value_unit}]"
    else:
        what, ylabel = result.case.control[0], "load factor α [-]"
    ax.set(xlabel=f"displacement of {verbatim(what)} [{unit}]", ylabel=ylabel)
    # From zero, with room for a text below it.
    ax.update_datalim([(0.0, -0.06 * values.max())])
    ax.autoscale_view()
    if label:
        legend_above(ax)
    return ax


def crushing_domain(
    result: bs.CaseResult, interface: str, *, about: str = "s", iteration: int = -1, ax: Axes | None = None
) -> Axes:
    """Draw the N–M domain of an interface that crushes, and its iterations.

    The boundary belongs to a rectangular stress block of the compressive strength on one side of a neutral axis
    parallel to ``about``, and the tensile strength on the other. For a rectangle without tensile strength it is ``|M| =
    (N b / 2) (1 − N / (f_c A))``, which is the condition itself with the uniaxial interaction. That limits bending
    about each axis separately, so the other axis may be the one that crushes. With the biaxial interaction, and for
    joints in cells, bending about the other axis makes the domain smaller than drawn. The title therefore states the
    utilisation of crushing, and any bending about the other axis.

    Parameters
    ----------
    result
        The result of a case.
    interface
        Name of the interface.
    about
        Axis of the bending moment, ``"s"`` or ``"t"`` of the interface's frame.
    iteration
        The marked iteration; earlier ones are drawn as a path.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError
        If the joint material of the interface has no compressive strength, the axis is unknown, or the case has no
        iterations.
    UnknownNameError
        If the interface or the iteration is unknown.
    """
    model = given_result(result, "crushing_domain").model
    k = chosen_interface(model, interface)
    last = chosen_iteration(result, iteration)
    bs.errors.check_known(about, ("s", "t"), "crushing_domain: about")
    joint = model.interfaces[k]
    strength, tension = joint.joint_material.compressive_strength, joint.joint_material.tensile_strength
    if not np.isfinite(strength):
        msg = (
            f"interface {interface!r}: its joint material {joint.joint_material.name!r} has no compressive strength, "
            "so there is no crushing domain; give the JointMaterial one, or choose another interface"
        )
        raise bs.errors.ModelError(msg)

    frame = result.history["interface_frame"].to_numpy()[k]
    plane = (np.asarray(joint.polygon) - joint.centroid) @ frame[1:].T
    # A pressure p at (s, t) has the moments t p about s and −s p about t.
    plane = plane if about == "s" else plane[:, ::-1] * (1, -1)
    # The tensile strength acts on the whole area, without a moment, and both strengths together beyond the neutral
    # axis.
    N, M = stress_blocks(plane, strength + tension)
    N = N - tension * joint.area
    resultants = result.resultants.isel(interface=k)
    force = resultants["force"].sel(component="n").to_numpy()[: last + 1]
    moment = resultants["moment"].sel(component=about).to_numpy()[: last + 1]

    ax = new_axes(ax)
    n_factor, n_unit = readable(N, "N")
    m_factor, m_unit = readable(M, "N·m")
    ax.fill(N * n_factor, M * m_factor, facecolor="0.95", edgecolor="0.35", lw=1)
    ax.plot(force * n_factor, moment * m_factor, ".-", color=ACCENT, lw=0.8, ms=4, label="iterations")
    ax.plot(force[-1] * n_factor, moment[-1] * m_factor, "D", color=FORCE, ms=6, label=f"iteration {last}")
    ax.margins(0.08)
    ax.set(xlabel=f"N [{n_unit}]", ylabel=f"M about {about} [{m_unit}]")
    ax.set_title(_title(result, k, last, "t" if about == "s" else "s"), fontsize="small", loc="left")
    # The domain has points at both ends, so its corners are free.
    ax.legend(frameon=False, fontsize="small", loc="upper left")
    return ax


def _title(result: bs.CaseResult, k: int, iteration: int, other: str) -> str:
    """Return the utilisation of the interface, and its bending about the other axis.

    Bending is left out if its eccentricity is below a thousandth of the square root of the area.
    """
    history = result.history.isel(iteration=[iteration])
    name = verbatim(str(history["interface"].to_numpy()[k]))
    used = float(bs.results.utilisation(history)["crushing"].isel(iteration=0, interface=k))
    if math.isnan(used):
        return f"{name}\nnot pressed"
    lines = [name, f"utilisation of crushing {used:.2f}"]
    last = bs.results.interface_resultants(history).isel(iteration=0, interface=k)
    force, moment = float(last["force"].sel(component="n")), abs(float(last["moment"].sel(component=other)))
    if moment / force > 1e-3 * math.sqrt(float(history["interface_area"].to_numpy()[k])):
        factor, unit = readable(moment, "N·m")
        points = history["interface_of_contact_point"].to_numpy() == k
        in_cells = np.isfinite(history["cell_strength"].to_numpy()[points]).all()
        reduced = in_cells or result.settings.crushing_interaction == "biaxial"
        lines.append(f"{moment * factor:.3g} {unit} about {other}" + (" reduces the domain" if reduced else ""))
    return "\n".join(lines)


def stress_blocks(polygon: Array, strength: float) -> tuple[Array, Array]:
    """Return normal forces and moments of stress blocks, around the domain.

    Parameters
    ----------
    polygon : (k, 2) array
        Corners about the centroid, m; the moment is the force times their second coordinate.
    strength
        Pa.
    """
    area, static = bs.results.parts_beyond(polygon, np.array([0.0, 1.0]), np.linspace(1, 0))
    # From the whole interface to its upper edge, and back along the lower one.
    rest_area, rest_static = area[0] - area, static[0] - static
    return strength * np.concatenate([area, rest_area]), strength * np.concatenate([static, rest_static])


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
#: Largest drawn acceleration of a demand, relative to the largest of the capacity curve.
_TALLEST = 6.0


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
    least = EFFECT * float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
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
        values = np.maximum(history[name].to_numpy(), ROUNDING)
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
    if block:
        bs.errors.check_known(block, names, "response: no block")
    chosen = names.index(block) if block else int(moved["peak_displacement"].isel(time=-1).to_numpy().argmax())
    displacement = moved["displacement"].isel(block=chosen).to_numpy()
    axis = int(np.abs(displacement).max(axis=0).argmax())
    time = moved["time"].to_numpy()
    factor, unit = (1e3, "mm") if np.abs(displacement).max() < 1 else readable(displacement, "m")
    ax = new_axes(ax)
    ground = result.case.ground[:, axis] if isinstance(result.case, bs.RecordCase) else np.zeros(1)
    if np.abs(ground).max() > 0 and isinstance(result.case, bs.RecordCase):
        height = np.abs(displacement).max() * factor / np.abs(ground).max()
        ax.plot(result.case.times, ground * height, color="0.75", lw=0.6, label="ground acceleration, no scale")
    name = verbatim(names[chosen])
    ax.plot(time, displacement[:, axis] * factor, color=ACCENT, lw=1.2, label=f"displacement of {name}")
    if np.isfinite(result.collapse_time):
        ax.axvline(result.collapse_time, color=FORCE, lw=0.8, ls=":", label="collapse")
    ax.set(xlabel="time [s]", ylabel=f"displacement along {'xyz'[axis]} [{unit}]")
    legend_above(ax)
    return ax


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
