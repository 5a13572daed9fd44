"""Follow the collapse mechanism until the load factor is zero.

The pushover begins at the collapse state and goes through finite displacements.
"""

from collections.abc import Generator, Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import Placement
from blockstruct.limit.capacity_curve import ZERO, FiniteStep, zero_displacement
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.moved import MovingProblem
from blockstruct.limit.program import Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.attempts import Attempts
from blockstruct.procedures.drops import drop_on
from blockstruct.procedures.finite_step import CERTIFIED
from blockstruct.procedures.pushover_state import Found, State, begins_above, lost, stands
from blockstruct.vocabulary import counted

Array = NDArray[np.float64]

#: Most attempts at a step after which blocks penetrate too far or the flow rule does not hold.
ATTEMPTS = 5
#: Most corrections of a step's length to end it at the failure of a tie. The distance between anchors is not linear in
#: time.
APPROACHES = 3
#: Safety factor on the length of a shorter step, whose penetration falls with the square of the length; least share of
#: a step.
BELOW, LEAST_SHARE = 0.9, 0.25
#: Deepest penetration, in mean block sizes.
DEEPEST = 2e-3
#: Flow-rule gap, relative to the work of a step, above which the pushover ends; most steps in a row with a gap that is
#: not certified.
LOST, DOUBTFUL = 0.03, 3
#: Most steps, in multiples of the requested number; least number requested that this limit assumes. After an event,
#: steps grow again from small ones. This takes the same number of steps for any request.
PATIENCE, FEW = 5, 20
#: Relative excess over the collapse load that is allowed for a first state with sharp corners. A cross vault has 1.1 %.
ABOVE = 0.015
#: Error of the energy balance of a step, relative to all work so far, above which the step is divided; most attempts.
EVENT, EVENTS = 1e-3, 3
#: Ratio of the error in a shorter step to quadratic scaling with its length: within this range, forces change
#: continuously. Safety factor on the length at which the error is then within the bound.
BENT, WITHIN = (0.5, 1.5), 0.9
#: Most corrections of the last step towards a load factor of zero.
CORRECTIONS = 3

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

    Each step prescribes the displacement of the control point, by the work of the variable load. Blocks move along the
    screws of their twists. Contact detection then runs again at the new placement.

    A step is halved if blocks penetrate too far, or no motion after it satisfies the flow rule. The latter happens if a
    contact leaves its face or a block meets another. A step is divided if its energy balance is missed, for example
    because forces jump. A step ends at the point at which blocks begin to drop, and the drop is a separate step.

    Parameters
    ----------
    problem
        The case, at any placement of its blocks.
    collapse
        The certified collapse state, whose mechanism is the first motion.
    steps
        Approximate number of steps.
    settings, solver
        Settings and solver of the case.
    before
        Known states of the curve, which continues after the last state.

    Yields
    ------
    FiniteStep
        A state; the first has zero displacement.

    Returns
    -------
    str
        How the pushover ended.
    """
    path, state = _Path(problem, collapse, steps, settings, solver), None
    for known in before:
        state = path.taken(known)
    if state is None:
        rest = Placement.of(problem.statics.model)
        first = path.attempts.begun(rest, collapse)
        if first is None:
            return path.lost(rest, None)
        # Rounded corners lower the load factor and hide an excess over the collapse load.
        sharp = problem.sharp
        own = first if sharp is problem else Attempts(sharp, collapse, steps, settings, solver).begun(rest, collapse)
        if own is not None and own.state.load_factor > (1 + ABOVE) * path.attempts.load_factor:
            return begins_above(problem, own, path.attempts.load_factor)
        step = path.record(first)
        yield step
        state = path.taken(step)
    while True:
        end = zero_displacement(path.curve)
        if np.isfinite(end):
            return f"the load factor is zero at a displacement of {end:.6g} m{stands(problem, path.curve, state)}"
        if len(path.curve) > PATIENCE * max(steps, FEW):
            return (
                f"no end after {len(path.curve)} states, with {counted(steps, 'step')} asked for: ask for more steps, "
                "or follow a point and a direction that the mechanism goes along"
            )
        following = path.advance(state)
        if isinstance(following, str):
            return following
        step = path.record(following)
        yield step
        state = path.taken(step)


class _Path:
    """Compute the next step from the curve so far."""

    def __init__(
        self, problem: MovingProblem, collapse: Iteration, steps: int, settings: ProcedureSettings, solver: Solver
    ) -> None:
        self._problem = problem
        self.attempts = Attempts(problem, collapse, steps, settings, solver)
        self._longest = problem.lengths(Placement.of(problem.statics.model))
        self._divided, self._doubtful = False, 0
        self._done, self._clock = 0.0, perf_counter()

    @property
    def curve(self) -> list[tuple[float, float]]:
        """Return displacement, m, and load factor of each state."""
        return self.attempts.pace.curve

    def taken(self, step: FiniteStep) -> State:
        """Take a state as the last one.

        Only the kept data of the state matter, so a continued curve is the same.
        """
        placement = Placement.at(step.position, step.rotation)
        lengths, last = self._problem.lengths(placement), self.attempts.last
        self._longest = np.maximum(self._longest, lengths)
        tight = lengths if last is None else last.tightened(lengths)
        state = State.of(step, self._longest, tight, self._problem.yielding(step.tie_force))
        if last is not None:
            self._done += self._energy(last, state)[1]
        self._divided, self._doubtful = step.divided, 0 if step.holds else self._doubtful + 1
        self.attempts.taken(state, step)
        return state

    def advance(self, state: State) -> Found | str:
        """Return the state after a step, or the reason for its absence."""
        attempts = self.attempts
        following, time = self._tried(state)
        if isinstance(following, str):
            return following
        self._divided, divided = False, self._divided
        tried = attempts.stepper.carried, attempts.stepper.waiting
        dropping = drop_on(attempts, state, following, time)
        if dropping is not None:
            return dropping
        # A search without success has no effect on the next step.
        attempts.stepper.go_on(*tried)
        error, work = self._energy(state, following.state)
        missed = self._share(error, work)
        # Blocks that fall release work that nothing balances, in a step of any length.
        self._divided = missed > EVENT and not divided and following.solved.falling < attempts.driving
        if not self._divided:
            return following
        # Forces that jump at an event do not act before it. The error is then proportional to the length of the step
        # that contains the event, and most of the way is a separate step. An error that is quadratic in the length
        # means that forces change without a jump. The rest of the way may then be divided as well.
        whole, share = following.state.displacement, 1 - EVENT / missed / 2
        best = following
        for _ in range(EVENTS):
            moved = attempts.after(state, share * time)
            found = attempts.reached(moved, state)
            if found is None or not attempts.goes_on(found.solved):
                break
            less, done = self._energy(state, found.state)
            bent = BENT[0] < less / (error * share**2) < BENT[1]
            if self._share(less, done) < missed:
                best, missed, self._divided = found, self._share(less, done), not bent
            if missed <= EVENT:
                break
            own, before = EVENT * work / error / 2, EVENT * self._done / error
            share = WITHIN * (own + np.sqrt(own**2 + before)) if bent else share / 2
        if best is following:
            return best
        speed = abs(self._problem.control.velocity(best.state.placement, best.state.twist))
        rest = abs(whole - best.state.displacement) / max(speed, 1e-300)
        return replace(best, state=replace(best.state, time=min(best.state.time, rest)))

    def _share(self, missed: float, work: float) -> float:
        """Return the error of an energy balance relative to all work so far."""
        return missed / max(self._done + work, 1e-300)

    def _tried(self, state: State) -> tuple[Found | str, float]:
        """Return the state after a step, and the step's time.

        Shorten the step until it is solved. Return a reason instead of a state if no step is solved.
        """
        attempts, time = self.attempts, state.time
        following, halved, landed = None, False, False
        for attempt in range(ATTEMPTS):
            moved = attempts.after(state, time)
            for _ in range(1 if self._problem.at_limit(state.longest).any() else APPROACHES):
                whole = self._problem.until_broken(state.longest, moved.longest)
                if whole == 1:
                    break
                time *= whole
                moved = attempts.after(state, time)
            last, depth = attempt + 1 == ATTEMPTS, moved.penetration / (DEEPEST * self._problem.statics.length)
            # The depth comes from a chord over an arc, or from blocks that meet. It is at least proportional to the
            # length.
            if depth > 1 and not last:
                time *= max(BELOW / np.sqrt(depth), LEAST_SHARE)
                continue
            following = attempts.reached(moved, state)
            # A landing cannot be judged on half of a drop.
            landed = not halved and following is not None and attempts.settles(following, state)
            if landed or (following is not None and attempts.goes_on(following.solved)):
                break
            if not last:
                time, halved = time / 2, True
        most = CERTIFIED if self._doubtful == DOUBTFUL else LOST
        if following is None or following.solved.missed > most or (attempts.falls(following.solved) and not landed):
            return self.lost(moved.placement, following), time
        # The load factor falls suddenly when a tie breaks, not before.
        if self._problem.breaks(state.longest, moved.longest).any():
            return following, time
        for _ in range(CORRECTIONS):
            below = following.state.load_factor
            if below >= -ZERO * attempts.load_factor or state.load_factor <= 0:
                break
            time *= state.load_factor / (state.load_factor - below)
            moved = attempts.after(state, time)
            back = attempts.reached(moved, state)
            if back is None or not attempts.goes_on(back.solved):
                break
            following = back
        return following, time

    def lost(self, placement: Placement, found: Found | None) -> str:
        return lost(self._problem, placement, found, falls=found is not None and self.attempts.falls(found.solved))

    def record(self, found: Found) -> FiniteStep:
        """Return the state in the format that is kept."""
        missed = work = 0.0
        if self.attempts.last is not None:
            missed, work = self._energy(self.attempts.last, found.state)
        time, self._clock = perf_counter() - self._clock, perf_counter()
        return found.kept(
            divided=self._divided,
            waiting=self.attempts.stepper.waiting,
            energy_error=self._share(missed, work),
            spent=self.attempts.stepper.solver.spent(),
            time=time,
        )

    def _energy(self, before: State, after: State) -> tuple[float, float]:
        """Return the energy error between two states, and all work, J.

        Use the trapezoidal rule. The work of the dead and variable loads, on the true way of the blocks, must equal the
        dissipated work.
        """
        places = before.placement, after.placement
        dead, variable = self._problem.dead.work(*places), self._problem.variable.work(*places)
        pushed = variable * (before.load_factor + after.load_factor) / 2
        return abs(dead + pushed - variable * after.dissipated), abs(dead) + abs(pushed) + abs(dead + pushed)
