"""Sentences on the curves of pushovers, for the first page of a report."""

from collections.abc import Sequence

import xarray as xr

import blockstruct as bs
from blockstruct.text import report

#: Relative difference between the first load factor of a curve and the load factor of its case that is reported.
_APART = 0.005
#: Curves that the first page of a report has room for.
_LISTED = 3


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
        doubts = bs.results.doubtful_words(curve, procedure)
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
