"""Before a run: cases are checked, their results planned, and the versions noted that will make the numbers."""

import platform
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache, partial
from importlib.metadata import version
from typing import Any

import numpy as np

from blockstruct.errors import GeometryError, ModelError, UnusualValueWarning, VersionWarning
from blockstruct.limit import LimitProblem, Outcome
from blockstruct.limit.settings import Numerics, ProcedureSettings, scheduled
from blockstruct.model import Case, Model, Pushover, RecordCase, check_unrepeated, has_curve
from blockstruct.motion.moving_problem import check_moving_case
from blockstruct.motion.record import check_record
from blockstruct.results import history_of
from blockstruct.results.analysis import Analysis, run_name
from blockstruct.results.case_result import CaseResult, LazyHistory
from blockstruct.solvers import solver_of
from blockstruct.statics.moved import MovingStructure
from blockstruct.statics.statics import Statics
from blockstruct.storage import patterns
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


def planned_result(run: Run, statics: Statics, problem: LimitProblem, started_at: str) -> CaseResult:
    """Return the result of a case that is still to be run; its empty history is made at its first use."""
    history: Any = LazyHistory(0, partial(history_of, statics, problem, []))
    return CaseResult(
        model=statics.model,
        case=run.case,
        settings=run.settings,
        outcome=Outcome(Status.INTERRUPTED, np.nan, Reason.NOT_BEGUN),
        certificate=None,
        schedule=run.schedule,
        of_case=run.of_case,
        history=history,
        started_at=started_at,
        duration=0.0,
    )


def located_cases(model: Model, cases: Sequence[Case]) -> list[Case]:
    """Return the cases with the names of the blocks at control points."""
    return [case.located(model) if isinstance(case, Pushover) else case for case in cases]


def checked_problems(statics: Statics, cases: Sequence[Case]) -> list[LimitProblem]:
    """Return the limit problems of cases.

    Raises
    ------
    ModelError
        If there is no case, two cases have the same name, or a case cannot be run.

    Warns
    -----
    UnusualValueWarning
        If a dead load is zero and the joints rely on friction alone.
    """
    names = [case.name for case in cases]
    if not names:
        msg = "AnalysisManager.run: no case; give at least one LimitCase, SettlementCase or RecordCase"
        raise ModelError(msg)
    check_unrepeated(names, "AnalysisManager.run: case")
    patterns(cases)
    for case in cases:
        if has_curve(case):
            check_moving_case(statics.model, case)
        if isinstance(case, Pushover):
            _check_rounding(statics, case)
        if isinstance(case, RecordCase):
            check_record(statics.model, case)
    problems = [LimitProblem.of(statics, case) for case in cases]
    _look_at_dead_loads(cases, problems)
    return problems


def _check_rounding(statics: Statics, case: Pushover) -> None:
    """Refuse rounded corners that remove a whole face."""
    if case.corner_rounding:
        try:
            MovingStructure(statics, case.corner_rounding)
        except GeometryError as error:
            msg = f"pushover {case.name!r}: corner_rounding: {error}"
            raise GeometryError(msg) from error


def _look_at_dead_loads(cases: Sequence[Case], problems: Sequence[LimitProblem]) -> None:
    """Warn of a zero dead load if joints rely on friction alone.

    Such a load is rarely intended. All forces are then in proportion to the variable load: the load factor is 0 or
    infinite, unless joints crush.
    """
    first = dict[str, Case]()
    for case, problem in zip(cases, problems, strict=True):
        if not (problem.w_D.any() or problem.cohesion.any() or problem.tension.any() or len(problem.ties.capacity)):
            first.setdefault(case.dead.name, case)
    for name, case in first.items():
        lacks = "is zero on every free block" if case.dead.loads else "has no loads"
        text = (
            f"case {case.name!r}: the dead load {name!r} {lacks}, and joints without cohesion or tensile strength "
            "have nothing but the variable load to press them together: what is found is hardly a load factor of a "
            "structure; give the dead load the weight of the blocks, SelfWeight() (self_weight)"
        )
        # The warning names the line that calls run.
        warnings.warn(text, UnusualValueWarning, stacklevel=5)


_PACKAGES = ("blockstruct", "clarabel", "cvxpy", "h5netcdf", "h5py", "numpy", "pint", "scipy", "shapely", "xarray")
#: Options of Clarabel that every solve takes from the settings, so their defaults are never used.
_TOLERANCES = {"tol_gap_abs", "tol_gap_rel", "tol_feas"}


def now() -> str:
    """Return the time, UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def versions() -> dict[str, str]:
    """Return the versions of all numerical packages, Python and the platform."""
    return {**_installed(), "python": platform.python_version(), "platform": platform.platform()}


@cache
def _installed() -> dict[str, str]:
    """Return the versions, read once, because reading takes the time of a small case."""
    return {package: version(package) for package in _PACKAGES}


def solver_options(settings: Iterable[ProcedureSettings]) -> dict[str, dict[str, Any]]:
    """Return the options of each solver, apart from the tolerances.

    The settings contain the tolerances.
    """
    return {
        name: _options(solver_of(ProcedureSettings(numerics=Numerics(solver=name))))
        for name in sorted({s.numerics.solver for s in settings})
    }


def _options(solver: Any) -> dict[str, Any]:
    settings = getattr(solver, "settings", None)
    names = [name for name in dir(settings) if not name.startswith("_") and name not in _TOLERANCES]
    plain = {name: getattr(settings, name) for name in names}
    return {name: value for name, value in plain.items() if isinstance(value, bool | int | float | str)}


def warn_of_versions(analysis: Analysis) -> None:
    """Warn of cases whose kept numbers come from other versions."""
    present, cases = versions(), dict[str, list[str]]()
    for name, result in analysis.items():
        for made_by in result.versions:
            differ = [
                f"{package} {of_numbers} (now {present.get(package, 'not installed')})"
                for package, of_numbers in made_by.items()
                if of_numbers != present.get(package)
            ]
            if differ:
                cases.setdefault(", ".join(differ), []).append(repr(name))
    for made_with, names in cases.items():
        text = f"case {', '.join(names)}: made by {made_with}, and kept; the versions of each case tell what made it"
        warnings.warn(text, VersionWarning, stacklevel=3)
