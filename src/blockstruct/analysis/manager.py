"""The analysis manager, its listener that commits a run, the remedies of notes, and analyses in one call."""

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from types import MappingProxyType
from typing import Any, Self

import numpy as np

from blockstruct.analysis import plan
from blockstruct.analysis.events import (
    CaseFinished,
    CaseStarted,
    Event,
    IterationDone,
    Listener,
    Progress,
    StateDone,
    StepDone,
    tell,
    with_progress,
)
from blockstruct.analysis.motions import INTERRUPTED, ReplaySolver, collect, kept_state, trace_curve, trace_record
from blockstruct.errors import LoadFactorWarning, ModelError, shown
from blockstruct.limit import Iteration, LimitProblem
from blockstruct.limit.program import Solver
from blockstruct.limit.settings import ProcedureSettings, schedules_of
from blockstruct.model import Case, Interface, JointMaterial, Model, RecordCase, checked_text, checked_tuple, has_curve
from blockstruct.model.fields import changed
from blockstruct.procedures import load_factor_at, solve_dead_load, solve_limit_case
from blockstruct.results import compare, history_of
from blockstruct.results.analysis import Analysis, checked_parameters, checked_tags
from blockstruct.results.capacity import state_arrays
from blockstruct.results.case_result import CaseResult
from blockstruct.results.comparison import Comparison
from blockstruct.results.history import division_of, iteration_variables
from blockstruct.results.interfaces import corner_torsion
from blockstruct.solvers import RememberingSolver, solver_of
from blockstruct.statics.contacts import Division
from blockstruct.statics.statics import Statics
from blockstruct.storage import Checkpoint, claim, is_unfinished, open_analysis, planned_analysis, tidy
from blockstruct.vocabulary import Stage, Status, Torsion

#: Statics and limit problem of each case by its name.
Problems = Mapping[str, tuple[Statics, LimitProblem]]


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
                self._working.start(case.name, plan.versions())
                self._variables = lambda iteration: iteration_variables(statics, problem, [iteration])
            case IterationDone(case, index, iteration):
                arrays = {name: values for name, (_, values, _) in self._variables(iteration).items()}
                held = {"holds": np.array([iteration.certificate.holds])}
                self._working.commit(case.name, "iteration", index, arrays | held)
            case StepDone(case, index, step):
                self._working.commit(case.name, "step", index, state_arrays([step]))
            case StateDone(case, index, state):
                self._working.commit(case.name, "step", index, state_arrays([state]))
            case CaseFinished(result) if result.status is not Status.INTERRUPTED:
                self._working.end(result)


