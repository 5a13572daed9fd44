"""The first page of a report: the number to rely on, and what to know with it; its checks and pictures."""

import base64
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

import blockstruct as bs
from blockstruct.text import report
from blockstruct.text.mechanism import SMALL, motion_clause, smaller_bodies, weight_text
from blockstruct.text.note import Note, NoteCode, Severity
from blockstruct.text.numbers import shown
from blockstruct.views import figures
from blockstruct.views.figures.sheet import Drawing, drawings
from blockstruct.views.selection import compasses, moving_bodies
from blockstruct.views.style import BODY_COLOURS
from blockstruct.vocabulary import FEW, LISTED, CurveDoubt

#: Width and height, inches: the mechanism of a direction is 9 cm high or more, with its legend next to it.
_MECHANISM, _GEOMETRY, _DIAGRAM, _ROW = (4.5, 3.7), (6.3, 3.6), (6.3, 2.9), (1.2, 1.0)


def picture(drawing: Drawing) -> dict[str, Any]:
    """Return the caption of a picture, and the picture as a ``data:`` address."""
    content = base64.b64encode(drawing.picture()).decode("ascii")
    return {"caption": drawing.caption, "address": f"data:image/png;base64,{content}"}


def mechanism_picture(result: bs.CaseResult) -> dict[str, Any] | None:
    """Return the picture of the mechanism with its load, and the legend of its bodies; None without a mechanism.

    The legend lists the heaviest bodies. The others, and bodies below two percent of the moving weight, are one
    entry.
    """
    if not result.moves:
        return None
    drawn = picture(Drawing("mechanism", _moves(result), lambda ax: _draw(ax, result), _MECHANISM))
    return drawn | {"bodies": _bodies(result)}


def _draw(ax: Axes, result: bs.CaseResult) -> None:
    """Draw the mechanism of a case without its legend."""
    figures.mechanism(result, colour="macro-block", ax=ax)
    if legend := ax.get_legend():
        legend.remove()


def small_picture(result: bs.CaseResult) -> dict[str, str]:
    """Return the picture of a mechanism for a row of the table, without texts."""

    def draw(ax: Axes) -> None:
        _draw(ax, result)
        for text in list(ax.texts):
            text.remove()
        # The blocks fill the picture: neither the push nor the axes have room.
        blocks = max((part.get_datalim(ax.transData) for part in ax.collections), key=lambda box: box.width)
        ax.set(xlim=blocks.intervalx, ylim=blocks.intervaly)

    return picture(Drawing("mechanism", _moves(result), draw, _ROW))


def relied_motion(check: bs.assess.LocalMechanismCheck) -> bs.CaseResult:
    """Return the case with the motion that a check relies on, and with the load factor that activates it."""
    result = check.governing
    if not check.alpha0 > 0:
        return result
    load_factor = check.verdict.governing.alpha / check.alpha0 * result.load_factor
    return result.changed(outcome=replace(result.outcome, load_factor=load_factor))


def _bodies(result: bs.CaseResult) -> list[dict[str, str]]:
    """Return colour, name, weight and motion of the moving bodies, the small ones as one."""
    moving = moving_bodies(result, -1)[1]
    whole = sum(body.total for body in moving)
    large = [body for body in moving if body.total >= SMALL * whole][:LISTED]
    rows = [
        {
            "colour": BODY_COLOURS[k % len(BODY_COLOURS)],
            "name": body.name,
            "weight": weight_text(body.total, body.carried),
            "motion": motion_clause(body.translation, body.axis, body.centroid, body.speed),
        }
        for k, body in enumerate(large)
    ]
    small = moving[len(large) :]
    if small:
        weights = (sum(body.total for body in small), sum(body.carried for body in small))
        rows.append(
            {
                "colour": "",
                "name": smaller_bodies(len(small)),
                "weight": weight_text(*weights),
                "motion": "",
            }
        )
    return rows


def geometry_picture(model: bs.Model) -> dict[str, str]:
    """Return the picture of the model with its overall dimensions."""
    caption = "The structure with its overall dimensions; supports are darker"
    return picture(Drawing("geometry", caption, lambda ax: figures.dimensions(model, ax=ax), _GEOMETRY))


