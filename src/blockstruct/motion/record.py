"""Follow a structure through an acceleration of the ground."""

from bisect import bisect_right
from collections.abc import Generator
from dataclasses import replace
from math import ceil

import numpy as np

from blockstruct.arrays import NEGLIGIBLE, SLIGHT, Array
from blockstruct.limit.response import Fall, RecordState
from blockstruct.model import STANDARD_GRAVITY, Model, RecordCase
from blockstruct.model.fields import label
from blockstruct.motion.dynamics import COMPLIANCE, SPLIT, ContactForces, Contacts, Dynamics, Motion, Step
from blockstruct.motion.masses import Masses
from blockstruct.motion.moving_problem import check_in_motion
from blockstruct.statics.moved import MovingLoads, MovingStructure, Placement
from blockstruct.statics.moving_cells import Crushed
from blockstruct.statics.statics import Statics
from blockstruct.vocabulary import Reason

#: Steps in the time √(r / g) of the smallest block, with r its radius of gyration. Contacts are found as far away as
#: the fastest block goes in as many steps.
RESOLUTION = 48
#: Most states of a record, and the shortest time between two, s.
STATES, SHORTEST = 200, 0.01
#: Slip of contacts up to which they are followed, and least gap, in sizes of the smallest block. Contacts are found
#: anew when a contact may have slipped by the one, or two blocks together have moved by the gap; from a state that is
#: kept after half of that, or after this number of states.
REACH, KEPT = 0.02, 16
#: Longest motion after the record, s, if the record is not longer itself.
AFTER = 30.0

States = Generator[RecordState, None, Reason]


def respond(statics: Statics, case: RecordCase, before: RecordState | None = None) -> States:
    """Follow a structure through a record and until it is at rest, or has collapsed.

    Parameters
    ----------
    statics, case
        The structure, which stands under the dead load, and the record.
    before
        A known state with ``finds_contacts``, after which the response continues as without a break.

    Yields
    ------
    RecordState
        The first is at rest, the others follow in equal intervals. The last one is that in which a block has fallen, if
        it has.

    Returns
    -------
    Reason
    """
    run = _Run(statics, case)
    state = before
    if state is None:
        state = run.at_rest()
        yield state
    while not (ended := run.ended(state)):
        following = run.advance(state)
        if following is None:
            return Reason.STEP_NOT_SOLVED
        state = following
        yield state
    return ended


def time_step(statics: Statics, case: RecordCase) -> float:
    """Return the length of the steps of a response, s: equal parts of the interval between its states."""
    interval = kept_interval(case)
    longest = case.time_step or _longest_step(statics, Masses.of(statics.model, case.dead, label(case)))
    return interval / ceil(interval / longest * (1 - 1e-12))


def _longest_step(statics: Statics, masses: Masses) -> float:
    """Return the longest step, s, which the smallest block and those that bear much more than their weight limit.

    Contacts deform by a share :data:`COMPLIANCE` of the way that their force moves a block in a step. Under the weight
    above a block, this is at most a slight share of its thickness, so that thin or light layers keep apart what they
    bear. This weight is that of the blocks whose centroids are higher and which overlap in plan.
    """
    blocks, free = [statics.model.blocks[k] for k in statics.free], statics.free
    corners = [b.shape.vertices for b in blocks]
    low, high = (np.array([extreme(c, axis=0) for c in corners])[:, :2] for extreme in (np.min, np.max))
    meet = (low[:, None] < high).all(axis=2) & (low < high[:, None]).all(axis=2)
    level, mass = np.array([b.centroid[2] for b in blocks]), masses.mass[free]
    borne = mass + np.where(meet & (level > level[:, None]), mass, 0.0).sum(axis=1)
    thickness = np.array([np.ptp(c @ b.shape.normals.T, axis=0).min() for c, b in zip(corners, blocks, strict=True)])
    way = np.minimum(masses.size[free] / RESOLUTION**2, SLIGHT / COMPLIANCE * thickness * mass / borne)
    return float(np.sqrt(way.min() / STANDARD_GRAVITY))