class AnalysisManager:
    """Runs limit cases of one model and assembles its statics once.

    Parameters
    ----------
    model
        The structure.
    store
        Path of the file to write; None keeps the analysis in memory. The path is checked at once. During the run the
        data are in ``NAME.partial`` in the same folder. The file appears when the last case ends or the run is
        interrupted.
    settings
        Schedule and tolerances of the procedure.
    listeners
        Called with every :class:`~blockstruct.analysis.Event`, in order.
    progress
        Whether to show the progress; by default on a terminal or in a notebook, if there are no listeners.
    tags
        Words by which :meth:`blockstruct.Archive.select` finds the analysis.
    parameters
        Parameters of the model, kept in the file: numbers, texts and quantities by name. They are columns of
        :meth:`blockstruct.Archive.table`.
    effects
        Whether to run a case with a note on torsion, crushing or self-stress again by the remedy of the note, which
        then states how much the number changes. It takes one to three times the time of the case.
    document_hash
        Hash of the document that describes the model: :attr:`blockstruct.documents.Document.hash`.
    study
        Study that the run belongs to, as :func:`blockstruct.study` names it.

    Raises
    ------
    StorageError
        If the store cannot be written.
    SolverError
        If the settings name a solver that is not installed.
    GeometryError
        If an interface that crushes cannot be divided into cells.
    """

    def __init__(  # noqa: PLR0913
        self,
        model: Model,
        store: str | Path | None = None,
        *,
        settings: ProcedureSettings | None = None,
        listeners: Iterable[Listener] = (),
        progress: Progress = "auto",
        tags: Iterable[str] = (),
        parameters: Mapping[str, Any] = MappingProxyType({}),
        study: str = "",
        document_hash: str = "",
        effects: bool = True,
    ) -> None:
        if not isinstance(model, Model):
            msg = f"AnalysisManager: model is {shown(model)}; give a Model"
            raise ModelError(msg)
        if not isinstance(settings, ProcedureSettings | None):
            msg = f"AnalysisManager: settings are {shown(settings)}; give ProcedureSettings(…)"
            raise ModelError(msg)
        self.model = model
        self.settings = settings or ProcedureSettings()
        self.listeners = with_progress(checked_tuple(listeners, Callable, "AnalysisManager: listeners"), progress)
        self.tags = checked_tags(tags, "AnalysisManager")
        self.parameters = checked_parameters(parameters, "AnalysisManager: parameters")
        self.study = checked_text(study, "AnalysisManager: study")
        self.document_hash = document_hash
        self.effects = effects
        self.statics = Statics.of(model, Division(self.settings.crushing_cells))
        self._solvers = dict[str, Solver]()
        self._solver_of(self.settings)
        self.store = None if store is None else claim(store)

    def run(self, cases: Iterable[Case], *, spread: bool | str | Iterable[str] = False) -> Analysis:
        """Run cases one after the other.

        After all cases, a LoadFactorWarning names load factors that need care: :attr:`CaseResult.warnings`.

        An UnusualValueWarning reports a zero dead load on joints that rely on friction, before anything is solved.

        A KeyboardInterrupt ends the run. The current case gets the status ``interrupted`` and keeps its iterations.
        Later cases get the same status without iterations. Earlier cases are complete.

        With a store, every iteration is committed when it is solved. If the process is killed, :meth:`resume` and
        :func:`blockstruct.recover` find all iterations but the current one.

        Parameters
        ----------
        cases
            The cases.
        spread
            True also runs every non-associative case along the variants of the loading path and with associative
            flow, as ``"case [half steps]"`` and ``"case [associative]"``. :attr:`CaseResult.path_dependence` is then
            the range of the load factor. Names select schedules of :data:`~blockstruct.limit.SCHEDULES`; ``"paper"``
            selects all schedules of the paper's procedure. :meth:`Analysis.spread` has their results. No schedule
            changes the headline.

        Raises
        ------
        ModelError
            If there is no case, two cases have the same name, a variable load is zero, the model cannot take a load,
            or a schedule is unknown. Raised before anything is solved.
        StorageError
            If another run writes to the store, or the store holds the iterations of a killed run. Raised before
            anything is solved. Also if the disk is full; committed data are kept.
        """
        located = plan.located_cases(self.model, checked_tuple(cases, Case, "AnalysisManager.run: cases"))
        return self._run(plan.runs_of(located, self.settings, schedules_of(spread)))

    def vary(self, result: CaseResult, *others: CaseResult) -> Analysis:
        """Run the variants of a case that has been run, as ``run([case], spread=True)`` does after the case.

        Parameters
        ----------
        result
            Result of a case of this model, with the settings of this manager. It is part of the analysis as it is.
        others
            Results of other cases to keep in the analysis.
        """
        return self._run(plan.runs_of([result.case], self.settings, schedules_of(True)), *others, result)

    def _run(self, runs: Sequence[plan.Run], *known: CaseResult) -> Analysis:
        """Run cases, apart from known results."""
        started_at = plan.now()
        checked = self.check([run.case for run in runs])
        problems = {run.case.name: (self.statics, problem) for run, problem in zip(runs, checked, strict=True)}
        planned = {result.name: result for result in known}
        for run in runs:
            planned.setdefault(run.case.name, plan.planned_result(run, *problems[run.case.name], started_at))
        analysis = Analysis(
            self.model,
            planned,
            started_at,
            plan.versions(),
            solver_options=plan.solver_options([run.settings for run in runs]),
            document_hash=self.document_hash,
            tags=self.tags,
            parameters=self.parameters,
            study=self.study,
        )
        if self.store is None:
            done = self._conduct(analysis, self.listeners, problems)
        else:
            with Checkpoint.begin(self.store, analysis) as working:
                done = self._record(analysis, working, problems)
        before = {result.name for result in known}
        _warn_of(result for name, result in done.items() if name not in before)
        return done

    @classmethod
    def resume(
        cls, path: str | Path, *, listeners: Iterable[Listener] = (), progress: Progress = "auto", effects: bool = True
    ) -> Analysis:
        """Resume a killed or interrupted run from its last committed iteration.

        Cases that have ended are kept. Solved programs are not solved again, except for the program under dead load.
        The result equals the result of an uninterrupted run, to the tolerance of its certificate. A finished analysis
        is returned unchanged.

        Parameters
        ----------
        path
            The store of the run.
        listeners
            As for the manager; they also receive replayed iterations.
        progress, effects
            As for the manager.

        Raises
        ------
        StorageError
            If there is nothing to resume, or the run is still under way.
        FormatError
            If the file is damaged, or this version of blockstruct would solve other iterations.

        Warns
        -----
        VersionWarning
            If other versions made the kept numbers. :attr:`CaseResult.versions` gives the versions of each case.
        """
        options: dict[str, Any] = {"listeners": listeners, "progress": progress, "effects": effects}
        if is_unfinished(path):
            with Checkpoint.reopen(path) as working:
                analysis = working.analysis()
                plan.warn_of_versions(analysis)
                done = cls._resuming(analysis, path, **options)._record(analysis, working)
        elif (analysis := open_analysis(path)).status == "finished":
            tidy(path)
            return analysis
        else:
            plan.warn_of_versions(analysis)
            manager = cls._resuming(analysis, path, **options)
            with Checkpoint.begin(path, analysis) as working:
                done = manager._record(analysis, working)
        _warn_of(done.values())
        return done

    @classmethod
    def again(cls, analysis: Analysis, *, listeners: Iterable[Listener] = ()) -> Analysis:
        """Run an analysis again in memory, each case with its own settings."""
        manager = cls._resuming(analysis, None, listeners=listeners)
        started_at = plan.now()
        problems = {name: manager._problem_of(result) for name, result in analysis.items()}
        planned = {
            name: plan.planned_result(plan.Run(r.case, r.settings, r.schedule, r.of_case), *problems[name], started_at)
            for name, r in analysis.items()
        }
        return manager._conduct(analysis.replaced(results=planned, created_at=started_at), manager.listeners, problems)

    def check(self, cases: Sequence[Case]) -> list[LimitProblem]:
        """Check cases as :meth:`run` does, and return their limit problems."""
        return plan.checked_problems(self.statics, plan.located_cases(self.model, cases))

    @classmethod
    def _resuming(cls, analysis: Analysis, path: str | Path | None, **options: Any) -> Self:
        settings = next((result.settings for result in analysis.values()), None)
        return cls(analysis.model, path, settings=settings, **options)

    def _record(self, analysis: Analysis, working: Checkpoint, problems: Problems = MappingProxyType({})) -> Analysis:
        done = self._conduct(analysis, (Recorder(working), *self.listeners), problems)
        working.finish(done)
        return done

    def _conduct(self, analysis: Analysis, listeners: Sequence[Listener], problems: Problems) -> Analysis:
        """Run the interrupted cases of an analysis."""
        results = dict(analysis)
        of_numbers = analysis.versions
        for number, (name, before) in enumerate(analysis.items(), start=1):
            if before.status is not Status.INTERRUPTED:
                continue
            of_numbers = plan.versions()
            try:
                statics, problem = problems[name] if name in problems else self._problem_of(before)
                place = (number, len(analysis))
                results[name] = result = self.run_case(before, statics, problem, listeners, place)
                try:
                    if self.effects and not result.schedule:
                        results[name] = result = with_effects(result)
                finally:
                    # The case has ended, if need be without its effects.
                    tell(listeners, CaseFinished(result))
            except KeyboardInterrupt:
                break
            if result.status is Status.INTERRUPTED:
                break
        return analysis.replaced(results=results, versions=of_numbers)

    def run_case(
        self,
        before: CaseResult,
        statics: Statics,
        problem: LimitProblem,
        listeners: Sequence[Listener] = (),
        place: tuple[int, int] = (1, 1),
    ) -> CaseResult:
        """Run a planned or interrupted case from its statics and limit problem, without remedies and warnings.

        The case is number ``place[0]`` of ``place[1]`` for its listeners.
        """
        case, settings, start = before.case, before.settings, perf_counter()
        scaled, solver = problem.at_unit_load, self._solver_of(settings)
        replay = ReplaySolver(statics, scaled, before.history, solver) if before.n_iterations else None
        answers: Solver = replay or solver
        solved = (
            solve_dead_load(scaled, settings, answers)
            if isinstance(case, RecordCase)
            else solve_limit_case(scaled, case.flow, settings, answers)
        )
        made_by, started_at = (before.versions, before.started_at) if replay else ((), plan.now())
        tell(listeners, CaseStarted(case, len(self.model.blocks), problem.n_points, statics, problem, *place))
        iterations, ended = collect(
            replay.follow(solved) if replay else solved,
            lambda k, iteration: tell(listeners, IterationDone(case, k, iteration)),
        )
        if ended is None and len(iterations) < before.n_iterations:
            return before
        outcome, history = ended or INTERRUPTED, history_of(statics, problem, iterations)
        proof = iterations[-1].certificate if iterations and outcome.status is not Status.UNBOUNDED else None
        done = replace(
            before,
            outcome=outcome,
            damage="",
            certificate=proof if proof and proof.is_of_a_state else None,
            history=history,
            started_at=started_at,
            duration=before.duration + perf_counter() - start,
            versions=made_by if made_by[-1:] == (plan.versions(),) else (*made_by, plan.versions()),
        )
        if isinstance(case, RecordCase):
            return trace_record(done, statics, case, listeners) if outcome.status is Status.STANDS else done
        if not has_curve(case) or outcome.status is not Status.CONVERGED:
            return done
        # The curve begins with the collapse state as the first run kept it.
        first = before.history if before.n_iterations == len(iterations) else history
        return trace_curve(done, statics, problem, kept_state(statics, problem, first, iterations[-1]), listeners)

    def _solver_of(self, settings: ProcedureSettings) -> Solver:
        """Return the solver of settings, which knows the dead loads of earlier cases."""
        name = settings.numerics.solver
        if name not in self._solvers:
            self._solvers[name] = RememberingSolver(solver_of(settings))
        return self._solvers[name]

    def _problem_of(self, result: CaseResult) -> tuple[Statics, LimitProblem]:
        """Return statics and limit problem of a result, with its division into cells."""
        division = division_of(self.model, result.settings.crushing_cells, result.history)
        is_same = division == Division(self.settings.crushing_cells, self.statics.points.divided)
        statics = self.statics if is_same else Statics.of(self.model, division)
        return statics, LimitProblem.of(statics, result.case)


