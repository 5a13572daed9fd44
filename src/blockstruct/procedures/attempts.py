"""Try the next step of a pushover from a known state."""

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

#: Ratio of a step's length to the wanted length above which the step is solved again; most attempts.
MISSED, LENGTHS = 1.5, 3
#: Work of forces across closing gaps, relative to all work of the step, above which the step stops at the first gap.
#: Share of the way that stays open before that gap. Shortest such step, relative to an even division of the curve.
REACHING, BEFORE, CLOSEST = 1e-3, 1e-3, 1 / 4096
#: Least reach of contact detection, in mean block sizes. Reach in multiples of the last motion. Second reach, in mean
#: block sizes, if the first finds nothing. Measured at hinges of arches that jump: voussoirs move back by up to 0.07,
#: and rest.
NEAREST, REACH, WIDE = 0.05, 2.0, 0.2
#: A state found with the second reach is accepted up to this change of the load factor, relative to collapse.
LIKE = 0.1
#: Blocks fall above this work rate of the dead load, less the part that ties take up. Its unit is the work rate at
#: collapse of the variable load or of friction, the larger. The second value applies if no load factor is left.
#: Measured with units that drop a short way onto others: up to 5.
FALLING, FALLING_AT_ZERO = 10.0, 3.0
#: Largest way of the fastest block, in mean block sizes, in a step after which dropping blocks count as settled.
SETTLES = 0.1
#: Rise of the dead load's work rate, in the same unit, above which blocks drop.
DROPS = 0.1
#: Change of the load factor, relative to the collapse load factor, up to which a step with a drop alone shows a drop.
STEADY = 0.05
#: Least work that errors of a step are relative to, in multiples of the work at the collapse load.
LEAST_WORK = 0.05
#: Work of friction at collapse, relative to the work of the push, up to which blocks rock. Solutions that stop early
#: contain some friction work.
ROCKS = 0.05


