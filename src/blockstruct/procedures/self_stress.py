"""Find loads that depend on self-stress: only jammed blocks carry them.

Self-stress forces balance each other without load, for example between the jambs of a flat arch. They raise the
friction of the joints they press. The model does not determine their size. A dilatant structure makes them as large as
it needs. Without dilatancy, they depend on the construction of the building.
"""

from collections.abc import Generator, Sequence
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import NEGLIGIBLE, Array
from blockstruct.limit.certificate import certify
from blockstruct.limit.friction import frozen_sliding, shift_of, true_sliding
from blockstruct.limit.iteration import Iteration, is_solved
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.limit.ties import Ties
from blockstruct.procedures.step import solve_step
from blockstruct.solvers.anderson import REGULARISATION
from blockstruct.vocabulary import Stage

#: Multiple of the first load factor from which a load factor that still speeds up grows without limit. Measured:
#: increments also grow for a while on paths that end.
_MULTIPLE = 10.0


def dead_load_collapse(
    problem: LimitProblem, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, tuple[int, ...]]:
    """Find blocks that stand under dead load only in some self-stress states.

    Whether they fall depends on forces that the model does not determine. The answer depends on the joints and the dead
    load, and not on the variable load.

    Normal forces that carry the dead load without friction prove that nothing falls. With these forces, the dead load
    does no work in any motion that closes no joint. A collapse state without dilatancy needs work against friction.
    Least squares find such forces in most walls. Otherwise each group of blocks without contact to others is tested
    separately. The test uses the forces with the least normal forces.

    Parameters
    ----------
    problem
        The limit problem, with the dilatancy of its joints.
    settings, solver
        Tolerances and solver.

    Yields
    ------
    Iteration
        The collapse state of the dead load, if there is one, with the normalisation ``w_D·u = 1``. Its load factor is
        NaN.

    Returns
    -------
    tuple of int
        Indices of the free blocks that fall, empty if the dead load has no such collapse state.
    """
    whole = problem.held
    dilates = bool((whole.friction == whole.dilatancy).all())
    if dilates or not whole.w_D.any() or _stands_without_friction(whole, settings):
        return ()
    groups, u, n = whole.groups, np.zeros((whole.n_blocks, 6)), np.zeros(whole.n_points)
    for group in range(int(groups.max()) + 1):
        blocks = groups == group
        part = whole.part(blocks)
        if not part.n_points or not part.w_D.any():
            continue
        # A single group is the whole structure, which is already tested.
        if groups.any() and _stands_without_friction(part, settings):
            continue
        found = _fall(part, settings, solver)
        if found is not None:
            u[blocks], n[whole.points_of(blocks)] = found.u.reshape(-1, 6), found.x[:, 0]
    if not u.any():
        return ()
    own = whole.dead_load_alone
    velocities = u.ravel() / float(own.w_L @ u.ravel())
    yield replace(_falling(own, velocities, n, settings, solver), load_factor=np.nan)
    speed = np.linalg.norm(u[:, :3], axis=1) / whole.wrench_unit
    return tuple(np.flatnonzero(speed > settings.numerics.interpenetration_tolerance * speed.max()).tolist())


def _stands_without_friction(problem: LimitProblem, settings: ProcedureSettings) -> bool:
    """Return whether normal forces alone carry the dead load.

    Least squares find the forces. Each attempt leaves out the contact points that the last one puts in tension.
    """
    # Loaded here: it is slow to import.
    from scipy.sparse.linalg import splu

    A, bears = sp.csc_array(problem.A)[:, ::3], np.ones(problem.n_points, dtype=bool)
    while True:
        bearing = sp.csc_array(A[:, bears])
        normal = sp.csc_array(bearing @ bearing.T)
        slight = sp.diags_array(np.full(normal.shape[0], REGULARISATION * max(float(normal.diagonal().mean()), 1.0)))
        n = -(bearing.T @ splu(sp.csc_matrix(normal + slight)).solve(problem.w_D))
        if np.abs(bearing @ n + problem.w_D).max() > settings.numerics.equilibrium_tolerance:
            return False
        pulled = n < -0.1 * settings.numerics.yield_tolerance
        if not pulled.any():
            x, u = np.zeros((problem.n_points, 3)), np.zeros_like(problem.w_D)
            x[bears, 0] = n
            return certify(problem, x, u, 0.0, settings, problem.ties.prestress(0.0)).admissible
        bears[np.flatnonzero(bears)[pulled]] = False


