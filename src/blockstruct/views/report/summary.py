"""The first page of a report: the number to rely on, and what to know with it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

import blockstruct as bs
from blockstruct.text import NoteCode, report
from blockstruct.views.report.pictures import mechanism_picture, relied_motion
from blockstruct.views.report.verification import Notes

Check = bs.assess.LocalMechanismCheck

#: Statuses without a load factor, the proven collapse first.
_WORST_FIRST = (
    *(bs.Status.UNSTABLE, bs.Status.SELF_STRESS, bs.Status.COLLAPSES, bs.Status.UNDECIDED),
    *(bs.Status.NOT_CONVERGED, bs.Status.INTERRUPTED),
)
#: Relative difference between the first load factor of a curve and the load factor of its case that is reported.
_APART = 0.005
#: Curves that the first page of a report has room for.
_LISTED = 3
#: Pushes up to which no compass is drawn.
_FEW = 2


def relied_on(analysis: bs.Analysis, checks: Sequence[tuple[str, Check]], noted: Notes) -> dict[str, Any]:
    """Return the governing case, with its number in words and its picture.

    A pushed case without a load factor governs, whatever the other checks. Otherwise the check with the least share of
    its site's ground acceleration governs. Without checks, the case with the lowest load factor governs. Settlements
    govern only if there are no other cases.
    """
    heads = analysis.headlines
    loaded = {name: head for name, head in heads.items() if not head.answer.is_reaction} or heads
    name, check = _governing(loaded, checks)
    if name is None:
        nothing = {
            "name": "",
            "sentence": report.NO_CASE,
            "between": "",
            "curves": [],
            "figures": [],
            "notes": [],
            "missed": [],
        }
        return nothing | {"picture": None, "holds": None}
    head = heads[name]
    result = analysis[name]
    begins = beginning_words(result)
    of_check = [note.text for note in check.notes] if check else []
    texts = [*result.warnings, *result.owed, *of_check]
    has_doubt_note = check is not None and any(note.code is NoteCode.CURVE_DOUBT for note in check.notes)
    mixed = len({one.answer.dimension for one in loaded.values()}) > 1
    figures = [
        {
            "what": f"{head.answer.name} {head.answer.symbol}",
            "number": head.number,
            "more": ["NOT SETTLED" * result.drifts, begins, head.range, head.bound, f"{head.flow} flow"],
        }
    ]
    if check is not None:
        borne, site = check.limit_state.ag_texts()
        verdict = check.verdict
        figures += [
            {
                "what": "capacity / demand",
                "number": _ratio(check),
                "more": [check.relied_on, check.outcome, verdict.figures],
            },
            {
                "what": "ground acceleration borne",
                "number": borne,
                "more": [f"site {site}", f"e* = {check.e_star:.3g}, FC = {check.confidence_factor:g}"],
            },
        ]
    return {
        "name": name,
        "sentence": _sentence(name, head, check, len(loaded), [one for _, one in checks], mixed=mixed),
        "between": "" if np.isnan(head.load_factor) else _between(analysis),
        "curves": curve_sentences(analysis, name, [case for case, _ in checks], has_doubt_note=has_doubt_note),
        "figures": figures,
        "picture": mechanism_picture(relied_motion(check) if check else result),
        "holds": _holds(result, [one for _, one in checks]),
        "missed": _missed([item for item in checks if item[1] is not check]),
        "notes": list(dict(zip(noted.numbers(texts), texts, strict=True)).items()),
    }


def _governing(
    heads: Mapping[str, bs.results.Headline], checks: Sequence[tuple[str, Check]]
) -> tuple[str | None, Check | None]:
    """Return the name of the governing case, and its check if that governs."""
    without = [name for name, head in heads.items() if head.status in _WORST_FIRST]
    if without:
        # It is worse than any number, and than any check of another case.
        return min(without, key=lambda name: _WORST_FIRST.index(heads[name].status)), None
    if checks:
        return min(checks, key=lambda item: item[1].verdict.share)
    # A record that the structure stands has no number.
    numbered = [name for name, head in heads.items() if head.status is not bs.Status.STANDS] or heads
    return min(numbered, key=lambda name: heads[name].load_factor, default=None), None


def _holds(result: bs.CaseResult, checks: Sequence[Check]) -> bool | None:
    """Return whether every check is satisfied; None without a check.

    It is False if the governing case has no settled load factor.
    """
    if result.status is bs.Status.STANDS:
        return True
    if np.isnan(result.load_factor) or result.drifts:
        return False
    return all(check.satisfied for check in checks) if checks else None


def _sentence(
    name: str, head: bs.results.Headline, check: Check | None, cases: int, checks: Sequence[Check], *, mixed: bool
) -> str:
    if not np.isfinite(head.load_factor):
        return report.no_number(name, head.status, head.answer, cases=cases, checks=len(checks))
    if check is None:
        return report.number(name, head.number, head.answer, cases=cases, has_mixed_units=mixed)
    return report.ratio(name, check.relied_on, check.ratio, check.verdict.governing.alpha, checks=len(checks))


def _between(analysis: bs.Analysis) -> str:
    """Return the sentences on directions between the computed ones; empty without directions."""
    try:
        of_cases = bs.studies.Directions.each_of(analysis)
        around = of_cases or [("", bs.studies.Directions.of(analysis))]
    except bs.errors.ModelError:
        return ""
    least = [(name, found.least_between) for name, found in around if np.isfinite(found.least_between)]
    # Two pushes are no compass unless a case with directions made them.
    missed = {found.uncovered for name, found in around if name or found.data.sizes["direction"] > _FEW}
    return report.between_directions(least, sorted(missed - {""}))


def _missed(others: Sequence[tuple[str, Check]]) -> list[str]:
    """Return the sentence on other checks whose capacity is below the demand, or that are not satisfied."""
    missed = [(name, check) for name, check in others if check.ratio < 1 or not check.satisfied]
    missed.sort(key=lambda item: item[1].ratio)
    facts = [(name, check.relied_on, check.ratio, check.outcome) for name, check in missed]
    return [report.other_checks(facts)] if facts else []


def _ratio(check: Check) -> str:
    return check.limit_state.ratio_text()


def beginning_words(result: bs.CaseResult) -> str:
    """Return the clause on where the curve of a pushover begins, if not at the load factor; else empty."""
    if result.capacity is None:
        return ""
    first, load_factor = _first(result.capacity), result.load_factor
    # A NaN compares as False.
    if not abs(first - load_factor) > _APART * abs(load_factor):
        return ""
    rounded = isinstance(result.case, bs.Pushover) and result.case.corner_rounding
    return report.curve_begins(result.answer.text(first), is_rounded=bool(rounded))


def curve_sentences(
    analysis: bs.Analysis, relied_on: str, checked: Sequence[str], *, has_doubt_note: bool = False
) -> list[str]:
    """Return a sentence on each curve that matters: relied on, checked, or below the number relied on.

    It states where a curve begins and ends, and its first doubt, unless a note on the case relied on states that.
    """
    heads = analysis.headlines
    curves = {name: curve for name in heads if (curve := analysis[name].capacity) is not None}
    names = [name for name in dict.fromkeys([relied_on, *checked]) if name in curves]
    names += [
        name
        for name, curve in curves.items()
        if name not in names
        and "reaction" not in curve
        and beginning_words(analysis[name])
        and _first(curve) < heads[relied_on].load_factor
    ]
    sentences = []
    for name in names[:_LISTED]:
        curve, procedure = curves[name], analysis[name].settings.procedure
        breaks = bs.results.breaking_words(curve)
        doubts = [str(part) for part in bs.results.doubtful_parts(curve, procedure)]
        clauses = [beginning_words(analysis[name]), analysis[name].curve_ended]
        if doubts:
            clauses += [] if has_doubt_note and name == relied_on else doubts[:1]
        elif breaks:
            # The last of several breaks may be the one at which SLV ends.
            clauses += [breaks[0], *([report.MORE_BREAKS] if breaks[1:] else [])]
        if any(clauses):
            sentences.append(report.curve_sentence(name, list(filter(None, clauses)), settles="reaction" in curve))
    more = len(names) - _LISTED
    return [*sentences, report.more_curves(more)] if more > 0 else sentences


def _first(curve: xr.Dataset) -> float:
    """Return the first load factor of a curve."""
    return float(curve["load_factor"][0])
