"""Independent motions in a collapse state."""

from collections.abc import Collection, Sequence

import numpy as np

from blockstruct.arrays import ROUNDING, SLIGHT, Array
from blockstruct.assess.participation import HorizontalForces
from blockstruct.model import TieSegment, tie_segments
from blockstruct.results import MacroBlock
from blockstruct.results.case_result import CaseResult
from blockstruct.results.interfaces import NO_FORCE, at_points
from blockstruct.results.ties import tie_state
from blockstruct.vocabulary import TieState


def separate_mechanisms(
    result: CaseResult, forces: HorizontalForces, bodies: Sequence[MacroBlock]
) -> list[list[MacroBlock]]:
    """Return the moving bodies in sets that exchange no work, each in the order of the bodies.

    Façades that stand apart and reach their load factor together may each move at any rate: each is a mechanism by
    itself. Work passes through a joint whose force moves with both of its bodies, and along a stressed tie that does
    not give way. Bodies that exchange almost no work count as apart. This is on the safe side: the largest e* of the
    parts is never below the e* of all bodies (Cauchy's inequality).

    Parameters
    ----------
    result
        The collapse state.
    forces
        Forces of its variable load. Sets of bodies on which they do no work are left out.
    bodies
        ``result.macro_blocks``.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    moving = [body for body in bodies if body.moves]
    body_of = {name: k for k, body in enumerate(moving) for name in body.blocks}
    model = result.model
    sides = [[getattr(i, side) for i in model.interfaces] for side in ("minus", "plus")]
    # Supports and bodies at rest exchange no work.
    one, other = (np.array([body_of.get(name, -1) for name in names]) for names in sides)
    passed = np.min([_work(result, names) for names in sides], axis=0)
    own = np.array([body.total * np.linalg.norm(body.translation) for body in moving])
    joined = (one >= 0) & (other >= 0) & (passed > SLIGHT * np.minimum(own[one], own[other]))
    pairs = np.column_stack([one, other])[joined].tolist()
    pairs += [[body_of[name] for name in tie.blocks] for tie in _stressed(result, body_of)]
    start, end = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    graph = coo_array((np.ones(len(start)), (start, end)), shape=(len(moving), len(moving)))
    count, part = connected_components(graph, directed=False)
    of_force = np.array([body_of.get(b.name, -1) for b in model.blocks])[forces.block]
    work = np.where(of_force >= 0, forces.weight * forces.displacements(model, result.mechanism), 0.0)
    pushed = np.bincount(part[of_force], work, minlength=count)
    found = np.flatnonzero(np.abs(pushed) > SLIGHT * np.bincount(part, own, minlength=count))
    return [[body for body, of in zip(moving, part, strict=True) if of == k] for k in found] or [moving]


def _stressed(result: CaseResult, blocks: Collection[str]) -> list[TieSegment]:
    """Return the stressed ties between some blocks that do not give way at collapse."""
    model = result.model
    if not model.ties:
        return []
    stressed = (tie_state(result.history.isel(iteration=-1)) == TieState.STRESSED).to_numpy()
    segments = zip(tie_segments(model.ties, model.blocks), stressed, strict=True)
    return [tie for tie, holds in segments if holds and all(name in blocks for name in tie.blocks)]


def _work(result: CaseResult, blocks: Sequence[str]) -> Array:
    """Return the absolute work (J,) of forces at each joint on one of its blocks."""
    last, model, mechanism = result.history.isel(iteration=-1), result.model, result.mechanism
    of_point = last["interface_of_contact_point"].to_numpy()
    block = np.array([model.block_index[name] for name in blocks])[of_point]
    shift, turn = (mechanism[name].transpose("block", "axis").to_numpy()[block] for name in ("translation", "rotation"))
    arm = last["contact_point_position"].to_numpy() - np.array([b.centroid for b in model.blocks])[block]
    v = np.einsum("kij,kj->ki", last["interface_frame"].to_numpy()[of_point], shift + np.cross(turn, arm))
    work = v * at_points(last, "contact_force")
    # Friction may take the work of normal forces: only its own weight and push may move a lintel.
    each = np.abs(work[:, 0]) + np.abs(work[:, 1:].sum(axis=1))
    return np.asarray(np.bincount(of_point, each, minlength=len(blocks)))


def is_unique(result: CaseResult, bodies: Sequence[MacroBlock]) -> bool:
    """Return whether moving bodies have one motion only, up to its size.

    If each course of a tower is about to turn over the one below, each joint may open by itself, and the motion found
    is an arbitrary mixture. All motions count that keep the direction of the relative motion at each loaded joint, and
    the length of each stressed tie.

    Parameters
    ----------
    result
        The collapse state.
    bodies
        One set of :func:`separate_mechanisms`, and the bodies at rest.
    """
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import eigsh

    model, last = result.model, result.history.isel(iteration=-1)
    moving = [body for body in bodies if body.moves]
    # Bodies at rest support the others; bodies of another mechanism do not.
    number = {b.name: -1 for b in model.blocks if b.fixed} | {n: -1 for body in bodies for n in body.blocks}
    number |= {name: k for k, body in enumerate(moving) for name in body.blocks}
    centre, length = np.mean([body.centroid for body in moving], axis=0), model.characteristic_length
    turn = length * np.array([*(body.rotation for body in moving), np.zeros(3)])
    arm = np.array([*(body.centroid - centre for body in moving), np.zeros(3)]) / length
    shift = np.array([*(body.translation for body in moving), np.zeros(3)]) - np.cross(turn, arm)
    u = np.column_stack([shift, turn])

    def at(points: Array) -> Array:
        """Return the matrices (J, 6, 6) from velocity and rotation at the centre to points (J, 3), m."""
        r = (points - centre) / length
        found = np.tile(np.eye(6), (len(r), 1, 1))
        found[:, :3, 3:] = np.cross(np.eye(3), r[:, None, :]).swapaxes(1, 2)
        return found

    pairs = [(number.get(i.minus, -2), number.get(i.plus, -2)) for i in model.interfaces]
    force = np.linalg.norm(at_points(last, "contact_force"), axis=1)
    pressed = np.bincount(last["interface_of_contact_point"].to_numpy(), force, minlength=len(pairs))
    # Forces are relative to the weight of the lesser body.
    least = NO_FORCE * np.array([*(body.total for body in moving), np.inf, np.inf])
    loaded = [k for k, (a, b) in enumerate(pairs) if a != b and min(a, b) > -2 and pressed[k] > min(least[[a, b]])]
    minus, plus = np.array([pairs[k] for k in loaded], dtype=np.int64).reshape(-1, 2).T
    there = at(np.array([model.interfaces[k].polygon.mean(axis=0) for k in loaded]).reshape(-1, 3))
    goes = np.einsum("jab,jb->ja", there, u[plus] - u[minus])
    size = np.linalg.norm(goes, axis=1)
    way = np.where(size > SLIGHT, 1 / np.maximum(size, SLIGHT), 0.0)[:, None] * goes
    across = there - way[:, :, None] * np.einsum("ja,jab->jb", way, there)[:, None]
    ends = [(minus, -across), (plus, across)]
    ties = _stressed(result, number)
    anchor = np.array([(tie.start, tie.end) for tie in ties]).reshape(-1, 2, 3)
    along = anchor[:, 1] - anchor[:, 0]
    along /= np.linalg.norm(along, axis=1)[:, None]
    for k, sign in ((0, -1.0), (1, 1.0)):
        longer = np.zeros((len(ties), 6, 6))
        longer[:, 0] = sign * np.einsum("ta,tab->tb", along, at(anchor[:, k])[:, :3])
        body = np.array([number[tie.blocks[k]] for tie in ties], dtype=np.int64)
        ends[k] = np.concatenate([ends[k][0], body]), np.concatenate([ends[k][1], longer])
    resistance = np.zeros((len(moving) + 1, len(moving) + 1, 6, 6))
    for one, rows in ends:
        for other, columns in ends:
            np.add.at(resistance, (one, other), np.einsum("jca,jcb->jab", rows, columns))
    n = 6 * len(moving)
    matrix = csc_array(resistance[:-1, :-1].transpose(0, 2, 1, 3).reshape(n, n))
    least_two = eigsh(matrix, 2, sigma=-ROUNDING, v0=np.ones(n), return_eigenvectors=False)
    # One joint resists with about one. Motions are accurate to about 1e-6, and long chains of bodies resist little.
    return bool(least_two.max() > ROUNDING)
