"""The pushover: from the collapse state through finite displacements until the load factor is zero."""

from collections.abc import Generator, Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit import Iteration, Placement, ProcedureSettings
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.motion.course import PENETRATING, Course, carried, loaded
from blockstruct.motion.moving_problem import MovedProblem, MovingProblem
from blockstruct.motion.state import CurveOutcome, MotionState, zero_displacement
from blockstruct.solvers.step import StepProblem, StepSolution, solve_step
from blockstruct.vocabulary import CurveEnd

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: First way of the control point, as a share of an even one, the growth from one to the next, and the largest, as a
#: share of the way so far, in multiples of an even one, so that what slides without end comes far.
FIRST, GROWTH, LARGEST = 0.25, 1.5, 2.0
#: Share of the way to a load factor of zero that a step goes, and load factor, relative to the first, from which it
#: goes all of it.
SHORT_OF, NEAR = 0.75, 1e-3
#: States whose longest step tells how long the next may be: one that ends where a tie breaks tells nothing.
AFTER = 4
#: States from which the end of the curve is foreseen, along a straight line.
FORESEEN = 8
#: Most that a block may move in a step, in ways of the control point, and how far either may be from what is wanted.
FASTEST, OFF = 3.0, 1.5
#: Least reach of contacts, and the widest in which blocks that move further are looked after, in mean block sizes.
NEAREST, WIDEST = 0.05, 0.25
#: Gap or slack that is closed, in mean block sizes.
CLOSED = 1e-4
#: Share of the work of a step that a force may do across a gap that it closes; how much of the way to such a gap a step
#: goes; and its least share.
ACROSS, UP_TO, SHORTEST = 1e-3, 1 - 1e-3, 1 / 4096
#: Share of its elongation limit within which a tie is about to break.
BREAKS = 1e-4
#: Share of a step that is tried where it is not solved.
SHORTER = 0.25
#: Acceleration of a step, relative to gravity: share of inertia in the load factor.
INERTIA = 1e-7
#: Way of the control point while blocks fall, as a share of theirs; and free fall in such a step at the most, in
#: distances in which contacts are looked for: what leans on others falls by less.
WAITS, HIGHEST = 1e-4, 256.0
#: Flow-rule gap, relative to the work of a step, beyond which a shorter step is tried; and how many are, of which the
#: one that misses least is taken.
LOST, DOUBTS = 0.05, 2
#: Share of inertia in the work of a last step from which blocks fall; and force of a tie that is rounding, in dead
#: wrenches of the lighter block.
MOSTLY, NO_FORCE = 0.5, 1e-6
#: Steps, in multiples of those asked for, after which the curve is left; and how few asked for count as more.
PATIENCE, FEW = 5, 20
#: How far a first state with sharp corners may be above the collapse state, relatively: that of a cross vault is 1.1 %.
ABOVE = 0.015
#: Speed of the control point, relative to the fastest block, at which it hardly goes on, and at collapse rests.
STANDS, RESTS = 1e-2, 1e-4
#: Speed, relative to the fastest block, from which a block is told to move, and blocks that are told.
FAST, NAMED = 0.5, 5


States = Generator[MotionState, None, CurveOutcome]