def _fall(part: LimitProblem, settings: ProcedureSettings, solver: Solver) -> Iteration | None:
    """Find a collapse mechanism of the dead load with friction frozen.

    Return None if there is no such mechanism.
    """
    forces = _least_pressed(part, settings, solver)
    if forces is None:
        return None
    own, tolerance = part.dead_load_alone, settings.numerics.gap_tolerance
    frozen = frozen_sliding(own, forces[:, 0])
    beyond = (1 + tolerance) * np.linalg.norm(forces[:, 1:], axis=1) - frozen.bound - frozen.slope * forces[:, 0]
    if beyond.max() <= 10 * settings.numerics.solver_tolerance:
        # Frozen friction carries more than the dead load, and no program is necessary.
        return None
    found = solve_step(_exact(own, settings), frozen, Stage.DEAD_LOAD_COLLAPSE, settings, solver)
    if not found.solved or found.load_factor > 1 + tolerance:
        return None
    collapse = _falling(own, found.u, found.x[:, 0], settings, solver)
    return found if collapse.certificate.holds and collapse.load_factor >= 1 - tolerance else None


def _falling(own: LimitProblem, u: Array, n: Array, settings: ProcedureSettings, solver: Solver) -> Iteration:
    """Find the forces of the dead load that miss a flow rule least.

    They carry at most the whole dead load. The velocities satisfy ``w_D·u = 1``. Nearby normal forces n (K,) determine
    the sliding of joints of uniform torsion.
    """
    v = (own.A.T @ u).reshape(-1, 3)
    return solve_step(
        _exact(own, settings),
        true_sliding(own),
        Stage.DEAD_LOAD_COLLAPSE,
        settings,
        solver,
        # The flow-rule gap is linear in the forces. The weight above one favours the whole dead load.
        objective=Objective(shift_of(own, v, n), 2.0),
        max_load_factor=1.0,
        velocities=u,
    )


def _exact(problem: LimitProblem, settings: ProcedureSettings) -> ConicProgram:
    """Return the program with the exact cones of crushing."""
    return ConicProgram(problem, replace(settings, crushing="conic"))


def grows_without_limit(load_factors: Sequence[float]) -> bool:
    """Return whether load factors of successive programs grow without limit.

    They have grown far, and by more in each program than in any before.
    """
    increments = np.diff(load_factors)
    speeds_up = len(increments) > 1 and increments[-1] > increments[:-1].max()
    return bool(speeds_up and load_factors[-1] > _MULTIPLE * load_factors[0] > 0)


def can_jam(problem: LimitProblem, settings: ProcedureSettings, solver: Solver) -> bool:
    """Return whether joints may carry normal forces that balance without load.

    They cannot if a motion opens all joints faster than friction could close them, ``v_n > μ ‖v_t‖``. Joints that never
    slide must open without sliding. Such a motion would do work on the forces. Without this proof, the answer is that
    they may. Least squares usually find such a motion; otherwise a program searches for it.
    """
    if not problem.n_points or _opens_everywhere(problem):
        return False
    # Forces from ties are limited and do not count. The variable load only scales the program, and any load can do so.
    loads = problem.w_L if problem.w_L.any() else problem.w_D
    own = replace(problem, w_D=np.zeros_like(problem.w_D), w_L=loads, ties=Ties.none(len(problem.w_D)))
    program = _exact(own, settings)
    opening = Objective(np.full(own.n_points, -1.0 / own.n_points))
    data = program.data(true_sliding(own), objective=opening, max_load_factor=0.0)
    _, _, u = program.unpack(solver.solve(program, data, settings.numerics.solver_tolerance))
    v = (own.A.T @ u).reshape(-1, 3)
    slip = np.linalg.norm(v[:, 1:], axis=1)
    slipping = (slip / own.force_unit)[own.never_slides].max(initial=0.0)
    held = slipping <= settings.numerics.interpenetration_tolerance * own.speed(v, u)
    # NaN proves nothing: the solver then gives no multipliers.
    return not bool(held and (v[:, 0] - own.friction * slip).min() > 0.5 / own.n_points)


