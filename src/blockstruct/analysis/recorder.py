"""Commit a run while it is under way."""

from collections.abc import Callable
from typing import Any

import numpy as np

from blockstruct.analysis.events import CaseFinished, CaseStarted, Event, IterationDone, StateDone, StepDone
from blockstruct.analysis.provenance import versions
from blockstruct.limit import Iteration
from blockstruct.results import iteration_variables, response_arrays, step_arrays
from blockstruct.storage import Checkpoint
from blockstruct.vocabulary import Status


class Recorder:
    """Listener that commits every iteration, step of a pushover, state of a response and case.

    Parameters
    ----------
    working
        Working data to commit to.
    """

    def __init__(self, working: Checkpoint) -> None:
        self._working = working
        self._variables: Callable[[Iteration], dict[str, Any]]

    def __call__(self, event: Event) -> None:
        """Commit the content of an event."""
        match event:
            case CaseStarted(case, statics=statics, problem=problem):
                self._working.start(case.name, versions())
                self._variables = lambda iteration: iteration_variables(statics, problem, [iteration])
            case IterationDone(case, index, iteration):
                arrays = {name: values for name, (_, values, _) in self._variables(iteration).items()}
                self._working.commit(case.name, index, arrays | {"holds": np.array([iteration.certificate.holds])})
            case StepDone(case, index, step):
                self._working.commit_step(case.name, index, step_arrays([step]))
            case StateDone(case, index, state):
                self._working.commit_step(case.name, index, response_arrays([state]))
            case CaseFinished(result) if result.status is not Status.INTERRUPTED:
                self._working.end(result)
