"""The analysis manager."""

import platform
import reprlib
from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.analysis.events import CaseFinished, CaseStarted, IterationDone, Listener
from blockstruct.errors import ModelError
from blockstruct.limit import (
    SCHEDULES,
    Iteration,
    LimitProblem,
    Outcome,
    ProcedureSettings,
    schedules_of,
    solve_limit_case,
)
from blockstruct.model import LimitCase, Model, checked_tuple
from blockstruct.results import Analysis, CaseResult, contact_state, history_of, run_name, sweep_of
from blockstruct.solvers import solver_of
from blockstruct.statics import Statics
from blockstruct.storage import claim, patterns, save_analysis
from blockstruct.vocabulary import ContactState, Flow, Status

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

#: Properties of joints that a sweep varies, with their dimensions.
SWEPT = {
    "compressive_strength": "stress",
    "friction_coefficient": "dimensionless",
    "cohesion": "stress",
    "tensile_strength": "stress",
    "dilatancy_angle": "angle",
}


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

    def run(self, cases: Iterable[LimitCase], *, spread: bool | str | Iterable[str] = False) -> Analysis:
        """Run cases, one after the other.

        Parameters
        ----------
        cases
            The cases.
        spread
            True also runs every non-associative case with each of the named :data:`~blockstruct.SCHEDULES` and with
            associative flow, as ``"case [schedule]"`` and ``"case [associative]"``; names run only those schedules.
            :meth:`Analysis.spread` then tells the lowest and the highest certified load factor.

        A KeyboardInterrupt ends the run; the case at work gets the status ``interrupted`` and keeps the
        iterations it has, the cases before it are complete, the cases after it are missing.

        Raises
        ------
        ModelError
            No case, two cases of one name, a variable load that is zero, loads that the model cannot take, an unknown
            schedule: before anything is solved.
        """
        runs = self._runs(checked_tuple(cases, LimitCase, "AnalysisManager.run: cases"), schedules_of(spread))
        problems = self.check([case for case, _ in runs])
        created_at = _now()
        results: dict[str, CaseResult] = {}
        for (case, settings), problem in zip(runs, problems, strict=True):
            results[case.name] = result = self._run_case(case, settings, self.statics, problem)
            try:
                self._tell(CaseFinished(result))
            except KeyboardInterrupt:
                break
            if result.status is Status.INTERRUPTED:
                break
        analysis = Analysis(self.model, results, created_at, _versions(), self.sweep)
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

    def sweep(self, quantity: str, values: Any, case: LimitCase) -> xr.Dataset:
        """Load factor of a case for several values of a joint property, on the statics assembled once.

        Parameters
        ----------
        quantity
            ``"compressive_strength"``, ``"friction_coefficient"``, ``"cohesion"``, ``"tensile_strength"`` or
            ``"dilatancy_angle"``: every joint of the model takes the value.
        values
            An array quantity, or one quantity a value; None is an infinite compressive strength.
        case
            The case.

        Returns
        -------
        xarray.Dataset
            ``load_factor``, ``status``, ``flow_rule_gap`` and ``n_iterations`` along the quantity, in SI units.

        Raises
        ------
        ModelError
            A quantity that joints do not have, no value, or one that a joint cannot take.
        """
        joints = [i.joint_material for i in self.model.interfaces]
        values = list(values)
        if quantity not in SWEPT:
            msg = f"sweep: joints have no {quantity!r}; give one of {', '.join(SWEPT)}"
            raise ModelError(msg)
        if not values:
            msg = f"sweep of {quantity}: no value; give at least one"
            raise ModelError(msg)
        varied = [[joint.varied(**{quantity: value}) for joint in joints] for value in values]
        results, statics = [], self.statics
        for one in varied:
            statics = statics.varied(one, self.settings.crushing_cells)
            problem = LimitProblem.of(statics, case)
            results.append(self._run_case(case, self.settings, statics, problem))
            if results[-1].status is Status.INTERRUPTED:
                break
        found = [float(getattr(one[0], quantity)) for one in varied[: len(results)]]
        return sweep_of(quantity, SWEPT[quantity], found, results)

    def _runs(self, cases: Sequence[LimitCase], schedules: Sequence[str]) -> list[tuple[LimitCase, ProcedureSettings]]:
        """Cases with their settings: those of the manager, and the schedules of a spread."""
        runs = []
        for case in cases:
            runs.append((case, self.settings))
            if schedules and case.flow is Flow.NONASSOCIATIVE:
                for name in schedules:
                    run = replace(case, name=run_name(case.name, name))
                    runs.append((run, replace(self.settings, **SCHEDULES[name])))
                bound = replace(case, name=run_name(case.name, Flow.ASSOCIATIVE), flow=Flow.ASSOCIATIVE)
                runs.append((bound, self.settings))
        return runs

    def _run_case(
        self, case: LimitCase, settings: ProcedureSettings, statics: Statics, problem: LimitProblem
    ) -> CaseResult:
        started_at, start = _now(), perf_counter()
        steps = solve_limit_case(problem, case.flow, settings, solver_of(settings))
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
        history = history_of(statics, problem, iterations)
        return CaseResult(
            case=case,
            settings=settings,
            status=outcome.status,
            load_factor=outcome.load_factor,
            certificate=iterations[-1].certificate if iterations and outcome.status is not Status.UNBOUNDED else None,
            message=outcome.message + (_where(history) if outcome.status is Status.UNSTABLE else ""),
            history=history,
            started_at=started_at,
            duration=perf_counter() - start,
        )

    def _tell(self, event: CaseStarted | IterationDone | CaseFinished) -> None:
        for listener in self.listeners:
            listener(event)


def _where(history: xr.Dataset) -> str:
    """Interfaces that fail fastest in the last iteration, with how they fail."""
    last = history.isel(iteration=-1)
    speed = np.linalg.norm(last["relative_velocity"].transpose("contact_point", "component"), axis=1)
    fastest = np.zeros(history.sizes["interface"])
    np.maximum.at(fastest, last["interface_of_contact_point"].to_numpy(), speed)
    state = contact_state(last).to_numpy()
    still = (ContactState.STICKING, ContactState.UNKNOWN)
    order = [j for j in np.argsort(-fastest, kind="stable") if state[j] not in still][:3]
    names = history["interface"].to_numpy()
    return "; it fails at " + ", ".join(f"{names[j]} ({state[j]})" for j in order) if order else ""


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _versions() -> dict[str, str]:
    found = {package: version(package) for package in _PACKAGES}
    return {**found, "python": platform.python_version(), "platform": platform.platform()}
