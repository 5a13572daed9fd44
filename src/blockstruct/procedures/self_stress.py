"""What self-stress leaves open: loads that only jammed blocks carry.

Forces that balance each other without any load, as between the jambs of a flat arch, raise the friction of the joints
they press. Their size is not part of the model. A dilatant structure makes them as large as it needs; without dilatancy
they are what the building left behind.
"""

from collections.abc import Generator, Sequence
from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit.friction import frozen_sliding, shift_of, true_sliding
from blockstruct.limit.iteration import Iteration, Outcome, given_up, is_solved
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.limit.ties import Ties
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Reason, Stage, Status

Array = NDArray[np.float64]

#: A load factor grows without limit after this many increments, each larger than the one before and than a share of the
#: load factor, to this multiple of the first one. Measured: increments alone also grow for a while on paths that end.
_INCREMENTS, _SHARE, _MULTIPLE = 5, 0.05, 10.0
#: Velocity of a block that falls, relative to that of the fastest.
_FALLS = 1e-2
#: Attempts of least squares, and the openings beyond friction, relative to the largest velocity, that are proof and
#: that are asked for.
_TRIES, _OPENS, _ASKED = 20, 2e-3, 0.1


def collapse_of_dead_load(
    problem: LimitProblem, found: Iteration, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, Outcome]:
    """Ask whether the mechanism of a negative load factor is one of the dead load alone.

    Such a mechanism is driven by the dead load, and held by friction. If forces carry the whole dead load that this
    mechanism has used up, the dead load itself is at collapse; as forces of another self-stress carry it as well,
    the model does not tell whether the structure stands.

    Parameters
    ----------
    problem
        The limit problem, with the dilatancy of its flow.
    found
        A certified state at a negative load factor.
    settings, solver
        Tolerances and solver.

    Yields
    ------
    Iteration
        The state under the dead load, certified with its own normalisation ``w_D·u = 1``. Its load factor is NaN.
    """
    own, work = problem.dead_load_alone, float(problem.w_D @ found.u)
    if not work > 0:
        return given_up(problem, Reason.NEGATIVE_LOAD_FACTOR)
    step = _falling(own, replace(found, u=found.u / work, v=found.v / work), settings, solver)
    yield replace(step, load_factor=np.nan)
    if _is_whole(step, settings):
        return Outcome(Status.SELF_STRESS, np.nan, Reason.DEAD_LOAD_COLLAPSES)
    return given_up(problem, Reason.NEGATIVE_LOAD_FACTOR)


def _falling(own: LimitProblem, mechanism: Iteration, settings: ProcedureSettings, solver: Solver) -> Iteration:
    """Forces of the dead load, of up to its whole, that miss the flow rule of a mechanism with ``w_D·u = 1`` least."""
    return solve_step(
        ConicProgram(own, replace(settings, crushing="conic")),
        true_sliding(own),
        Stage.DEAD_LOAD,
        settings,
        solver,
        # The flow-rule gap is linear in the forces; the weight above one asks for the whole dead load first.
        objective=Objective(shift_of(own, mechanism.v, mechanism.x[:, 0]), 2.0),
        max_load_factor=1.0,
        mechanism=mechanism,
    )


def _is_whole(step: Iteration, settings: ProcedureSettings) -> bool:
    """Whether a state of :func:`_falling` is one of collapse under the whole dead load."""
    return step.certificate.holds and step.load_factor >= 1 - settings.numerics.gap_tolerance


def grows_without_limit(load_factors: Sequence[float]) -> bool:
    """Whether load factors of successive programs end in a growth that nothing slows down."""
    last = np.array(load_factors[-_INCREMENTS - 1 :])
    increments = np.diff(last)
    return bool(
        len(increments) == _INCREMENTS
        and np.all(np.diff(increments) > 0)
        and np.all(increments > _SHARE * np.abs(last[1:]))
        and last[-1] > _MULTIPLE * load_factors[0] > 0
    )


def can_jam(problem: LimitProblem, settings: ProcedureSettings, solver: Solver) -> bool:
    """Whether the joints may bear normal forces that balance each other without any load.

    They may not if there is a motion that opens all of them faster than friction could close them,
    ``v_n > μ ‖v_t‖``: it would do work on such forces. Without that proof they may. As a rule least squares find one;
    where they do not, a program is asked.
    """
    if not problem.n_points or _opens_everywhere(problem):
        return False
    # What ties press together is limited, and does not count.
    # The variable load only scales the program, which any load does.
    loads = problem.w_L if problem.w_L.any() else problem.w_D
    own = replace(problem, w_D=np.zeros_like(problem.w_D), w_L=loads, ties=Ties.none(len(problem.w_D)))
    program = ConicProgram(own, replace(settings, crushing="conic"))
    opening = Objective(np.full(own.n_points, -1.0 / own.n_points))
    data = program.data(true_sliding(own), objective=opening, max_load_factor=0.0)
    _, _, u = program.unpack(solver.solve(program, data, settings.numerics.solver_tolerance))
    v = (own.A.T @ u).reshape(-1, 3)
    # A NaN, where the solver gives no multipliers, proves nothing.
    return not bool((v[:, 0] - own.friction * np.linalg.norm(v[:, 1:], axis=1)).min() > 0.5 / own.n_points)


