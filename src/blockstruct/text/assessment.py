"""Notes and verdicts on checks of local mechanisms, Circolare 7/2019 C8.7.1.2.1."""

from collections.abc import Sequence

import numpy as np

from blockstruct.model import STANDARD_GRAVITY
from blockstruct.text.note import Note, NoteCode, Severity
from blockstruct.text.numbers import BEYOND, in_g, ratio_text, shown
from blockstruct.vocabulary import Status, Way, counted

g = STANDARD_GRAVITY
UNSETTLED = "NOT SETTLED: the load factor is not an answer yet"
_OUTSIDE = "If something outside the model holds the edge, verify that, too."


def _caution(code: NoteCode, text: str) -> Note:
    return Note(code, Severity.CAUTION, text)


# -- verdicts ----------------------------------------------------------------------------------------------------------


def state_outcome(name: str, ratio: float, *, satisfied: bool) -> str:
    """Return whether a limit state is satisfied, and why if its ratio does not show it.

    Parameters
    ----------
    name
        Of the limit state.
    ratio
        Capacity over demand; NaN without a spectrum.
    satisfied
        Whether it is satisfied.
    """
    if np.isnan(ratio):
        return "not checked: no spectrum of this limit state"
    if satisfied:
        least = f"below 1, but satisfied: a_g,{name[:3]} counts as no less than a_g,SLD (C8.7.1.2.1.8)"
        return "satisfied" if ratio >= 1 else least
    return "not satisfied" + ("" if ratio < 1 else ": a weaker ground motion already demands as much")


def verdict(name: str, ratio: float, outcome: str, ag: float, accelerations: tuple[str, str], *, of_sld: bool) -> str:
    """Return the sentence on a limit state.

    Parameters
    ----------
    name, ratio, outcome
        Of the limit state: capacity over demand, and :func:`state_outcome`.
    ag
        Ground acceleration that the structure bears, m/s².
    accelerations
        Texts of this acceleration and of the acceleration of the site.
    of_sld
        Whether SLD gives the ground acceleration.
    """
    borne, site = accelerations
    in_si = f"{shown(ag, 'm/s²')} = " if np.isfinite(ag) else ""
    at = "borne is a_g = a_g,SLD" if of_sld else "equal at a_g"
    return f"{name}: capacity / demand = {ratio_text(ratio)}, {outcome}; {at} = {in_si}{borne} (site {site})."


def open_warnings(count: int) -> str:
    """Return the outcome of a check with warnings, whose ratio alone would satisfy it."""
    return f"not satisfied before {'the warning is' if count == 1 else f'{count} warnings are'} settled"


def governing_way(
    way: Way,
    alpha: float,
    e_star: float,
    *,
    run: str,
    ends: tuple[float, float],
    floor: float | None,
    is_estimate: bool = False,
) -> str:
    """Return the sentences on the way that governs a check.

    Parameters
    ----------
    way, alpha, e_star
        The way, its multiplier and its e*.
    run
        The variant of the path, or the remedy, that gives them; empty for the case as given.
    ends
        Lowest and highest ratio over the load factors.
    floor
        Ratio with e* = 1; None if it is no different.
    is_estimate
        Whether the first steps of a loading path give the multiplier.
    """
    texts, (low, high) = [], [ratio_text(end) for end in ends]
    if run or way is not Way.COLLAPSE:
        kind, where = "an estimate for" if is_estimate else "of", f" in the run with “{run}”" if run else ""
        texts.append(f"It is {kind} {_WAYS[way]}{where}, with α = {shown(alpha)} and e* = {shown(e_star)}.")
    if high != low:
        texts.append(f"Other load factors, with the least motion of each, give up to {high}.")
    if floor is not None:
        texts.append(f"No motion has less than {ratio_text(floor)}, the ratio with e* = 1.")
    return " ".join(texts)


