"""A collapse in words: what moves and how, at which joints, with which share of the weight."""

from collections.abc import Iterable

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.model import LoadPattern, Model
from blockstruct.results.macro_blocks import MacroBlock, macro_blocks
from blockstruct.results.mechanism import mechanism
from blockstruct.results.states import active_joints, contact_state
from blockstruct.results.ties import tie_sentences
from blockstruct.vocabulary import AXES, ContactState, Stage, Status, coordinate, counted

Array = NDArray[np.float64]

#: Names listed before the rest is counted, and share of a measure of all joints below which one is not a main one.
LISTED, MAIN = 5, 0.02
#: Share of the speed of a body below which its centroid is said to stay.
STAYS = 1e-3
#: Share of the distance of an axis from the centroid below which a coordinate of it is zero.
NOISE = 1e-5
#: Cosine above which a direction is that of an axis.
ALONG = np.cos(np.radians(3.0))
_NO_RESULT = "What follows is the motion of the last iteration, which is no result."


def describe(
    model: Model, history: xr.Dataset, dead: LoadPattern | None = None, status: Status = Status.CONVERGED
) -> str:
    """How a structure collapses, in sentences: bodies, axes of rotation, hinges, sliding and crushing joints, ties.

    Parameters
    ----------
    model, history
        The structure, and the history of a case with a mechanism.
    dead
        The dead load, whose weights count with those of the blocks that carry them; without it none.
    status
        How the case ended: of one without a certified state the sentences are of its last iteration alone.
    """
    bodies = macro_blocks(model, mechanism(history), dead=dead)
    moving = [body for body in bodies if body.moves]
    weight, carried = (sum(getattr(body, name) for body in bodies) for name in ("total", "carried"))
    blocks = sum(len(body.blocks) for body in bodies)
    share = sum(body.total for body in moving) / weight if weight > 0 else 0.0
    count = sum(len(body.blocks) for body in moving)
    bodies_move = counted(len(moving), "body", "bodies")
    whole, of_it = ("the weight with what blocks carry", "that weight") if carried else ("the weight", "the weight")
    move = "moves" if count == 1 else "move"
    lines = [_NO_RESULT] if status in (Status.NOT_CONVERGED, Status.INTERRUPTED) else []
    lines += [f"{count} of {counted(blocks, 'free block')} {move}, {share:.0%} of {whole}, as {bodies_move}."]
    for number, body in enumerate(moving[:LISTED], 1):
        names = _listed(body.blocks, "block")
        part = body.total / weight if weight > 0 else 0.0
        size = counted(len(body.blocks), "block")
        lines.append(f"{number}. A body of {size} ({names}; {part:.0%} of {of_it}) {_motion(body)}.")
    if len(moving) > LISTED:
        rest = len(moving) - LISTED
        lines.append(f"{rest} smaller {'body moves' if rest == 1 else 'bodies move'}, too.")
    lines += _joints(history)
    if "tie" in history.sizes:
        said = tie_sentences(history)
        lines += said[:LISTED]
        if len(said) > LISTED:
            lines.append(f"And {counted(len(said) - LISTED, 'more tie')}: CaseResult.ties.")
    if (history["stage"] == Stage.LOADING_PATH.value).any():
        lines.append("Iterations along the loading path are steps of displacement; any other is a numerical step.")
    else:
        lines.append("An iteration of its history is a numerical step, not a step of loading.")
    return "\n".join(lines)


def failures(history: xr.Dataset) -> str:
    """How the last iteration fails, at the joints that dissipate most; empty if none moves."""
    first = active_joints(history).head(3)["state"]
    return "; it fails at " + ", ".join(f"{name} ({state})" for name, state in first.items()) if len(first) else ""


def _joints(history: xr.Dataset) -> list[str]:
    last = history.isel(iteration=-1)
    state = contact_state(last)
    index = last["interface_of_contact_point"].to_numpy()
    force = last["contact_force"].transpose("contact_point", "component").to_numpy()
    v = last["relative_velocity"].transpose("contact_point", "component").to_numpy()

    def per_joint(values: Array) -> Array:
        return np.asarray(np.bincount(index, values, minlength=len(state)), dtype=float)

    friction = per_joint(-np.einsum("kc,kc->k", force[:, 1:], v[:, 1:]))
    measures = {
        ContactState.HINGE: (
            "Hinges",
            per_joint(force[:, 0]) * per_joint(np.maximum(v[:, 0], 0.0)),
        ),
        ContactState.SLIDING: ("Sliding joints", friction),
        ContactState.TWISTING: ("Twisting joints", friction),
        ContactState.CRUSHING: ("Crushing joints", per_joint(np.maximum(-force[:, 0] * v[:, 0], 0.0))),
    }
    lines = []
    for part, (words, measure) in measures.items():
        has = state.str.contains(part.value).to_numpy()
        ranked = np.where(has, measure, 0.0)
        total = ranked.sum()
        if not total > 0:
            continue
        order = np.argsort(-ranked, kind="stable")
        main = [str(state["interface"].to_numpy()[k]) for k in order if ranked[k] > MAIN * total]
        lines.append(
            f"{words}: {len(main)}, first {_listed(main, 'joint')}." if len(main) > 1 else f"{words}: {main[0]}."
        )
    return lines


def _motion(body: MacroBlock) -> str:
    towards = _direction(body.translation)
    if body.axis is None:
        return f"moves towards {towards} without turning"
    direction, point = body.axis
    along = np.abs(direction).argmax()
    if abs(direction[along]) > ALONG:
        # What the solver leaves of a zero is small beside the distance from the centroid.
        noise = NOISE * np.linalg.norm(point - body.centroid)
        place = np.where(np.abs(point) <= noise, 0.0, np.round(point, 6) + 0.0)
        rest = [f"{name} = {coordinate(value)} m" for name, value in zip(AXES, place, strict=True)]
        where = f"the axis along {AXES[along]} through {', '.join(r for k, r in enumerate(rest) if k != along)}"
    else:
        place = np.round(point, 6) + 0.0
        where = f"an axis along {_vector(direction)} through ({', '.join(map(coordinate, place))}) m"
    stays = np.linalg.norm(body.translation) <= STAYS * body.speed
    return f"turns about {where}; its centroid {'stays' if stays else f'moves towards {towards}'}"


def _direction(vector: Array) -> str:
    length = np.linalg.norm(vector)
    if length == 0:
        return "nowhere"
    unit = vector / length
    along = np.abs(unit).argmax()
    if abs(unit[along]) > ALONG:
        return f"{'+' if unit[along] > 0 else '−'}{AXES[along]}"
    return _vector(unit)


def _vector(values: Array) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in np.round(values, 6) + 0.0) + ")"


def _listed(names: Iterable[str], what: str) -> str:
    found = list(names)
    rest = len(found) - LISTED
    return ", ".join(found[:LISTED]) + (f" and {counted(rest, f'more {what}')}" if rest > 0 else "")
