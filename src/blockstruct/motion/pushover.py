"""Find the steps of a capacity curve.

Motions are scaled so that the variable load does work at 1 W. The time of a step, s, is therefore the work of the
variable load in it, J. The way of a step is the distance that the control point moves in it, m.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import MOSTLY, SLIGHT, Array, Flags
from blockstruct.limit import Iteration
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.model import STANDARD_GRAVITY
from blockstruct.model.cases import STEPS
from blockstruct.motion.course import SAME, Course, carried, forces_at, loaded
from blockstruct.motion.moving_problem import COMPLIANCE, MovedProblem, MovingProblem
from blockstruct.motion.state import ZERO, CurveOutcome, MotionState, zero_displacement
from blockstruct.solvers.step import RECENT, StepProblem, StepSolution, solve_step
from blockstruct.statics.moved import Placement
from blockstruct.vocabulary import CurveEnd

#: Inertia in each step, which selects one of several motions: acceleration relative to gravity. It is about its share
#: in the load factor.
TRACE = 1e-7
#: Longest way of a step, relative to the longest one of the recent steps, or to the way so far divided by the requested
#: number of steps.
GROWTH = 2.0
#: Number of states that give the slope of the curve.
FORESEEN = 8
#: Largest way of a block in a step, in ways of the control point.
FASTEST = 3.0
#: Largest way of a solved step, relative to the prescribed way.
OFF = 1.5
#: Longest reach, for blocks that move further, in mean block sizes.
WIDEST = 0.25
#: Least share of a step, also while blocks fall.
SHORTEST = 1 / 4096
#: Share of a step that is tried if the whole step closes a gap. Share of the way to zero that a step leaves.
SHORTER = 0.25
#: Interpenetration, relative to the fastest point, from which blocks are jammed if they have it in steps of any length.
#: Steps by splitting have up to half of it.
JAMS = 0.05
#: Largest number of states in which blocks fall, and of others, relative to the requested number of steps, or to the
#: usual number if fewer are requested.
PATIENCE = 5


@dataclass(slots=True)
class _Planned:
    """A step that is being solved, and may be shortened.

    Attributes
    ----------
    moved : MovedProblem
        With contacts as far away as its reach.
    memory : MotionState
        State with the forces before the step.
    before : (K, 3) array
        These forces.
    twist, guess : (B, 6) arrays
        Motion before the step, and of a similar step.
    way : float
        Prescribed way, m.
    time, least : float
        Its work and that of the shortest step, J.
    far : float
        Way of the fastest block, for the inertia, m.
    paced : bool
        Whether it has been shortened to the prescribed way.
    """

    moved: MovedProblem
    memory: MotionState
    before: Array
    twist: Array
    guess: Array
    way: float
    time: float
    least: float
    far: float
    paced: bool = False


class PushoverPath:
    """The curve of a pushover so far, and its next step."""

    #: Work of the variable load while the structure takes the dead load; None if this load is zero until then.
    held: float | None = None

    def __init__(self, problem: MovingProblem, collapse: Iteration, settings: ProcedureSettings) -> None:
        self._problem, self._steps = problem, problem.case.steps
        self._course = Course(problem, settings)
        #: A usual load factor.
        self.scale = abs(collapse.load_factor)
        push, dead = (
            float(np.linalg.norm(loads.wrench[problem.statics.free, :3], axis=1).sum())
            for loads in (problem.variable, problem.dead)
        )
        # Ratio of the variable load at collapse to the dead load. A structure with a larger ratio moves further.
        self._share = min(1.0, self.scale * push / max(dead, 1e-300))
        self._length = problem.statics.length
        blocks = problem.statics.model.blocks
        shapes = [(b.shape.vertices, b.centroid) for b in blocks]
        self._radius = np.array([np.linalg.norm(corners - centre, axis=1).max() for corners, centre in shapes])
        free = np.concatenate([corners for (corners, _), b in zip(shapes, blocks, strict=True) if not b.fixed])
        #: Length that no distance of two points of the structure exceeds, m.
        self._extent = float(np.linalg.norm(np.ptp(np.concatenate([corners for corners, _ in shapes]), axis=0)))
        self._rest = Placement.of(problem.statics.model)
        #: Way of each step if the steps divide a quarter of the radius of the structure evenly, m.
        self._even = float(np.linalg.norm(free - free.mean(axis=0), axis=1).max()) / (4 * self._steps)
        #: Ways up to each state of the curve, and to the one after the last, m.
        self._ways = [0.0]
        #: Way that blocks have fallen since they last rested, m, and number of all steps in which they fell.
        self._fallen, self._falls = 0.0, 0
        #: Start of the last step, s, and its iterations.
        self._start, self._spent = perf_counter(), 0
        #: The last state in which nothing falls, whose motion continues.
        self._going: MotionState | None = None
        #: Whether the last step that was tried meets something immovable.
        self._jammed = False

    def take(self, state: MotionState) -> MotionState:
        """Add a state as the last one."""
        self._course.take(state)
        if len(self._course.curve) == len(self._ways):
            self._ways.append(self._ways[-1] + self._way(state))
        self._falls += state.falls
        if not state.falls:
            self._going = state
        furthest = float(np.linalg.norm(state.velocity, axis=1).max()) * state.motion_time
        self._fallen = self._fallen + furthest if state.falls else 0.0
        return state

    def begun(self, mechanism: Array) -> MotionState | None:
        """Load the structure until it is a mechanism; return the first state whose certificate holds.

        Joints deform elastically, first under the dead load and then in steps that grow from this deformation.
        """
        rest, nowhere, none = self._rest, np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        moved = self._course.at(rest, SAME * self._length)
        unloaded = np.zeros((moved.problem.n_points, 3))
        solved, inertia_time = self._step(moved, unloaded, [np.zeros_like(mechanism)], self.held, self._length / TRACE)
        if solved is None:
            return None
        settled = self._state(moved, solved, moved.twist(solved.u), 1.0, inertia_time)
        self._going = replace(
            settled,
            velocity=mechanism[:, :3],
            angular_velocity=mechanism[:, 3:],
            minus_of_contact=nowhere,
            plus_of_contact=nowhere,
            point_of_contact=none,
            normal_of_contact=none,
            force_of_contact=none,
            cell_of_contact=nowhere,
        )
        self._course.take(settled)
        way = COMPLIANCE * self._length
        while way <= GROWTH * self._even and self.end() is None:
            following = self.advance(way)
            if following is None or (following.holds and not following.falls):
                return following
            self.take(following)
            way = way if following.falls else GROWTH * self._way(following)
        return None

    def advance(self, way: float | None = None) -> MotionState | None:
        """Return the state after the last step, with a step of a way."""
        last = self._course.last
        if last is None:
            return None
        self._start, self._spent = perf_counter(), 0
        placement = self._following(last)
        return self._solved(placement, carried(self._going or last, placement), way or self._next_way(), last)

    def _following(self, state: MotionState) -> Placement:
        """Return the placement after the motion of a state."""
        at = Placement.at(state.position, state.rotation).moved(state.twist * state.motion_time)
        return Placement.at(at.position, at.vectors)

    def end(self) -> CurveEnd | None:
        """How the curve has ended."""
        if (reached := self._reached()) is not None:
            return reached
        if self._fallen > self._length:
            return CurveEnd.FALLS
        states = max(len(self._course.curve), self._falls)
        return CurveEnd.LIMIT_REACHED if states > PATIENCE * max(self._steps, STEPS) else None

    def _reached(self) -> CurveEnd | None:
        if np.isfinite(zero_displacement(self._course.curve)):
            return CurveEnd.ZERO
        last, start = self._course.last, self._rest.position
        gone = last is not None and np.linalg.norm(last.position - start, axis=1).max() > self._extent
        return CurveEnd.CARRIED_AWAY if gone else None

    def lost(self) -> CurveEnd:
        """How the curve ends where no step is solved."""
        if self._jammed:
            return CurveEnd.JAMS
        last = self._course.last
        return CurveEnd.FALLS if last is not None and last.falls else CurveEnd.NOT_SOLVED

    def outcome(self, end: CurveEnd) -> CurveOutcome:
        """Facts of the end."""
        last, control = self._course.last, self._problem.control
        if last is None:
            return CurveOutcome(end)
        curve, placement = self._course.curve, Placement.at(last.position, last.rotation)
        fastest = np.linalg.norm(last.velocity, axis=1).max()
        stands = control.velocity(placement, last.twist) * np.sign(last.displacement) <= ZERO * fastest
        end_at = last.displacement
        if end is CurveEnd.ZERO:
            end_at = zero_displacement(curve)
        elif end is CurveEnd.JAMS:
            end_at = control.displacement(self._following(last))
        found = outcome_of(self._problem, end, last.twist)
        return replace(found, displacement=end_at, states=len(curve), stands=bool(stands))

    def _way(self, state: MotionState) -> float:
        """Return the way of the control point in the step of a state, or a share of the way of the fastest block."""
        placement = Placement.at(state.position, state.rotation)
        return self._speed(placement, state.twist) * state.motion_time

    def _speed(self, placement: Placement, twist: Array) -> float:
        speed = abs(self._problem.control.velocity(placement, twist))
        return max(speed, float(np.linalg.norm(twist[:, :3], axis=1).max()) / FASTEST)

    def _time(self, placement: Placement, twist: Array, way: float) -> float:
        """Time at 1 W in which a motion, twists (B, 6), goes a way."""
        return way / max(self._speed(placement, twist), 1e-300)

    def _next_way(self) -> float:
        """Way of the next step, m."""
        ways = self._ways
        alpha = np.array([a for _, a in self._course.curve[-FORESEEN:]])
        way = np.array(ways[:-1][-FORESEEN:])
        slope = float(np.polyfit(way, alpha, 1)[0]) if len(way) > 1 else 0.0
        whole = way[-1] - alpha[-1] / slope if slope < 0 else np.inf
        even = min(
            whole / self._steps,
            max(8 * self._even * self._share, self._even, GROWTH * ways[-1] / self._steps),
        )
        return min(even, self._longest)

    @property
    def _highest(self) -> float:
        """Largest height of free fall in a step, m. Inertia is small then."""
        return self._length / SLIGHT

    @property
    def _longest(self) -> float:
        """Longest way of the next step, m."""
        return GROWTH * max(float(np.diff(self._ways[-RECENT:]).max()), COMPLIANCE * self._length)

    def _reach(self, way: float) -> float:
        return max(SAME * self._length, 2 * FASTEST * way)

    def _closing(self, twist: Array) -> float:
        """Speed that no two points of blocks are faster than towards each other in a motion, twists (B, 6)."""
        apart = np.linalg.norm(np.ptp(twist[:, :3], axis=0))
        turning = np.linalg.norm(twist[:, 3:], axis=1) * self._radius
        return float(apart + np.sort(turning)[-2:].sum())

    def _solved(self, placement: Placement, twist: Array, way: float, memory: MotionState) -> MotionState | None:
        """Return the state at a placement after a motion, twists (B, 6), and its step of a way.

        Blocks fall until they rest. Blocks also fall if no step is found, or if they leap in it. A fall from a state
        that is hardly unstable begins slowly: its height grows until blocks fall. If no step is found, any solution
        with the inertia of a fall is taken, also if blocks hardly move in it.
        """
        height = self._height(memory)
        if memory.falls:
            if (fallen := self._fallen_from(placement, twist, memory, height)) is not None:
                return fallen
            height *= GROWTH**2
        pushed, leaps = self._pushed(placement, twist, way, memory)
        self._jammed = pushed is None and leaps
        while (pushed is None or leaps) and height < self._highest:
            last_resort = not (leaps or memory.falls)
            if (fallen := self._fallen_from(placement, twist, memory, height, last_resort=last_resort)) is not None:
                return fallen
            height *= GROWTH**2
        return pushed

    def _pushed(
        self, placement: Placement, twist: Array, way: float, memory: MotionState
    ) -> tuple[MotionState | None, bool]:
        """Return the state at a placement and its step of a way, which may be shorter, and whether blocks leap or jam.

        A step ends just before a gap closes across which a force would work. The shortest step does not: blocks may
        leap in it.
        """
        step, missed = self._planned(placement, twist, way, memory), np.inf
        # Joints deform elastically before the curve begins. Then blocks press on each other only if they are jammed,
        # in a step of any length.
        jams = bool(self._course.curve)
        while (solution := self._within_reach(step)) is not None:
            solved, time, inertia_time, motion = solution
            found = self._completed(step.moved, solved, inertia_time)
            jams &= found.interpenetration > JAMS
            broken = self._until_broken(found)
            share = min(self._shortened(step, solved, time), broken, self._until_zero(step.moved, found))
            if SLIGHT < found.energy_error < MOSTLY * missed:
                # A shorter step may miss less work, unless the motion before has missed it.
                share, missed = min(share, SHORTER), found.energy_error
            if time <= step.least or (share == 1 and not jams):
                leaps = time <= step.least and self._way(found) > SHORTER * step.way
                return None if jams else found, jams or leaps
            if broken < 1:
                # A tie breaks within the step, which may be as short as needed. Inertia follows the shorter motion.
                step.least, step.far = 0.0, share * step.far
            step.time, step.guess = max(min(share, SHORTER if jams else 1.0) * time, step.least), motion
        return None, False

    def _planned(self, placement: Placement, twist: Array, way: float, memory: MotionState) -> _Planned:
        time, moved = self._time(placement, twist, way), self._course.at(placement, self._reach(way))
        far = float(np.linalg.norm(twist[:, :3], axis=1).max()) * time
        before = forces_at(moved, memory)
        return _Planned(moved, memory, before, twist, twist, way, time, SHORTEST * time, far)

    def _within_reach(self, step: _Planned) -> tuple[StepSolution, float, float, Array] | None:
        """Return the solution of a step in which blocks move no further than contacts are found.

        Its time, time of inertia and motion, twists (B, 6), come with it. The step is shortened, or contacts are found
        further away. None if no step is found.
        """
        while True:
            solved, time, inertia_time = self._attempted(step)
            if solved is None:
                return None
            motion = step.moved.twist(solved.u / time)
            closing = self._closing(motion) * time
            if closing <= step.moved.reach:
                return solved, time, inertia_time, motion
            gone = self._speed(step.moved.placement, motion) * time
            wide = WIDEST * self._length
            if step.moved.reach < wide and (step.paced or gone <= OFF * step.way):
                step.moved = self._course.at(step.moved.placement, wide)
                step.before, step.time = forces_at(step.moved, step.memory), time
            elif time <= step.least:
                return None
            else:
                # Other blocks than before may move, and go further for the same work.
                share = SHORTER if step.paced else min(step.way / gone, step.moved.reach / (OFF * closing))
                step.time, step.paced = max(share * time, step.least), True

    def _fallen_from(
        self, placement: Placement, twist: Array, memory: MotionState, height: float, *, last_resort: bool = False
    ) -> MotionState | None:
        """Return the state at a placement and a step in which blocks fall by a height.

        The control point waits; None if no block moves further than with it, except as a last resort.
        """
        reach = WIDEST * self._length
        moved = self._course.at(placement, reach)
        before = forces_at(moved, memory)
        wanted = self._time(placement, twist, SHORTEST * reach)
        falling = twist / max(float(np.linalg.norm(twist[:, :3], axis=1).max()), 1e-300)
        while height > ZERO * self._length:
            solved, inertia_time = self._step(moved, before, [height * falling], wanted, height)
            if solved is not None and self._closing(moved.twist(solved.u)) <= reach:
                found = self._completed(moved, solved, inertia_time)
                waits = self._way(found) <= OFF * SHORTEST * reach and not last_resort
                return None if waits else found
            height /= GROWTH**2
        return None

    def _attempted(self, step: _Planned) -> tuple[StepSolution | None, float, float]:
        """Return a solution of a step, its time and its time of inertia.

        Until one is found, a quarter of the step is tried with ten times the inertia. The most inertia that is tried
        does about a thousandth of the work.
        """
        time, inertia = step.time, TRACE
        while inertia <= SLIGHT:
            motions = [time * step.twist, time * step.guess]
            solved, inertia_time = self._step(step.moved, step.before, motions, time, step.far / inertia)
            if solved is not None:
                return solved, time, inertia_time
            time, inertia = SHORTER * time, 10 * inertia
        return None, np.nan, np.nan

    def _completed(self, moved: MovedProblem, solved: StepSolution, inertia_time: float) -> MotionState:
        """Return the complete state of a solution."""
        # Only inertia resists a mechanism: rounding shifts the work that was prescribed.
        time = float(moved.problem.w_L @ solved.u)
        motion = moved.twist(solved.u / time)
        state = self._state(moved, solved, motion, time, inertia_time)
        state = replace(state, solver_iterations=self._spent, solver_time=perf_counter() - self._start)
        return self._course.complete(state, moved)

    def _shortened(self, step: _Planned, solved: StepSolution, time: float) -> float:
        """Share of a step to which it is to be shortened; one if it need not."""
        moved = step.moved
        gone = self._speed(moved.placement, moved.twist(solved.u))
        if gone > OFF * step.way:
            return step.way / gone
        problem, closed = moved.problem, ZERO * self._length
        v = (problem.A.T @ solved.u).reshape(-1, 3)
        work = max(abs(solved.load_factor) * time, -float((solved.x[:, 1:] * v[:, 1:]).sum()), 1e-300)
        gaps = np.concatenate([moved.contacts.gap, moved.slack])
        units = np.concatenate([problem.force_unit, problem.ties.force_unit])
        forces = np.concatenate([solved.x[:, 0], solved.tie_force])
        # If a hinge moves along a joint, the contact point next to it carried the force before.
        new = np.concatenate([step.before[:, 0] <= 0, np.ones(len(problem.ties), dtype=bool)])
        across = new & (gaps > closed) & (forces * units * gaps > SLIGHT * work)
        if across.any():
            # So did another point at the same place, where two faces of a block share the corner that touches.
            points = slice(problem.n_points)
            across[points] &= ~moved.contacts.same_place(~new[points], self._length)
        if not across.any():
            return 1.0
        going = moved.velocities(step.twist * time)
        rates = np.concatenate([-(problem.A.T @ going)[::3], problem.ties.elongation(going)]) / units
        share = (1 - SLIGHT) * float((gaps[across] / np.maximum(rates[across], 1e-300)).min())
        return share if share < 1 - SLIGHT else SHORTER

    def _step(
        self, moved: MovedProblem, before: Array, motions: Sequence[Array], time: float | None, height: float
    ) -> tuple[StepSolution | None, float]:
        """Return the solution of a step and its time of inertia.

        ``before`` (K, 3) are the last forces, and ``time`` is None under the dead load alone. Blocks are expected to
        move by ``motion`` (B, 6). In the time of inertia blocks without support fall by ``height``, m.
        """
        problem, last, squared = moved.problem, self._course.last, height / STANDARD_GRAVITY
        step = StepProblem(
            problem=problem,
            gap=moved.contacts.gap * problem.force_unit,
            slack=moved.slack * problem.ties.force_unit,
            inertia=sp.csr_array(self._problem.inertia / squared),
            force=before,
            compliance=self._problem.compliance,
            displacement=time,
            load_factor=0.0 if last is None else last.load_factor,
            mirror=moved.mirror,
            normal_compliance=moved.of_cells(moved.contacts.cells.compliance, self._problem.compliance),
        )
        solved = solve_step(step, *(moved.velocities(motion) for motion in motions))
        self._spent += 0 if solved is None else solved.iterations
        return solved, float(np.sqrt(squared))

    def _state(
        self,
        moved: MovedProblem,
        solved: StepSolution,
        motion: Array,
        time: float,
        inertia_time: float,
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
            reach=moved.reach,
            tie_force=moved.tie_force(solved.tie_force),
            solver_iterations=0,
            solver_time=0.0,
            crushed_depth=moved.crushed.depth,
            crushed_slope=moved.crushed.slope,
            crushed_share=moved.crushed.share,
            **loaded(moved.contacts, solved.x * problem.force_unit[:, None]),
        )

    def _height(self, last: MotionState) -> float:
        """Return the height of free fall in the step after a state in which blocks fall, m.

        It grows where blocks move less than a quarter of the reach of contact detection.
        """
        least, grown = WIDEST * self._length / 4, GROWTH**2 * STANDARD_GRAVITY * last.inertia_time**2
        fallen = float(np.linalg.norm(last.velocity, axis=1).max()) * last.motion_time
        return grown if last.falls and fallen < least / 4 and grown < self._highest else least

    def _until_zero(self, moved: MovedProblem, found: MotionState) -> float:
        """Return the share of the step of a state at which the load factor is nearly zero; one if it stays above."""
        last, curve = self._course.last, self._course.curve
        if last is None or not curve or found.load_factor >= last.load_factor:
            return 1.0
        if last.tie_force[~moved.holds].any():
            # The load factor has dropped with a tie.
            return 1.0
        alpha, way = found.load_factor, self._way(found)
        left = alpha * self._way(last) / (last.load_factor - alpha)
        if not COMPLIANCE * self._length < left < (1 - SLIGHT) * way:
            return 1.0
        return left / way * (1 - SHORTER if alpha > SLIGHT * abs(curve[0][1]) else 1.0)

    def _until_broken(self, found: MotionState) -> float:
        """Return the share of the way of a state up to the first tie that breaks; one if no tie breaks.

        The way ends just before the tie breaks, or just after if the tie is near its limit already.
        """
        ties = self._problem.statics.ties
        if not len(ties):
            return 1.0
        placement = Placement.at(found.position, found.rotation)
        limit = ties.elongation_limit
        longest = self._course.at(placement, found.reach).longest - ties.span

        def breaks(share: float, most: Array) -> Flags:
            at = placement.moved(found.twist * (share * found.motion_time))
            return np.asarray((longest <= limit) & (self._problem.lengths(at) - ties.span > most))

        if not breaks(1.0, limit).any():
            return 1.0
        near = (longest <= limit) & (longest >= (1 - ZERO) * limit)
        most = np.where(near, (1 + ZERO) * limit, (1 - ZERO / 2) * limit)
        if not breaks(1.0, most).any():
            return 1.0
        low, high = 0.0, 1.0
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (low, middle) if breaks(middle, most).any() else (middle, high)
        share = high if near.any() else low
        return share if share < 1 - ZERO else 1.0


def outcome_of(problem: MovingProblem, end: CurveEnd, twist: Array) -> CurveOutcome:
    """An end, and the blocks that move most in a motion, twists (B, 6)."""
    speed = np.linalg.norm(twist[:, :3], axis=1) * ~problem.structure.fixed
    fastest = np.argsort(-speed, kind="stable")
    names = [problem.statics.model.blocks[i].name for i in fastest[speed[fastest] > MOSTLY * speed.max()]]
    along = np.round(twist[fastest[0], :3] / max(speed.max(), 1e-300), 4) + 0.0
    return CurveOutcome(end, blocks=tuple(names), direction=tuple(along.tolist()))
