"""Every direction of a building in one call: runs, checks, one verdict, one table, one report."""

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from blockstruct.analysis import AnalysisManager, kept_analysis
from blockstruct.analysis.events import CaseFinished, Event, Progress
from blockstruct.analysis.manager import with_effects
from blockstruct.analysis.plan import runs_of
from blockstruct.assess.check import LocalMechanismCheck, Verdict
from blockstruct.assess.floor_spectrum import Spectrum
from blockstruct.assess.local_mechanism import REMEDIES, local_mechanism
from blockstruct.assess.unit_sizes import UnitSizes
from blockstruct.errors import ModelError, StorageError, made_again
from blockstruct.limit.settings import ProcedureSettings, schedules_of
from blockstruct.model import BodyForce, LimitCase, LoadPattern, Model
from blockstruct.model.fields import changed
from blockstruct.notebook import html_table, is_watched
from blockstruct.results import Spread
from blockstruct.results.analysis import Analysis, run_name
from blockstruct.results.case_result import CaseResult
from blockstruct.text import assessment
from blockstruct.text.note import NoteCode, Severity
from blockstruct.text.numbers import told_apart
from blockstruct.vocabulary import Stage, Status

#: Directions of a building with walls along x and y.
DIRECTIONS = ("+x", "-x", "+y", "-y")
#: Warnings of a direction that has not settled.
_UNSETTLED = (NoteCode.NOT_SETTLED, NoteCode.RAISED_BY_CRUSHING)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Building:
    """The checks of a building: :func:`building`.

    Attributes
    ----------
    analysis : Analysis
        A case a direction. The governing case has its whole history, the others their last state.
    checks : mapping of str to LocalMechanismCheck
        By direction, of those with a load factor.
    unit_sizes : UnitSizes or None
    """

    analysis: Analysis
    checks: Mapping[str, LocalMechanismCheck]
    unit_sizes: UnitSizes | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return made_again(self)

    @property
    def governing(self) -> LocalMechanismCheck:
        """The check with the lowest share of its site's ground acceleration.

        Its notes include the directions that leave it open: without a load factor, not settled, or with open warnings.
        """
        name = _governing(self.checks)
        check = self.checks[name]
        notes = [
            assessment.direction_without(other, result.status)
            for other, result in self.analysis.items()
            if result.status not in (Status.CONVERGED, Status.UNBOUNDED) and result.of_case == ""
        ]
        for case, each in self.checks.items():
            verdict = each.verdict
            if case == name:
                continue
            if not verdict.settled:
                is_limit = bool(np.isfinite(each.result.outcome.without_crushing))
                notes.append(assessment.direction_unsettled(case, each.ratio, check.ratio, is_limit=is_limit))
            if others := [note for note in verdict.open if note.code not in _UNSETTLED]:
                notes.append(assessment.direction_open(case, each.ratio, len(others)))
        return replace(check, notes=tuple(dict.fromkeys([*check.notes, *notes])))

    @property
    def _noted(self) -> dict[str, LocalMechanismCheck]:
        """The checks, of which the governing one has its notes on the others."""
        return {**self.checks, _governing(self.checks): self.governing}

    @property
    def verdict(self) -> Verdict:
        """The verdict of the governing direction, which the other directions may leave open."""
        return self.governing.verdict

    @property
    def table(self) -> pd.DataFrame:
        """A row a direction: status, α0, and of the motion relied on α, e*, a0*, ratio, its range, and the outcome."""
        rows = {}
        governs = _governing(self.checks)
        checks = self._noted
        for name, result in self.analysis.items():
            if result.of_case:
                continue
            check = checks.get(name)
            row: dict[str, Any] = {"status": result.ended, "load factor": result.load_factor}
            if check is not None:
                verdict = check.verdict
                lowest, highest = verdict.range
                row |= {
                    "α": verdict.governing.alpha,
                    "e*": verdict.governing.e_star,
                    "a0* [meter / second ** 2]": check.acceleration,
                    "ratio": lowest,
                    "highest ratio": highest,
                    "relied on": verdict.relied_on,
                    "satisfied": verdict.satisfied,
                    "governs": name == governs,
                }
            rows[name] = row
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("case")

    def report(self, path: str | Path, project: Mapping[str, str] = MappingProxyType({})) -> Path:
        """Write the report, ``.html`` or ``.pdf``: :func:`blockstruct.views.report.write_report`."""
        from blockstruct.views.report import write_report

        checks = self._noted.values()
        return write_report(self.analysis, path, project=project, checks=checks, unit_sizes=self.unit_sizes)

    @property
    def _title(self) -> str:
        return f"{_governing(self.checks)}: {self.verdict}"

    @property
    def _shown(self) -> pd.DataFrame:
        """The columns of the table that are printed, numbers with four digits."""
        shown = self.table.reindex(columns=["load factor", "α", "e*", "ratio", "relied on", "satisfied"])
        shown["ratio"] = [told_apart(ratio, 1.0)[0] for ratio in shown["ratio"]]
        for name, column in shown.items():
            shown[name] = [f"{value:.4g}" if isinstance(value, float) else value for value in column]
        return shown

    @property
    def _below(self) -> list[str]:
        """What is open, and the answers with units of other sizes."""
        return [*(f"open: {note}" for note in self.verdict.open), *([str(self.unit_sizes)] if self.unit_sizes else [])]

    def __repr__(self) -> str:
        return f"<Building {self.analysis.model.name!r}: {self._title}>"

    def _repr_html_(self) -> str:
        shown = self._shown
        return html_table(self._title, ["case", *shown.columns], shown.itertuples(name=None), self._below)

    def __str__(self) -> str:
        return "\n".join([self._title, "", self._shown.to_string(), *self._below])


