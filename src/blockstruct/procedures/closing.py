"""The exact collapse state at the end of a loading path."""

from collections.abc import Generator
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.certificate import certify
from blockstruct.limit.friction import CAP, Sliding, frozen_sliding, true_sliding
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.program import ConicProgram, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.carried_forces import LEAST_FRICTION, Aim, corrected_forces, within
from blockstruct.procedures.fictitious import admissible
from blockstruct.procedures.path import Path
from blockstruct.procedures.step import solve_step
from blockstruct.solvers.interior_point import Step
from blockstruct.vocabulary import SolverStatus, Stage

Array = NDArray[np.float64]

#: Flow-rule gap asked of the closed state, relative to the load factor.
CLOSED = 1e-4
#: Tolerances asked of the solver. Measured on walls of 820 blocks: asked for 1e-9, its programs take a quarter more
#: iterations, and the load factor and its gap are the same in five digits.
MECHANISM, FORCES = 1e-6, 1e-8
#: Of the loop for the mechanism: complementarity gap to begin with, in multiples of the load factor, and its most
#: factorisations. Measured: begun at a tenth of it, 2,430 blocks are not solved.
WIDE, MOST = 1.0, 40
#: Opening and sliding that count as such, relative to the fastest contact point.
MOVES = 1e-4
#: Least normal force of a closed contact to begin with, in multiples of the mean; friction where nothing slides, as a
#: share of its most; and what it misses of that where something does.
PRESSED, HELD, SLIDING = 0.3, 0.5, 3e-5
#: Corrections of forces, the share of its way below which one leads nowhere, and the flow-rule gap that they end at,
#: in multiples of the one asked for.
CORRECTIONS, NOWHERE, ENOUGH = 30, 0.05, 0.9
#: Change of the load factor that costs as much as doubling the force at a contact, relative.
FREE = 1e-4


def close_path(
    path: Path, exact: ConicProgram, near: Array, lengths: Array, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, Iteration]:
    """Exact collapse state near the last step of a path and near forces (K, 3), if its certificate holds.

    The mechanism is that of the largest load with friction frozen at ``μ n`` of these forces, and with rectangles that
    bear over the shares (R, 2) of their lengths. Its forces, in the exact program, miss its flow rule least. Both are
    conic programs, and both are first tried from the state of the path, for a fraction of their time.

    Yields
    ------
    Iteration
        The mechanism, and its forces.

    Returns
    -------
    Iteration
        The last of them.
    """
    program, numerics = path.program, settings.numerics
    of_mechanism, of_forces = (
        replace(settings, numerics=replace(numerics, solver_tolerance=max(numerics.solver_tolerance, tolerance)))
        for tolerance in (MECHANISM, FORCES)
    )
    caps = frozen_sliding(program.problem, near[:, 0])
    mechanism = _mechanism_nearby(path, caps, lengths)
    if mechanism is None:
        stage = Stage.NONASSOCIATIVE
        mechanism = solve_step(program, caps, stage, of_mechanism, solver, c0=CAP, bearing=lengths)
    yield mechanism
    if not mechanism.solved:
        return mechanism
    closed = _forces_nearby(path, mechanism, near, settings)
    if closed is None:
        closed = admissible(exact, mechanism, near[:, 0], lengths, of_forces, solver)
    yield closed
    return closed


def _mechanism_nearby(path: Path, caps: Sliding, lengths: Array) -> Iteration | None:
    """The mechanism by the interior-point loop from the last step, None if the loop does not find it."""
    start, contact = perf_counter(), path.contact.rigid(caps, lengths)
    nothing = np.zeros(contact.conditions.size)
    found = contact.solve(
        Step(nothing, nothing, 1.0),
        contact.beside(path.reached, WIDE),
        centring=None,
        tolerance=MECHANISM,
        max_iterations=MOST,
    )
    if not found.within(MECHANISM):
        return None
    seconds = perf_counter() - start
    state = found.state
    state = state.scaled(1 / float(path.program.problem.w_L @ state.u))
    return replace(path.iteration(state, found.iterations, seconds), stage=Stage.NONASSOCIATIVE, sliding=caps, c0=CAP)


def _forces_nearby(path: Path, mechanism: Iteration, near: Array, settings: ProcedureSettings) -> Iteration | None:
    """Forces of a mechanism near others (K, 3), None if none are found that miss its flow rule by little.

    They carry nothing where the mechanism opens, and rub against it where it slides.
    """
    start, problem = perf_counter(), path.program.problem
    if not problem.is_plain:
        return None
    v, u = mechanism.v, mechanism.u
    scale = path.scale(mechanism)
    slip = np.hypot(v[:, 1], v[:, 2])
    opening = np.maximum(v[:, 0] - problem.dilatancy * slip, 0.0)
    least = MOVES * problem.force_unit * problem.speed(v, u)
    pressed = opening <= least
    slides = (slip > least)[pressed]
    v, slip, opening = v[pressed], slip[pressed], opening[pressed]
    mu = np.maximum(problem.friction[pressed], LEAST_FRICTION)
    n = np.maximum(near[pressed, 0], PRESSED * near[:, 0].mean())
    x = within(np.column_stack([n, near[pressed, 1:]]), mu, HELD)
    x[slides, 1:] = -((1 - SLIDING) * mu * n / slip)[slides, None] * v[slides, 1:]
    found = corrected_forces(
        problem.A[:, np.repeat(pressed, 3)],
        mu,
        x,
        -problem.w_D,
        corrections=CORRECTIONS,
        aim=Aim(
            load=problem.w_L,
            alpha=mechanism.load_factor,
            free=FREE * scale,
            cost=np.column_stack([opening + mu * slip, v[:, 1:]]),
            enough=ENOUGH * CLOSED * scale,
            nowhere=NOWHERE,
        ),
    )
    if found is None:
        return None
    of_pressed, alpha, count = found
    x = np.zeros_like(mechanism.x)
    x[pressed] = of_pressed
    closed = replace(
        mechanism,
        stage=Stage.ADMISSIBLE,
        load_factor=alpha,
        x=x,
        sliding=true_sliding(problem),
        c0=0.0,
        certificate=certify(problem, x, u, alpha, settings),
        solver_status=SolverStatus.SOLVED,
        solver_iterations=count,
        solver_time=perf_counter() - start,
    )
    return closed if closed.certificate.holds and path.gap(closed) <= CLOSED else None
