"""Solve conic programs by Clarabel, and keep solutions under dead load."""

from hashlib import sha256
from time import perf_counter
from typing import Any

import clarabel
import numpy as np
import scipy.sparse as sp

from blockstruct.limit import ConicProgram
from blockstruct.limit.program import ProgramData, Solution, Solver
from blockstruct.vocabulary import SolverStatus

_STATUS = {
    "Solved": SolverStatus.SOLVED,
    "AlmostSolved": SolverStatus.ALMOST_SOLVED,
    "PrimalInfeasible": SolverStatus.INFEASIBLE,
    "AlmostPrimalInfeasible": SolverStatus.INFEASIBLE,
    "DualInfeasible": SolverStatus.UNBOUNDED,
    "AlmostDualInfeasible": SolverStatus.UNBOUNDED,
}


class ClarabelSolver:
    """Interior-point solver of Goulart & Chen (2024).

    Source: doi:10.48550/arXiv.2405.12762.

    Parameters
    ----------
    max_iterations
        Most interior-point iterations of one program.
    """

    def __init__(self, max_iterations: int = 200) -> None:
        self.settings = clarabel.DefaultSettings()
        self.settings.verbose = False
        self.settings.max_iter = max_iterations
        # Measured on 2,400 blocks: up to twice as fast as the supernodal factorisation.
        self.settings.direct_solve_method = "qdldl"
        # The program is already scaled. More row and column scaling would depend on the directions of the global axes.
        # So would the choice among equally good forces, which the non-associative iteration continues from.
        self.settings.equilibrate_enable = False
        # Numbers can be updated in place only if the pattern stays the same.
        self.settings.presolve_enable = False
        self.settings.input_sparse_dropzeros = False
        self._program: ConicProgram | None = None
        self._solver: Any = None

    def solve(self, program: ConicProgram, data: ProgramData, tolerance: float) -> Solution:
        """Solve one program.

        The pattern of the factorisation is kept while the program is the same object.
        """
        start = perf_counter()
        self.settings.tol_gap_abs = self.settings.tol_gap_rel = self.settings.tol_feas = tolerance
        if program is self._program:
            self._solver.update(A=data.G, b=data.h, q=data.q, settings=self.settings)
        else:
            rows, columns = program.G.shape
            cones = [
                clarabel.ZeroConeT(program.zero_rows),
                clarabel.NonnegativeConeT(program.nonnegative_rows),
                *[clarabel.SecondOrderConeT(3)] * program.cones,
            ]
            G = sp.csc_matrix((data.G, program.G.indices, program.G.indptr), shape=(rows, columns))
            P = sp.csc_matrix(sp.diags_array(program.cost)) if program.cost.any() else sp.csc_matrix((columns, columns))
            self._solver = clarabel.DefaultSolver(P, data.q, G, data.h, cones, self.settings)
            self._program = program
        result = self._solver.solve()
        return Solution(
            status=_STATUS.get(str(result.status), SolverStatus.FAILED),
            y=np.array(result.x),
            z=np.array(result.z),
            iterations=int(result.iterations),
            time=perf_counter() - start,
        )


class RememberingSolver:
    """Solver that keeps the solutions of programs with one load.

    The programs of the dead load alone are such programs. The cases of a model share them.

    Parameters
    ----------
    solver
        Solves the programs.
    """

    def __init__(self, solver: Solver) -> None:
        self._solver = solver
        self._solutions: dict[str, Solution] = {}

    def solve(self, program: ConicProgram, data: ProgramData, tolerance: float) -> Solution:
        """Solve one program, or return its solution if it is known."""
        problem = program.problem
        if problem.w_D.any() and not np.array_equal(problem.w_L, problem.w_D):
            return self._solver.solve(program, data, tolerance)
        sizes = np.array([tolerance, program.zero_rows, program.nonnegative_rows])
        key = sha256()
        for part in (sizes, program.G.indptr, program.G.indices, program.cost, data.G, data.h, data.q):
            key.update(part.tobytes())
        name = key.hexdigest()
        if name not in self._solutions:
            self._solutions[name] = self._solver.solve(program, data, tolerance)
        return self._solutions[name]
