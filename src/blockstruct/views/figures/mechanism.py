"""The collapse mechanism over the ghost of the structure."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct.units import si
from blockstruct.views.figures.canvas import Canvas
from blockstruct.views.selection import chosen_iteration, same_model
from blockstruct.views.solids import Solids

#: Amplitude where none is given, in multiples of the largest extent of the structure.
AMPLITUDE = 0.08


def mechanism(
    model: bs.Model,
    result: bs.CaseResult,
    *,
    amplitude: Any = None,
    iteration: int = -1,
    look: str = "y",
    ax: Axes | None = None,
) -> Axes:
    """Draw the blocks displaced by a mechanism, over their original places.

    Displacements are to first order, so that joints that stay closed stay closed in the picture.

    Parameters
    ----------
    model, result
        The structure and a case of it.
    amplitude : quantity, length
        The largest translation of a centroid; 8 % of the structure's largest extent by default.
    iteration, look, ax
        As in :func:`structure`.

    Raises
    ------
    ModelError, UnknownNameError, UnitError, DimensionError
        As :func:`structure`, and an amplitude that is no length.
    """
    same_model(model, result)
    index = chosen_iteration(result, iteration)
    solids = Solids.of(model)
    factor = AMPLITUDE * solids.size if amplitude is None else si(amplitude, "length", "mechanism: amplitude")
    moved = solids.vertices + factor * solids.displacement(result, index)
    if not np.isfinite(moved).all():
        msg = f"case {result.name!r}: no mechanism in iteration {index}, {result.status}; choose another iteration"
        raise bs.ModelError(msg)
    canvas = Canvas.of(ax, look)
    supports = [b.fixed for b in model.blocks]
    canvas.bodies(solids, supports, solids.vertices, ghost=True)
    canvas.bodies(solids, supports, moved)
    canvas.frame(np.concatenate([solids.vertices, moved]))
    canvas.ax.set_title(f"largest translation drawn as {factor:.3g} m", fontsize="small", color="0.35")
    return canvas.ax  # type: ignore[no-any-return]