def _moves(result: bs.CaseResult) -> str:
    """Return the caption of a mechanism."""
    if bs.vocabulary.Stage(result.history["stage"].to_numpy()[-1]).is_of_dead_load:
        return f"How “{result.name}” moves under its dead load alone, to first order: its bodies in colours"
    answer = f"{result.answer.name} {result.answer.symbol}"
    what = f"the {answer}" if result.answer.is_reaction else f"the variable load and its {answer}"
    if result.status is not bs.Status.CONVERGED:
        return (
            f"Motion of the last iteration of “{result.name}”, without a collapse state: its bodies in colours, "
            f"{what} there"
        )
    return f"How “{result.name}” moves, to first order: its bodies in colours, {what}"


def capacity_picture(check: bs.assess.LocalMechanismCheck) -> dict[str, str] | None:
    """Return the picture of capacity curve and demand; None without a check by displacement."""
    if "SLV, by displacement" not in check.limit_states:
        return None
    caption = "Capacity curve and demand at SLV; the ray is that of the equivalent period"
    return picture(Drawing("verification", caption, lambda ax: figures.verification(check, ax=ax), _DIAGRAM))


Check = bs.assess.LocalMechanismCheck


class Notes:
    """Notes in the order in which cases first cite them.

    Cautions with one code are one note, with the text of the case that cites it first.
    """

    def __init__(self) -> None:
        self._cases: dict[str, dict[str, Note]] = {}
        self._texts: dict[tuple[NoteCode, int], str] = {}

    def numbers(self, case: str, notes: Iterable[Note]) -> list[int]:
        """Return the numbers of the notes on a case, and list those that are new."""
        texts, met = list[str](), Counter[NoteCode]()
        for note in notes:
            text = note.text
            if note.severity is not Severity.WARNING and text not in self._cases:
                # A case may have several notes of one code.
                text = self._texts.setdefault((note.code, met[note.code]), text)
            met[note.code] += 1
            self._cases.setdefault(text, {})[case] = note
            texts.append(text)
        numbers = {text: number for number, text in enumerate(self._cases, start=1)}
        return list(dict.fromkeys(numbers[text] for text in texts))

    def listed(self, relied_on: str) -> list[tuple[int, str]]:
        """Return the number and the text of every note, with its cases unless it is only of the one relied on."""
        each = enumerate(self._cases.values(), start=1)
        return [(number, report.note_of_cases(cases, relied_on)) for number, cases in each]


