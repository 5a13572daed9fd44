"""How far the steps of a pushover go."""

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import Placement
from blockstruct.limit.moved import MovingProblem
from blockstruct.procedures.pushover_state import State

Array = NDArray[np.float64]

#: First step, as a share of one that divides an eighth of the structure's extent evenly; the control point of most
#: structures goes further before the load factor is zero.
FIRST = 0.25
#: Growth of a step over the last, its least share of one that divides the curve evenly, and its largest share of the
#: way so far, in multiples of an even one, so that what slides without end comes far.
GROWTH, LEAST, LARGEST = 1.5, 1 / 64, 2.0
#: Ratio of what the push and the dead load weigh, up to which steps are the longer for it: what carries more moves no
#: further.
HEAVIEST = 1.0
#: States from which the end of the curve is foreseen, along a straight line, and how long a step is.
FORESEEN = 8
#: Most that a block may move, in multiples of what the control point is meant to.
FASTEST = 3.0


class Pace:
    """The states of a curve so far, and the way of the next step.

    Parameters
    ----------
    problem
        The case.
    steps
        Number of them, about.
    load_factor
        At collapse.
    """

    def __init__(self, problem: MovingProblem, steps: int, load_factor: float) -> None:
        self._problem, self._steps = problem, steps
        # Whatever unit the variable load is given in.
        push, dead = (
            float(np.linalg.norm(loads.wrench[problem.statics.free, :3], axis=1).sum())
            for loads in (problem.variable, problem.dead)
        )
        self._share = min(load_factor * push / dead, HEAVIEST) if dead else HEAVIEST
        free = np.concatenate([b.shape.vertices for b in problem.statics.model.blocks if not b.fixed])
        #: Way of a step that divides an eighth of the structure's extent evenly, m.
        self.even = float(np.linalg.norm(free - free.mean(axis=0), axis=1).max()) / (4 * steps)
        #: Displacement, m, and load factor of each state.
        self.curve: list[tuple[float, float]] = []
        self._way = [0.0]
        self._last: State | None = None
        #: Time of the longest motion, s.
        self.longest = 0.0

    def taken(self, state: State) -> None:
        """A state is the last one."""
        if self._last is not None:
            self._way.append(self._way[-1] + _way(self._last, state.placement, state.displacement))
        self._last = state
        self.longest = max(self.longest, state.time)
        self.curve.append((state.displacement, state.load_factor))

    def way(self, placement: Placement) -> float:
        """Of the next step from a placement, m: of the control point, or a share of that of the fastest block."""
        if self._last is None or len(self.curve) < 2:
            return FIRST * self.even
        way, a = np.array(self._way[-FORESEEN:]), np.array(self.curve[-FORESEEN:])[:, 1]
        slope = float(np.polyfit(way, a, 1)[0])
        whole = way[-1] - a[-1] / slope if slope < 0 else np.inf
        large = max(self.even * max(1.0, 8 * self._share), LARGEST * way[-1] / self._steps)
        even = min(whole / self._steps, large)
        # A short step that ends where something happens tells nothing of the next.
        gone = _way(self._last, placement, self._problem.control.displacement(placement))
        last = max(gone, way[-1] - way[-2])
        return float(np.clip(even, max(LEAST * even, last / 2), max(GROWTH * last, LEAST * even)))

    def time(self, placement: Placement, twist: Array) -> float:
        """Time at 1 W that a motion, twists (B, 6), takes for it, s."""
        speed = abs(self._problem.control.velocity(placement, twist))
        fastest = float(np.linalg.norm(twist[:, :3], axis=1).max())
        return self.way(placement) / max(speed, fastest / FASTEST, 1e-300)


def _way(before: State, placement: Placement, displacement: float) -> float:
    """Way of the control point from a state, or a share of that of the block that goes furthest."""
    furthest = float(np.linalg.norm(placement.position - before.placement.position, axis=1).max())
    return max(abs(displacement - before.displacement), furthest / FASTEST)
