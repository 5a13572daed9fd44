"""Blocks that move: a limit problem wherever they are, one step after the other, and the curve that they give.

Each step is one of :func:`blockstruct.solvers.step.solve_step` on the moved geometry. What drives it is the caller's:
a :func:`pushover` prescribes the work of the variable load.
"""

from blockstruct.motion.course import CERTIFIED, Course, recomputed
from blockstruct.motion.moving_problem import ControlPoint, MovedProblem, MovingProblem, check_pushover
from blockstruct.motion.pushover import pushover
from blockstruct.motion.state import CurveOutcome, MotionState, zero_displacement

__all__ = [
    "CERTIFIED",
    "ControlPoint",
    "Course",
    "CurveOutcome",
    "MotionState",
    "MovedProblem",
    "MovingProblem",
    "check_pushover",
    "pushover",
    "recomputed",
    "zero_displacement",
]
