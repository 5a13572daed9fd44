"""Sentences on a collapse mechanism: bodies, joints, ties, and supports that hold some motions only."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from blockstruct.arrays import NEGLIGIBLE, SLIGHT, Array
from blockstruct.vocabulary import AXES, SolverStatus, coordinate, counted, listed, shortened

#: Share of the whole weight, or of the largest value, below which a body, joint or force is not shown by itself.
SMALL = 0.02
#: Cosine of the largest angle (3°) between an axis of rotation and the coordinate axis that names it.
_ALONG = np.cos(np.radians(3.0))

NO_COLLAPSE_STATE = "There is no collapse state. The motion below is from the last iteration."
STEPS_OF_PATH = "Iterations along the loading path are steps of displacement; any other is a numerical step."
STEPS_OF_PROGRAMS = "Iterations of the history are numerical steps, not steps of loading."


def moving_sentence(moving: int, free: int, bodies: int, share: float, *, carried: bool) -> str:
    """Return how many free blocks move, as how many bodies, with which share of the weight."""
    weight = "the weight, carried weight included" if carried else "the weight"
    move = "moves" if moving == 1 else "move"
    return (
        f"{moving} of {counted(free, 'free block')} {move}, {share:.0%} of {weight}, "
        f"as {counted(bodies, 'body', 'bodies')}."
    )


def body_sentences(bodies: Sequence[tuple[Sequence[str], float, str]]) -> list[str]:
    """Return a sentence on each moving body: its blocks, its share of the weight, and a :func:`motion_clause`."""
    sentences = []
    for k, (blocks, share, motion) in enumerate(bodies, start=1):
        names = f"{counted(len(blocks), 'block')} ({listed(blocks, noun='block')}; {share:.0%} of the weight)"
        sentences.append(f"{k}. A body of {names} {motion}.")
    return shortened(sentences, lambda more: f"{more} smaller {'body moves' if more == 1 else 'bodies move'}, too.")


def smaller_bodies(count: int) -> str:
    """Return the name of bodies that are summed."""
    return f"{counted(count, 'smaller body', 'smaller bodies')}"


def more_ties(count: int) -> str:
    """Return the sentence on ties that are not listed."""
    return f"There {'is' if count == 1 else 'are'} {counted(count, 'more tie')}."


def joints_sentence(kind: str, joints: Sequence[str]) -> str:
    """Return the sentence on joints that fail in one way, the most active first."""
    many = f"{len(joints)}, the most active first: " * (len(joints) > 1)
    return f"{kind}: {many}{listed(joints, noun='joint')}."


def failure_clause(states: Iterable[tuple[str, str]]) -> str:
    """Return the clause on the joints at which a structure fails, with their states."""
    joints = ", ".join(f"{name} ({state})" for name, state in states)
    return f"; it fails at {joints}" if joints else ""


def motion_clause(translation: Array, axis: tuple[Array, Array] | None, centroid: Array, speed: float) -> str:
    """Return how a body moves, as the end of a sentence.

    Parameters
    ----------
    translation, centroid : (3,) arrays
        Velocity of the centroid, and its place, m.
    axis : tuple of (3,) arrays or None
        Direction and nearest point, m, of the axis of rotation; None if the body slides.
    speed
        Largest velocity of the body, in the unit of the translation.
    """
    towards = direction_text(translation)
    if axis is None:
        return f"moves towards {towards} without turning"
    direction, point = axis
    along = int(np.abs(direction).argmax())
    if abs(direction[along]) > _ALONG:
        noise = NEGLIGIBLE * np.linalg.norm(point - centroid)
        place = np.where(np.abs(point) <= noise, 0.0, np.round(point, 6) + 0.0)
        rest = [f"{name} = {coordinate(value)} m" for name, value in zip(AXES, place, strict=True)]
        where = f"the axis along {AXES[along]} through {', '.join(r for k, r in enumerate(rest) if k != along)}"
    else:
        place = np.round(point, 6) + 0.0
        where = f"an inclined axis near ({', '.join(map(coordinate, place))}) m"
    if np.linalg.norm(translation) <= SLIGHT * speed:
        return f"turns about {where}; its centroid stays"
    # A body that overturns goes down, too: its direction is the level one.
    level = np.array([translation[0], translation[1], 0.0])
    if np.linalg.norm(level) <= abs(translation[2]):
        return f"moves towards {towards}, turning about {where}"
    verb = "leans" if abs(direction[2]) <= np.sqrt(0.5) else "swings"
    return f"{verb} towards {direction_text(level)}, turning about {where}"


def direction_text(vector: Array) -> str:
    """Return the axis nearest to a direction, with the angle between them unless it is small.

    >>> direction_text(np.array([1.0, 0.05, 0.0])), direction_text(np.array([0.0, -1.0, 0.5]))
    ('+x', '−y (27° off)')
    """
    length = np.linalg.norm(vector)
    if length == 0:
        return "nowhere"
    unit = vector / length
    along = int(np.abs(unit).argmax())
    share = abs(unit[along])
    name = f"{'+' if unit[along] > 0 else '−'}{AXES[along]}"
    return name if round(share, 2) == 1 else f"{name} ({np.degrees(np.arccos(share)):.0f}° off)"


def tie_title(name: str, kind: str = "tie") -> str:
    """Return the name of a tie for a sentence, after the word tie unless it has it.

    >>> tie_title("left"), tie_title("tie 1"), tie_title("left tie")
    ('tie left', 'tie 1', 'left tie')
    """
    return name if "tie" in name.casefold() else f"{kind} {name}"


def tie_sentence(
    name: str, force: float, capacity: float, governing: str, state: str, elongation: float, limit: float, at: float
) -> str:
    """Return the sentence on a tie at collapse, from a row of :func:`blockstruct.results.ties_at_collapse`."""
    text = f"{tie_title(name, 'Tie')}: {state}, {kilonewton(force)} of {kilonewton(capacity)} ({governing})"
    if elongation > SLIGHT:
        text += f"; it lengthens by {elongation:.3g} times the largest block displacement"
        if np.isfinite(at):
            text += f" and reaches its limit of {limit * 1e3:.4g} mm at {at * 1e3:.4g} mm, to first order"
    return f"{text}."


def least_ties_sentence(
    load_factor: float,
    forces: Mapping[str, float],
    solver_status: SolverStatus,
    governing: str,
    *,
    is_associative: bool,
    proven: bool,
) -> str:
    """Return the sentence on the ties of least total strength that carry a load factor.

    Parameters
    ----------
    load_factor
    forces
        Strength of each tie, N; NaN if no strength is enough.
    solver_status
        How the program ended.
    governing
        ``"load factor"``, ``"dead load"`` or ``"both"``: the requirement that sets the strengths.
    is_associative, proven
        Flow of the case, and whether weaker ties are proven to be too weak.
    """
    total = sum(forces.values())
    if np.isnan(total):
        is_infeasible = solver_status is SolverStatus.INFEASIBLE
        why = "no strength of these is enough" if is_infeasible else f"the solver ended as {solver_status}"
        at = ", under the dead load alone" if governing == "dead load" else ""
        return f"load factor {load_factor:.6g}: none ({', '.join(forces)}: {why}{at})"
    # The residual force of a tie that is not needed is the solver's rounding.
    rounded = {name: force if force > NEGLIGIBLE * total else 0.0 for name, force in forces.items()}
    each = ", ".join(f"{name} {force / 1e3:.5g} kN" for name, force in rounded.items())
    clauses = [f"load factor {load_factor:.6g}: {total / 1e3:.5g} kN in all ({each})"]
    if not is_associative:
        clauses.append("with associative flow: without dilatancy these ties may carry less, run the case with them")
    if governing == "dead load":
        clauses.append("the dead load alone asks for them")
    if not proven and governing == "both":
        clauses.append("not proven, the dead load alone asks for others than the load factor: a smaller sum may do")
    elif not proven:
        clauses.append("not proven, the certificate does not hold")
    return "; ".join(clauses)


def kilonewton(force: float) -> str:
    """Return a force in N as text in kN."""
    return f"{force / 1e3:.4g} kN"


def weight_text(total: float, carried: float) -> str:
    """Return the weight of a body and the carried part, N, as text in kN."""
    return f"{kilonewton(total)}{f', {kilonewton(carried)} of it carried' if carried else ''}"


def roller_sentences(reactions: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Return a sentence on each support, with its reactions, N and N·m, in the motions that it holds.

    >>> roller_sentences({"head": {"x": -7200.0, "ry": 0.0}})
    ['Support head holds x with -7.2 kN and ry with 0 kN·m.']
    """
    sentences = []
    for name, of_support in reactions.items():
        parts = [f"{motion} with {kilonewton(value)}{'·m' * ('r' in motion)}" for motion, value in of_support.items()]
        held = " and ".join(filter(None, (", ".join(parts[:-1]), parts[-1])))
        sentences.append(f"Support {name} holds {held}.")
    return shortened(sentences, "{} more such supports have reactions: result.support_reactions.".format)


