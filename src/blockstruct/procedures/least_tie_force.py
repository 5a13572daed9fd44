"""The least strength of ties with which a structure carries a load."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.certificate import Certificate, certify
from blockstruct.limit.friction import true_sliding
from blockstruct.limit.iteration import is_solved
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.vocabulary import SolverStatus

Array = NDArray[np.float64]

#: By how much an elongation may miss its price, relative to the largest price.
_PRICED = 1e-4


@dataclass(frozen=True, slots=True)
class LeastTies:
    """What the program found, non-dimensional.

    Attributes
    ----------
    tie_force : (M,) array
        Forces T of all ties with their prestress; NaN if the program has no point.
    certificate : Certificate
        Of the state in the structure whose ties have these forces as their strengths.
    least : bool
        Whether the multipliers prove that no ties of a smaller sum will do.
    solver_status : SolverStatus
    governing : "load factor", "dead load" or "both"
        What asks for these strengths: the load factor, or the dead load alone. The certificate is that of this load,
        and of the load factor if it is both.
    """

    tie_force: Array
    certificate: Certificate
    least: bool
    solver_status: SolverStatus
    governing: str = "load factor"


def least_ties(
    problem: LimitProblem, sought: NDArray[np.bool_], alpha: float, settings: ProcedureSettings, solver: Solver
) -> LeastTies:
    """Minimise the sum of the strengths of ties with which a structure stands, and carries a load factor.

    It must do both: a variable load may well hold up what the dead load alone brings down. What carries the two carries
    any load factor between them. The least strengths for either that will do for the other are the least for both.
    Where neither will, the larger ones of each tie do, and a smaller sum may.

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
    problem: LimitProblem, sought: NDArray[np.bool_], alpha: float, settings: ProcedureSettings, solver: Solver
) -> LeastTies:
    """Minimise the sum of the strengths of ties at a given load factor, with associative flow.

    ``min Σ T_j`` subject to ``A x + Σ a_j T_j + w_D + α w_L = 0`` and all conditions but the upper limits of the ties
    that are sought. As a strength above the force buys nothing, the forces are the strengths. Its multipliers are a
    mechanism in which no tie that is sought gets longer by more than its price, so that no weaker ones will do.
    """
    ties = problem.ties
    loaded = _loaded(problem, np.where(sought, np.inf, ties.capacity), alpha)
    price = np.where(sought, ties.force_unit, 0.0) / ties.force_unit[sought].max()
    status, x, u, T = _solved(loaded, Objective(np.zeros(loaded.n_points), price=price), settings, solver)
    strength = _strength(problem, sought, T, alpha)
    tied = replace(problem.associated, ties=replace(ties, capacity=strength))
    # Where the ties are not needed no mechanism does work on the load.
    work = float(problem.w_L @ u)
    certificate = certify(tied, x, u / work if work > 0 else u, alpha, settings, T)
    dear = (ties.elongation(u) - price)[sought]
    left = float((strength[sought] * np.abs(dear)).sum()) / max(float((strength * price).sum()), 1e-12)
    # A NaN is not proof.
    least = bool(dear.max() <= _PRICED and left <= _PRICED)
    return LeastTies(T, certificate, least, status)


def _carries(
    problem: LimitProblem,
    sought: NDArray[np.bool_],
    tie_force: Array,
    alpha: float,
    settings: ProcedureSettings,
    solver: Solver,
) -> bool:
    """Whether forces are found that carry a load factor with ties of these strengths."""
    tied = _loaded(problem, _strength(problem, sought, tie_force, alpha), alpha)
    _, x, u, T = _solved(tied, Objective(np.zeros(tied.n_points)), settings, solver)
    return certify(tied, x, u, 0.0, settings, T).admissible


def _loaded(problem: LimitProblem, capacity: Array, alpha: float) -> LimitProblem:
    """The problem with flow by the friction angle, whose dead load is all of its load at a load factor."""
    ties = replace(problem.ties.at(alpha), capacity=capacity)
    return replace(problem.associated, w_D=problem.w_D + alpha * problem.w_L, ties=ties)


def _strength(problem: LimitProblem, sought: NDArray[np.bool_], tie_force: Array, alpha: float) -> Array:
    """Strengths beyond the prestress, (M,), if the ties that are sought have these forces as theirs."""
    beyond = np.maximum(tie_force - problem.ties.prestress(alpha), 0.0)
    return np.where(sought, beyond, problem.ties.capacity)


def _solved(
    loaded: LimitProblem, objective: Objective, settings: ProcedureSettings, solver: Solver
) -> tuple[SolverStatus, Array, Array, Array]:
    """Status, contact forces, velocities and tie forces under the dead load; NaN without a solution."""
    program = ConicProgram(loaded, replace(settings, crushing="conic"))
    data = program.data(true_sliding(loaded), objective=objective, max_load_factor=0.0, loaded=False)
    solution = solver.solve(program, data, settings.numerics.solver_tolerance)
    _, x, u = program.unpack(solution)
    T = program.tie_force(solution)
    if not is_solved(solution.status):
        x, u, T = (np.full_like(part, np.nan) for part in (x, u, T))
    return solution.status, x, u, T
