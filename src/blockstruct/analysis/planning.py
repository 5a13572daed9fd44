"""The runs of cases, and their results before the run."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from blockstruct.limit import LimitProblem, Outcome, ProcedureSettings, scheduled
from blockstruct.model import Case, Model, RecordCase
from blockstruct.results import CaseResult, history_of, run_name
from blockstruct.statics import Division, Statics
from blockstruct.vocabulary import Flow, Reason, Status


@dataclass(frozen=True, slots=True)
class Run:
    """A case to run, with its settings.

    Attributes
    ----------
    case : Case
    settings : ProcedureSettings
    schedule, of_case : str
        The schedule of a run of a spread, and the case that it varies; empty for the original case.
    """

    case: Case
    settings: ProcedureSettings
    schedule: str = ""
    of_case: str = ""


def runs_of(cases: Sequence[Case], settings: ProcedureSettings, schedules: Sequence[str]) -> list[Run]:
    """Return the runs of cases: original, by schedule, and associative."""
    runs = []
    for case in cases:
        runs.append(Run(case, settings))
        if not schedules or case.flow is Flow.ASSOCIATIVE or isinstance(case, RecordCase):
            continue
        for name in schedules:
            other = scheduled(settings, name)
            # The given settings need no second run.
            if other != settings:
                runs.append(Run(case.renamed(run_name(case.name, name)), other, name, case.name))
        bound = str(Flow.ASSOCIATIVE)
        runs.append(Run(case.renamed(run_name(case.name, bound), Flow.ASSOCIATIVE), settings, bound, case.name))
    return runs


def blank_history(model: Model, result: CaseResult) -> xr.Dataset:
    """Return the history of a case that has not begun."""
    statics = Statics.of(model, Division(result.settings.crushing_cells))
    return history_of(statics, LimitProblem.of(statics, result.case), [])


def planned_result(run: Run, statics: Statics, problem: LimitProblem, started_at: str) -> CaseResult:
    """Return the result of a case that is still to be run."""
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
