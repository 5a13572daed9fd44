"""Describe the states of a capacity curve and find its zero."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class FiniteStep:
    """One state of a pushover and its motion towards the next, in SI units.

    The forces are in equilibrium at the placement of the blocks.

    Attributes
    ----------
    load_factor : float
    displacement : float
        Displacement of the control point along its direction, m.
    position, rotation : (B, 3) arrays
        Centroids, m, and rotation vectors from the orientation in the model, rad.
    velocity, angular_velocity : (B, 3) arrays
        Velocities of the mechanism at 1 W of variable load, m/s and rad/s.
    motion_time : float
        Time for which these velocities act until the next state, s, if that step is not halved.
    dissipation : float
        Work of friction and of ties per unit of work of the variable load.
    falling : float
        Work of the dead load that ties do not absorb, per unit of work of the variable load.
    dropped : bool
        Whether some blocks drop until they meet others while all other blocks are almost at rest.
    drops_next : bool
        Whether blocks begin to drop on the way to the next state.
    tie_force, tie_elongation : (N,) arrays
        Force of each tie of the model, N, zero after the tie breaks. Elongation from its length in the model, m.
    minus_of_contact, plus_of_contact : (P,) arrays
        Indices of the two blocks at each contact point with a force.
    point_of_contact, normal_of_contact, force_of_contact : (P, 3) arrays
        Position, m; direction from the minus to the plus block; force on the plus block, N.
    body : (B,) array
        Number of the body that each block moves with towards the next state; zero for the supports.
    penetration : float
        Deepest penetration, m.
    energy_error : float
        Work of the loads less the dissipation of friction and ties, in the motion from the previous state. It is
        relative to the sum of the magnitudes of all such work so far.
    equilibrium_residual, yield_excess, interpenetration, flow_rule_gap : float
        As in :class:`Certificate`, on the moved geometry, with the openings at the end of the step.
    holds : bool
        Whether these four measures are within the tolerances of a step.
    contact_points, programs, solver_iterations : int
        Number of contact points of the state. Programs and iterations of all attempts at the step, including failed
        ones.
    solver_time : float
        Solver time of the whole step, s.
    divided : bool
        Whether the step to this state was divided. The next step is then not divided.
    body_failures, body_waits : int
        Number of consecutive failed steps with bodies. Number of programs with all blocks before bodies are tried
        again.
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


#: Load factor, relative to the first of a curve, up to which it counts as zero.
ZERO = 1e-4


def zero_displacement(curve: Sequence[tuple[float, float]]) -> float:
    """Return the displacement at which the load factor of a curve is zero.

    The curve is a sequence of (displacement, load factor). The result is extrapolated or interpolated from the last
    two states. It is NaN if the curve ends before zero.
    """
    if not curve or curve[-1][1] > ZERO * abs(curve[0][1]):
        return np.nan
    if len(curve) == 1 or curve[-2][1] == curve[-1][1]:
        return curve[-1][0]
    (d0, a0), (d1, a1) = curve[-2:]
    return d1 + a1 * (d1 - d0) / (a0 - a1)
