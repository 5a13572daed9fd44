"""Sentences on the result of a case: its end and number, certificate, pushed states, response to a record."""

from collections.abc import Collection, Sequence

import numpy as np

from blockstruct.limit import Certificate, Outcome
from blockstruct.text.answer import Answer
from blockstruct.text.numbers import FEW
from blockstruct.vocabulary import PathEnd, Procedure, Reason, Status, counted, listed

_FOUND_BY = {
    Procedure.LOADING_PATH: "along its loading path",
    Procedure.FICTITIOUS: "by fictitious sliding conditions",
    Procedure.SHIFTED: "by the shifted objective",
    Procedure.ASSOCIATIVE: "with associative flow",
}
_PATH_ENDS = {
    PathEnd.NO_DEAD_LOAD_STATE: "it found no state under dead load to begin with",
    PathEnd.STEP_NOT_SOLVED: "one of its steps was not solved",
    PathEnd.LIMIT_REACHED: "it reached its largest displacement",
    PathEnd.NOT_CERTIFIED: "no state at its end met the tolerances of the certificate",
}
_REASONS = {
    Reason.CERTIFIED: "the certificate holds",
    Reason.DEAD_LOAD_NOT_CARRIED: "the joints carry at most {carried:.3g} of the dead load",
    Reason.DEAD_LOAD_COLLAPSES: (
        "friction between supports holds {hung} under the dead load in some states of self-stress and not in others"
    ),
    Reason.DEAD_LOAD_UNDECIDED: "the solver found neither forces that carry the dead load nor a mechanism",
    Reason.NEVER_COLLAPSES: "the joints carry any multiple of {load}",
    Reason.CARRIES_ANY_LOAD: (
        "the joints can carry any multiple of {load}, which without dilatancy does not exclude collapse"
    ),
    Reason.GROWS_WITHOUT_LIMIT: "the {number} grows without limit, and the joints can carry any multiple of {load}",
    Reason.NEVER_SETTLES: "from {low} to {high} over the last tenfold displacement, and not settled",
    Reason.JAMS: "still {rising} at {last}, the blocks jam",
    Reason.PROGRAM_NOT_SOLVED: "the solver did not solve the first program",
    Reason.NO_CERTIFICATE: "no certificate in {programs}",
    Reason.NEGATIVE_LOAD_FACTOR: "the only state that was found has a negative load factor",
    Reason.AT_REST: "at rest after the record",
    Reason.BLOCKS_FALLEN: "a block has fallen or turned over",
    Reason.STILL_MOVING: "blocks still move at the end",
    Reason.STEP_NOT_SOLVED: "a step was not solved, and the response ends there",
    Reason.INTERRUPTED: "the user stopped the run",
    Reason.KILLED: "the run was killed",
    Reason.NOT_BEGUN: "no program was solved",
}
_WITHOUT_NUMBER = {
    Status.UNSTABLE: "does not stand under its dead load",
    Status.UNBOUNDED: "never collapses",
    Status.INTERRUPTED: "interrupted",
    Status.STANDS: "stands",
    Status.COLLAPSES: "collapses at {time:.4g} s",
    Status.UNDECIDED: "undecided",
}


def found_by(outcome: Outcome) -> str:
    """Return how the load factor was found, as in ``"along its loading path"``; empty without one."""
    return _FOUND_BY[outcome.procedure] if outcome.procedure is not None else ""


def why(outcome: Outcome, answer: Answer, hung: Sequence[str] = ()) -> str:
    """Return why a case ended with its status, without a full stop.

    If a loading path was followed and not closed, the text states why.
    """
    low, high = answer.ends(outcome.drift or (np.nan, np.nan))
    text = _REASONS[outcome.reason].format(
        carried=outcome.carried,
        hung=listed(hung, FEW) or "the structure",
        load="this motion of the supports" if answer.is_reaction else "the variable load",
        number=answer.name,
        rising="falling" if answer.is_reaction else "rising",
        last=low if answer.is_reaction else high,
        low=low,
        high=high,
        programs=counted(outcome.programs, "program"),
    )
    if outcome.path_end not in (None, PathEnd.CLOSED):
        text += f"; the loading path did not finish: {_PATH_ENDS[outcome.path_end]}"
    if np.isfinite(outcome.load_ratio):
        text += (
            f"; the loads of two blocks that touch differ by a factor of {outcome.load_ratio:.1e}, too much for the "
            "solver: give plates and wedges between heavy blocks no weight, or more"
        )
    return text


def ended(outcome: Outcome, *, has_procedure: bool) -> str:
    """Return how a case ended in two or three words, such as ``"NOT SETTLED"``.

    Parameters
    ----------
    outcome
        The outcome.
    has_procedure
        Whether the case is non-associative, so that a load factor may be unsettled.
    """
    if outcome.status is not Status.CONVERGED or not has_procedure:
        return outcome.status.words
    return outcome.status.words if outcome.settled else "NOT SETTLED"


def range_text(ends: tuple[float, float] | None, answer: Answer) -> str:
    """Return the range of a load factor over the variants of its loading path; empty without one."""
    if ends is None:
        return ""
    low, high = answer.ends(ends)
    if low == high:
        return "unchanged with other steps and joint stiffness"
    return f"{low} to {high} by step length and joint stiffness"


