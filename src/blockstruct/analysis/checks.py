"""Checks of cases before anything is solved."""

import warnings
from collections.abc import Sequence

from blockstruct.errors import GeometryError, ModelError, UnusualValueWarning
from blockstruct.limit import LimitProblem
from blockstruct.model import Case, Model, Pushover, RecordCase, check_unrepeated, has_curve
from blockstruct.motion import check_moving_case, check_record
from blockstruct.statics import MovingStructure, Statics
from blockstruct.storage import patterns


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
