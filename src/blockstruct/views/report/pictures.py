"""Pictures of a case, in the text of the report itself."""

import base64
from collections.abc import Callable
from io import BytesIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import blockstruct as bs
from blockstruct.views import figures
from blockstruct.views.solids import Solids


def pictures(model: bs.Model, result: bs.CaseResult) -> list[tuple[str, str]]:
    """Captions and ``data:`` addresses of the pictures of a case that has iterations."""
    look = best_look(model, result)
    forces = result.history["contact_force"].isel(iteration=-1)
    drawings: dict[str, Callable[[Axes], object]] = {
        "Mechanism of the last iteration": lambda ax: figures.mechanism(model, result, look=look, ax=ax),
        "State of the interfaces": lambda ax: figures.structure(model, result, look=look, ax=ax),
        "Load factor of every iteration": lambda ax: figures.convergence(result, ax=ax),
        "Certificate of every iteration": lambda ax: figures.certificate(result, ax=ax),
    }
    if np.any(np.nan_to_num(forces) != 0):
        caption = "Resultants on the interfaces and line of thrust"
        drawings[caption] = lambda ax: figures.forces(model, result, look=look, ax=ax)
    diagrams = ("Load factor of every iteration", "Certificate of every iteration")
    return [(name, _address(draw, None if name in diagrams else look)) for name, draw in drawings.items()]


def best_look(model: bs.Model, result: bs.CaseResult) -> str:
    """Elevation across the thinner side of a structure that is thin and collapses in its plane; space otherwise."""
    extent = np.ptp(Solids.of(model).vertices, axis=0)
    thin = int(np.argmin(extent[:2]))
    motion = np.abs(bs.mechanism(result.history)["translation"].transpose("block", "axis").to_numpy()).max(axis=0)
    flat = extent[thin] < 0.35 * extent.max() and motion[thin] <= 0.1 * motion.max()
    return "xy"[thin] if flat else "3d"


def _address(draw: Callable[[Axes], object], look: str | None) -> str:
    # A Figure of its own: pyplot would keep it, and may want a screen.
    figure = Figure(figsize=(5, 3.4) if look is None else (7, 4.6), layout="constrained")
    draw(figure.add_subplot(projection="3d" if look == "3d" else None))
    stream = BytesIO()
    figure.savefig(stream, format="png", dpi=150)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
