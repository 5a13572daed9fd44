"""Follow a collapse state through finite displacements: pushovers and settlements."""

from collections.abc import Generator, Sequence
from dataclasses import replace

import numpy as np
import shapely

from blockstruct.arrays import Array, Index
from blockstruct.limit import Iteration
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.model import SettlementCase
from blockstruct.motion.course import CERTIFIED, SAME
from blockstruct.motion.moving_problem import MovedProblem, MovingProblem
from blockstruct.motion.nearest import nearest
from blockstruct.motion.pushover import PushoverPath, outcome_of
from blockstruct.motion.settlement import SettlementPath
from blockstruct.motion.state import ZERO, CurveOutcome, MotionState
from blockstruct.statics.moved import Placement
from blockstruct.vocabulary import CurveEnd

States = Generator[MotionState, None, CurveOutcome]


def follow(
    problem: MovingProblem,
    collapse: Iteration,
    settings: ProcedureSettings,
    before: Sequence[MotionState] = (),
) -> States:
    """Follow a collapse mechanism through finite displacements.

    In each step the work of the variable load is prescribed, and with it the way of the control point. The variable
    load of a settlement is the reaction of its supports, which go this way. Blocks then move along the screws of their
    twists, and contacts are found anew where they are. The load factor belongs to the geometry at the beginning of the
    step. Blocks that nothing holds fall, while the control point waits.

    Parameters
    ----------
    problem
        The case, wherever its blocks are.
    collapse
        The certified collapse state, whose mechanism is the first motion.
    settings
        Of the case.
    before
        Known states of the curve, which continues after the last state.

    Yields
    ------
    MotionState
        A state; the first state has no displacement.

    Returns
    -------
    CurveOutcome
        How it ended.
    """
    rest = Placement.of(problem.statics.model)
    mechanism = _mechanism(problem, collapse, rest)
    speed = abs(problem.control.velocity(rest, mechanism))
    if speed <= ZERO * np.linalg.norm(mechanism[:, :3], axis=1).max():
        return replace(outcome_of(problem, CurveEnd.RESTS, mechanism), displacement=0.0)
    kind = SettlementPath if isinstance(problem.case, SettlementCase) else PushoverPath
    path = kind(problem, collapse, settings)
    for known in before:
        path.take(known)
    if not before:
        first = path.begun(mechanism)
        if first is None:
            return replace(outcome_of(problem, CurveEnd.NOT_SOLVED, mechanism), displacement=0.0)
        alpha = collapse.load_factor
        if first.load_factor - alpha > max(CERTIFIED * abs(alpha), ZERO * path.scale):
            beyond = _beyond_interfaces(problem, first, rest)
            if beyond:
                return CurveOutcome(CurveEnd.BEGINS_ABOVE, 0.0, first.load_factor, 0, beyond)
        yield path.take(first)
    while (end := path.end()) is None:
        following = path.advance()
        if following is None:
            return path.outcome(path.lost())
        yield path.take(following)
    return path.outcome(end)


def _mechanism(problem: MovingProblem, collapse: Iteration, rest: Placement) -> Array:
    """Twists (B, 6) of the collapse mechanism at 1 W."""
    return np.asarray(_at_rest(problem, rest, SAME).twist(collapse.u))


def _at_rest(problem: MovingProblem, rest: Placement, reach: float) -> MovedProblem:
    """Return the problem before blocks move, with contacts up to a reach, in mean block sizes."""
    lengths = problem.lengths(rest)
    return problem.at(rest, reach * problem.statics.length, lengths, lengths)


def _beyond_interfaces(problem: MovingProblem, first: MotionState, rest: Placement) -> tuple[str, ...]:
    """Return the names of blocks that press on each other beyond the interfaces of the model, as ``one|other``.

    Blocks that touch along an edge only, where there can be no interface, are left out.
    """
    points, names = problem.statics.points, [b.name for b in problem.statics.model.blocks]
    axes, (_, some) = points.frame[:, 1:], np.unique(points.interface, return_index=True)
    own = np.einsum("kij,kj->ki", axes[points.interface], points.position)
    # The resultant of an interface acts anywhere in the convex hull of its points.
    hulls = shapely.convex_hull(shapely.multipoints(own, indices=points.interface))

    def outside(row: Index, at: Index) -> Array:
        place = np.einsum("kij,kj->ki", axes[at], first.point_of_contact[row])
        return np.asarray(shapely.distance(hulls[at], shapely.points(place)))

    ends = first.minus_of_contact, first.plus_of_contact
    row, _, distance = nearest(ends, (points.minus[some], points.plus[some]), outside)
    beyond = np.ones(len(ends[0]), dtype=bool)
    beyond[row[distance <= SAME * problem.statics.length]] = False
    pairs = np.unique(np.sort(np.column_stack(ends)[beyond]), axis=0)
    touching = _at_rest(problem, rest, ZERO).contacts.points
    found = np.sort(np.column_stack([touching.minus, touching.plus]))

    def share_area(pair: Array) -> bool:
        along = np.diff(touching.position[(found == pair).all(axis=1)], axis=0)
        return bool(np.linalg.matrix_rank(along, ZERO * problem.statics.length) > 1)

    return tuple(f"{names[i]}|{names[j]}" for i, j in filter(share_area, pairs))
