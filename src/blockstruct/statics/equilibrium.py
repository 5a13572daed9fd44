"""Assemble the equilibrium matrix A of (2) of docs/theory.md."""

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import Array, Index
from blockstruct.statics.contacts import ContactPoints


def equilibrium_matrix(
    points: ContactPoints,
    centroids: Array,
    free: Index,
    length: float,
    rotation: Array | None = None,
    least: float = 1e-12,
) -> sp.csc_array:
    """Return the matrix A of equilibrium ``A x + w_D + α w_L = 0``.

    Column 3k + v of A is the wrench of a unit force at contact point k along axis v of (n, s, t). It is
    ``[v; (p − c) × v]`` on the plus block, and its negative on the minus block.

    Parameters
    ----------
    points
        The K contact points.
    centroids : (B, 3) array, m
        Reference points of the moments.
    free : (F,) array
        Indices of the free blocks in the order of the rows. Each has six rows; supports have none.
    length
        Characteristic length, m; moments are divided by this length.
    rotation : (B, 3, 3) array
        Rotations of the blocks. The rows of a block are then in its rotated axes, so that rotation adds no entries.
    least
        Magnitude up to which entries are dropped as rounding. They would only fill the factorisation.

    Returns
    -------
    (6 F, 3 K) sparse array
    """
    n_points = len(points)
    row_of = np.full(len(centroids), -1)
    row_of[free] = 6 * np.arange(len(free))
    axes = points.frame[points.interface]
    column = 3 * np.arange(n_points)[:, None] + np.arange(3)
    rows, columns, values = [], [], []
    for sign, block in ((1.0, points.plus), (-1.0, points.minus)):
        on = row_of[block] >= 0
        arm = (points.position[on] - centroids[block[on]]) / length
        force = sign * axes[on]
        if rotation is not None:
            own = rotation[block[on]]
            arm, force = np.einsum("kij,ki->kj", own, arm), force @ own
        wrench = np.concatenate([force, np.cross(arm[:, None], force)], axis=2)
        shape = wrench.shape
        rows.append(np.broadcast_to(row_of[block[on]][:, None, None] + np.arange(6), shape).ravel())
        columns.append(np.broadcast_to(column[on][:, :, None], shape).ravel())
        values.append(wrench.ravel())
    value = np.concatenate(values)
    keep = np.abs(value) > least
    entries = (value[keep], (np.concatenate(rows)[keep], np.concatenate(columns)[keep]))
    return sp.csc_array(entries, shape=(6 * len(free), 3 * n_points))
