"""The procedure: dead load, associative program, non-associative iteration, admissible state."""

from collections.abc import Generator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.crushing import Linearisation
from blockstruct.limit.dead_load import dead_load_program
from blockstruct.limit.friction import fictitious_sliding, relax, true_sliding
from blockstruct.limit.iteration import Iteration, Outcome
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.limit.step import solve_step
from blockstruct.vocabulary import Flow, Stage, Status

Array = NDArray[np.float64]
Steps = Generator[Iteration, None, Outcome]

#: Programs after which a linearised associative analysis turns to the exact cones.
LINEARISED_PROGRAMS = 12


def solve_limit_case(problem: LimitProblem, flow: Flow, settings: ProcedureSettings, solver: Solver) -> Steps:
    """Solve a limit case, program by program.

    Parameters
    ----------
    problem
        The limit problem, with the dilatancy of its flow.
    flow
        Associative flow ends with the associative program.
    settings
        Schedule and tolerances.
    solver
        Solves the conic programs.

    Yields
    ------
    Iteration
        One a program, as it is solved.

    Returns
    -------
    Outcome
        Value of the generator.
    """
    dead = yield from dead_load_program(problem, settings, solver)
    if isinstance(dead, Outcome):
        return dead
    program = ConicProgram(problem, settings)
    first = yield from _associate(program, flow, settings, solver)
    if first.load_factor == np.inf and flow is Flow.NONASSOCIATIVE:
        # Dilatancy jams the blocks; without it they may slide all the same. Go on from the forces of the dead load,
        # with sliding conditions of the slope tan ψ: they bound every load that does not jam them by itself.
        sliding = fictitious_sliding(problem, dead, settings.cohesion, 0.0)
        numbers = program.numbers(sliding)
        first = solve_step(program, numbers, sliding, Stage.NONASSOCIATIVE, settings, solver, c0=settings.cohesion)
        yield first
    if first.load_factor == np.inf:
        message = "the variable load never causes collapse: the joints carry any multiple of it"
        return Outcome(Status.UNBOUNDED, np.inf, message)
    if not first.solved:
        return _given_up(f"the solver ended the {first.stage} program as {first.solver_status}", first)
    if flow is Flow.NONASSOCIATIVE:
        return (yield from _iterate(program, first, settings, solver))
    if first.certificate.holds:
        return Outcome(Status.CONVERGED, first.load_factor, "the certificate of the associative program holds")
    return _given_up("the certificate of the associative program does not hold", first)


def _associate(
    program: ConicProgram, flow: Flow, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, Iteration]:
    """Associative program; if crushing is linearised and the flow associative, programs until it is exact.

    Where the normal forces of many joints are not unique, the lines swing between them for ever. After a dozen
    programs the exact cones settle it.
    """
    sliding, linearisation = true_sliding(program.problem), Linearisation.first(program.problem)
    for k in range(LINEARISED_PROGRAMS + 1):
        if k == LINEARISED_PROGRAMS:
            program = ConicProgram(program.problem, replace(settings, crushing="conic"))
        numbers = program.numbers(sliding, linearisation=linearisation)
        step = solve_step(program, numbers, sliding, Stage.ASSOCIATIVE, settings, solver)
        yield step
        again = program.is_linearised and flow is Flow.ASSOCIATIVE and step.solved
        if step.certificate.holds or not again:
            break
        beta = 1.0 if k < 4 else 0.5
        linearisation = linearisation.after(program.problem, step.x, step.v, beta)
    return step