def pushover(
    problem: MovingProblem,
    collapse: Iteration,
    steps: int,
    settings: ProcedureSettings,
    before: Sequence[MotionState] = (),
) -> States:
    """Follow a collapse mechanism through finite displacements.

    In each step the work of the variable load is prescribed, and with it the way of the control point. Blocks then move
    along the screws of their twists, and contacts are found anew where they are. The load factor belongs to the
    geometry at the beginning of the step. Blocks that nothing holds fall, while the control point waits.

    Parameters
    ----------
    problem
        The case, wherever its blocks are.
    collapse
        The certified collapse state, whose mechanism is the first motion.
    steps
        Number of them, about.
    settings
        Of the case.
    before
        States of the curve that are known already: it continues after the last of them.

    Yields
    ------
    MotionState
        A state; the first is that without displacement.

    Returns
    -------
    CurveOutcome
        How it ended.
    """
    rest = Placement.of(problem.statics.model)
    mechanism = _mechanism(problem, collapse, rest)
    speed = abs(problem.control.velocity(rest, mechanism))
    if speed <= RESTS * np.linalg.norm(mechanism[:, :3], axis=1).max():
        return replace(_outcome(problem, CurveEnd.RESTS, mechanism), displacement=0.0)
    path = _Path(problem, collapse, steps, settings)
    for known in before:
        path.take(known)
    if not before:
        sharp = problem.sharp
        first = path.begun(mechanism, collapse)
        own = first if sharp is problem else _Path(sharp, collapse, steps, settings).begun(mechanism, collapse)
        if own is not None and own.load_factor > (1 + ABOVE) * abs(collapse.load_factor):
            return _begins_above(problem, own)
        if first is None:
            return _outcome(problem, CurveEnd.NOT_SOLVED, mechanism)
        yield path.take(first)
    while (end := path.end()) is None:
        following = path.advance()
        if following is None:
            return path.outcome(path.lost())
        yield path.take(following)
    return path.outcome(end)


