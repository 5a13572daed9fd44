"""Figures of many analyses: compass, curves over a parameter, samples, collapses, first-order scatter."""

import math
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

import blockstruct as bs
from blockstruct.text.mechanism import SMALL
from blockstruct.units import readable, short_unit
from blockstruct.views.console import out_of_the_ordinary
from blockstruct.views.figures.canvas import legend_above, new_axes, next_colour, verbatim
from blockstruct.views.style import ACCENT, FORCE, GHOST

_SHORT = {"pascal": "Pa", "newton": "N", "meter": "m", "radian": "rad"}
_SYMBOLS = {"compressive_strength": "compressive strength f_c", "friction_coefficient": "friction coefficient μ"}


def compass(around: "bs.studies.Directions | bs.Analysis", *, label: str | None = None, ax: Any = None) -> Axes:
    """Draw load factors around the compass, with the governing direction.

    Lines join the points if no direction between them is below (:attr:`blockstruct.studies.Directions.is_convex`).
    The load factor of a hollow point has not settled.

    Parameters
    ----------
    around
        Directions, or an analysis with directions.
    label
        Name in the legend, for several structures on one Axes.
    ax
        Polar Axes to draw on.

    Raises
    ------
    ModelError
        If the analysis has no directions, or the Axes are not polar.
    """
    directions = bs.studies.Directions.of(around) if isinstance(around, bs.Analysis) else around
    if ax is None:
        ax = plt.figure(layout="constrained").add_subplot(projection="polar")
    if ax.name != "polar":
        msg = f"compass: Axes of projection {ax.name!r}; give polar ones, add_subplot(projection='polar')"
        raise bs.errors.ModelError(msg)
    angle = np.radians(directions.data["direction"].to_numpy())
    alpha = directions.data["load_factor"].to_numpy()
    drawn = np.where(np.isfinite(alpha), alpha, np.nan)
    colour = next_colour(ax)
    # A direction without a load factor leaves a gap in the line.
    joined = "-" if directions.is_convex else "none"
    # The line does not cross half a turn without directions.
    wide = np.flatnonzero(directions.half_turns) + 1
    turn = np.insert(np.append(angle, angle[0] + 2 * math.pi), wide, np.nan)
    ends = np.insert(np.append(drawn, drawn[0]), wide, np.nan)
    ax.plot(turn, ends, marker="o", ls=joined, color=colour, ms=4, lw=1.2, label=label)
    hollow = np.isfinite(drawn) & ~directions.data["settled"].to_numpy()
    if hollow.any():
        ax.scatter(angle[hollow], drawn[hollow], s=16, facecolors="white", edgecolors=colour, zorder=3)
    if not math.isnan(directions.load_factor) and math.isfinite(directions.load_factor):
        at = math.radians(directions.governing_direction)
        style = {"arrowstyle": "-|>", "color": FORCE, "lw": 1.5, "shrinkA": 0, "shrinkB": 3}
        ax.annotate("", (at, directions.load_factor), (0, 0), arrowprops=style)
    most = np.nanmax(drawn, initial=0.0)
    ax.set_rlim(0, max(1.08 * most, ax.get_ylim()[1] if len(ax.get_lines()) > 1 else 0.0) or 1.0)
    ax.yaxis.set_major_locator(MaxNLocator(4))
    ax.set_rlabel_position(22.5)
    ax.set_xticks(np.radians(np.arange(0, 360, 45)), ["+x", "45°", "+y", "135°", "−x", "225°", "−y", "315°"])
    ax.tick_params(labelsize="small")
    governing = f"α = {directions.load_factor:.4g} at {directions.governing_direction:g}°"
    missing = f", {len(directions.without_load_factor)} not known" if directions.without_load_factor else ""
    lines = [("no load factor" if math.isnan(directions.load_factor) else governing) + missing]
    lines += ["hollow: NOT SETTLED"] if hollow.any() else []
    lines += [] if directions.is_covered else ["directions between the points are not covered"]
    ax.set_title("\n".join(lines), fontsize="small")
    if label:
        ax.legend(frameon=False, fontsize="small", loc="lower left", bbox_to_anchor=(0.95, 0.9))
    return ax  # type: ignore[no-any-return]


