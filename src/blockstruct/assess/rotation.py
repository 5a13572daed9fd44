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
    dead, variable : tuple of two floats
        A and B, N·m.
    ties : tuple of Pull
    """

    hinge: Array
    axis: Array
    dead: tuple[float, float]
    variable: tuple[float, float]
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
        parts = [_moments(model, case, pattern, blocks, hinge, axis) for pattern in (case.dead, case.variable)]
        turning, reach = parts[1][0], np.hypot(*parts[1])
        if abs(turning) <= 1e-9 * reach or reach == 0:
            msg = (
                f"case {case.name!r}: {case.variable.name!r} does not turn these blocks about the hinge; choose another"
            )
            raise ModelError(msg)
        # About the opposite axis A has the other sign; B, of the moment of arms that turn about it, keeps its own.
        sign = float(np.sign(turning))
        dead, variable = ((sign * A, B) for A, B in parts)
        return cls(hinge, sign * axis, dead, variable, tuple(ties))

    def load_factor(self, angle: float) -> float:
        """α at an angle, rad."""
        turn = np.array([np.cos(angle), np.sin(angle)])
        held = sum(self.moment(tie, angle) for tie in self.ties)
        return float(-(turn @ self.dead + held) / (turn @ self.variable))

    def moment(self, tie: Pull, angle: float) -> float:
        """Moment of a tie about the hinge at an angle, N·m; against the push below zero."""
        at = tie.anchor + self.moved(tie.anchor, angle)
        along = tie.towards - at
        return float(tie.force * np.cross(at - self.hinge, along) @ self.axis / np.linalg.norm(along))

    def elongation(self, tie: Pull, angle: float) -> float:
        """Elongation of a tie at an angle, m."""
        at = tie.anchor + self.moved(tie.anchor, angle)
        return float(np.linalg.norm(tie.towards - at) - np.linalg.norm(tie.towards - tie.anchor))

    def without(self, ties: Sequence[Pull]) -> Self:
        """The same body without some of its ties."""
        return replace(self, ties=tuple(tie for tie in self.ties if all(tie is not gone for gone in ties)))

    @property
    def capacity(self) -> float:
        """Least angle θ0 at which α vanishes, rad; NaN where the body is not overturned."""
        A, B = self.dead
        if not self.ties:
            return float(np.arctan2(-A, B)) if A < 0 < B else np.nan
        angle = first_reached(lambda angle: -self.load_factor(angle), _TRIED)
        return angle if np.isfinite(angle) else np.nan

    def breaks(self, tie: Pull) -> float:
        """Angle at which a tie reaches its limit, rad; infinite if it never does."""
        return first_reached(lambda angle: self.elongation(tie, angle) - tie.limit, _TRIED)

    def moved(self, point: Array, angle: float) -> Array:
        """Displacement (3,) of a point of the body at an angle, m."""
        arm = point - self.hinge
        across = arm - (arm @ self.axis) * self.axis
        return np.asarray((np.cos(angle) - 1) * across + np.sin(angle) * np.cross(self.axis, across))


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


def _moments(
    model: Model, case: LimitCase, pattern: LoadPattern, blocks: Sequence[int], hinge: Array, axis: Array
) -> tuple[float, float]:
    found = applied_loads(model, pattern, case.dead)
    on = np.isin(found.block, list(blocks))
    if found.couple[on].any():
        name = model.blocks[int(found.block[on][found.couple[on].any(axis=1)][0])].name
        msg = (
            f"load pattern {pattern.name!r}: a couple on block {name!r}, whose direction at a finite rotation is not "
            "known; give a pair of PointLoads"
        )
        raise ModelError(msg)
    arm = found.point[on] - hinge
    turned = np.cross(axis, arm)
    A, B = (float(np.cross(r, found.force[on]).sum(axis=0) @ axis) for r in (arm, turned))
    return A, B
