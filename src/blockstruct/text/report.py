"""Sentences of the first page of a report."""

from collections.abc import Mapping, Sequence

from blockstruct.text.note import Note
from blockstruct.text.numbers import Answer, ratio_text, shown
from blockstruct.vocabulary import Status, counted, listed, shortened

NO_SOURCE = "the author of the model"
NO_CASE = "The analysis has no case."
NO_DEMAND = (
    "a load factor alone does not verify a structure. It is the multiple of the variable load at which the structure "
    "collapses, to compare with the one that a code demands."
)
NO_DEMAND_OF_REACTION = (
    "a reaction alone does not verify a structure. It is the reaction left in the supports, under the dead load, as "
    "the structure begins to follow them."
)


def note_of_cases(cases: Mapping[str, Note], relied_on: str) -> str:
    """Return the note of the first case, with the other cases that have one of its kind.

    Each of these has the relative change of its number, if it is known.
    """
    (first, note), *others = cases.items()
    named = note.text if first == relied_on else f"{first}: {note}"
    if not others:
        return named
    each = [name if other.change is None else f"{name} (about {other.change:+.0%})" for name, other in others]
    differ = any(other.change is None and other.text != note.text for _, other in others)
    return f"{named} This also applies to {listed(each)}{', with other figures' * differ}."


def no_number(case: str, status: Status, answer: Answer, *, cases: int, checks: int) -> str:
    """Return the sentences on a governing case without a load factor.

    Parameters
    ----------
    case, status, answer
        Its name, how it ended, and the name of its number.
    cases, checks
        Number of cases, and of checks of other cases.
    """
    if status is Status.STANDS:
        among = f"“{case}”" if cases == 1 else f"all of {cases} cases. It moves furthest in “{case}”"
        return f"The structure stands in {among}. The response to a record has no load factor."
    worst = "" if cases == 1 else f", the worst of {cases} cases"
    text = {
        Status.COLLAPSES: f"The structure collapses in “{case}”{worst}.",
        Status.UNDECIDED: f"It is undecided whether the structure stands in “{case}”{worst}.",
    }.get(status, f"There is no {answer.name} to rely on: “{case}” {status.predicate}{worst}.")
    if not checks:
        return text
    others = "The check of another case does" if checks == 1 else f"The {checks} checks of other cases do"
    return f"{text} The verification is not satisfied. {others} not cover it."


def number(case: str, value: str, answer: Answer, *, cases: int, has_mixed_units: bool) -> str:
    """Return the sentences on the number of the governing case, out of some cases, without checks."""
    worst = f"the {'largest' if answer.is_reaction else 'lowest'} of {cases} cases"
    among = f"one of {cases} cases, forces and moments" if has_mixed_units else worst
    return (
        f"Relied on: {answer.name} {value} of “{case}”{f', {among}' if cases > 1 else ''}. It is checked against no "
        "demand."
    )


def ratio(case: str, state: str, value: float, alpha: float, *, checks: int) -> str:
    """Return the sentence on the governing check.

    Parameters
    ----------
    case, state
        Names of the case and of the limit state.
    value
        Capacity over demand.
    alpha
        Multiplier of the motion relied on.
    checks
        Number of checks.
    """
    least = f", which of {checks} checks bears the least share of its site's ground acceleration"
    among = least if checks > 1 else ""
    return f"Relied on: capacity / demand {ratio_text(value)} of “{case}” ({state}){among}, with α = {shown(alpha)}."


def other_checks(checks: Sequence[tuple[str, str, float, str]]) -> str:
    """Return the sentence on failed checks: case, state, ratio, outcome."""
    texts = [f"{ratio_text(value)} of “{case}” ({state}), {outcome}" for case, state, value, outcome in checks]
    some = shortened(texts, "and {} more, in the verification below".format)
    return f"Other checks: capacity / demand {'; '.join(some)}."


def between_directions(least: Sequence[tuple[str, float]], uncovered: Sequence[str]) -> str:
    """Return the sentences on directions between the computed ones.

    Parameters
    ----------
    least
        Cases with directions, each with the least load factor between them; one without a name stands for all cases.
    uncovered
        Clauses on directions that the computed ones do not cover.
    """
    bounds = ", ".join(
        f"{alpha:.4g} between those {f'of “{name}”' if name else 'that were run'}" for name, alpha in least
    )
    texts = [f"With associative flow no direction is below load factor {bounds}."] if bounds else []
    return " ".join([*texts, *(f"Directions between those that were run {clause}." for clause in uncovered)])


def curve_begins(answer: str, *, is_rounded: bool) -> str:
    """Return the clause on the first load factor of a capacity curve, if it differs from the case's."""
    return f"the curve{' of rounded corners' if is_rounded else ''} begins at {answer}"


def curve_sentence(case: str, clauses: Sequence[str], *, settles: bool) -> str:
    """Return the sentence on a capacity curve."""
    return f"{'Settlement' if settles else 'Pushover'} “{case}”: {'; '.join(clauses)}."


def ends_of_ways(alphas: tuple[float, float]) -> str:
    """Return the lowest and the highest multiplier of the ways to check; one if they are alike."""
    return " to ".join(dict.fromkeys(shown(alpha) for alpha in alphas))


def range_of_ways(alphas: tuple[float, float]) -> str:
    """Return the clause on the multipliers of the ways to check; empty if they are alike."""
    low, high = (shown(alpha) for alpha in alphas)
    return f"{low} to {high} over steps, joint stiffness, motions and remedies" if low != high else ""


MORE_BREAKS = "further tie breaks follow below"


def more_curves(count: int) -> str:
    """Return the sentence on curves that are not listed."""
    return f"The curves of {counted(count, 'more pushover')} follow below."
