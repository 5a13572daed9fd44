"""Pictures of a case, in the text of the report itself."""

import base64
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import blockstruct as bs
from blockstruct.views import figures
from blockstruct.views.selection import is_pressed
from blockstruct.views.solids import Solids

#: Width and height of pictures of the structure and of diagrams, inches.
_WIDE, _NARROW = (7, 4.6), (5, 3.4)


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture of a case: its caption, its ``data:`` address, and whether it takes the whole width."""

    caption: str
    address: str
    wide: bool


def pictures(model: bs.Model, result: bs.CaseResult) -> list[Picture]:
    """Pictures of a case that has iterations, as far as there is something to draw."""
    look = best_look(model, result)
    last = result.history.isel(iteration=[-1])
    wide: dict[str, Callable[[Axes], object]] = {}
    narrow: dict[str, Callable[[Axes], object]] = {}
    if np.isfinite(last["block_velocity"]).all():
        wide["Mechanism of the last iteration"] = lambda ax: figures.mechanism(model, result, look=look, ax=ax)
    if np.any(np.nan_to_num(last["contact_force"]) != 0):
        wide["State of the interfaces"] = lambda ax: figures.structure(model, result, look=look, ax=ax)
    if is_pressed(last, bs.interface_resultants(last)).any():
        wide["Resultants on the interfaces and line of thrust"] = lambda ax: figures.forces(
            model, result, look=look, ax=ax
        )
    if np.isfinite(result.history["load_factor"]).sum() > 1:
        narrow["Load factor of every iteration"] = lambda ax: figures.convergence(result, ax=ax)
        narrow["Certificate of every iteration"] = lambda ax: figures.certificate(result, ax=ax)
    name, about = nearest_to_crushing(model, result)
    if name:
        narrow[f"Interface {name}, the nearest to crushing"] = lambda ax: figures.crushing_domain(
            model, result, name, about=about, ax=ax
        )
    space = "3d" if look == "3d" else None
    return [Picture(caption, _address(draw, _WIDE, space), wide=True) for caption, draw in wide.items()] + [
        Picture(caption, _address(draw, _NARROW), wide=False) for caption, draw in narrow.items()
    ]


def nearest_to_crushing(model: bs.Model, result: bs.CaseResult) -> tuple[str, str]:
    """Most compressed of the interfaces that use most of their compressive strength, and the axis that takes most.

    No name if none has a strength.
    """
    use = np.nan_to_num(result.utilisation["crushing"].isel(iteration=-1).to_numpy())
    if not use.any():
        return "", ""
    last = result.resultants.isel(iteration=-1)
    N = last["force"].sel(component="n").to_numpy()
    k = int(np.argmax(np.where(use >= 0.99 * use.max(), N, -np.inf)))
    # The eccentricity as a share of the depth: the smaller moment may be the one that crushes.
    frame = result.history["interface_frame"].to_numpy()[k]
    width = dict(zip("st", np.ptp(np.asarray(model.interfaces[k].polygon) @ frame[1:].T, axis=0), strict=True))
    moment = last["moment"].isel(interface=k)
    share = {about: abs(float(moment.sel(component=about))) / width[across] for about, across in ("st", "ts")}
    return model.interfaces[k].name, max(share, key=share.__getitem__)


def best_look(model: bs.Model, result: bs.CaseResult) -> str:
    """Elevation across the thinner side of a structure that is thin and collapses in its plane; space otherwise."""
    extent = np.ptp(Solids.of(model).vertices, axis=0)
    thin = int(np.argmin(extent[:2]))
    translation = bs.mechanism(result.history)["translation"].transpose("block", "axis").to_numpy()
    motion = np.abs(np.nan_to_num(translation)).max(axis=0)
    flat = extent[thin] < 0.35 * extent.max() and motion[thin] <= 0.1 * motion.max()
    return "xy"[thin] if flat else "3d"


def _address(draw: Callable[[Axes], object], size: tuple[float, float], projection: str | None = None) -> str:
    # A Figure of its own: pyplot would keep it, and may want a screen.
    figure = Figure(figsize=size, layout="constrained")
    draw(figure.add_subplot(projection=projection))
    stream = BytesIO()
    figure.savefig(stream, format="png", dpi=150)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
