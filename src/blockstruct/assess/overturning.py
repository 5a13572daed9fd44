"""Linear kinematic analysis by hand: a named group of blocks turns about a named edge."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from blockstruct.arrays import NEGLIGIBLE, SLIGHT, Array
from blockstruct.assess.lines import Line, section
from blockstruct.assess.participation import HorizontalForces
from blockstruct.assess.rotation import SAMPLES, Pull, RigidRotation, pulls_at
from blockstruct.errors import ModelError
from blockstruct.errors import shown as as_given
from blockstruct.model import Block, LimitCase, Model, checked_tuple, tie_segments
from blockstruct.model.fit import OFF_FACE
from blockstruct.results import MacroBlock, applied_loads
from blockstruct.text import assessment
from blockstruct.text.note import EFFECT, Note
from blockstruct.text.numbers import shown
from blockstruct.units import QuantityLike, si, si_array
from blockstruct.vocabulary import JointOrientation, counted

_WHO = "overturning"


@dataclass(frozen=True, slots=True)
class Overturning:
    """A mechanism named by hand, and the multiplier that activates it.

    Attributes
    ----------
    blocks : tuple of str
    rotation : RigidRotation
        Rotation about the hinge.
    setback : float
        Distance of the hinge from the edge by crushing, m.
    alpha0 : float
        Multiplier of the weights P + Q that activates the mechanism.
    weight : float
        Σ (P + Q), N.
    d0 : float
        Displacement of their centroid along the push at which α vanishes without ties, m.
    lines : tuple of Line
    notes : tuple of Note
        Read them before relying on the multiplier.
    """

    blocks: tuple[str, ...]
    rotation: RigidRotation
    setback: float
    alpha0: float
    weight: float
    d0: float
    lines: tuple[Line, ...]
    notes: tuple[Note, ...] = ()

    def __str__(self) -> str:
        calculation = section(f"overturning of {counted(len(self.blocks), 'block')} about an edge", self.lines)
        return "\n".join([*(f"note: {text}" for text in self.notes), str(calculation)])


def overturning(
    model: Model,
    case: LimitCase,
    blocks: Iterable[str] | MacroBlock,
    edge: Any,
    *,
    compressive_strength: QuantityLike | None = None,
) -> Overturning:
    """Return α0 of blocks that turn as one body about an edge, [C8.7.1.1].

    The loads of the case on these blocks act, and ties to other blocks: with their capacities, or with their prestress
    if the rotation slackens them. Nothing else holds them, neither friction nor bond. Blocks that stand on them do not
    count; a line names them. d0 is the value without ties. If the resultant leaves the edge before, they turn about
    another edge, and a line states it. If no joint holds the edge, such as under blocks that overhang their support, a
    note says so.

    Parameters
    ----------
    model, case
        The structure, and its dead and variable loads.
    blocks
        Names of the blocks that turn as one, or a macro-block of a result.
    edge : quantity, length, shape (2, 3)
        Two ends of the edge. The joint crushes over its length.
    compressive_strength : quantity, stress
        Sets the hinge back from the edge by half the depth of the stress block, ``N / (2 f_c l)``, under dead load and
        ties. By default it is infinite.

    Raises
    ------
    ModelError
        If blocks are unknown, named twice or supports, the edge has no length or is not at the blocks, they do not
        overturn about it or ties lift them off it, the strength is not above zero or the edge upright, or the push is
        not horizontal.

    Examples
    --------
    >>> import blockstruct as bs
    >>> stone = bs.Material("stone", "20 kN/m^3")
    >>> ground = bs.Block.box("ground", "[-1, -1, -0.5] m", "[3, 3, 0.5] m", stone, fixed=True)
    >>> block = bs.Block.box("block", "[0, 0, 0] m", "[1, 1, 2] m", stone)
    >>> found = bs.detect_interfaces([ground, block], joint_material=bs.JointMaterial("dry", 0.7))
    >>> model = bs.Model("block", [ground, block], found)
    >>> push = bs.LoadPattern("push", [bs.BodyForce("+x")])
    >>> case = bs.LimitCase("push", bs.LoadPattern("dead", [bs.SelfWeight()]), push)
    >>> round(overturning(model, case, ["block"], bs.Q_([[1, 0, 0], [1, 1, 0]], "m")).alpha0, 6)
    0.5
    """
    if not isinstance(case, LimitCase):
        given = as_given(getattr(case, "name", case))
        msg = f"{_WHO}: case {given} is a {type(case).__name__}; give a LimitCase with a push"
        raise ModelError(msg)
    names = blocks.blocks if isinstance(blocks, MacroBlock) else checked_tuple(blocks, str, f"{_WHO}: blocks")
    bodies = _free_blocks(model, names)
    ends = _ends_of(edge, bodies)
    f_c = np.inf
    if compressive_strength is not None:
        f_c = si(compressive_strength, "stress", f"{_WHO}: compressive strength")
    if f_c <= 0:
        msg = f"{_WHO}: compressive strength {f_c:.4g} Pa; give more than zero, or leave it out for no setback"
        raise ModelError(msg)
    forces = HorizontalForces.of(model, case)
    index = model.block_index
    members = [index[name] for name in names]
    length = float(np.linalg.norm(ends[1] - ends[0]))
    axis, middle = (ends[1] - ends[0]) / length, ends.mean(axis=0)
    on = np.isin(forces.block, members)
    W, G = float(forces.weight[on].sum()), forces.weight[on] @ forces.point[on] / forces.weight[on].sum()
    dead, stretches = applied_loads(model, case.dead), tie_segments(model.ties, model.blocks)
    down = float(-dead.force[np.isin(dead.block, members), 2].sum())
    strengths = [np.array([getattr(s, name) for s in stretches]) for name in ("capacity", "prestress")]
    most, least = (pulls_at(model, set(names), force) for force in strengths)
    is_upright = bool(np.hypot(*axis[:2]) < NEGLIGIBLE)
    if is_upright and np.isfinite(f_c):
        msg = f"{_WHO}: an edge that is upright has no joint that weight crushes; leave compressive_strength out"
        raise ModelError(msg)
    inward = np.cross(axis, [0.0, 0.0, 1.0])
    inward *= 0.0 if is_upright else np.sign(inward @ (G - middle)) / np.linalg.norm(inward)

    def turning(crushed: float) -> tuple[RigidRotation, float, float]:
        """Return the rotation about the hinge, its setback and the force on it, with a length that crushes.

        The hinge decides which ties the rotation slackens, and the ties decide where the hinge is.
        """
        N, tried = 0.0, set[float]()
        while N not in tried:
            tried.add(N)
            setback = N / (2 * f_c * crushed)
            hinge = middle + setback * inward
            pulls = _pulls(RigidRotation.of(model, case, members, hinge, axis), most, least)
            N = _pressed(down, pulls)
        return RigidRotation.of(model, case, members, hinge, axis, pulls), setback, N

    rotation, setback, N = turning(length)
    pulls = rotation.ties
    alone = down / (2 * f_c * length)
    lines = _standing_on(model, set(names))
    if np.isfinite(f_c):
        lines.append(
            Line(
                "hinge set back by crushing",
                f"u = N / (2 f_c l) = {shown(N / 1e3, 'kN')} / (2 · {shown(f_c / 1e6, 'MPa')} · {shown(length, 'm')})"
                f" = {shown(setback, 'm')}",
                "rectangular stress block; C8.7.1.2.1.1",
            )
        )
    lines += [
        Line(
            f"tie {pull.name}",
            f"T = {shown(pull.force / 1e3, 'kN')}, M = {shown(-rotation.moment(pull, 0.0) / 1e3, 'kN m')}",
        )
        for pull in pulls
    ]
    alpha0 = rotation.load_factor(0.0) * forces.share
    if alpha0 <= 0 and is_upright:
        msg = f"{_WHO}: weight does not hold blocks that turn about an upright edge; give a level one, at their foot"
        raise ModelError(msg)
    if alpha0 <= 0:
        back = f", set back by {shown(setback, 'm')} by crushing" if setback else ""
        msg = (
            f"{_WHO}: about the edge{back}, dead load and ties do not hold the blocks against the push (α0 = "
            f"{shown(alpha0)}); give the edge that the push turns them about"
        )
        raise ModelError(msg)
    # Ties load or relieve the joint only while they pull.
    free = RigidRotation.of(model, case, members, middle + alone * inward, axis)
    theta0 = free.capacity() if free.load_factor(0.0) > 0 else np.nan
    d0 = float(free.moved(G, theta0) @ forces.direction) if np.isfinite(theta0) else np.nan
    crushed = f"and with u = {shown(alone, 'm')} " if alone else ""
    without = f"without ties {crushed}" if pulls else ""
    resisting = "(dead+T)" if pulls else "dead"
    held = sum(rotation.moment(pull, 0.0) for pull in pulls)
    at_rest = np.eye(3)
    stabilising = -(float(rotation.dead.moment(at_rest) @ rotation.axis) + held) / 1e3
    pushing = float(rotation.variable.moment(at_rest) @ rotation.axis) / forces.share / 1e3
    lines += [
        Line(
            "multiplier, moments about the hinge",
            f"α0 = M_{resisting} / M_(P+Q) = {shown(stabilising, 'kN m')} / {shown(pushing, 'kN m')} = {shown(alpha0)}",
            "C8.7.1.2.1.1 (C8.7.1.1)",
        ),
        Line("share of the mass", "e* = 1: one body", "C8.7.1.2.1.3 (C8.7.1.5)"),
        Line(
            "rotation at which α vanishes",
            f"{without}θ0 = {shown(theta0, 'rad')}; its centroid moves by d0 = {shown(d0, 'm')}"
            if np.isfinite(theta0)
            else "none: without ties the dead load overturns the blocks, or never does",
            "C8.7.1.2.1.2",
        ),
    ]
    left = _leaves(rotation, free, theta0, length)
    if np.isfinite(left):
        d = float(rotation.moved(G, left) @ forces.direction)
        lines.append(
            Line(
                "the resultant leaves the edge",
                f"at d = {shown(d, 'm')} its line of action is beyond the ends of the edge, {shown(length, 'm')} long: "
                f"the blocks go over to another edge{', and d0 is less' if left else ''}; run a Pushover",
                "C8.7.1.2.1.2",
            )
        )
    loads = rotation.dead.force + rotation.load_factor(0.0) * rotation.variable.force
    pressing = loads + sum((pull.force * pull.direction for pull in pulls), np.zeros(3))

    def alpha_of(crushed: float) -> float:
        return turning(crushed)[0].load_factor(0.0) * forces.share

    notes = _notes_of_joints(model, bodies, ends, pressing, alpha0, alpha_of)
    return Overturning(names, rotation, setback, alpha0, W, d0, tuple(lines), notes)


def _free_blocks(model: Model, names: Sequence[str]) -> list[Block]:
    """Return the blocks of names; refuse repeated names and supports."""
    twice = [name for name, times in Counter(names).items() if times > 1]
    if twice:
        msg = f"{_WHO}: blocks: {as_given(twice[0])} is given twice; name each block once"
        raise ModelError(msg)
    blocks = [model.block(name) for name in names]
    if not blocks or any(b.fixed for b in blocks):
        msg = f"{_WHO}: blocks: {len(blocks)}, of them supports: {sum(b.fixed for b in blocks)}; name free blocks"
        raise ModelError(msg)
    return blocks


def _ends_of(edge: Any, blocks: Sequence[Block]) -> Array:
    """Return the ends (2, 3) of an edge, m; refuse one without length or apart from the blocks."""
    ends = si_array(edge, "length", f"{_WHO}: edge")
    as_in = "give its two ends, as in Q_([[0, 0, 0], [5, 0, 0]], 'm')"
    if ends.shape != (2, 3):
        msg = f"{_WHO}: edge of shape {ends.shape}; {as_in}"
        raise ModelError(msg)
    if np.array_equal(*ends):
        msg = f"{_WHO}: both ends of the edge are at ({', '.join(f'{x:g}' for x in ends[0])}) m; {as_in}"
        raise ModelError(msg)
    corners = np.concatenate([b.shape.vertices for b in blocks])
    low, high = corners.min(axis=0), corners.max(axis=0)
    room = OFF_FACE * np.ptp(corners, axis=0).max()
    if np.any(ends < low - room) or np.any(ends > high + room):
        start, end, first, last = (np.round(point, 4).tolist() for point in (*ends, low, high))
        msg = (
            f"{_WHO}: the edge from {start} to {end} m is not at the blocks, which reach from {first} to {last} m; "
            "correct its points or their unit"
        )
        raise ModelError(msg)
    return ends


def _pulls(about: RigidRotation, most: Sequence[Pull], least: Sequence[Pull]) -> list[Pull]:
    """Return the ties that pull: with the most if the rotation lengthens them, else with the least."""
    return [p for p in most if about.moment(p, 0.0) < 0] + [p for p in least if about.moment(p, 0.0) >= 0]


def _leaves(rotation: RigidRotation, free: RigidRotation, theta0: float, length: float) -> float:
    """Return the angle at which the resultant leaves the edge; infinite if it stays.

    At rest the ties count, and then they do not.
    """
    level = np.array([0.0, 0.0, 1.0]) - rotation.axis[2] * rotation.axis
    if np.linalg.norm(level) < NEGLIGIBLE:
        return np.inf
    ends, normal = (-length / 2, length / 2), level / np.linalg.norm(level)
    at_rest = rotation.leaves(ends, normal, np.zeros(1))
    if np.isfinite(at_rest) or np.isnan(theta0):
        return at_rest
    return free.leaves(ends, normal, np.linspace(0.0, theta0, SAMPLES))


def _pressed(down: float, pulls: Sequence[Pull]) -> float:
    """Return the force with which dead load and ties press the blocks, N."""
    N = down - float(sum(p.force * p.direction[2] for p in pulls))
    if N <= 0 and pulls:
        msg = (
            f"overturning: ties pull the blocks up by {-N / 1e3:.4g} kN more than the dead load presses them down, so "
            "they lift; name a mechanism in which these ties pull less"
        )
        raise ModelError(msg)
    return N


def supporting(model: Model) -> list[tuple[str, str]]:
    """Return the blocks below and above each joint on which a block stands."""
    joints = [joint for joint in model.interfaces if joint.orientation is not JointOrientation.HEAD]
    return [(j.minus, j.plus) if j.normal[2] > 0 else (j.plus, j.minus) for j in joints]


def _standing_on(model: Model, names: set[str]) -> list[Line]:
    """Return the line on blocks that stand on these and are not among them."""
    counted = names | {b.name for b in model.blocks if b.fixed}
    standing = dict.fromkeys(above for below, above in supporting(model) if below in names and above not in counted)
    return [Line("standing on them, not counted", ", ".join(standing), "C8.7.1.2.1.1")] if standing else []


def _notes_of_joints(
    model: Model,
    bodies: Sequence[Block],
    ends: Array,
    pressing: Array,
    alpha0: float,
    alpha_of: Callable[[float], float],
) -> tuple[Note, ...]:
    """Return the note on an edge without a joint that takes the force on it, or with shorter joints that crush.

    ``alpha_of`` gives α0 with another length that crushes, m.
    """
    length = float(np.linalg.norm(ends[1] - ends[0]))
    axis = (ends[1] - ends[0]) / length
    up = np.array([0.0, 0.0, 1.0]) - axis[2] * axis
    if np.linalg.norm(up) < NEGLIGIBLE:
        return ()
    up /= np.linalg.norm(up)
    corners = np.concatenate([b.shape.vertices for b in bodies])
    near = SLIGHT * float(np.ptp(corners, axis=0).max())
    below = {b.name: float(((ends[0] - b.shape.vertices) @ up).max()) for b in bodies}
    joints = _joints_at(model, set(below), ends[0], axis, pressing, near)
    if any(begin <= length + near and end >= -near for begin, end in joints):
        total = float(shapely.union_all(shapely.linestrings([[(x, 0.0) for x in part] for part in joints])).length)
        less = alpha_of(total) if 0 < total < length / (1 + EFFECT) else alpha0
        return (assessment.edge_is_long(length, total, alpha0, less),) if less < (1 - EFFECT) * alpha0 else ()
    furthest = max(below, key=below.__getitem__)
    if below[furthest] <= near:
        return (assessment.edge_overhangs(),)
    others = sum(depth > near for depth in below.values()) - 1
    return (assessment.edge_is_high(below[furthest], furthest, others),)


def _joints_at(
    model: Model, names: set[str], start: Array, axis: Array, pressing: Array, near: float
) -> list[tuple[float, float]]:
    """Return begin and end along a line, m, of joints at the line on which a force presses the blocks."""
    found = []
    for joint in model.interfaces:
        inward = joint.normal if joint.plus in names else -joint.normal
        within = (joint.minus in names) == (joint.plus in names)
        if within or inward @ pressing >= -NEGLIGIBLE * np.linalg.norm(pressing):
            continue
        along = axis - (axis @ inward) * inward
        if np.linalg.norm(along) < NEGLIGIBLE:
            along = joint.polygon[1] - joint.polygon[0]
        along = along / np.linalg.norm(along)
        frame = np.array([along, np.cross(inward, along), inward])
        reach = (joint.polygon - start) @ axis
        box, at = joint.polygon @ frame.T, frame @ start
        with np.errstate(divide="ignore", invalid="ignore"):
            # Where the line enters and leaves the slabs between opposite sides of a box around the joint.
            sides = (np.array([box.min(axis=0) - near, box.max(axis=0) + near]) - at) / (frame @ axis)
        if max(reach.min(), sides.min(axis=0).max()) <= min(reach.max(), sides.max(axis=0).min()):
            found.append((float(reach.min()), float(reach.max())))
    return found
