"""Solve conic programs by any solver in CVXPY, for cross-checks.

This is the readable reference.
"""

import time
import warnings

import cvxpy as cp
import numpy as np
import scipy.sparse as sp

from blockstruct.errors import SolverError
from blockstruct.limit import ConicProgram
from blockstruct.limit.program import ProgramData, Solution
from blockstruct.vocabulary import SolverStatus

_STATUS = {
    cp.OPTIMAL: SolverStatus.SOLVED,
    cp.OPTIMAL_INACCURATE: SolverStatus.ALMOST_SOLVED,
    cp.INFEASIBLE: SolverStatus.INFEASIBLE,
    cp.INFEASIBLE_INACCURATE: SolverStatus.INFEASIBLE,
    cp.UNBOUNDED: SolverStatus.UNBOUNDED,
    cp.UNBOUNDED_INACCURATE: SolverStatus.UNBOUNDED,
}
_OPTIONS = {
    "CLARABEL": lambda tol: {"tol_gap_abs": tol, "tol_gap_rel": tol, "tol_feas": tol},
    "SCS": lambda tol: {"eps_abs": tol, "eps_rel": tol, "max_iters": 1_000_000},
    "ECOS": lambda tol: {"abstol": tol, "reltol": tol, "feastol": tol},
}


class CvxpySolver:
    """Solver in CVXPY that builds the program again for every step.

    CLARABEL, SCS and ECOS use the tolerance of the program. Other solvers use their default tolerance. CVXPY reports no
    ray for an unbounded program, so the result has no ray.

    Parameters
    ----------
    name
        A solver of ``cvxpy.installed_solvers()`` that takes second-order cones.
    """

    def __init__(self, name: str) -> None:
        self.name = name.upper()
        if self.name not in cp.installed_solvers():
            msg = f"solver {name!r} is not installed; CVXPY has {', '.join(cp.installed_solvers())}"
            raise SolverError(msg)
        cone = cp.SOC(cp.Variable(), cp.Variable(2))
        try:
            cp.Problem(cp.Minimize(0), [cone]).get_problem_data(self.name)
        except cp.SolverError as error:
            msg = f"solver {name!r} takes no second-order cones; give one that does, such as CLARABEL, ECOS or SCS"
            raise SolverError(msg) from error

    def solve(self, program: ConicProgram, data: ProgramData, tolerance: float) -> Solution:
        """Solve one program."""
        rows, columns = program.G.shape
        G = sp.csr_array(sp.csc_array((data.G, program.G.indices, program.G.indptr), shape=(rows, columns)))
        first, second = program.zero_rows, program.zero_rows + program.nonnegative_rows
        y = cp.Variable(columns)
        cone = G[second:] @ y
        slack = cp.reshape(data.h[second:] - cone, (program.cones, 3), order="C")
        equality = G[:first] @ y == data.h[:first]
        inequality = G[first:second] @ y <= data.h[first:second]
        sliding = cp.SOC(slack[:, 0], slack[:, 1:], axis=1)
        problem = cp.Problem(cp.Minimize(data.q @ y), [equality, inequality, sliding])
        start = time.perf_counter()
        try:
            with warnings.catch_warnings():
                # The certificate judges an inaccurate solution.
                warnings.simplefilter("ignore")
                problem.solve(solver=self.name, **_OPTIONS.get(self.name, lambda _: {})(tolerance))
            status = _STATUS.get(problem.status, SolverStatus.FAILED)
        except cp.SolverError:
            status = SolverStatus.FAILED
        z = np.full(rows, np.nan)
        if y.value is not None and equality.dual_value is not None:
            heads, tails = sliding.dual_value
            z = np.concatenate(
                [equality.dual_value, inequality.dual_value, np.column_stack([heads.ravel(), tails]).ravel()]
            )
        return Solution(
            status=status,
            y=np.full(columns, np.nan) if y.value is None else y.value,
            z=z,
            iterations=int(problem.solver_stats.num_iters or 0) if problem.solver_stats else 0,
            time=time.perf_counter() - start,
        )
