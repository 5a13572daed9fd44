"""Checks of local mechanisms in a report, and their notes."""

from collections.abc import Iterable, Sequence
from typing import Any

import blockstruct as bs
from blockstruct.text import report
from blockstruct.views.report.pictures import capacity_picture

Check = bs.assess.LocalMechanismCheck


class Notes:
    """Texts in the order in which they are first cited."""

    def __init__(self) -> None:
        self._number: dict[str, int] = {}

    def numbers(self, texts: Iterable[str]) -> list[int]:
        """Return the numbers of notes, and list those that are new."""
        return [self._number.setdefault(text, len(self._number) + 1) for text in texts]

    def listed(self) -> list[tuple[int, str]]:
        """Return the number and the text of every note."""
        return [(number, text) for text, number in self._number.items()]


def checked(analysis: bs.Analysis, checks: Iterable[Check]) -> list[tuple[str, Check]]:
    """Return each check with its case. Equal checks count once.

    Raises
    ------
    ModelError
        If an argument is not a check, or a check belongs to another model, to a case that the analysis does not have,
        or to another load factor than the report's.
    """
    given = tuple(checks) if isinstance(checks, Iterable) else (checks,)
    if not isinstance(checks, Iterable) or not all(isinstance(check, Check) for check in given):
        msg = (
            f"report of {analysis.model.name!r}: checks: {', '.join(type(each).__name__ for each in given)}; give a "
            "list of what assess.local_mechanism returns, as in checks=[check]"
        )
        raise bs.errors.ModelError(msg)
    runs = {name: name for name in analysis.headlines}
    for case, spread in analysis.spreads.items():
        runs |= dict.fromkeys((r.name for r in spread.results.values()), case)
    checks_by_name: dict[tuple[str, str], Check] = {}
    for check in given:
        name = check.result.name
        if check.result.model.hash != analysis.model.hash or name not in runs:
            msg = (
                f"report of {analysis.model.name!r}: the check is of case {name!r} of model "
                f"{check.result.model.name!r}, which is not part of it; check a result of this analysis"
            )
            raise bs.errors.ModelError(msg)
        case, spreads = runs[name], analysis.spreads
        relied = (spreads[case].relied_on if case in spreads else analysis[case]).load_factor
        if check.result.load_factor not in (relied, analysis[case].load_factor):
            msg = (
                f"report of {analysis.model.name!r}: the check is of the load factor {check.result.load_factor:.4g}, "
                f"but {case!r} has {relied:.4g}; check analysis.spread({case!r})"
            )
            raise bs.errors.ModelError(msg)
        # Of two checks that print the same, keep one, whichever was made first.
        checks_by_name.setdefault((runs[name], str(check)), check)
    return [(case, check) for (case, _), check in checks_by_name.items()]


def undemanded(analysis: bs.Analysis) -> str:
    """Return what an analysis without a check leaves open."""
    settles = all(isinstance(result.case, bs.SettlementCase) for result in analysis.values())
    return report.NO_DEMAND_OF_REACTION if settles and len(analysis) else report.NO_DEMAND


def verification(name: str, check: Check, notes: Notes) -> dict[str, Any]:
    """Return verdict, notes, picture and every formula of a check."""
    verdict = check.verdict
    return {
        "name": name,
        "verdict": str(verdict),
        # The status of an unsettled case has more detail.
        "missed": not (check.satisfied or check.result.drifts),
        "ratio": verdict.state.ratio_text(),
        "state": check.relied_on,
        "e_star": f"{verdict.governing.e_star:.3g}",
        "a0_star": f"{check.acceleration:.4g} m/s²",
        "notes": notes.numbers(note.text for note in check.notes),
        "picture": {"is_detail": check.method == "linear", **picture} if (picture := capacity_picture(check)) else None,
        "sections": [
            {
                "title": part.title,
                "lines": [(line.what, line.formula, line.source) for line in part.lines],
                "is_detail": part.is_detail,
            }
            for part in check.sections
        ],
    }


def shared_sections(found: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Remove the sections that all checks share, spectrum and coefficients, and return them once."""
    if not found:
        return []
    first, *others = (check["sections"] for check in found)
    shared = [part for part in first if all(part in sections for sections in others)] if others else []
    for check in found:
        check["sections"] = [part for part in check["sections"] if part not in shared]
    return shared