def tornado(scatter: xr.Dataset, *, most: int = 12, ax: Axes | None = None) -> Axes:
    """Draw the effect of each joint's friction on the load factor, largest first.

    Parameters
    ----------
    scatter
        Result of :func:`blockstruct.studies.first_order`.
    most
        Largest number of joints.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError
        If the data are not such a result.
    """
    if "contribution" not in scatter:
        msg = "tornado: no contributions; give what bs.studies.first_order returns"
        raise bs.errors.ModelError(msg)
    ax = new_axes(ax)
    size = np.abs(scatter["contribution"].to_numpy())
    shown = scatter.isel(interface=slice(0, min(most, int((size > SMALL * size.max(initial=0.0)).sum()))))
    alpha, change = float(scatter["load_factor"]), shown["contribution"].to_numpy()
    rows = np.arange(len(change))
    ax.barh(rows, change, left=alpha, height=0.7, color=ACCENT, label="μ + σ")
    ax.barh(rows, -change, left=alpha, height=0.7, color=FORCE, label="μ − σ")
    ax.axvline(alpha, color="0.2", lw=0.8)
    ax.set_yticks(rows, [verbatim(name) for name in shown["interface"].to_numpy()], fontsize="small")
    ax.invert_yaxis()
    ax.set(xlabel="load factor α [-], to first order")
    ax.spines[["top", "right"]].set_visible(False)
    title = f"standard deviation of α: {float(scatter['independent']):.2g} if joints are independent,\n"
    title += f"{float(scatter['correlated']):.2g} if joints of one material are equal"
    if not scatter.attrs["unique"]:
        title += "\nseveral mechanisms have this load factor: these are not derivatives"
    ax.set_title(title, fontsize="small", loc="left", pad=22)
    legend_above(ax)
    return ax


def distribution(data: xr.Dataset, case: str | None = None, *, confidence: float = 0.9, ax: Axes | None = None) -> Axes:
    """Draw the distribution of load factors of a study, and its fractiles.

    The shares leave out runs without a load factor. The title counts them, and unsettled runs.

    Parameters
    ----------
    data
        A study of distributions.
    case
        Name of the case; the only one otherwise.
    confidence
        See :func:`blockstruct.studies.summary`.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError
        If the study has no samples, or several cases and none is named.
    UnknownNameError
        If it has no such case.
    """
    names = data["case"].to_numpy().tolist()
    if case is None and len(names) != 1:
        msg = f"distribution: the study has the cases {', '.join(map(repr, names)) or 'none'}; name one, case=…"
        raise bs.errors.ModelError(msg)
    if case is not None:
        bs.errors.check_known(case, names, "distribution: no case")
    chosen = data.sel(case=[case or names[0]])
    summary = bs.studies.summary(chosen, confidence=confidence).isel(case=0)
    status = chosen["status"].to_numpy().ravel()
    values = np.sort(chosen["load_factor"].to_numpy().ravel()[status == bs.Status.CONVERGED])
    known = len(status) - int(summary["unknown"])
    below = (np.arange(len(values)) + 1 + int(summary["unstable"])) / max(known, 1)
    ax = new_axes(ax)
    ax.step(values, below, where="post", color=ACCENT, lw=1.2, label="runs")
    ends = values[[0, -1]] if len(values) else np.array([0.0, 1.0])
    low, high = (summary[name].to_numpy() for name in ("lower", "upper"))
    label = f"{confidence:.0%} confidence of the fractile"
    ax.hlines(summary["fractile"], np.clip(low, *ends), np.clip(high, *ends), color=FORCE, lw=3, label=label)
    for bound, marker, end in ((low, "<", ends[0]), (high, ">", ends[1])):
        # An arrow shows that there are too few runs for a bound.
        open_ended = summary["fractile"].to_numpy()[np.isinf(bound)]
        ax.plot(np.full(len(open_ended), end), open_ended, marker, color=FORCE, ms=8, clip_on=False)
    ax.plot(summary["load_factor"], summary["fractile"], "o", color=FORCE, ms=5)
    ax.axhline(1, color=GHOST, lw=0.8, zorder=0)
    ax.set(xlabel="load factor α [-]", ylabel="share of runs below [-]", ylim=(0, 1.02))
    if lines := out_of_the_ordinary(summary):
        ax.set_title("\n".join(lines), fontsize="small", loc="left", pad=22)
    legend_above(ax)
    return ax


