"""A rigid body that turns about a fixed hinge through finite angles."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.model import LimitCase, LoadPattern, Model, Moment

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RigidRotation:
    """Moments about a fixed hinge of loads whose points turn with the body and whose directions do not.

    A moment is ``A cos θ + B sin θ`` at the angle θ, so that ``α(θ) = −(A_d cos θ + B_d sin θ) / (A_v cos θ + B_v sin
    θ)`` for dead and variable loads: for a block b × h on its base ``tan(atan(b/h) − θ)``.

    Attributes
    ----------
    hinge : (3,) array
        A point of it, m.
    axis : (3,) array
        Unit vector along it; positive angles are those in which the variable load does work.
    dead, variable : tuple of two floats
        A and B, N·m.
    """

    hinge: Array
    axis: Array
    dead: tuple[float, float]
    variable: tuple[float, float]

    @classmethod
    def of(cls, model: Model, case: LimitCase, blocks: Sequence[int], hinge: Array, axis: Array) -> Self:
        """Of the blocks of these indices and the loads of a case that act on them.

        Raises
        ------
        ModelError
            Couples among the loads, or a variable load that does not turn the body.
        """
        parts = [_moments(model, pattern, blocks, hinge, axis) for pattern in (case.dead, case.variable)]
        turning, reach = parts[1][0], np.hypot(*parts[1])
        if abs(turning) <= 1e-9 * reach or reach == 0:
            msg = (
                f"case {case.name!r}: {case.variable.name!r} does not turn these blocks about the hinge; choose another"
            )
            raise ModelError(msg)
        sign = float(np.sign(turning))
        dead, variable = ((sign * A, sign * B) for A, B in parts)
        return cls(hinge, sign * axis, dead, variable)

    def load_factor(self, angle: float) -> float:
        """α at an angle, rad."""
        turn = np.array([np.cos(angle), np.sin(angle)])
        return float(-(turn @ self.dead) / (turn @ self.variable))

    @property
    def capacity(self) -> float:
        """Angle θ0 at which α vanishes, rad; NaN where the dead load never overturns the body."""
        A, B = self.dead
        return float(np.arctan2(-A, B)) if A < 0 < B else np.nan

    def moved(self, point: Array, angle: float) -> Array:
        """Displacement (3,) of a point of the body at an angle, m."""
        arm = point - self.hinge
        across = arm - (arm @ self.axis) * self.axis
        return np.asarray((np.cos(angle) - 1) * across + np.sin(angle) * np.cross(self.axis, across))


def _moments(
    model: Model, pattern: LoadPattern, blocks: Sequence[int], hinge: Array, axis: Array
) -> tuple[float, float]:
    names = {model.blocks[i].name for i in blocks}
    couples = [load.block for load in pattern.loads if isinstance(load, Moment) and load.block in names]
    if couples:
        msg = (
            f"load pattern {pattern.name!r}: a couple on block {couples[0]!r}, whose direction at a finite rotation is "
            "not known; give a pair of PointLoads"
        )
        raise ModelError(msg)
    block, point, force = pattern.applied(model.blocks)
    on = np.isin(block, list(blocks))
    arm = point[on] - hinge
    turned = np.cross(axis, arm)
    return tuple(float(np.cross(r, force[on]).sum(axis=0) @ axis) for r in (arm, turned))  # type: ignore[return-value]
