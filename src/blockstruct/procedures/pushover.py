"""The pushover: from the collapse state through finite displacements until the load factor is zero."""

from collections.abc import Generator
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.iteration import Iteration
from blockstruct.limit.moved import FiniteStep, MovedProblem, MovingProblem
from blockstruct.limit.program import Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.finite_step import CERTIFIED, Solved, solve_finite_step
from blockstruct.statics import Placement

Array = NDArray[np.float64]

#: Growth of a step over the last, and the least and most of it, in shares of a step that divides the curve evenly.
GROWTH, LEAST, MOST = 1.5, 1 / 64, 2.0
#: First step, in such shares.
FIRST = 0.25
#: Most that a block may move, in multiples of what the control point was meant to.
FASTEST = 3.0
#: How far the control point may miss what it was meant to, as a ratio, before the step is solved again.
MISSED = 1.5
#: Attempts to find a step of the wanted length, and to halve one that penetrates.
LENGTHS, HALVINGS = 3, 3
#: Flow-rule gap, relative to the work of a step, beyond which it is no state to go on from.
LOST = 0.5
#: Rate of the dead load's work, in multiples of that of the collapse load, from which blocks fall by themselves.
FALLING = 3.0
#: Speed, relative to the fastest block, from which a block is told to fall, and blocks that a message names.
FAST, NAMED = 0.5, 5
#: Deepest penetration, and least reach of contacts, in mean block sizes; reach in multiples of the last motion.
DEEPEST, NEAREST, REACH = 2e-3, 0.05, 2.0
#: Steps, in multiples of those asked for, after which the curve is left.
PATIENCE = 5
#: Load factor, relative to the first one, that is zero; and corrections of the last step towards it.
ZERO, CORRECTIONS = 1e-4, 3
#: Work of a step, relative to that at the collapse load, to which what it misses is relative where there is less.
LEAST_WORK = 0.05

Ended = tuple[str, bool]
Finite = Generator[FiniteStep, None, Ended]


@dataclass(frozen=True, slots=True)
class _State:
    """A placement, what a step from there found, and the motion of the step."""

    moved: MovedProblem
    solved: Solved
    twist: Array
    work: float
    displacement: float

    @property
    def penetration(self) -> float:
        """Deepest penetration, m."""
        return max(-float(self.moved.contacts.gap.min(initial=0.0)), 0.0)

    @property
    def motion(self) -> Array:
        """Twists (B, 6) of the step."""
        return self.twist * self.work

    def carried(self, placement: Placement) -> Array:
        """The same screws, as twists (B, 6) of the centroids at another placement."""
        way = placement.position - self.moved.placement.position
        return np.column_stack([self.twist[:, :3] + np.cross(self.twist[:, 3:], way), self.twist[:, 3:]])


def pushover(
    problem: MovingProblem,
    collapse: Iteration,
    steps: int,
    settings: ProcedureSettings,
    solver: Solver,
    before: list[FiniteStep],
) -> Finite:
    """Follow a collapse mechanism through finite displacements.

    In each step the work of the variable load is prescribed, as a displacement of the control point; blocks then move
    along the screws of their twists, and contacts are found anew where they are. A step is halved where the blocks
    penetrate by more than a bound after it, as where one leaves a face or meets another.

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
    str, bool
        How it ended, and whether the load factor came down to zero.
    """
    path = _Path(problem, collapse.load_factor, steps, settings, solver, before)
    if before:
        last = before[-1]
        placement = Placement.at(last.position, last.rotation)
        twist = np.column_stack([last.velocity, last.angular_velocity])
        state = path.solved(placement, twist, path.wanted(), path.nearest)
    else:
        placement = Placement.of(problem.statics.model)
        state = path.solved(placement, problem.twist(collapse.u), path.wanted(), path.nearest)
    if state is None:
        return path.lost(placement), False
    if not before:
        yield path.record(None, state)
    while True:
        if path.is_over(state):
            return f"the load factor is zero at a displacement of {path.zero:.6g} m", True
        if len(path.curve) > PATIENCE * steps:
            return f"no end after {len(path.curve)} states, {PATIENCE} times the steps that were asked for", False
        following = path.advance(state)
        if isinstance(following, str):
            return following, False
        yield path.record(state, following)
        state = following