def sentence(
    outcome: Outcome,
    answer: Answer,
    *,
    bound: float = np.nan,
    path_range: tuple[float, float] | None = None,
    hung: Sequence[str] = (),
    digits: int = 4,
) -> str:
    """Return how a case ended, its number, how it was found and between which limits it lies.

    Parameters
    ----------
    outcome, answer
        The outcome, and the name of its number.
    bound
        Load factor with associative flow, an upper bound; infinite if it has none, NaN if unknown.
    path_range
        Lowest and highest load factor of the variants of the loading path.
    hung
        Blocks that stand under their dead load only in some states of self-stress.
    digits
        Significant digits of the number, its bound and its peak.

    Examples
    --------
    >>> from blockstruct.limit import Outcome
    >>> from blockstruct.text import LOAD_FACTOR
    >>> from blockstruct.vocabulary import Procedure, Reason, Status
    >>> found = Outcome(Status.CONVERGED, 0.5509, Reason.CERTIFIED, Procedure.LOADING_PATH, settled=True)
    >>> sentence(found, LOAD_FACTOR, bound=0.7498)
    'collapses at load factor 0.5509 along its loading path (certified; associative bound 0.7498)'
    """
    if outcome.status is not Status.CONVERGED:
        text = _WITHOUT_NUMBER.get(outcome.status, f"no {answer.name}").format(time=outcome.collapse_time)
        return f"{text}: {why(outcome, answer, hung)}"
    number, bounds = answer.text(outcome.load_factor, digits), []
    if path_range is not None:
        bounds.append(range_text(path_range, answer))
    last = "" if outcome.drift is None else "{} to {}".format(*answer.ends(outcome.drift))
    if np.isfinite(outcome.without_crushing):
        bounds.append(f"without crushing; with crushing {last}")
    elif last and not outcome.settled:
        bounds.append(f"its last values are {last}")
    bounds.append("certified")
    if outcome.procedure is Procedure.ASSOCIATIVE:
        bounds.append("a bound of every other flow rule")
    elif np.isfinite(bound):
        bounds.append(f"associative bound {answer.text(bound, digits)}")
    elif np.isinf(bound):
        bounds.append("no associative bound")
    verb = "follows its supports at a" if answer.is_reaction else "collapses at"
    text = f"{verb} {answer.name} {'of ' * answer.is_reaction}{number} {found_by(outcome)} ({'; '.join(bounds)})"
    if np.isfinite(outcome.peak):
        text += f" after {_peak(outcome, answer, digits)}"
    if not outcome.settled:
        text = f"NOT SETTLED, {text}"
    if outcome.stands_in:
        text += f". The loading path did not finish: {_PATH_ENDS[outcome.path_end or PathEnd.NOT_CERTIFIED]}"
    return text


def _peak(outcome: Outcome, answer: Answer, digits: int) -> str:
    peak = answer.text(outcome.peak, digits)
    if answer.is_reaction:
        return f"a least reaction of {peak} on the way"
    return f"a peak of {peak}: a load that is not reduced brings it down at the peak"


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
        states_clause = f"1 state was found, {'certified' if certified else 'not certified'},"
    else:
        states_clause = f"{states} states were found, {'all' if certified == states else certified} of them certified,"
    return (
        f"Beyond collapse {states_clause} up to a displacement of {1e3 * reached:.4g} mm of {point} along {direction}."
    )


def no_curve(reason: str) -> str:
    """Return the sentence on a pushover without a capacity curve."""
    return f"There is no capacity curve: {reason}."


def tilting_table(angle: float) -> str:
    """Return the clause on the angle, degrees, at which a structure falls on a tilting table."""
    return f"on a tilting table: falls at {angle:.4g} deg"


def response_sentences(
    *,
    largest: tuple[float, str],
    remaining: tuple[float, str],
    fallen: Sequence[str],
    end: float,
    step: float,
    steps: int,
) -> list[str]:
    """Return the sentences on a response.

    Parameters
    ----------
    largest, remaining
        Largest displacement during the motion and at its end, m, each with its block.
    fallen
        Blocks that have fallen.
    end
        Time of the last state, s.
    step, steps
        Length of the steps, s, and their number.

    Examples
    --------
    >>> at = {"largest": (0.12, "b2"), "remaining": (0.002, "b1")}
    >>> print(*response_sentences(**at, fallen=[], end=8, step=2e-3, steps=4100))
    The largest displacement is 120 mm, of b2. At the end, 8 s, 2 mm remain, of b1. It took 4100 steps of at most 2 ms.
    """
    sentences = [f"The largest displacement is {1e3 * largest[0]:.4g} mm, of {largest[1]}."]
    if fallen:
        sentences.append(f"At {end:.4g} s {listed(fallen, FEW)} {'has' if len(fallen) == 1 else 'have'} fallen.")
    else:
        sentences.append(f"At the end, {end:.4g} s, {1e3 * remaining[0]:.4g} mm remain, of {remaining[1]}.")
    return [*sentences, f"It took {steps} steps of at most {1e3 * step:.4g} ms."]
