"""Iterate without dilatancy through fictitious sliding conditions."""

import numpy as np

from blockstruct.limit.crushing import Linearisation
from blockstruct.limit.friction import STEEPEST, fictitious_sliding, limited_sliding, relax, shift_of, true_sliding
from blockstruct.limit.iteration import Found, Iteration, Search
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Procedure, Stage


def fictitious_iteration(
    program: ConicProgram,
    exact: ConicProgram,
    first: Iteration,
    settings: ProcedureSettings,
    solver: Solver,
    left: int,
) -> Search:
    """Find a collapse state by the iteration with fictitious conditions.

    The iteration of Gilbert, Casapulla & Ahmed (2006), in cones: Portioli, Casapulla & Cascini (2014).

    Parameters
    ----------
    program, exact
        The program of the steps, and the program of closing states with the exact cones of crushing.
    first
        The associative program. If joints have more friction than :func:`limited_sliding` allows, a separate program
        starts the iteration.
    settings, solver
        Schedule and tolerances, and the solver.
    left
        Largest number of programs.

    Returns
    -------
    Found or None, Iteration
        The certified state, or None; and the last step.
    """
    linearisation = Linearisation.first(program.problem).after(program.problem, first.x[:, 0])
    if (program.problem.friction > STEEPEST).any():
        sliding = limited_sliding(program.problem)
        start = solve_step(program, sliding, Stage.NONASSOCIATIVE, settings, solver, linearisation=linearisation)
        yield start
        left -= 1
        first = start if start.solved else first
        linearisation = linearisation.after(program.problem, first.x[:, 0])
    n0, c0, a, beta = first.x[:, 0], settings.schedule.c0, settings.schedule.slope, settings.schedule.relaxation
    last, load_factors, settled, cooldown, pause = first, [first.load_factor], 0, 0, 1
    while left > 0:
        sliding = fictitious_sliding(program.problem, n0, c0, a)
        step = solve_step(
            program, sliding, Stage.NONASSOCIATIVE, settings, solver, c0=c0, a=a, linearisation=linearisation
        )
        yield step
        left -= 1
        if not step.solved:
            # A program with more cohesion is easier to solve.
            c0 *= 4
            continue
        last = step
        load_factors.append(step.load_factor)
        change = _remaining_change(load_factors, program.problem.work_scale(step.u))
        is_settled = change <= settings.schedule.load_factor_tolerance and c0 <= settings.schedule.c0_limit
        settled = settled + 1 if is_settled else 0
        patient = len(load_factors) > settings.schedule.patience
        cooldown -= 1
        beta = _relaxation(beta, load_factors, settings)
        n0 = relax(n0, step.x[:, 0], beta)
        if left == 1 or (cooldown <= 0 and (settled >= 2 or patient)):
            closing = admissible(exact, step, settings, solver)
            yield closing
            left -= 1
            if closing.certificate.holds:
                # Since the step before it settled.
                recent = load_factors[-2 - settled :]
                found = Found(closing, Procedure.FICTITIOUS, settled >= 2, (min(recent), max(recent)))
                return found, closing
            cooldown = pause = 2 * pause
            if closing.solved and load_factors[-1] > load_factors[-2]:
                # A rising load factor approaches from below: the next step starts from forces that satisfy all true
                # conditions. Measured: on 2,400 blocks the next attempt holds 4 steps sooner.
                n0 = closing.x[:, 0]
        linearisation = linearisation.after(program.problem, step.x[:, 0])
        c0 = max(c0 * settings.schedule.c0_decay, settings.schedule.c0_min)
        a = max(a * settings.schedule.slope_decay, settings.schedule.slope_min)
    return None, last


def admissible(program: ConicProgram, step: Iteration, settings: ProcedureSettings, solver: Solver) -> Iteration:
    """Of all forces within the true conditions, find those that miss a mechanism's flow rule least.

    The load factor is at most the step's. For given velocities the flow-rule gap is linear in the forces. Up to a
    constant, it is ``Σ s_k n_k − α`` with the shift s of De Saxcé & Feng (1998). A step satisfies the true conditions
    only in the limit of the iteration. This state satisfies them at once, or shows that no such state is near. The
    objective also contains a hundredth of α. If several load factors miss the flow rule equally little, it selects the
    highest. The choice then does not depend on the solver's path.
    """
    return solve_step(
        program,
        true_sliding(program.problem),
        Stage.ADMISSIBLE,
        settings,
        solver,
        objective=Objective(shift_of(program.problem, step.v, step.x[:, 0]), 1.01),
        max_load_factor=step.load_factor,
        velocities=step.u,
    )


def _remaining_change(load_factors: list[float], work_scale: float) -> float:
    """Estimate the remaining change of the load factor, relative to α.

    Assume that the last changes continue as a geometric series. The estimate is at least the last change.
    """
    if len(load_factors) < 3:
        return np.inf
    before, now = np.diff(load_factors[-3:])
    ratio = min(max(now / before, 0.0), 0.99) if before != 0 else 0.0
    scale = max(abs(load_factors[-1]), 1e-3 * work_scale)
    return float(abs(now) * max(1.0, ratio / (1 - ratio)) / scale)


def _relaxation(beta: float, load_factors: list[float], settings: ProcedureSettings) -> float:
    """Return β after a step.

    β grows while the load factor changes in one direction, and falls when the direction reverses. Measured: with a
    constant β of 0.6 or more, forces of walls of 1,500 blocks and more oscillate between steps. A constant 0.4 needs
    more steps on walls of 50.
    """
    if len(load_factors) < 4:
        return beta
    before, now = np.diff(load_factors[-3:])
    if before * now >= 0:
        return min(beta * settings.schedule.relaxation_growth, settings.schedule.relaxation_max)
    return max(beta * settings.schedule.relaxation_cut, settings.schedule.relaxation_min)


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
        shift = (shift + shift_of(problem, step.v, step.x[:, 0])) / 2
    return None, last
