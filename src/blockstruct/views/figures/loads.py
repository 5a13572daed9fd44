"""The loads of a case on the structure."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.units import readable
from blockstruct.views.figures.canvas import Canvas, legend_above
from blockstruct.views.loads import applied
from blockstruct.views.selection import given_result
from blockstruct.views.solids import Solids
from blockstruct.views.style import ACCENT, FORCE, PALE_EDGE, PALE_STONE

Array = NDArray[np.float64]

#: Length of the longest arrow and width of its shaft, in multiples of the size of the structure, and the least length
#: that is drawn, in multiples of the longest.
_LONGEST, _WIDEST, _LEAST = 0.18, 0.007, 0.02


def loads(result: bs.CaseResult, *, look: Any = None, ax: Axes | None = None) -> Axes:
    """Draw the dead load besides the weight of the blocks, and the variable load at a load factor of 1.

    Arrows end where the forces act, and are as long as these are large, to one scale in each of the two loads; those
    below 2 % of the longest are left out. The legend has the resultants. Forces on supports and couples are not drawn.

    Parameters
    ----------
    result
        The result of a case, with or without iterations.
    look, ax
        As in :func:`structure`.

    Raises
    ------
    ModelError
        If it is not the result of a case.
    """
    model, case = given_result(result, "loads").model, result.case
    solids = Solids.of(model)
    canvas = Canvas.of(result, ax, look)
    canvas.bodies(model, solids, solids.vertices, [PALE_STONE] * len(model.blocks), edge=(PALE_EDGE, 0.4))
    drawn, handles = [solids.vertices], {}
    # A settlement has no variable load.
    for pattern, (colour, times) in zip(case.patterns, ((ACCENT, ""), (FORCE, " × load factor")), strict=False):
        carried = [load for load in pattern.loads if not isinstance(load, bs.SelfWeight)]
        points, forces = applied(bs.LoadPattern(pattern.name, carried), model, case.dead)
        size = np.linalg.norm(forces, axis=1)
        if not len(size):
            continue
        shown = size > _LEAST * size.max()
        vectors = forces[shown] * (_LONGEST * solids.size / size.max())
        tails = points[shown] - vectors
        widths = _WIDEST * solids.size * (0.4 + 0.6 * size[shown] / size.max())
        canvas.arrows(tails, vectors, widths, colour)
        drawn.append(tails)
        factor, unit = readable(size, "N")
        total = np.linalg.norm(forces.sum(axis=0)) * factor
        text = f"{pattern.name}: {total:.4g} {unit}{times}"
        handles[text] = Line2D([], [], color=colour, lw=2)
    canvas.frame(np.concatenate(drawn))
    legend_above(canvas.ax, list(handles.values()), list(handles))
    return canvas.ax  # type: ignore[no-any-return]
