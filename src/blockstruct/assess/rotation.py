"""Finite rotation of a rigid body about a fixed hinge."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from blockstruct.arrays import NEGLIGIBLE, SLIGHT, Array
from blockstruct.errors import ModelError
from blockstruct.model import LimitCase, LoadPattern, Model, tie_segments
from blockstruct.results import applied_loads

#: Number of angles at which a rotation is sampled.
SAMPLES = 60
#: Angles, from zero to a right angle, that bracket a wanted one.
_TRIED = np.linspace(0, np.pi / 2, 2000, endpoint=False)


@dataclass(frozen=True, slots=True)
class Pull:
    """A tie that pulls the body towards a point at rest.

    Attributes
    ----------
    name : str
    anchor, towards : (3,) arrays
        Its end on the body, and its other end, m.
    force : float
        N, at any elongation.
    limit : float
        Elongation at which it breaks, m; infinite without a limit.
    """

    name: str
    anchor: Array
    towards: Array
    force: float
    limit: float

    @property
    def direction(self) -> Array:
        """Direction of its pull, a unit vector."""
        along = self.towards - self.anchor
        return np.asarray(along / np.linalg.norm(along))


def pulls_at(model: Model, blocks: Collection[str], force: Array) -> list[Pull]:
    """Return the pulling ties between these blocks and others, from the forces (M,) of stretches, N."""
    segments = tie_segments(model.ties, model.blocks)
    found = []
    for segment, T in zip(segments, force.tolist(), strict=True):
        mine = [name in blocks for name in segment.blocks]
        if mine[0] != mine[1] and T > 0:
            near, far = np.array([segment.start, segment.end])[[mine.index(True), mine.index(False)]]
            found.append(Pull(segment.name, near, far, T, segment.elongation_limit))
    return found


@dataclass(frozen=True, slots=True)
class Load:
    """Forces with fixed directions at points that turn with a body.

    Attributes
    ----------
    force : (3,) array
        Sum of the forces, N.
    arms : (3, 3) array
        Sum of arms from a point of the hinge, along the first axis, times forces, N·m.
    """

    force: Array
    arms: Array

    def moment(self, turn: Array) -> Array:
        """Return the moment (3,) about that point after a rotation by a matrix (3, 3), N·m."""
        r = turn @ self.arms
        return np.array([r[1, 2] - r[2, 1], r[2, 0] - r[0, 2], r[0, 1] - r[1, 0]])

    def is_close(self, other: Self) -> bool:
        """Return whether forces and arms equal another load's within rounding."""
        pairs = ((self.force, other.force), (self.arms, other.arms))
        return all(np.allclose(one, of, rtol=0.0, atol=NEGLIGIBLE * np.abs(of).max()) for one, of in pairs)


