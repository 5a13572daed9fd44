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
    """

    tie_force: Array
    certificate: Certificate
    least: bool
    solver_status: SolverStatus


def least_ties(
    problem: LimitProblem, sought: NDArray[np.bool_], alpha: float, settings: ProcedureSettings, solver: Solver
) -> LeastTies:
    """Minimise the sum of the strengths of ties at a given load factor, with associative flow.

    ``min Σ T_j`` subject to ``A x + Σ a_j T_j + w_D + α w_L = 0`` and all conditions but the upper limits of the ties
    that are sought. As a strength above the force buys nothing, the forces are the strengths. Its multipliers are a
    mechanism in which no tie that is sought gets longer by more than its price, so that no weaker ones will do.

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
    ties, associative = problem.ties, replace(problem, dilatancy=problem.friction)
    free = replace(ties, capacity=np.where(sought, np.inf, ties.capacity))
    loaded = replace(associative, w_D=problem.w_D + alpha * problem.w_L, ties=free)
    program = ConicProgram(loaded, replace(settings, crushing="conic"))
    price = np.where(sought, ties.force_unit, 0.0) / ties.force_unit[sought].max()
    data = program.data(
        true_sliding(loaded),
        objective=Objective(np.zeros(loaded.n_points), price=price),
        max_load_factor=0.0,
        loaded=False,
    )
    solution = solver.solve(program, data, settings.solver_tolerance)
    _, x, u = program.unpack(solution)
    if not is_solved(solution.status):
        x, u = np.full_like(x, np.nan), np.full_like(u, np.nan)
    T = program.tie_force(solution) if is_solved(solution.status) else np.full(len(ties), np.nan)
    strength = np.where(sought, np.maximum(T - ties.prestress(alpha), 0.0), ties.capacity)
    tied = replace(associative, ties=replace(ties, capacity=strength))
    # Where the ties are not needed no mechanism does work on the load.
    work = float(problem.w_L @ u)
    certificate = certify(tied, x, u / work if work > 0 else u, alpha, settings, T)
    dear = (ties.elongation(u) - price)[sought]
    left = float((strength[sought] * np.abs(dear)).sum()) / max(float((strength * price).sum()), 1e-12)
    # A NaN is not proof.
    least = bool(dear.max() <= _PRICED and left <= _PRICED)
    return LeastTies(T, certificate, least, solution.status)
