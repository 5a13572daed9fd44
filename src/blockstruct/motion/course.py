"""Compute the energies, certificates and memory of the states of a pushover."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import Any, Self

import numpy as np

from blockstruct.arrays import ROUNDING, SLIGHT, Array, Index
from blockstruct.limit import LimitProblem
from blockstruct.limit.certificate import certify
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.motion.moving_problem import MovedProblem, MovingProblem
from blockstruct.motion.nearest import nearest
from blockstruct.motion.state import MotionState
from blockstruct.solvers.splitting import LEAST
from blockstruct.solvers.step import RECENT, UNBALANCED
from blockstruct.statics.moved import MovedContacts, Placement
from blockstruct.statics.moving_cells import Crushed

#: Distance, in mean block sizes, up to which a contact point continues an earlier one. Shortest reach of detection.
SAME = 0.05
#: Largest flow-rule gap of a certificate that holds, relative to the work of the step, and largest interpenetration,
#: relative to the fastest point. A step shorter than recent ones may miss more, in proportion of its work. It is also
#: the largest equilibrium residual and yield excess.
CERTIFIED = UNBALANCED


class Course:
    """The states so far.

    Overlaps of blocks and elongations of ties give their forces. Friction remembers the forces of the last state. Cells
    of joints that crush remember the depth that they have lost.

    Parameters
    ----------
    problem
        The case at any placement.
    settings
        Settings of the case.
    """

    def __init__(self, problem: MovingProblem, settings: ProcedureSettings) -> None:
        self.problem, self._settings = problem, settings
        self._longest = self._tight = problem.lengths(Placement.of(problem.statics.model))
        self.last: MotionState | None = None
        #: Displacement, m, and load factor of each state without falling blocks.
        self.curve: list[tuple[float, float]] = []
        self._done = 0.0
        #: Work, J, of the steps without falling blocks. Short steps also correct the overlaps that longer ones leave.
        self._works: list[float] = []
        #: Work of the overlaps of the last state, J, and of the last complete one at its positions.
        self._overlap, self._completed = 0.0, (np.empty(0), 0.0)

    def take(self, state: MotionState) -> None:
        """Add a complete state.

        The curve begins at the first state whose certificate holds. Before that state, joints deform elastically.
        """
        dead, pushed = self._work(state)
        self._done += _sum_of(dead, pushed)
        position, overlap = self._completed
        self._overlap = overlap if position is state.position else self._overlap_of(state)
        self._longest, self._tight = self._lengths(Placement.at(state.position, state.rotation))
        self.last = state
        if not state.falls and (self.curve or state.holds):
            self.curve.append((state.displacement, state.load_factor))
            self._works.append(state.work * state.motion_time)

    def copied(self) -> Self:
        """Return a copy that takes states of its own."""
        other = copy(self)
        other.curve, other._works = list(self.curve), list(self._works)
        return other

    def at(self, placement: Placement, reach: float) -> MovedProblem:
        """Return the limit problem at a placement after the last state."""
        return self.problem.at(placement, reach, *self._lengths(placement), self._crushed(placement))

    def _crushed(self, placement: Placement) -> Crushed | None:
        """Return the memory of cells at a placement; None before the first state."""
        cells, last = self.problem.cells, self.last
        if last is None:
            return None
        force = _forces_of_cells(last, len(cells))
        return cells.after(_crushed_of(last), force, placement.position, placement.rotation)

    def _lengths(self, placement: Placement) -> tuple[Array, Array]:
        """Return the largest lengths (N,) of ties so far, and the lengths at which they begin to pull, m.

        Only ties that yield grow. Anchors move along chords, so other ties are longer after a step by the error of the
        chords, which the next step corrects.
        """
        lengths = self.problem.lengths(placement)
        longest = np.maximum(self._longest, lengths)
        if self.last is None:
            return longest, self._tight
        capacity = self.problem.statics.ties.capacity
        grown = np.maximum(self._tight, lengths - self.problem.compliance * capacity)
        yields = self.last.tie_force >= (1 - ROUNDING) * capacity
        return longest, np.where(yields, grown, self._tight)

    def complete(self, found: MotionState, moved: MovedProblem | None = None) -> MotionState:
        """Return a state with its energies and its certificate.

        The problem at its placement is set up if it is not given.
        """
        placement = Placement.at(found.position, found.rotation)
        moved = moved or self._at_state(found)
        problem, time, alpha = moved.problem, found.motion_time, found.load_factor
        x, T = forces_at(moved, found), found.tie_force[moved.holds] / problem.ties.force_unit
        u = moved.velocities(found.twist)
        inertia = self.problem.inertia @ u * (time / found.inertia_time**2)
        # Between tilted faces, the part of a cell that is crushed is at its strength.
        tilt = moved.of_cells(moved.contacts.cells.tilt, 0.0)
        part = x[:, 0] / np.where(tilt > 0, tilt, 1.0)
        c = certify(
            replace(
                problem,
                w_D=problem.w_D - inertia,
                compression=np.where(tilt > 0, np.minimum(part, problem.compression), problem.compression),
            ),
            x,
            u,
            alpha,
            self._settings,
            T,
            # Blocks that overlap are in contact, and ties that are stretched are tight.
            gap=np.maximum(moved.gap(time), 0.0),
            slack=np.maximum(moved.slack_in(time), 0.0),
            speed=problem.fastest(u),
        )
        dissipation, kinetic = dissipated(problem, x, T, u), float(u @ inertia)
        first = self.curve[0][1] if self.curve else alpha
        if self.problem.at_rest.settlement is not None:
            # The supports may have no reaction. A load factor of one is the dead load.
            first = 1.0
        # What drops is driven by the dead load.
        work = max(abs(alpha) + dissipation + kinetic, abs(float(problem.w_D @ u)), LEAST * abs(first))
        share = work * time / max([work * time, *self._works[-RECENT:]])
        missed = share * max(c.interpenetration, c.flow_rule_gap / work)
        state = replace(
            found,
            displacement=self.problem.control.displacement(placement),
            dissipation=dissipation,
            work=work,
            inertia=kinetic / work,
            falls=kinetic > SLIGHT * work,
            tie_elongation=moved.elongation,
            crushed_depth=moved.crushed.depth,
            crushed_slope=moved.crushed.slope,
            crushed_share=moved.crushed.share,
            largest_crushed_depth=float(moved.contacts.cells.lost.max(initial=0.0)),
            penetration=moved.penetration,
            equilibrium_residual=c.equilibrium_residual,
            yield_excess=c.yield_excess,
            interpenetration=c.interpenetration,
            flow_rule_gap=c.flow_rule_gap,
            holds=max(c.equilibrium_residual, c.yield_excess, missed) <= CERTIFIED,
            contact_points=len(moved.contacts.gap),
        )
        overlap = _overlap(moved, x)
        self._completed = state.position, overlap
        before = self.last
        if before is None or not self.curve:
            return replace(state, energy_error=0.0)
        # Work of the dead and of the variable loads, on the way that blocks have really gone, is dissipated, or pushes
        # blocks into each other until the next step, or crushes them.
        dead, pushed = self._work(state)
        rate = (before.dissipation + dissipated(problem, x, T, moved.velocities(carried(before, placement)))) / 2
        missed = abs(dead + pushed - before.motion_time * rate - (overlap - self._overlap))
        done = self._done + _sum_of(dead, pushed)
        return replace(state, energy_error=missed / max(done, 1e-300))

    def _overlap_of(self, state: MotionState) -> float:
        """Return the work of the overlaps of a state, J."""
        moved = self._at_state(state)
        return _overlap(moved, forces_at(moved, state))

    def _at_state(self, state: MotionState) -> MovedProblem:
        """Return the limit problem of a state after the last one.

        In the first state, cells remember the loading before the curve.
        """
        placement = Placement.at(state.position, state.rotation)
        if self.last is not None:
            return self.at(placement, state.reach)
        return self.problem.at(placement, state.reach, *self._lengths(placement), _crushed_of(state))

    def _work(self, state: MotionState) -> tuple[float, float]:
        """Return the work of both loads from the last state of the curve to another, J, by the trapezoidal rule."""
        before = self.last
        if before is None or not self.curve:
            return 0.0, 0.0
        one, other = (Placement.at(of.position, of.rotation) for of in (before, state))
        mean = (before.load_factor + state.load_factor) / 2
        return self.problem.dead.work(one, other), mean * self.problem.variable.work(one, other)


def recomputed(problem: MovingProblem, settings: ProcedureSettings, states: Sequence[MotionState]) -> list[MotionState]:
    """Compute the energies and certificates of states again."""
    course, found = Course(problem, settings), []
    for state in states:
        found.append(course.complete(state))
        course.take(found[-1])
    return found


def _sum_of(dead: float, pushed: float) -> float:
    """Return the sum of the work of the loads and of what resists them."""
    return abs(dead) + abs(pushed) + abs(dead + pushed)


def _overlap(moved: MovedProblem, x: Array) -> float:
    """Return the work of contact forces x (K, 3) on the way that closes overlaps, and of crushing so far, J.

    A cell is crushed, and closes its overlap, up to the overlap under its force.
    """
    cells, unit = moved.contacts.cells, moved.problem.force_unit
    way = moved.contacts.gap + moved.of_cells(cells.compliance, 0.0) * unit * x[:, 0] / 2
    return cells.work - float(x[:, 0] @ (unit * way))


def dissipated(problem: LimitProblem, x: Array, T: Array, u: Array) -> float:
    """Rate of work of friction and of ties, of forces x (K, 3) and T (M,) in a motion u (6 F,)."""
    v = (problem.A.T @ u).reshape(-1, 3)
    return float(T @ problem.ties.elongation(u) - np.einsum("kj,kj->", x[:, 1:], v[:, 1:]))


def carried(state: MotionState, placement: Placement) -> Array:
    """The screws of a state, as twists (B, 6) of the centroids at another placement."""
    way = placement.position - state.position
    return np.column_stack([state.velocity + np.cross(state.angular_velocity, way), state.angular_velocity])


def loaded(contacts: MovedContacts, force: Array) -> dict[str, Any]:
    """Contact points with a force, (K, 3) in N in the frame of each, as a state keeps them."""
    points = contacts.points
    frame, some = points.frame[points.interface], force.any(axis=1)
    return {
        "minus_of_contact": points.minus[some],
        "plus_of_contact": points.plus[some],
        "point_of_contact": points.position[some],
        "normal_of_contact": frame[some, 0],
        "force_of_contact": np.einsum("kij,ki->kj", frame, force)[some],
        "cell_of_contact": contacts.cell[some],
    }


def _crushed_of(state: MotionState) -> Crushed:
    """Return the memory of cells in a state."""
    return Crushed(state.crushed_depth, state.crushed_slope, state.crushed_share)


def _forces_of_cells(state: MotionState, cells: int) -> Array:
    """Return the normal forces (C,) of the cells of a state, N."""
    force, some = np.zeros(cells), state.cell_of_contact >= 0
    normal = np.einsum("ki,ki->k", state.force_of_contact, state.normal_of_contact)
    force[state.cell_of_contact[some]] = normal[some]
    return force


def forces_at(moved: MovedProblem, state: MotionState, reach: float = SAME) -> Array:
    """Return the forces (K, 3) of a state at the nearest contact points of a problem, within a reach.

    Points belong to the same two blocks and are compared in the axes of each block: a point of a block that slides
    stays where it was on one of the two. Two points at one place with different normals, as in an inner corner, differ.
    Cells of joints that crush keep their forces.
    """
    points, placement, length = moved.contacts.points, moved.placement, moved.problem.length
    before, force = Placement.at(state.position, state.rotation), np.zeros_like(points.position)
    minus, plus, frame = state.minus_of_contact, state.plus_of_contact, points.frame[points.interface]

    def places(ends: tuple[Index, Index], position: Array, normal: Array, at: Placement) -> list[Array]:
        """Return position and normal (K, 6) in the axes of the lower and of the upper block of each point."""
        towards = np.where(ends[0] < ends[1], reach, -reach)[:, None] * normal
        both = []
        for own in (np.minimum(*ends), np.maximum(*ends)):
            turn = at.rotation[own].transpose(0, 2, 1)
            way = (position - at.position[own]) / length
            both.append(np.concatenate([turn @ way[:, :, None], turn @ towards[:, :, None]], axis=1)[:, :, 0])
        return both

    ends = (minus, plus), (points.minus, points.plus)
    old = places(ends[0], state.point_of_contact, state.normal_of_contact, before)
    new = places(ends[1], points.position, frame[:, 0], placement)

    def apart(row: Index, at: Index) -> list[Array]:
        return [np.linalg.norm(b[at] - a[row], axis=1) for a, b in zip(old, new, strict=True)]

    def known(ends: tuple[Index, Index], cell: Index) -> tuple[Index, Index]:
        """Return the two blocks of each point; each cell has a number beyond all blocks."""
        one, other = (np.where(cell >= 0, len(placement.position) + cell, block) for block in ends)
        return one, other

    cells = state.cell_of_contact, moved.contacts.cell
    of_points = known(ends[0], cells[0]), known(ends[1], cells[1])
    row, at, distance = nearest(*of_points, lambda row, at: np.minimum(*apart(row, at)))
    same = (distance <= reach) | (cells[0][row] >= 0)
    row, at = row[same], at[same]
    # Forces turn with the block in whose axes the point is where it was.
    of_lower, of_upper = apart(row, at)
    own = np.where(of_lower <= of_upper, np.minimum(minus, plus)[row], np.maximum(minus, plus)[row])
    turned = np.einsum("kij,klj,kl->ki", placement.rotation[own], before.rotation[own], state.force_of_contact[row])
    turned *= np.where(minus[row] == points.minus[at], 1.0, -1.0)[:, None]
    np.add.at(force, at, np.einsum("kij,kj->ki", frame[at], turned) / moved.problem.force_unit[at, None])
    return force
