"""The pushover: from the collapse state through finite displacements until the load factor is zero."""

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

#: Attempts at a step that the blocks penetrate after, or the flow rule is missed.
ATTEMPTS = 5
#: Corrections of the length of a step that ends before a tie breaks: anchors do not part evenly.
APPROACHES = 3
#: Penetration after a shorter step, relative to the deepest by the square of its length; and least share of a step.
BELOW, LEAST_SHARE = 0.9, 0.25
#: Deepest penetration, in mean block sizes.
DEEPEST = 2e-3
#: Flow-rule gap, relative to the work of a step, beyond which the pushover cannot go on from it; and how often it may
#: one after the other where the gap is not certified.
LOST, DOUBTFUL = 0.03, 3
#: Steps, in multiples of those asked for, after which the curve is left; and how few asked for count as more. Behind
#: what happens on the way steps grow again from small ones, which takes as many of them whatever was asked for.
PATIENCE, FEW = 5, 20
#: How far a first state with sharp corners may be above the collapse state, relatively: that of a cross vault is 1.1 %.
ABOVE = 0.015
#: What the energy balance of a step may miss, relative to all work so far, before it is divided; and attempts.
EVENT, EVENTS = 1e-3, 3
#: What it misses in a shorter step, relative to what goes with the square of its length, where forces bend and do not
#: jump; and share of the length on which that would be within the bound.
BENT, WITHIN = (0.5, 1.5), 0.9
#: Corrections of the last step towards a load factor of zero.
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
        first = path.attempts.begun(rest, collapse)
        if first is None:
            return path.lost(rest, None)
        # Rounded corners lower what is found, and hide what is above.
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
    """The curve so far, and the next step of it."""

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
        """Displacement, m, and load factor of each state."""
        return self.attempts.pace.curve

    def taken(self, step: FiniteStep) -> State:
        """Take a state as the last one, from what is kept of it alone: a curve that is gone on with is the same."""
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
        """The state after a step, or why there is none."""
        attempts = self.attempts
        following, time = self._tried(state)
        if isinstance(following, str):
            return following
        self._divided, divided = False, self._divided
        tried = attempts.stepper.carried, attempts.stepper.waiting
        dropping = drop_on(attempts, state, following, time)
        if dropping is not None:
            return dropping
        # What was looked for in vain leaves nothing behind.
        attempts.stepper.go_on(*tried)
        error, work = self._energy(state, following.state)
        missed = self._share(error, work)
        # Blocks that fall release work that nothing balances, however short the step.
        self._divided = missed > EVENT and not divided and following.solved.falling < attempts.driving
        if not self._divided:
            return following
        # Forces that jump where something happens have not acted on the way there, and what is missed goes with the
        # length of the step in which they do: most of the way is a step of its own. Where it goes with the square of
        # that length forces bend, and do not jump: what is left of the way may be divided as well.
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
        """What the energy balance of a step misses, relative to all work so far."""
        return missed / max(self._done + work, 1e-300)

    def _tried(self, state: State) -> tuple[Found | str, float]:
        """The state after a step, shortened until it is solved, or why there is none; and its time."""
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
            # The depth is that of a chord over an arc, or of blocks that meet: at least in proportion.
            if depth > 1 and not last:
                time *= max(BELOW / np.sqrt(depth), LEAST_SHARE)
                continue
            following = attempts.reached(moved, state)
            # Half of a way that blocks drop by is none that they rest on.
            landed = not halved and following is not None and attempts.settles(following, state)
            if landed or (following is not None and attempts.goes_on(following.solved)):
                break
            if not last:
                time, halved = time / 2, True
        most = CERTIFIED if self._doubtful == DOUBTFUL else LOST
        if following is None or following.solved.missed > most or (attempts.falls(following.solved) and not landed):
            return self.lost(moved.placement, following), time
        # Where a tie breaks the load factor falls at once, and not on the way there.
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
        """The state as it is kept."""
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
        """Work between two states that is missed, and the sum of all of it, J, by the trapezoidal rule.

        Work of the dead and of the variable loads, on the way that blocks have really gone, is dissipated.
        """
        places = before.placement, after.placement
        dead, variable = self._problem.dead.work(*places), self._problem.variable.work(*places)
        pushed = variable * (before.load_factor + after.load_factor) / 2
        return abs(dead + pushed - variable * after.dissipated), abs(dead) + abs(pushed) + abs(dead + pushed)