def breaking_clause(
    breaks: Sequence[tuple[str, float, float]], before: float, after: float, *, is_reaction: bool
) -> str:
    """Return the clause on ties that break together: name, displacement, m, and elongation, m.

    The load factor, or the reaction, N, is ``before`` in the state before, and ``after`` in the state after.
    """
    each = [
        f"{tie_title(str(name))} breaks at a displacement of {at * 1e3:.4g} mm, {longer * 1e3:.4g} mm longer"
        for name, at, longer in breaks
    ]
    if is_reaction:
        return f"{' and '.join(each)}: the reaction changes from {kilonewton(before)} to {kilonewton(after)}"
    return f"{' and '.join(each)}: the load factor falls from {before:.4g} to {after:.4g}"


def more_breaks(count: int) -> str:
    """Return the clause on ties that break and are not listed."""
    return f"{count} more {'tie breaks' if count == 1 else 'ties break'}"


def ties_in_motion(ties: Sequence[tuple[str, float, float]]) -> list[str]:
    """Return a sentence on each tie under a record: name, largest elongation, m, and time of its break, s, or NaN.

    >>> ties_in_motion([("bar", 0.0123, float("nan")), ("chain", 0.2, 1.25)])
    ['Tie bar holds: it lengthens by at most 12.3 mm.', 'Tie chain breaks at 1.25 s.']
    """
    sentences = []
    for name, elongation, at in ties:
        title = tie_title(name)
        ends = f"breaks at {at:.4g} s" if at == at else f"holds: it lengthens by at most {1e3 * elongation:.4g} mm"
        sentences.append(f"{title[:1].upper()}{title[1:]} {ends}.")
    return shortened(sentences, "{} more ties: result.response.peak_tie_elongation.".format)


def crushed_joints(depth: float) -> list[str]:
    """Return a sentence on the largest depth, m, that joints lose in motion; none if it is zero.

    >>> crushed_joints(0.00312)
    ['Joints are crushed by up to 3.12 mm.']
    """
    return [f"Joints are crushed by up to {1e3 * depth:.3g} mm."] if depth > 0 else []


def holding_ties(ties: Sequence[tuple[str, float, float]]) -> list[str]:
    """Return a sentence on each tie that does not break: name, largest elongation, m, and largest force, N."""
    sentences = []
    for name, elongation, force in ties:
        title = tie_title(name)
        lengthens = f"it lengthens by at most {1e3 * elongation:.4g} mm, under {kilonewton(force)} at most"
        sentences.append(f"{title[:1].upper()}{title[1:]} holds: {lengthens}.")
    return shortened(sentences, lambda more: f"{more} more hold{'s' * (more == 1)}, too.")
