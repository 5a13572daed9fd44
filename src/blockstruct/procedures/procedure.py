"""Solve a limit case: dead load, associative program, non-associative."""

from collections.abc import Generator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from blockstruct.arrays import ROUNDING, Array
from blockstruct.limit.crushing import Linearisation
from blockstruct.limit.friction import fictitious_sliding, true_sliding
from blockstruct.limit.iteration import Found, Iteration, Outcome, Steps, changed_steps, conclude, given_up
from blockstruct.limit.mirror import Mirror
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.dead_load import dead_load_program, largest_reaction
from blockstruct.procedures.fictitious import fictitious_iteration, shifted_iteration
from blockstruct.procedures.self_stress import (
    can_jam,
    dead_load_collapse,
    grows_without_limit,
    jammed_by_self_stress,
)
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Flow, PathEnd, Procedure, Reason, Stage, Status

if TYPE_CHECKING:
    from blockstruct.procedures.path import Path


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
        One for each solved program, in multiples of the variable load of the case.

    Returns
    -------
    Outcome
        Value of the generator, in multiples of the variable load of the case.
    """
    # Steps of a path to 1e-5 may have two solutions; the symmetric one moved the load factor of 14 blocks by 0.4 %.
    mirror = Mirror.of(problem) if flow is Flow.ASSOCIATIVE else None
    steps = _limited(problem if mirror is None else mirror.half, flow, settings, solver)
    whole = steps if mirror is None else changed_steps(steps, mirror.iteration)
    outcome = yield from changed_steps(whole, lambda step: step.of_case(problem))
    return (outcome if mirror is None else mirror.outcome(outcome)).of_case(problem)


def _limited(problem: LimitProblem, flow: Flow, settings: ProcedureSettings, solver: Solver) -> Steps:
    """Run the procedure, and the case without crushing.

    Crushing never raises the associative load factor. Without dilatancy there are several collapse states, and joints
    that settle as they crush lean one wall on another. If crushing raises the load factor, the case ends with the
    state without crushing, which has the load factor that counts.
    """
    outcome = yield from _solve(problem, flow, settings, solver)
    if flow is Flow.ASSOCIATIVE or not len(problem.rectangles) or outcome.status is not Status.CONVERGED:
        return outcome
    # Loaded here: its linear algebra is slow to import.
    from blockstruct.procedures.path import SETTLED

    states: list[Iteration] = []
    guard = _solve(problem.without_crushing, flow, settings, solver, is_guard=True)
    limit = conclude(guard, states.append)
    without = limit.load_factor
    # Two runs of one structure differ by as much as the range in which a path has settled.
    if not outcome.load_factor - without > SETTLED * abs(without):
        return outcome
    yield replace(states[-1], linearised_at=None)
    outcome = replace(outcome, load_factor=without, settled=False, without_crushing=without)
    return replace(outcome, procedure=limit.procedure, peak=limit.peak)


def _solve(
    problem: LimitProblem, flow: Flow, settings: ProcedureSettings, solver: Solver, *, is_guard: bool = False
) -> Steps:
    """Run the procedure and test the effect of self-stress.

    A guard needs the load factor alone: no test of self-stress, and no largest reaction of a settlement.
    """
    program = ConicProgram(problem, settings)
    path = _path(program, settings) if flow is Flow.NONASSOCIATIVE else None
    dead = _dead_load_forces(problem, path)
    if dead is None:
        found = yield from dead_load_program(problem, settings, solver)
        if isinstance(found, Outcome):
            return found
        dead = found
    is_tested = flow is Flow.NONASSOCIATIVE and problem.settlement is None and not is_guard
    if is_tested:
        hung = yield from dead_load_collapse(problem, settings, solver)
        if hung:
            return Outcome(Status.SELF_STRESS, np.nan, Reason.DEAD_LOAD_COLLAPSES, hung=hung)
    if problem.settlement is not None and not is_guard:
        yield largest_reaction(problem, settings, solver)
    first = ray = yield from _associate(program, dead, flow, settings, solver)
    jammed = first.load_factor == np.inf and flow is Flow.NONASSOCIATIVE
    if jammed:
        # Dilatancy jams the blocks, but without dilatancy they may slide. Continue from the dead-load forces, with
        # sliding conditions of slope tan ψ. These bound every load that does not jam the blocks by itself.
        sliding = fictitious_sliding(problem, dead, settings.schedule.c0, 0.0)
        first = solve_step(program, sliding, Stage.NONASSOCIATIVE, settings, solver, c0=settings.schedule.c0)
        yield first
    if first.load_factor == np.inf:
        reason = Reason.NEVER_COLLAPSES if flow is Flow.ASSOCIATIVE else Reason.CARRIES_ANY_LOAD
        return Outcome(Status.UNBOUNDED, np.inf, reason)
    if not first.solved:
        return given_up(problem, Reason.PROGRAM_NOT_SOLVED)
    if flow is Flow.NONASSOCIATIVE:
        steps = _without_dilatancy(program, first, path, settings, solver)
        outcome = yield from _concluded(steps, first, ray if jammed else None, problem, settings, solver)
        if not is_tested or outcome.status is not Status.CONVERGED:
            return outcome
        blocks = jammed_by_self_stress(problem, settings, solver, bounded=not jammed)
        return replace(outcome, jammed=blocks)
    outcome = _collapse(problem, Found(first, Procedure.ASSOCIATIVE))
    if first.certificate.holds and _is_answer(problem, outcome):
        return outcome
    return given_up(problem, Reason.NO_CERTIFICATE, programs=1)


def _associate(
    program: ConicProgram, dead: Array, flow: Flow, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, Iteration]:
    """Solve the associative program.

    With linearised crushing and associative flow, repeat until crushing is exact. If normal forces of many joints are
    not unique, the tangents find the mechanism while the forces oscillate. Once the gap no longer falls, the exact
    cones settle the forces.
    """
    sliding = true_sliding(program.problem)
    linearisation = Linearisation.first(program.problem).after(program.problem, dead)
    last_gap = np.inf
    for _ in range(settings.schedule.max_programs):
        step = solve_step(program, sliding, Stage.ASSOCIATIVE, settings, solver, linearisation=linearisation)
        yield step
        gap = step.certificate.flow_rule_gap
        if step.certificate.holds or not (program.is_linearised and step.solved and flow is Flow.ASSOCIATIVE):
            break
        if gap >= last_gap:
            program = exact(program, settings)
        last_gap = gap
        linearisation = linearisation.after(program.problem, step.x[:, 0])
    return step


def load_factor_at(displacement: float, problem: LimitProblem, bound: float, settings: ProcedureSettings) -> float:
    """Return the load factor at a displacement of the loading path; NaN if the path ends before.

    Parameters
    ----------
    displacement
        As :attr:`Iteration.displacement`.
    problem, settings
        The limit problem and the steps of the path.
    bound
        Load factor with associative flow, or of a similar problem; infinite without one. It scales the first
        guess.

    Returns
    -------
    float
        Load factor of the first step that is as long, in multiples of the variable load of the case.
    """
    path = _path(ConicProgram(problem, settings), settings)
    if path is None or path.dead_load is None:
        return np.nan
    while (step := path.advance(bound * problem.load_unit)) is not None:
        if step.displacement >= displacement * (1 - ROUNDING):
            return step.of_case(problem).load_factor
    return np.nan


def _path(program: ConicProgram, settings: ProcedureSettings) -> "Path | None":
    """Return the loading path at its beginning, if the settings use one."""
    if settings.procedure != "loading path":
        return None
    # Loaded here: its linear algebra is slow to import.
    from blockstruct.procedures.loading_path import path_of

    return path_of(exact(program, settings), settings)


def _dead_load_forces(problem: LimitProblem, path: "Path | None") -> Array | None:
    """Find normal forces (K,) that prove that the structure stands.

    They are near the path's state under dead load. Return None without a proof.
    """
    state = None if path is None else path.dead_load
    if state is None:
        return None
    if state.certificate.admissible:
        return state.x[:, 0]
    own = problem.held
    if not own.is_plain:
        return None
    # Loaded here: it is slow to import.
    from blockstruct.procedures.carried_forces import carried_forces

    x = carried_forces(own.A, own.friction, state.x, -own.w_D)
    tolerance = state.certificate.tolerances["equilibrium_residual"]
    if x is None or np.abs(own.A @ x.ravel() + own.w_D).max() > tolerance:
        return None
    return x[:, 0]


def _without_dilatancy(
    program: ConicProgram, first: Iteration, path: "Path | None", settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, tuple[Found | None, PathEnd | None]]:
    """Run the procedure of the settings, and others without a certificate.

    The fictitious conditions replace a loading path that does not finish. The shifted objective replaces fictitious
    conditions without a certificate. A replacement never counts as settled, because it answers a different question.
    """
    # The dead-load program and the associative program come before.
    left, last, end = settings.schedule.max_programs - 2, first, None
    of_cones = exact(program, settings) if path is None else path.program
    if path is not None:
        from blockstruct.procedures.loading_path import loading_path

        end, closed = yield from loading_path(path, first.load_factor, settings, solver)
        if closed is not None:
            return closed, end
    found = None
    if settings.procedure != "shifted":
        within = min(left, settings.schedule.fallback_after - 2)
        found, last = yield from fictitious_iteration(program, of_cones, first, settings, solver, within)
        left -= within
    if found is None:
        found, _ = yield from shifted_iteration(of_cones, last, settings, solver, left)
    if found is not None and found.procedure.value != settings.procedure:
        found = replace(found, settled=False)
    return found, end


def _concluded(
    steps: Generator[Iteration, None, tuple[Found | None, PathEnd | None]],
    first: Iteration,
    ray: Iteration | None,
    problem: LimitProblem,
    settings: ProcedureSettings,
    solver: Solver,
) -> Steps:
    """Conclude the search for a collapse state.

    ``ray`` is the associative program if it is unbounded. It proves that joints with dilatancy carry any multiple of
    the variable load. It does not prove this without dilatancy.
    """
    load_factors, watched, n = [first.load_factor], ray is not None, 1 if ray is None else 2
    step = first
    while True:
        try:
            step = next(steps)
        except StopIteration as stop:
            found, end = stop.value
            break
        n += step.stage is not Stage.LOADING_PATH
        yield step
        if watched and step.solved and step.stage not in (Stage.ADMISSIBLE, Stage.LOADING_PATH):
            load_factors.append(step.load_factor)
        if ray is not None and watched and grows_without_limit(load_factors):
            watched = False
            if not can_jam(problem, settings, solver):
                yield ray
                return Outcome(Status.UNBOUNDED, np.inf, Reason.GROWS_WITHOUT_LIMIT)
    if found is not None and end is PathEnd.LIMIT_REACHED:
        if ray is not None and not can_jam(problem, settings, solver):
            yield ray
            return Outcome(Status.UNBOUNDED, np.inf, Reason.GROWS_WITHOUT_LIMIT)
        reason = Reason.NEVER_SETTLES if ray is None else Reason.JAMS
        return Outcome(Status.NOT_CONVERGED, np.nan, reason, drift=found.drift, path_end=end)
    if found is None:
        return replace(given_up(problem, Reason.NO_CERTIFICATE, programs=n), path_end=end)
    if found.state is not step:
        # The last iteration of a history is the certified one.
        yield found.state
    outcome = replace(_collapse(problem, found), path_end=end)
    if _is_answer(problem, outcome):
        return outcome
    return replace(given_up(problem, Reason.NEGATIVE_LOAD_FACTOR, programs=n), path_end=end)


def _is_answer(problem: LimitProblem, outcome: Outcome) -> bool:
    """Return whether a load factor is valid.

    It must not be negative; the reaction of a settlement may have any sign.
    """
    return outcome.load_factor >= 0 or problem.settlement is not None


def _collapse(problem: LimitProblem, found: Found) -> Outcome:
    """Return the outcome of a certified state.

    A load factor within the gap of zero is zero.
    """
    state = found.state
    alpha = state.load_factor
    if problem.settlement is None and abs(alpha) <= state.certificate.flow_rule_gap_limit:
        alpha = max(alpha, 0.0)
    return Outcome(
        Status.CONVERGED,
        alpha,
        Reason.CERTIFIED,
        procedure=found.procedure,
        settled=found.settled,
        drift=found.drift,
        peak=found.peak,
    )


def exact(program: ConicProgram, settings: ProcedureSettings) -> ConicProgram:
    """Return the program with the exact cones of crushing."""
    if not program.is_linearised:
        return program
    return ConicProgram(program.problem, replace(settings, crushing="conic"))
