"""The capacity curve of a mechanism: spectral acceleration over spectral displacement."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from blockstruct.assess.lines import Line, shown
from blockstruct.assess.participation import HorizontalForces, Participation
from blockstruct.assess.rotation import RigidRotation
from blockstruct.errors import ModelError
from blockstruct.results import CaseResult, MacroBlock

Array = NDArray[np.float64]

#: Distance between the hinge of the forces and the axis of the velocities, in multiples of the extent of the body.
_APART = 2e-3


@dataclass(frozen=True, slots=True)
class CapacityCurve:
    """Acceleration a(d) of the equivalent oscillator, straight between its points.

    Attributes
    ----------
    displacement : (n,) array
        m, from 0 to d0.
    acceleration : (n,) array
        m/s².
    lines : tuple of Line
        Where it comes from.
    """

    displacement: Array
    acceleration: Array
    lines: tuple[Line, ...]

    @property
    def d0(self) -> float:
        """Where the acceleration vanishes, m."""
        return float(self.displacement[-1])

    def at(self, displacement: float) -> float:
        """Acceleration, m/s²."""
        return float(np.interp(displacement, self.displacement, self.acceleration))


def curve_of_rotation(
    result: CaseResult,
    bodies: Sequence[MacroBlock],
    forces: HorizontalForces,
    participation: Participation,
    a0_star: float,
) -> CapacityCurve:
    """Straight curve a0* (1 − d/d0) of one macro-block that turns about a fixed hinge, C8.7.1.2.1.2.

    The hinge is where the forces of the collapse state press, so that crushing sets it back. d0 is that of the finite
    rotation at which the load factor vanishes; the control point is the centroid of the weights P + Q.

    Raises
    ------
    ModelError
        A mechanism of several bodies, one that slides, or one that does not turn where it presses: it takes a pushover.
    """
    moving = [body for body in bodies if body.moves]
    if len(moving) != 1:
        msg = f"{len(moving)} bodies move against each other"
        raise ModelError(msg)
    body = moving[0]
    if body.axis is None:
        msg = "the body slides without turning, which has no d0"
        raise ModelError(msg)
    index = {b.name: i for i, b in enumerate(result.model.blocks)}
    members = [index[name] for name in body.blocks]
    direction, on_axis = body.axis
    hinge, depth = _pressed(result, members, direction)
    corners = np.concatenate([result.model.blocks[i].shape.vertices for i in members])
    apart = np.cross(direction, hinge - on_axis)
    if np.linalg.norm(apart) > _APART * np.ptp(corners, axis=0).max() + depth:
        msg = (
            f"the body turns about an axis {np.linalg.norm(apart):.3g} m from where its joints press: friction, "
            "tension or other bodies hold it, too"
        )
        raise ModelError(msg)
    turning = RigidRotation.of(result.model, result.case, members, hinge, direction)
    alpha = turning.load_factor(0.0)
    if abs(alpha - result.load_factor) > 1e-3 * result.load_factor:
        msg = (
            f"the weight about the hinge gives a load factor of {alpha:.4g}, not {result.load_factor:.4g}: more than "
            "weight resists"
        )
        raise ModelError(msg)
    theta0 = turning.capacity
    if np.isnan(theta0):
        msg = "the dead load does not overturn the body"
        raise ModelError(msg)
    on = np.isin(forces.block, members)
    control = forces.weight[on] @ forces.point[on] / forces.weight[on].sum()
    d_C = float(turning.moved(control, theta0) @ forces.direction)
    d0 = d_C * participation.factor / float(participation.displacement[0])
    where = ", ".join(f"{value:.4g}" for value in np.round(hinge, 6) + 0.0)
    lines = (
        Line("hinge", f"along ({_components(direction)}) through ({where}) m, where the joints press", "C8.7.1.2.1.1"),
        Line(
            "rotation at which α vanishes", f"θ0 = {shown(theta0, 'rad')} = {np.degrees(theta0):.4g}°", "C8.7.1.2.1.2"
        ),
        Line(
            "displacement of the oscillator",
            f"d0 = d_C,0 Σ(P+Q)δ² / (δ_C Σ(P+Q)δ) = {shown(d_C, 'm')} · {shown(d0 / d_C)} = {shown(d0, 'm')}; C is the "
            "centroid of the weights",
            "C8.7.1.2.1.3 (C8.7.1.4)",
        ),
        Line(
            "capacity curve",
            f"a(d) = a0* (1 − d/d0) = {shown(a0_star, 'm/s²')} (1 − d / {shown(d0, 'm')}), without an elastic branch",
            "C8.7.1.2.1.2, C8.7.1.2.1.3",
        ),
    )
    return CapacityCurve(np.array([0.0, d0]), np.array([a0_star, 0.0]), lines)


def _pressed(result: CaseResult, members: Sequence[int], axis: Array) -> tuple[Array, float]:
    """Mean point at which other bodies press these blocks, and the depth of the deepest stress block, m."""
    last, model = result.history.isel(iteration=-1), result.model
    index = {b.name: i for i, b in enumerate(model.blocks)}
    sides = np.array([[index[i.minus] in members, index[i.plus] in members] for i in model.interfaces])
    outside = sides[:, 0] != sides[:, 1]
    of_point = last["interface_of_contact_point"].to_numpy()
    at = outside[of_point]
    normal = last["contact_force"].transpose("contact_point", "component").to_numpy()[at, 0]
    position = last["contact_point_position"].to_numpy()[at]
    total = np.bincount(of_point[at], np.maximum(normal, 0), minlength=len(sides))
    strength, area = last["compressive_strength"].to_numpy(), last["interface_area"].to_numpy()
    used = np.where(outside, total / (strength * area), 0.0)
    extent = np.array([np.linalg.norm(np.ptp(np.cross(i.polygon, axis), axis=0)) for i in model.interfaces])
    return np.maximum(normal, 0) @ position / np.maximum(normal, 0).sum(), float((used * extent).max(initial=0.0))


def _components(vector: Array) -> str:
    return ", ".join(f"{value:.3g}" for value in np.round(vector, 6) + 0.0)
