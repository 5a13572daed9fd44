"""Motions of blocks, and of bodies of blocks that stay joined."""

from dataclasses import replace
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import ROUNDING, Array, Flags, Index
from blockstruct.limit.problem import LimitProblem
from blockstruct.statics.statics import Statics


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


_Matrix = TypeVar("_Matrix", sp.csr_array, sp.csc_array)


def joined(problem: LimitProblem, centroid: Array, body: Index) -> tuple[LimitProblem, sp.csr_array, Flags]:
    """Return the limit problem of rigid bodies.

    Parameters
    ----------
    problem
        Limit problem of the blocks, without a settlement.
    centroid : (F, 3) array
        Centroids of the free blocks, m.
    body : (F,) array
        Number of the body of each block, from zero.

    Returns
    -------
    problem
        The problem of the G bodies and of the contact points at which they touch others.
    motion : (6 F, 6 G) sparse array
        Matrix from velocities of the bodies to velocities of the blocks.
    between : (K,) array
        Whether each contact point belongs to the problem of the bodies.
    """
    unit = np.asarray(np.bincount(body, problem.wrench_unit), dtype=float)
    weighted = problem.wrench_unit[:, None] * centroid
    centre = np.column_stack([np.bincount(body, x) for x in weighted.T]) / unit[:, None]
    arm = (centroid - centre[body]) / problem.length
    values = np.tile(np.eye(6), (len(body), 1, 1))
    values[:, :3, 3:] = np.cross(np.eye(3), arm[:, None]).swapaxes(1, 2)
    values *= (problem.wrench_unit / unit[body])[:, None, None]
    rows, columns = np.broadcast_arrays(
        6 * np.arange(len(body))[:, None, None] + np.arange(6)[:, None], 6 * body[:, None, None] + np.arange(6)
    )
    shape = (6 * len(body), 6 * len(unit))
    motion = sp.csr_array((values.ravel(), (rows.ravel(), columns.ravel())), shape=shape)
    whole = replace(
        problem,
        A=without_rounding(sp.csc_array(motion.T @ problem.A), ROUNDING),
        w_D=np.asarray(motion.T @ problem.w_D),
        w_L=np.asarray(motion.T @ problem.w_L),
        ties=replace(problem.ties, columns=without_rounding(sp.csc_array(motion.T @ problem.ties.columns), ROUNDING)),
        wrench_unit=unit,
    )
    every = np.ones(len(unit), dtype=bool)
    return whole.part(every), motion, whole.points_of(every)


def without_rounding(matrix: _Matrix, least: float) -> _Matrix:
    """Return a matrix without its entries below a magnitude; the matrix itself is changed."""
    matrix.data[np.abs(matrix.data) < least] = 0.0
    matrix.eliminate_zeros()
    return matrix
