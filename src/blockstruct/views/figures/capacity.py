"""The capacity curve of a pushover or a settlement."""

import numpy as np
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct.units import readable
from blockstruct.views.figures.canvas import legend_above, new_axes, next_colour, verbatim
from blockstruct.views.selection import given_result
from blockstruct.views.style import FORCE
from blockstruct.views.words import without_curve_words
from blockstruct.vocabulary import listed


def capacity(result: bs.CaseResult, *, label: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw the load factor of a pushover, or the reaction of a settlement, over the displacement.

    The line falls at tie breaks, which dotted lines mark. States whose certificate does not hold are drawn
    as crosses. ``d0`` is marked: the displacement at which the load factor is zero, or the largest one of the supports
    before blocks fall. If the curve ends before, the last state is, with a ring.

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
        what, ylabel = listed(result.case.supports, 3), f"reaction R [{value_unit}]"
    else:
        what, ylabel = f"the control point on {result.case.control[0]}", "load factor α [-]"
    ax.set(xlabel=f"displacement of {verbatim(what)} [{unit}]", ylabel=ylabel)
    # From zero, with room for a text below it.
    ax.update_datalim([(0.0, -0.06 * values.max())])
    ax.autoscale_view()
    if label:
        legend_above(ax)
    return ax
