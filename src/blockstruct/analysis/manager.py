"""The analysis manager."""

import platform
import reprlib
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from time import perf_counter

import numpy as np

from blockstruct.analysis.events import CaseFinished, CaseStarted, IterationDone, Listener
from blockstruct.errors import ModelError
from blockstruct.limit import Iteration, LimitProblem, Outcome, ProcedureSettings, solve_limit_case
from blockstruct.model import LimitCase, Model, checked_tuple
from blockstruct.results import Analysis, CaseResult, history_of
from blockstruct.solvers import solver_of
from blockstruct.statics import Statics
from blockstruct.storage import claim, patterns, save_analysis
from blockstruct.vocabulary import Status

_PACKAGES = (
    "blockstruct",
    "clarabel",
    "cvxpy",
    "h5netcdf",
    "h5py",
    "numpy",
    "pint",
    "scipy",
    "shapely",
    "xarray",
)


class AnalysisManager:
    """Runs limit cases of one model, whose statics are assembled once.

    Parameters
    ----------
    model
        The structure.
    store
        Path of the file to write; None keeps the analysis in memory. It is checked at once and written when the
        last case has ended, or the run was interrupted.
    settings
        Schedule and tolerances of the procedure.
    listeners
        Called with every :class:`~blockstruct.analysis.Event`, in order.

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
        self.statics = Statics.of(model, self.settings.crushing_cells)
        solver_of(self.settings)
        self.store = None if store is None else claim(store)

    def run(self, cases: Iterable[LimitCase]) -> Analysis:
        """Run cases, one after the other.

        A KeyboardInterrupt ends the run; the case at work gets the status ``interrupted`` and keeps the
        iterations it has, the cases before it are complete, the cases after it are missing.

        Raises
        ------
        ModelError
            No case, two cases of one name, a variable load that is zero, loads that the model cannot take:
            before anything is solved.
        """
        cases = checked_tuple(cases, LimitCase, "AnalysisManager.run: cases")
        problems = self.check(cases)
        created_at = _now()
        results: dict[str, CaseResult] = {}
        for case, problem in zip(cases, problems, strict=True):
            results[case.name] = result = self._run_case(case, problem)
            try:
                self._tell(CaseFinished(result))
            except KeyboardInterrupt:
                break
            if result.status is Status.INTERRUPTED:
                break
        analysis = Analysis(self.model, results, created_at, _versions())
        if self.store is not None:
            save_analysis(analysis, self.store)
        return analysis

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

    def _run_case(self, case: LimitCase, problem: LimitProblem) -> CaseResult:
        started_at, start = _now(), perf_counter()
        steps = solve_limit_case(problem, case.flow, self.settings, solver_of(self.settings))
        iterations: list[Iteration] = []
        outcome = Outcome(Status.INTERRUPTED, np.nan, "interrupted by the user")
        try:
            self._tell(CaseStarted(case, len(self.model.blocks), problem.n_points))
            while True:
                iterations.append(next(steps))
                self._tell(IterationDone(case, len(iterations) - 1, iterations[-1]))
        except StopIteration as stop:
            outcome = stop.value
        except KeyboardInterrupt:
            pass
        return CaseResult(
            case=case,
            settings=self.settings,
            status=outcome.status,
            load_factor=outcome.load_factor,
            certificate=iterations[-1].certificate if iterations and outcome.status is not Status.UNBOUNDED else None,
            message=outcome.message,
            history=history_of(self.statics, problem, iterations),
            started_at=started_at,
            duration=perf_counter() - start,
        )

    def _tell(self, event: CaseStarted | IterationDone | CaseFinished) -> None:
        for listener in self.listeners:
            listener(event)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _versions() -> dict[str, str]:
    found = {package: version(package) for package in _PACKAGES}
    return {**found, "python": platform.python_version(), "platform": platform.platform()}
