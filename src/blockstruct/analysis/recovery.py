"""Keeping what a killed run has found."""

from pathlib import Path

import numpy as np
import xarray as xr

from blockstruct.analysis.sweeps import Run
from blockstruct.limit import LimitProblem, Outcome
from blockstruct.model import Model
from blockstruct.results import Analysis, CaseResult, history_of
from blockstruct.statics import Division, Statics
from blockstruct.storage import Checkpoint
from blockstruct.vocabulary import Reason, Status


def recover(path: str | Path) -> Analysis:
    """Make the analysis file of a run that was killed, with every iteration that it committed.

    Cases that had not ended get the status ``interrupted``. :meth:`blockstruct.AnalysisManager.resume` goes on with
    either, the killed run or the recovered file.

    Parameters
    ----------
    path
        The file that the run would have written. What stood there when the run began is replaced, as the run would
        have done, and nothing else.

    Raises
    ------
    StorageError
        If there is no killed run, it is still under way, or the path cannot be written.
    FormatError
        If the working data are damaged at their root.
    """
    with Checkpoint.reopen(path, blank_history) as working:
        analysis = working.analysis()
        working.finish(analysis)
    return analysis


def blank_history(model: Model, result: CaseResult) -> xr.Dataset:
    """History of a case that has not begun."""
    statics = Statics.of(model, Division(result.settings.crushing_cells))
    return history_of(statics, LimitProblem.of(statics, result.case), [])


def planned_result(run: Run, statics: Statics, problem: LimitProblem, started_at: str) -> CaseResult:
    """Result of a case that is still to be run."""
    return CaseResult(
        model=statics.model,
        case=run.case,
        settings=run.settings,
        outcome=Outcome(Status.INTERRUPTED, np.nan, Reason.NOT_BEGUN),
        certificate=None,
        schedule=run.schedule,
        of_case=run.of_case,
        history=history_of(statics, problem, []),
        started_at=started_at,
        duration=0.0,
    )
