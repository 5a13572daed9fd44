"""Commits a run while it goes on."""

from collections.abc import Callable

import xarray as xr

from blockstruct.analysis.events import CaseFinished, CaseStarted, Event, IterationDone
from blockstruct.limit import Iteration
from blockstruct.results import history_of
from blockstruct.storage import Checkpoint
from blockstruct.vocabulary import Status


class Recorder:
    """Listener that commits every iteration as it is solved, and every case as it ends.

    Parameters
    ----------
    working
        Where.
    """

    def __init__(self, working: Checkpoint) -> None:
        self._working = working
        self._history: Callable[[Iteration], xr.Dataset]

    def __call__(self, event: Event) -> None:
        """Commit what an event tells."""
        match event:
            case CaseStarted(case, statics=statics, problem=problem):
                self._working.start(case.name, history_of(statics, problem, []))
                self._history = lambda iteration: history_of(statics, problem, [iteration])
            case IterationDone(case, index, iteration):
                holds = ("iteration", [iteration.certificate.holds])
                self._working.commit(case.name, index, self._history(iteration).assign(holds=holds))
            case CaseFinished(result) if result.status is not Status.INTERRUPTED:
                self._working.end(result)
