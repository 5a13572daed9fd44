"""Mechanisms of their own within one collapse state: sets of bodies that pass no work on to each other."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from blockstruct.assess.participation import HorizontalForces
from blockstruct.model import tie_segments
from blockstruct.results import CaseResult, MacroBlock, tie_state
from blockstruct.vocabulary import TieState

Array = NDArray[np.float64]

#: Work, relative to weight times motion of the lesser of two bodies, that is none.
_NOTHING = 1e-3


def separate_mechanisms(
    result: CaseResult, forces: HorizontalForces, bodies: Sequence[MacroBlock]
) -> list[list[MacroBlock]]:
    """Bodies that move, in sets between which no work passes, each in the order of the bodies.

    Façades that stand apart and reach their load factor at once may each move as fast as it likes: whatever their
    motion is together, each of theirs is a mechanism. Work passes through a joint whose force moves with both of its
    bodies, and along a tie that is stressed and does not give way. Bodies between which next to none passes are taken
    to be apart. That is on the safe side: the largest e* of the parts is never below that of all (Cauchy's inequality).

    Parameters
    ----------
    result
        The collapse state.
    forces
        Of its variable load. Sets of bodies on which they do no work are left out.
    bodies
        ``result.macro_blocks``.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    moving = [body for body in bodies if body.moves]
    body_of = {name: k for k, body in enumerate(moving) for name in body.blocks}
    model, last = result.model, result.history.isel(iteration=-1)
    sides = [[getattr(i, side) for i in model.interfaces] for side in ("minus", "plus")]
    # Supports, and bodies at rest, take on no work.
    one, other = (np.array([body_of.get(name, -1) for name in names]) for names in sides)
    passed = np.min([_work(result, names) for names in sides], axis=0)
    own = np.array([body.total * np.linalg.norm(body.translation) for body in moving])
    joined = (one >= 0) & (other >= 0) & (passed > _NOTHING * np.minimum(own[one], own[other]))
    pairs = np.column_stack([one, other])[joined].tolist()
    if model.ties:
        stressed = (tie_state(last) == TieState.STRESSED).to_numpy()
        of_ties = [s.blocks for s, holds in zip(tie_segments(model.ties, model.blocks), stressed, strict=True) if holds]
        pairs += [[body_of[name] for name in blocks] for blocks in of_ties if set(blocks) <= body_of.keys()]
    start, end = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    graph = coo_array((np.ones(len(start)), (start, end)), shape=(len(moving), len(moving)))
    count, part = connected_components(graph, directed=False)
    of_force = np.array([body_of.get(b.name, -1) for b in model.blocks])[forces.block]
    work = np.where(of_force >= 0, forces.weight * forces.displacements(model, result.mechanism), 0.0)
    pushed = np.bincount(part[of_force], work, minlength=count)
    found = np.flatnonzero(np.abs(pushed) > _NOTHING * np.bincount(part, own, minlength=count))
    return [[body for body, of in zip(moving, part, strict=True) if of == k] for k in found] or [moving]


def _work(result: CaseResult, blocks: Sequence[str]) -> Array:
    """Work (J,) of normal forces and of friction at each joint on one of its blocks, by name, whatever its sign."""
    last, model, mechanism = result.history.isel(iteration=-1), result.model, result.mechanism
    of_point = last["interface_of_contact_point"].to_numpy()
    block = np.array([model.block_index[name] for name in blocks])[of_point]
    shift, turn = (mechanism[name].transpose("block", "axis").to_numpy()[block] for name in ("translation", "rotation"))
    arm = last["contact_point_position"].to_numpy() - np.array([b.centroid for b in model.blocks])[block]
    v = np.einsum("kij,kj->ki", last["interface_frame"].to_numpy()[of_point], shift + np.cross(turn, arm))
    work = v * last["contact_force"].transpose("contact_point", "component").to_numpy()
    # What normal forces give friction may take: all that moves a lintel may be its own weight and push.
    each = np.abs(work[:, 0]) + np.abs(work[:, 1:].sum(axis=1))
    return np.asarray(np.bincount(of_point, each, minlength=len(blocks)))