class _Path:
    """The curve so far, and the next step of it."""

    def __init__(self, problem: MovingProblem, collapse: Iteration, steps: int, settings: ProcedureSettings) -> None:
        self._problem, self._steps, self._settings = problem, steps, settings
        self._course = Course(problem, settings)
        push, dead = (
            float(np.linalg.norm(loads.wrench[problem.statics.free, :3], axis=1).sum())
            for loads in (problem.variable, problem.dead)
        )
        # Whatever the unit of the variable load: what carries more moves further.
        self._share = min(1.0, abs(collapse.load_factor) * push / max(dead, 1e-300))
        self._length = problem.statics.length
        blocks = problem.statics.model.blocks
        shapes = [(b.shape.vertices, b.centroid) for b in blocks]
        self._radius = np.array([np.linalg.norm(corners - centre, axis=1).max() for corners, centre in shapes])
        free = np.concatenate([corners for (corners, _), b in zip(shapes, blocks, strict=True) if not b.fixed])
        #: Way of a step that divides an eighth of the extent of the structure evenly, m.
        self._even = float(np.linalg.norm(free - free.mean(axis=0), axis=1).max()) / (4 * steps)
        self._ways, self._fallen = [0.0], 0.0
        #: The last state in which nothing falls, whose motion continues.
        self._going: MotionState | None = None

    def take(self, state: MotionState) -> MotionState:
        """Take a state as the last one."""
        last = self._course.last
        if last is not None:
            self._ways.append(self._ways[-1] + self._way(last))
        self._course.take(state)
        if not state.falls:
            self._going = state
        furthest = float(np.linalg.norm(state.velocity, axis=1).max()) * state.motion_time
        self._fallen = self._fallen + furthest if state.falls else 0.0
        return state

    def begun(self, mechanism: Array, collapse: Iteration) -> MotionState | None:
        """The collapse state; found anew where corners are rounded and contacts not where the model has them."""
        statics, at_rest = self._problem.statics, self._problem.at_rest
        rest = Placement.of(statics.model)
        forces = loaded(statics.points, collapse.x * at_rest.force_unit[:, None])
        # What is left of the force of a slack tie is the rounding of a program.
        T = np.where(collapse.tie_force > NO_FORCE, collapse.tie_force, 0.0) * at_rest.ties.force_unit
        way = FIRST * self._even
        state = MotionState(
            load_factor=collapse.load_factor,
            position=rest.position,
            rotation=rest.vectors,
            velocity=mechanism[:, :3],
            angular_velocity=mechanism[:, 3:],
            motion_time=self._time(rest, mechanism, way),
            inertia_time=np.inf,
            falls=False,
            reach=self._reach(way),
            tie_force=T,
            solver_iterations=0,
            solver_time=0.0,
            **forces,
        )
        found = self._course.complete(state)
        if found.holds and self._until_broken(found) == 1:
            return found
        return self._solved(rest, mechanism, way, state)

    def advance(self) -> MotionState | None:
        """The state after the last step."""
        last = self._course.last
        if last is None:
            return None
        at = Placement.at(last.position, last.rotation).moved(last.twist * last.motion_time)
        placement = Placement.at(at.position, at.vectors)
        return self._solved(placement, carried(self._going or last, placement), self._wanted(), last)

    def end(self) -> CurveEnd | None:
        """How the curve has ended."""
        if np.isfinite(zero_displacement(self._course.curve)):
            return CurveEnd.ZERO
        if self._fallen > self._length:
            return CurveEnd.FALLS
        return CurveEnd.LIMIT_REACHED if len(self._ways) > PATIENCE * max(self._steps, FEW) else None

    def lost(self) -> CurveEnd:
        """How the curve ends where no step is solved."""
        last = self._course.last
        return CurveEnd.FALLS if last is not None and last.inertia > MOSTLY else CurveEnd.NOT_SOLVED

    def outcome(self, end: CurveEnd) -> CurveOutcome:
        """Facts of the end."""
        last, control = self._course.last, self._problem.control
        if last is None:
            return CurveOutcome(end)
        curve, placement = self._course.curve, Placement.at(last.position, last.rotation)
        begun = curve[min(1, len(curve) - 1)][0]
        fastest = np.linalg.norm(last.velocity, axis=1).max()
        stands = begun != 0 and control.velocity(placement, last.twist) * np.sign(begun) <= STANDS * fastest
        end_at = zero_displacement(curve) if end is CurveEnd.ZERO else last.displacement
        found = _outcome(self._problem, end, last.twist)
        return replace(found, displacement=end_at, states=len(curve), stands=bool(stands))

    def _way(self, state: MotionState) -> float:
        """Way of the control point in the step of a state, or a share of that of the block that goes furthest."""
        placement = Placement.at(state.position, state.rotation)
        return self._speed(placement, state.twist) * state.motion_time

    def _speed(self, placement: Placement, twist: Array) -> float:
        speed = abs(self._problem.control.velocity(placement, twist))
        return max(speed, float(np.linalg.norm(twist[:, :3], axis=1).max()) / FASTEST)

    def _time(self, placement: Placement, twist: Array, way: float) -> float:
        """Time at 1 W in which a motion, twists (B, 6), goes a way."""
        return way / max(self._speed(placement, twist), 1e-300)

    def _wanted(self) -> float:
        """Way of the next step, m."""
        last = self._course.last
        if last is None:
            return FIRST * self._even
        ways = [*self._ways, self._ways[-1] + self._way(last)]
        alpha = np.array([a for _, a in self._course.curve[-FORESEEN:]])
        way = np.array(ways[:-1][-len(self._course.curve) :])[-FORESEEN:]
        slope = float(np.polyfit(way, alpha, 1)[0]) if len(way) > 1 else 0.0
        whole = way[-1] - alpha[-1] / slope if slope < 0 else np.inf
        even = min(
            whole / self._steps,
            max(8 * self._even * self._share, self._even, LARGEST * ways[-1] / self._steps),
        )
        wanted = min(even, GROWTH * max(float(np.diff(ways[-AFTER:]).max()), FIRST * SHORTEST * self._even))
        if len(way) > 1 and alpha[-1] < alpha[-2]:
            # The last step ends where the load factor is zero.
            left = alpha[-1] * (way[-1] - way[-2]) / (alpha[-2] - alpha[-1]) - (ways[-1] - way[-1])
            if 0 < left < wanted:
                wanted = left * (SHORT_OF if alpha[-1] > NEAR * abs(self._course.curve[0][1]) else 1.0)
        return wanted

    def _reach(self, way: float) -> float:
        return max(NEAREST * self._length, 2 * FASTEST * way)

    def _closing(self, twist: Array) -> float:
        """Speed that no two points of blocks are faster than towards each other in a motion, twists (B, 6)."""
        apart = np.linalg.norm(np.ptp(twist[:, :3], axis=0))
        turning = np.linalg.norm(twist[:, 3:], axis=1) * self._radius
        return float(apart + np.sort(turning)[-2:].sum())

    def _solved(self, placement: Placement, twist: Array, way: float, memory: MotionState) -> MotionState | None:
        """A state at a placement after a motion, twists (B, 6), and its step of a way, which may be shorter.

        A step ends just before what closes in it does work there; what the shortest step closes is a drop. Where blocks
        fall further than contacts are looked for they fall by as much, while the control point waits.
        """
        start, spent, course, size = perf_counter(), 0, self._course, self._length
        time, reach, falls = self._time(placement, twist, way), self._reach(way), np.inf
        far = float(np.linalg.norm(twist[:, :3], axis=1).max()) * time
        least, moved = SHORTEST * time, course.at(placement, reach)
        before, doubtful, paced = course.forces(moved, memory), list[MotionState](), False
        while True:
            solved, inertia_time = self._step(moved, before, twist, time, far, falls)
            share = SHORTER
            if solved is not None:
                spent += solved.iterations
                motion = moved.twist(solved.u / time)
                if self._closing(motion) * time > reach:
                    gone = self._speed(placement, motion) * time
                    if not paced and gone > OFF * way:
                        # Other blocks than before move, and go further for the same work.
                        time, paced = time * way / gone, True
                    elif reach < WIDEST * size:
                        reach = WIDEST * size
                        moved = course.at(placement, reach)
                        before = course.forces(moved, memory)
                    else:
                        time, falls = self._time(placement, twist, WAITS * reach), min(falls, HIGHEST * reach) / 4
                        if falls < CLOSED * size:
                            return None
                    continue
                found = course.complete(
                    replace(
                        self._state(
                            moved, solved, motion, time, inertia_time, reach, falls=time <= least or np.isfinite(falls)
                        ),
                        solver_iterations=spent,
                        solver_time=perf_counter() - start,
                    )
                )
                if found.interpenetration <= PENETRATING:
                    doubtful.append(found)
                if np.isfinite(falls):
                    break
                broken = self._until_broken(found)
                share = min(self._shortened(moved, solved, before, twist, time, way), broken)
                if broken < 1:
                    least, far = 0.0, share * far
                if share < 1:
                    if time > least:
                        doubtful.clear()
                elif found.missed <= LOST and doubtful:
                    return found
                elif len(doubtful) == DOUBTS:
                    break
                else:
                    share = SHORTER
            if time <= least:
                break
            time = max(share * time, least)
        return min(doubtful, key=lambda state: state.missed, default=None)

    def _shortened(
        self,
        moved: MovedProblem,
        solved: StepSolution,
        before: tuple[Array, Array],
        twist: Array,
        time: float,
        way: float,
    ) -> float:
        """Share of a step to which it is to be shortened; one if it need not."""
        gone = self._speed(moved.placement, moved.twist(solved.u))
        if gone > OFF * way:
            return way / gone
        problem, closed = moved.problem, CLOSED * self._length
        v = (problem.A.T @ solved.u).reshape(-1, 3)
        work = max(abs(solved.load_factor) * time, -float((solved.x[:, 1:] * v[:, 1:]).sum()), 1e-300)
        gaps = np.concatenate([moved.contacts.gap, moved.slack])
        units = np.concatenate([problem.force_unit, problem.ties.force_unit])
        forces = np.concatenate([solved.x[:, 0], solved.tie_force])
        # Hinges that move have had their forces near by.
        new = np.concatenate([before[0][:, 0] <= 0, np.ones(len(problem.ties), dtype=bool)])
        across = new & (gaps > closed) & (forces * units * gaps > ACROSS * work)
        if not across.any():
            return 1.0
        going = moved.velocities(twist * time)
        rates = np.concatenate([-(problem.A.T @ going)[::3], problem.ties.elongation(going)]) / units
        share = UP_TO * float((gaps[across] / np.maximum(rates[across], 1e-300)).min())
        return share if share < 1 else SHORTER

    def _step(
        self, moved: MovedProblem, before: tuple[Array, Array], twist: Array, time: float, far: float, falls: float
    ) -> tuple[StepSolution | None, float]:
        """Solve a step of blocks that are meant to go as far, or to fall by a height, and its time of inertia."""
        problem = moved.problem
        if not problem.n_points:
            return None, np.inf
        normal = before[0][:, 0] * problem.force_unit
        mean = normal[normal > 0].mean() if (normal > 0).any() else problem.wrench_unit.mean()
        squared = min(far / INERTIA, falls) / STANDARD_GRAVITY
        step = StepProblem(
            problem=problem,
            gap=moved.contacts.gap * problem.force_unit,
            slack=moved.slack * problem.ties.force_unit,
            inertia=sp.csr_array(self._problem.inertia / squared),
            force=before[0],
            tie_force=before[1],
            compliance=far / mean,
            displacement=time,
        )
        solved = solve_step(step, moved.velocities(twist * time), self._settings)
        return solved, np.inf if solved is None else float(np.sqrt(squared / solved.inertia))

    def _state(
        self,
        moved: MovedProblem,
        solved: StepSolution,
        motion: Array,
        time: float,
        inertia_time: float,
        reach: float,
        *,
        falls: bool,
    ) -> MotionState:
        placement, problem = moved.placement, moved.problem
        return MotionState(
            load_factor=solved.load_factor,
            position=placement.position,
            rotation=placement.vectors,
            velocity=motion[:, :3],
            angular_velocity=motion[:, 3:],
            motion_time=time,
            inertia_time=inertia_time,
            falls=falls,
            reach=reach,
            tie_force=moved.tie_force(solved.tie_force),
            solver_iterations=0,
            solver_time=0.0,
            **loaded(moved.contacts.points, solved.x * problem.force_unit[:, None]),
        )

    def _until_broken(self, found: MotionState) -> float:
        """Share of the way of a state that ends where a tie breaks; one if none does.

        It ends just before the first that does and, of one that is near its limit, just behind.
        """
        ties = self._problem.statics.ties
        placement = Placement.at(found.position, found.rotation)
        limit = ties.elongation_limit
        longest = self._course.at(placement, found.reach).longest - ties.span

        def breaks(share: float, most: Array) -> Flags:
            at = placement.moved(found.twist * (share * found.motion_time))
            return np.asarray((longest <= limit) & (self._problem.lengths(at) - ties.span > most))

        if not breaks(1.0, limit).any():
            return 1.0
        near = (longest <= limit) & (longest >= (1 - BREAKS) * limit)
        most = np.where(near, (1 + BREAKS) * limit, (1 - BREAKS / 2) * limit)
        if not breaks(1.0, most).any():
            return 1.0
        low, high = 0.0, 1.0
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (low, middle) if breaks(middle, most).any() else (middle, high)
        share = high if near.any() else low
        return share if share < 1 - BREAKS else 1.0