_WAYS = {
    Way.COLLAPSE: "the collapse mechanism",
    Way.WITHOUT_SMALL: "the collapse mechanism without bodies that move far less",
    Way.OTHER_MOTION: "another motion than the collapse mechanism",
    Way.LOWER_END: "the lower end of the range of the load factor",
    Way.UPPER_END: "the upper end of the range of the load factor",
    Way.UNIFORM_TORSION: "joints with the torsion of uniform pressure",
    Way.LOWERED_FRICTION: "joints whose friction is divided by their excess of torsion",
    Way.BIAXIAL: "crushing about both axes",
    Way.OTHER_PROCEDURE: "another procedure, as the load factor depends on self-stress",
    Way.WEIGHTS: "the displacement of the weights",
    Way.ALONE: "a body that overturns alone",
}


def way_line(name: str, alpha: float, e_star: float, ratio: float, *, governs: bool) -> tuple[str, str]:
    """Return the name of a way to check, and its multiplier, e* and capacity over demand."""
    relied = ", relied on" if governs else ""
    numbers = f"α = {shown(alpha)}, e* = {shown(e_star)}: capacity / demand = {ratio_text(ratio)}{relied}"
    return name, numbers


def acceleration_in_g(ag: float, text: str) -> str:
    """Return a ground acceleration, given its text in multiples of gravity."""
    return f"{text} g" if np.isfinite(ag) else BEYOND


def direction_without(name: str, status: Status) -> Note:
    """Return the note on a direction of a building that has no load factor."""
    text = f"“{name}” {status.predicate}, so nothing covers this direction."
    return Note(NoteCode.DIRECTION_WITHOUT, Severity.WARNING, text)


def direction_unsettled(name: str, ratio: float, least: float, *, is_limit: bool) -> Note:
    """Return the note on a direction of a building whose load factor has not settled.

    Parameters
    ----------
    name, ratio
        Of its case: name, and capacity over demand of the load factor that has not settled.
    least
        Capacity over demand of the direction that governs.
    is_limit
        Whether the load factor is the one without crushing, which crushing raised.
    """
    why = "is without crushing, which raised it" if is_limit else "has not settled"
    text = (
        f"The load factor of “{name}” {why}: capacity / demand {ratio_text(ratio)}. It governs instead if the true one "
        f"is lower by more than {1 - least / ratio:.0%}. Rule that out before signing."
    )
    return Note(NoteCode.DIRECTION_WITHOUT, Severity.WARNING, text)


def direction_open(name: str, ratio: float, count: int) -> Note:
    """Return the note on a direction of a building with warnings of its own, and its capacity over demand."""
    text = (
        f"“{name}” has {counted(count, 'warning')} of its own to settle before signing: read its notes. Its "
        f"capacity / demand is {ratio_text(ratio)}."
    )
    return Note(NoteCode.DIRECTION_WITHOUT, Severity.WARNING, text)


def unit_size(size: float, ratio: float) -> Note:
    """Return the note on units of another size, m, with which capacity over demand is below one."""
    text = f"With units of {shown(size, 'm')}, capacity / demand is {ratio_text(ratio)}. Draw the bond as it is."
    return Note(NoteCode.UNIT_SIZE, Severity.WARNING, text)


def unit_sizes(what: str, sizes: Sequence[float], values: Sequence[float], fine: float, scatter: float) -> str:
    """Return the sentences on answers with units of several sizes, m, the largest first."""
    (first, *others), (value, *rest) = sizes, values
    text = f"With units of {shown(first, 'm')} the {what} is {shown(value)}."
    if others:
        changes = [f"{one / value - 1:+.0%}" for one in rest]
        each = [
            f"{shown(size, 'm')} gives {'the same' if change in ('+0%', '-0%') else change}"
            for size, change in zip(others, changes, strict=True)
        ]
        text += f" {'; '.join(each)}."
    band = f" ± {scatter:.2g}" if np.isfinite(scatter) and shown(fine + scatter) != shown(fine) else ""
    return f"{text} A fine bond would give about {shown(fine)}{band}."


# -- progress ----------------------------------------------------------------------------------------------------------


def runs_planned(model: str, blocks: int, directions: int, variants: int) -> str:
    """Return the line on the runs of a building: its directions, and the variants of the one that governs."""
    return (
        f"{model}: {counted(blocks, 'block')}; {counted(directions, 'direction')}, then {counted(variants, 'run')} for "
        "the range of the one that governs"
    )


