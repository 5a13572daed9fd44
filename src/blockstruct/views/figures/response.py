"""The response of a structure to a record."""

import numpy as np
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct.units import readable
from blockstruct.views.figures.canvas import legend_above, new_axes, verbatim
from blockstruct.views.selection import given_result
from blockstruct.views.style import ACCENT, FORCE

#: Height of the drawn ground acceleration, relative to the largest displacement.
_GROUND = 0.25


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
