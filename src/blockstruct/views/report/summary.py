"""The number that a report relies on, and what an engineer must see with it on one page."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import blockstruct as bs
from blockstruct.views.report.pictures import mechanism_picture
from blockstruct.views.report.pushovers import beginning_words, curve_sentences

Check = bs.assess.LocalMechanismCheck

#: Statuses without a load factor, from the one that is proven to fall down to those that nothing is known of.
_WORST_FIRST = (bs.Status.UNSTABLE, bs.Status.SELF_STRESS, bs.Status.NOT_CONVERGED, bs.Status.INTERRUPTED)
#: Other checks that miss their demand that the first page has room for.
_LISTED = 8
#: Pushes up to which they are no compass.
_FEW = 2


def relied_on(analysis: bs.Analysis, checks: Sequence[tuple[str, Check]]) -> dict[str, Any]:
    """The case that governs, its number in words and its picture.

    A case that is pushed and has no load factor governs, whatever the checks of others; else the check that bears the
    least share of its site's ground acceleration, of those that are not satisfied if there are any; without checks the
    case with the lowest load factor; settlements govern where nothing else was asked for.
    """
    heads = analysis.headlines
    loaded = {name: head for name, head in heads.items() if not head.answer.is_reaction} or heads
    name, check = _governing(loaded, checks)
    if name is None:
        said = "The analysis has no case."
        nothing = {"name": "", "sentence": said, "between": "", "curves": [], "figures": [], "notes": []}
        return nothing | {"picture": None, "holds": None}
    head = heads[name]
    result = analysis[name]
    begins = beginning_words(result)
    notes = list(check.notes) if check else []
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
        figures += [
            {
                "what": "capacity / demand",
                "number": _ratio(check),
                "more": [check.relied_on, check.outcome],
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
        "curves": curve_sentences(analysis, name, [case for case, _ in checks], notes),
        "figures": figures,
        "picture": mechanism_picture(result, small=True),
        "holds": _holds(result, check),
        "notes": _missed([item for item in checks if item[1] is not check]) + notes,
    }


def _governing(
    heads: Mapping[str, bs.results.Headline], checks: Sequence[tuple[str, Check]]
) -> tuple[str | None, Check | None]:
    """Name of the case that governs, and its check if that does."""
    without = [name for name, head in heads.items() if np.isnan(head.load_factor)]
    if without:
        # Worse than any number, and than any check of another case.
        return min(without, key=lambda name: _WORST_FIRST.index(heads[name].status)), None
    if checks:
        # One that bears more may not be satisfied by what a note says to rely on.
        return min(checks, key=lambda item: (item[1].satisfied, _share(item[1])))
    return min(heads, key=lambda name: heads[name].load_factor, default=None), None


def _holds(result: bs.CaseResult, check: Check | None) -> bool | None:
    """Return whether what governs is satisfied; never without a settled load factor, None if unchecked."""
    if np.isnan(result.load_factor) or result.drifts:
        return False
    return None if check is None else check.satisfied


def _sentence(
    name: str, head: bs.results.Headline, check: Check | None, cases: int, checks: Sequence[Check], *, mixed: bool
) -> str:
    if not np.isfinite(head.load_factor):
        other = "" if cases == 1 else f", the worst of {cases} cases"
        said = f"There is no {head.answer.name} to rely on: “{name}” {head.status.predicate}{other}."
        if not checks:
            return said
        checked = len(checks)
        of_others = "The check of another case says" if checked == 1 else f"The {checked} checks of other cases say"
        return f"{said} The verification is not satisfied. {of_others} nothing of it."
    worst = "largest" if head.answer.is_reaction else "lowest"
    if check is None:
        among = f"one of {cases} cases, forces and moments" if mixed else f"the {worst} of {cases} cases"
        of_cases = f", {among}" if cases > 1 else ""
        said = f"Relied on: {head.answer.name} {head.number} of “{name}”{of_cases}."
        return f"{said} It is checked against no demand."
    least = _share(check) <= min(map(_share, checks))
    governs = "bears the least share of its site's ground acceleration" if least else "is not satisfied"
    of_checks = f", which of {len(checks)} checks {governs}" if len(checks) > 1 else ""
    return (
        f"Relied on: capacity / demand {_ratio(check)} of “{name}” ({check.relied_on}){of_checks}, from its load "
        f"factor {head.number}."
    )


def _between(analysis: bs.Analysis) -> str:
    """What no direction is below, those between the ones that were run included, or that it is not known."""
    try:
        of_cases = bs.studies.Directions.each_of(analysis)
        around = of_cases or [("", bs.studies.Directions.of(analysis))]
    except bs.errors.ModelError:
        return ""
    said = [
        f"{found.least_between:.4g} between those {f'of “{name}”' if name else 'that were run'}"
        for name, found in around
        if np.isfinite(found.least_between)
    ]
    told = [f"With associative flow no direction is below load factor {', '.join(said)}."] if said else []
    # Two pushes that no case with directions made are no compass.
    missed = {found.uncovered for name, found in around if name or found.data.sizes["direction"] > _FEW}
    told += [f"Directions between those that were run {said}." for said in sorted(missed - {""})]
    return " ".join(told)


def _missed(others: Sequence[tuple[str, Check]]) -> list[str]:
    """Of checks that do not govern those whose capacity is below the demand, or that are not satisfied, in words."""
    missed = [(name, check) for name, check in others if check.ratio < 1 or not check.satisfied]
    if not missed:
        return []
    missed.sort(key=lambda item: item[1].ratio)
    said = [f"{_ratio(check)} of “{name}” ({check.relied_on}), {check.outcome}" for name, check in missed[:_LISTED]]
    if len(missed) > _LISTED:
        said.append(f"and {len(missed) - _LISTED} more, in the verification below")
    return [f"Other checks: capacity / demand {'; '.join(said)}."]


def _share(check: Check) -> float:
    """Ground acceleration borne over that of the site."""
    return check.ag / check.limit_state.ag_site


def _ratio(check: Check) -> str:
    return check.limit_state.ratio_text()
