"""Pictures of a case, in the text of the report itself."""

import base64
from io import BytesIO

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct.views import figures
from blockstruct.views.solids import Solids


def pictures(model: bs.Model, result: bs.CaseResult) -> list[tuple[str, str]]:
    """Captions and ``data:`` addresses of the pictures of a case that has iterations."""
    look = best_look(model, result)
    forces = result.history["contact_force"].isel(iteration=-1)
    captions = {
        "Mechanism of the last iteration": figures.mechanism(model, result, look=look),
        "State of the interfaces": figures.structure(model, result, look=look),
        "Load factor of every iteration": figures.convergence(result),
        "Certificate of every iteration": figures.certificate(result),
    }
    if np.any(np.nan_to_num(forces) != 0):
        captions["Resultants on the interfaces and line of thrust"] = figures.forces(model, result, look=look)
    return [(caption, _address(ax)) for caption, ax in captions.items()]


def best_look(model: bs.Model, result: bs.CaseResult) -> str:
    """Elevation across the thinner side of a structure that is thin and collapses in its plane; space otherwise."""
    extent = np.ptp(Solids.of(model).vertices, axis=0)
    thin = int(np.argmin(extent[:2]))
    motion = np.abs(bs.mechanism(result.history)["translation"].transpose("block", "axis").to_numpy()).max(axis=0)
    flat = extent[thin] < 0.35 * extent.max() and motion[thin] <= 0.1 * motion.max()
    return "xy"[thin] if flat else "3d"


def _address(ax: Axes) -> str:
    stream = BytesIO()
    ax.figure.savefig(stream, format="png", dpi=150)
    plt.close(ax.figure)  # type: ignore[arg-type]
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