def run_ended(case: str, status: Status, done: int, count: int, elapsed: float) -> str:
    """Return the line on a run that ended, with the time so far, s, and an estimate of the time left."""
    left = f", about {elapsed / done * (count - done):.0f} s left" if done < count else ""
    return f"run {done} of {count}, {case}: {status.words} after {elapsed:.0f} s{left}"


def building_interrupted(ended: Sequence[str], store: str | None) -> str:
    """Return the sentence on the runs of an interrupted building that have ended, and the file that keeps them."""
    runs = f"{counted(len(ended), 'run')} ended ({', '.join(ended)})" if ended else "no run ended"
    if store is None:
        return f"{runs}: give a store (store=, --store) to keep them, and the same call continues"
    return f"{store} keeps what was done, {runs}; the same call continues from there"


# -- the collapse state ------------------------------------------------------------------------------------------------


def associative_bound() -> Note:
    """Return the note on a load factor of associative flow."""
    text = "α0 is an upper bound, as flow is associative. Run the case non-associative before relying on it."
    return Note(NoteCode.ASSOCIATIVE_BOUND, Severity.WARNING, text)


def rounded_corners(radius: float, first: float, alpha0: float) -> Note:
    """Return the note on rounded corners: radius, m, first load factor of the curve, and α0."""
    text = (
        f"Corners are rounded by {1e3 * radius:.4g} mm in the capacity curve only. At rest its load factor is "
        f"{shown(first)}; α0 = {shown(alpha0)} belongs to the joints as modelled."
    )
    return _caution(NoteCode.ROUNDED_CORNERS, text)


def curve_doubt(clause: str) -> Note:
    """Return the note on a doubtful part of a capacity curve."""
    return _caution(NoteCode.CURVE_DOUBT, f"In the capacity curve {clause}.")


def curve_end(first: float, last: float) -> Note:
    """Return the note on a curve that ends before its load factor has come down."""
    text = (
        f"The capacity curve ends at a load factor of {shown(last)}, {shown(first)} at first, and the check relies on "
        "nothing after that. With other steps the curve may continue, if blocks come to rest again: compare two runs."
    )
    return _caution(NoteCode.CURVE_END, text)


def anchorages(names: Sequence[str]) -> Note:
    """Return the note on anchorages that give way at collapse."""
    text = (
        f"Anchorages that give way at collapse ({', '.join(names)}) are assumed to hold, but punching and bond fail in "
        "a brittle way. Design them for the strength of the bar, or leave the tie out."
    )
    return _caution(NoteCode.ANCHORAGES, text)


def out_of_plane() -> Note:
    """Return the note on bodies that do not move parallel to one plane."""
    text = "The bodies do not move parallel to one plane, for which the procedure is calibrated (C8.7.1.2.1.6)."
    return _caution(NoteCode.OUT_OF_PLANE, text)


def masses_differ(dead: float, pushed: float) -> Note:
    """Return the note on a dead load and a pushed weight, N, that differ."""
    text = (
        f"The dead load of the moving bodies is {dead / 1e3:.4g} kN, the weight of the pushed masses "
        f"{pushed / 1e3:.4g} kN. Some loads have mass without a horizontal force, or forces without weight."
    )
    return _caution(NoteCode.MASSES_DIFFER, text)


def small_motions(small: float, total: float, delta: float, *, e_star: float, a0_star: float) -> Note:
    """Return the note on bodies that move far less than the others along the push.

    Parameters
    ----------
    small, total
        Weight of these bodies and of all that move, N.
    delta
        Their largest displacement, relative to the largest of all.
    e_star, a0_star
        Without them: e* and a0*, m/s².
    """
    text = (
        f"Bodies of {shown(small / 1e3)} kN out of {shown(total / 1e3)} kN move less than half as far as the others in "
        f"the mean, up to {delta:.2g} of the largest δ. e* counts their whole weight, which raises a0*. Without "
        f"them e* = {shown(e_star)}, and a0* = {in_g(a0_star, g)}."
    )
    return _caution(NoteCode.SMALL_MOTIONS, text)


