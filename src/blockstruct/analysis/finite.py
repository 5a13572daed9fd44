"""Pushovers: the capacity curve after a collapse state."""

from collections.abc import Iterable
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from blockstruct.analysis.events import Listener, StepDone, tell
from blockstruct.limit import FiniteStep, Iteration, LimitProblem, MovingProblem, Outcome, Placement, block_motion
from blockstruct.model import Pushover
from blockstruct.procedures import moves_furthest, pushover
from blockstruct.results import CaseResult, capacity_of, step_arrays, steps_of
from blockstruct.solvers import solver_of
from blockstruct.statics import Statics
from blockstruct.vocabulary import Reason, Status

Array = NDArray[np.float64]

#: Speed of the control point, relative to the fastest block of the mechanism, below which the point counts as at rest.
RESTS = 1e-4


def pushed_over(
    result: CaseResult, statics: Statics, problem: LimitProblem, collapse: Iteration, listeners: Iterable[Listener]
) -> CaseResult:
    """Return the result of a pushover with its capacity curve.

    A curve that the result already has is continued. A KeyboardInterrupt ends the curve; the result is then
    interrupted.

    Parameters
    ----------
    result
        Converged result of a :class:`~blockstruct.Pushover`.
    statics, problem
        Statics and limit problem of the result.
    collapse
        The collapse state.
    listeners
        Called with every state.
    """
    case, settings, start = result.case, result.settings, perf_counter()
    if not isinstance(case, Pushover):
        return result
    steps: list[FiniteStep] = [] if result.capacity is None else steps_of(result.capacity)
    moving = MovingProblem(statics, problem, case)
    if not steps and (resting := _resting(moving, case, block_motion(statics, problem, collapse.u[None])[0])):
        return replace(result, curve_ended=resting)
    going = pushover(moving, collapse, case.steps, settings, solver_of(settings), list(steps))
    outcome, ended = result.outcome, ""
    try:
        for k, step in enumerate(steps):
            tell(listeners, StepDone(case, k, step))
        while True:
            step = next(going)
            steps.append(step)
            tell(listeners, StepDone(case, len(steps) - 1, step))
    except StopIteration as stop:
        ended = stop.value
    except KeyboardInterrupt:
        outcome = Outcome(Status.INTERRUPTED, np.nan, Reason.INTERRUPTED)
    curve = capacity_of(statics.model, step_arrays(steps), ended) if steps else None
    return replace(
        result,
        outcome=outcome,
        capacity=curve,
        curve_ended=ended,
        duration=result.duration + perf_counter() - start,
    )


def _resting(problem: MovingProblem, case: Pushover, twist: Array) -> str:
    """Return why a control point at rest gives no curve."""
    model = problem.statics.model
    fastest = np.linalg.norm(twist[:, :3], axis=1).max()
    if abs(problem.control.velocity(Placement.of(model), twist)) > RESTS * fastest:
        return ""
    block, direction = case.control
    along = ", ".join(f"{value:.3g}" for value in np.round(direction, 4) + 0.0)
    return (
        f"the control point at block {block!r} does not move along ({along}) in the collapse mechanism, and there is "
        f"no curve over its displacement; {moves_furthest([b.name for b in model.blocks], twist)}"
    )
