"""Pictures of a report."""

import base64
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct import text
from blockstruct.views.figures.diagrams import verification
from blockstruct.views.figures.mechanism import mechanism
from blockstruct.views.figures.sheet import Drawing
from blockstruct.views.figures.structure import dimensions
from blockstruct.views.selection import moving_bodies
from blockstruct.views.style import BODY_COLOURS

#: Width and height, inches: the mechanism of a direction is 9 cm high or more, with its legend next to it.
_MECHANISM, _GEOMETRY, _DIAGRAM = (4.5, 3.7), (6.3, 3.6), (6.3, 2.9)


def address(drawing: Drawing) -> str:
    """Return a picture as a ``data:`` address."""
    return "data:image/png;base64," + base64.b64encode(drawing.picture()).decode("ascii")


def mechanism_picture(result: bs.CaseResult) -> dict[str, Any] | None:
    """Return the picture of the mechanism with its load, and the legend of its bodies; None without a mechanism.

    The legend lists the five heaviest bodies. The others, and bodies below two percent of the moving weight, are one
    entry.
    """
    if not result.n_iterations or not np.isfinite(result.history["block_velocity"].isel(iteration=-1)).all():
        return None
    caption = _moves(result)
    drawing = Drawing(
        "mechanism", caption, lambda ax: _without_legend(mechanism(result, colour="macro-block", ax=ax)), _MECHANISM
    )
    return {"caption": caption, "address": address(drawing), "bodies": _bodies(result)}


def relied_motion(check: bs.assess.LocalMechanismCheck) -> bs.CaseResult:
    """Return the case with the motion that a check relies on, and with the load factor that activates it."""
    result = check.governing
    if not check.alpha0 > 0:
        return result
    load_factor = check.verdict.governing.alpha / check.alpha0 * result.load_factor
    return result.changed(outcome=replace(result.outcome, load_factor=load_factor))


def _without_legend(ax: Axes) -> None:
    legend = ax.get_legend()
    if legend is not None:
        legend.remove()


def _bodies(result: bs.CaseResult) -> list[dict[str, str]]:
    """Return colour, name, weight and motion of the moving bodies, the small ones as one."""
    moving = moving_bodies(result, -1)[1]
    whole = sum(body.total for body in moving)
    large = [body for body in moving if body.total >= text.SMALL * whole][: text.LISTED]
    rows = [
        {
            "colour": BODY_COLOURS[k % len(BODY_COLOURS)],
            "name": body.name,
            "weight": _kilonewtons(body.total, body.carried),
            "motion": text.motion_clause(body.translation, body.axis, body.centroid, body.speed),
        }
        for k, body in enumerate(large)
    ]
    small = moving[len(large) :]
    if small:
        weights = (sum(body.total for body in small), sum(body.carried for body in small))
        rows.append(
            {"colour": "", "name": text.smaller_bodies(len(small)), "weight": _kilonewtons(*weights), "motion": ""}
        )
    return rows


def _kilonewtons(total: float, carried: float) -> str:
    return f"{text.kilonewton(total)}{f', {text.kilonewton(carried)} of it carried' if carried else ''}"


def geometry_picture(model: bs.Model) -> dict[str, str]:
    """Return the picture of the model with its overall dimensions."""
    caption = "The structure with its overall dimensions; supports are darker"
    return {
        "caption": caption,
        "address": address(Drawing("geometry", caption, lambda ax: dimensions(model, ax=ax), _GEOMETRY)),
    }


def _moves(result: bs.CaseResult) -> str:
    """Return the caption of a mechanism."""
    if bs.vocabulary.Stage(result.history["stage"].to_numpy()[-1]).is_of_dead_load:
        return f"How “{result.name}” moves under its dead load alone, to first order: its bodies in colours"
    answer = f"{result.answer.name} {result.answer.symbol}"
    what = f"the {answer}" if result.answer.is_reaction else f"the variable load and its {answer}"
    if result.status is not bs.Status.CONVERGED:
        return (
            f"Motion of the last iteration of “{result.name}”, without a collapse state: its bodies in colours, "
            f"{what} there"
        )
    return f"How “{result.name}” moves, to first order: its bodies in colours, {what}"


def capacity_picture(check: bs.assess.LocalMechanismCheck) -> dict[str, str] | None:
    """Return the picture of capacity curve and demand; None without a check by displacement."""
    if "SLV, by displacement" not in check.limit_states:
        return None
    caption = "Capacity curve and demand at SLV; the ray is that of the equivalent period"
    return {
        "caption": caption,
        "address": address(Drawing("verification", caption, lambda ax: verification(check, ax=ax), _DIAGRAM)),
    }
