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

from blockstruct.limit import crushing
from blockstruct.limit.certificate import certify
from blockstruct.limit.friction import frozen_sliding, shift_of, true_sliding
from blockstruct.limit.iteration import Iteration, is_solved
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.limit.ties import Ties
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Stage

Array = NDArray[np.float64]

#: A load factor grows without limit after this many increments, each larger than the one before and than a share of the
#: load factor, to this multiple of the first one. Measured: increments alone also grow for a while on paths that end.
_INCREMENTS, _SHARE, _MULTIPLE = 5, 0.05, 10.0
#: Share of the dead load that frozen friction must carry more to need no program.
_MORE = 1e-2
#: Velocity of a block that falls, relative to that of the fastest.
_FALLS = 1e-2
#: Attempts of least squares, and the openings beyond friction, relative to the largest velocity, that are proof and
#: that are asked for.
_TRIES, _OPENS, _ASKED = 20, 2e-3, 0.1
#: Stiffness of blocks in directions in which no joint holds them, relative to the mean.
_SLIGHT = 1e-10


def dead_load_collapse(
    problem: LimitProblem, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, tuple[int, ...]]:
    """Find the blocks that friction holds under the dead load in some states of self-stress and not in others.

    Whether they fall depends on forces that the model does not determine. The answer depends on the joints and the
    dead load alone, and not on the variable load.

    Normal forces that carry the dead load without friction prove that nothing falls. With them the dead load does no
    work in any motion that closes no joint, and a collapse state without dilatancy needs work against friction. Least
    squares find such forces in most walls. Otherwise each group of blocks that touches no other is tested with the
    forces that press its joints together least.

    Parameters
    ----------
    problem
        The limit problem, with the dilatancy of its joints.
    settings, solver
        Tolerances and solver.

    Yields
    ------
    Iteration
        The collapse state of the dead load, if one is found, with its own normalisation ``w_D·u = 1``. Its load factor
        is NaN.

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
        # One group alone is the whole, which has been tested.
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
    return tuple(np.flatnonzero(speed > _FALLS * speed.max()).tolist())


def _stands_without_friction(problem: LimitProblem, settings: ProcedureSettings) -> bool:
    """Whether least squares find normal forces that carry the dead load without friction.

    Contact points that they put in tension are left out of the next attempt.
    """
    # Loaded here: it is slow to import.
    from scipy.sparse.linalg import splu

    A, bears = sp.csc_array(problem.A)[:, ::3], np.ones(problem.n_points, dtype=bool)
    for _ in range(_TRIES):
        bearing = sp.csc_array(A[:, bears])
        normal = sp.csc_array(bearing @ bearing.T)
        slight = sp.diags_array(np.full(normal.shape[0], _SLIGHT * max(float(normal.diagonal().mean()), 1.0)))
        n = -(bearing.T @ splu(sp.csc_matrix(normal + slight)).solve(problem.w_D))
        if np.abs(bearing @ n + problem.w_D).max() > settings.numerics.equilibrium_tolerance:
            return False
        pulled = n < -0.1 * settings.numerics.yield_tolerance
        if not pulled.any():
            x, u = np.zeros((problem.n_points, 3)), np.zeros_like(problem.w_D)
            x[bears, 0] = n
            return certify(problem, x, u, 0.0, settings, problem.ties.prestress(0.0)).admissible
        bears[np.flatnonzero(bears)[pulled]] = False
    return False


def _fall(part: LimitProblem, settings: ProcedureSettings, solver: Solver) -> Iteration | None:
    """Mechanism of a collapse state of the dead load with friction frozen, None if there is none."""
    forces = _least_pressed(part, settings, solver)
    if forces is None:
        return None
    own, tolerance = part.dead_load_alone, settings.numerics.gap_tolerance
    frozen = frozen_sliding(own, forces[:, 0])
    beyond = (1 + _MORE) * np.linalg.norm(forces[:, 1:], axis=1) - frozen.bound - frozen.slope * forces[:, 0]
    if beyond.max() <= 10 * settings.numerics.solver_tolerance:
        # A larger share of the dead load is carried with the same friction.
        return None
    found = solve_step(_exact(own, settings), frozen, Stage.DEAD_LOAD_COLLAPSE, settings, solver)
    if not found.solved or found.load_factor > 1 + tolerance:
        return None
    collapse = _falling(own, found.u, found.x[:, 0], settings, solver)
    return found if collapse.certificate.holds and collapse.load_factor >= 1 - tolerance else None


def _falling(own: LimitProblem, u: Array, n: Array, settings: ProcedureSettings, solver: Solver) -> Iteration:
    """Forces of the dead load, at most its whole, that miss the flow rule of velocities with ``w_D·u = 1`` least.

    Joints of uniform torsion slide as normal forces n (K,) near them tell.
    """
    v, biaxial = (own.A.T @ u).reshape(-1, 3), settings.crushing_interaction == "biaxial"
    shift = shift_of(own, v, n) + crushing.shift(own, v, n, biaxial=biaxial)
    return solve_step(
        _exact(own, settings),
        true_sliding(own),
        Stage.DEAD_LOAD_COLLAPSE,
        settings,
        solver,
        # The flow-rule gap is linear in the forces. The weight above one favours the whole dead load.
        objective=Objective(shift, 2.0),
        max_load_factor=1.0,
        velocities=u,
    )


def _exact(problem: LimitProblem, settings: ProcedureSettings) -> ConicProgram:
    """The program with the exact cones of crushing."""
    return ConicProgram(problem, replace(settings, crushing="conic"))


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
    program = _exact(own, settings)
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
    slight = sp.diags_array(np.full(normal.shape[0], _SLIGHT * float(normal.diagonal().mean())))
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


def jammed_by_self_stress(
    problem: LimitProblem, settings: ProcedureSettings, solver: Solver, *, bounded: bool
) -> tuple[int, ...]:
    """Indices of the free blocks that self-stress keeps from moving under the variable load, or may not.

    The load factor of one group of blocks says nothing about another that touches it nowhere. A group jams if, with
    friction frozen at the forces under dead load that press its joints together least, the variable load moves it,
    though with dilatancy nothing does.

    Parameters
    ----------
    problem
        The limit problem without dilatancy, or with that of its joints.
    settings, solver
        Tolerances and solver.
    bounded
        Whether the load factor with dilatancy is finite, so that one group alone does not jam.
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
    """Forces (K, 3) of the least normal forces that carry the dead load; None where the solver finds none."""
    if not part.w_D.any():
        return np.zeros((part.n_points, 3))
    program = _exact(replace(part, w_L=part.w_D), settings)
    least = Objective(np.full(part.n_points, 1.0 / part.n_points))
    data = program.data(true_sliding(part), objective=least, max_load_factor=0.0, loaded=False)
    solution = solver.solve(program, data, settings.numerics.solver_tolerance)
    return program.unpack(solution)[1] if is_solved(solution.status) else None


def _only_jams(part: LimitProblem, settings: ProcedureSettings, solver: Solver) -> bool:
    """Whether the variable load moves blocks with friction frozen, and no blocks with dilatancy."""
    program = _exact(part, settings)
    if solve_step(program, true_sliding(part), Stage.ASSOCIATIVE, settings, solver).load_factor != np.inf:
        return False
    forces = _least_pressed(part, settings, solver)
    if forces is None:
        return False
    return solve_step(program, frozen_sliding(part, forces[:, 0]), Stage.NONASSOCIATIVE, settings, solver).solved
