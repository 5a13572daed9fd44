"""What a load factor in a report owes to the curve of its pushover."""

from collections.abc import Sequence

import xarray as xr

import blockstruct as bs
from blockstruct.vocabulary import counted

#: Difference of the first load factor of a curve from the one it stands beside, relative to that, that is told.
_APART = 0.005
#: Curves that the first page of a report has room for.
_LISTED = 3


def beginning_words(result: bs.CaseResult) -> str:
    """Return where the curve of a pushover begins, if not at the load factor; else empty."""
    if result.capacity is None:
        return ""
    first, load_factor = _first(result.capacity), result.load_factor
    # False for a load factor that is NaN.
    if not abs(first - load_factor) > _APART * abs(load_factor):
        return ""
    rounded = isinstance(result.case, bs.Pushover) and result.case.corner_rounding
    return f"the curve{' of rounded corners' if rounded else ''} begins at {first:.4g}"


def curve_sentences(analysis: bs.Analysis, relied_on: str, checked: Sequence[str], told: Sequence[str]) -> list[str]:
    """Of the curves of cases that are relied on or checked, or that begin below the number relied on, a sentence each.

    It says where a curve begins and ends, and the first thing of it that is to be looked at, unless that is told.
    """
    heads = analysis.headlines
    curves = {name: curve for name in heads if (curve := analysis[name].capacity) is not None}
    names = [name for name in dict.fromkeys([relied_on, *checked]) if name in curves]
    names += [
        name
        for name, curve in curves.items()
        if name not in names and beginning_words(analysis[name]) and _first(curve) < heads[relied_on].load_factor
    ]
    said = []
    for name in names[:_LISTED]:
        curve, procedure = curves[name], analysis[name].settings.procedure
        breaks = bs.results.breaking_words(curve)
        looked_at = [*bs.results.doubtful_words(curve, procedure), *breaks][:1]
        clauses = [beginning_words(analysis[name]), analysis[name].curve_ended]
        clauses += [text for text in looked_at if not any(text in note for note in told)]
        # The last of several may be the one at which SLV ends.
        clauses += ["further breaks of ties are told below"] if breaks[1:] and looked_at == breaks[:1] else []
        if any(clauses):
            said.append(f"Pushover “{name}”: {'; '.join(filter(None, clauses))}.")
    more = len(names) - _LISTED
    return [*said, f"Of {counted(more, 'more pushover')} the curves are told below."] if more > 0 else said


def _first(curve: xr.Dataset) -> float:
    """Load factor at which a curve begins."""
    return float(curve["load_factor"][0])
