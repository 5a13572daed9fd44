"""All figures of a case, as far as there is something to draw."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import blockstruct as bs
from blockstruct.views.figures.diagrams import capacity, certificate, convergence, crushing_domain, response
from blockstruct.views.figures.structure import forces, loads, mechanism, structure
from blockstruct.views.figures.studies import compass
from blockstruct.views.output import made_folder, write_bytes
from blockstruct.views.selection import compasses, shown_results

#: Width and height, inches, of pictures of the structure and of diagrams; a page is 160 mm wide.
_STRUCTURE, _DIAGRAM = (6.3, 4.0), (6.3, 3.0)
_FORMATS = ("png", "svg", "pdf")
#: Texts of an SVG stay texts, and a file has no date.
_STYLE: Any = {"font.size": 9, "svg.fonttype": "none", "svg.hashsalt": "blockstruct"}


@dataclass(frozen=True, slots=True)
class Drawing:
    """A figure of a case: name, caption, drawing function, and size in inches."""

    name: str
    caption: str
    draw: Callable[[Axes], object]
    size: tuple[float, float]
    projection: str = "rectilinear"

    def picture(self, file_format: str = "png", dpi: int = 200) -> bytes:
        """Return the content of the figure's file."""
        with rc_context(_STYLE):
            # Not a figure of pyplot, which would keep it and may need a screen.
            figure = Figure(figsize=self.size, layout="constrained")
            self.draw(figure.add_subplot(projection=self.projection))
            stream = BytesIO()
            undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(file_format)
            figure.savefig(stream, format=file_format, dpi=dpi, metadata=undated)
        return stream.getvalue()


def drawings(result: bs.CaseResult, *, look: Any = None) -> list[Drawing]:
    """Return the figures of a case; none without iterations.

    Parameters
    ----------
    result
        The result of a case.
    look
        As in :func:`structure`.
    """
    if result.response is not None:
        caption = "Displacement of the block that moves furthest, relative to the ground"
        return [Drawing("response", caption, lambda ax: response(result, ax=ax), _DIAGRAM)]
    if not result.n_iterations:
        return []
    last = result.history.isel(iteration=[-1])
    drawings: list[Drawing] = []

    def add(name: str, caption: str, draw: Callable[..., Axes], **options: Any) -> None:
        of_structure = draw in (mechanism, loads, structure, forces)
        options |= {"look": look} if of_structure else {}
        size = _STRUCTURE if of_structure else _DIAGRAM
        drawings.append(Drawing(name, caption, lambda ax: draw(result, **options, ax=ax), size))

    if result.moves:
        add("mechanism", "Mechanism of the last iteration, to first order", mechanism)
    plain = (bs.SelfWeight, bs.BodyForce)
    if not all(isinstance(load, plain) for p in result.case.patterns for load in p.loads):
        add("loads", "Dead load without the weight of the blocks, and variable load", loads)
    if np.any(np.nan_to_num(last["contact_force"]) != 0):
        add("states", "Joints that move in the mechanism; dashes combine the states of a joint", structure)
        add("sliding", "Share of the sliding strength in use", structure, colour="sliding")
    pressed = bs.results.is_pressed(last, bs.results.interface_resultants(last)).any()
    if pressed:
        add("forces", "Resultants on the interfaces, and the line of thrust where there is one", forces)
    name, about = nearest_to_crushing(result)
    if pressed and name:
        blocks = "Depth of the stress block that the compressive strength needs in each joint"
        add("crushing", blocks, structure, colour="crushing")
    if name:
        domain = f"Interface {name}, the nearest to crushing: normal force and bending in every iteration"
        add("domain", domain, crushing_domain, interface=name, about=about)
    if result.capacity is not None:
        marks = "a cross is a state that its certificate does not hold for, a ring an end before the structure falls"
        add("capacity", f"Capacity curve: load factor or reaction over the displacement; {marks}", capacity)
    if np.isfinite(result.history["load_factor"]).sum() > 1:
        along_path = (result.history["stage"] == bs.vocabulary.Stage.LOADING_PATH.value).any()
        steps = ", and steps of displacement along the loading path" if along_path else ", not steps of load"
        every = f"{result.answer.name.capitalize()} of every iteration: numerical steps{steps}"
        add("convergence", every, convergence)
        add("certificate", "Certificate of every iteration, with its tolerances", certificate)
    return drawings