def _warn_of(results: Iterable[CaseResult]) -> None:
    """Issue the warnings of results, each text once."""
    cases_of_text = dict[str, str]()
    for result in results:
        for text in result.warnings:
            cases_of_text.setdefault(text, result.name)
    for text, name in cases_of_text.items():
        warnings.warn(f"case {name!r}: {text}", LoadFactorWarning, stacklevel=3)


#: Steps of a loading path after which the effect of a remedy is estimated: 7.5 elastic displacements. Measured on 18
#: settled cases of 8 structures: the effect is off by 0.8 % of the load factor in the mean square, after 3 steps by
#: 1.1 %, after 5 by 0.8 %.
COMPARED = 4


def with_effects(
    result: CaseResult, *, is_estimate: bool = False, hear: Callable[[str, CaseResult], object] = lambda *_: None
) -> CaseResult:
    """Return a result with the load factor that the remedy of each note gives.

    A note on torsion has joints with the torsion of uniform pressure as its remedy, a note on crushing about both axes
    the exact condition, and a note on self-stress another procedure. Each remedy takes one to three times the time of
    the case. With ``is_estimate`` torsion and crushing take a fifth of that time: the load factors of both loading
    paths are compared after ``COMPARED`` steps. docs/theory/torsion.md compares the estimates with the remedy.

    Parameters
    ----------
    result, is_estimate
        The case, and whether its loading paths are compared at their beginning only.
    hear
        Called with the name of each fact, and the run that gives it.
    """
    settings = result.settings
    other = "fictitious" if settings.procedure == "loading path" else "loading path"
    remedies = {
        "uniform_torsion": (_uniform, settings),
        "lowered_friction": (_lowered, settings),
        "biaxial_crushing": (_same, replace(settings, crushing="conic", crushing_interaction="biaxial")),
        "other_procedure": (_same, replace(settings, procedure=other)),
    }
    facts: dict[str, Any] = {}
    for name in result.wanted_effects:
        changed_model, changed_settings = remedies[name]
        if is_estimate and name != "other_procedure":
            facts[name] = _estimated(changed_model(result), result, changed_settings)
            continue
        run = run_again(result, changed_model(result), changed_settings)
        hear(name, run)
        facts[name] = run.load_factor if run.status is Status.CONVERGED else np.nan
    if not facts:
        return result
    return result.changed(outcome=replace(result.outcome, estimated=is_estimate, **facts))


