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

_MECHANISM = "Mechanism of the last iteration"
_STATES = "State of the interfaces"
_CONVERGENCE = "Load factor of every iteration"
_CERTIFICATE = "Certificate of every iteration"
_FORCES = "Resultants on the interfaces and line of thrust"


def pictures(model: bs.Model, result: bs.CaseResult) -> list[tuple[str, str]]:
    """Captions and ``data:`` addresses of the pictures of a case that has iterations, as far as there is something."""
    look = best_look(model, result)
    last = result.history.isel(iteration=-1)
    drawings: dict[str, Callable[[Axes], object]] = {}
    if np.isfinite(last["block_velocity"]).all():
        drawings[_MECHANISM] = lambda ax: figures.mechanism(model, result, look=look, ax=ax)
    found_forces = bool(np.any(np.nan_to_num(last["contact_force"]) != 0))
    if found_forces:
        drawings[_STATES] = lambda ax: figures.structure(model, result, look=look, ax=ax)
    if np.isfinite(result.history["load_factor"]).sum() > 1:
        drawings[_CONVERGENCE] = lambda ax: figures.convergence(result, ax=ax)
        drawings[_CERTIFICATE] = lambda ax: figures.certificate(result, ax=ax)
    if found_forces:
        drawings[_FORCES] = lambda ax: figures.forces(model, result, look=look, ax=ax)
    return [
        (name, _address(draw, None if name in (_CONVERGENCE, _CERTIFICATE) else look))
        for name, draw in drawings.items()
    ]


def best_look(model: bs.Model, result: bs.CaseResult) -> str:
    """Elevation across the thinner side of a structure that is thin and collapses in its plane; space otherwise."""
    extent = np.ptp(Solids.of(model).vertices, axis=0)
    thin = int(np.argmin(extent[:2]))
    translation = bs.mechanism(result.history)["translation"].transpose("block", "axis").to_numpy()
    motion = np.abs(np.nan_to_num(translation)).max(axis=0)
    flat = extent[thin] < 0.35 * extent.max() and motion[thin] <= 0.1 * motion.max()
    return "xy"[thin] if flat else "3d"


def _address(draw: Callable[[Axes], object], look: str | None) -> str:
    # A Figure of its own: pyplot would keep it, and may want a screen.
    figure = Figure(figsize=(5, 3.4) if look is None else (7, 4.6), layout="constrained")
    draw(figure.add_subplot(projection="3d" if look == "3d" else None))
    stream = BytesIO()
    figure.savefig(stream, format="png", dpi=150)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
