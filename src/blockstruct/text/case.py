"""Sentences on the result of a case: end, number, certificate, curve, response to a record, and pushed masses."""

from collections.abc import Collection, Sequence

import numpy as np

from blockstruct.limit import Certificate, Outcome
from blockstruct.model import (
    BodyForce,
    Case,
    Model,
    MovingCase,
    Pushover,
    RecordCase,
    SelfWeight,
    SettlementCase,
    kind_of,
)
from blockstruct.motion.state import CurveOutcome
from blockstruct.statics.carried import carried_weights
from blockstruct.statics.wrenches import applied_loads
from blockstruct.text.mechanism import crushed_joints, kilonewton, ties_in_motion
from blockstruct.text.numbers import Answer
from blockstruct.vocabulary import (
    FEW,
    CurveDoubt,
    CurveEnd,
    PathEnd,
    Procedure,
    Reason,
    Status,
    axis_text,
    counted,
    listed,
)

_FOUND_BY = {
    Procedure.LOADING_PATH: "along its loading path",
    Procedure.FICTITIOUS: "by fictitious sliding conditions",
    Procedure.SHIFTED: "by the shifted objective",
    Procedure.ASSOCIATIVE: "with associative flow",
}
_PATH_ENDS = {
    PathEnd.NO_DEAD_LOAD_STATE: "it found no state under dead load to begin with",
    PathEnd.STEP_NOT_SOLVED: "one of its steps was not solved",
    PathEnd.LIMIT_REACHED: "it reached its largest displacement or number of iterations",
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
    >>> from blockstruct.text.numbers import LOAD_FACTOR
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


def pushed_states(
    states: int, certified: int, reached: float, point: str, direction: Sequence[float], *, settles: bool
) -> str:
    """Return the sentence on the states of a curve.

    Parameters
    ----------
    states, certified
        Number of states, and of certified ones.
    reached
        Last displacement, m.
    point, direction
        The point or the supports that move, and the direction.
    settles
        Whether supports move.
    """
    if states == 1:
        states_clause = f"1 state was found, {'certified' if certified else 'not certified'},"
    else:
        states_clause = f"{states} states were found, {'all' if certified == states else certified} of them certified,"
    return (
        f"{'After the first motion' if settles else 'Beyond collapse'} {states_clause} up to a displacement of "
        f"{1e3 * reached:.4g} mm of {point} along {axis_text(direction)}."
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
    ties: Sequence[tuple[str, float, float]],
    crushed: float,
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
    ties
        Name, largest elongation, m, and time of the break, s, or NaN, of each tie.
    crushed
        Largest depth, m, that joints have lost.
    end
        Time of the last state, s.
    step, steps
        Length of the steps, s, and their number.

    Examples
    --------
    >>> at = {"largest": (0.12, "b2"), "remaining": (0.002, "b1")}
    >>> print(*response_sentences(**at, fallen=[], ties=[], crushed=0, end=8, step=2e-3, steps=41)[:2])
    The largest displacement is 120 mm, of block b2. At the end, 8 s, 2 mm remain, of block b1.
    """
    sentences = [f"The largest displacement is {1e3 * largest[0]:.4g} mm, of block {largest[1]}."]
    if fallen:
        which = f"block {fallen[0]} has" if len(fallen) == 1 else f"blocks {listed(fallen, FEW)} have"
        sentences.append(f"At {end:.4g} s {which} fallen.")
    else:
        sentences.append(f"At the end, {end:.4g} s, {1e3 * remaining[0]:.4g} mm remain, of block {remaining[1]}.")
    sentences += [*ties_in_motion(ties), *crushed_joints(crushed)]
    return [*sentences, f"It took {steps} steps of at most {1e3 * step:.4g} ms."]


def response_number(largest: float, collapse_time: float) -> tuple[str, str]:
    """Return name and text of the largest displacement, m, of a response, or of the time, s, of its collapse.

    >>> response_number(0.0312, float("nan")), response_number(2.5, 3.21)
    (('largest displacement', '31.2 mm'), ('time of collapse', '3.21 s'))
    """
    if np.isnan(collapse_time):
        return "largest displacement", f"{1e3 * largest:.4g} mm"
    return "time of collapse", f"{collapse_time:.4g} s"


_OTHER_STEPS = ", so run it with other steps and compare"
_BEGUN = (
    ", or friction leaves more than one collapse state, and procedure='loading path' in the settings finds the one "
    "that loading leads to"
)


def curve_end(outcome: CurveOutcome, case: MovingCase) -> str:
    """Return a clause on the end of a curve, with the remedy if it is missing.

    Parameters
    ----------
    outcome
        Its facts.
    case
        The pushover or settlement.
    """
    if outcome.end is CurveEnd.EARLIER_VERSION:
        return "the file is of an earlier version, whose curves are no longer read: run the case again"
    names, at = listed(list(outcome.blocks)), f"at a displacement of {outcome.displacement:.6g} m"
    if isinstance(case, Pushover):
        return _end_of_pushover(outcome, case, names, at)
    match outcome.end:
        case CurveEnd.DISPLACEMENT_REACHED:
            return f"the structure follows its supports up to a displacement of {outcome.displacement:.6g} m"
        case CurveEnd.FALLS:
            return f"the supports move by {outcome.displacement:.6g} m at most, then blocks fall ({names})"
        case CurveEnd.LIMIT_REACHED:
            return f"no end after {outcome.states} states: ask for more steps, or a smaller displacement"
        case CurveEnd.BEGINS_ABOVE:
            return (
                "no curve: it would begin at a smaller reaction than that of the case, as blocks that move touch "
                f"wherever faces do. {names} touch beyond the interfaces of the model: give the interfaces that are "
                "there, and compare the reactions"
            )
        case _:
            return f"no forces that hold the blocks are found {at}, and the method ends"


def _end_of_pushover(outcome: CurveOutcome, case: Pushover, names: str, at: str) -> str:
    block, direction = case.control
    moves = (
        f"block {outcome.blocks[0]!r} moves furthest, along {axis_text(outcome.direction)}" if outcome.blocks else ""
    )
    match outcome.end:
        case CurveEnd.ZERO:
            stands = f", where the control point at block {block!r} stands still or goes back: {moves}"
            return f"the load factor is zero {at}{stands if outcome.stands else ''}"
        case CurveEnd.FALLS:
            return f"blocks fall under the dead load alone {at} ({names}), and the method ends"
        case CurveEnd.NOT_SOLVED:
            return (
                f"no load factor is found {at}: no forces carry the dead load, and blocks fall, or the push meets what "
                "it cannot move; and the method ends"
            )
        case CurveEnd.CARRIED_AWAY:
            return f"nothing stops the push: {at} it has carried blocks further than the structure is large ({names})"
        case CurveEnd.LIMIT_REACHED:
            return (
                f"no end after {outcome.states} states: ask for more steps, or follow a point and a direction that the "
                "mechanism goes along"
            )
        case CurveEnd.RESTS:
            return (
                f"the control point at block {block!r} does not move along {axis_text(direction)} in the collapse "
                f"mechanism, and there is no curve over its displacement; {moves}"
            )
        case _:
            return (
                f"no curve: it would begin at a load factor of {outcome.load_factor:.4g}, above that of the collapse "
                f"state, as blocks that move touch wherever faces do. {names} touch beyond the interfaces: "
                "give the interfaces that are there, or blocks whose faces are no larger, and compare the load factors"
            )


def doubtful_part(
    doubt: CurveDoubt,
    displacement: tuple[float, float],
    load_factor: tuple[float, float],
    missed: float,
    procedure: str,
    *,
    has_ties: bool,
) -> str:
    """Return a clause on a part of a capacity curve that may depend on its steps.

    Parameters
    ----------
    doubt
    displacement, load_factor
        Of the control point, m, and of the states between which the part lies.
    missed
        Share of all work so far that the forces miss.
    procedure
        Procedure that found the collapse state.
    has_ties
        Whether the structure has ties.
    """
    before, after = (f"{1e3 * d:.4g} mm" for d in displacement)
    changes = f"from {load_factor[0]:.4g} to {load_factor[1]:.4g} at a displacement of"
    match doubt:
        case CurveDoubt.BEGINS_ABOVE:
            factors = f"{load_factor[1]:.4g}, above the load factor of the collapse state, {load_factor[0]:.4g}"
            return f"the curve begins at {factors}: friction leaves more than one collapse state"
        case CurveDoubt.RISES:
            tight = ", or ties are pulled tight" if has_ties else ""
            begun = "" if procedure == "loading path" else _BEGUN
            return f"the load factor rises {changes} {after}: blocks meet, interlock or jam{tight}{begun}"
        case CurveDoubt.SLIPS:
            why = "where units slip and catch a curve depends on its steps"
            return f"the load factor jumps {changes} {before}: {why}{_OTHER_STEPS}"
        case CurveDoubt.LEAPS:
            why = "another mechanism takes over, as where the hinge of an arch leaps, or a block tips after it slid"
            return f"the load factor jumps {changes} {before}: {why}{_OTHER_STEPS}"
        case CurveDoubt.GOES_BACK:
            why = "its displacement does not measure the motion there, so follow another point"
            return f"the control point goes back from {before} to {after}: {why}"
        case CurveDoubt.MISSES_WORK:
            work = f"{missed:.1%} of all work is missed in the step from a displacement of {before}"
            return f"{work}: blocks drop or meet, or hinges leap there{_OTHER_STEPS}"
        case CurveDoubt.ROCKS | CurveDoubt.ROCKS_AND_SLIDES:
            rock = "rock" if doubt is CurveDoubt.ROCKS else "rock and slide"
            where = f"up to a displacement of {before}, and {rock} from {after} on"
            return f"blocks slide {where}: that is known to a step{_OTHER_STEPS}"


_NAMES = {"weight": "concentrated weights", "line_load": "line loads", "area_load": "area loads", "fill_load": "fill"}


def pushed_masses(model: Model, case: Case) -> str:
    """Return sentences on the acting loads of a case; usually empty.

    For a mass-proportional push and a record they list the weights that it moves and the weights that it does not.
    Weights on supports have no effect. For a settlement they list loads on supports.
    """
    on_supports = _on_supports(model, case) if isinstance(case, SettlementCase) else ""
    return " ".join(filter(None, (_of_push(model, case), on_supports)))


def _of_push(model: Model, case: Case) -> str:
    is_record = isinstance(case, RecordCase)
    if not is_record and not any(isinstance(load, BodyForce) for p in case.patterns for load in p.loads):
        return ""
    pushed = "accelerated" if is_record else "pushed"
    free = np.array([not b.fixed for b in model.blocks])
    masonry = sum(b.weight for b in model.blocks if not b.fixed)
    carried = carried_weights(model, case.dead)
    names = np.array([_NAMES.get(kind_of(load), "") for load in case.dead.loads], dtype=object)
    parts = []
    for name in _NAMES.values():
        chosen = free[carried.block] & (names[carried.load] == name)
        weight, share = (float(column[chosen].sum()) for column in (carried.weight, carried.pushed))
        if weight:
            whole = "" if share == weight else f" (of {kilonewton(weight)})"
            parts.append(f"{kilonewton(share)} {name}{whole}")
    text = f"{pushed.capitalize()} weight: {' + '.join([f'{kilonewton(masonry)} masonry', *parts])}."
    on_supports = float(carried.weight[~free[carried.block]].sum())
    if on_supports > 1e-9 * masonry:
        text += f" Weights of {kilonewton(on_supports)} on supports do nothing."
    if not any(isinstance(load, SelfWeight) for load in case.dead.loads):
        text += f" {case.dead.name!r} holds no self-weight: the blocks are {pushed}, but do not weigh."
    applied = applied_loads(model, case.dead)
    massless = np.array([kind_of(load) in ("point_load", "face_load") for load in case.dead.loads])
    down = -float(applied.force[massless[applied.load] & free[applied.block], 2].sum())
    if down > 1e-9 * max(masonry, 1.0):
        text += f" Forces of {case.dead.name!r}, {kilonewton(down)} downwards, have no mass and are not {pushed}."
    return text


def _on_supports(model: Model, case: Case) -> str:
    """Return the sentence on dead loads on supports; empty without any.

    The own weight of supports does not count.
    """
    others = np.array([not isinstance(load, SelfWeight | BodyForce) for load in case.dead.loads])
    applied = applied_loads(model, case.dead)
    fixed = np.array([b.fixed for b in model.blocks])
    chosen = fixed[applied.block] & others[applied.load]
    force, couple = (np.linalg.norm(part[chosen], axis=1).sum() for part in (applied.force, applied.couple))
    parts = [f"forces of {kilonewton(force)}"] * bool(force) + [f"moments of {kilonewton(couple)}·m"] * bool(couple)
    if not parts:
        return ""
    names = listed([model.blocks[k].name for k in np.unique(applied.block[chosen])], FEW)
    return (
        f"Loads of {case.dead.name!r} on supports do nothing, {' and '.join(parts)} on {names}: a reaction is what "
        "joints and ties bring to the supports that give way."
    )