def _same(result: CaseResult) -> Model:
    return result.model


def _uniform(result: CaseResult) -> Model:
    """Return the model of a case with the torsion of uniform pressure in its joints."""
    materials = result.model.joint_materials.items()
    joints = {name: joint.varied(torsion=Torsion.UNIFORM_PRESSURE) for name, joint in materials}
    return _with_joints(result.model, lambda i: joints[i.joint_material.name])


def _lowered(result: CaseResult) -> Model:
    """Return the model of a case with the friction of each joint divided by its excess of torsion."""
    times = corner_torsion(result.model, result.history)["times"].clip(lower=1.0)

    def lowered(interface: Interface) -> JointMaterial:
        joint, excess = interface.joint_material, float(times[interface.name])
        return joint if excess == 1 else joint.varied(friction_coefficient=joint.friction_coefficient / excess)

    return _with_joints(result.model, lowered)


def _with_joints(model: Model, joint_of: Callable[[Interface], JointMaterial]) -> Model:
    # The shapes are unchanged, and need no second check.
    other: Model = changed(model, interfaces=tuple(i.with_joint_material(joint_of(i)) for i in model.interfaces))
    return other


def _estimated(model: Model, result: CaseResult, settings: ProcedureSettings) -> float:
    """Return the load factor of a case with another model and other settings, by the first steps of its loading path.

    NaN without a path as long.
    """
    of_path = result.history["stage"].to_numpy() == Stage.LOADING_PATH.value
    displacement, alpha = (result.history[name].to_numpy()[of_path] for name in ("displacement", "load_factor"))
    if not len(alpha) > COMPARED:
        return np.nan
    statics, bound = Statics.of(model, Division(settings.crushing_cells)), result.associative_load_factor
    problem = LimitProblem.of(statics, result.case).at_unit_load
    at_same = load_factor_at(displacement[COMPARED], problem, bound, settings)
    return result.load_factor * at_same / float(alpha[COMPARED])