def _opens_everywhere(problem: LimitProblem) -> bool:
    """Whether least squares find a motion that opens all joints, asked for more where friction would close them."""
    # Loaded here: it is slow to import.
    from scipy.sparse.linalg import splu

    normal = sp.csc_array(problem.A @ problem.A.T)
    # Blocks that no joint holds in some direction rest in it.
    slight = sp.diags_array(np.full(normal.shape[0], 1e-10 * float(normal.diagonal().mean())))
    solved = splu(sp.csc_matrix(normal + slight))
    asked = np.tile([1.0, 0.0, 0.0], (problem.n_points, 1))
    for _ in range(_TRIES):
        v = (problem.A.T @ solved.solve(problem.A @ asked.ravel())).reshape(-1, 3)
        speed = max(float(np.abs(v).max()), np.finfo(float).tiny)
        beyond = (v[:, 0] - problem.friction * np.linalg.norm(v[:, 1:], axis=1)) / speed
        if beyond.min() > _OPENS:
            return True
        asked[:, 0] += np.where(beyond < _ASKED / 2, 2 * (_ASKED - beyond), 0.0)
    return False


def decided_by_self_stress(
    problem: LimitProblem, settings: ProcedureSettings, solver: Solver
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Free blocks that friction on self-stress may hold or not, group by group.

    What bounds one group tells nothing of another that touches it nowhere. So each group that can jam is asked by
    itself: whether its dead load has a collapse state, from the forces under dead load that press its joints together
    least; and whether, with friction frozen at these, the variable load moves it, though with dilatancy nothing does.
    Where no joints can jam, as in most walls, arches and domes, least squares show it without a program.

    Parameters
    ----------
    problem
        The limit problem without dilatancy, or with that of its joints.
    settings, solver
        Tolerances and solver.

    Returns
    -------
    tuple of int, tuple of int
        Indices of the free blocks that fall with too little self-stress, and those of other groups that it jams.
    """
    own = problem.held
    if not can_jam(own, settings, solver):
        return (), ()
    hung, jammed, groups = np.zeros(own.n_blocks, bool), np.zeros(own.n_blocks, bool), own.groups
    for group in range(int(groups.max()) + 1):
        blocks = groups == group
        part = own.part(blocks)
        if not part.n_points or not (part.w_D.any() or part.w_L.any()):
            continue
        # A group that is all there is has been asked.
        if groups.any() and not can_jam(part, settings, solver):
            continue
        loose = _least_pressed(part, settings, solver)
        hung[blocks] = _hanging(part, loose, settings, solver)
        jammed[blocks] = not hung[blocks].any() and _only_jams(part, loose, settings, solver)
    return tuple(np.flatnonzero(hung).tolist()), tuple(np.flatnonzero(jammed).tolist())


def _least_pressed(part: LimitProblem, settings: ProcedureSettings, solver: Solver) -> Array:
    """Normal forces (K,) of the least sum that carry the dead load; NaN where the solver finds none."""
    if not part.w_D.any():
        return np.zeros(part.n_points)
    program = ConicProgram(replace(part, w_L=part.w_D), replace(settings, crushing="conic"))
    least = Objective(np.full(part.n_points, 1.0 / part.n_points))
    data = program.data(true_sliding(part), objective=least, max_load_factor=0.0, loaded=False)
    solution = solver.solve(program, data, settings.numerics.solver_tolerance)
    forces = program.unpack(solution)[1][:, 0]
    return forces if is_solved(solution.status) else np.full(part.n_points, np.nan)


def _hanging(part: LimitProblem, loose: Array, settings: ProcedureSettings, solver: Solver) -> NDArray[np.bool_]:
    """Blocks that fall, (F,), in a collapse state of the dead load by a mechanism of friction frozen at n (K,)."""
    none = np.zeros(part.n_blocks, dtype=bool)
    if not part.w_D.any() or not np.isfinite(loose).all():
        return none
    own = part.dead_load_alone
    program = ConicProgram(own, replace(settings, crushing="conic"))
    found = solve_step(program, frozen_sliding(own, loose), Stage.DEAD_LOAD, settings, solver)
    if not found.solved or found.load_factor > 1 + settings.numerics.gap_tolerance:
        return none
    if not _is_whole(_falling(own, found, settings, solver), settings):
        return none
    speed = np.linalg.norm(found.u.reshape(-1, 6)[:, :3], axis=1) / own.wrench_unit
    return np.asarray(speed > _FALLS * speed.max())


def _only_jams(part: LimitProblem, loose: Array, settings: ProcedureSettings, solver: Solver) -> bool:
    """Whether the variable load moves blocks whose friction is frozen at normal forces (K,), and no others."""
    if not part.w_L.any() or not np.isfinite(loose).all():
        return False
    program = ConicProgram(part, replace(settings, crushing="conic"))
    dilating = solve_step(program, true_sliding(part), Stage.ASSOCIATIVE, settings, solver)
    if dilating.load_factor != np.inf:
        return False
    return solve_step(program, frozen_sliding(part, loose), Stage.NONASSOCIATIVE, settings, solver).solved
