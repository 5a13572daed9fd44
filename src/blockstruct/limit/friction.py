"""Sliding conditions: the true cone, and the fictitious one of the non-associative iteration."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.problem import LimitProblem

Array = NDArray[np.float64]

#: Cohesion that keeps the program of frozen friction feasible.
CAP = 1e-9
#: Friction coefficient up to which the fictitious iteration starts from the associative program. Beyond, dilatancy
#: wedges blocks by forces far above their weights. Measured on a wall with a friction of 2.5: 1.505 from the
#: associative program, 0.579 from here and along the loading path.
STEEPEST = 0.65


@dataclass(frozen=True, slots=True)
class Sliding:
    """Condition ``‖(s_k, t_k)‖ ≤ bound_k + slope_k n_k`` at every contact point, non-dimensional."""

    bound: Array
    slope: Array


def true_sliding(problem: LimitProblem) -> Sliding:
    """Coulomb's condition."""
    return Sliding(problem.cohesion, problem.friction)


def limited_sliding(problem: LimitProblem) -> Sliding:
    """Coulomb's condition with a friction coefficient of at most 0.65, or of tan ψ where that is larger."""
    return Sliding(problem.cohesion, np.minimum(problem.friction, np.maximum(problem.dilatancy, STEEPEST)))


def fictitious_sliding(problem: LimitProblem, n0: Array, c0: float, a: float) -> Sliding:
    """Condition through the point of Coulomb's condition at ``n0``, raised by ``c0``, of slope tan ψ − a (μ − tan ψ).

    For ψ = 0 it is ``c0 + (1 + a) μ n0 − a μ n``; for ψ = φ Coulomb's condition itself, raised by ``c0``.
    """
    slope = problem.dilatancy - a * (problem.friction - problem.dilatancy)
    return Sliding(problem.cohesion + c0 + (problem.friction - slope) * n0, slope)


def frozen_sliding(problem: LimitProblem, n0: Array) -> Sliding:
    """Condition whose resistance beyond that of dilatancy is of normal forces n0 (K,), whatever n is."""
    return fictitious_sliding(problem, n0, CAP, 0.0)


def shift_of(problem: LimitProblem, v: Array, n: Array) -> Array:
    """Shift ``(μ − tan ψ) ‖v_t,k‖`` of De Saxcé & Feng (1998) at relative velocities v, (K,).

    In interfaces with the torsion of uniform pressure the rate of sliding depends on the normal forces n (K,).
    """
    return np.asarray((problem.friction - problem.dilatancy) * problem.slip(v, n))


def relax(n0: Array, n: Array, beta: float) -> Array:
    """``β n + (1 − β) n0``."""
    return beta * n + (1 - beta) * n0