def curve(data: xr.Dataset | xr.DataArray, *, label: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw load factors over the one parameter they depend on.

    Parameters
    ----------
    data
        ``load_factor`` over one coordinate with ``units``: of a case of a study, ``data.load_factor.sel(case=name)``.
        Points where no load factor was found (NaN) leave a gap. The load factor at an absent value, NaN or infinite,
        is a level line.
    label
        Name in the legend, for several curves on one Axes.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError
        If the data do not depend on just one parameter.
    """
    data = data["load_factor"] if isinstance(data, xr.Dataset) else data
    if data.ndim != 1 or data.dims[0] not in data.coords:
        over = ", ".join(map(str, data.dims)) or "nothing"
        msg = f"curve: load factors over {over}; give them over one coordinate, as 'compressive_strength'"
        raise bs.errors.ModelError(msg)
    name = str(data.dims[0])
    values = data[name].to_numpy().astype(float)
    ordered = np.argsort(values, kind="stable")
    is_finite = np.isfinite(values[ordered])
    finite, absent = ordered[is_finite], ordered[~is_finite]
    load_factor = data.to_numpy()
    long_unit = str(data[name].attrs.get("units", "dimensionless"))
    factor, unit = readable(values, _SHORT[long_unit]) if long_unit in _SHORT else (1.0, short_unit(long_unit) or "-")
    ax = new_axes(ax)
    colour = next_colour(ax)
    (line,) = ax.plot(values[finite] * factor, load_factor[finite], "o-", color=colour, ms=4, lw=1.2, label=label)
    for level in load_factor[absent]:
        ax.axhline(level, color=line.get_color(), lw=1, ls="--")
    ax.set(xlabel=f"{_SYMBOLS.get(name, name.replace('_', ' '))} [{unit}]", ylabel="load factor α [-]")
    # From zero, with room for the points; fixed limits would cut off later curves.
    ax.update_datalim([(0.0, 0.0)], updatex=False)
    ax.autoscale_view()
    if label:
        legend_above(ax)
    return ax


def fragility(data: xr.Dataset, *, label: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw the share of collapses over a parameter, with its interval of confidence.

    Parameters
    ----------
    data
        From :func:`blockstruct.studies.fragility`.
    label
        Name in the legend, for several curves on one Axes.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError
        If the data are anything else.
    """
    if not isinstance(data, xr.Dataset) or not {"share", "low", "high"} <= set(data):
        msg = f"fragility: {type(data).__name__} has no shares; give the Dataset of bs.studies.fragility(study)"
        raise bs.errors.ModelError(msg)
    name = str(data["share"].dims[0])
    ordered = data.sortby(name)
    values, share, low, high = (ordered[n].to_numpy() for n in (name, "share", "low", "high"))
    ax = new_axes(ax)
    colour = next_colour(ax)
    ax.plot(values, share, "o-", color=colour, ms=4, lw=1.2, label=label)
    interval = f"{data.attrs['confidence']:.0%} interval"
    ax.fill_between(values, low, high, color=colour, alpha=0.15, lw=0, label=interval)
    unit = str(data[name].attrs.get("units", "-")).replace("dimensionless", "-")
    ax.set(xlabel=f"{name.replace('_', ' ')} [{unit}]", ylabel="share of collapses [-]", ylim=(-0.02, 1.02))
    legend_above(ax)
    return ax