def overview(analysis: bs.Analysis) -> list[Drawing]:
    """Return the figures of all cases together: a compass for three directions or more."""
    caption = "Load factors around the compass; the arrow is the direction that governs"
    try:
        each = compasses(analysis)
    except bs.errors.ModelError:
        return []
    several = len(each) > 1
    return [
        Drawing(
            f"directions-{k}" if several else "directions",
            f"{caption}: {name}" if several else caption,
            lambda ax, around=around: compass(around, ax=ax),  # type: ignore[misc]
            _STRUCTURE,
            "polar",
        )
        for k, (name, around) in enumerate(each, start=1)
        if around.data.sizes["direction"] > 2
    ]


def write_figures(
    analysis: bs.Analysis, folder: str | Path, *, look: Any = None, file_format: str = "png", dpi: int = 200
) -> list[Path]:
    """Write the figures of all cases into a folder, and replace existing ones.

    Parameters
    ----------
    analysis
        The analysis. A spread shows its run as given.
    folder
        Made if it does not exist.
    look
        As in :func:`structure`.
    file_format
        ``"png"``, ``"svg"`` or ``"pdf"``.
    dpi
        Resolution of PNG; figures are 160 mm wide.

    Returns
    -------
    list of Path
    The written files.

    Raises
    ------
    ModelError
        If the look or the format is unknown, or no case of the analysis has an iteration.
    StorageError
        If the folder cannot be written to.
    """
    bs.errors.check_known(file_format, _FORMATS, "write_figures: format")
    named = _file_names([r.name for r in shown_results(analysis)])
    sheets = {named[r.name]: drawings(r, look=look) for r in shown_results(analysis)}
    if not any(sheets.values()):
        ended = "; ".join(map(str, analysis.values())) or "it has no case"
        msg = f"analysis of {analysis.model.name!r}: no case has an iteration to draw ({ended}); run it again"
        raise bs.errors.ModelError(msg)
    named_drawings = [(f"{case}-{one.name}", one) for case, sheet in sheets.items() for one in sheet]
    named_drawings += [(one.name, one) for one in overview(analysis)]
    target = made_folder(folder)
    return [
        write_bytes(one.picture(file_format, dpi), target / f"{name}.{file_format}") for name, one in named_drawings
    ]


def _file_names(cases: list[str]) -> dict[str, str]:
    """Return distinct parts of file names for cases."""
    names: dict[str, str] = {}
    for case in cases:
        plain = re.sub(r"[^\w+-]+", "-", case).strip("-")[:60] or "case"
        name, k = plain, 2
        while name.lower() in {n.lower() for n in names.values()}:
            name, k = f"{plain}-{k}", k + 1
        names[case] = name
    return names


def nearest_to_crushing(result: bs.CaseResult) -> tuple[str, str]:
    """Return the interface nearest to crushing, and its governing axis; no name without strength."""
    use = np.nan_to_num(result.utilisation["crushing"].isel(iteration=-1).to_numpy())
    if not use.any():
        return "", ""
    last = result.resultants.isel(iteration=-1)
    N = last["force"].sel(component="n").to_numpy()
    k = int(np.argmax(np.where(use >= 0.99 * use.max(), N, -np.inf)))
    # Relative to the depth, since the smaller moment may be the one that crushes.
    frame = result.history["interface_frame"].to_numpy()[k]
    interface = result.model.interfaces[k]
    width = dict(zip("st", np.ptp(np.asarray(interface.polygon) @ frame[1:].T, axis=0), strict=True))
    moment = last["moment"].isel(interface=k)
    share = {about: abs(float(moment.sel(component=about))) / width[across] for about, across in ("st", "ts")}
    return interface.name, max(share, key=share.__getitem__)