def kept_interval(case: RecordCase) -> float:
    """Return the time between two states that are kept, s."""
    return float(case.interval or max(case.duration / STATES, SHORTEST))


class _Run:
    def __init__(self, statics: Statics, case: RecordCase) -> None:
        model, who = statics.model, f"record case {case.name!r}"
        check_record(model, case)
        self._statics, self._case = statics, case
        self._free = statics.free
        self._masses = Masses.of(model, case.dead, who)
        self._dead = MovingLoads.of(model, case.dead, case.dead)
        # Loads through the centres of mass do not change in motion.
        plain = not (self._dead.lever.any() or self._masses.offset.any())
        self._weight = self._dead.wrench if plain else None
        none = np.empty(0)
        self._contacts: tuple[Contacts | None, Array, Array, float, float, int] = None, none, none, 0.0, 0.0, 0
        smallest = min(float(np.cbrt(model.blocks[k].volume)) for k in self._free)
        self._h, self._follows = time_step(statics, case), REACH * smallest
        self._dynamics = Dynamics(MovingStructure(statics), self._masses, self._h)
        self._start = Placement.of(model)
        self._fixed = np.array([b.fixed for b in model.blocks])
        self._fall = Fall.of(model)
        self._radius = np.array([np.linalg.norm(b.shape.vertices - b.centroid, axis=1).max() for b in model.blocks])
        m = self._masses
        #: Kinetic energy (B,) below which a block is at rest, J.
        self._rest = NEGLIGIBLE * STANDARD_GRAVITY * m.mass * m.size
        self._times, ground = case.times, case.ground
        self._moments = self._times.tolist()
        # The integral of the acceleration, which is linear between samples: a step takes the mean over its impulse.
        steps = np.diff(self._times)[:, None] * (ground[1:] + ground[:-1]) / 2
        self._ground, self._velocity = ground, np.concatenate([np.zeros((1, 3)), steps.cumsum(axis=0)])
        self._begin, self._end = float(self._times[0]), float(self._times[-1])

    def at_rest(self) -> RecordState:
        """Return the state at the beginning."""
        B, cells = len(self._fixed), self._dynamics.undamaged
        no_block, no_force = np.empty(0, dtype=np.int64), np.zeros(len(self._statics.ties))
        return RecordState(
            time=self._begin,
            displacement=np.zeros((B, 3)),
            rotation=np.zeros((B, 3)),
            velocity=np.zeros((B, 3)),
            angular_velocity=np.zeros((B, 3)),
            peak_displacement=np.zeros(B),
            ground_acceleration=self._acceleration(self._begin),
            base_reaction=-self._dead.wrench[self._free, :3].sum(axis=0),
            acceleration=0.0,
            kinetic_energy=0.0,
            dead_work=0.0,
            record_work=0.0,
            dissipated_energy=0.0,
            time_step=self._h,
            last_step=0.0,
            steps=0,
            iterations=0,
            finds_contacts=True,
            tie_force=no_force,
            tie_elongation=no_force,
            peak_tie_elongation=no_force,
            crushed_depth=cells.depth,
            crushed_slope=cells.slope,
            largest_crushed_depth=0.0,
            minus_of_contact=no_block,
            plus_of_contact=no_block,
            point_of_contact=np.empty((0, 3)),
            force_of_contact=np.empty((0, 3)),
        )

    def ended(self, state: RecordState) -> Reason | None:
        """Return the reason for the end of the response; None if it continues."""
        if self._fall.at(self._placement(state)).any():
            return Reason.BLOCKS_FALLEN
        # Blocks that have slipped may no longer touch where they did when contacts were found.
        if self._rests(state) and self._contacts[-1] == 1:
            return Reason.AT_REST
        limit = self._end + max(AFTER, self._end - self._begin)
        return Reason.STILL_MOVING if state.time >= limit else None

    def _rests(self, state: RecordState) -> bool:
        """Return whether all blocks are at rest after the record."""
        if state.time < self._end * (1 - 1e-12):
            return False
        # Blocks may lean on others until the record ends.
        last = float(np.linalg.norm(self._ground[-1])) if state.time - state.last_step < self._end else 0.0
        # At the turn of a motion, only the energy is small.
        if not state.steps or max(state.acceleration, last) > SLIGHT * STANDARD_GRAVITY:
            return False
        twist = np.column_stack([state.velocity, state.angular_velocity])
        energy = (twist * self._momentum(state)).sum(axis=1) / 2
        return bool((energy <= self._rest).all())

    def advance(self, state: RecordState) -> RecordState | None:
        """Return the next state; None if a step is not solved."""
        h, start = self._h, state.time
        placement = self._placement(state)
        contacts, force, moved, slip, reach, kept = self._contacts
        memory = state.tie_elongation, state.peak_tie_elongation, self._crushed(state)
        motion = Motion(placement, self._momentum(state), state.last_step, force, *memory)
        forces = ContactForces(
            state.minus_of_contact,
            state.plus_of_contact,
            state.point_of_contact,
            state.force_of_contact,
            state.tie_force,
        )
        twist = np.column_stack([state.velocity, state.angular_velocity])
        if state.finds_contacts or self._rests(state):
            contacts = None
        # Supports take up the loads, less what becomes momentum.
        square, impulse, acting = state.peak_displacement**2, motion.momentum[:, :3].sum(axis=0), 0.0
        dead = record = dissipated = 0.0
        steps, iterations, done, kinetic = state.steps, state.iterations, 0.0, state.kinetic_energy
        total, part = round(kept_interval(self._case) / h), 0
        while part < total:
            left, time = (part + 1) * h - done, start + done
            if contacts is None:
                reach = max(self._follows, RESOLUTION * h * float(self._speeds(twist).max()))
                contacts, force = self._dynamics.contacts(motion.placement, motion.crushed, reach, forces)
                motion, moved, slip, kept = replace(motion, force=force), np.zeros(len(twist)), 0.0, 0
            weight = self._weight if self._weight is not None else self._dead_wrench(motion.placement)
            step = self._solved(motion, contacts, weight, time, left)
            if step is None:
                return None
            motion = step.motion
            done += motion.last_step
            if done >= (part + 1) * h - 1e-9 * h:
                part += 1
                done = part * h
            k, mean = step.impulse_time, step.mean
            dead += k * float(np.vdot(weight, mean))
            record += k * float(np.vdot(step.loads - weight, mean))
            dissipated += step.dissipated_energy
            impulse += k * step.loads[self._free, :3].sum(axis=0)
            acting += k
            earlier, twist = twist, step.twist
            steps, iterations, kinetic = steps + 1, iterations + step.iterations, step.kinetic_energy
            place = motion.placement
            way = place.position - self._start.position
            square = np.maximum(square, _squares(way))
            moved = moved + motion.last_step * self._speeds(twist)
            slip += step.slip
            used = max(float(np.partition(moved, -2)[-2:].sum()) / reach, slip / self._follows)
            if used > 1:
                forces, contacts = self._dynamics.forces(motion, contacts), None
            if self._fall.at(place).any():
                break
        time = start + done
        if contacts is not None:
            forces = self._dynamics.forces(motion, contacts)
        self._contacts = contacts, motion.force, moved, slip, reach, kept + 1
        return RecordState(
            time=time,
            displacement=way,
            rotation=motion.placement.vectors,
            velocity=twist[:, :3],
            angular_velocity=twist[:, 3:],
            peak_displacement=np.sqrt(square),
            ground_acceleration=self._acceleration(time),
            base_reaction=(motion.momentum[:, :3].sum(axis=0) - impulse) / acting,
            acceleration=float(self._speeds(twist - earlier).max()) / k,
            kinetic_energy=kinetic,
            dead_work=state.dead_work + dead,
            record_work=state.record_work + record,
            dissipated_energy=state.dissipated_energy + dissipated,
            time_step=h,
            last_step=motion.last_step,
            steps=steps,
            iterations=iterations,
            finds_contacts=used > 0.5 or kept + 1 >= KEPT,
            tie_force=forces.tie_force,
            tie_elongation=motion.elongation,
            peak_tie_elongation=motion.peak_elongation,
            crushed_depth=motion.crushed.depth,
            crushed_slope=motion.crushed.slope,
            largest_crushed_depth=max(state.largest_crushed_depth, self._dynamics.largest_depth(motion)),
            minus_of_contact=forces.minus,
            plus_of_contact=forces.plus,
            point_of_contact=forces.point,
            force_of_contact=forces.force,
        )

    def _solved(self, motion: Motion, contacts: Contacts, weight: Array, time: float, h: float) -> Step | None:
        """Return a step of at most h. Steps of half the length are tried until one is solved, or too short."""

        def loads(h: float) -> Array:
            found = weight.copy()
            found[:, :3] += self._push(time - motion.last_step / 2, time + h / 2)
            return found

        step, shortest = None, SPLIT * min(h, self._h)
        while step is None and h >= shortest:
            step, h = self._dynamics.step(motion, contacts, loads, h), h / 2
        return step

    def _push(self, begin: float, end: float) -> Array:
        """Return the mean forces (B, 3) of the ground acceleration on the masses from one time to another."""
        begin = max(begin, self._begin)
        mean = (self._reached(end) - self._reached(begin)) / (end - begin)
        return -self._masses.mass[:, None] * mean

    def _reached(self, time: float) -> Array:
        """Return the integral (3,) of the ground acceleration."""
        k, share = self._sample(time)
        if k < 0:
            return np.asarray(self._velocity[-1])
        a, b, length = self._ground[k], self._ground[k + 1], self._times[k + 1] - self._times[k]
        return np.asarray(self._velocity[k] + length * share * (a + share / 2 * (b - a)))

    def _acceleration(self, time: float) -> Array:
        k, share = self._sample(time)
        if k < 0:
            return np.zeros(3)
        return np.asarray((1 - share) * self._ground[k] + share * self._ground[k + 1])

    def _sample(self, time: float) -> tuple[int, float]:
        """Return the sample before a time, and the share of the way to the next; −1 after the record."""
        if time > self._end:
            return -1, 0.0
        k = min(bisect_right(self._moments, time), len(self._moments) - 1) - 1
        return k, float((time - self._times[k]) / (self._times[k + 1] - self._times[k]))

    def _placement(self, state: RecordState) -> Placement:
        return Placement.at(self._start.position + state.displacement, state.rotation)

    def _crushed(self, state: RecordState) -> Crushed:
        return self._dynamics.undamaged._replace(depth=state.crushed_depth, slope=state.crushed_slope)

    def _momentum(self, state: RecordState) -> Array:
        """Return the momentum (B, 6) of a state. The inertia of its last step is that at the beginning of the step."""
        back = Placement.at(state.displacement, -state.last_step * state.angular_velocity).rotation
        R, m = back @ self._placement(state).rotation, self._masses
        spin = np.einsum("bij,bjk,blk,bl->bi", R, m.inertia, R, state.angular_velocity)
        found = np.column_stack([m.mass[:, None] * state.velocity, spin])
        found[self._fixed] = 0.0
        return found

    def _speeds(self, twist: Array) -> Array:
        """Return upper bounds (B,) of the speed of any point of each block, m/s."""
        return np.asarray(np.sqrt(_squares(twist[:, :3])) + self._radius * np.sqrt(_squares(twist[:, 3:])))

    def _dead_wrench(self, placement: Placement) -> Array:
        """Return the dead loads (B, 6) about the centres of mass."""
        wrench = self._dead.at(placement)
        arm = np.einsum("bij,bj->bi", placement.rotation, self._masses.offset)
        wrench[:, 3:] -= np.cross(arm, wrench[:, :3])
        return wrench


def _squares(vectors: Array) -> Array:
    """Return the squares (n,) of the lengths of vectors (n, 3)."""
    return np.asarray(np.einsum("ni,ni->n", vectors, vectors))


def check_record(model: Model, case: RecordCase) -> None:
    """Refuse models that the response to a record does not support.

    Raises
    ------
    ModelError
        If a free block has no mass, or as in :func:`check_in_motion`.
    """
    who = label(case)
    check_in_motion(model, who)
    Masses.of(model, case.dead, who)
