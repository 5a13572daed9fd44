"""Pushovers and settlements: the capacity curve after a collapse state."""

from collections.abc import Iterable
from dataclasses import replace
from time import perf_counter

import numpy as np

from blockstruct.analysis.events import Listener, StepDone, tell
from blockstruct.limit import Iteration, LimitProblem, Outcome
from blockstruct.model import has_curve
from blockstruct.motion import MotionState, MovingProblem, follow
from blockstruct.results import CaseResult, capacity_of, step_arrays, steps_of
from blockstruct.statics import Statics
from blockstruct.vocabulary import Reason, Status


def followed(
    result: CaseResult, statics: Statics, problem: LimitProblem, collapse: Iteration, listeners: Iterable[Listener]
) -> CaseResult:
    """Return the result of a case that goes on beyond collapse with its capacity curve.

    A curve that the result has already is continued. A KeyboardInterrupt ends it; the result is then interrupted.

    Parameters
    ----------
    result
        Converged result of a case with a curve.
    statics, problem
        Statics and limit problem of the result.
    collapse
        The collapse state.
    listeners
        Called with every state.
    """
    case, start = result.case, perf_counter()
    if not has_curve(case):
        return result
    states: list[MotionState] = [] if result.capacity is None else steps_of(result.capacity)
    going = follow(MovingProblem(statics, problem, case), collapse, result.settings, list(states))
    outcome, ended = result.outcome, None
    try:
        for k, state in enumerate(states):
            tell(listeners, StepDone(case, k, state))
        while True:
            state = next(going)
            states.append(state)
            tell(listeners, StepDone(case, len(states) - 1, state))
    except StopIteration as stop:
        ended = stop.value
    except KeyboardInterrupt:
        outcome = Outcome(Status.INTERRUPTED, np.nan, Reason.INTERRUPTED)
    return replace(
        result,
        outcome=outcome,
        capacity=capacity_of(statics.model, case, step_arrays(states)) if states else None,
        curve_outcome=ended,
        duration=result.duration + perf_counter() - start,
    )
