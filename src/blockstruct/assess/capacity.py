"""Capacity curve of a mechanism: spectral acceleration over spectral displacement, by hand or of a pushover."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import xarray as xr

from blockstruct.arrays import SLIGHT, Array, Flags
from blockstruct.assess.lines import Line
from blockstruct.assess.participation import HorizontalForces, Participation
from blockstruct.assess.rotation import SAMPLES, Pull, RigidRotation, pulls_at
from blockstruct.errors import ModelError
from blockstruct.model import LimitCase, Model
from blockstruct.results import MacroBlock, block_rotations
from blockstruct.results.case_result import CaseResult
from blockstruct.results.interfaces import at_points
from blockstruct.results.mechanism import TOGETHER, twists, velocities
from blockstruct.text.numbers import shown
from blockstruct.vocabulary import coordinate, counted


@dataclass(frozen=True, slots=True)
class CapacityCurve:
    """Acceleration a(d) of the equivalent oscillator, piecewise linear.

    Attributes
    ----------
    displacement : (n,) array
        m, from 0 to d0.
    acceleration : (n,) array
        m/s².
    lines : tuple of Line
        Steps of its calculation.
    losses : tuple of (float, float)
        Displacement, m, of each tie break, and the loss by all ties broken so far, relative to the largest
        acceleration. A pushover lists its other states, too, with the loss in the following step.
    """

    displacement: Array
    acceleration: Array
    lines: tuple[Line, ...]
    losses: tuple[tuple[float, float], ...] = ()

    @property
    def d0(self) -> float:
        """Displacement at which the acceleration vanishes, m."""
        return float(self.displacement[-1])

    def at(self, displacement: float) -> float:
        """Return the acceleration, m/s²; at a tie break, the value before the loss."""
        return float(np.interp(displacement, self.displacement, self.acceleration))

    def with_d0(self, d0: float) -> Self:
        """Return the same accelerations at displacements scaled to another d0, m."""
        share = d0 / self.d0
        losses = tuple((share * at, lost) for at, lost in self.losses)
        return replace(self, displacement=share * self.displacement, losses=losses)


def curve_of_rotation(
    result: CaseResult,
    case: LimitCase,
    bodies: Sequence[MacroBlock],
    forces: HorizontalForces,
    a0_star: float,
) -> CapacityCurve:
    """Return the curve of one macro-block that turns about a fixed hinge, C8.7.1.2.1.2.

    Without ties it is the straight line a0* (1 − d/d0). The hinge lies where the forces of the collapse state press, so
    crushing sets it back. d0 belongs to the finite rotation at which the load factor vanishes. The control point is the
    centroid of the weights P + Q. Ties pull with their force at collapse until they reach their elongation limit. Ties
    without a limit do not count, since nothing verifies that they hold until collapse (C8.7.1.2.1.6).

    Raises
    ------
    ModelError
        If a pushover is necessary: several bodies move, or the body slides, turns about another axis than its pressed
        edge, turns about a point, or turns about an edge that the resultant leaves.
    """
    instead = _instead(result.model)
    body, (direction, on_axis) = _turning_body(bodies, instead)
    index = result.model.block_index
    members = [index[name] for name in body.blocks]
    pressed = _Pressed.of(result, set(body.blocks), direction)
    hinge = pressed.point
    corners = np.concatenate([result.model.blocks[i].shape.vertices for i in members])
    apart = np.cross(direction, hinge - on_axis)
    near = SLIGHT * np.ptp(corners, axis=0).max()
    if np.linalg.norm(apart) > near + pressed.depth:
        msg = (
            f"the body turns about an axis {np.linalg.norm(apart):.3g} m from the pressure at its joints: friction, "
            "tension or other bodies also hold it, or it crushes towards a corner under an oblique push; "
            f"{instead}"
        )
        raise ModelError(msg)
    force = result.history["tie_force"].isel(iteration=-1).to_numpy() if result.model.ties else np.zeros(0)
    pulls = pulls_at(result.model, body.blocks, force)
    turning = RigidRotation.of(result.model, case, members, hinge, direction, pulls)
    alpha = turning.load_factor(0.0)
    if abs(alpha - result.load_factor) > SLIGHT * result.load_factor:
        msg = (
            f"the moments of weight and ties about the hinge give a load factor of {alpha:.4g}, not "
            f"{result.load_factor:.4g}: something else resists, too; {instead}"
        )
        raise ModelError(msg)
    on = np.isin(forces.block, members)
    control = forces.weight[on] @ forces.point[on] / forces.weight[on].sum()

    def displacement(angle: float) -> float:
        return float(turning.moved(control, angle) @ forces.direction)

    counted = turning.without([tie for tie in turning.ties if not np.isfinite(tie.limit)])
    if turning.ties and counted.load_factor(0.0) <= 0:
        msg = "the dead load overturns the body at rest without the ties that have no elongation limit: give them one"
        raise ModelError(msg)
    breaks = {tie.name: counted.breaks(tie) for tie in counted.ties}
    parts, losses, theta0 = _parts(counted, breaks)
    if np.isnan(theta0):
        msg = "the dead load does not overturn the body at any rotation"
        raise ModelError(msg)
    lost = [tie for tie in turning.ties if all(tie is not held for held in parts[-1][0].ties)]
    lift = sum(tie.force * float(tie.direction @ pressed.normal) for tie in lost)
    back = pressed.setback(turning.axis, near) * lift / pressed.force
    if back > SLIGHT * abs(float((control - hinge) @ np.cross(turning.axis, pressed.normal))):
        msg = (
            f"ties that lift the body break before α vanishes, or do not count ({', '.join(t.name for t in lost)}), "
            f"so its joints crush further than at collapse, which moves the hinge back by "
            f"{shown(back, 'm')}: check the model without these ties"
        )
        raise ModelError(msg)
    d0 = displacement(theta0)
    ends = pressed.ends(turning.axis, near)
    if ends[1] - ends[0] <= near:
        msg = (
            f"the body turns about a point and not about an edge, and may then go over to an edge next to it; {instead}"
        )
        raise ModelError(msg)
    left = min(current.leaves(ends, pressed.normal, angles) for current, angles, _ in parts)
    if np.isfinite(left):
        msg = (
            f"at d = {shown(displacement(left), 'm')}, before α vanishes about it at {shown(d0, 'm')}, the resultant "
            f"leaves the hinge, which is {shown(ends[1] - ends[0], 'm')} long: the body goes over to another "
            f"edge; {instead}"
        )
        raise ModelError(msg)
    # At collapse the friction found holds the body, whatever it consists of.
    at_rest = turning.force(0.0)
    pressing = -float(at_rest @ pressed.normal)
    most = (1 + SLIGHT) * max(pressed.friction, float(np.linalg.norm(at_rest + pressing * pressed.normal)) / pressing)
    slides = min(current.slides(most, pressed.normal, angles) for current, angles, _ in parts)
    if np.isfinite(slides):
        cohesive = any(i.joint_material.cohesion for i in result.model.interfaces)
        msg = (
            f"at d = {shown(displacement(slides), 'm')}, before α vanishes at {shown(d0, 'm')}, ties and constant "
            "loads need more friction at the hinge than there is"
            f"{' without cohesion' * cohesive}, and it slides; {instead}"
        )
        raise ModelError(msg)
    where = ", ".join(coordinate(value, 4) for value in np.round(hinge, 6) + 0.0)
    lines = [
        Line("hinge", f"along ({components(direction)}) through ({where}) m, where the joints press", "C8.7.1.2.1.1"),
        *(_tie_line(tie, breaks.get(tie.name), displacement) for tie in turning.ties),
        Line(
            "rotation at which α vanishes", f"θ0 = {shown(theta0, 'rad')} = {np.degrees(theta0):.4g}°", "C8.7.1.2.1.2"
        ),
        Line(
            "displacement of the oscillator",
            f"d0 = d_C,0 Σ(P+Q)δ² / (δ_C Σ(P+Q)δ) = d_C,0 = {shown(d0, 'm')}; C is the centroid of one body",
            "C8.7.1.2.1.3 (C8.7.1.4)",
        ),
    ]
    scale = a0_star / result.load_factor
    start = scale * counted.load_factor(0.0)
    source = "C8.7.1.2.1.2, C8.7.1.2.1.3"
    if not counted.ties:
        formula = (
            f"a(d) = a(0) (1 − d/d0) = {shown(start, 'm/s²')} (1 − d / {shown(d0, 'm')}), without an elastic branch"
        )
        lines.append(Line("capacity curve", formula, source))
        return CapacityCurve(np.array([0.0, d0]), np.array([start, 0.0]), tuple(lines))
    formula = (
        f"a(d) = α(θ) g / (e* FC), from {shown(start, 'm/s²')} to 0 at {shown(d0, 'm')}, with ties until they break"
    )
    lines.append(Line("capacity curve", formula, source))
    angles, factors = (np.concatenate(column) for column in list(zip(*parts, strict=True))[1:])
    d = np.array([displacement(angle) for angle in angles.tolist()])
    # Each loss has two points: one before it, and one just beyond.
    d = np.maximum.accumulate(np.where(np.diff(d, prepend=-1.0) <= 0, np.nextafter(d, np.inf), d))
    found = tuple((displacement(angle), loss) for angle, loss in losses)
    return CapacityCurve(d, scale * factors, tuple(lines), found)


def _turning_body(bodies: Sequence[MacroBlock], instead: str) -> tuple[MacroBlock, tuple[Array, Array]]:
    """Return the only body that moves, and its axis."""
    moving = [body for body in bodies if body.moves]
    if len(moving) != 1:
        msg = f"{len(moving)} bodies move against each other; {instead}"
        raise ModelError(msg)
    if moving[0].axis is None:
        msg = f"the body slides without turning, which has no d0; {instead}"
        raise ModelError(msg)
    return moving[0], moving[0].axis


def _parts(
    turning: RigidRotation, breaks: Mapping[str, float]
) -> tuple[list[tuple[RigidRotation, Array, Array]], list[tuple[float, float]], float]:
    """Return body, angles and load factors between tie breaks, the losses, and the last angle."""
    parts, losses, begin, current = [], [], 0.0, turning
    for tie in sorted(turning.ties, key=lambda tie: breaks[tie.name]):
        angle = breaks[tie.name]
        if not np.isfinite(angle) or current.capacity(begin) <= angle:
            break
        parts.append((current, *_sampled(current, begin, angle)))
        before, current, begin = current.load_factor(angle), current.without([tie]), angle
        losses.append((angle, before - max(current.load_factor(angle), 0.0)))
    end = current.capacity(begin)
    if np.isnan(end):
        return parts, losses, end
    parts.append((current, *_sampled(current, begin, end)))
    parts[-1][2][-1] = 0.0
    largest = max(float(factors.max()) for _, _, factors in parts)
    lost = np.cumsum([loss for _, loss in losses]) / largest
    return parts, list(zip([at for at, _ in losses], lost.tolist(), strict=True)), end


def _sampled(turning: RigidRotation, begin: float, end: float) -> tuple[Array, Array]:
    angles = np.linspace(begin, end, SAMPLES if begin < end else 1)
    return angles, np.maximum([turning.load_factor(angle) for angle in angles.tolist()], 0.0)


def _tie_line(tie: Pull, angle: float | None, displacement: Callable[[float], float]) -> Line:
    what = f"tie {tie.name}"
    if angle is None:
        formula = f"T = {shown(tie.force / 1e3, 'kN')}; without an elongation limit it is not counted in a(d)"
        return Line(what, formula, "C8.7.1.2.1.6")
    until = f"until d = {shown(displacement(angle), 'm')}" if np.isfinite(angle) else "always"
    return Line(
        what, f"T = {shown(tie.force / 1e3, 'kN')} {until}, an elongation of {shown(tie.limit, 'm')}", "C8.7.1.2.1.6"
    )


def _instead(model: Model) -> str:
    """Return the remedy for a missing straight curve, as the end of a message."""
    joints = [i.joint_material for i in model.interfaces]
    strong = any(j.cohesion or j.tensile_strength for j in joints)
    without = ", with joints that have neither cohesion nor a tensile strength" if strong else ""
    return f"run a Pushover{without}"


@dataclass(frozen=True, slots=True)
class _Pressed:
    """Pressure of other bodies on some blocks.

    Attributes
    ----------
    point, normal : (3,) arrays
        Mean point of the pressure, m, and its direction on the blocks, perpendicular to the axis.
    force : float
        Pressing force in that direction, N.
    friction : float
        Least friction coefficient of the pressing joints.
    depth : float
        Depth of the stress blocks, m: the axis lies within this distance, or the nearest corner, of the pressure.
    corners : (n, 3) array
        Corners of the joints with other bodies, m.
    """

    point: Array
    normal: Array
    force: float
    friction: float
    depth: float
    corners: Array

    @classmethod
    def of(cls, result: CaseResult, members: Collection[str], axis: Array) -> Self:
        last, model = result.history.isel(iteration=-1), result.model
        outside = np.array([(i.minus in members) != (i.plus in members) for i in model.interfaces])
        of_point = last["interface_of_contact_point"].to_numpy()
        at = outside[of_point]
        # If joints resist tension, the stress block carries the force beyond it.
        tension = last["tensile_strength"].to_numpy()[at]
        force = at_points(last, "contact_force")[at, 0]
        normal = np.maximum(force + tension, 0.0)
        if not normal.sum() > 0:
            msg = "nothing presses the body"
            raise ModelError(msg)
        position = last["contact_point_position"].to_numpy()[at]
        total = np.bincount(of_point[at], normal, minlength=len(outside))
        strength, area = last["compressive_strength"].to_numpy(), last["interface_area"].to_numpy()
        most = strength * area + np.bincount(of_point[at], tension, minlength=len(outside))
        joints = [i for i, at in zip(model.interfaces, outside, strict=True) if at]
        turned = np.column_stack([np.bincount(of_point[at], normal * x, minlength=len(outside)) for x in position.T])
        depths = [
            _depth(np.cross(i.polygon, axis), np.cross(moment / N, axis), N / largest)
            for i, moment, N, largest in zip(joints, turned[outside], total[outside], most[outside], strict=True)
            if N > 0
        ]
        pushes = total[outside] @ np.array([i.normal if i.plus in members else -i.normal for i in joints])
        pushes = pushes - (pushes @ axis) * axis
        pressing = float(np.linalg.norm(pushes))
        return cls(
            normal @ position / normal.sum(),
            pushes / pressing,
            pressing,
            min(
                i.joint_material.friction_coefficient
                for i, N in zip(joints, total[outside], strict=True)
                if SLIGHT * total[outside].max() < N
            ),
            max(depths),
            np.concatenate([i.polygon for i in joints]),
        )

    def setback(self, axis: Array, near: float) -> float:
        """Return the distance of the hinge from the corners furthest in front, m."""
        return float(self._before(axis, near)[1].max(initial=0.0))

    def ends(self, axis: Array, near: float) -> tuple[float, float]:
        """Return the ends of the hinge along the axis, m: of the corners on it, or in front if it is set back."""
        along, before = self._before(axis, near)
        at = along[before >= -near]
        return float(at.min(initial=np.inf)), float(at.max(initial=-np.inf))

    def _before(self, axis: Array, near: float) -> tuple[Array, Array]:
        """Return the positions of corners at the level of the hinge, along it and in front, m."""
        arm = self.corners - self.point
        arm = arm[np.abs(arm @ self.normal) <= near + self.depth]
        return arm @ axis, arm @ np.cross(axis, self.normal)


def _depth(corners: Array, point: Array, used: float) -> float:
    """Return a bound of the depth of a stress block across an axis, m.

    It starts at the corner nearest to its centre and is at most as deep as a square of the same area.
    """
    nearest = np.linalg.norm(corners - point, axis=1).min()
    return float(min(nearest, np.sqrt(used) * np.linalg.norm(np.ptp(corners, axis=0))))


def components(vector: Array) -> str:
    """Return the components of a direction as text, to three digits."""
    return ", ".join(f"{value:.3g}" for value in np.round(vector, 6) + 0.0)


def curve_of_pushover(
    result: CaseResult, capacity: xr.Dataset, push: Array, participation: Participation, a0_star: float
) -> CapacityCurve:
    """Return the capacity curve of a pushover, C8.7.1.2.1.2 and [C8.7.1.4].

    Parameters
    ----------
    result
        Collapse state of a pushover.
    capacity
        ``result.capacity``, used up to the first step whose certificate does not hold.
    push : (3,) array
        Direction of the push, a unit vector.
    participation
        Participation of the macro-blocks.
    a0_star
        Acceleration at the collapse state, m/s².

    Returns
    -------
    CapacityCurve
        Acceleration, m/s², over the displacement of the oscillator, m, from the collapse state on.

    Raises
    ------
    ModelError
        If the control point does not follow the push, rests in the mechanism or turns back, no step is
        certified, or a tie has no elongation limit.
    """
    case: Any = result.case
    block, direction = case.control
    unlimited = [t.name for t in result.model.ties if t.elongation_limit is None]
    if unlimited:
        msg = (
            f"tie {unlimited[0]!r} has no elongation limit, so nothing verifies that it holds until α vanishes "
            "(C8.7.1.2.1.6): give it one"
        )
        raise ModelError(msg)
    if np.linalg.norm(np.cross(direction, push)) > SLIGHT:
        # At a finite rotation, motion across the push is not proportional to motion along it.
        msg = (
            f"the control point at block {block!r} moves along ({components(direction)}), but the oscillator moves "
            "along the push (C8.7.1.2.1.3): run the pushover again with "
            f"control=({block!r}, ({components(push)}))"
        )
        raise ModelError(msg)
    model = result.model
    point = model.block(block).centroid if case.control_point is None else np.array(case.control_point)
    of_point = velocities(model, twists(result.mechanism), np.array(model.block_index[block]), point)
    delta = float(of_point @ direction) / participation.scale
    if abs(delta) < TOGETHER:
        msg = f"the control point at block {block!r} rests in the mechanism"
        raise ModelError(msg)
    certified = _certified(capacity)
    d_C = capacity["displacement"].transpose("step").to_numpy()[certified]
    side = np.sign(d_C[np.abs(d_C).argmax()])
    d_C = d_C * side
    back = _turns_back(d_C)
    if back.any():
        at = d_C[: int(back.argmax())].max()
        msg = (
            f"the control point at block {block!r} turns back at {shown(float(at), 'm')}, so its displacement no "
            f"longer measures the mechanism: {_remedy(capacity, certified, side * np.array(direction), d_C.max())}"
        )
        raise ModelError(msg)
    alpha = capacity["load_factor"].transpose("step").to_numpy()[certified]
    d_C, alpha = _onward(d_C, alpha)
    end = float(abs(capacity["d0"]))
    complete = bool(certified.all()) and np.isfinite(end)
    if complete:
        before = d_C < end
        d_C, alpha = np.append(d_C[before], end), np.append(alpha[before], 0.0)
    # Joints alone deform until the first state, where rounded corners carry less than the interfaces at collapse.
    beyond = d_C > max(d_C[0], 0.0)
    at_rest = min([result.load_factor, *alpha[~beyond]])
    d_C, alpha = np.append(0.0, d_C[beyond]), np.append(at_rest, alpha[beyond])
    if len(d_C) < 3 or np.any(np.diff(d_C) <= 0):
        msg = f"the pushover has {counted(len(d_C) - 1, 'certified step')}, or its control point stands still"
        raise ModelError(msg)
    steps = len(d_C) - 1
    breaks = np.zeros(0, dtype=np.int64)
    if "tie_break_displacement" in capacity:
        broke = np.abs(capacity["tie_break_displacement"].to_numpy())
        breaks = np.unique(np.searchsorted(d_C, broke[broke < d_C[-1]])) - 1
    factor = participation.factor / abs(delta)
    d, a = d_C * factor, a0_star / result.load_factor * alpha
    until = "where α vanishes" if complete else "its end before α vanishes, which counts as d0"
    lines = (
        Line("curve of the pushover", f"{steps} steps, to {shown(float(d_C[-1]), 'm')}, {until}", "C8.7.1.2.1.2"),
        Line(
            "displacement of the oscillator",
            f"d = d_C Σ(P+Q)δ² / (δ_C Σ(P+Q)δ) = d_C · {shown(factor)}; C is on block {block}",
            "C8.7.1.2.1.3 (C8.7.1.4)",
        ),
        Line(
            "capacity curve",
            f"a(d) = α(d_C) g / (e* FC), from {shown(float(a[0]), 'm/s²')}; d0 = {shown(float(d[-1]), 'm')}",
            "C8.7.1.2.1.3 (C8.7.1.3)",
        ),
    )
    # Loss in each step; ties count with the ties that broke before them.
    falls = -np.diff(alpha) / alpha.max()
    falls[breaks] = np.cumsum(falls[breaks])
    return CapacityCurve(d, a, lines, tuple(zip(d[:-1].tolist(), falls.tolist(), strict=True)))


def d0_of_weights(
    model: Model, capacity: xr.Dataset, forces: HorizontalForces, names: Sequence[str], e_star: float
) -> float:
    """Return d0 of a pushover, m, measured by the weights P + Q instead of the control point.

    It is their mean displacement along the push at the last certified step, over e*: [C8.7.1.4] with their mean δ as
    the δ of the control point.

    Parameters
    ----------
    model, capacity
        Model and ``result.capacity`` of the pushover.
    forces
        Weights P + Q, their points and the direction of the push.
    names
        Blocks whose weights count.
    e_star
        Participating share e* of the mass.
    """
    last = int(np.flatnonzero(_certified(capacity))[-1])
    index = model.block_index
    of = np.isin(forces.block, [index[name] for name in names])
    block, weight = forces.block[of], forces.weight[of]
    arm = forces.point[of] - np.array([b.centroid for b in model.blocks])[block]
    position = capacity["position"].transpose("step", "block", "axis").to_numpy()[last, block]
    now = position + np.einsum("nij,nj->ni", block_rotations(capacity)[last, block], arm)
    return float(weight @ ((now - forces.point[of]) @ forces.direction) / weight.sum() / e_star)


def _turns_back(way: Array) -> Flags:
    """Return the states, (state, …), in which displacements are smaller than before."""
    return np.asarray(np.maximum.accumulate(way) - way > SLIGHT * way.max(axis=0))


def _onward(way: Array, alpha: Array) -> tuple[Array, Array]:
    """Return the states below all later displacements, each with the least α since the state before it.

    Of several α at one displacement it keeps the lowest, so that a return motion never raises the curve.
    """
    nearest = np.minimum.accumulate(way[::-1])[::-1]
    on = np.flatnonzero(np.append(way[:-1] < nearest[1:], True))
    return way[on], np.minimum.reduceat(alpha, np.append(0, on[:-1] + 1))


def _remedy(capacity: xr.Dataset, certified: Flags, direction: Array, furthest: float) -> str:
    """Return the remedy for a control point that turns back."""
    position = capacity["position"].transpose("step", "block", "axis").to_numpy()[certified]
    way = (position - position[0]) @ direction
    on = np.where(_turns_back(way).any(axis=0), -np.inf, way[-1])
    if not on.max() > furthest:
        return "no block goes further without turning back; look at the states of the pushover (result.capacity)"
    return (
        f"run the pushover again with control= at block {str(capacity['block'].values[int(on.argmax())])!r}, which "
        f"reaches {shown(float(on.max()), 'm')}"
    )


def _certified(capacity: xr.Dataset) -> Flags:
    """Return which steps precede the first one whose certificate does not hold."""
    return np.cumprod(capacity["holds"].transpose("step").to_numpy()).astype(bool)