class Attempts:
    """Try continuations of a curve; only :meth:`taken` keeps a state."""

    def __init__(
        self, problem: MovingProblem, collapse: Iteration, steps: int, settings: ProcedureSettings, solver: Solver
    ) -> None:
        self.problem = problem
        self.load_factor = abs(collapse.load_factor)
        # Near the friction angle, gravity does most of the work against friction.
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
        """Keep a state as the last one."""
        self.pace.taken(state)
        self._before, self.last = self.last, state
        self._carried = Carried.of_step(self.problem, step), (step.body_failures, step.body_waits)
        self.go_on()

    def go_on(self) -> None:
        """Begin the next step from the last kept state.

        Forces of attempts made since then have no influence.
        """
        self.stepper.go_on(*self._carried)

    def begun(self, rest: Placement, collapse: Iteration) -> Found | None:
        """Find the collapse state again for the contacts of the pushover.

        These contacts differ from the model's if corners are rounded or faces overlap beyond interfaces.
        """
        moved = self.problem.at(rest, self._nearest, self.problem.lengths(rest))
        twist = moved.twist(collapse.u)
        time = self.pace.time(moved.placement, twist)
        question = self._question(moved, time, twist)
        solution = self.stepper.begin(moved, question, collapse, self.problem.statics.points)
        return self.solved(moved, twist) if solution is None else self._found(moved, solution, time)

    def after(self, state: State, time: float) -> MovedProblem:
        """Return the problem after a state's motion has lasted a time.

        Contact detection reaches as far as that motion can close a gap.
        """
        reach = max(self._nearest, REACH * self._closing(state.twist) * time)
        placement = state.placement.moved(state.twist * time)
        return self.problem.at(placement, reach, state.longest, state.tightened(self.problem.lengths(placement)))

    def reached(self, moved: MovedProblem, before: State) -> Found | None:
        """Solve a step from the placement that a state's motion leads to.

        If nearby contacts cannot carry the dead load, search a second time with a wider reach. Blocks that drop may
        come to rest on these contacts. The result counts only if its load factor lies on the same curve.
        """
        # Dropped blocks have met others, so the motion before the drop continues.
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
        """Solve a step for a time in which only dropping blocks move.

        Return None if the load factor changes by more than :data:`STEADY`.
        """
        self.go_on()
        solution = self.stepper.solve(moved, self._question(moved, time, state.carried(moved.placement)))
        if solution is None or not solution.holds or abs(solution.load_factor - alpha) > STEADY * self.load_factor:
            return None
        found = self._found(moved, solution, time)
        return replace(found, state=replace(found.state, dropped=True)).after(state)

    def solved(self, moved: MovedProblem, twist: Array) -> Found | None:
        """Solve a step of the wanted length from a placement.

        The length limits the way of the control point and of the fastest block.
        """
        placement = moved.placement
        time, last = self.pace.time(placement, twist), twist
        shortest = CLOSEST * self.pace.even / self.pace.way(placement) * time
        found: Found | None = None
        # The work rate of the dead load in the last step is no sign of a drop.
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
                # The last motion closes the gap later than this one.
                longest, left = max(time / 2, shortest), max(left, 1)
            better = min(self.pace.time(placement, twist), longest)
            if 1 / MISSED < better / time < MISSED and time <= longest:
                break
            time = better
        return found

    def _question(self, moved: MovedProblem, time: float, twist: Array) -> Question:
        """Return the step for a time."""
        return Question.of(moved, time, twist, self._least, rocks=self._rocks)

    def _found(self, moved: MovedProblem, solution: Solved, time: float) -> Found:
        """Return the state of a solution.

        Its motion stops before blocks could meet others beyond the reach of contact detection.
        """
        placement, displacement = moved.placement, self.problem.control.displacement(moved.placement)
        twist, alpha, dissipation = moved.twist(solution.u), solution.load_factor, solution.dissipation
        falling, yields = solution.falling, self.problem.yielding(moved.tie_force(solution.tie_force))
        time = min(time, moved.reach / self._closing(twist))
        ties = moved.longest, moved.tight, yields
        state = State(placement, alpha, dissipation, twist, time, displacement, *ties, falling)
        return Found(state, moved, solution)

    def _closing(self, twist: Array) -> float:
        """Return an upper bound of the speed at which blocks approach.

        ``twist`` has shape (B, 6).
        """
        apart = np.linalg.norm(np.ptp(twist[:, :3], axis=0))
        turning = np.linalg.norm(twist[:, 3:], axis=1) * self._radius
        return float(apart + np.sort(turning)[-2:].sum())

    def _closes(self, moved: MovedProblem, solved: Solved, twist: Array) -> bool:
        """Return whether a solution closes a tie's slack or a contact's gap.

        The force across the gap must do more than :data:`REACHING` of the step's work. The last motion must close the
        gap too. Gaps near points pressed in the last state do not count. Moving hinges open with the square of the way
        and always have forces across such gaps.
        """
        if (solved.tightening > REACHING).any():
            return True
        meets = (solved.reaching > REACHING) & (moved.relative(twist)[:, 0] < 0)
        if self.last is None or not meets.any():
            return False
        carried, _ = self._carried
        return not carried.pressed_near(moved, NEAREST)[meets].all()

    def _until_closed(self, moved: MovedProblem, solved: Solved, twist: Array) -> float:
        """Return the time until the last motion closes the first gap.

        The gap of a contact or the slack of a tie counts if its force does more than :data:`REACHING` of the step's
        work. Forces of a step act at its end, and a gap has no force before it closes.
        """
        reaching, tightening = solved.reaching > REACHING, solved.tightening > REACHING
        longer = moved.problem.ties.elongation(moved.velocities(twist))
        ways = np.concatenate([moved.contacts.gap[reaching], moved.slack_in(1.0)[tightening]])
        rates = np.concatenate([-moved.relative(twist)[reaching, 0], longer[tightening]])
        return (1 - BEFORE) * float((ways / np.maximum(rates, 1e-300)).min(initial=np.inf))

    def drops(self, falling: float, before: float = 0.0) -> bool:
        """Return whether blocks drop until they meet others.

        Compare the work rates of the dead load in a step and in an earlier one.
        """
        return falling > max(before, self.driving - self.load_factor) + DROPS * self.driving

    def falls(self, solved: Solved) -> bool:
        """Return whether the dead load drives the motion instead of the push.

        The forces then give no load factor.
        """
        most = FALLING if solved.load_factor > 0 else FALLING_AT_ZERO
        return solved.falling > most * self.driving

    def settles(self, found: Found, before: State) -> bool:
        """Return whether dropped blocks come to rest in a state.

        They move by little, and do little work or have just begun to drop. Steps are short after an event, and on a
        short step any drop does more work than the push. The longest of all steps therefore gives the work of the push.
        """
        furthest = float(np.linalg.norm(found.state.twist[:, :3], axis=1).max()) * found.state.time
        near = furthest <= SETTLES * self.problem.statics.length
        little = found.solved.falling * found.state.time < self.driving * self.pace.longest
        return (before.drops_next or little) and near and found.solved.missed <= CERTIFIED

    def goes_on(self, solved: Solved) -> bool:
        """Return whether the next step may begin at a state."""
        return solved.missed <= CERTIFIED and not self.falls(solved)