class _TimeLeft:
    """Listener that prints each run that ends, and an estimate of the time that is left, to stderr."""

    def __init__(self, count: int) -> None:
        self.count, self._done, self._begin = count, 0, perf_counter()

    def __call__(self, event: Event) -> None:
        if isinstance(event, CaseFinished):
            self._done += 1
            result, elapsed = event.result, perf_counter() - self._begin
            line = assessment.run_ended(result.name, result.status, self._done, self.count, elapsed)
            print(line, file=sys.stderr, flush=True)


def building(  # noqa: PLR0913
    model: Model,
    dead: LoadPattern,
    spectrum: Spectrum,
    *,
    store: str | Path | None = None,
    directions: Sequence[Any] = DIRECTIONS,
    confidence_factor: float | None = None,
    knowledge_level: str | None = None,
    method: str = "linear",
    settings: ProcedureSettings | None = None,
    progress: Progress = "auto",
    unit_sizes: UnitSizes | None = None,
) -> Building:
    """Check the local mechanisms of a building in several directions.

    Each direction has its loading path. The variants of the path are run only where the verdict depends on them: in
    the direction that governs, until that direction has its range. With the four directions there are some ten runs.
    The effects of torsion and crushing are run where the verdict depends on them, too, and estimated in the other
    directions. On one core a house of 129 blocks takes 22 s.

    Parameters
    ----------
    model, dead
        The structure, and its weights and other loads that act in full.
    spectrum
        Demand at SLV.
    store
        Path of a file that keeps every run when it ends. After an interrupt or a crash, the same call continues from
        there. None keeps the runs in memory, where an interrupt loses them.
    directions
        Directions of :class:`blockstruct.BodyForce`.
    confidence_factor, knowledge_level, method
        See :func:`local_mechanism`.
    settings
        See :class:`blockstruct.AnalysisManager`.
    progress
        False prints nothing. By default the number of runs, and each run that ends with an estimate of the time left,
        are printed to stderr, also into a file; on a terminal or in a notebook the progress within a run, too.
    unit_sizes
        Answers with units of other sizes: :func:`blockstruct.assess.unit_sizes`. The report states them, and the
        verdict is not satisfied while one of their ratios is below one.

    Returns
    -------
    Building
        ``.verdict``, ``.table`` and ``.report(path)``.

    Raises
    ------
    ModelError
        If no direction has a load factor to check, or an argument does not suit :func:`local_mechanism`.
    StorageError
        If the store holds runs of another model, other loads or other settings, or cannot be written.
    KeyboardInterrupt
        After an interrupt. Its note states which runs the store keeps.
    """
    cases = {}
    for direction in directions:
        force = BodyForce(direction)
        name = f"push {direction if isinstance(direction, str) else tuple(direction)}"
        cases[name] = LimitCase(name, dead, LoadPattern(name, [force]))
    # The governing case is run before its variants.
    variants = len(runs_of([*cases.values()][:1], settings or ProcedureSettings(), schedules_of(True))) - 1
    kept = {} if store is None else _kept(store, model, cases, settings or ProcedureSettings())
    left = _TimeLeft(len(cases) + variants - len(_ended(kept)))
    watched: dict[str, Any] = {"effects": False, "progress": is_watched() if progress == "auto" else progress}
    if progress is not False:
        watched["listeners"] = [left]
        print(assessment.runs_planned(model.name, len(model.blocks), len(cases), variants), file=sys.stderr, flush=True)
    manager = AnalysisManager(model, store, settings=settings, **watched)
    analysis = manager.resume(store, **watched) if store and kept else manager.run(cases.values())
    results = dict(_complete(analysis, store))

    def checked(result: CaseResult | Spread) -> LocalMechanismCheck:
        return local_mechanism(result, confidence_factor, spectrum, knowledge_level=knowledge_level, method=method)

    # Effects of torsion, crushing and self-stress count: estimates may decide which direction governs.
    estimated = {
        name: with_effects(results[name], is_estimate=True)
        for name in cases
        if results[name].status is Status.CONVERGED
    }
    checks = {name: checked(result) for name, result in estimated.items()}
    if not checks:
        ended = ", ".join(f"{name}: {result.ended}" for name, result in results.items())
        msg = f"building {model.name!r}: no direction has a load factor to check ({ended})"
        raise ModelError(msg)
    ranged = set[str]()
    while (name := _governing(checks)) not in ranged:
        left.count += variants * bool(ranged)
        ranged.add(name)
        more = analysis
        if name not in analysis.spreads:
            others = [result for result in results.values() if result.name != name]
            more = _complete(manager.vary(results[name], *others), store)
        remedies: dict[str, CaseResult] = {}
        low = with_effects(more.spread(name).relied_on, hear=remedies.__setitem__)
        more = more.replaced(results={**more, low.name: low})
        results |= {run: more[run] for run in more if name in (run, more[run].of_case)}
        checks[name] = _lowest(name, checked(more.spread(name)), remedies, checked)
    governs = _governing(checks)
    if unit_sizes is not None:
        checks[governs] = replace(checks[governs], notes=(*checks[governs].notes, *unit_sizes.notes))
    found = {
        name: result if (result.of_case or name) == governs else _last(estimated.get(name, result))
        for name, result in results.items()
    }
    kept = Analysis(model, found, analysis.created_at, analysis.versions, solver_options=analysis.solver_options)
    return Building(kept, MappingProxyType(checks), unit_sizes)


