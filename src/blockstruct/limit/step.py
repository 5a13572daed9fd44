"""One program: solve it, and measure what the solver gives."""

import numpy as np

from blockstruct.limit.certificate import certify
from blockstruct.limit.friction import Sliding
from blockstruct.limit.iteration import Iteration, is_solved
from blockstruct.limit.program import ConicProgram, Numbers, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.vocabulary import SolverStatus, Stage


def solve_step(
    program: ConicProgram,
    numbers: Numbers,
    sliding: Sliding,
    stage: Stage,
    settings: ProcedureSettings,
    solver: Solver,
    *,
    c0: float = 0.0,
    a: float = 0.0,
    mechanism: Iteration | None = None,
) -> Iteration:
    """Solve one program and certify its state.

    Parameters
    ----------
    program, numbers, sliding
        The program and its sliding condition.
    stage, c0, a
        Where it stands in the procedure.
    settings, solver
        Tolerances of the certificate, and the solver.
    mechanism
        A step whose velocities belong to the state instead of the solver's own.
    """
    solution = solver.solve(program, numbers)
    alpha, x, u = program.unpack(solution)
    if mechanism is not None:
        u = mechanism.u
    # The ray of an unbounded program is kept to be checked; other points without a claim mean nothing.
    if not is_solved(solution.status) and solution.status is not SolverStatus.UNBOUNDED:
        alpha, x, u = np.nan, np.full_like(x, np.nan), np.full_like(u, np.nan)
    return Iteration(
        stage=stage,
        load_factor=alpha,
        x=x,
        u=u,
        v=(program.problem.A.T @ u).reshape(-1, 3),
        sliding=sliding,
        c0=c0,
        a=a,
        certificate=certify(program.problem, x, u, alpha, settings),
        solver_status=solution.status,
        solver_iterations=solution.iterations,
        solver_time=solution.time,
    )
