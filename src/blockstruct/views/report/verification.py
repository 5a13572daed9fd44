"""Checks of local mechanisms, as a report hands them in."""

from collections.abc import Sequence
from typing import Any

import blockstruct as bs
from blockstruct.views.report.pictures import capacity_picture, mechanism_picture

Check = bs.assess.LocalMechanismCheck


def checked(analysis: bs.Analysis, checks: Sequence[Check]) -> list[tuple[str, Check]]:
    """The case of each check, which must be of the load factor that the report relies on.

    Raises
    ------
    ModelError
        If a check is of another model, of a case that the analysis does not have, or of another load factor.
    """
    runs = {name: name for name in analysis.headlines}
    for case, spread in analysis.spreads.items():
        runs |= dict.fromkeys((r.name for r in spread.results.values()), case)
    found = []
    for check in checks:
        name = check.result.name
        if check.result.model.hash != analysis.model.hash or name not in runs:
            msg = (
                f"report of {analysis.model.name!r}: the check is of case {name!r} of model "
                f"{check.result.model.name!r}, which is not part of it; check a result of this analysis"
            )
            raise bs.errors.ModelError(msg)
        relied = analysis.headlines[runs[name]].load_factor
        if check.result.load_factor != relied:
            msg = (
                f"report of {analysis.model.name!r}: the check is of the load factor {check.result.load_factor:.4g}, "
                f"but that of {runs[name]!r} is {relied:.4g}; check analysis.spread({runs[name]!r})"
            )
            raise bs.errors.ModelError(msg)
        found.append((runs[name], check))
    return found


def undemanded(analysis: bs.Analysis) -> str:
    """What an analysis without a check leaves open."""
    if any(not isinstance(result.case, bs.SettlementCase) for result in analysis.values()):
        return (
            "a load factor alone does not verify a structure. It is the multiple of the variable load at which the "
            "structure collapses, to be compared with the one that a code demands."
        )
    return (
        "a reaction alone does not verify a structure. It is what is left of the reaction of the supports as the "
        "structure begins to follow them, under the dead load."
    )


def verification(name: str, check: Check) -> dict[str, Any]:
    """Verdict, notes, picture and every formula of a check."""
    return {
        "name": name,
        "verdict": check.verdict,
        "satisfied": check.satisfied,
        "rounded": bs.assess.lines.ROUNDED,
        "notes": list(check.notes),
        "pictures": [mechanism_picture(check.result, small=False), capacity_picture(check)],
        "sections": [
            {"title": part.title, "lines": [(line.what, line.formula, line.source) for line in part.lines]}
            for part in check.sections
        ],
    }