def _kept(
    store: str | Path, model: Model, cases: Mapping[str, LimitCase], settings: ProcedureSettings
) -> Mapping[str, CaseResult]:
    """Return the results that a store has of a building; empty without a file."""
    analysis = kept_analysis(store)
    if analysis is None:
        return {}
    found = {name: (result.case, result.settings) for name, result in analysis.items() if not result.of_case}
    if analysis.model.hash != model.hash or found != {name: (case, settings) for name, case in cases.items()}:
        msg = (
            f"{store}: holds runs of another model, other loads or other settings than building {model.name!r}; give "
            "another store"
        )
        raise StorageError(msg)
    return analysis


def _ended(results: Mapping[str, CaseResult]) -> list[str]:
    return [name for name, result in results.items() if result.status is not Status.INTERRUPTED]


def _complete(analysis: Analysis, store: str | Path | None) -> Analysis:
    """Return an analysis; raise KeyboardInterrupt if one ended it early, as a building needs every run."""
    if analysis.status != "finished":
        interrupt = KeyboardInterrupt()
        interrupt.add_note(assessment.building_interrupted(_ended(analysis), None if store is None else str(store)))
        raise interrupt
    return analysis


def _governing(checks: Mapping[str, LocalMechanismCheck]) -> str:
    return min(checks, key=lambda name: checks[name].verdict.share)


def _lowest(
    name: str,
    check: LocalMechanismCheck,
    remedies: Mapping[str, CaseResult],
    checked: Callable[[CaseResult], LocalMechanismCheck],
) -> LocalMechanismCheck:
    """Return the check of the remedy that governs, with its own motion; the check itself if none does.

    Parameters
    ----------
    name, check
        The case, and the check of its path, which counts remedies by their load factors alone.
    remedies
        Runs of remedies by the fact that each gives.
    checked
        Makes a check of a run.
    """
    factors = [way.load_factor * check.result.load_factor for way in check.verdict.ways]
    while (way := check.verdict.governing.way) in REMEDIES and (run := remedies.get(REMEDIES[way])) is not None:
        case = changed(run.case, name=run_name(name, str(way)))
        run = run.changed(case=case, schedule=str(way), of_case=name, path_dependence=(min(factors), max(factors)))
        own = checked(with_effects(run))
        rest = replace(check, others=tuple(other for other in check.others if other.way is not way))
        if own.verdict.share <= rest.verdict.share:
            stays = [note for note in check.notes if note.change is not None or note.severity is Severity.WARNING]
            return replace(own, notes=tuple(dict.fromkeys([*stays, *own.notes])))
        check = rest
    return check


def _last(result: CaseResult) -> CaseResult:
    """Return the result with its associative program and its last state alone."""
    stage = result.history["stage"].to_numpy()
    kept = stage == Stage.ASSOCIATIVE.value
    kept[-1:] = True
    history = result.history.isel(iteration=np.flatnonzero(kept))
    numbers = history["iteration"].copy(data=np.arange(history.sizes["iteration"]))
    return result.changed(history=history.assign_coords(iteration=numbers))
