"""Sentences on the result of a case: statics, certificate, schedules, pushover."""

from collections.abc import Collection

from blockstruct.limit import Certificate
from blockstruct.text.answer import Answer
from blockstruct.text.ties import kilonewton, tie_title
from blockstruct.vocabulary import Status, counted


def capitalised(text: str) -> str:
    """Return a clause as a sentence."""
    return f"{text[:1].upper()}{text[1:]}."


def statics_range(least: float, largest: float, answer: Answer) -> str:
    """Return the sentence on the reactions that statics allows; empty if one is NaN."""
    ends = [answer.format(least, alongside=largest), answer.format(largest, alongside=least)]
    return "" if "none" in ends else f"Statics allows reactions from {ends[0]} to {ends[1]} under the dead load."


def settled_schedules(settled: Collection[float], schedules: int, answer: Answer) -> str:
    """Return the sentence on the load factors of the settled schedules of a spread."""
    text = f"{len(settled)} of {counted(schedules, 'schedule')} settled at a certified {answer.name}"
    if settled:
        text += f", {' to '.join(dict.fromkeys(answer.ends((min(settled), max(settled)))))}"
    return f"{text}."


def admissible_state(alpha: float, gap: float, iteration: int, answer: Answer, *, is_associative: bool) -> str:
    """Return the sentences on the best admissible state of a case without a collapse state.

    Parameters
    ----------
    alpha, gap, iteration
        Its load factor, its flow-rule gap, and its place in the history.
    answer
        Name of the number of the case.
    is_associative
        Whether flow is associative, so that the state is a bound.
    """
    wanted, side = ("least reaction", "upper") if answer.is_reaction else ("collapse load factor", "lower")
    meaning = f"an {side}" if side == "upper" else f"a {side}"
    meaning += f" bound of the {wanted}"
    if not is_associative:
        meaning = f"not the {wanted}, and without dilatancy not {meaning}"
    return (
        f"Forces in equilibrium within the strength of all joints were found at {answer.name} {answer.text(alpha)} "
        f"(iteration {iteration}). They miss the flow rule by {gap:.1e} in units of {_gap_unit(answer)}. "
        f"It is {meaning}."
    )


def certificate_sentence(certificate: Certificate | None, status: Status, answer: Answer, *, has_ties: bool) -> str:
    """Return the sentence on the certificate of a case, with its measures and their tolerances."""
    if certificate is None:
        return "There is no certificate."
    if status is Status.UNSTABLE:
        verdict = "is proven" if certificate.holds else "is not proven"
        return f"A mechanism in which the dead load alone does work {verdict}."
    if status is Status.SELF_STRESS:
        verdict = "is certified" if certificate.holds else "is not certified"
        return f"A collapse state of the dead load alone {verdict} within the tolerances."
    loaded = "no joint and no tie" if has_ties else "no joint"
    (residual, of_residual), (excess, of_excess), (depth, of_depth), (gap, of_gap) = certificate.texts.values()
    return (
        f"The {certificate.verdict}: equilibrium is off by at most {residual} of a block's weight (tolerance "
        f"{of_residual}), {loaded} is loaded beyond its strength by more than {excess} of it ({of_excess}), blocks "
        f"penetrate by at most {depth} of the largest motion ({of_depth}), and the flow rule is missed by {gap} of "
        f"{_gap_unit(answer)} ({of_gap})."
    )


def _gap_unit(answer: Answer) -> str:
    return f"the {'dead load' if answer.is_reaction else 'load factor'}"


def pushed_states(states: int, certified: int, reached: float, point: str, direction: str) -> str:
    """Return the sentence on the states of a curve.

    Parameters
    ----------
    states, certified
        Number of states, and of certified ones.
    reached
        Last displacement, m.
    point, direction
        The point or the supports that move, and the direction.
    """
    if states == 1:
        found = f"1 state was found, {'certified' if certified else 'not certified'},"
    else:
        found = f"{states} states were found, {'all' if certified == states else certified} of them certified,"
    return f"Beyond collapse {found} up to a displacement of {1e3 * reached:.4g} mm of {point} along {direction}."


def no_curve(reason: str) -> str:
    """Return the sentence on a pushover without a capacity curve."""
    return f"There is no capacity curve: {reason}."


def tie_holds(name: str, elongation: float, force: float) -> str:
    """Return the sentence on a tie that does not break, with its largest elongation, m, and force, N."""
    title = capitalised(tie_title(name)).removesuffix(".")
    return f"{title} holds: it lengthens by at most {1e3 * elongation:.4g} mm, under {kilonewton(force)} at most."


def more_ties_hold(count: int) -> str:
    """Return the sentence on ties that hold and are not listed."""
    return f"{count} more hold{'s' * (count == 1)}, too."


def tilting_table(angle: float) -> str:
    """Return the clause on the angle, degrees, at which a structure falls on a tilting table."""
    return f"on a tilting table: falls at {angle:.4g} deg"
