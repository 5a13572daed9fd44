"""Iterate without dilatancy in the true cones, with a shifted objective."""

from blockstruct.limit.friction import relax, shift_of, true_sliding
from blockstruct.limit.iteration import Found, Iteration, Search
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Procedure, Stage

#: Share of the new shift in the next shift.
DAMPING = 0.5


def shifted_iteration(
    program: ConicProgram, first: Iteration, settings: ProcedureSettings, solver: Solver, left: int
) -> Search:
    """Maximise ``α − Σ s_k n_k`` inside the true cones: (18) of docs/theory.md.

    The shift s belongs to the last mechanism: De Saxcé & Feng (1998), doi:10.1016/S0895-7177(98)00119-8, iterated as by
    Acary et al. (2011), doi:10.1002/zamm.201000073. Every program is feasible and every iterate is statically
    admissible. The iteration often ends at a higher load factor than the fictitious conditions. It gives the upper end
    of a spread, and is the fallback.

    Parameters
    ----------
    program
        The program, with the exact cones of crushing.
    first
        A solved iteration whose mechanism gives the first shift.
    settings, solver
        Tolerances and solver.
    left
        Largest number of programs.

    Returns
    -------
    Found or None, Iteration
        The certified state, or None; and the last solved program.
    """
    problem, last = program.problem, first
    sliding, shift = true_sliding(problem), shift_of(problem, first.v, first.x[:, 0])
    for _ in range(left):
        step = solve_step(program, sliding, Stage.SHIFTED, settings, solver, objective=Objective(shift))
        yield step
        if not step.solved:
            break
        last = step
        if step.certificate.holds:
            return Found(step, Procedure.SHIFTED), step
        shift = relax(shift, shift_of(problem, step.v, step.x[:, 0]), DAMPING)
    return None, last