def _iterate(program: ConicProgram, first: Iteration, settings: ProcedureSettings, solver: Solver) -> Steps:
    """Non-associative iteration (Gilbert, Casapulla & Ahmed 2006; in cones: Portioli, Casapulla & Cascini 2014)."""
    n0, c0, a, beta = first.x[:, 0], settings.cohesion, settings.slope, settings.relaxation
    linearisation = Linearisation.first(program.problem).after(program.problem, first.x, first.v, 1.0)
    last, trail, settled, wait, pause = first, [first.load_factor], 0, 0, 1
    # The closing state is found inside the exact conditions, whatever the steps use.
    exact = program if not program.is_linearised else ConicProgram(program.problem, replace(settings, crushing="conic"))
    # The dead-load and the associative program are behind, an admissible one may follow.
    left = settings.max_programs - 2
    while left > 0:
        sliding = fictitious_sliding(program.problem, n0, c0, a)
        numbers = program.numbers(sliding, linearisation=linearisation)
        step = solve_step(program, numbers, sliding, Stage.NONASSOCIATIVE, settings, solver, c0=c0, a=a)
        yield step
        left -= 1
        if not step.solved:
            c0 *= 4
            continue
        last = step
        trail.append(step.load_factor)
        drift = _drift(trail, program.problem.work_scale(step.u))
        calm = drift <= settings.load_factor_tolerance and c0 <= settings.cohesion_limit
        settled = settled + 1 if calm else 0
        patient = len(trail) > settings.patience
        wait -= 1
        beta = _relaxation(beta, trail, settings)
        n0 = relax(n0, step.x[:, 0], beta)
        if left == 1 or (wait <= 0 and (settled >= 2 or patient)):
            closing = _admissible(exact, step, settings, solver)
            yield closing
            left -= 1
            if closing.certificate.holds:
                return Outcome(Status.CONVERGED, closing.load_factor, "the certificate holds")
            wait = pause = 2 * pause
            if closing.solved and trail[-1] > trail[-2]:
                # A load factor that rises comes up from below: the next step starts from forces that break no true
                # condition. Measured: on 2,400 blocks the next attempt holds 4 steps sooner.
                n0 = closing.x[:, 0]
        linearisation = linearisation.after(program.problem, step.x, step.v, beta)
        c0 = max(c0 * settings.cohesion_decay, settings.cohesion_min)
        a = max(a * settings.slope_decay, settings.slope_min)
    return _given_up(f"no certificate within {settings.max_programs} programs, that of the dead load counted", last)


def _admissible(
    program: ConicProgram,
    step: Iteration,
    settings: ProcedureSettings,
    solver: Solver,
) -> Iteration:
    """Forces inside the true cones that miss the flow rule of a step's mechanism least, at no higher load factor.

    For given velocities the flow-rule gap is linear in the forces: up to a constant it is ``Σ s_k n_k − α`` with
    the shift ``s_k = (μ − tan ψ) ‖v_t,k‖`` (De Saxcé & Feng 1998). The state of a step satisfies the true
    conditions only in the limit of the iteration; this one does at once, or shows that none is near.
    """
    problem = program.problem
    sliding = true_sliding(problem)
    shift = (problem.friction - problem.dilatancy) * np.linalg.norm(step.v[:, 1:], axis=1)
    numbers = program.numbers(sliding, shift=shift, limit=step.load_factor)
    return solve_step(program, numbers, sliding, Stage.ADMISSIBLE, settings, solver, mechanism=step)


def _drift(trail: list[float], work_scale: float) -> float:
    """Change still to come, relative to α, if the last changes go on as a geometric series."""
    if len(trail) < 3:
        return np.inf
    before, now = np.diff(trail[-3:])
    ratio = min(max(now / before, 0.0), 0.99) if before != 0 else 0.0
    scale = max(abs(trail[-1]), 1e-3 * work_scale)
    return float(abs(now) * max(1.0, ratio / (1 - ratio)) / scale)


def _relaxation(beta: float, trail: list[float], settings: ProcedureSettings) -> float:
    """β after a step: larger while the load factor goes one way, smaller when it turns back.

    Measured: a constant β of 0.6 or more lets the forces of walls of 1,500 blocks and more swing from step to step,
    a constant 0.4 needs more steps on walls of 50.
    """
    if len(trail) < 4:
        return beta
    before, now = np.diff(trail[-3:])
    if before * now >= 0:
        return min(beta * settings.relaxation_growth, settings.relaxation_max)
    return max(beta * settings.relaxation_cut, settings.relaxation_min)


def _given_up(why: str, last: Iteration) -> Outcome:
    c = last.certificate
    return Outcome(
        Status.NOT_CONVERGED,
        np.nan,
        f"{why}; last load factor {last.load_factor:.6g} with equilibrium residual {c.equilibrium_residual:.1e}, "
        f"yield excess {c.yield_excess:.1e}, interpenetration {c.interpenetration:.1e}, "
        f"flow-rule gap {c.flow_rule_gap:.1e}",
    )