def cautions(result: bs.CaseResult) -> list[Note]:
    """Return the notes on a case that are warnings or cautions."""
    return [note for note in result.notes if note.severity is not Severity.INFO]


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
        result = check.result
        # The run of a remedy has joints of its own, and is not part of the analysis.
        of_analysis = result.name in runs or result.model.blocks is not analysis.model.blocks
        is_remedy = not of_analysis and result.of_case in runs
        name = result.of_case if is_remedy else result.name
        if name not in runs or not (is_remedy or result.model.hash == analysis.model.hash):
            msg = (
                f"report of {analysis.model.name!r}: the check is of case {name!r} of model "
                f"{result.model.name!r}, which is not part of it; check a result of this analysis"
            )
            raise bs.errors.ModelError(msg)
        case, spreads = runs[name], analysis.spreads
        relied = (spreads[case].relied_on if case in spreads else analysis[case]).load_factor
        if not is_remedy and result.load_factor not in (relied, analysis[case].load_factor):
            msg = (
                f"report of {analysis.model.name!r}: the check is of the load factor {result.load_factor:.4g}, "
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
        "alpha": shown(verdict.governing.alpha),
        "range": report.ends_of_ways(verdict.alphas),
        "e_star": f"{verdict.governing.e_star:.3g}",
        "a0_star": f"{check.acceleration:.4g} m/s²",
        "notes": notes.numbers(name, check.notes),
        "picture": {"is_detail": check.method == "linear", **drawn} if (drawn := capacity_picture(check)) else None,
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


#: Statuses without a load factor, the proven collapse first.
_WORST_FIRST = (
    *(bs.Status.UNSTABLE, bs.Status.SELF_STRESS, bs.Status.COLLAPSES, bs.Status.UNDECIDED),
    *(bs.Status.NOT_CONVERGED, bs.Status.INTERRUPTED),
)


#: Relative difference between the first load factor of a curve and the load factor of its case that is reported.
_APART = 0.005


def relied_on(analysis: bs.Analysis, checks: Sequence[tuple[str, Check]], noted: Notes) -> dict[str, Any]:
    """Return the governing case, with its number in words and its picture.

    A pushed case without a load factor governs, whatever the other checks. Otherwise the check with the least share of
    its site's ground acceleration governs. Without checks, the case with the lowest load factor governs. Settlements
    govern only if there are no other cases.
    """
    heads = analysis.headlines
    loaded = {name: head for name, head in heads.items() if not head.answer.is_reaction} or heads
    name, check = _governing(analysis, loaded, checks)
    if name is None:
        nothing = dict.fromkeys(("curves", "figures", "notes", "missed", "response"), ()) | dict.fromkeys(
            ("picture", "holds")
        )
        return nothing | {"name": "", "sentence": report.NO_CASE, "between": ""}
    head, result = heads[name], analysis[name]
    begins = beginning_words(result)
    # Those of a check include the notes on the run that it relies on, which may be a variant of the case.
    notes = check.notes if check else cautions(result)
    has_doubt_note = check is not None and any(note.code is NoteCode.CURVE_DOUBT for note in check.notes)
    is_record = result.response is not None
    what, number = result.number() if is_record else (f"{head.answer.name} {head.answer.symbol}", head.number)
    mixed = len({one.answer.dimension for one in loaded.values()}) > 1
    figures = [
        {
            "what": what,
            "number": number if check is None else shown(check.verdict.governing.alpha),
            "more": [
                "NOT SETTLED" * result.drifts,
                begins,
                head.range if check is None else report.range_of_ways(check.verdict.alphas),
                head.bound,
                "" if is_record else f"{head.flow} flow",
            ],
        }
    ]
    if check is not None:
        borne, site = check.verdict.state.ag_texts()
        verdict = check.verdict
        figures += [
            {
                "what": "capacity / demand",
                "number": check.verdict.state.ratio_text(),
                "more": [check.relied_on, check.verdict.outcome, verdict.figures],
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
        "response": [picture(drawing) for drawing in drawings(result)] if is_record else [],
        "holds": _holds(result, [one for _, one in checks]),
        "missed": _missed([item for item in checks if item[1] is not check]),
        "notes": noted.numbers(name, notes),
    }


def _governing(
    analysis: bs.Analysis, heads: Mapping[str, bs.results.Headline], checks: Sequence[tuple[str, Check]]
) -> tuple[str | None, Check | None]:
    """Return the name of the governing case, and its check if that governs."""
    without = [name for name, head in heads.items() if head.status in _WORST_FIRST]
    if without:
        # It is worse than any number, and than any check of another case.
        return min(without, key=lambda name: _WORST_FIRST.index(heads[name].status)), None
    if checks:
        return min(checks, key=lambda item: item[1].verdict.share)
    # A record that the structure stands has no load factor.
    if numbered := [name for name, head in heads.items() if head.status is not bs.Status.STANDS]:
        return min(numbered, key=lambda name: heads[name].load_factor), None
    return max(heads, key=lambda name: analysis[name].peak_displacement, default=None), None


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
    missed = {found.uncovered for _, found in compasses(analysis)}
    return report.between_directions(least, sorted(missed - {""}))


def _missed(others: Sequence[tuple[str, Check]]) -> list[str]:
    """Return the sentence on other checks whose capacity is below the demand, or that are not satisfied."""
    missed = [(name, check) for name, check in others if check.ratio < 1 or not check.satisfied]
    missed.sort(key=lambda item: item[1].ratio)
    facts = [(name, check.relied_on, check.ratio, check.verdict.outcome) for name, check in missed]
    return [report.other_checks(facts)] if facts else []


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
    for name in names[:FEW]:
        curve, result = curves[name], analysis[name]
        breaks, doubts = bs.results.breaking_words(curve), result.curve_doubts
        begins_above = [part.doubt for part in doubts[:1]] == [CurveDoubt.BEGINS_ABOVE]
        clauses = ["" if begins_above else beginning_words(result), result.curve_ended]
        if doubts:
            clauses += [] if has_doubt_note and name == relied_on else map(str, doubts[:1])
        elif breaks:
            # The last of several breaks may be the one at which SLV ends.
            clauses += [breaks[0], *([report.MORE_BREAKS] if breaks[1:] else [])]
        if any(clauses):
            sentences.append(report.curve_sentence(name, list(filter(None, clauses)), settles="reaction" in curve))
    more = len(names) - FEW
    return [*sentences, report.more_curves(more)] if more > 0 else sentences


def _first(curve: xr.Dataset) -> float:
    """Return the first load factor of a curve."""
    return float(curve["load_factor"][0])
