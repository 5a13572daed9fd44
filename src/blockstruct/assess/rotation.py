"""A rigid body that turns about a fixed hinge through finite angles."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.model import LimitCase, LoadPattern, Model
from blockstruct.results import applied_loads

Array = NDArray[np.float64]

#: Angles, between none and the right one, among which one is looked for.
_TRIED = 2000


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
        sign = float(np.sign(turning))
        dead, variable = ((sign * A, sign * B) for A, B in parts)
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
        return self.least_angle(lambda angle: -self.load_factor(angle))

    def least_angle(self, excess: Callable[[float], float]) -> float:
        """Least angle at which a function is no longer below zero, rad; NaN without one."""
        from scipy.optimize import brentq

        tried = np.linspace(0, np.pi / 2, _TRIED, endpoint=False)
        reached = np.flatnonzero([excess(angle) >= 0 for angle in tried.tolist()])
        if not len(reached):
            return np.nan
        k = int(reached[0])
        return 0.0 if k == 0 else float(brentq(excess, tried[k - 1], tried[k], xtol=1e-15))

    def moved(self, point: Array, angle: float) -> Array:
        """Displacement (3,) of a point of the body at an angle, m."""
        arm = point - self.hinge
        across = arm - (arm @ self.axis) * self.axis
        return np.asarray((np.cos(angle) - 1) * across + np.sin(angle) * np.cross(self.axis, across))


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
