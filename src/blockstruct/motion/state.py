"""Define the states of a capacity curve, its end and its zero."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Self

import numpy as np

from blockstruct.arrays import Array, Index
from blockstruct.model import Case, SettlementCase
from blockstruct.vocabulary import CurveEnd


@dataclass(frozen=True, slots=True)
class MotionState:
    """One state of moving blocks, in SI units: forces at a placement, and the step to the next state.

    A step finds the first group of attributes. The second group is computed from the first and from earlier states.

    Attributes
    ----------
    load_factor : float
    position, rotation : (B, 3) arrays
        Centroids, m, and rotation vectors from where the model has the blocks, rad.
    velocity, angular_velocity : (B, 3) arrays
        Of the step, at 1 W of variable load.
    motion_time : float
        Time for which they act, s.
    inertia_time : float
        Time in which blocks at rest go the way of the step: ``M = mass / inertia_time²``; infinite without inertia.
    reach : float
        Largest gap of contact points, m.
    tie_force : (N,) array
        Of each tie of the model, N; zero once it has broken.
    minus_of_contact, plus_of_contact : (P,) arrays
        The two blocks at each contact point with a force.
    point_of_contact, normal_of_contact, force_of_contact : (P, 3) arrays
        Position, m, direction from the minus to the plus block, and force on the plus block, N.
    cell_of_contact : (P,) array
        Cell of a joint that crushes at each contact point with a force, −1 for none; empty without such joints.
    crushed_depth, crushed_share : (C,) arrays
        Depth that each cell has lost before the step, m, and share of its area that was crushed in the state before.
    crushed_slope : (C, 3) array
        Slope of each cell, as in :class:`~blockstruct.statics.Crushed`.
    solver_iterations : int
        Iterations of all solutions of the step.
    solver_time : float
        Seconds.

    displacement : float
        Of the control point along its direction, m.
    dissipation : float
        Work of friction, of crushing and of ties per unit of work of the variable load.
    work : float
        Work of the step, per unit of work of the variable load.
    inertia : float
        Share of the work of inertia in that work.
    falls : bool
        Whether this share is so large that blocks fall, while the control point hardly moves.
    tie_elongation : (N,) array
        Of each tie, m, beyond its length in the model.
    largest_crushed_depth : float
        Of all joints, m; zero without joints that crush.
    penetration : float
        Deepest penetration, m.
    energy_error : float
        Of the motion from the state before: work of the loads less what friction, crushing and ties dissipate, relative
        to the sum of the magnitudes of all such work so far.
    equilibrium_residual, yield_excess, interpenetration, flow_rule_gap : float
        As in :class:`Certificate`, on the moved geometry, with the force of inertia as a load; openings are those at
        the end of the step.
    holds : bool
        Whether they are within the tolerances of a step.
    contact_points : int
    """

    load_factor: float
    position: Array
    rotation: Array
    velocity: Array
    angular_velocity: Array
    motion_time: float
    inertia_time: float
    reach: float
    tie_force: Array
    minus_of_contact: Index
    plus_of_contact: Index
    point_of_contact: Array
    normal_of_contact: Array
    force_of_contact: Array
    cell_of_contact: Index
    crushed_depth: Array
    crushed_slope: Array
    crushed_share: Array
    solver_iterations: int
    solver_time: float

    displacement: float = np.nan
    dissipation: float = np.nan
    work: float = np.nan
    inertia: float = np.nan
    falls: bool = False
    tie_elongation: Array = np.nan  # type: ignore[assignment]
    largest_crushed_depth: float = np.nan
    penetration: float = np.nan
    energy_error: float = np.nan
    equilibrium_residual: float = np.nan
    yield_excess: float = np.nan
    interpenetration: float = np.nan
    flow_rule_gap: float = np.nan
    holds: bool = False
    contact_points: int = 0

    @property
    def twist(self) -> Array:
        """Velocities and angular velocities (B, 6)."""
        return np.column_stack([self.velocity, self.angular_velocity])


@dataclass(frozen=True, slots=True)
class CurveOutcome:
    """How and where a capacity curve ended.

    Attributes
    ----------
    end : CurveEnd
    displacement : float
        Of the control point, m.
    load_factor : float
        At which it would begin, if it does not begin.
    states : int
    blocks : tuple of str
        Those that the end is about: that move most, the fastest first, or touch.
    direction : tuple of float
        In which the first one moves.
    stands : bool
        Whether the control point rests or goes back.
    """

    end: CurveEnd
    displacement: float = np.nan
    load_factor: float = np.nan
    states: int = 0
    blocks: tuple[str, ...] = ()
    direction: tuple[float, ...] = ()
    stands: bool = False

    @property
    def text(self) -> str:
        """Its facts as a file keeps them."""
        return json.dumps(asdict(self))

    @classmethod
    def read(cls, text: str) -> Self | None:
        """Of what a file keeps; None of a curve that has not ended, or was made by an earlier version."""
        if not text.startswith("{"):
            return None
        facts = json.loads(text)
        listed = {name: tuple(facts[name]) for name in ("blocks", "direction")}
        return cls(**facts | listed | {"end": CurveEnd(facts["end"])})


#: What is zero on a curve: a load factor relative to the first one, a gap relative to the mean block size, a speed
#: relative to the fastest block, a length of a tie relative to its elongation limit.
ZERO = 1e-4


def zero_displacement(curve: Sequence[tuple[float, float]]) -> float:
    """Displacement at which the load factor of a curve of (displacement, load factor) is zero; NaN if it ends before.

    Interpolated over the last two states.
    """
    if not curve or curve[-1][1] > ZERO * abs(curve[0][1]):
        return np.nan
    if len(curve) == 1 or curve[-2][1] == curve[-1][1]:
        return curve[-1][0]
    (d0, a0), (d1, a1) = curve[-2:]
    return d1 + a1 * (d1 - d0) / (a0 - a1)


def largest_displacement(case: Case, displacement: Array, load_factor: Array, falls: Array) -> float:
    """Return the largest displacement of a curve at which the blocks are in equilibrium; NaN if it is not reached.

    For a pushover the load factor is zero there. At this displacement of supports that settle, blocks begin to fall.
    """
    stands = falls == 0
    if isinstance(case, SettlementCase):
        return float(displacement[np.flatnonzero(stands)[-1] + 1]) if stands.any() and not stands[-1] else np.nan
    return zero_displacement(list(zip(displacement[stands].tolist(), load_factor[stands].tolist(), strict=True)))