def other_motion(found: float, alpha: float, e_star: float, bodies: int) -> Note:
    """Return the note on a motion that a smaller acceleration activates than the collapse mechanism.

    Parameters
    ----------
    found
        α0 of the collapse mechanism.
    alpha, e_star, bodies
        Of the motion.
    """
    more = f"At {alpha / found - 1:.1%} more than α0" if alpha > 1.0005 * found else "At α0"
    text = (
        f"{more}, α = {shown(alpha)}, another motion of {counted(bodies, 'body', 'bodies')} with e* = {shown(e_star)} "
        "is activated. It needs a smaller a0* than the collapse mechanism."
    )
    return _caution(NoteCode.OTHER_MOTION, text)


def separate_mechanisms(count: int, checked: Sequence[tuple[str, float]], unfollowed: Sequence[str]) -> Note:
    """Return the note on mechanisms that begin at the same load factor.

    Parameters
    ----------
    count
        Number of mechanisms.
    checked
        Name and ratio of those that are checked, the lowest ratio first.
    unfollowed
        Names of those that the pushover does not follow.
    """
    (first, _), *others = checked
    text = f"{count} mechanisms begin at this load factor independently, and each has its own check. This is {first}"
    if others:
        text += f", with the lowest capacity / demand; {', '.join(f'{name} has {shown(r)}' for name, r in others)}"
    if unfollowed:
        text += f". The pushover does not follow {', '.join(unfollowed)}, which has no check by displacement"
    return _caution(NoteCode.SEPARATE_MECHANISMS, f"{text}.")


# -- the demand --------------------------------------------------------------------------------------------------------


def floor_below_ground(floor: float, ground: float) -> Note:
    """Return the note on a floor spectrum with a smaller peak, m/s², than the ground."""
    text = (
        f"The largest acceleration at this height, {in_g(floor, g)}, is below the largest on the ground, "
        f"{in_g(ground, g)}: the modes leave out the part that moves with the ground."
    )
    return _caution(NoteCode.FLOOR_BELOW_GROUND, text)


def ground_at_height(height: float, *, on_support: bool) -> Note:
    """Return the note on a ground spectrum for a mechanism that stands at a height, m."""
    where, unless = (" on a support", " unless that support is the ground") if on_support else ("", "")
    text = (
        f"The mechanism stands{where} {height:.3g} m above the foot of the structure, but the demand is the ground "
        f"spectrum, which the structure below amplifies{unless}. Give bs.assess.floor_spectrum(…), or --mode on the "
        "command line (C8.7.1.2.1.8)."
    )
    return _caution(NoteCode.GROUND_AT_HEIGHT, text)


def floor_on_ground(floor: float, ground: float) -> Note:
    """Return the note on a floor spectrum for a mechanism on a support, with both peaks, m/s²."""
    text = (
        "The mechanism stands on a support of the model, but the demand is a floor spectrum: at most "
        f"{in_g(floor, g)}, against {in_g(ground, g)} on the ground. If the support is the ground, give the ground "
        "spectrum, which usually demands less."
    )
    return _caution(NoteCode.FLOOR_ON_GROUND, text)


# -- what to rely on ---------------------------------------------------------------------------------------------------


def range_of_load_factor(range_text: str) -> Note:
    """Return the note on a load factor with a range."""
    return _caution(NoteCode.RANGE, f"The load factor is {range_text}. The check counts its lower end.")


def run_unsettled(schedule: str, load_factor: str, ratio: float) -> Note:
    """Return the note on a run of a spread that ended lower than the one relied on, and has not settled.

    Parameters
    ----------
    schedule, load_factor
        Of the run.
    ratio
        Capacity over demand at its load factor.
    """
    text = (
        f"The loading path with “{schedule}” ended at a load factor of {load_factor} and has not settled. There "
        f"capacity / demand is about {ratio_text(ratio)}."
    )
    if ratio >= 1:
        return _caution(NoteCode.RUN_UNSETTLED, text)
    return Note(NoteCode.RUN_UNSETTLED, Severity.WARNING, f"{text} Rule that out before signing.")


def control_point(d0: float, of_weights: float) -> Note:
    """Return the note on a control point that does not move with the weights.

    Parameters
    ----------
    d0, of_weights
        By the control point, and by the mean displacement of the weights P + Q, m.
    """
    text = (
        f"The control point gives d0 = {shown(d0, 'm')}, the mean of the weights P + Q {shown(of_weights, 'm')}: they "
        "do not move in proportion along the curve. Choose a control point near the centroid of the weights."
    )
    return _caution(NoteCode.CONTROL_POINT, text)