class _Path:
    """The curve so far, and the next step of it."""

    def __init__(
        self,
        problem: MovingProblem,
        load_factor: float,
        steps: int,
        settings: ProcedureSettings,
        solver: Solver,
        before: list[FiniteStep],
    ) -> None:
        self._least = LEAST_WORK * abs(load_factor)
        self._problem, self._steps, self._settings, self._solver = problem, steps, settings, solver
        self.curve = [(step.displacement, step.load_factor) for step in before]
        model = problem.statics.model
        vertices = np.concatenate([b.shape.vertices for b in model.blocks])
        self._extent = float(np.ptp(vertices, axis=0).max())
        self._size = problem.statics.length
        self.nearest = NEAREST * self._size
        self.zero = np.nan
        self._last = self._done = 0.0
        self._time = perf_counter()

    def wanted(self) -> float:
        """Displacement of the control point in the next step."""
        if len(self.curve) < 2:
            return FIRST * self._extent / (8 * self._steps)
        (d0, a0), (d1, a1) = self.curve[-2:]
        even = self._even()
        last = self._last or abs(d1 - d0)
        return float(np.clip(even, max(LEAST * even, last / 2), GROWTH * last))

    def _even(self) -> float:
        """Step that divides the curve, as it goes on along a straight line, evenly."""
        d, a = np.array(self.curve[-8:]).T
        slope = float(np.polyfit(d, a, 1)[0])
        start = self.curve[0][1]
        left = self.curve[-1][1] / -slope if slope < 0 else np.inf
        whole = self.curve[-1][0] + left
        floor = self._extent / (8 * self._steps)
        return float(min(whole / self._steps, MOST * floor * max(1.0, 8 * start)))

    def solved(self, placement: Placement, twist: Array, wanted: float, reach: float) -> _State | None:
        """A step from a placement in which the control point moves as far as wanted, or blocks as far as they may."""
        control, moved = self._problem.control, self._problem.at(placement, reach)
        work = self._work(placement, twist, wanted)
        state: _State | None = None
        for _ in range(LENGTHS):
            found = solve_finite_step(moved, work, twist, self._least, self._settings, self._solver)
            if found is None:
                return state
            twist = self._problem.twist(found.u)
            state = _State(moved, found, twist, work, control.displacement(placement))
            better = self._work(placement, twist, wanted)
            if 1 / MISSED < better / work < MISSED:
                break
            work = better
        return state

    def _work(self, placement: Placement, twist: Array, wanted: float) -> float:
        """Work of the unit variable load with which the control point moves as far as wanted."""
        speed = abs(self._problem.control.velocity(placement, twist))
        fastest = float(np.linalg.norm(twist[:, :3], axis=1).max())
        return wanted / max(speed, fastest / FASTEST, 1e-300)

    def advance(self, state: _State) -> _State | str:
        """The state after a step, or why there is none."""
        motion = state.motion
        for halving in range(HALVINGS + 1):
            placement = state.moved.placement.moved(motion)
            reach = max(self.nearest, REACH * float(np.linalg.norm(motion[:, :3], axis=1).max()))
            following = self.solved(placement, state.carried(placement), self.wanted(), reach)
            if following is not None and (self._is_good(following) or halving == HALVINGS):
                break
            motion = motion / 2
        if following is None or following.solved.missed > LOST or self._falls(following):
            return self.lost(placement, following)
        following = self._back_to_zero(state, following, motion, reach)
        self._last = abs(following.displacement - state.displacement)
        return following

    def _back_to_zero(self, state: _State, following: _State, motion: Array, reach: float) -> _State:
        """The state after so much of a motion that the load factor is zero, if it is below after all of it."""
        a0 = state.solved.load_factor
        for _ in range(CORRECTIONS):
            a1 = following.solved.load_factor
            if a1 >= -ZERO * abs(self.curve[0][1]) or a0 <= 0:
                break
            motion = motion * a0 / (a0 - a1)
            placement = state.moved.placement.moved(motion)
            back = self.solved(placement, state.carried(placement), self.wanted(), reach)
            if back is None:
                break
            following = back
        return following

    def _is_good(self, state: _State) -> bool:
        """Whether nothing happened in a step that a shorter one would see better."""
        return state.penetration <= DEEPEST * self._size and state.solved.missed <= CERTIFIED

    def _falls(self, state: _State) -> bool:
        """Whether the dead load drives the motion, and not the push."""
        return state.solved.falling > FALLING * abs(self.curve[0][1])

    def is_over(self, state: _State) -> bool:
        """Whether the load factor has come down to zero."""
        start, now = self.curve[0][1], state.solved.load_factor
        if now > ZERO * abs(start):
            return False
        self.zero = state.displacement
        if len(self.curve) > 1:
            (d0, a0), (d1, a1) = self.curve[-2:]
            self.zero = d1 + a1 * (d1 - d0) / (a0 - a1) if a0 != a1 else d1
        return True

    def lost(self, placement: Placement, state: _State | None = None) -> str:
        """Why nothing is in equilibrium at a placement, or what is found there no state to go on from."""
        at = f"at a displacement of {self._problem.control.displacement(placement):.6g} m"
        if state is None:
            return f"no forces carry the dead load {at}: blocks fall, and the method ends"
        speed = np.linalg.norm(state.twist[:, :3], axis=1)
        fastest = np.argsort(-speed, kind="stable")
        names = [self._problem.statics.model.blocks[i].name for i in fastest[speed[fastest] > FAST * speed.max()]]
        listed = ", ".join(names[:NAMED]) + (f" and {len(names) - NAMED} more" if len(names) > NAMED else "")
        if self._falls(state):
            return f"blocks fall under the dead load alone {at} ({listed}), and the method ends"
        return f"no motion that satisfies the flow rule is found {at} (blocks {listed}), and the method ends"

    def record(self, before: _State | None, state: _State) -> FiniteStep:
        """The state as it is kept."""
        solved, contacts = state.solved, state.moved.contacts
        missed = 0.0
        if before is not None:
            missed, work = self._energy(before, state)
            self._done += work
        self.curve.append((state.displacement, solved.load_factor))
        spent, self._time = perf_counter() - self._time, perf_counter()
        placement, c = state.moved.placement, solved.certificate
        return FiniteStep(
            load_factor=solved.load_factor,
            displacement=state.displacement,
            position=placement.position,
            rotation=placement.vectors,
            velocity=state.twist[:, :3],
            angular_velocity=state.twist[:, 3:],
            dissipation=solved.dissipation,
            penetration=state.penetration,
            energy_error=missed / max(self._done, 1e-300),
            equilibrium_residual=c.equilibrium_residual,
            yield_excess=c.yield_excess,
            interpenetration=c.interpenetration,
            flow_rule_gap=c.flow_rule_gap,
            holds=solved.holds,
            contact_points=len(contacts.gap),
            programs=solved.programs,
            solver_iterations=solved.iterations,
            solver_time=spent,
        )

    def _energy(self, before: _State, state: _State) -> tuple[float, float]:
        """Work between two states that is missed, and the sum of all of it, J, by the trapezoidal rule.

        Work of the dead and of the variable loads, on the way that blocks have really gone, is dissipated by friction.
        """
        places = before.moved.placement, state.moved.placement
        dead, variable = self._problem.dead.work(*places), self._problem.variable.work(*places)
        pushed = variable * (before.solved.load_factor + state.solved.load_factor) / 2
        rubbed = variable * (before.solved.dissipation + state.solved.dissipation) / 2
        return abs(dead + pushed - rubbed), abs(dead) + abs(pushed) + abs(rubbed)
