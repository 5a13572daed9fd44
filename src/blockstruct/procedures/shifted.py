"""The non-associative iteration with the true cones and a shifted objective."""

from blockstruct.limit.crushing import bearing
from blockstruct.limit.friction import relax, shift_of, true_sliding
from blockstruct.limit.iteration import Found, Iteration, Search
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.fictitious import admissible
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Procedure, Stage

#: Share of the new shift that is taken up.
DAMPING = 0.5


def shifted_iteration(
    program: ConicProgram, exact: ConicProgram, first: Iteration, settings: ProcedureSettings, solver: Solver, left: int
) -> Search:
    """Maximise ``α − Σ s_k n_k`` inside the true cones, with the shift s of the last mechanism.

    De Saxcé & Feng (1998), doi:10.1016/S0895-7177(98)00119-8, iterated as by Acary et al. (2011),
    doi:10.1002/zamm.201000073. Every program is feasible, and every iterate is statically admissible unless rectangles
    crush, whose strips follow the state. It often ends at a higher load factor than the fictitious conditions: the
    upper end of a spread, and the fallback.

    Parameters
    ----------
    program, exact
        The program of the steps, and the program of closing states, with the exact cones of crushing.
    first
        A solved iteration whose mechanism gives the first shift.
    settings, solver
        Tolerances and solver.
    left
        Programs it may solve.

    Returns
    -------
    Found or None, Iteration
        The certified state, None without one; and the last solved program.
    """
    problem, last, n0 = program.problem, first, first.x[:, 0]
    lengths = bearing(problem, n0)
    sliding, shift = true_sliding(problem), shift_of(problem, first.v, n0)
    for _ in range(left):
        step = solve_step(
            program,
            sliding,
            Stage.SHIFTED,
            settings,
            solver,
            objective=Objective(shift),
            bearing=lengths,
        )
        yield step
        if not step.solved:
            break
        last = step
        if step.certificate.holds:
            return Found(step, Procedure.SHIFTED), step
        if program.is_frozen and step.certificate.flow_rule_gap <= step.certificate.flow_rule_gap_limit:
            closing = admissible(exact, step, step.x[:, 0], lengths, settings, solver)
            yield closing
            if closing.certificate.holds:
                return Found(closing, Procedure.SHIFTED), closing
        shift = relax(shift, shift_of(problem, step.v, step.x[:, 0]), DAMPING)
        n0 = relax(n0, step.x[:, 0], DAMPING)
        lengths = bearing(problem, n0, lengths)
    return None, last
