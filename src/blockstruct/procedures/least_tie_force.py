"""Find the least strength of ties with which a structure carries a load."""

from dataclasses import dataclass, replace

import numpy as np

from blockstruct.arrays import Array, Flags
from blockstruct.limit.certificate import Certificate, certify
from blockstruct.limit.friction import true_sliding
from blockstruct.limit.iteration import is_solved
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.vocabulary import SolverStatus


@dataclass(frozen=True, slots=True)
class LeastTies:
    """Result of the program, non-dimensional.

    Attributes
    ----------
    tie_force : (M,) array
        Forces T of all ties with their prestress; NaN if the program has no feasible point.
    certificate : Certificate
        Certificate of the state in the structure whose tie strengths equal these forces.
    least : bool
        Whether the multipliers prove that no ties with a smaller sum of strengths suffice.
    solver_status : SolverStatus
        Status of the solver.
    governing : "load factor", "dead load" or "both"
        The load that requires these strengths: at the load factor, or the dead load alone. The certificate is for this
        load, and for the load factor if both govern.
    """

    tie_force: Array
    certificate: Certificate
    least: bool
    solver_status: SolverStatus
    governing: str = "load factor"


def least_ties(
    problem: LimitProblem, sought: Flags, alpha: float, settings: ProcedureSettings, solver: Solver
) -> LeastTies:
    """Minimise the sum of tie strengths that carry a load factor.

    The structure must also stand under the dead load alone, because a variable load may hold up a structure that would
    fall without it. A structure that carries both loads carries any load factor between them. If the least strengths
    for one load suffice for the other, they are the least for both. Otherwise the larger strength of each tie suffices,
    and a smaller sum may exist.

    Parameters
    ----------
    problem
        The limit problem.
    sought : (M,) array
        Whether each strength is sought.
    alpha
        Load factor.
    settings, solver
        Tolerances and solver.
    """
    loaded = _least_at(problem, sought, alpha, settings, solver)
    if not problem.w_D.any() or np.isnan(loaded.tie_force).any():
        return loaded
    alone = problem.dead_load_alone
    if _carries(alone, sought, loaded.tie_force, 1.0, settings, solver):
        return loaded
    at_rest = _least_at(alone, sought, 1.0, settings, solver)
    if np.isnan(at_rest.tie_force).any() or _carries(problem, sought, at_rest.tie_force, alpha, settings, solver):
        return replace(at_rest, governing="dead load")
    return replace(loaded, tie_force=np.maximum(loaded.tie_force, at_rest.tie_force), least=False, governing="both")


def _least_at(
    problem: LimitProblem, sought: Flags, alpha: float, settings: ProcedureSettings, solver: Solver
) -> LeastTies:
    """Minimise the sum of tie strengths at a load factor.

    ``min Σ T_j`` subject to ``A x + Σ a_j T_j + w_D + α w_L = 0`` and all other conditions, with associative flow. The
    sought ties have no upper limit. Strength above the force has no use, so the forces are the strengths. The
    multipliers are a mechanism in which no sought tie elongates by more than its price. This proves that no weaker ties
    suffice.
    """
    ties = problem.ties
    loaded = _loaded(problem, np.where(sought, np.inf, ties.capacity), alpha)
    price = np.where(sought, ties.force_unit, 0.0) / ties.force_unit[sought].max()
    status, x, u, T = _solved(loaded, Objective(np.zeros(loaded.n_points), price=price), settings, solver)
    strength = _strength(problem, sought, T, alpha)
    tied = replace(problem, dilatancy=problem.friction, ties=replace(ties, capacity=strength))
    # If the ties are not needed, no mechanism does work on the load.
    work = float(problem.w_L @ u)
    certificate = certify(tied, x, u / work if work > 0 else u, alpha, settings, T)
    dear = (ties.elongation(u) - price)[sought]
    left = float((strength[sought] * np.abs(dear)).sum()) / max(float((strength * price).sum()), 1e-12)
    # Prices are velocities. NaN proves nothing.
    tolerance = settings.numerics.interpenetration_tolerance
    least = bool(dear.max() <= tolerance and left <= tolerance)
    return LeastTies(T, certificate, least, status)


def _carries(
    problem: LimitProblem,
    sought: Flags,
    tie_force: Array,
    alpha: float,
    settings: ProcedureSettings,
    solver: Solver,
) -> bool:
    """Return whether ties of these strengths carry a load factor."""
    tied = _loaded(problem, _strength(problem, sought, tie_force, alpha), alpha)
    _, x, u, T = _solved(tied, Objective(np.zeros(tied.n_points)), settings, solver)
    return certify(tied, x, u, 0.0, settings, T).admissible


def _loaded(problem: LimitProblem, capacity: Array, alpha: float) -> LimitProblem:
    """Return the problem with its load at a load factor as dead load.

    Flow follows the friction angle.
    """
    ties = replace(problem.ties.at(alpha), capacity=capacity)
    return replace(problem, dilatancy=problem.friction, w_D=problem.w_D + alpha * problem.w_L, ties=ties)


def _strength(problem: LimitProblem, sought: Flags, tie_force: Array, alpha: float) -> Array:
    """Return tie strengths beyond the prestress, (M,).

    The sought ties get ``tie_force`` as strength; the others keep their own.
    """
    beyond = np.maximum(tie_force - problem.ties.prestress(alpha), 0.0)
    return np.where(sought, beyond, problem.ties.capacity)


def _solved(
    loaded: LimitProblem, objective: Objective, settings: ProcedureSettings, solver: Solver
) -> tuple[SolverStatus, Array, Array, Array]:
    """Solve under the dead load alone.

    Return status, contact forces, velocities and tie forces; they are NaN without a solution.
    """
    program = ConicProgram(loaded, replace(settings, crushing="conic"))
    data = program.data(true_sliding(loaded), objective=objective, max_load_factor=0.0, loaded=False)
    solution = solver.solve(program, data, settings.numerics.solver_tolerance)
    _, x, u = program.unpack(solution)
    T = program.tie_force(solution)
    if not is_solved(solution.status):
        x, u, T = (np.full_like(part, np.nan) for part in (x, u, T))
    return solution.status, x, u, T
