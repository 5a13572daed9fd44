"""Run a structure with varied parameters: runs found in the store, runs that are left, and the progress."""

import contextlib
import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.analysis.plan import runs_of
from blockstruct.errors import BlockstructError, LoadFactorWarning, StorageError, StudyWarning, shown
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.model import checked_tuple
from blockstruct.model.fields import checked_count
from blockstruct.notebook import is_terminal
from blockstruct.results.analysis import Analysis, plain_value
from blockstruct.storage import Archive, planned_analysis
from blockstruct.studies.design import Design, design_of
from blockstruct.studies.plan import Plan, Problem, Run, carry_out
from blockstruct.studies.summary import check_parameter_names, dataset_of
from blockstruct.studies.workers import Ended, connected, in_processes, on_cluster
from blockstruct.vocabulary import Flow, Status, counted


@dataclass(frozen=True, slots=True)
class StudyProgress:
    """Count of the runs of a study, sent when a run ends.

    Attributes
    ----------
    done, total : int
        Runs that have ended, including failed and earlier ones, and all runs.
    failed : int
    found : int
        Runs that an earlier study had finished.
    seconds : float
        Since the study began.
    """

    done: int
    total: int
    failed: int
    found: int
    seconds: float

    @property
    def seconds_left(self) -> float:
        """Estimate from the mean duration of ended runs; NaN before the first."""
        now = self.done - self.found
        return self.seconds / now * (self.total - self.done) if now else float("nan")

    def __str__(self) -> str:
        """Return one line of text."""
        text = f"{self.done} of {counted(self.total, 'run')}"
        text += f", {self.found} of them found" if self.found else ""
        text += f", {self.failed} failed" if self.failed else ""
        if self.done == self.total:
            return f"{text}, in {_time(self.seconds)}"
        return f"{text}, about {_time(self.seconds_left)} left" if self.done > self.found else text


Listener = Callable[[StudyProgress], None]


def print_progress(progress: StudyProgress) -> None:
    """Print one line of progress on the terminal, over the previous one."""
    end = "\n" if progress.done == progress.total else ""
    print(f"\r\x1b[K{progress}", end=end, file=sys.stderr, flush=True)


