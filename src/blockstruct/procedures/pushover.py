"""The pushover: from the collapse state through finite displacements until the load factor is zero."""

from collections.abc import Generator, Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import Placement
from blockstruct.limit.capacity_curve import ZERO, FiniteStep, zero_displacement
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.moved import MovedProblem, MovingProblem
from blockstruct.limit.program import Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.body_step import Carried, Stepper
from blockstruct.procedures.finite_step import CERTIFIED, Question, Solved
from blockstruct.procedures.pace import Pace
from blockstruct.procedures.pushover_state import Found, State, friction_of, lost, stands

Array = NDArray[np.float64]

#: How far the way of a step may be from the one that is wanted, as a ratio, before it is solved again; and attempts.
MISSED, LENGTHS = 1.5, 3
#: Work of forces across gaps that close in a step, relative to all of its work, for which it is shortened to the
#: first of them; what is left of that way; and the least step to one, as a share of one that divides the curve evenly.
REACHING, BEFORE, CLOSEST = 1e-3, 1e-3, 1 / 4096
#: Attempts at a step that the blocks penetrate after, or the flow rule is missed.
ATTEMPTS = 5
#: Penetration after a shorter step, relative to the deepest by the square of its length; and least share of a step.
BELOW, LEAST_SHARE = 0.9, 0.25
#: Deepest penetration, and least reach of contacts, in mean block sizes; reach in multiples of the last motion.
DEEPEST, NEAREST, REACH = 2e-3, 0.05, 2.0
#: Flow-rule gap, relative to the work of a step, beyond which the pushover cannot go on from it; and how often it may
#: one after the other where the gap is not certified.
LOST, DOUBTFUL = 0.03, 3
#: Rate of the dead load's work, but for what ties take up, from which blocks fall, in multiples of that of the variable
#: load or of friction at collapse; and from which they do where no load factor is left. Measured where units drop a
#: little way until they meet others: up to 5.
FALLING, FALLING_AT_ZERO = 10.0, 3.0
#: Rise of that rate, in the same multiples, from which a shorter step has blocks that drop.
DROPS = 0.1
#: Rise of that rate, in the same multiples, and change of velocity, relative to the fastest, in a step on which blocks
#: may have begun to drop; the least rise, in multiples of that one, in a step shortened by a factor, if they have; and
#: of that, if they have there as well; halvings of the step until there; and what its load factor may be away by.
BEGINS, CHANGES, ALONE, SHORT, AS_FAR, HALVINGS, STEADY = 0.005, 0.07, 4.0, 1 / 32, 0.2, 4, 0.05
#: Steps, in multiples of those asked for, after which the curve is left.
PATIENCE = 5
#: What the energy balance of a step may miss, relative to all work so far, before it is divided; and attempts.
EVENT, EVENTS = 1e-3, 3
#: Corrections of the last step towards a load factor of zero.
CORRECTIONS = 3
#: Work of a step, relative to that at the collapse load, to which what it misses is relative where there is less.
LEAST_WORK = 0.05

FiniteSteps = Generator[FiniteStep, None, str]


def pushover(
    problem: MovingProblem,
    collapse: Iteration,
    steps: int,
    settings: ProcedureSettings,
    solver: Solver,
    before: Sequence[FiniteStep] = (),
) -> FiniteSteps:
    """Follow a collapse mechanism through finite displacements.

    In each step the displacement of the control point is prescribed, by the work of the variable load. Blocks then
    move along the screws of their twists, and contacts are found anew where they are. A step is halved where the
    blocks penetrate by more than a bound after it, or no motion from there satisfies the flow rule, as where a contact
    leaves its face or a block meets another; divided where its energy balance is missed, as where forces jump; and ends
    where blocks begin to drop, whose drop is a step of its own.

    Parameters
    ----------
    problem
        The case, wherever its blocks are.
    collapse
        The certified collapse state, whose mechanism is the first motion.
    steps
        Number of them, about.
    settings, solver
        Of the case.
    before
        States of the curve that are known already: it goes on behind the last of them.

    Yields
    ------
    FiniteStep
        A state; the first is that without displacement.

    Returns
    -------
    str
        How it ended.
    """
    path, state = _Path(problem, collapse, steps, settings, solver), None
    for known in before:
        state = path.taken(known)
    if state is None:
        rest = Placement.of(problem.statics.model)
        first = path.begun(rest, collapse)
        if first is None:
            return path.lost(rest, None)
        step = path.record(first)
        yield step
        state = path.taken(step)
    while True:
        end = zero_displacement(path.pace.curve)
        if np.isfinite(end):
            return f"the load factor is zero at a displacement of {end:.6g} m{stands(problem, path.pace.curve, state)}"
        if len(path.pace.curve) > PATIENCE * steps:
            return (
                f"no end after {len(path.pace.curve)} states, {PATIENCE} times the steps that were asked for: ask for "
                "more steps, or follow a point and a direction that the mechanism goes along"
            )
        following = path.advance(state)
        if isinstance(following, str):
            return following
        step = path.record(following)
        yield step
        state = path.taken(step)


