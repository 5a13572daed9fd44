"""Runs of a study that are there already: whether they are its own."""

import math
from collections.abc import Mapping
from typing import Any

from blockstruct.errors import StorageError, shown
from blockstruct.results import Analysis, plain_value
from blockstruct.storage import Archive, is_unfinished, open_analysis, planned_analysis
from blockstruct.studies.design import Design, Run
from blockstruct.studies.plan import Plan
from blockstruct.studies.task import values_of
from blockstruct.vocabulary import Status, counted

#: Rows of the archive of one run, by the names of all columns.
Rows = list[dict[str, Any]]


def found_runs(archive: Archive, design: Design, plan: Plan) -> tuple[dict[str, Rows], dict[str, str]]:
    """Rows of the runs that are done; and files under the names of runs that are not these, with why.

    Raises
    ------
    StorageError
        If the file of a run cannot be read.
    """
    rows: dict[str, Rows] = {}
    others: dict[str, str] = {}
    own, changed = list[Run](), list[Run]()
    for run in design.runs:
        path = archive.folder / f"{run.name}.h5"
        if is_unfinished(path):
            if why := _not_gone_on_with(run, planned_analysis(path), plan):
                others[run.name] = why
            continue
        if not path.is_file():
            continue
        of_run = archive.rows(path)
        if of_run[0]["problem"]:
            msg = f"{path}: {of_run[0]['problem']}; move it away, then run the study again"
            raise StorageError(msg)
        if why := _misnamed(run, of_run[0]):
            others[run.name] = why
            continue
        whose = of_run[0].get("study", "")
        done = all(row["status"] != Status.INTERRUPTED for row in of_run)
        if whose == plan.study:
            if not done:
                if why := _not_gone_on_with(run, open_analysis(path), plan):
                    others[run.name] = why
                continue
            own.append(run)
        elif done and plan.differs_by_source(whose):
            changed.append(run)
        else:
            others[run.name] = _of_another(whose or "no study", plan)
            continue
        rows[run.name] = of_run
    # What build calls may be another although its own source is the same.
    ends = [own[k] for k in sorted({0, len(own) - 1}) if own]
    if any(_differs(run, _finished(archive, run), plan) for run in ends):
        others |= {run.name: _rebuilt(plan) for run in own}
    differing = [run for run in changed if _differs(run, _finished(archive, run), plan)]
    others |= {run.name: _of_another(rows[run.name][0]["study"], plan) for run in differing}
    return {name: of_run for name, of_run in rows.items() if name not in others}, others


def told(archive: Archive, others: Mapping[str, str]) -> str:
    """Why files of other runs are not taken over."""
    name, why = next(iter(others.items()))
    return (
        f"study: {archive.folder} has {counted(len(others), 'run')} of these parameters, by name, but not of this "
        f"study: {name}.h5 {why}. Choose another store, or run anew with rerun=True"
    )


def _of_another(whose: str, plan: Plan) -> str:
    return f"is of {whose}; this is {plan.study}"


def _rebuilt(plan: Plan) -> str:
    return f"is of another model or other cases than {plan.study} makes now"


def _finished(archive: Archive, run: Run) -> Analysis:
    return open_analysis(archive.folder / f"{run.name}.h5")


def _not_gone_on_with(run: Run, begun: Analysis, plan: Plan) -> str:
    """Why a run that was killed or interrupted is not gone on with; empty if it is.

    Going on, nothing is built anew: it would end with the model that it began with.
    """
    if begun.study != plan.study:
        return _of_another(begun.study or "no study", plan)
    kept = {f"parameter_{name}": plain_value(value)[0] for name, value in begun.parameters.items()}
    return _misnamed(run, kept) or (_rebuilt(plan) if _differs(run, begun, plan) else "")


def _misnamed(run: Run, row: Mapping[str, Any]) -> str:
    """What tells that a file was made with other values than those its name stands for; empty if it was not."""
    for name, value in run.values.items():
        (due, unit), kept = plain_value(value), row.get(f"parameter_{name}")
        if not _same(due, kept):
            of_unit = "" if unit in ("", "dimensionless") else f" {unit}"
            return (
                f"was made with {name} {shown(kept)}{of_unit}, but its name stands for {shown(due)}{of_unit}: it was "
                "renamed or copied. Give it its own name back"
            )
    return ""


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, int | float):
        # The same quantity in two units may differ by rounding.
        return math.isclose(one, other, rel_tol=1e-9)
    return bool(one == other)


def _differs(run: Run, analysis: Analysis, plan: Plan) -> bool:
    """Whether build now makes another model or other cases than an analysis has."""
    try:
        model, cases = plan.model_and_cases(values_of(run.stored))
    except Exception:  # It is not known to make the same; the runs that are left tell why.
        return True
    kept = {case.name: case for case in analysis.cases}
    if model.hash != analysis.model.hash or not (plan.schedules or len(kept) == len(cases)):
        return True
    return any(kept.get(case.name) != case for case in cases)