def overturns_alone(pushover: float, alone: float) -> Note:
    """Return the note on a body that by itself overturns before the pushover ends, with both d0, m."""
    text = (
        f"The pushover ends at d0 = {shown(pushover, 'm')}, but a body that turns about its hinge alone overturns at "
        f"{shown(alone, 'm')}. In the pushover, friction on its sides, which depends on self-stress, or other blocks "
        "hold it, too. Verify them, or use the smaller d0."
    )
    return _caution(NoteCode.OVERTURNS_ALONE, text)


def state_left_out(state: str, reason: str) -> Note:
    """Return the note on a limit state that could not be checked by displacement."""
    return _caution(NoteCode.STATE_LEFT_OUT, f"{state} by displacement was left out. {reason}.")


def state_missed(name: str, ratio: float, outcome: str) -> Note:
    """Return the note on a limit state that is not satisfied."""
    return _caution(NoteCode.STATE_MISSED, f"{name}: capacity / demand = {ratio_text(ratio)}, {outcome}.")


def changed_coefficients(changed: Sequence[tuple[str, float, float, str]]) -> Note:
    """Return the note on changed coefficients: name, value, default, paragraph."""
    values = ", ".join(f"{name} = {value:g} ({default:g} in {source})" for name, value, default, source in changed)
    return Note(NoteCode.COEFFICIENTS, Severity.INFO, f"Coefficients differ from the Circolare: {values}.")


# -- mechanisms by hand ------------------------------------------------------------------------------------------------


def hand_is_higher(height: float) -> Note:
    """Return the note on a mechanism by hand that stands higher, m, than the one found."""
    text = (
        f"The mechanism by hand stands {shown(height, 'm')} higher than the one found. Its own height usually demands "
        "more, so a larger α0 does not make it safer. Check it separately, with bs.assess.floor_spectrum(…)."
    )
    return _caution(NoteCode.HAND_IS_HIGHER, text)


def hand_is_lower(by_hand: float, found: float) -> Note:
    """Return the note on a mechanism by hand with a lower α0 than the one found."""
    text = (
        f"The mechanism by hand begins at α0 = {shown(by_hand)}, below the one found, {shown(found)}. Either it leaves "
        "out something that holds the blocks, or the model lacks something that it counts. Find out which before "
        "relying on either."
    )
    return Note(NoteCode.HAND_IS_LOWER, Severity.WARNING, text)


def edge_is_long(edge: float, joints: float, alpha0: float, less: float) -> Note:
    """Return the note on an edge, m, that is longer than the joints on its line, with α0 of both lengths."""
    text = (
        f"The edge named by hand is {shown(edge, 'm')} long, but the joints on its line are {shown(joints, 'm')} long, "
        f"as at a door. Only these crush: the hinge is set back further than u, and α0 = {shown(less)}, "
        f"{1 - less / alpha0:.0%} less. Give the compressive strength times {joints / edge:.3g}, with the same edge."
    )
    return _caution(NoteCode.EDGE_IS_LONG, text)


def edge_overhangs() -> Note:
    """Return the note on an edge beyond the block that the moving blocks stand on."""
    text = (
        "No joint with the blocks at rest lies at the edge named by hand. The blocks overhang their support and turn "
        f"about its edge at a lower load. Name an edge of a joint. {_OUTSIDE}"
    )
    return _caution(NoteCode.EDGE_OVERHANGS, text)


def edge_is_high(height: float, block: str, others: int) -> Note:
    """Return the note on an edge at a height, m, over some blocks, without a joint."""
    more = f" and {others} more" if others else ""
    text = (
        f"The edge named by hand lies {shown(height, 'm')} above the lowest point of block {block!r}{more}, without a "
        "joint that holds the blocks there. The parts below it would turn backwards. Name an edge at a joint, or only "
        f"blocks above it. {_OUTSIDE}"
    )
    return _caution(NoteCode.EDGE_IS_HIGH, text)
