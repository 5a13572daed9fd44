"""Find the steps of a structure whose supports settle far."""

from copy import copy
from dataclasses import replace
from typing import Self

import numpy as np

from blockstruct.arrays import Array
from blockstruct.limit import Iteration
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.model import SettlementCase
from blockstruct.motion.moving_problem import COMPLIANCE, MovedProblem, MovingProblem
from blockstruct.motion.pushover import GROWTH, SHORTER, SHORTEST, PushoverPath
from blockstruct.motion.state import CurveOutcome, MotionState
from blockstruct.statics.moved import Placement
from blockstruct.vocabulary import CurveEnd


class SettlementPath(PushoverPath):
    """The curve of a settlement so far, and its next step."""

    # Supports stay until the structure has taken the dead load.
    held = 0.0

    def __init__(self, problem: MovingProblem, collapse: Iteration, settings: ProcedureSettings) -> None:
        super().__init__(problem, collapse, settings)
        # The reaction may be zero. Its unit is the dead load.
        self.scale = 1.0
        case = problem.case
        #: The state after the one that is next, once it is known.
        self._ahead: MotionState | None = None
        self._falls_at = np.nan
        self._goal = (isinstance(case, SettlementCase) and case.displacement) or np.inf
        self._unit = problem.settlement.reaction_unit

    def _reached(self) -> CurveEnd | None:
        curve = self._course.curve
        return (
            CurveEnd.DISPLACEMENT_REACHED if curve and curve[-1][0] >= self._goal - COMPLIANCE * self._length else None
        )

    def advance(self, way: float | None = None) -> MotionState | None:
        """Return the state after the last step.

        Its step is shortened if blocks would fall after it, until it is too short to matter.
        """
        if way is not None:
            return super().advance(way)
        state, gone = self._ahead or super().advance(), np.inf
        self._ahead = None
        while state is not None and not state.falls:
            self._ahead = self._after(state).follow()
            gone = min(gone, self._way(state))
            if (self._ahead is not None and not self._ahead.falls) or gone <= SHORTEST * self._goal / self._steps:
                break
            gone *= SHORTER
            state, self._ahead = super().advance(gone), None
        return state

    def follow(self) -> MotionState | None:
        """Return the state after the last step, whatever comes after it."""
        return super().advance()

    def _after(self, state: MotionState) -> Self:
        """Return the path with one more state."""
        other = copy(self)
        other._ways, other._course = list(self._ways), self._course.copied()
        other.take(state)
        return other

    def outcome(self, end: CurveEnd) -> CurveOutcome:
        """Facts of the end; the displacement is that at which blocks begin to fall."""
        found = super().outcome(end)
        return replace(found, displacement=self._falls_at) if end is CurveEnd.FALLS else found

    def take(self, state: MotionState) -> MotionState:
        """Add a state as the last one."""
        before = self._course.last
        if state.falls and (before is None or not before.falls):
            self._falls_at = state.displacement
        return super().take(state)

    def _next_way(self) -> float:
        last = self._course.last
        return min(self._goal / self._steps, self._longest if last is None else GROWTH * self._way(last))

    def _time(self, placement: Placement, twist: Array, way: float) -> float:
        # The last step but one ends at the displacement of the case.
        left = self._goal - self._problem.control.displacement(placement)
        time = super()._time(placement, twist, way)
        return min(time, left * self._unit) if left > COMPLIANCE * self._length else time

    def _until_zero(self, moved: MovedProblem, found: MotionState) -> float:
        return 1.0