def _mechanism(problem: MovingProblem, collapse: Iteration, rest: Placement) -> Array:
    """Twists (B, 6) of the collapse mechanism at 1 W."""
    lengths = problem.lengths(rest)
    twist = problem.at(rest, NEAREST * problem.statics.length, lengths, lengths).twist(collapse.u)
    return np.asarray(twist)


def _outcome(problem: MovingProblem, end: CurveEnd, twist: Array) -> CurveOutcome:
    """An end, and the blocks that move most in a motion, twists (B, 6)."""
    speed = np.linalg.norm(twist[:, :3], axis=1)
    fastest = np.argsort(-speed, kind="stable")
    names = [problem.statics.model.blocks[i].name for i in fastest[speed[fastest] > FAST * speed.max()][:NAMED]]
    along = np.round(twist[fastest[0], :3] / max(speed.max(), 1e-300), 4) + 0.0
    return CurveOutcome(end, blocks=tuple(names), direction=tuple(along.tolist()))


def _begins_above(problem: MovingProblem, first: MotionState) -> CurveOutcome:
    """No curve where blocks touch beyond the interfaces of the model, and carry more with that."""
    points, names = problem.statics.points, [b.name for b in problem.statics.model.blocks]
    joints = set(map(tuple, np.sort(np.column_stack([points.minus, points.plus])).tolist()))
    pressed = np.sort(np.column_stack([first.minus_of_contact, first.plus_of_contact])).tolist()
    without = sorted({(i, j) for i, j in map(tuple, pressed)} - joints)
    blocks = tuple(f"{names[i]}|{names[j]}" for i, j in without[:NAMED])
    return CurveOutcome(CurveEnd.BEGINS_ABOVE, 0.0, first.load_factor, 0, blocks)
