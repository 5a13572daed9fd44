"""Find the finished runs of a study in its store."""

import math
from collections.abc import Mapping
from typing import Any

from blockstruct.analysis.planning import runs_of
from blockstruct.errors import BlockstructError, StorageError, shown
from blockstruct.results import Analysis, plain_value
from blockstruct.storage import Archive, is_unfinished, open_analysis, planned_analysis
from blockstruct.studies.design import Design, Run
from blockstruct.studies.plan import Plan
from blockstruct.studies.task import values_of
from blockstruct.vocabulary import counted

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
        is_killed = is_unfinished(path)
        if not is_killed and not path.is_file():
            continue
        try:
            kept = planned_analysis(path) if is_killed else open_analysis(path)
        except BlockstructError as error:
            msg = f"{error}; move it away, then run the study again"
            raise StorageError(msg) from error
        if why := _difference(run, kept, plan):
            others[run.name] = why
        elif not is_killed and kept.status == "finished":
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
        if not _same(due, found):
            of_unit = "" if unit in ("", "dimensionless") else f" {unit}"
            return (
                f"was made with {name} {shown(found)}{of_unit}, but its name stands for {shown(due)}{of_unit}: it was "
                "renamed or copied. Give it its own name back"
            )
    try:
        model, cases = plan.model_and_cases(values_of(run.stored))
    except Exception as error:
        return f"cannot be compared: build fails now ({error})"
    due = [(each.case, each.settings) for each in runs_of(cases, plan.settings, plan.schedules)]
    if model.hash != kept.model.hash or due != [(result.case, result.settings) for result in kept.values()]:
        return "is of another model, other cases or other settings than this study has"
    return ""


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, int | float):
        # The same quantity in two units may differ by rounding.
        return math.isclose(one, other, rel_tol=1e-9)
    return bool(one == other)
