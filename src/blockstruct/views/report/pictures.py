"""Pictures of a report."""

import base64

import numpy as np

import blockstruct as bs
from blockstruct.views.figures import mechanism, verification
from blockstruct.views.figures.sheet import Drawing

#: Width and height, inches.
_SUMMARY, _VERIFICATION, _DIAGRAM = (6.3, 3.1), (6.3, 3.4), (6.3, 2.9)


def address(drawing: Drawing) -> str:
    """Return a picture as a ``data:`` address."""
    return "data:image/png;base64," + base64.b64encode(drawing.picture()).decode("ascii")


def mechanism_picture(result: bs.CaseResult, *, small: bool) -> dict[str, str] | None:
    """Return the picture of the mechanism with its load, each moving body in a colour; None without one."""
    if not result.n_iterations or not np.isfinite(result.history["block_velocity"].isel(iteration=-1)).all():
        return None
    caption = _moves(result)
    size = _SUMMARY if small else _VERIFICATION
    drawing = Drawing("mechanism", caption, lambda ax: mechanism(result, colour="macro-block", ax=ax), size)
    return {"caption": caption, "address": address(drawing)}


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
