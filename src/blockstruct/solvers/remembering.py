"""Solve the programs of a dead load once for all cases of a model."""

from hashlib import sha256

import numpy as np

from blockstruct.limit import ConicProgram, ProgramData, Solution, Solver


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
