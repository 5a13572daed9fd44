"""The equations of equilibrium with the contacts eliminated: six unknowns a free block."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.solvers.interior_point.conditions import Conditions, Weights

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Relative addition to the diagonal, which keeps a pivot of a block that nothing holds away from zero.
REGULARISATION = 1e-13
#: The matrix is symmetric in its pattern and nearly so in its values: no pivoting, a symmetric ordering.
OPTIONS = {"SymmetricMode": True, "Equil": False}


class SchurComplement:
    """``A (C + Fᵀ W⁻² E)⁻¹ Aᵀ``: pattern and ordering are found once.

    Parameters
    ----------
    A : (6 F, N) sparse array
        Equilibrium, with empty columns for auxiliary variables.
    conditions
        Whose groups each stand between two blocks at most.
    """

    def __init__(self, A: sp.csc_array, conditions: Conditions) -> None:
        # The one row of a settlement is a block of its own.
        n_blocks = -(-A.shape[0] // 6)
        self._stacks, pairs = _stacks(sp.csc_array(A), conditions, n_blocks)
        unknowns = (6 * pairs[:, :, None] + np.arange(6)).reshape(len(pairs), 12)
        rows, columns = np.repeat(unknowns, 12, axis=1).ravel(), np.tile(unknowns, (1, 12)).ravel()
        n = self._size = A.shape[0]
        # A support stands for the block after the last.
        self._kept = (rows < n) & (columns < n)
        rows, columns = rows[self._kept], columns[self._kept]
        pattern = sp.csc_matrix((np.ones(len(rows)), (rows, columns)), shape=(n, n))
        found = sp.linalg.splu(
            sp.csc_matrix(pattern + sp.diags_array(np.full(n, 1.0 + pattern.sum(axis=0).max())).tocsc()),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0,
            options=OPTIONS,
        )
        self._place = found.perm_c
        self._order = np.argsort(self._place)
        code = self._place[columns].astype(np.int64) * n + self._place[rows]
        entries, self._entry = np.unique(code, return_inverse=True)
        self._indices = (entries % n).astype(np.int32)
        self._indptr = np.searchsorted(entries // n, np.arange(n + 1)).astype(np.int32)
        self._diagonal = np.flatnonzero(self._indices == entries // n)

    def factorised(self, weights: Weights) -> "Factor":
        """Factorise at given weights.

        Raises
        ------
        RuntimeError
            A matrix that is singular to rounding.
        """
        values = []
        for group, members, B in self._stacks:
            inverse = weights.inverses[group][members]
            pairs, many, d, _ = inverse.shape
            right = np.matmul(inverse, B.transpose(0, 2, 1).reshape(pairs, many, d, 12)).reshape(pairs, many * d, 12)
            values.append(np.matmul(B, right).ravel())
        data = np.asarray(np.bincount(self._entry, np.concatenate(values)[self._kept]), dtype=float)
        data[self._diagonal] *= 1 + REGULARISATION
        M = sp.csc_matrix((data, self._indices, self._indptr), shape=(self._size, self._size))
        lu = sp.linalg.splu(M, permc_spec="NATURAL", diag_pivot_thresh=0, options=OPTIONS)
        return Factor(M, lu, self._place, self._order)


class Factor:
    """A factorised complement."""

    def __init__(self, M: sp.csc_matrix, lu: sp.linalg.SuperLU, place: Index, order: Index) -> None:
        self._M, self._lu, self._place, self._order = M, lu, place, order

    def solve(self, b: Array) -> Array:
        """Solution for a right-hand side, refined once."""
        b = b[self._order]
        x = self._lu.solve(b)
        x = x + self._lu.solve(b - self._M @ x)
        return np.asarray(x[self._place])


def _stacks(A: sp.csc_array, conditions: Conditions, n_blocks: int) -> tuple[list[tuple[int, Index, Array]], Index]:
    """Members of each group that stand between the same two blocks, stacked by their number; and the two blocks.

    Each stack holds the group, members (J, m) and their columns of A on both blocks (J, 12, m d).
    """
    block, column = A.indices // 6, np.repeat(np.arange(A.shape[1]), np.diff(A.indptr))
    stacks, pairs = [], []
    for number, group in enumerate(conditions.groups):
        of_column = np.full(A.shape[1], -1)
        of_column[group.columns] = np.arange(len(group.columns))[:, None]
        local = np.zeros(A.shape[1], dtype=int)
        local[group.columns] = np.arange(group.columns.shape[1])
        mine = of_column[column] >= 0
        member, own = of_column[column[mine]], block[mine]
        low, high = np.full(len(group.columns), n_blocks), np.full(len(group.columns), -1)
        np.minimum.at(low, member, own)
        np.maximum.at(high, member, own)
        B = np.zeros((len(group.columns), 12, group.columns.shape[1]))
        B[member, 6 * (own != low[member]) + A.indices[mine] % 6, local[column[mine]]] = A.data[mine]
        high = np.where(high == low, n_blocks, high)
        key = low * (n_blocks + 1) + high
        order = np.argsort(key, kind="stable")
        starts = np.flatnonzero(np.diff(key[order], prepend=-1))
        counts = np.diff(np.append(starts, len(order)))
        for many in np.unique(counts):
            members = order[starts[counts == many][:, None] + np.arange(many)]
            stacked = B[members].transpose(0, 2, 1, 3).reshape(len(members), 12, -1)
            stacks.append((number, members, stacked))
            pairs.append(np.column_stack([low[members[:, 0]], high[members[:, 0]]]))
    return stacks, np.concatenate(pairs)
