"""The capacity curve of a local mechanism, and its demand."""

import numpy as np
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct.views.figures.canvas import legend_above, new_axes
from blockstruct.views.style import ACCENT, FORCE

#: Longest drawn period of the demand, relative to the period of the last limit state.
_BEYOND = 1.3
#: Largest drawn acceleration, relative to the largest of the capacity curve.
_TALLEST = 6.0


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
        found = check.limit_states.get(f"{name}, by displacement")
        if found is not None:
            d = found.capacity
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
