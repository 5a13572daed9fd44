"""Load factors over a parameter, such as the compressive strength or the friction coefficient."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct.units import readable, short_unit
from blockstruct.views.figures.canvas import legend_above, new_axes, next_colour
from blockstruct.views.style import ACCENT, FORCE

#: Colours of the curves on one Axes, from the palette of Okabe & Ito.
_COLOURS = (ACCENT, FORCE, "#009e73", "#cc79a7", "#000000")
_SHORT = {"pascal": "Pa", "newton": "N", "meter": "m", "radian": "rad"}
_SYMBOLS = {"compressive_strength": "compressive strength f_c", "friction_coefficient": "friction coefficient μ"}


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
    colour = next_colour(ax, _COLOURS)
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
