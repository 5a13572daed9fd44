"""Find the exact collapse state at the end of a loading path."""

from collections.abc import Generator
from dataclasses import replace
from time import perf_counter

import numpy as np

from blockstruct.arrays import NEGLIGIBLE, Array
from blockstruct.limit.certificate import certify
from blockstruct.limit.friction import CAP, Sliding, frozen_sliding, true_sliding
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.program import Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.carried_forces import INSIDE, LEAST_FRICTION, Aim, corrected_forces
from blockstruct.procedures.fictitious import admissible
from blockstruct.procedures.path import Path
from blockstruct.procedures.step import solve_step
from blockstruct.solvers.interior_point import Step
from blockstruct.solvers.splitting import LEAST
from blockstruct.vocabulary import SolverStatus, Stage

#: Largest flow-rule gap of the closed state, relative to the load factor, and change of the load factor that costs as
#: much as doubling the force at a contact.
CLOSED = 1e-4


def close_path(
    path: Path, near: Array, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, Iteration]:
    """Find the exact collapse state near the last step of a path.

    The search starts near forces (K, 3). The mechanism belongs to the largest load with friction frozen at ``μ n`` of
    these forces. The forces then miss the flow rule of this mechanism least. Both follow from conic programs. A loop
    from the path's state is tried first, because it needs a fraction of their time.

    Yields
    ------
    Iteration
        The mechanism, then its forces.

    Returns
    -------
    Iteration
        The last yielded iteration, whose certificate may or may not hold.
    """
    program, numerics = path.program, settings.numerics
    # The forces that follow, solved to the tolerance of the settings, correct the load factor of the mechanism.
    rough = replace(settings, numerics=replace(numerics, solver_tolerance=max(numerics.solver_tolerance, NEGLIGIBLE)))
    caps = frozen_sliding(program.problem, near[:, 0])
    mechanism = _mechanism_nearby(path, caps)
    if mechanism is None:
        mechanism = solve_step(program, caps, Stage.NONASSOCIATIVE, rough, solver, c0=CAP)
    yield mechanism
    if not mechanism.solved:
        return mechanism
    closed = _forces_nearby(path, mechanism, near, settings)
    if closed is None:
        closed = admissible(program, mechanism, settings, solver)
    yield closed
    return closed


def _mechanism_nearby(path: Path, caps: Sliding) -> Iteration | None:
    """Find the mechanism by the interior-point loop from the last step.

    Return None if the loop does not find the mechanism.
    """
    if path.program.problem.never_slides.any():
        # Without compliance, nothing in the loop limits the shear forces of joints that never slide.
        return None
    start, contact = perf_counter(), path.contact.rigid(caps)
    nothing = np.zeros(contact.conditions.size)
    found = contact.solve(
        Step(nothing, nothing, 1.0),
        contact.beside(path.reached),
        centre=False,
        tolerance=NEGLIGIBLE,
    )
    if not found.within(NEGLIGIBLE):
        return None
    seconds = perf_counter() - start
    state = found.state
    state = state.scaled(1 / float(path.program.problem.w_L @ state.u))
    return replace(path.iteration(state, found.iterations, seconds), stage=Stage.NONASSOCIATIVE, sliding=caps, c0=CAP)


def _forces_nearby(path: Path, mechanism: Iteration, near: Array, settings: ProcedureSettings) -> Iteration | None:
    """Find forces of a mechanism near given forces (K, 3).

    The forces are zero at opening contacts and oppose sliding at sliding contacts. Return None if no such forces
    satisfy the flow rule closely enough.
    """
    start, problem = perf_counter(), path.program.problem
    if not problem.is_plain:
        return None
    v, u = mechanism.v, mechanism.u
    scale = path.scale(mechanism)
    slip = np.hypot(v[:, 1], v[:, 2])
    opening = np.maximum(v[:, 0] - problem.dilatancy * slip, 0.0)
    least = settings.numerics.interpenetration_tolerance * problem.force_unit * problem.speed(v, u)
    pressed = opening <= least
    slides = (slip > least)[pressed]
    v, slip, opening = v[pressed], slip[pressed], opening[pressed]
    mu = np.maximum(problem.friction[pressed], LEAST_FRICTION)
    n = np.maximum(near[pressed, 0], LEAST * near[:, 0].mean())
    # Friction starts inside its limit where contacts slide, and at zero elsewhere.
    x = np.column_stack([n, np.zeros((len(n), 2))])
    x[slides, 1:] = -(INSIDE * (mu * n)[slides] / slip[slides])[:, None] * v[slides, 1:]
    found = corrected_forces(
        problem.A[:, np.repeat(pressed, 3)],
        mu,
        x,
        -problem.w_D,
        aim=Aim(
            load=problem.w_L,
            alpha=mechanism.load_factor,
            free=CLOSED * scale,
            cost=np.column_stack([opening + mu * slip, v[:, 1:]]),
            enough=CLOSED * scale,
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
