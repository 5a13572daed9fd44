"""Steps of a pushover that are tried from a state: where its motion leads, and what comes of it there."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import Placement
from blockstruct.limit.capacity_curve import FiniteStep
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.moved import MovedProblem, MovingProblem
from blockstruct.limit.program import Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.body_step import Carried, Stepper
from blockstruct.procedures.finite_step import CERTIFIED, Question, Solved
from blockstruct.procedures.pace import Pace
from blockstruct.procedures.pushover_state import Found, State, friction_of

Array = NDArray[np.float64]

#: How far the way of a step may be from the one that is wanted, as a ratio, before it is solved again; and attempts.
MISSED, LENGTHS = 1.5, 3
#: Work of forces across gaps that close in a step, relative to all of its work, for which it is shortened to the
#: first of them; what is left of that way; and the least step to one, as a share of one that divides the curve evenly.
REACHING, BEFORE, CLOSEST = 1e-3, 1e-3, 1 / 4096
#: Least reach of contacts, in mean block sizes; reach in multiples of the last motion; and, in mean block sizes again,
#: where nothing is found with it. Measured where hinges of arches leap: voussoirs go back by up to 0.07, and rest.
NEAREST, REACH, WIDE = 0.05, 2.0, 0.2
#: Difference of load factors, relative to that at collapse, up to which what is found with those is on the same curve.
LIKE = 0.1
#: Rate of the dead load's work, but for what ties take up, from which blocks fall, in multiples of that of the variable
#: load or of friction at collapse; and from which they do where no load factor is left. Measured where units drop a
#: little way until they meet others: up to 5.
FALLING, FALLING_AT_ZERO = 10.0, 3.0
#: Way of the fastest block, in mean block sizes, up to which blocks that drop on, or do little work by it, may.
SETTLES = 0.1
#: Rise of that rate, in the same multiples, from which a shorter step has blocks that drop.
DROPS = 0.1
#: Difference of load factors, relative to that at collapse, with which a step that has a drop alone tells of a drop.
STEADY = 0.05
#: Work of a step, relative to that at the collapse load, to which what it misses is relative where there is less.
LEAST_WORK = 0.05
#: Work of friction at collapse, relative to that of the push, up to which blocks rock. What is stopped early has some.
ROCKS = 0.05


class Attempts:
    """What may come next on a curve; nothing of it is kept but by :meth:`taken`."""

    def __init__(
        self, problem: MovingProblem, collapse: Iteration, steps: int, settings: ProcedureSettings, solver: Solver
    ) -> None:
        self.problem = problem
        self.load_factor = abs(collapse.load_factor)
        # Down a slope that hardly holds it the push drives little of what friction takes.
        friction = friction_of(problem.at_rest, collapse)
        self.driving = max(self.load_factor, friction)
        self._rocks = friction <= ROCKS * self.load_factor
        self.pace = Pace(problem, steps, self.load_factor)
        self.stepper = Stepper(settings, solver)
        self._least = LEAST_WORK * self.load_factor
        self._nearest = NEAREST * problem.statics.length
        shapes = ((b.shape.vertices, b.centroid) for b in problem.statics.model.blocks)
        self._radius = np.array([np.linalg.norm(corners - centre, axis=1).max() for corners, centre in shapes])
        self._before: State | None = None
        self.last: State | None = None

    def taken(self, state: State, step: FiniteStep) -> None:
        """A state, as it is kept, is the last one."""
        self.pace.taken(state)
        self._before, self.last = self.last, state
        self._carried = Carried.of_step(self.problem, step), (step.body_failures, step.body_waits)
        self.go_on()

    def go_on(self) -> None:
        """Begin the next step, whatever was tried since: the forces of no other state act there."""
        self.stepper.go_on(*self._carried)

    def begun(self, rest: Placement, collapse: Iteration) -> Found | None:
        """The collapse state, found anew where corners are rounded and contacts not where the model has them."""
        moved = self.problem.at(rest, self._nearest, self.problem.lengths(rest))
        twist = moved.twist(collapse.u)
        time = self.pace.time(moved.placement, twist)
        question = self._question(moved, time, twist)
        solution = self.stepper.begin(moved, question, collapse, self.problem.statics.points)
        return self.solved(moved, twist) if solution is None else self._found(moved, solution, time)

    def after(self, state: State, time: float) -> MovedProblem:
        """The problem where the blocks of a state are after a time, with contacts within the reach of that motion."""
        reach = max(self._nearest, REACH * self._closing(state.twist) * time)
        placement = state.placement.moved(state.twist * time)
        return self.problem.at(placement, reach, state.longest, state.tightened(self.problem.lengths(placement)))

    def reached(self, moved: MovedProblem, before: State) -> Found | None:
        """A step from where the motion of a state leads to.

        Where no forces carry the dead load with the contacts near by, those further away that what drops there comes to
        rest on are looked for, if the curve goes on with them.
        """
        # What dropped has met others: the push goes on as it did before.
        going = self._before if before.dropped and self._before is not None else before
        carried = going.carried(moved.placement)
        found = self.solved(moved, carried)
        wide = WIDE * self.problem.statics.length
        if found is None and moved.reach < wide:
            further = self.problem.at(moved.placement, wide, moved.longest, moved.tight)
            found = self.solved(further, carried)
            if found is not None and abs(found.solved.load_factor - before.load_factor) > LIKE * self.load_factor:
                return None
        return found and found.after(before)

    def alone(self, state: State, moved: MovedProblem, time: float, alpha: float) -> Found | None:
        """A step for a time in which only what drops moves, and in which little else tells of the load factor."""
        self.go_on()
        solution = self.stepper.solve(moved, self._question(moved, time, state.carried(moved.placement)))
        if solution is None or not solution.holds or abs(solution.load_factor - alpha) > STEADY * self.load_factor:
            return None
        found = self._found(moved, solution, time)
        return replace(found, state=replace(found.state, dropped=True)).after(state)

    def solved(self, moved: MovedProblem, twist: Array) -> Found | None:
        """A step from a placement in which the control point moves as far as wanted, or blocks as far as they may."""
        placement = moved.placement
        time, last = self.pace.time(placement, twist), twist
        shortest = CLOSEST * self.pace.even / self.pace.way(placement) * time
        found: Found | None = None
        # Work that the dead load did before is none of what drops.
        fell = 0.0 if self.last is None or self.last.dropped else self.last.falling
        longest, left = np.inf, LENGTHS
        while left > 0:
            left -= 1
            solution = self.stepper.solve(moved, self._question(moved, time, twist))
            if solution is None:
                break
            doubtful = solution.missed > CERTIFIED
            if found is not None and (doubtful or self.drops(solution.falling, max(found.solved.falling, fell))):
                break
            found = self._found(moved, solution, time)
            twist = found.state.twist
            if doubtful:
                break
            if np.isinf(longest):
                longest = max(self._until_closed(moved, solution, last), shortest)
            if time <= longest and self._closes(moved, solution, last):
                # The last motion does so later than this one.
                longest, left = max(time / 2, shortest), max(left, 1)
            better = min(self.pace.time(placement, twist), longest)
            if 1 / MISSED < better / time < MISSED and time <= longest:
                break
            time = better
        return found

    def _question(self, moved: MovedProblem, time: float, twist: Array) -> Question:
        """A step for a time."""
        return Question.of(moved, time, twist, self._least, rocks=self._rocks)

    def _found(self, moved: MovedProblem, solution: Solved, time: float) -> Found:
        """The state of a solution, whose motion goes on for a time: blocks meet nothing further than contacts reach."""
        placement, displacement = moved.placement, self.problem.control.displacement(moved.placement)
        twist, alpha, dissipation = moved.twist(solution.u), solution.load_factor, solution.dissipation
        falling, yields = solution.falling, self.problem.yielding(moved.tie_force(solution.tie_force))
        time = min(time, moved.reach / self._closing(twist))
        ties = moved.longest, moved.tight, yields
        state = State(placement, alpha, dissipation, twist, time, displacement, *ties, falling)
        return Found(state, moved, solution)

    def _closing(self, twist: Array) -> float:
        """Speed that no two points of blocks are faster than towards each other in a motion, twists (B, 6)."""
        apart = np.linalg.norm(np.ptp(twist[:, :3], axis=0))
        turning = np.linalg.norm(twist[:, 3:], axis=1) * self._radius
        return float(apart + np.sort(turning)[-2:].sum())

    def _closes(self, moved: MovedProblem, solved: Solved, twist: Array) -> bool:
        """Whether a solution pulls a tie tight, or closes a gap that the last motion closes too, and has weight there.

        Gaps are those near which nothing was pressed in the last state: hinges that move open by the square of the way,
        and have their forces across that all of the time.
        """
        if (solved.tightening > REACHING).any():
            return True
        meets = (solved.reaching > REACHING) & (moved.relative(twist)[:, 0] < 0)
        if self.last is None or not meets.any():
            return False
        carried, _ = self._carried
        return not carried.pressed_near(moved, NEAREST)[meets].all()

    def _until_closed(self, moved: MovedProblem, solved: Solved, twist: Array) -> float:
        """Time in which the last motion closes the first gap or slack across which the solution has a force of weight.

        Forces of a step are those at its end; what closes on the way has none before.
        """
        reaching, tightening = solved.reaching > REACHING, solved.tightening > REACHING
        longer = moved.problem.ties.elongation(moved.velocities(twist))
        ways = np.concatenate([moved.contacts.gap[reaching], moved.slack_in(1.0)[tightening]])
        rates = np.concatenate([-moved.relative(twist)[reaching, 0], longer[tightening]])
        return (1 - BEFORE) * float((ways / np.maximum(rates, 1e-300)).min(initial=np.inf))

    def drops(self, falling: float, before: float = 0.0) -> bool:
        """Whether blocks drop until they meet others, by the rates of the dead load's work in a step and in another."""
        return falling > max(before, self.driving - self.load_factor) + DROPS * self.driving

    def falls(self, solved: Solved) -> bool:
        """Whether the dead load drives the motion, and not the push: what forces there are is no load factor then."""
        most = FALLING if solved.load_factor > 0 else FALLING_AT_ZERO
        return solved.falling > most * self.driving

    def settles(self, found: Found, before: State) -> bool:
        """Whether blocks that have dropped on the way to a state drop on by little, or do little work by it.

        Behind what happens steps are short, and on them any drop does more work than the push: what counts is the push
        on the longest of all steps.
        """
        furthest = float(np.linalg.norm(found.state.twist[:, :3], axis=1).max()) * found.state.time
        near = furthest <= SETTLES * self.problem.statics.length
        little = found.solved.falling * found.state.time < self.driving * self.pace.longest
        return (before.drops_next or little) and near and found.solved.missed <= CERTIFIED

    def goes_on(self, solved: Solved) -> bool:
        """Whether the next step may begin at a state."""
        return solved.missed <= CERTIFIED and not self.falls(solved)
