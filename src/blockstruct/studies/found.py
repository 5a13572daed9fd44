"""Runs of a study that are there already: whether they are its own."""

from collections.abc import Mapping
from typing import Any

from blockstruct.errors import StorageError
from blockstruct.storage import Archive, is_unfinished, open_analysis, study_under_way
from blockstruct.studies.design import Design, Run
from blockstruct.studies.plan import Plan
from blockstruct.studies.task import values_of
from blockstruct.vocabulary import Status

#: Rows of the archive of one run, by the names of all columns.
Rows = list[dict[str, Any]]


def found_runs(archive: Archive, design: Design, plan: Plan) -> tuple[dict[str, Rows], dict[str, str]]:
    """Rows of the runs that are done; and those that are of another study, with what they are of.

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
            if (whose := study_under_way(path)) != plan.study:
                others[run.name] = whose
            continue
        if not path.is_file():
            continue
        of_run = archive.rows(path)
        if of_run[0]["problem"]:
            msg = f"{path}: {of_run[0]['problem']}; move it away, then run the study again"
            raise StorageError(msg)
        whose = of_run[0].get("study", "")
        done = all(row["status"] != Status.INTERRUPTED for row in of_run)
        if whose == plan.study:
            if not done:
                continue  # It is gone on with.
            own.append(run)
        elif done and plan.differs_by_source(whose):
            changed.append(run)
        else:
            others[run.name] = whose or "no study"
            continue
        rows[run.name] = of_run
    # What build calls may be another although its own source is the same.
    ends = [own[k] for k in sorted({0, len(own) - 1}) if own]
    if any(_differs(run, archive, plan) for run in ends):
        others |= {run.name: f"another model or other cases than {plan.study} makes now" for run in own}
    others |= {run.name: rows[run.name][0]["study"] for run in changed if _differs(run, archive, plan)}
    return {name: of_run for name, of_run in rows.items() if name not in others}, others


def told(archive: Archive, others: Mapping[str, str], plan: Plan) -> str:
    """Why runs of another study are not taken over."""
    name, whose = next(iter(others.items()))
    return (
        f"study: {archive.folder} has {len(others)} runs of these parameters that are not of this study: {name}.h5 is "
        f"of {whose}; this is {plan.study}. Choose another store, or run them anew by rerun=True"
    )


def _differs(run: Run, archive: Archive, plan: Plan) -> bool:
    """Whether build now makes another model or other cases than a file has."""
    analysis = open_analysis(archive.folder / f"{run.name}.h5")
    try:
        model, cases = plan.model_and_cases(values_of(run.stored))
    except Exception:  # It is not known to make the same; the runs that are left tell why.
        return True
    kept = {case.name: case for case in analysis.cases}
    if model.hash != analysis.model.hash or not (plan.schedules or len(kept) == len(cases)):
        return True
    return any(kept.get(case.name) != case for case in cases)
