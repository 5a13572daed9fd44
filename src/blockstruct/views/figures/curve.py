"""Load factors over a parameter, such as λ(f_c) and λ(μ)."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct.views.figures.canvas import new_axes
from blockstruct.views.look import ACCENT, readable

_SHORT = {"pascal": "Pa", "newton": "N", "meter": "m", "dimensionless": "-"}
_SYMBOLS = {"compressive_strength": "compressive strength f_c", "friction_coefficient": "friction coefficient μ"}


def curve(sweep: xr.Dataset | xr.DataArray, *, label: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw load factors over the one parameter they depend on.

    Parameters
    ----------
    sweep
        ``load_factor`` over one coordinate with ``units``, as ``Analysis.sweep`` gives it. Points where no load
        factor was found (NaN) leave a gap.
    label
        Name in the legend, for several curves on one Axes.
    ax
        Axes to draw on.

    Raises
    ------
    ModelError
        Data that do not depend on just one parameter.
    """
    data = sweep["load_factor"] if isinstance(sweep, xr.Dataset) else sweep
    if data.ndim != 1 or data.dims[0] not in data.coords:
        over = ", ".join(map(str, data.dims)) or "nothing"
        msg = f"curve: load factors over {over}; give them over one coordinate, as 'compressive_strength'"
        raise bs.ModelError(msg)
    name = str(data.dims[0])
    ordered = data.sortby(name)
    values = ordered[name].to_numpy().astype(float)
    long_unit = str(ordered[name].attrs.get("units", "dimensionless"))
    unit = _SHORT.get(long_unit, long_unit)
    factor, unit = (1.0, unit) if unit == "-" else readable(values, unit)
    ax = new_axes(ax)
    ax.plot(values * factor, ordered.to_numpy(), "o-", color=None if label else ACCENT, ms=4, lw=1.2, label=label)
    ax.set(xlabel=f"{_SYMBOLS.get(name, name.replace('_', ' '))} [{unit}]", ylabel="load factor λ [-]")
    ax.set_ylim(bottom=min(0.0, float(np.nanmin(ordered))))
    if label:
        ax.legend(frameon=False, fontsize="small")
    return ax