def _time(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


#: Rows of one run in the archive, each a mapping by column name.
Rows = list[dict[str, Any]]


def found_runs(archive: Archive, design: Design, plan: Plan) -> tuple[dict[str, Rows], dict[str, str]]:
    """Return the rows of finished runs, and why other files are refused.

    The model and the cases of each run are built again and compared with its file.

    Returns
    -------
    tuple of dict
        Rows by the name of the run. Reasons by the name of the run, for files with other values, models, cases or
        settings.

    Raises
    ------
    StorageError
        If the file of a run cannot be read.
    """
    rows: dict[str, Rows] = {}
    others: dict[str, str] = {}
    for run in {run.name: run for run in design.runs}.values():
        path = archive.folder / f"{run.name}.h5"
        try:
            stored = planned_analysis(path)
        except BlockstructError as error:
            msg = f"{error}; move it away, then run the study again"
            raise StorageError(msg) from error
        if stored is None:
            continue
        if why := _difference(run, stored, plan):
            others[run.name] = why
        elif stored.status == "finished":
            rows[run.name] = archive.rows(path)
    return rows, others


def refusal(archive: Archive, others: Mapping[str, str]) -> str:
    """Return the error message on files that do not belong to this study."""
    name, why = next(iter(others.items()))
    return (
        f"study: {archive.folder} has {counted(len(others), 'run')} of these parameters, by name, but not of this "
        f"study: {name}.h5 {why}. Choose another store, or run anew with rerun=True"
    )


def _difference(run: Run, kept: Analysis, plan: Plan) -> str:
    """Return the difference between a run and its file; empty without any."""
    for name, value in run.values.items():
        due, unit = plain_value(value)
        found = plain_value(kept.parameters[name])[0] if name in kept.parameters else None
        # Values with one name are equal to the last digit.
        if due != found:
            of_unit = "" if unit in ("", "dimensionless") else f" {unit}"
            return (
                f"was made with {name} {shown(found)}{of_unit}, but its name stands for {shown(due)}{of_unit}: it was "
                "renamed or copied. Give it its own name back"
            )
    try:
        model, cases = plan.model_and_cases(run.values)
    except Exception as error:
        return f"cannot be compared: build fails now ({error})"
    due = [(each.case, each.settings) for each in runs_of(cases, plan.settings, plan.schedules)]
    if model.hash != kept.model.hash or due != [(result.case, result.settings) for result in kept.values()]:
        return "is of another model, other cases or other settings than this study has"
    return ""


def study(  # noqa: PLR0913
    build: Callable[..., Any],
    parameters: Mapping[str, Any],
    store: str | Path | None = None,
    *,
    sampling: str | None = None,
    runs: int | None = None,
    seed: int = 0,
    workers: int | None = None,
    cluster: Any = None,
    settings: ProcedureSettings | None = None,
    spread: bool | str | Iterable[str] = False,
    rerun: bool = False,
    listeners: Iterable[Listener] | None = None,
) -> xr.Dataset:
    """Run a structure with many values of its parameters.

    Parameters
    ----------
    build
        Function that returns a model and its cases from named parameters: ``build(**values) -> model, cases``.
    parameters
        By name, each

        - a list of numbers, texts or quantities, as ``Q_([2, 4], "MPa")``. ``"grid"`` runs all combinations.
          ``"paired"`` runs the first values of all lists, then the second and so on. None stands for an absent value;
        - a frozen distribution of scipy.stats, as ``norm(0.6, 0.05)``, with a unit as ``Q_(lognorm(…), "MPa")``;
        - one value for all runs.
    store
        Folder that keeps a file of every run. Finished runs are not repeated; killed or interrupted runs are
        continued. None keeps nothing.
    sampling
        ``"grid"`` (default) or ``"paired"`` for lists; ``"monte carlo"`` (default) or ``"latin hypercube"`` for
        distributions. Monte Carlo samples are independent. More ``runs`` with the same ``seed`` begin with the same
        samples.
    runs, seed
        Number of samples of distributions, and their seed.
    workers
        Processes on this machine, each with one thread for linear algebra; 1 runs in this process. The default is the
        number of processors.
    cluster
        A Dask cluster to use instead: a Client, a cluster, or the address of a scheduler. Its workers need blockstruct
        and the module of ``build``, if any, but no shared disk.
    settings, spread
        Settings of the procedure and schedules of each case, as for :class:`blockstruct.AnalysisManager`.
    rerun
        Whether to replace stored runs whose model, cases, settings or values differ, instead of refusing them.
    listeners
        Called with :class:`~blockstruct.studies.StudyProgress` when a run ends; by default a line on a terminal.

    Returns
    -------
    xarray.Dataset
        Along the parameters of a grid, or along ``run``; and along ``case``: ``load_factor``, ``bound`` (the
        associative load factor), ``status``, ``flow``, ``flow_rule_gap``, ``n_iterations``, ``duration``, ``message``.

        For each run: ``problem``, ``elsewhere`` and ``path``. ``problem`` is why the run failed; empty if it did not.
        A failed run has NaN load factors and the statuses ``failed``. ``elsewhere`` is whether another study is
        carrying the run out; its statuses are then ``elsewhere``. ``path`` is the path in the store. Coordinates are in
        the unit of the first value of each parameter.

    Raises
    ------
    ModelError
        If the parameters give no runs, or the number of samples or workers is invalid. Also if a parameter has the name
        of a variable of the study, ``run`` or ``case``.
    UnknownKeywordError
        If ``build`` does not take a parameter, or a parameter is missing.
    StorageError
        If the store cannot be written, or the file of a run has other values, another model, other cases or other
        settings. Each finished run is built again and compared.
    StudyError
        If ``build`` cannot be sent to another process, or the processes cannot start.
    ClusterError
        If the cluster does not answer, or its workers cannot run blockstruct.

    Warns
    -----
    StudyWarning
        If runs failed; the next study tries them again. If another study is carrying out runs.
    """
    plan = Plan.of(build, settings, spread)
    design = design_of(parameters, sampling, runs, seed)
    plan.check_names(design.runs[0].values)
    check_parameter_names(design.runs[0].values)
    count = _workers(workers, len(design.runs))
    terminal = (print_progress,) if is_terminal(sys.stderr) else ()
    heard = terminal if listeners is None else checked_tuple(listeners, Callable, "study: listeners")
    with contextlib.ExitStack() as stack:
        client = None if cluster is None else stack.enter_context(connected(cluster))
        folder = _folder(stack.enter_context(tempfile.TemporaryDirectory()) if store is None else store)
        archive = Archive(folder)
        rows, others = found_runs(archive, design, plan)
        if others and not rerun:
            raise StorageError(refusal(archive, others))
        # Samples of few values may repeat a run.
        named = {run.name: replace(run, anew=run.name in others) for run in design.runs if run.name not in rows}
        left = [*named.values()]
        total = len(rows) + len(left)
        if client is not None:
            ended = on_cluster(plan, left, folder, client)
        elif count == 1:
            ended = ((run, carry_out(plan, run, folder)) for run in left)
        else:
            ended = in_processes(plan, left, folder, count)
        problems = _conduct(archive, ended, rows, total, heard)
        of_runs = [rows.get(run.name, []) for run in design.runs]
        _warn(of_runs, problems)
    data = dataset_of(design, of_runs, [problems.get(run.name, Problem()) for run in design.runs])
    return data.assign_attrs(study=plan.study, store="" if store is None else str(folder))


def _conduct(
    archive: Archive, ended: Ended, rows: dict[str, Rows], total: int, listeners: Sequence[Listener]
) -> dict[str, Problem]:
    """Collect the rows of runs as they end; return why some have no results."""
    start, found, problems = perf_counter(), len(rows), dict[str, Problem]()

    def tell() -> None:
        done = len(rows) + len(problems)
        failed = sum(not problem.is_elsewhere for problem in problems.values())
        progress = StudyProgress(done, total, failed, found, perf_counter() - start)
        for listener in listeners:
            listener(progress)

    tell()
    with contextlib.closing(ended), warnings.catch_warnings():
        warnings.simplefilter("ignore", LoadFactorWarning)  # One warning stands for all runs.
        for run, problem in ended:
            if not problem:
                of_run = archive.rows(archive.folder / f"{run.name}.h5")
                problem = Problem(of_run[0]["problem"])
            if problem:
                problems[run.name] = problem
            else:
                rows[run.name] = of_run
            tell()
    return problems


def _warn(rows: Sequence[Rows], problems: Mapping[str, Problem]) -> None:
    failed = [(name, problem) for name, problem in problems.items() if not problem.is_elsewhere]
    if elsewhere := len(problems) - len(failed):
        msg = (
            f"study: another study is carrying out {elsewhere} of {counted(len(rows), 'run')}; run the study again "
            "when the other has ended"
        )
        warnings.warn(msg, StudyWarning, stacklevel=3)
    if failed:
        name, why = failed[0]
        msg = (
            f"study: {len(failed)} of {counted(len(rows), 'run')} failed, {name}: {why}. The variable problem tells "
            "of each; they are tried again when the study is run again"
        )
        warnings.warn(msg, StudyWarning, stacklevel=3)
    jammed = [
        row
        for of_run in rows
        for row in of_run
        if row["flow"] == Flow.NONASSOCIATIVE
        and row["status"] != Status.UNBOUNDED
        and np.isposinf(row.get("associative_load_factor", np.nan))
    ]
    if jammed:
        msg = (
            f"study: {counted(len(jammed), 'result')} without an associative bound: what the joints carry depends on "
            f"how firmly the blocks are jammed: {jammed[0]['path']}, case {jammed[0]['case']!r} for one; see its "
            "warnings"
        )
        warnings.warn(msg, StudyWarning, stacklevel=3)


def _folder(store: str | Path) -> Path:
    folder = Path(store).absolute()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        msg = f"{folder} is not a folder to write to ({error.strerror or error}); choose another store"
        raise StorageError(msg) from error
    return folder


def _workers(workers: Any, runs: int) -> int:
    if workers is None:
        available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return min(available, runs)
    return min(checked_count(workers, 1, "study: workers"), runs)
