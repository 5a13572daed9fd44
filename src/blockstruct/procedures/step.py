"""Solve one program and measure its solution."""

import numpy as np

from blockstruct.arrays import Array
from blockstruct.limit.certificate import certify
from blockstruct.limit.crushing import Linearisation
from blockstruct.limit.friction import Sliding
from blockstruct.limit.iteration import Iteration, is_solved
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.vocabulary import SolverStatus, Stage


def solve_step(
    program: ConicProgram,
    sliding: Sliding,
    stage: Stage,
    settings: ProcedureSettings,
    solver: Solver,
    *,
    c0: float = 0.0,
    a: float = 0.0,
    linearisation: Linearisation | None = None,
    objective: Objective | None = None,
    max_load_factor: float | None = None,
    velocities: Array | None = None,
) -> Iteration:
    """Solve one program and certify its state.

    If the solver reports an unbounded program, the load factor is ∞ if the ray proves it. Otherwise the program has
    failed.

    Parameters
    ----------
    program, sliding
        The program and its sliding condition.
    stage, c0, a
        Place of the program in the procedure.
    settings, solver
        Tolerances of the certificate, and the solver.
    linearisation, objective, max_load_factor
        Data of the program: :meth:`ConicProgram.data`.
    velocities
        Velocities of the state, instead of the solver's.
    """
    data = program.data(sliding, linearisation=linearisation, objective=objective, max_load_factor=max_load_factor)
    numerics = settings.numerics
    solution = solver.solve(program, data, max(numerics.solver_tolerance, numerics.step_tolerance * c0))
    alpha, x, u = program.unpack(solution)
    T = program.tie_force(solution)
    if velocities is not None:
        u = velocities
    status = solution.status
    if not is_solved(status):
        unbounded = status is SolverStatus.UNBOUNDED
        if unbounded and not _is_ray(program.problem, x, solution.y[program.tie_columns], alpha, sliding, settings):
            unbounded, status = False, SolverStatus.FAILED
        alpha = np.inf if unbounded else np.nan
        x, T, u = (np.full_like(values, np.nan) for values in (x, T, u))
    return Iteration(
        stage=stage,
        load_factor=alpha,
        x=x,
        u=u,
        v=(program.problem.A.T @ u).reshape(-1, 3),
        sliding=sliding,
        c0=c0,
        a=a,
        linearised_at=linearisation.N0[:, -1] if linearisation is not None and program.is_linearised else None,
        certificate=certify(program.problem, x, u, alpha if np.isfinite(alpha) else np.nan, settings, T),
        solver_status=status,
        solver_iterations=solution.iterations,
        solver_time=solution.time,
        tie_force=T,
        elongation=program.problem.ties.elongation(u),
    )


def _is_ray(
    problem: LimitProblem, x: Array, of_ties: Array, alpha: float, sliding: Sliding, settings: ProcedureSettings
) -> bool:
    """Return whether forces prove that a program is unbounded.

    They balance the variable load alone and stay inside the sliding condition at any size.
    """
    if not alpha > 0:
        return False
    x = x / alpha
    residual = np.abs(problem.A @ x.ravel() + problem.w_L).max()
    shear = np.where(problem.never_slides, 0.0, np.linalg.norm(x[:, 1:], axis=1))
    excess = max((shear - sliding.slope * x[:, 0]).max(), (-x[:, 0]).max())
    of_joints = problem.torsion.excess(x, sliding.slope * x[:, 0])
    excess = max(excess, of_joints.max(initial=0.0))
    # Joints that crush, and ties, carry no force at any size.
    bounded = np.concatenate([x[problem.crushes, 0], of_ties / alpha])
    excess = max(excess, np.abs(bounded).max(initial=0.0))
    return bool(max(residual, excess) <= settings.numerics.yield_tolerance * max(1.0, np.abs(x).max()))
