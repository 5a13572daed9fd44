"""Sentences on results that console, page and report share."""

from collections.abc import Iterable

import numpy as np

import blockstruct as bs
from blockstruct.text import case as case_text
from blockstruct.text.mechanism import crushed_joints, holding_ties, roller_sentences
from blockstruct.vocabulary import FEW, MOTIONS, listed

#: Statuses whose history may hold an admissible state.
_WITHOUT_STATE = (bs.Status.NOT_CONVERGED, bs.Status.INTERRUPTED)


def status_words(result: bs.CaseResult) -> str:
    """Return the sentence on how a case ended: its number, how it was found, and its limits."""
    return case_text.capitalised(str(result.headline))


def range_words(result: bs.CaseResult) -> str:
    """Return the sentence on the reactions that statics allows; empty unless the case is a settlement."""
    if not isinstance(result.case, bs.SettlementCase) or not result.n_iterations:
        return ""
    least, largest = (float(end) for end in result.reaction_range.magnitude)
    return case_text.statics_range(least, largest, result.answer)


def warning_words(result: bs.CaseResult) -> str:
    """Return the warnings and cautions on a load factor as one paragraph; usually empty."""
    return " ".join([*result.warnings, *result.owed])


def spread_words(spread: bs.results.Spread) -> str:
    """Return the sentence on the load factors of the settled schedules of a spread."""
    settled = [r.load_factor for r in spread.runs.values() if r.settled]
    return case_text.settled_schedules(settled, len(spread.runs), spread.headline.answer)


def admissible_words(result: bs.CaseResult) -> str:
    """Return the sentences on the best admissible state of an unconverged case."""
    state = result.admissible_state if result.status in _WITHOUT_STATE else None
    if state is None:
        return ""
    gap, is_associative = state.certificate.flow_rule_gap, result.case.flow is bs.Flow.ASSOCIATIVE
    return case_text.admissible_state(
        state.load_factor, gap, state.iteration, result.answer, is_associative=is_associative
    )


def tie_words(result: bs.CaseResult) -> list[str]:
    """Return a sentence on each tie in the last iteration; none if the solver found no forces."""
    if not (result.model.ties and result.n_iterations):
        return []
    has_forces = np.isfinite(result.history["tie_force"].isel(iteration=-1)).all()
    return bs.results.tie_sentences(result.history) if has_forces else []


def roller_words(result: bs.CaseResult) -> list[str]:
    """Return a sentence on each support that holds some motions only; none without forces."""
    rollers = [block for block in result.model.blocks if block.is_roller]
    reactions = result.support_reactions.sel(support=[block.name for block in rollers])
    values = np.hstack([reactions["force"].to_numpy(), reactions["moment"].to_numpy()])
    if not np.isfinite(values).all():
        return []
    return roller_sentences(
        {
            b.name: {m: v for m, v in zip(MOTIONS, row, strict=True) if m in b.held}
            for b, row in zip(rollers, values, strict=True)
        }
    )


def pushover_words(result: bs.CaseResult) -> list[str]:
    """Return the sentences on the states beyond collapse: their number, end, ties, or why there is no curve."""
    curve, case = result.capacity, result.case
    if curve is None or not bs.model.has_curve(case):
        return [case_text.no_curve(result.missing_curve)] if result.missing_curve else []
    if isinstance(case, bs.Pushover):
        point, direction = f"the control point on {case.control[0]}", case.control[1]
    else:
        point, direction = listed(case.supports, FEW), case.direction
    reached = float(curve["displacement"][-1])
    clauses = [result.curve_ended, *bs.results.breaking_words(curve)]
    clauses += map(str, result.curve_doubts)
    states, certified = curve.sizes["step"], int(curve["holds"].sum())
    sentences = [case_text.pushed_states(states, certified, reached, point, direction, settles="reaction" in curve)]
    sentences += [case_text.capitalised(clause) for clause in clauses if clause]
    if "largest_crushed_depth" in curve:
        sentences += crushed_joints(float(curve["largest_crushed_depth"].max()))
    if "tie_force" in curve:
        held = curve.isel(tie=np.isnan(curve["tie_break_displacement"].to_numpy()))
        most = (held[name].max("step").to_numpy() for name in ("tie_elongation", "tie_force"))
        sentences += holding_ties(list(zip(held["tie"].to_numpy(), *most, strict=True)))
    return sentences


def response_words(result: bs.CaseResult) -> list[str]:
    """Return the sentences on the response to a record; none for any other case."""
    return [] if result.response is None else bs.results.response_words(result.model, result.response)


def without_curve_words(result: bs.CaseResult) -> str:
    """Return why a result has no capacity curve, and the remedy, as the end of a message."""
    reason = f"no capacity curve, {result.missing_curve or result.headline}"
    remedy = "give it a displacement" if isinstance(result.case, bs.SettlementCase) else "run a Pushover"
    return reason if bs.model.has_curve(result.case) else f"{reason}; {remedy}"


def cells_of(results: Iterable[bs.CaseResult]) -> list[str]:
    """Return the sentences on joints that crush in cells, each once."""
    # Cases with the same cells and the same kind of answer have the same sentence.
    alike = {(r.settings.crushing_cells, r.answer.is_reaction): r for r in results if r.n_iterations}
    return list(dict.fromkeys(filter(None, (r.cells for r in alike.values()))))


def certificate_words(result: bs.CaseResult) -> str:
    """Return the sentences on the certificate of a result, with its measures."""
    return case_text.certificate_sentence(result.certificate, result.status)
