"""The non-associative iteration with fictitious sliding conditions."""

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import crushing
from blockstruct.limit.crushing import Linearisation, bearing
from blockstruct.limit.friction import STEEPEST, fictitious_sliding, limited_sliding, relax, shift_of, true_sliding
from blockstruct.limit.iteration import Found, Iteration, Search
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Procedure, Stage

Array = NDArray[np.float64]

#: Programs whose load factors are the range of the drift.
RECENT = 3


def fictitious_iteration(
    program: ConicProgram,
    exact: ConicProgram,
    first: Iteration,
    settings: ProcedureSettings,
    solver: Solver,
    left: int,
) -> Search:
    """Gilbert, Casapulla & Ahmed (2006), in cones: Portioli, Casapulla & Cascini (2014).

    Parameters
    ----------
    program, exact
        The program of the steps, and the program of closing states, with the exact cones of crushing.
    first
        The associative program. Joints of more friction than :func:`limited_sliding` has start from a program of their
        own.
    settings, solver
        Schedule and tolerances, and the solver.
    left
        Programs it may solve.

    Returns
    -------
    Found or None, Iteration
        The certified state, None without one; and the last step.
    """
    if (program.problem.friction > STEEPEST).any():
        start = solve_step(program, limited_sliding(program.problem), Stage.NONASSOCIATIVE, settings, solver)
        yield start
        left -= 1
        first = start if start.solved else first
    n0, c0, a, beta = first.x[:, 0], settings.schedule.c0, settings.schedule.slope, settings.schedule.relaxation
    linearisation = Linearisation.first(program.problem).after(program.problem, first.x, first.v, 1.0)
    lengths = bearing(program.problem, n0)
    last, load_factors, settled, cooldown, pause = first, [first.load_factor], 0, 0, 1
    while left > 0:
        sliding = fictitious_sliding(program.problem, n0, c0, a)
        step = solve_step(
            program,
            sliding,
            Stage.NONASSOCIATIVE,
            settings,
            solver,
            c0=c0,
            a=a,
            linearisation=linearisation,
            bearing=lengths,
        )
        yield step
        left -= 1
        if not step.solved:
            c0 *= 4
            continue
        last = step
        load_factors.append(step.load_factor)
        drift = _drift(load_factors, program.problem.work_scale(step.u))
        is_settled = drift <= settings.schedule.load_factor_tolerance and c0 <= settings.schedule.c0_limit
        settled = settled + 1 if is_settled else 0
        patient = len(load_factors) > settings.schedule.patience
        cooldown -= 1
        beta = _relaxation(beta, load_factors, settings)
        n0 = relax(n0, step.x[:, 0], beta)
        if left == 1 or (cooldown <= 0 and (settled >= 2 or patient)):
            closing = admissible(exact, step, step.x[:, 0], lengths, settings, solver)
            yield closing
            left -= 1
            if closing.certificate.holds:
                recent = load_factors[-RECENT:]
                found = Found(closing, Procedure.FICTITIOUS, settled >= 2, (min(recent), max(recent)))
                return found, closing
            cooldown = pause = 2 * pause
            if closing.solved and load_factors[-1] > load_factors[-2]:
                # A load factor that rises comes up from below: the next step starts from forces that break no true
                # condition. Measured: on 2,400 blocks the next attempt holds 4 steps sooner.
                n0 = closing.x[:, 0]
        linearisation = linearisation.after(program.problem, step.x, step.v, beta)
        lengths = bearing(program.problem, n0, lengths)
        c0 = max(c0 * settings.schedule.c0_decay, settings.schedule.c0_min)
        a = max(a * settings.schedule.slope_decay, settings.schedule.slope_min)
    return None, last


def admissible(
    program: ConicProgram,
    step: Iteration,
    near: Array,
    lengths: Array,
    settings: ProcedureSettings,
    solver: Solver,
) -> Iteration:
    """Forces inside the true cones that miss the flow rule of a step's mechanism least, at no higher load factor.

    For given velocities the flow-rule gap is linear in the forces: up to a constant it is ``Σ s_k n_k − α`` with
    the shift s of De Saxcé & Feng (1998). The gap of crushing is linear about normal forces near (K,). Rectangles bear
    over shares (R, 2) of their lengths. The state of a step satisfies the true conditions only in the limit of the
    iteration; this one does at once, or shows that none is near. A hundredth of α is added to the objective: where
    several load factors miss the flow rule equally little, the highest is taken, and not whichever the solver's path
    leads to.
    """
    problem, biaxial = program.problem, settings.crushing_interaction == "biaxial"
    shift = shift_of(problem, step.v, step.x[:, 0]) + crushing.shift(problem, step.v, near, biaxial=biaxial)
    return solve_step(
        program,
        true_sliding(problem),
        Stage.ADMISSIBLE,
        settings,
        solver,
        objective=Objective(shift, 1.01),
        bearing=lengths,
        max_load_factor=step.load_factor,
        velocities=step.u,
    )


def _drift(load_factors: list[float], work_scale: float) -> float:
    """Change still to come, relative to α, if the last changes go on as a geometric series."""
    if len(load_factors) < 3:
        return np.inf
    before, now = np.diff(load_factors[-3:])
    ratio = min(max(now / before, 0.0), 0.99) if before != 0 else 0.0
    scale = max(abs(load_factors[-1]), 1e-3 * work_scale)
    return float(abs(now) * max(1.0, ratio / (1 - ratio)) / scale)


def _relaxation(beta: float, load_factors: list[float], settings: ProcedureSettings) -> float:
    """β after a step: larger while the load factor goes one way, smaller when it turns back.

    Measured: a constant β of 0.6 or more lets the forces of walls of 1,500 blocks and more swing from step to step,
    a constant 0.4 needs more steps on walls of 50.
    """
    if len(load_factors) < 4:
        return beta
    before, now = np.diff(load_factors[-3:])
    if before * now >= 0:
        return min(beta * settings.schedule.relaxation_growth, settings.schedule.relaxation_max)
    return max(beta * settings.schedule.relaxation_cut, settings.schedule.relaxation_min)