def _opens_everywhere(problem: LimitProblem) -> bool:
    """Return whether least squares find a motion that opens all joints.

    Joints that open less than the mean get a larger target, while this halves the missing opening.
    """
    if problem.never_slides.any():
        # Least squares do not keep joints from sliding.
        return False
    # Loaded here: it is slow to import.
    from scipy.sparse.linalg import splu

    normal = sp.csc_array(problem.A @ problem.A.T)
    slight = sp.diags_array(np.full(normal.shape[0], REGULARISATION * float(normal.diagonal().mean())))
    solved = splu(sp.csc_matrix(normal + slight))
    asked, before = np.tile([1.0, 0.0, 0.0], (problem.n_points, 1)), np.inf
    while True:
        v = (problem.A.T @ solved.solve(problem.A @ asked.ravel())).reshape(-1, 3)
        opening = v[:, 0] - problem.friction * np.linalg.norm(v[:, 1:], axis=1)
        missing = NEGLIGIBLE * float(np.abs(v).max()) - float(opening.min())
        if missing < 0:
            return True
        if not missing < before / 2:
            return False
        asked[:, 0] += np.maximum(opening.mean() - opening, 0.0)
        before = missing


def jammed_by_self_stress(
    problem: LimitProblem, settings: ProcedureSettings, solver: Solver, *, bounded: bool
) -> tuple[int, ...]:
    """Find free blocks that self-stress may keep from moving.

    The load factor of one group of blocks does not apply to a group without contact to it. A group jams if the variable
    load moves it with frozen friction, but not with dilatancy. Friction is frozen at the dead-load forces with the
    least normal forces.

    Parameters
    ----------
    problem
        The limit problem, without dilatancy or with the dilatancy of its joints.
    settings, solver
        Tolerances and solver.
    bounded
        Whether the load factor with dilatancy is finite. A single group then does not jam.

    Returns
    -------
    tuple of int
        Indices of the free blocks.
    """
    groups, jammed = problem.groups, np.zeros(problem.n_blocks, dtype=bool)
    if bounded and not groups.any():
        return ()
    for group in range(int(groups.max()) + 1):
        part = problem.part(groups == group)
        if part.n_points and part.w_L.any() and can_jam(part, settings, solver):
            jammed[groups == group] = _only_jams(part, settings, solver)
    return tuple(np.flatnonzero(jammed).tolist())


def _least_pressed(part: LimitProblem, settings: ProcedureSettings, solver: Solver) -> Array | None:
    """Return forces (K, 3) that carry the dead load with least normal forces.

    Return None if the solver finds no such forces.
    """
    if not part.w_D.any():
        return np.zeros((part.n_points, 3))
    program = _exact(replace(part, w_L=part.w_D), settings)
    least = Objective(np.full(part.n_points, 1.0 / part.n_points))
    data = program.data(true_sliding(part), objective=least, max_load_factor=0.0, loaded=False)
    solution = solver.solve(program, data, settings.numerics.solver_tolerance)
    return program.unpack(solution)[1] if is_solved(solution.status) else None


def _only_jams(part: LimitProblem, settings: ProcedureSettings, solver: Solver) -> bool:
    """Return whether blocks move with frozen friction but not with dilatancy."""
    program = _exact(part, settings)
    if solve_step(program, true_sliding(part), Stage.ASSOCIATIVE, settings, solver).load_factor != np.inf:
        return False
    forces = _least_pressed(part, settings, solver)
    if forces is None:
        return False
    return solve_step(program, frozen_sliding(part, forces[:, 0]), Stage.NONASSOCIATIVE, settings, solver).solved
