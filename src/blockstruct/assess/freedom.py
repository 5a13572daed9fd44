"""Motions of a collapse state: the independent ones, and the one that the least acceleration activates.

Forces x in equilibrium at the load factor α₀ give every motion u a multiplier by virtual work. Friction keeps its limit
at the normal forces of x::

    α(u) = α₀ + G(u) / Σ(P+Q)δ,   G(u) = Σ (largest work of each joint and tie at u, less the work of x) ≥ 0

G is the flow-rule gap of the certificate. It vanishes for the collapse mechanism and for every other mechanism that x
admits. The motion is activated at the acceleration ``α(u) g / (e*(u) FC)``, and e* differs between motions. The check
thus needs the least value over all motions, and not the value of the mechanism that a procedure ended at.

With ``Σ(P+Q)δ = 1``, ``f = α(u)`` is convex, and ``q = 1/e* = Σ(P+Q) Σ(P+Q)δ²`` is a convex quadratic form. For any
weight λ > 0, ``f q ≤ (f + λ q)² / 4 λ``, with equality at ``λ = f/q``. So convex programs that minimise ``f + λ q``,
each with the λ of the motion before, never raise the product ``f q``. They end once this bound is close to the product.

The number of bodies decides e*, too: two bodies that nearly turn as one have e* = 0.8 where one body has 1. So the two
bodies that move apart least are joined to a rigid one, and the programs are repeated. Bodies stay apart if α(u) alone
would exceed the least acceleration so far. No further body that is joined makes α(u) less, so the search ends once α(u)
is within a thousandth of that acceleration. A joint that is closed
costs work, which α(u) counts. The least acceleration therefore does not jump where a joint opens by more or less than a
tolerance.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import ROUNDING, SLIGHT, Array, Index
from blockstruct.assess.participation import HorizontalForces, Participation
from blockstruct.limit import ConicProgram, LimitProblem
from blockstruct.limit.friction import Sliding, frozen_sliding
from blockstruct.limit.motion import joined, unit_of_velocity
from blockstruct.limit.problem import total
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.model import TieSegment, tie_segments
from blockstruct.results import MacroBlock
from blockstruct.results.case_result import CaseResult
from blockstruct.results.history import division_of
from blockstruct.results.interfaces import NO_FORCE, at_points
from blockstruct.results.mechanism import twists, velocities
from blockstruct.results.ties import tie_state
from blockstruct.solvers import ClarabelSolver
from blockstruct.statics.statics import Statics
from blockstruct.vocabulary import SolverStatus, TieState


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
    last, model = result.history.isel(iteration=-1), result.model
    of_point = last["interface_of_contact_point"].to_numpy()
    block = np.array([model.block_index[name] for name in blocks])[of_point]
    v = velocities(model, twists(result.mechanism), block, last["contact_point_position"].to_numpy())
    v = np.einsum("kij,kj->ki", last["interface_frame"].to_numpy()[of_point], v)
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


#: Accuracy of the programs.
_ACCURATE = 1e-8


@dataclass(frozen=True, slots=True)
class Activation:
    """A motion and the multiplier that activates it.

    Attributes
    ----------
    alpha : float
        Multiplier of the weights P + Q, by virtual work of the forces of the collapse state.
    e_star : float
        Share of the mass that takes part.
    bodies : int
        Number of bodies that e* counts.
    motion : (blocks, 6) array or None
        Velocity of the centroids and angular velocity, SI; None for the collapse mechanism.
    """

    alpha: float
    e_star: float
    bodies: int
    motion: Array | None = None

    @property
    def acceleration(self) -> float:
        """``α / e*``: spectral acceleration that activates the motion without a confidence factor, in g."""
        return self.alpha / self.e_star


def least_activation(
    result: CaseResult, forces: HorizontalForces, bodies: Sequence[MacroBlock], counted: Participation
) -> Activation:
    """Return the motion that the least acceleration activates, or the collapse mechanism.

    Parameters
    ----------
    result
        The collapse state.
    forces
        Forces of its variable load.
    bodies
        Moving bodies of one mechanism. All other blocks stay at rest.
    counted
        Participation of the bodies that e* counts.
    """
    alpha0 = result.load_factor * forces.share
    best = Activation(alpha0, counted.e_star, len(counted.names))
    # No motion has more than e* = 1.
    if best.e_star > 1 - SLIGHT or not alpha0 > 0:
        return best
    search, weight = _Search.of(result, forces, bodies, counted), best.alpha * best.e_star
    found = search.least(weight, best.acceleration)
    while found is not None:
        if found.acceleration < (1 - SLIGHT) * best.acceleration:
            motion = np.zeros((len(result.model.blocks), 6))
            motion[search.blocks] = found.motion
            best, weight = Activation(found.alpha, 1 / found.q, search.count, motion), found.weight
        # Without this end, a house of 289 blocks takes 56 programs instead of 18.
        if found.alpha > (1 - SLIGHT) * best.acceleration:
            break
        nearest, found = search.nearest(found.motion), None
        for pair in nearest:
            joined_to = search.joining(pair)
            found = joined_to.least(weight, best.acceleration)
            if found is not None:
                search = joined_to
                break
            search = replace(search, apart=search.apart | {pair})
    return best


@dataclass(frozen=True, slots=True)
class _Found:
    """Motion of a program: multiplier α, q = 1/e*, and velocities (F, 6) of the blocks, SI."""

    alpha: float
    q: float
    motion: Array

    @property
    def acceleration(self) -> float:
        return self.alpha * self.q

    @property
    def weight(self) -> float:
        """The λ of the next program."""
        return self.alpha / self.q


@dataclass(frozen=True, slots=True)
class _Search:
    """Motions of the moving blocks of one mechanism with certified forces.

    Attributes
    ----------
    problem, sliding, settings
        Limit problem of the moving blocks, friction at the certified normal forces, and settings of the programs.
    alpha, share
        Load factor, and the multiplier of the weights at load factor 1.
    blocks : (F,) array
        Indices of the moving blocks in the model.
    centroid, weight : (F, 3) and (F,) arrays
        m, and P + Q in N.
    body : (F,) array
        Number of the body of each block that e* counts; −1 without one.
    joints : tuple of (int, int, (n, 3) array)
        Both blocks and the corners, m, of each joint between moving blocks.
    rigid : frozenset of int
        Bodies that are rigid because they were joined.
    apart : frozenset of (int, int)
        Pairs of bodies that stay apart.
    """

    problem: LimitProblem
    sliding: Sliding
    settings: ProcedureSettings
    alpha: float
    share: float
    blocks: Index
    centroid: Array
    weight: Array
    body: Index
    joints: tuple[tuple[int, int, Array], ...]
    rigid: frozenset[int] = frozenset()
    apart: frozenset[tuple[int, int]] = frozenset()

    @classmethod
    def of(
        cls, result: CaseResult, forces: HorizontalForces, bodies: Sequence[MacroBlock], counted: Participation
    ) -> Self:
        model, last = result.model, result.history.isel(iteration=-1)
        statics = Statics.of(model, division_of(model, result.settings.crushing_cells, result.history))
        whole = result.final_problem(statics)
        n = at_points(last, "contact_force")[:, 0] / whole.force_unit
        moves = {name for body in bodies for name in body.blocks}
        moving = np.array([model.blocks[i].name in moves for i in statics.free])
        sliding, at = frozen_sliding(whole, n), whole.points_of(moving)
        blocks = statics.free[moving]
        place = {model.blocks[i].name: k for k, i in enumerate(blocks)}
        number = np.full(len(blocks), -1)
        for k, body in enumerate(one for one in bodies if one.name in counted.names):
            number[[place[name] for name in body.blocks]] = k
        return cls(
            problem=whole.part(moving),
            sliding=Sliding(sliding.bound[at], sliding.slope[at]),
            settings=replace(result.settings, crushing="conic"),
            alpha=result.load_factor,
            share=forces.share,
            blocks=blocks,
            centroid=np.array([model.blocks[i].centroid for i in blocks]),
            weight=np.bincount(forces.block, forces.weight, len(model.blocks))[blocks],
            body=number,
            joints=tuple(
                (place[i.minus], place[i.plus], i.polygon)
                for i in model.interfaces
                if {i.minus, i.plus} <= place.keys()
            ),
        )

    @property
    def count(self) -> int:
        """Number of bodies that e* counts."""
        return len(np.unique(self.body[self.body >= 0]))

    def solved(self, weight: float) -> _Found | None:
        """Return the motion of least ``α + λ q`` for a weight λ; None if the solver fails."""
        blocks = np.arange(len(self.body))
        for body in self.rigid:
            blocks[self.body == body] = np.flatnonzero(self.body == body)[0]
        problem, motion, between = joined(self.problem, self.centroid, np.unique(blocks, return_inverse=True)[1])
        pushed = np.where(np.repeat(self.body >= 0, 6), self.problem.w_L, 0.0)
        mass = self.weight[self.body >= 0].sum()
        means = []
        for body in np.unique(self.body[self.body >= 0]):
            mine = self.body == body
            own = np.where(np.repeat(mine, 6), pushed, 0.0)
            means.append(own * np.sqrt(mass / self.weight[mine].sum()))
        # w_L·u of a body is share P δ, so these columns give √(ΣP P) δ, with Σ share P δ = 1.
        columns = motion.T @ np.column_stack(means)
        problem = replace(problem, w_D=problem.w_D + self.alpha * problem.w_L, w_L=motion.T @ pushed)
        scale = np.sqrt(2 * weight / self.share / total(problem.w_L))
        program = ConicProgram(problem, self.settings, sp.csc_array(scale * columns))
        sliding = Sliding(self.sliding.bound[between], self.sliding.slope[between])
        solution = ClarabelSolver().solve(program, program.data(sliding), _ACCURATE)
        if solution.status not in (SolverStatus.SOLVED, SolverStatus.ALMOST_SOLVED):
            return None
        extra, _, u = program.unpack(solution)
        q = float(((columns.T @ u) ** 2).sum())
        # By duality the springs double their cost in the load factor.
        alpha = self.share * (self.alpha + extra) - 2 * weight * q
        # No motion has less than α₀ or more than e* = 1, apart from rounding.
        velocities = (motion @ u).reshape(-1, 6) / unit_of_velocity(self.problem)
        return _Found(max(alpha, self.share * self.alpha), max(q, 1.0), velocities)

    def least(self, weight: float, limit: float) -> _Found | None:
        """Return the motion of least acceleration from a first λ on; None if its multiplier exceeds a limit."""
        found = self.solved(weight)
        if found is None or found.alpha >= limit:
            return None
        while (weight - found.weight) ** 2 > 4 * SLIGHT * weight * found.weight:
            weight, again = found.weight, self.solved(found.weight)
            if again is None or again.acceleration >= (1 - SLIGHT) * found.acceleration:
                break
            found = again
        return found

    def joining(self, pair: tuple[int, int]) -> "_Search":
        """Return the search in which two bodies are one rigid body."""
        one, other = pair
        apart = (sorted(one if body == other else body for body in bodies) for bodies in self.apart)
        return replace(
            self,
            body=np.where(self.body == other, one, self.body),
            rigid=(self.rigid - {other}) | {one},
            apart=frozenset((first, second) for first, second in apart),
        )

    def nearest(self, motion: Array) -> list[tuple[int, int]]:
        """Return the pairs of bodies that touch and may be joined, those that move apart least in a motion first."""
        apart: dict[tuple[int, int], float] = {}
        for minus, plus, corners in self.joints:
            one, other = sorted((int(self.body[minus]), int(self.body[plus])))
            if one < 0 or one == other or (one, other) in self.apart:
                continue
            v = [motion[k, :3] + np.cross(motion[k, 3:], corners - self.centroid[k]) for k in (minus, plus)]
            fastest = float(np.linalg.norm(v[1] - v[0], axis=1).max())
            apart[one, other] = min(apart.get((one, other), np.inf), fastest)
        return sorted(apart, key=lambda pair: apart[pair])
