"""Choose the length of the steps of a pushover."""

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import Placement
from blockstruct.limit.moved import MovingProblem
from blockstruct.procedures.pushover_state import State

Array = NDArray[np.float64]

#: First step, as a share of an even one, which divides an eighth of the structure's extent evenly. At most structures
#: the control point moves further before the load factor is zero.
FIRST = 0.25
#: Largest growth of a step over the last. Least step, as a share of an even division of the curve. Largest step, in
#: multiples of the way so far divided by the number of steps, so that endless sliding advances quickly.
GROWTH, LEAST, LARGEST = 1.5, 1 / 64, 2.0
#: Largest ratio of push to dead load that lengthens steps. A structure that carries more does not move further.
HEAVIEST = 1.0
#: Number of last states from which a straight line predicts the end of the curve and sets the step.
FORESEEN = 8
#: Largest way of a block, in multiples of the wanted way of the control point.
FASTEST = 3.0


class Pace:
    """Choose the length of the next step from the curve so far.

    Parameters
    ----------
    problem
        The case.
    steps
        Approximate number of steps.
    load_factor
        Load factor at collapse.
    """

    def __init__(self, problem: MovingProblem, steps: int, load_factor: float) -> None:
        self._problem, self._steps = problem, steps
        # The ratio does not depend on the unit of the variable load.
        push, dead = (
            float(np.linalg.norm(loads.wrench[problem.statics.free, :3], axis=1).sum())
            for loads in (problem.variable, problem.dead)
        )
        self._share = min(load_factor * push / dead, HEAVIEST) if dead else HEAVIEST
        free = np.concatenate([b.shape.vertices for b in problem.statics.model.blocks if not b.fixed])
        #: Length of a step that divides an eighth of the structure's extent evenly, m.
        self.even = float(np.linalg.norm(free - free.mean(axis=0), axis=1).max()) / (4 * steps)
        #: Displacement, m, and load factor of each state.
        self.curve: list[tuple[float, float]] = []
        self._way = [0.0]
        self._last: State | None = None
        #: Time of the longest motion, s.
        self.longest = 0.0

    def taken(self, state: State) -> None:
        """Record a state as the last one."""
        if self._last is not None:
            self._way.append(self._way[-1] + _way(self._last, state.placement, state.displacement))
        self._last = state
        self.longest = max(self.longest, state.time)
        self.curve.append((state.displacement, state.load_factor))

    def way(self, placement: Placement) -> float:
        """Return the length of the next step from a placement, m.

        The length is the way of the control point, or a share of the fastest block's way.
        """
        if self._last is None or len(self.curve) < 2:
            return FIRST * self.even
        way, a = np.array(self._way[-FORESEEN:]), np.array(self.curve[-FORESEEN:])[:, 1]
        slope = float(np.polyfit(way, a, 1)[0])
        whole = way[-1] - a[-1] / slope if slope < 0 else np.inf
        large = max(self.even * max(1.0, 8 * self._share), LARGEST * way[-1] / self._steps)
        even = min(whole / self._steps, large)
        # A short step that ends at an event must not limit the next one.
        gone = _way(self._last, placement, self._problem.control.displacement(placement))
        last = max(gone, way[-1] - way[-2])
        return float(np.clip(even, max(LEAST * even, last / 2), max(GROWTH * last, LEAST * even)))

    def time(self, placement: Placement, twist: Array) -> float:
        """Return the time of the next step at 1 W, s.

        The motion has twists (B, 6).
        """
        speed = abs(self._problem.control.velocity(placement, twist))
        fastest = float(np.linalg.norm(twist[:, :3], axis=1).max())
        return self.way(placement) / max(speed, fastest / FASTEST, 1e-300)


def _way(before: State, placement: Placement, displacement: float) -> float:
    """Return the way of the control point from a state, m.

    Return a share of the furthest block's way if it is larger.
    """
    furthest = float(np.linalg.norm(placement.position - before.placement.position, axis=1).max())
    return max(abs(displacement - before.displacement), furthest / FASTEST)
