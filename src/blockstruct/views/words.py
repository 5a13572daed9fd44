"""Statuses and certificates in words, as a report says them."""

from collections.abc import Iterable

import numpy as np

import blockstruct as bs
from blockstruct.vocabulary import counted

#: Ties that hold in a pushover that are told one by one.
_LISTED = 5
#: Statuses whose history may still hold an admissible state.
_WITHOUT_STATE = (bs.Status.NOT_CONVERGED, bs.Status.INTERRUPTED)


def status_words(result: bs.CaseResult) -> str:
    """How a case ended, as a sentence: its number, how it was found, and its limits."""
    text = str(result.headline)
    return f"{text[:1].upper()}{text[1:]}."


def range_words(result: bs.CaseResult) -> str:
    """The reactions that statics allows, as a sentence; empty if the case is not a settlement."""
    if not isinstance(result.case, bs.SettlementCase) or not result.n_iterations:
        return ""
    least, largest = (float(end) for end in result.reaction_range.magnitude)
    ends = [result.answer.said(least, beside=largest), result.answer.said(largest, beside=least)]
    if "none" in ends:
        return ""
    return f"Statics allows reactions from {ends[0]} to {ends[1]} under the dead load."


def warning_words(result: bs.CaseResult) -> str:
    """Return what must stand next to the load factor, as one paragraph; empty as a rule."""
    return " ".join([*result.warnings, *result.owed])


def spread_words(spread: bs.Spread) -> str:
    """A sentence on the certified answers of the schedules of a spread."""
    ends, answer = [r.load_factor for r in spread.runs.values() if r.settled], spread.headline.answer
    said = f"{len(ends)} of {counted(len(spread.runs), 'schedule')} settled at a certified {answer.name}"
    if ends:
        texts = dict.fromkeys(answer.ends((min(ends), max(ends))))
        said += f", {' to '.join(texts)}"
    return f"{said}."


def admissible_words(result: bs.CaseResult) -> str:
    """What a case without a load factor leaves behind: its best admissible state, named as a bound; or nothing."""
    state = result.admissible_state if result.status in _WITHOUT_STATE else None
    if state is None:
        return ""
    answer, unit = result.answer, _gap_unit(result)
    sought, bound = ("least reaction", "an upper") if answer.is_reaction else ("collapse load factor", "a lower")
    meaning = (
        f"{bound} bound of the {sought}"
        if result.case.flow is bs.Flow.ASSOCIATIVE
        else f"no {sought}, and without dilatancy no {bound.split()[1]} bound of it either"
    )
    return (
        f"Forces in equilibrium that no joint refuses were found at {answer.name} {answer.text(state.load_factor)} "
        f"(iteration {state.iteration}); they miss the flow rule by {state.certificate.flow_rule_gap:.1e} in units of "
        f"{unit}. It is {meaning}."
    )


def _gap_unit(result: bs.CaseResult) -> str:
    return f"the {'dead load' if result.answer.is_reaction else 'load factor'}"


def tie_words(result: bs.CaseResult) -> list[str]:
    """What each tie does in the last iteration, a sentence each; none where the solver found no forces."""
    if not (result.model.ties and result.n_iterations):
        return []
    found = np.isfinite(result.history["tie_force"].isel(iteration=-1)).all()
    return bs.results.tie_sentences(result.history) if found else []


def pushover_words(result: bs.CaseResult) -> list[str]:
    """Return what a pushover found beyond collapse, a sentence each: states, end and ties, or why it has no curve."""
    curve = result.capacity
    if curve is None or not isinstance(result.case, bs.Pushover):
        return [f"There is no capacity curve: {result.missing_curve}."] if result.missing_curve else []
    n, certified = curve.sizes["step"], int(curve["holds"].sum())
    block, direction = result.case.control
    along = f"on {block} along ({', '.join(f'{round(d, 4):g}' for d in direction)})"
    reached = 1e3 * float(curve["displacement"][-1])
    if n == 1:
        found = f"1 state was found, {'certified' if certified else 'not certified'},"
    else:
        found = f"{n} states were found, {'all' if certified == n else certified} of them certified,"
    states = f"Beyond collapse {found} up to a displacement of {reached:.4g} mm of the control point {along}"
    told = bs.results.breaking_words(curve) + bs.results.doubtful_words(curve, result.settings.procedure)
    said = [states, result.curve_ended, *told]
    if "tie_force" in curve:
        names = [str(name) for name in curve["tie"].to_numpy()]
        held = np.flatnonzero(np.isnan(curve["tie_break_displacement"]))
        longest, largest = (curve[name].max("step").to_numpy() for name in ("tie_elongation", "tie_force"))
        said += [
            f"{bs.results.tie_title(names[k])} holds: it gets longer by at most {1e3 * longest[k]:.4g} mm, under "
            f"{largest[k] / 1e3:.4g} kN at most"
            for k in held[:_LISTED]
        ]
        if len(held) > _LISTED:
            more = len(held) - _LISTED
            said.append(f"{more} more hold{'s' * (more == 1)}, too")
    return [f"{text[:1].upper()}{text[1:]}." for text in said if text]


def without_curve_words(result: bs.CaseResult) -> str:
    """Why a result has no capacity curve, and what to do, as the end of a message."""
    said = f"no capacity curve, {result.missing_curve or result.headline}"
    return said if isinstance(result.case, bs.Pushover) else f"{said}; run a Pushover"


def cells_of(results: Iterable[bs.CaseResult]) -> list[str]:
    """Sentences on joints that crush in cells, each once; one case tells of all like it with its settings."""
    alike = {(r.settings.crushing_cells, r.answer.is_reaction): r for r in results if r.n_iterations}
    return list(dict.fromkeys(filter(None, (r.cells for r in alike.values()))))


def certificate_words(result: bs.CaseResult) -> str:
    """A sentence on why to believe a result, with the measures of its certificate."""
    found = result.certificate
    if found is None:
        return "There is no certificate."
    if result.status is bs.Status.UNSTABLE:
        verdict = "is proven" if found.holds else "is not proven"
        return f"A mechanism {verdict} in which the dead load alone does work."
    if result.status is bs.Status.SELF_STRESS:
        verdict = "is certified" if found.holds else "is not certified"
        return f"A collapse state of the dead load alone {verdict} within the tolerances."
    loaded = "no joint and no tie" if result.model.ties else "no joint"
    (residual, of_residual), (excess, of_excess), (depth, of_depth), (gap, of_gap) = found.texts.values()
    return (
        f"The {found.verdict}: equilibrium is met to {residual} (tolerance {of_residual}) of the dead load of a block, "
        f"{loaded} is loaded beyond its strength by more than {excess if found.yield_excess > 0 else 0} ({of_excess}), "
        f"blocks penetrate by at most {depth} ({of_depth}) of the largest motion, and the flow rule is missed by "
        f"{gap} ({of_gap}) in units of {_gap_unit(result)}."
    )
