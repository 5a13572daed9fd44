"""Join blocks to rigid bodies."""

from dataclasses import replace
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import Array, Flags, Index
from blockstruct.limit.problem import LimitProblem

_Matrix = TypeVar("_Matrix", sp.csr_array, sp.csc_array)

#: Magnitude below which entries of the equilibrium matrix of bodies are rounding.
_ROUNDING = 1e-10


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
        A=without_rounding(sp.csc_array(motion.T @ problem.A), _ROUNDING),
        w_D=np.asarray(motion.T @ problem.w_D),
        w_L=np.asarray(motion.T @ problem.w_L),
        ties=replace(problem.ties, columns=without_rounding(sp.csc_array(motion.T @ problem.ties.columns), _ROUNDING)),
        wrench_unit=unit,
    )
    every = np.ones(len(unit), dtype=bool)
    return whole.part(every), motion, whole.points_of(every)


def without_rounding(matrix: _Matrix, least: float) -> _Matrix:
    """Return a matrix without its entries below a magnitude; the matrix itself is changed."""
    matrix.data[np.abs(matrix.data) < least] = 0.0
    matrix.eliminate_zeros()
    return matrix
