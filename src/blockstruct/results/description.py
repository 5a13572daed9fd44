"""Description of a collapse: bodies, joints, ties."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct import text
from blockstruct.model import LoadPattern, Model
from blockstruct.results.interfaces import active_joints, at_points, contact_state
from blockstruct.results.mechanism import macro_blocks, mechanism
from blockstruct.results.ties import tie_sentences
from blockstruct.vocabulary import ContactState, Stage, Status

Array = NDArray[np.float64]

_KINDS = {
    ContactState.HINGE: "Hinges",
    ContactState.SLIDING: "Sliding joints",
    ContactState.TWISTING: "Twisting joints",
    ContactState.CRUSHING: "Crushing joints",
}


def describe(
    model: Model, history: xr.Dataset, dead: LoadPattern | None = None, status: Status = Status.CONVERGED
) -> str:
    """Return sentences on a mechanism: bodies, axes, joints, ties.

    Parameters
    ----------
    model, history
        The structure, and the history of a case with a mechanism.
    dead
        The dead load, whose weights count with the blocks that carry them. Without it, blocks carry no weights.
    status
        How the case ended. Without a collapse state the sentences describe the last iteration.
    """
    bodies = macro_blocks(model, mechanism(history), dead=dead)
    moving = [body for body in bodies if body.moves]
    weight, carried = (sum(getattr(body, name) for body in bodies) for name in ("total", "carried"))
    free, moved = (sum(len(body.blocks) for body in some) for some in (bodies, moving))
    parts = [
        (
            body.blocks,
            body.total / weight if weight > 0 else 0.0,
            text.motion_clause(body.translation, body.axis, body.centroid, body.speed),
        )
        for body in moving
    ]
    lines = [text.NO_COLLAPSE_STATE] if status in (Status.NOT_CONVERGED, Status.INTERRUPTED) else []
    share = sum(share for _, share, _ in parts)
    lines.append(text.moving_sentence(moved, free, len(moving), share, carried=bool(carried)))
    lines += text.body_sentences(parts)
    lines += [text.joints_sentence(_KINDS[state], joints) for state, joints in main_joints(history).items()]
    if "tie" in history.sizes:
        ties = tie_sentences(history)
        more = len(ties) - text.LISTED
        lines += ties[: text.LISTED] + [text.more_ties(more)] * (more > 0)
    on_path = (history["stage"] == Stage.LOADING_PATH.value).any()
    lines.append(text.STEPS_OF_PATH if on_path else text.STEPS_OF_PROGRAMS)
    return "\n".join(lines)


def failures(history: xr.Dataset) -> str:
    """Return the clause on the joints that dissipate most; empty without any.

    The last iteration counts.
    """
    states = active_joints(history).head(3)["state"]
    return text.failure_clause(zip(states.index.astype(str), states, strict=True))


def main_joints(history: xr.Dataset) -> dict[ContactState, list[str]]:
    """Return the joints that fail in each way in the last iteration, the most active first.

    Hinges are ranked by normal force times opening velocity, the others by dissipation. Joints below a share of the
    largest, :data:`blockstruct.text.SMALL`, are left out.
    """
    last = history.isel(iteration=-1)
    state = contact_state(last)
    index = last["interface_of_contact_point"].to_numpy()
    force, v = (at_points(last, name) for name in ("contact_force", "relative_velocity"))

    def per_joint(values: Array) -> Array:
        return np.asarray(np.bincount(index, values, minlength=len(state)), dtype=float)

    friction = per_joint(-np.einsum("kc,kc->k", force[:, 1:], v[:, 1:]))
    measures = {
        ContactState.HINGE: per_joint(force[:, 0]) * per_joint(np.maximum(v[:, 0], 0.0)),
        ContactState.SLIDING: friction,
        ContactState.TWISTING: friction,
        ContactState.CRUSHING: per_joint(np.maximum(-force[:, 0] * v[:, 0], 0.0)),
    }
    joints = {}
    for part, measure in measures.items():
        ranked = np.where(state.str.contains(part.value).to_numpy(), measure, 0.0)
        largest = ranked.max(initial=0.0)
        if largest > 0:
            order = np.argsort(-ranked, kind="stable")
            joints[part] = [str(state["interface"].to_numpy()[k]) for k in order if ranked[k] > text.SMALL * largest]
    return joints
