"""The loads of a case on the structure."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.units import readable
from blockstruct.views.figures.canvas import Canvas, legend_above, verbatim
from blockstruct.views.loads import load_arrows
from blockstruct.views.selection import given_result
from blockstruct.views.solids import Solids
from blockstruct.views.style import ACCENT, FORCE, PALE_EDGE, PALE_STONE

Array = NDArray[np.float64]

#: Length of the longest arrow and width of its shaft, relative to the size of the structure.
_LONGEST, _WIDEST = 0.18, 0.007


def loads(result: bs.CaseResult, *, look: Any = None, ax: Axes | None = None) -> Axes:
    """Draw the dead load without block weights, and the variable load.

    Arrows end where the forces act. Their lengths are proportional to the forces, to one scale for each load; arrows
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
    model = given_result(result, "loads").model
    solids = Solids.of(model)
    canvas = Canvas.of(result, ax, look)
    canvas.bodies(model, solids, solids.vertices, [PALE_STONE] * len(model.blocks), edge=(PALE_EDGE, 0.4))
    drawn, handles = [solids.vertices], {}
    for arrows in load_arrows(result):
        colour, times = (FORCE, " × load factor") if arrows.grows else (ACCENT, "")
        vectors = arrows.force * (_LONGEST * solids.size / arrows.largest)
        tails = arrows.point - vectors
        size = np.linalg.norm(arrows.force, axis=1) / arrows.largest
        canvas.arrows(tails, vectors, _WIDEST * solids.size * (0.4 + 0.6 * size), colour)
        drawn.append(tails)
        factor, unit = readable(np.array([arrows.largest]), "N")
        text = f"{verbatim(arrows.name)}: {arrows.total * factor:.4g} {unit}{times}"
        handles[text] = Line2D([], [], color=colour, lw=2)
    canvas.frame(np.concatenate(drawn))
    legend_above(canvas.ax, list(handles.values()), list(handles))
    return canvas.ax  # type: ignore[no-any-return]
