"""Convert velocities of a problem to motions of blocks, and back."""

import numpy as np

from blockstruct.arrays import Array
from blockstruct.limit.problem import LimitProblem
from blockstruct.statics import Statics


def block_motion(statics: Statics, problem: LimitProblem, u: Array) -> Array:
    """Return the motions (n, B, 6) of all blocks at velocities u (n, rows).

    A motion is the velocity of the centroid and the angular velocity, in SI units.
    """
    F = len(statics.free)
    motion = np.zeros((len(u), len(statics.model.blocks), 6))
    motion[:, statics.free] = u[:, : 6 * F].reshape(-1, F, 6) / unit_of_velocity(problem)
    if problem.settlement is not None:
        speed = u[:, -1] / problem.settlement.force
        motion[:, problem.settlement.supports] = speed[:, None, None] * problem.settlement.motion
    return motion


def velocities_of(statics: Statics, problem: LimitProblem, motion: Array) -> Array:
    """Return the velocities u (n, rows) of motions (n, B, 6) in SI units.

    This is the inverse of :func:`block_motion`.
    """
    u = (motion[:, statics.free] * unit_of_velocity(problem)).reshape(len(motion), 6 * len(statics.free))
    if problem.settlement is None:
        return u
    unit, moved = problem.settlement.motion, motion[:, problem.settlement.supports]
    speed = np.einsum("nsc,sc->n", moved, unit) / (unit**2).sum()
    return np.column_stack([u, speed * problem.settlement.force])


def unit_of_velocity(problem: LimitProblem) -> Array:
    """Return the wrench units (F, 6) of free blocks, N and N·m.

    The units of velocity are their inverses.
    """
    return np.outer(problem.wrench_unit, np.repeat([1.0, problem.length], 3))
