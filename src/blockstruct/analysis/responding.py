"""Records: the response of a structure that stands under its dead load."""

from collections.abc import Iterable
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from blockstruct.analysis.events import Listener, StateDone, tell
from blockstruct.limit import Outcome, RecordState
from blockstruct.model import RecordCase
from blockstruct.motion import respond
from blockstruct.results import CaseResult, arrays_of_response, beginning_of, response_arrays, response_of
from blockstruct.statics import Statics
from blockstruct.vocabulary import Reason, Status

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
        own = result.response["state_of_contact"] <= k
        pieces.append(arrays_of_response(result.response.isel(time=slice(count), contact=own.to_numpy())))
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
    pieces += [response_arrays(states)] if states else []
    response = None
    if pieces:
        response = response_of(statics.model, {name: np.concatenate([p[name] for p in pieces]) for name in pieces[0]})
    return replace(result, outcome=outcome, response=response, duration=result.duration + perf_counter() - start)
