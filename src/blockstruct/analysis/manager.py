"""The analysis manager."""

import reprlib
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Self

import numpy as np

from blockstruct.analysis.events import CaseFinished, CaseStarted, Event, IterationDone, Listener
from blockstruct.analysis.provenance import now, solver_options, versions
from blockstruct.analysis.recorder import Recorder
from blockstruct.analysis.replay import ReplaySolver, followed
from blockstruct.errors import ModelError
from blockstruct.limit import Iteration, LimitProblem, Outcome, ProcedureSettings, solve_limit_case
from blockstruct.model import LimitCase, Model, checked_tuple
from blockstruct.results import Analysis, CaseResult, history_of
from blockstruct.solvers import solver_of
from blockstruct.statics import Statics
from blockstruct.storage import WorkingData, claim, is_unfinished, open_analysis, patterns
from blockstruct.vocabulary import Status


class AnalysisManager:
    """Runs limit cases of one model, whose statics are assembled once.

    Parameters
    ----------
    model
        The structure.
    store
        Path of the file to write; None keeps the analysis in memory. It is checked at once and put in place when the
        last case has ended, or the run was interrupted; until then the run is kept beside it, in ``NAME.partial``.
    settings
        Schedule and tolerances of the procedure.
    listeners
        Called with every :class:`~blockstruct.analysis.Event`, in order.
    tags
        Words to find the analysis by: :meth:`blockstruct.Archive.select`.
    document_hash
        Of the document that describes the model: :attr:`blockstruct.Document.hash`.

    Raises
    ------
    StorageError
        A store that cannot be written.
    SolverError
        Settings that name no installed solver.
    GeometryError
        An interface that crushes but cannot be divided into cells.
    """

    def __init__(
        self,
        model: Model,
        store: str | Path | None = None,
        *,
        settings: ProcedureSettings | None = None,
        listeners: Iterable[Listener] = (),
        tags: Iterable[str] = (),
        document_hash: str = "",
    ) -> None:
        if not isinstance(model, Model):
            msg = f"AnalysisManager: model is {reprlib.repr(model)}; give a Model"
            raise ModelError(msg)
        if not isinstance(settings, ProcedureSettings | None):
            msg = f"AnalysisManager: settings are {reprlib.repr(settings)}; give ProcedureSettings(…)"
            raise ModelError(msg)
        self.model = model
        self.settings = settings or ProcedureSettings()
        self.listeners = tuple(listeners)
        self.tags = checked_tuple(tags, str, "AnalysisManager: tags")
        self.document_hash = document_hash
        self.statics = Statics.of(model, self.settings.crushing_cells)
        solver_of(self.settings)
        self.store = None if store is None else claim(store)

    def run(self, cases: Iterable[LimitCase]) -> Analysis:
        """Run cases, one after the other.

        A KeyboardInterrupt ends the run; the case at work gets the status ``interrupted`` and keeps the
        iterations it has, as do the cases after it, without any; the cases before it are complete.

        With a store every iteration is committed as it is solved: after the process was killed, :meth:`resume` and
        :func:`blockstruct.recover` find all but the one in flight.

        Raises
        ------
        ModelError
            No case, two cases of one name, a variable load that is zero, loads that the model cannot take:
            before anything is solved.
        StorageError
            A store that another run writes to, or that holds the iterations of a killed one: before anything is
            solved. A disk that is full: what is committed is kept.
        """
        cases = checked_tuple(cases, LimitCase, "AnalysisManager.run: cases")
        started_at = now()
        planned = {
            case.name: _planned(case, self.settings, self.statics, problem, started_at)
            for case, problem in zip(cases, self.check(cases), strict=True)
        }
        analysis = Analysis(
            self.model,
            planned,
            started_at,
            versions(),
            solver_options=solver_options([self.settings]),
            document_hash=self.document_hash,
            tags=self.tags,
        )
        if self.store is None:
            return self._conduct(analysis, self.listeners)
        with WorkingData.begin(self.store, analysis) as working:
            return self._record(analysis, working)

    @classmethod
    def resume(cls, path: str | Path, *, listeners: Iterable[Listener] = ()) -> Analysis:
        """Go on with a run that was killed or interrupted, from its last committed iteration.

        Cases that have ended are kept. The programs that are already solved are not solved again, except for the
        one under dead load; the case ends where it would have ended without the interruption, to the tolerance of
        its certificate. A finished analysis is given back as it is.

        Parameters
        ----------
        path
            The store of the run.
        listeners
            As of the manager; they hear of the iterations that are replayed, too.

        Raises
        ------
        StorageError
            Nothing to resume, or a run that is still under way.
        FormatError
            A damaged file, or one whose iterations are not those of this version of blockstruct.
        """
        if is_unfinished(path):
            with WorkingData.reopen(path) as working:
                analysis = working.analysis()
                return cls._resuming(analysis, path, listeners)._record(analysis, working)
        analysis = open_analysis(path)
        if analysis.status == "finished":
            return analysis
        manager = cls._resuming(analysis, path, listeners)
        with WorkingData.begin(Path(path), analysis) as working:
            return manager._record(analysis, working)

    @classmethod
    def again(cls, analysis: Analysis, *, listeners: Iterable[Listener] = ()) -> Analysis:
        """Run the model and the cases of an analysis anew, each with its own settings, in memory."""
        manager = cls._resuming(analysis, None, listeners)
        planned, started_at = {}, now()
        for name, result in analysis.items():
            statics = manager._statics_of(result.settings)
            problem = LimitProblem.of(statics, result.case)
            planned[name] = _planned(result.case, result.settings, statics, problem, started_at)
        return manager._conduct(analysis.replaced(results=planned, created_at=started_at), manager.listeners)

    def check(self, cases: Sequence[LimitCase]) -> list[LimitProblem]:
        """Check cases as :meth:`run` does before it solves anything, and give their limit problems."""
        names = [case.name for case in cases]
        if not names:
            msg = "AnalysisManager.run: no case; give at least one LimitCase"
            raise ModelError(msg)
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            msg = f"AnalysisManager.run: case names used more than once: {', '.join(twice)}; rename them"
            raise ModelError(msg)
        patterns(cases)
        return [LimitProblem.of(self.statics, case) for case in cases]

    @classmethod
    def _resuming(cls, analysis: Analysis, path: str | Path | None, listeners: Iterable[Listener]) -> Self:
        settings = next((result.settings for result in analysis.values()), None)
        return cls(analysis.model, path, settings=settings, listeners=listeners)

    def _record(self, analysis: Analysis, working: WorkingData) -> Analysis:
        done = self._conduct(analysis, (Recorder(working), *self.listeners))
        working.finish(done)
        return done

    def _conduct(self, analysis: Analysis, listeners: Sequence[Listener]) -> Analysis:
        """Run what an analysis has left to run: its interrupted cases."""
        results = dict(analysis)
        of_numbers = analysis.versions
        for name, before in analysis.items():
            if before.status is not Status.INTERRUPTED:
                continue
            of_numbers = versions()
            try:
                statics = self._statics_of(before.settings)
                problem = LimitProblem.of(statics, before.case)
                results[name] = result = self._run_case(before, statics, problem, listeners)
                _tell(listeners, CaseFinished(result))
            except KeyboardInterrupt:
                break
            if result.status is Status.INTERRUPTED:
                break
        return analysis.replaced(results=results, versions=of_numbers)

    def _run_case(
        self, before: CaseResult, statics: Statics, problem: LimitProblem, listeners: Sequence[Listener]
    ) -> CaseResult:
        case, settings, start = before.case, before.settings, perf_counter()
        solver = ReplaySolver(statics, problem, before.history, solver_of(settings))
        steps = followed(solve_limit_case(problem, case.flow, settings, solver), before.history)
        iterations: list[Iteration] = []
        outcome = Outcome(Status.INTERRUPTED, np.nan, "interrupted by the user")
        started_at = before.started_at if before.n_iterations else now()
        try:
            _tell(listeners, CaseStarted(case, len(self.model.blocks), problem.n_points, statics, problem))
            while True:
                iterations.append(next(steps))
                _tell(listeners, IterationDone(case, len(iterations) - 1, iterations[-1]))
        except StopIteration as stop:
            outcome = stop.value
        except KeyboardInterrupt:
            if len(iterations) < before.n_iterations:
                return before
        return replace(
            before,
            status=outcome.status,
            load_factor=outcome.load_factor,
            certificate=iterations[-1].certificate if iterations and outcome.status is not Status.UNBOUNDED else None,
            message=outcome.message,
            history=history_of(statics, problem, iterations),
            started_at=started_at,
            duration=before.duration + perf_counter() - start,
        )

    def _statics_of(self, settings: ProcedureSettings) -> Statics:
        if settings.crushing_cells == self.settings.crushing_cells:
            return self.statics
        return Statics.of(self.model, settings.crushing_cells)


def _planned(
    case: LimitCase, settings: ProcedureSettings, statics: Statics, problem: LimitProblem, started_at: str
) -> CaseResult:
    """Result of a case that is still to be run."""
    return CaseResult(
        case=case,
        settings=settings,
        status=Status.INTERRUPTED,
        load_factor=np.nan,
        certificate=None,
        message="interrupted before its first program was solved",
        history=history_of(statics, problem, []),
        started_at=started_at,
        duration=0.0,
    )


def _tell(listeners: Sequence[Listener], event: Event) -> None:
    for listener in listeners:
        listener(event)
