"""The share of records under which a structure collapses."""

import xarray as xr
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct.views.figures.canvas import legend_above, new_axes, next_colour
from blockstruct.views.style import ACCENT

_COLOURS = (ACCENT, "#009e73", "#cc79a7", "#000000")


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
    colour = next_colour(ax, _COLOURS)
    ax.plot(values, share, "o-", color=colour, ms=4, lw=1.2, label=label)
    ax.fill_between(values, low, high, color=colour, alpha=0.15, lw=0)
    unit = str(data[name].attrs.get("units", "-")).replace("dimensionless", "-")
    ax.set(xlabel=f"{name.replace('_', ' ')} [{unit}]", ylabel="share of collapses [-]", ylim=(-0.02, 1.02))
    if label:
        legend_above(ax)
    return ax
