"""The conic program of a limit problem, and what a solver gives and takes."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit.friction import Sliding
from blockstruct.limit.problem import LimitProblem, total
from blockstruct.vocabulary import SolverStatus

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Numbers:
    """The numbers of one program of a fixed pattern: values of G, right-hand side h, objective q."""

    G: Array
    h: Array
    q: Array


@dataclass(frozen=True, slots=True)
class Solution:
    """What a solver says of one program.

    Attributes
    ----------
    status : SolverStatus
    claim : str
        The solver's own word.
    y, z : arrays
        Variables, and multipliers of the rows.
    iterations, time
        Interior-point iterations and seconds.
    """

    status: SolverStatus
    claim: str
    y: Array
    z: Array
    iterations: int
    time: float


class Solver(Protocol):
    """Solves programs of one pattern after another."""

    def solve(self, program: "ConicProgram", numbers: Numbers) -> Solution:
        """Minimise ``q·y`` subject to ``h − G y`` in the cones of the program."""


class ConicProgram:
    """Maximise α subject to equilibrium and the failure conditions: minimise ``q·y``, ``h − G y ∈ cones``.

    The variables are ``y = (κ α, n_1, s_1, t_1, …)`` with κ the mean variable wrench, so that a multiple of the
    variable load gives the same program; the rows are, in this order, the equilibrium of the free
    blocks (zero cone), an upper limit of α and the tension limits (nonnegative cone), and three rows of each
    contact point (second-order cones). The pattern never changes; :meth:`numbers` gives the values of a step.

    The objective is α times the total variable load, which makes the multipliers of equilibrium, the
    velocities, of order one: without it an interior-point solver stops percents short on thousands of blocks.

    Parameters
    ----------
    problem
        Equilibrium and strength.
    """

    def __init__(self, problem: LimitProblem) -> None:
        self.problem = problem
        rows, points = problem.A.shape[0], problem.n_points
        self.total = total(problem.w_L)
        self.unit = self.total / (rows // 6)
        n = 1 + 3 * np.arange(points)
        blocks = [
            sp.hstack([sp.csc_array(problem.w_L[:, None] / self.unit), problem.A]),
            _entries(np.zeros(1, int), np.zeros(1, int), 1, 1 + 3 * points),
            -_entries(np.arange(points), n, points, 1 + 3 * points),
            -_entries(np.arange(3 * points), 1 + np.arange(3 * points), 3 * points, 1 + 3 * points),
        ]
        G = sp.vstack(blocks, format="csc")
        G.sort_indices()
        self.G: sp.csc_array = G
        self.zero_rows = rows
        self.nonnegative_rows = 1 + points
        self.cones = points
        self._limit_row = rows
        self._tension_rows = rows + 1 + np.arange(points)
        self._bound_rows = rows + 1 + points + 3 * np.arange(points)
        self._limit_entry = _position(G, np.array([rows]), np.array([0]))
        self._slope_entries = _position(G, self._bound_rows, n)

    def numbers(self, sliding: Sliding, *, shift: Array | None = None, limit: float | None = None) -> Numbers:
        """Values of one step.

        Parameters
        ----------
        sliding
            Sliding condition of each contact point.
        shift : (K,) array
            The objective becomes ``α − shift·n``, and a hundredth of α more: where several load factors miss the
            flow rule equally little, the highest is taken, and not whichever the solver's path leads to.
        limit
            Upper limit of α.
        """
        G = self.G.data.copy()
        G[self._slope_entries] = -sliding.slope
        h = np.zeros(self.G.shape[0])
        h[: self.zero_rows] = -self.problem.w_D
        h[self._tension_rows] = self.problem.tension
        h[self._bound_rows] = sliding.bound
        # Without a limit its row reads 0 α ≤ 1: the entry stays in the pattern.
        G[self._limit_entry] = 0.0 if limit is None else 1.0
        h[self._limit_row] = 1.0 if limit is None else limit * self.unit
        q = np.zeros(self.G.shape[1])
        q[0] = -self.total / self.unit
        if shift is not None:
            q[0] *= 1.01
            q[1::3] = self.total * shift
        return Numbers(G, h, q)

    def unpack(self, solution: Solution) -> tuple[float, Array, Array]:
        """Load factor α, contact forces x (K, 3) and velocities u (6 F,) with ``w_L·u = 1``."""
        return (
            float(solution.y[0]) / self.unit,
            solution.y[1:].reshape(-1, 3),
            solution.z[: self.zero_rows] / self.total,
        )


def _entries(rows: Index, columns: Index, n_rows: int, n_columns: int) -> sp.csc_array:
    return sp.csc_array((np.ones(len(rows)), (rows, columns)), shape=(n_rows, n_columns))


def _position(G: sp.csc_array, rows: Index, columns: Index) -> Index:
    """Where the entries (row, column) stand in the data of a sorted csc array."""
    keys = np.repeat(np.arange(G.shape[1]), np.diff(G.indptr)).astype(np.int64) * G.shape[0] + G.indices
    return np.asarray(np.searchsorted(keys, columns.astype(np.int64) * G.shape[0] + rows))
