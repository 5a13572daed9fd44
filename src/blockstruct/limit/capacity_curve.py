"""A state of a capacity curve, and where the curve comes to zero."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class FiniteStep:
    """One state of a pushover, in SI units: forces in equilibrium at a placement, and how it goes on from there.

    Attributes
    ----------
    load_factor : float
    displacement : float
        Of the control point along its direction, m.
    position, rotation : (B, 3) arrays
        Centroids, m, and rotation vectors from where the model has the blocks, rad.
    velocity, angular_velocity : (B, 3) arrays
        Of the mechanism there, at 1 W of variable load.
    motion_time : float
        Time for which they act until the next state, s, if that step is not halved.
    dissipation : float
        Work of friction and of ties per unit of work of the variable load.
    falling : float
        Work of the dead load that ties do not take up, likewise.
    dropped : bool
        Whether the motion is that of blocks that drop until they meet others, while all else stands all but still.
    drops_next : bool
        Whether they begin to on the way to the next state.
    tie_force, tie_elongation : (N,) arrays
        Of each tie of the model: N, zero once it has broken; and m, beyond its length in the model.
    minus_of_contact, plus_of_contact : (P,) arrays
        The two blocks at each contact point with a force.
    point_of_contact, normal_of_contact, force_of_contact : (P, 3) arrays
        Where it is, m, the direction from its minus to its plus block, and the force on the plus block, N.
    body : (B,) array
        The body that each block moves on as part of; that of the supports is zero.
    penetration : float
        Deepest penetration, m.
    energy_error : float
        Of the motion from the state before: work of the loads less what friction and ties dissipate, relative
        to the sum of the magnitudes of all such work so far.
    equilibrium_residual, yield_excess, interpenetration, flow_rule_gap : float
        As in :class:`Certificate`, on the moved geometry; openings are those at the end of the step.
    holds : bool
        Whether they are within the tolerances of a step.
    contact_points, programs, solver_iterations : int
        Of the state; and of all attempts at the step, also of those that led nowhere.
    solver_time : float
        Seconds of the whole step.
    divided : bool
        Whether the step to the state was divided: the next one is not.
    body_failures, body_waits : int
        Steps of bodies that failed one after the other, and programs of all blocks before bodies are tried again.
    """

    load_factor: float
    displacement: float
    position: Array
    rotation: Array
    velocity: Array
    angular_velocity: Array
    motion_time: float
    dissipation: float
    falling: float
    dropped: bool
    drops_next: bool
    tie_force: Array
    tie_elongation: Array
    minus_of_contact: Index
    plus_of_contact: Index
    point_of_contact: Array
    normal_of_contact: Array
    force_of_contact: Array
    body: Index
    penetration: float
    energy_error: float
    equilibrium_residual: float
    yield_excess: float
    interpenetration: float
    flow_rule_gap: float
    holds: bool
    contact_points: int
    programs: int
    solver_iterations: int
    solver_time: float
    divided: bool
    body_failures: int
    body_waits: int


#: Load factor, relative to the first one of a curve, that is zero.
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
