"""Solve the equations of equilibrium with the contacts eliminated.

There are six unknowns per free block.
"""

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import Array, Flags, Index
from blockstruct.solvers.interior_point.conditions import Conditions, Weights

#: Relative addition to the diagonal, which keeps pivots of unsupported blocks away from zero.
REGULARISATION = 1e-13
#: The pattern is symmetric and the values nearly so: no pivoting, a symmetric ordering.
OPTIONS = {"SymmetricMode": True, "Equil": False}


class SchurComplement:
    """Matrix ``A (C + Fᵀ W⁻² E)⁻¹ Aᵀ`` with a fixed pattern and ordering.

    Parameters
    ----------
    A : (6 F, N) sparse array
        Equilibrium, with empty columns for auxiliary variables.
    conditions
        Conditions whose groups each connect a few blocks. A contact connects two, a bonded bar all blocks that it
        holds.
    idle : (6 F,) array
        Rows whose unknowns are zero.
    """

    def __init__(self, A: sp.csc_array, conditions: Conditions, idle: Flags) -> None:
        # The single row of a settlement counts as a separate block.
        n_blocks = -(-A.shape[0] // 6)
        self._stacks, blocks = _stacks(sp.csc_array(A), conditions, n_blocks)
        places = []
        for between in blocks:
            unknowns = (6 * between[:, :, None] + np.arange(6)).reshape(len(between), -1)
            many = unknowns.shape[1]
            places.append((np.repeat(unknowns, many, axis=1).ravel(), np.tile(unknowns, (1, many)).ravel()))
        rows, columns = (np.concatenate(part) for part in zip(*places, strict=True))
        n = self._size = A.shape[0]
        # Supports use the index after the last block. Idle rows are coupled to no other.
        outside = np.append(idle, np.ones(6 * n_blocks + 6 - n, dtype=bool))
        self._kept = ~(outside[rows] | outside[columns]) | ((rows == columns) & (rows < n))
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
        self._idle = idle[self._order][self._indices[self._diagonal]]

    def factorised(self, weights: Weights) -> "Factor":
        """Factorise the matrix at given weights.

        Raises
        ------
        RuntimeError
            If the matrix is singular to rounding.
        """
        values = []
        for group, members, B in self._stacks:
            inverse = weights.inverses[group][members]
            pairs, many, d, _ = inverse.shape
            wide = B.shape[1]
            of_members = B.transpose(0, 2, 1).reshape(pairs, many, d, wide)
            right = np.matmul(inverse, of_members).reshape(pairs, many * d, wide)
            values.append(np.matmul(B, right).ravel())
        data = np.asarray(np.bincount(self._entry, np.concatenate(values)[self._kept]), dtype=float)
        data[self._diagonal] *= 1 + REGULARISATION
        data[self._diagonal] += self._idle
        M = sp.csc_matrix((data, self._indices, self._indptr), shape=(self._size, self._size))
        lu = sp.linalg.splu(M, permc_spec="NATURAL", diag_pivot_thresh=0, options=OPTIONS)
        return Factor(M, lu, self._place, self._order)


class Factor:
    """Factorised Schur complement."""

    def __init__(self, M: sp.csc_matrix, lu: sp.linalg.SuperLU, place: Index, order: Index) -> None:
        self._M, self._lu, self._place, self._order = M, lu, place, order

    def solve(self, b: Array) -> Array:
        """Solve for a right-hand side, with one refinement."""
        b = b[self._order]
        x = self._lu.solve(b)
        x = x + self._lu.solve(b - self._M @ x)
        return np.asarray(x[self._place])


def _stacks(
    A: sp.csc_array, conditions: Conditions, n_blocks: int
) -> tuple[list[tuple[int, Index, Array]], list[Index]]:
    """Stack the members of each group that connect the same blocks.

    Return the stacks and their blocks. Each stack holds the group, members (J, m) and their columns of A on all r
    blocks (J, 6 r, m d). Supports use the index after the last block.
    """
    block, column = (A.indices // 6).astype(np.int64), np.repeat(np.arange(A.shape[1]), np.diff(A.indptr))
    stacks, blocks = [], []
    for number, group in enumerate(conditions.groups):
        of_column = np.full(A.shape[1], -1)
        of_column[group.columns] = np.arange(len(group.columns))[:, None]
        local = np.zeros(A.shape[1], dtype=int)
        local[group.columns] = np.arange(group.columns.shape[1])
        mine = of_column[column] >= 0
        member, own = of_column[column[mine]], block[mine]
        between, place = _between(member, own, len(group.columns), n_blocks)
        wide = 6 * between.shape[1]
        B = np.zeros((len(group.columns), wide, group.columns.shape[1]))
        B[member, 6 * place + A.indices[mine] % 6, local[column[mine]]] = A.data[mine]
        of_blocks = np.unique(between, axis=0, return_inverse=True)[1].ravel()
        order = np.argsort(of_blocks, kind="stable")
        starts = np.flatnonzero(np.diff(of_blocks[order], prepend=-1))
        counts = np.diff(np.append(starts, len(order)))
        for many in np.unique(counts):
            members = order[starts[counts == many][:, None] + np.arange(many)]
            stacked = B[members].transpose(0, 2, 1, 3).reshape(len(members), wide, -1)
            stacks.append((number, members, stacked))
            blocks.append(between[members[:, 0]])
    return stacks, blocks


def _between(member: Index, block: Index, members: int, n_blocks: int) -> tuple[Index, Index]:
    """Return the blocks (members, r) that each member connects, ascending.

    Also return the position of each entry's block among them.
    """
    pairs, entry = np.unique(member * (n_blocks + 1) + block, return_inverse=True)
    of_pair, own = pairs // (n_blocks + 1), pairs % (n_blocks + 1)
    place = np.arange(len(pairs)) - np.searchsorted(of_pair, of_pair)
    between = np.full((members, place.max(initial=0) + 1), n_blocks)
    between[of_pair, place] = own
    return between, place[entry.ravel()]