def run_again(result: CaseResult, model: Model, settings: ProcedureSettings | None = None) -> CaseResult:
    """Return the result of a case with another model and other settings, in memory, without its curve.

    Raises
    ------
    KeyboardInterrupt
        After an interrupt.
    """
    case, settings = result.case.renamed(result.name), settings or result.settings
    manager = AnalysisManager(model, settings=settings, progress=False)
    problem = LimitProblem.of(manager.statics, case)
    before = plan.planned_result(plan.Run(case, settings), manager.statics, problem, plan.now())
    found = manager.run_case(before, manager.statics, problem)
    if found.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return found


def run(
    model: Model,
    cases: Case | Iterable[Case],
    store: str | Path | None = None,
    *,
    settings: ProcedureSettings | None = None,
    spread: bool | str | Iterable[str] = False,
    parameters: Mapping[str, Any] = MappingProxyType({}),
    listeners: Iterable[Listener] = (),
    progress: Progress = "auto",
) -> Analysis:
    """Run cases of a model: :class:`AnalysisManager` in one call.

    Parameters
    ----------
    model, store, settings, parameters, listeners, progress
        As for :class:`AnalysisManager`.
    cases, spread
        As for :meth:`AnalysisManager.run`; ``cases`` may be a single case.

    Raises
    ------
    ModelError, StorageError, SolverError, GeometryError
        As :class:`AnalysisManager` and its method ``run``.
    """
    listed = [cases] if isinstance(cases, Case) else cases
    manager = AnalysisManager(
        model, store, settings=settings, parameters=parameters, listeners=listeners, progress=progress
    )
    return manager.run(listed, spread=spread)


def reproduce(analysis: Analysis, *, listeners: Iterable[Listener] = ()) -> Comparison:
    """Run an analysis again, each case with its own settings, and compare.

    Parameters
    ----------
    analysis
        An analysis, as a rule from a file.
    listeners
        As for :class:`blockstruct.AnalysisManager`.

    Returns
    -------
    Comparison
        The stored analysis, and the new one of this installation as the other, with the versions that differ.

    Raises
    ------
    ModelError
        If the argument is not an analysis, such as the name of a file.
    """
    if not isinstance(analysis, Analysis):
        msg = f"reproduce: {type(analysis).__name__} is not an analysis; give bs.open_analysis(file)"
        raise ModelError(msg)
    return compare(analysis, AnalysisManager.again(analysis, listeners=listeners))


def recover(path: str | Path) -> Analysis:
    """Make the analysis file of a killed run from its committed iterations.

    Cases that had not ended get the status ``interrupted``. :meth:`blockstruct.AnalysisManager.resume` continues
    either the killed run or the recovered file.

    Parameters
    ----------
    path
        The file that the run would have written. A file that was there when the run began is replaced, as the run would
        have done. No other file is replaced.

    Raises
    ------
    StorageError
        If there is no killed run, it is still under way, or the path cannot be written.
    FormatError
        If the working data are damaged at their root.
    """
    with Checkpoint.reopen(path) as working:
        analysis = working.analysis()
        working.finish(analysis)
    return analysis


def kept_analysis(path: str | Path) -> Analysis | None:
    """Return the analysis that a path holds, made anew if its run was killed; None if it holds nothing.

    Raises
    ------
    StorageError, FormatError
        As :func:`recover`, or if the file is not an analysis.
    """
    return recover(path) if is_unfinished(path) else planned_analysis(path)
