"""A rigid body that turns about a fixed hinge through finite angles."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.model import LimitCase, LoadPattern, Model, tie_segments
from blockstruct.results import applied_loads

Array = NDArray[np.float64]

#: Angles, between none and the right one, among which one is looked for.
_TRIED = np.linspace(0, np.pi / 2, 2000, endpoint=False)
#: Difference of two loads, relative to the largest component, that is rounding.
_SAME = 1e-6
#: How far beyond the ends of a hinge its resultant may seem to lie, in multiples of its length.
_BEYOND = 1e-3


@dataclass(frozen=True, slots=True)
class Pull:
    """A tie that pulls the body towards a point that rests.

    Attributes
    ----------
    name : str
    anchor, towards : (3,) arrays
        Its end on the body and the other one, m.
    force : float
        N, whatever its elongation.
    limit : float
        Elongation at which it breaks, m; infinite if none was given.
    """

    name: str
    anchor: Array
    towards: Array
    force: float
    limit: float

    @property
    def direction(self) -> Array:
        """In which it pulls, a unit vector."""
        along = self.towards - self.anchor
        return np.asarray(along / np.linalg.norm(along))


def pulls_at(model: Model, blocks: Collection[str], force: Array) -> list[Pull]:
    """Ties between these blocks and other ones that pull, with forces (M,) of all stretches, N."""
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
    """Forces whose points turn with a body and whose directions do not.

    Attributes
    ----------
    force : (3,) array
        Their sum, N.
    arms : (3, 3) array
        Sum of arms from a point of the hinge, along the first axis, times forces, N·m.
    """

    force: Array
    arms: Array

    def moment(self, turn: Array) -> Array:
        """Moment (3,) about that point when the body has turned by a matrix (3, 3), N·m."""
        r = turn @ self.arms
        return np.array([r[1, 2] - r[2, 1], r[2, 0] - r[0, 2], r[0, 1] - r[1, 0]])

    def is_close(self, other: Self) -> bool:
        """Whether forces and arms are those of another load, but for rounding."""
        pairs = ((self.force, other.force), (self.arms, other.arms))
        return all(np.allclose(one, of, rtol=0.0, atol=_SAME * np.abs(of).max()) for one, of in pairs)


@dataclass(frozen=True, slots=True)
class RigidRotation:
    """Moments about a fixed hinge of loads whose points turn with the body and whose directions do not.

    Such a moment is ``A cos θ + B sin θ`` at the angle θ. With the moment T of the ties, whose forces turn with them,
    ``α(θ) = −(A_d cos θ + B_d sin θ + T(θ)) / (A_v cos θ + B_v sin θ)`` for dead and variable loads: for a block b × h
    on its base ``tan(atan(b/h) − θ)``.

    Attributes
    ----------
    hinge : (3,) array
        A point of it, m.
    axis : (3,) array
        Unit vector along it; positive angles are those in which the variable load does work.
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
        """Of the blocks of these indices and the loads of a case that act on them.

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
        """α at an angle, rad."""
        turn = self._turn(angle)
        held = sum(self.moment(tie, angle) for tie in self.ties)
        return float(-(self.dead.moment(turn) @ self.axis + held) / (self.variable.moment(turn) @ self.axis))

    def moment(self, tie: Pull, angle: float) -> float:
        """Moment of a tie about the hinge at an angle, N·m; against the push below zero."""
        arm, force = self._pull(tie, angle)
        return float(force @ _across(self.axis) @ arm)

    def leaves(self, ends: tuple[float, float], normal: Array, angles: Array) -> float:
        """Least angle among these at which the resultant lies beyond the ends of the hinge; infinite if it stays.

        The moments about the axis are in balance at any angle, but those along it only where the force that presses
        the hinge, which pushes and does not pull, acts between its ends.

        Parameters
        ----------
        ends
            Of the hinge, along the axis from its point, m.
        normal : (3,) array
            In which the body is pressed: a unit vector across the axis.
        angles
            Ascending, rad.
        """
        across, room = np.cross(self.axis, normal), _BEYOND * (ends[1] - ends[0])

        def beyond(angle: float) -> float:
            turn, alpha = self._turn(angle), self.load_factor(angle)
            pulls, force = [self._pull(tie, angle) for tie in self.ties], self.force(angle)
            moment = self.dead.moment(turn) + alpha * self.variable.moment(turn) + sum(np.cross(*p) for p in pulls)
            pressed, along = -float(force @ normal), -float(moment @ across)
            return max(ends[0] * pressed - along, along - ends[1] * pressed) - room * pressed

        return first_reached(beyond, angles)

    def slides(self, friction: float, normal: Array, angles: Array) -> float:
        """Least of ascending angles, rad, at which the hinge asks for more friction than it has; infinite without one.

        Parameters
        ----------
        friction
            Coefficient of it.
        normal : (3,) array
            In which the body is pressed: a unit vector across the axis.
        angles
            Ascending, rad.
        """

        def beyond(angle: float) -> float:
            force = self.force(angle)
            pressed = -float(force @ normal)
            return float(np.linalg.norm(force + pressed * normal)) - friction * pressed

        return first_reached(beyond, angles)

    def force(self, angle: float) -> Array:
        """Force (3,) with which loads and ties press the hinge at an angle, N."""
        loads = self.dead.force + self.load_factor(angle) * self.variable.force
        return np.asarray(loads + sum(self._pull(tie, angle)[1] for tie in self.ties))

    def _pull(self, tie: Pull, angle: float) -> tuple[Array, Array]:
        """Arm and force of a tie at an angle."""
        at = tie.anchor + self.moved(tie.anchor, angle)
        along = tie.towards - at
        return at - self.hinge, tie.force * along / np.linalg.norm(along)

    def _turn(self, angle: float) -> Array:
        along = np.outer(self.axis, self.axis)
        return np.asarray(along + np.cos(angle) * (np.eye(3) - along) + np.sin(angle) * _across(self.axis))

    def elongation(self, tie: Pull, angle: float) -> float:
        """Elongation of a tie at an angle, m."""
        at = tie.anchor + self.moved(tie.anchor, angle)
        return float(np.linalg.norm(tie.towards - at) - np.linalg.norm(tie.towards - tie.anchor))

    def without(self, ties: Sequence[Pull]) -> Self:
        """The same body without some of its ties."""
        return replace(self, ties=tuple(tie for tie in self.ties if all(tie is not gone for gone in ties)))

    def capacity(self, begin: float = 0.0) -> float:
        """Least angle from one on at which α is no longer above zero, rad; NaN where the body is not overturned."""
        if self.load_factor(begin) <= 0:
            return begin
        if not self.ties:
            A, B = (float(self.dead.moment(turn) @ self.axis) for turn in (np.eye(3), _across(self.axis)))
            return float(np.arctan2(-A, B)) if A < 0 < B else np.nan
        angle = first_reached(lambda angle: -self.load_factor(angle), np.append(begin, _TRIED[begin < _TRIED]))
        return angle if np.isfinite(angle) else np.nan

    def breaks(self, tie: Pull) -> float:
        """Angle, up to the right one, at which a tie reaches its limit, rad; infinite if it never does.

        The square of its length is that at rest plus ``2 (p · t (1 − cos θ) − a × p · t sin θ)``, with the arm p of its
        anchor across the axis a and the arm t of its other end.
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
        """Displacement (3,) of a point of the body at an angle, m."""
        arm = point - self.hinge
        across = arm - (arm @ self.axis) * self.axis
        return np.asarray((np.cos(angle) - 1) * across + np.sin(angle) * (_across(self.axis) @ across))


def first_reached(excess: Callable[[float], float], tried: Array) -> float:
    """Least number at which a function is no longer below zero, to the last digit; infinite without one.

    Among the numbers that are tried, in ascending order, it is found between the first that reaches it and the one
    before.
    """
    from scipy.optimize import brentq

    below = None
    for at in tried.tolist():
        if excess(at) >= 0:
            return float(at if below is None else brentq(excess, below, at, xtol=1e-15))
        below = at
    return np.inf


def _across(axis: Array) -> Array:
    """Matrix (3, 3) of the cross product with an axis."""
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
