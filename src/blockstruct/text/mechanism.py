"""Sentences on a collapse mechanism: bodies, joints, ties."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from blockstruct.text.numbers import LISTED
from blockstruct.vocabulary import AXES, coordinate, counted

Array = NDArray[np.float64]

#: Share of the whole weight, or of the largest value, below which a body, joint or force is not shown by itself.
SMALL = 0.02
#: Translation of a centroid, relative to the speed of its body, below which it counts as at rest.
_STAYS = 1e-3
#: Coordinate of an axis, relative to its distance from the centroid, below which it is solver noise.
_NOISE = 1e-5
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
    for k, (blocks, share, motion) in enumerate(bodies[:LISTED], start=1):
        names = f"{counted(len(blocks), 'block')} ({_listed(blocks, 'block')}; {share:.0%} of the weight)"
        sentences.append(f"{k}. A body of {names} {motion}.")
    more = len(bodies) - LISTED
    return sentences + [f"{more} smaller {'body moves' if more == 1 else 'bodies move'}, too."] * (more > 0)


def smaller_bodies(count: int) -> str:
    """Return the name of bodies that are summed."""
    return f"{counted(count, 'smaller body', 'smaller bodies')}"


def more_ties(count: int) -> str:
    """Return the sentence on ties that are not listed."""
    return f"There {'is' if count == 1 else 'are'} {counted(count, 'more tie')}."


def joints_sentence(kind: str, joints: Sequence[str]) -> str:
    """Return the sentence on joints that fail in one way, the most active first."""
    return f"{kind}: {len(joints)}, first {_listed(joints, 'joint')}." if len(joints) > 1 else f"{kind}: {joints[0]}."


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
        noise = _NOISE * np.linalg.norm(point - centroid)
        place = np.where(np.abs(point) <= noise, 0.0, np.round(point, 6) + 0.0)
        rest = [f"{name} = {coordinate(value)} m" for name, value in zip(AXES, place, strict=True)]
        where = f"the axis along {AXES[along]} through {', '.join(r for k, r in enumerate(rest) if k != along)}"
    else:
        place = np.round(point, 6) + 0.0
        where = f"an inclined axis near ({', '.join(map(coordinate, place))}) m"
    if np.linalg.norm(translation) <= _STAYS * speed:
        return f"turns about {where}; its centroid stays"
    # A body that overturns goes down, too: its direction is the level one.
    level = np.array([translation[0], translation[1], 0.0])
    if np.linalg.norm(level) <= abs(translation[2]):
        return f"moves towards {towards}, turning about {where}"
    verb = "leans" if abs(direction[2]) <= np.sqrt(0.5) else "swings"
    return f"{verb} towards {direction_text(level)}, turning about {where}"


def direction_text(vector: Array) -> str:
    """Return the axis nearest to a direction, with the component along it unless the direction is the axis."""
    length = np.linalg.norm(vector)
    if length == 0:
        return "nowhere"
    unit = vector / length
    along = int(np.abs(unit).argmax())
    share = abs(unit[along])
    name = f"{'+' if unit[along] > 0 else '−'}{AXES[along]}"
    return name if round(share, 2) == 1 else f"{name} ({share:.0%})"


def _listed(names: Sequence[str], noun: str) -> str:
    rest = len(names) - LISTED
    return ", ".join(names[:LISTED]) + (f" and {counted(rest, f'more {noun}')}" if rest > 0 else "")
