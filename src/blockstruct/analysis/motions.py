"""Motions: the capacity curve of a pushover or a settlement after collapse, and the response to a record."""

from collections.abc import Iterable
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from blockstruct.analysis.events import Listener, StateDone, StepDone, tell
from blockstruct.limit import Iteration, LimitProblem, Outcome, RecordState
from blockstruct.model import RecordCase, has_curve
from blockstruct.motion import MotionState, MovingProblem, follow, respond
from blockstruct.results import (
    CaseResult,
    arrays_of_response,
    beginning_of,
    capacity_of,
    response_of,
    state_arrays,
    steps_of,
)
from blockstruct.statics import Statics
from blockstruct.vocabulary import Reason, Status


def followed(
    result: CaseResult, statics: Statics, problem: LimitProblem, collapse: Iteration, listeners: Iterable[Listener]
) -> CaseResult:
    """Return the result of a case that continues beyond collapse, with its capacity curve.

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
        capacity=capacity_of(statics.model, case, state_arrays(states)) if states else None,
        curve_outcome=ended,
        duration=result.duration + perf_counter() - start,
    )


_STATUS = {
    Reason.AT_REST: Status.STANDS,
    Reason.BLOCKS_FALLEN: Status.COLLAPSES,
    Reason.STILL_MOVING: Status.UNDECIDED,
    Reason.STEP_NOT_SOLVED: Status.UNDECIDED,
}


def responded(result: CaseResult, statics: Statics, case: RecordCase, listeners: Iterable[Listener]) -> CaseResult:
    """Return the result of a record with its response.

    A response that the result already has is continued. A KeyboardInterrupt ends it; the result is then interrupted.
    """
    start, last, count = perf_counter(), None, 0
    pieces: list[Any] = []
    if result.response is not None:
        k, last = beginning_of(result.response)
        count = k + 1
        is_kept = result.response["state_of_contact"] <= k
        pieces.append(arrays_of_response(result.response.isel(time=slice(count), contact=is_kept.to_numpy())))
    going = respond(statics, case, last)
    outcome = Outcome(Status.INTERRUPTED, np.nan, Reason.INTERRUPTED)
    states: list[RecordState] = []
    try:
        while True:
            last = next(going)
            states.append(last)
            tell(listeners, StateDone(case, count, last))
            count += 1
    except StopIteration as stop:
        reason: Reason = stop.value
        time = last.time if last is not None and reason is Reason.BLOCKS_FALLEN else np.nan
        outcome = Outcome(_STATUS[reason], np.nan, reason, collapse_time=time)
    except KeyboardInterrupt:
        pass
    pieces += [state_arrays(states)] if states else []
    response = None
    if pieces:
        response = response_of(statics.model, {name: np.concatenate([p[name] for p in pieces]) for name in pieces[0]})
    return replace(result, outcome=outcome, response=response, duration=result.duration + perf_counter() - start)
