"""Sentences on the result of a case: end, number, certificate, curve, response to a record, and pushed masses."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from blockstruct.limit import Certificate
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
from blockstruct.vocabulary import FEW, CurveDoubt, CurveEnd, Status, axis_text, counted, listed


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
    gap_unit = "dead load" if answer.is_reaction else "load factor"
    return (
        f"Forces in equilibrium within the strength of all joints were found at {answer.name} {answer.text(alpha)} "
        f"(iteration {iteration}). They miss the flow rule by {gap:.1e} in units of the {gap_unit}. "
        f"It is {meaning}."
    )


def certificate_sentence(certificate: Certificate | None, status: Status) -> str:
    """Return the sentences on the certificate of a case, with its measures and their tolerances."""
    if certificate is None:
        return "There is no certificate."
    if status is Status.UNSTABLE:
        verdict = "is proven" if certificate.holds else "is not proven"
        return f"A mechanism in which the dead load alone does work {verdict}."
    if status is Status.SELF_STRESS:
        verdict = "is certified" if certificate.holds else "is not certified"
        return f"A collapse state of the dead load alone {verdict} within the tolerances."
    measures = [f"{name}: {sentence} (tolerance {limit})" for name, sentence, limit in certificate.rows]
    return f"The {certificate.verdict}. {capitalised('; '.join(measures))}"


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


def response_sentences(response: xr.Dataset, fallen: Sequence[str]) -> list[str]:
    """Return the sentences on a response: its largest and its remaining displacement, fallen blocks, ties, steps."""
    last, names = response.isel(time=-1), response["block"].to_numpy()
    peak, left = last["peak_displacement"].to_numpy(), np.linalg.norm(last["displacement"].to_numpy(), axis=1)
    sentences = [f"The largest displacement is {1e3 * peak.max():.4g} mm, of block {names[peak.argmax()]}."]
    if fallen:
        which = f"block {fallen[0]} has" if len(fallen) == 1 else f"blocks {listed(fallen, FEW)} have"
        sentences.append(f"At {last['time'].item():.4g} s {which} fallen.")
    else:
        remain = f"{1e3 * left.max():.4g} mm remain, of block {names[left.argmax()]}"
        sentences.append(f"At the end, {last['time'].item():.4g} s, {remain}.")
    if "tie_break_time" in last:
        of_ties = (last[name].to_numpy().tolist() for name in ("tie", "peak_tie_elongation", "tie_break_time"))
        sentences += ties_in_motion(list(zip(*of_ties, strict=True)))
    if "largest_crushed_depth" in last:
        sentences += crushed_joints(last["largest_crushed_depth"].item())
    steps, longest = int(last["steps"]), float(response["time_step"])
    return [*sentences, f"It took {steps} steps of at most {1e3 * longest:.4g} ms."]


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
        case CurveEnd.JAMS:
            return f"the supports meet what they cannot move {at} ({names}), and the method ends"
        case _:
            return f"no forces that hold the blocks are found {at}, and the method ends"


def _end_of_pushover(outcome: CurveOutcome, case: Pushover, names: str, at: str) -> str:
    block, direction = case.control
    moves = (
        f"block {outcome.blocks[0]!r} moves furthest, along {axis_text(outcome.direction)}" if outcome.direction else ""
    )
    match outcome.end:
        case CurveEnd.ZERO:
            stands = f", where the control point at block {block!r} stands still or goes back: {moves}"
            return f"the load factor is zero {at}{stands if outcome.stands else ''}"
        case CurveEnd.FALLS:
            return f"blocks fall under the dead load alone {at} ({names}), and the method ends"
        case CurveEnd.NOT_SOLVED:
            return f"no forces that hold the blocks are found {at}, and the method ends"
        case CurveEnd.JAMS:
            return f"the push meets what it cannot move {at} ({names}), and the method ends"
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


@dataclass(frozen=True, slots=True)
class DoubtfulPart:
    """A part of a capacity curve that may depend on its steps.

    Attributes
    ----------
    doubt : CurveDoubt
    displacement, load_factor : tuple of float
        Displacement of the control point, m, and load factor at the states between which the part lies. A rise lies
        between the first state and the highest. If the curve begins too high, the first load factor is that of the
        collapse state.
    missed : float
        Work that the step to the last of these states misses, relative to all work so far.
    procedure : str
        Procedure of the settings, which found the collapse state.
    has_ties : bool
    """

    doubt: CurveDoubt
    displacement: tuple[float, float]
    load_factor: tuple[float, float]
    missed: float
    procedure: str
    has_ties: bool

    def __str__(self) -> str:
        before, after = (f"{1e3 * d:.4g} mm" for d in self.displacement)
        first, last = (f"{alpha:.4g}" for alpha in self.load_factor)
        changes = f"from {first} to {last} at a displacement of"
        match self.doubt:
            case CurveDoubt.BEGINS_ABOVE:
                above = f"above the load factor of the collapse state, {first}"
                return f"the curve begins at {last}, {above}: friction leaves more than one collapse state"
            case CurveDoubt.RISES:
                tight = ", or ties are pulled tight" if self.has_ties else ""
                begun = "" if self.procedure == "loading path" else _BEGUN
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
                work = f"{self.missed:.1%} of all work is missed in the step from a displacement of {before}"
                return f"{work}: blocks drop or meet, or hinges leap there{_OTHER_STEPS}"
            case CurveDoubt.NOT_CERTIFIED:
                return f"certificates of states from a displacement of {before} to {after} do not hold{_OTHER_STEPS}"
            case CurveDoubt.ROCKS | CurveDoubt.ROCKS_AND_SLIDES:
                rock = "rock" if self.doubt is CurveDoubt.ROCKS else "rock and slide"
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
    masonry = model.weight
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