@dataclass(frozen=True, slots=True)
class RigidRotation:
    """Moments about a fixed hinge of loads with fixed directions at points that turn with the body.

    Such a moment is ``A cos θ + B sin θ`` at the angle θ. With the moment T of the ties, whose forces turn with them,
    ``α(θ) = −(A_d cos θ + B_d sin θ + T(θ)) / (A_v cos θ + B_v sin θ)`` for dead and variable loads: for a block b × h
    on its base ``tan(atan(b/h) − θ)``.

    Attributes
    ----------
    hinge : (3,) array
        A point of the hinge, m.
    axis : (3,) array
        Unit vector along the hinge; the variable load does work at positive angles.
    dead, variable : Load
    ties : tuple of Pull
    """

    hinge: Array
    axis: Array
    dead: Load
    variable: Load
    ties: tuple[Pull, ...] = ()

    @classmethod
    def of(
        cls,
        model: Model,
        case: LimitCase,
        blocks: Sequence[int],
        hinge: Array,
        axis: Array,
        ties: Sequence[Pull] = (),
    ) -> Self:
        """Return the rotation of some blocks, by index, with the loads of a case on them.

        Raises
        ------
        ModelError
            If there are couples among the loads, or the variable load does not turn the body.
        """
        dead, variable = (_load(model, case, pattern, blocks, hinge) for pattern in (case.dead, case.variable))
        turning, later = (float(variable.moment(turn) @ axis) for turn in (np.eye(3), _across(axis)))
        reach = np.hypot(turning, later)
        if abs(turning) <= 1e-9 * reach or reach == 0:
            msg = (
                f"case {case.name!r}: {case.variable.name!r} does not turn these blocks about the hinge; choose another"
            )
            raise ModelError(msg)
        return cls(hinge, float(np.sign(turning)) * axis, dead, variable, tuple(ties))

    def load_factor(self, angle: float) -> float:
        """Return α at an angle, rad."""
        turn = self._turn(angle)
        held = sum(self.moment(tie, angle) for tie in self.ties)
        return float(-(self.dead.moment(turn) @ self.axis + held) / (self.variable.moment(turn) @ self.axis))

    def moment(self, tie: Pull, angle: float) -> float:
        """Return the moment of a tie about the hinge at an angle, N·m; negative against the push."""
        arm, force = self._pull(tie, angle)
        return float(force @ _across(self.axis) @ arm)

    def leaves(self, ends: tuple[float, float], normal: Array, angles: Array) -> float:
        """Return the least of these angles at which the resultant lies beyond the hinge; infinite if it stays.

        Moments about the axis balance at any angle. Moments along it balance only if the pressing force, which never
        pulls, acts between the ends of the hinge.

        Parameters
        ----------
        ends
            Ends of the hinge along the axis from its point, m.
        normal : (3,) array
            Direction of the pressure on the body: a unit vector across the axis.
        angles
            Ascending, rad.
        """
        across, room = np.cross(self.axis, normal), SLIGHT * (ends[1] - ends[0])

        def beyond(angle: float) -> float:
            turn, alpha = self._turn(angle), self.load_factor(angle)
            pulls, force = [self._pull(tie, angle) for tie in self.ties], self.force(angle)
            moment = self.dead.moment(turn) + alpha * self.variable.moment(turn) + sum(np.cross(*p) for p in pulls)
            pressed, along = -float(force @ normal), -float(moment @ across)
            return max(ends[0] * pressed - along, along - ends[1] * pressed) - room * pressed

        return first_reached(beyond, angles)

    def slides(self, friction: float, normal: Array, angles: Array) -> float:
        """Return the least of ascending angles, rad, at which the hinge lacks friction; infinite without one.

        Parameters
        ----------
        friction
            Friction coefficient of the hinge.
        normal : (3,) array
            Direction of the pressure on the body: a unit vector across the axis.
        angles
            Ascending, rad.
        """

        def beyond(angle: float) -> float:
            force = self.force(angle)
            pressed = -float(force @ normal)
            return float(np.linalg.norm(force + pressed * normal)) - friction * pressed

        return first_reached(beyond, angles)

    def force(self, angle: float) -> Array:
        """Return the force (3,) with which loads and ties press the hinge at an angle, N."""
        loads = self.dead.force + self.load_factor(angle) * self.variable.force
        return np.asarray(loads + sum(self._pull(tie, angle)[1] for tie in self.ties))

    def _pull(self, tie: Pull, angle: float) -> tuple[Array, Array]:
        """Return arm and force of a tie at an angle."""
        at = tie.anchor + self.moved(tie.anchor, angle)
        along = tie.towards - at
        return at - self.hinge, tie.force * along / np.linalg.norm(along)

    def _turn(self, angle: float) -> Array:
        along = np.outer(self.axis, self.axis)
        return np.asarray(along + np.cos(angle) * (np.eye(3) - along) + np.sin(angle) * _across(self.axis))

    def without(self, ties: Sequence[Pull]) -> Self:
        """Return the same body without some of its ties."""
        return replace(self, ties=tuple(tie for tie in self.ties if all(tie is not gone for gone in ties)))

    def capacity(self, begin: float = 0.0) -> float:
        """Return the least angle, from one on, at which α vanishes, rad; NaN without one."""
        if self.load_factor(begin) <= 0:
            return begin
        if not self.ties:
            A, B = (float(self.dead.moment(turn) @ self.axis) for turn in (np.eye(3), _across(self.axis)))
            return float(np.arctan2(-A, B)) if A < 0 < B else np.nan
        angle = first_reached(lambda angle: -self.load_factor(angle), np.append(begin, _TRIED[begin < _TRIED]))
        return angle if np.isfinite(angle) else np.nan

    def breaks(self, tie: Pull) -> float:
        """Return the angle, up to a right angle, at which a tie reaches its limit, rad; infinite without one.

        The square of its length is the one at rest plus ``2 (p · t (1 − cos θ) − a × p · t sin θ)``, with the arm p of
        its anchor across the axis a and the arm t of its other end.
        """
        arm, towards = tie.anchor - self.hinge, tie.towards - self.hinge
        across = arm - (arm @ self.axis) * self.axis
        cos, sin = float(across @ towards), float(np.cross(self.axis, across) @ towards)
        length, reach = float(np.linalg.norm(towards - arm)), float(np.hypot(cos, sin))
        at_limit = cos - (2 * length * tie.limit + tie.limit**2) / 2
        if at_limit < -reach:
            return np.inf
        angle = float(np.arctan2(sin, cos) + np.arccos(at_limit / reach))
        return angle if angle < np.pi / 2 else np.inf

    def moved(self, point: Array, angle: float) -> Array:
        """Return the displacement (3,) of a point of the body at an angle, m."""
        arm = point - self.hinge
        across = arm - (arm @ self.axis) * self.axis
        return np.asarray((np.cos(angle) - 1) * across + np.sin(angle) * (_across(self.axis) @ across))


def first_reached(excess: Callable[[float], float], tried: Array) -> float:
    """Return the least number at which a function is not below zero; infinite without one.

    It lies between the first of the tried numbers, in ascending order, that reaches zero and the one before.
    """
    from scipy.optimize import brentq

    below = None
    for at in tried.tolist():
        if excess(at) >= 0:
            return float(at if below is None else brentq(excess, below, at, xtol=1e-15))
        below = at
    return np.inf


def _across(axis: Array) -> Array:
    """Return the matrix (3, 3) of the cross product with an axis."""
    x, y, z = axis.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _load(model: Model, case: LimitCase, pattern: LoadPattern, blocks: Sequence[int], hinge: Array) -> Load:
    found = applied_loads(model, pattern, case.dead)
    on = np.isin(found.block, list(blocks))
    if found.couple[on].any():
        name = model.blocks[int(found.block[on][found.couple[on].any(axis=1)][0])].name
        msg = (
            f"load pattern {pattern.name!r}: a couple on block {name!r}, whose direction at a finite rotation is not "
            "known; give a pair of PointLoads"
        )
        raise ModelError(msg)
    return Load(found.force[on].sum(axis=0), (found.point[on] - hinge).T @ found.force[on])