class _Path:
    """The curve so far, and the next step of it."""

    def __init__(
        self, problem: MovingProblem, collapse: Iteration, steps: int, settings: ProcedureSettings, solver: Solver
    ) -> None:
        self._problem = problem
        self._load_factor = abs(collapse.load_factor)
        self._least = LEAST_WORK * self._load_factor
        self.pace = Pace(problem, steps, self._load_factor)
        self._size = problem.statics.length
        self._nearest = NEAREST * self._size
        self._longest = problem.lengths(Placement.of(problem.statics.model))
        # Down a slope that hardly holds it the push drives little of what friction takes.
        self._driving = max(self._load_factor, friction_of(problem.at_rest, collapse))
        self._before: State | None = None
        self._last: State | None = None
        self._stepper = Stepper(settings, solver)
        self._divided, self._doubtful = False, 0
        self._done, self._clock = 0.0, perf_counter()

    def taken(self, step: FiniteStep) -> State:
        """Take a state as the last one, from what is kept of it alone: a curve that is gone on with is the same."""
        placement = Placement.at(step.position, step.rotation)
        self._longest = np.maximum(self._longest, self._problem.lengths(placement))
        state = State.of(step, self._longest)
        if self._last is not None:
            self._done += self._energy(self._last, state)[1]
        self.pace.taken(state)
        self._before, self._last = self._last, state
        self._divided, self._doubtful = step.divided, 0 if step.holds else self._doubtful + 1
        self._carried = Carried.of_step(self._problem, step), (step.body_failures, step.body_waits)
        self._go_on()
        return state

    def _go_on(self) -> None:
        """Begin the next step, whatever was tried since: the forces of no other state act there."""
        self._stepper.go_on(*self._carried)

    def begun(self, rest: Placement, collapse: Iteration) -> Found | None:
        """The collapse state, found anew where corners are rounded and contacts not where the model has them."""
        moved = self._problem.at(rest, self._nearest, self._longest)
        twist = moved.twist(collapse.u)
        time = self.pace.time(moved.placement, twist)
        question = Question.of(moved, time, twist, self._least)
        solution = self._stepper.begin(moved, question, collapse, self._problem.statics.points)
        return self.solved(moved, twist) if solution is None else self._found(moved, solution, time)

    def solved(self, moved: MovedProblem, twist: Array) -> Found | None:
        """A step from a placement in which the control point moves as far as wanted, or blocks as far as they may."""
        placement = moved.placement
        time, last = self.pace.time(placement, twist), twist
        found: Found | None = None
        longest = np.inf
        for _ in range(LENGTHS):
            solution = self._stepper.solve(moved, Question.of(moved, time, twist, self._least))
            if solution is None:
                break
            if found is not None and (solution.missed > CERTIFIED or self._drops(solution, found.solved)):
                break
            found = self._found(moved, solution, time)
            twist = found.state.twist
            if solution.missed > CERTIFIED:
                break
            if np.isinf(longest):
                longest = self._until_closed(moved, solution, last, time)
            better = min(self.pace.time(placement, twist), longest)
            if 1 / MISSED < better / time < MISSED and time <= longest:
                break
            time = better
        return found

    def _found(self, moved: MovedProblem, solution: Solved, time: float) -> Found:
        """The state of a solution, whose motion goes on for a time."""
        placement, displacement = moved.placement, self._problem.control.displacement(moved.placement)
        twist, alpha, dissipation = moved.twist(solution.u), solution.load_factor, solution.dissipation
        falling, longest = solution.falling, moved.longest
        state = State(placement, alpha, dissipation, twist, time, displacement, longest, falling)
        return Found(state, moved, solution)

    def _reached(self, moved: MovedProblem, before: State) -> Found | None:
        """A step from where the motion of a state leads to."""
        # What dropped has met others: the push goes on as it did before.
        going = self._before if before.dropped and self._before is not None else before
        found = self.solved(moved, going.carried(moved.placement))
        return found and found.after(before)

    def _until_closed(self, moved: MovedProblem, solved: Solved, twist: Array, time: float) -> float:
        """Time in which the last motion closes the first gap or slack across which the solution has a force of weight.

        Forces of a step are those at its end; what closes on the way has none before.
        """
        reaching, tightening = solved.reaching > REACHING, solved.tightening > REACHING
        longer = moved.problem.ties.elongation(moved.velocities(twist))
        ways = np.concatenate([moved.contacts.gap[reaching], moved.slack_in(1.0)[tightening]])
        rates = np.concatenate([-moved.relative(twist)[reaching, 0], longer[tightening]])
        shortest = CLOSEST * self.pace.even / self.pace.way(moved.placement) * time
        return max((1 - BEFORE) * float((ways / np.maximum(rates, 1e-300)).min(initial=np.inf)), shortest)

    def advance(self, state: State) -> Found | str:
        """The state after a step, or why there is none."""
        following, time = self._tried(state)
        if isinstance(following, str):
            return following
        self._divided, divided = False, self._divided
        tried = self._stepper.carried, self._stepper.waiting
        dropping = self._dropping(state, following, time)
        if dropping is not None:
            return dropping
        # What was looked for in vain leaves nothing behind.
        self._stepper.go_on(*tried)
        missed = self._missed(state, following)
        # Blocks that fall release work that nothing balances, however short the step.
        self._divided = missed > EVENT and not divided and following.solved.falling < self._driving
        if not self._divided:
            return following
        # Forces that jump where something happens have not acted on the way there, and what is missed goes with the
        # length of the step in which they do: most of the way is a step of its own.
        whole, share = following.state.displacement, 1 - EVENT / missed / 2
        best = following
        for _ in range(EVENTS):
            moved = self._after(state, share * time)
            found = self._reached(moved, state)
            if found is None or not self._goes_on(found.solved):
                break
            if self._missed(state, found) < missed:
                best, missed = found, self._missed(state, found)
            if missed <= EVENT:
                break
            share /= 2
        if best is following:
            return best
        speed = abs(self._problem.control.velocity(best.state.placement, best.state.twist))
        rest = abs(whole - best.state.displacement) / max(speed, 1e-300)
        return replace(best, state=replace(best.state, time=min(best.state.time, rest)))

    def _dropping(self, state: State, following: Found, time: float) -> Found | None:
        """The state just before blocks drop on a step, or the drop itself where they do at once; None if none do.

        What the push drives goes with its step. What drops until it meets others goes all of that way in a step
        however short; on a step as long as others it would seem to hold for so long.
        """
        short, alpha = SHORT * following.state.time, following.solved.load_factor
        if state.drops_next:
            return self._alone(state, following.moved, short, alpha)
        rise = following.solved.falling - state.falling
        falls = state.falling > self._driving * (1 + DROPS) - self._load_factor
        velocity = state.carried(following.state.placement)[:, :3]
        change = np.abs(following.state.twist[:, :3] - velocity).max() / np.abs(velocity).max()
        if state.dropped or falls or rise < BEGINS * self._driving or change < CHANGES:
            return None
        found = self._alone(state, following.moved, short, alpha)
        if found is None or found.solved.falling - state.falling < ALONE * rise:
            return None
        least = state.falling + AS_FAR * (found.solved.falling - state.falling)
        before, behind = 0.0, time
        for _ in range(HALVINGS):
            half = (before + behind) / 2
            earlier = self._alone(state, self._after(state, half), short, alpha)
            if earlier is None:
                break
            if earlier.solved.falling > least:
                behind, found = half, earlier
            else:
                before = half
        if before:
            self._go_on()
            holds = self._reached(self._after(state, before), state)
            if holds is not None and self._goes_on(holds.solved):
                return replace(holds, state=replace(holds.state, time=behind - before, drops_next=True))
        return found

    def _alone(self, state: State, moved: MovedProblem, time: float, alpha: float) -> Found | None:
        """A step for a time in which only what drops moves, and in which little else tells of the load factor."""
        self._go_on()
        solution = self._stepper.solve(moved, Question.of(moved, time, state.carried(moved.placement), self._least))
        if solution is None or not solution.holds or abs(solution.load_factor - alpha) > STEADY * self._load_factor:
            return None
        found = self._found(moved, solution, time)
        return replace(found, state=replace(found.state, dropped=True)).after(state)

    def _missed(self, state: State, found: Found) -> float:
        """What the energy balance of a step misses, relative to all work so far."""
        missed, work = self._energy(state, found.state)
        return missed / max(self._done + work, 1e-300)

    def _tried(self, state: State) -> tuple[Found | str, float]:
        """The state after a step, shortened until it is solved, or why there is none; and its time."""
        time = state.time
        following = None
        for attempt in range(ATTEMPTS):
            moved = self._after(state, time)
            whole = self._problem.until_broken(state.longest, moved.longest)
            if whole < 1:
                time *= whole
                moved = self._after(state, time)
            last, depth = attempt + 1 == ATTEMPTS, moved.penetration / (DEEPEST * self._size)
            # The depth is that of a chord over an arc, or of blocks that meet: at least in proportion.
            if depth > 1 and not last:
                time *= max(BELOW / np.sqrt(depth), LEAST_SHARE)
                continue
            following = self._reached(moved, state)
            if following is not None and self._goes_on(following.solved):
                break
            if not last:
                time /= 2
        most = CERTIFIED if self._doubtful == DOUBTFUL else LOST
        if following is None or following.solved.missed > most or self._falls(following.solved):
            return self.lost(moved.placement, following), time
        # Where a tie breaks the load factor falls at once, and not on the way there.
        if self._problem.breaks(state.longest, moved.longest).any():
            return following, time
        for _ in range(CORRECTIONS):
            below = following.state.load_factor
            if below >= -ZERO * self._load_factor or state.load_factor <= 0:
                break
            time *= state.load_factor / (state.load_factor - below)
            moved = self._after(state, time)
            back = self._reached(moved, state)
            if back is None or not self._goes_on(back.solved):
                break
            following = back
        return following, time

    def _after(self, state: State, time: float) -> MovedProblem:
        """The problem where the blocks of a state are after a time, with contacts within the reach of that motion."""
        furthest = float(np.linalg.norm(state.twist[:, :3], axis=1).max()) * time
        reach = max(self._nearest, REACH * furthest)
        return self._problem.at(state.placement.moved(state.twist * time), reach, state.longest)

    def _drops(self, solved: Solved, before: Solved) -> bool:
        """Whether blocks drop until they meet others: a shorter step has the drop alone, and less to meet."""
        at_collapse = self._driving - self._load_factor
        return solved.falling > max(before.falling, at_collapse) + DROPS * self._driving

    def _falls(self, solved: Solved) -> bool:
        """Whether the dead load drives the motion, and not the push: what forces there are is no load factor then."""
        most = FALLING if solved.load_factor > 0 else FALLING_AT_ZERO
        return solved.falling > most * self._driving

    def _goes_on(self, solved: Solved) -> bool:
        """Whether the next step may begin at a state."""
        return solved.missed <= CERTIFIED and not self._falls(solved)

    def lost(self, placement: Placement, found: Found | None) -> str:
        return lost(self._problem, placement, found, falls=found is not None and self._falls(found.solved))

    def record(self, found: Found) -> FiniteStep:
        """The state as it is kept."""
        missed = work = 0.0
        if self._last is not None:
            missed, work = self._energy(self._last, found.state)
        all_work = self._done + work
        time, self._clock = perf_counter() - self._clock, perf_counter()
        return found.kept(
            divided=self._divided,
            waiting=self._stepper.waiting,
            energy_error=missed / all_work if all_work else 0.0,
            spent=self._stepper.solver.spent(),
            time=time,
        )

    def _energy(self, before: State, after: State) -> tuple[float, float]:
        """Work between two states that is missed, and the sum of all of it, J, by the trapezoidal rule.

        Work of the dead and of the variable loads, on the way that blocks have really gone, is dissipated.
        """
        places = before.placement, after.placement
        dead, variable = self._problem.dead.work(*places), self._problem.variable.work(*places)
        pushed = variable * (before.load_factor + after.load_factor) / 2
        return abs(dead + pushed - variable * after.dissipated), abs(dead) + abs(pushed) + abs(dead + pushed)
