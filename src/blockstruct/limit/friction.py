"""Define the true and the fictitious sliding conditions: (5) and (17) of docs/theory.md."""

from dataclasses import dataclass

import numpy as np

from blockstruct.arrays import ROUNDING, Array
from blockstruct.limit.problem import LimitProblem

#: Cohesion, in units of contact force, that keeps the program of frozen friction feasible.
CAP = ROUNDING
#: Friction coefficient up to which the fictitious iteration starts from the associative program. Above this value,
#: dilatancy wedges blocks with forces far above their weights. Measured load factors on a wall with friction 2.5: 1.505
#: from the associative program, 0.579 with this limit, 0.579 along the loading path.
STEEPEST = 0.65


@dataclass(frozen=True, slots=True)
class Sliding:
    """Condition ``‖(s_k, t_k)‖ ≤ bound_k + slope_k n_k``, non-dimensional.

    ``bound`` and ``slope`` (K,) apply to the contact points.
    """

    bound: Array
    slope: Array


def true_sliding(problem: LimitProblem) -> Sliding:
    """Return Coulomb's condition."""
    return Sliding(problem.cohesion, problem.friction)


def limited_sliding(problem: LimitProblem) -> Sliding:
    """Return Coulomb's condition with limited friction.

    The friction coefficient is at most 0.65 or tan ψ, whichever is larger.
    """
    return Sliding(problem.cohesion, np.minimum(problem.friction, np.maximum(problem.dilatancy, STEEPEST)))


def fictitious_sliding(problem: LimitProblem, n0: Array, c0: float, a: float) -> Sliding:
    """Return the fictitious condition of slope tan ψ − a (μ − tan ψ).

    At the normal forces ``n0`` (K,) it exceeds Coulomb's condition by ``c0``. For ψ = 0 the limit is
    ``c0 + (1 + a) μ n0 − a μ n``. For ψ = φ it is Coulomb's condition plus ``c0``.
    """
    slope = problem.dilatancy - a * (problem.friction - problem.dilatancy)
    return Sliding(problem.cohesion + c0 + (problem.friction - slope) * n0, slope)


def frozen_sliding(problem: LimitProblem, n0: Array) -> Sliding:
    """Return the condition with friction at fixed normal forces n0 (K,).

    Only the part of the resistance due to dilatancy depends on n.
    """
    return fictitious_sliding(problem, n0, CAP, 0.0)


def shift_of(problem: LimitProblem, v: Array, n: Array) -> Array:
    """Return the shift ``(μ − tan ψ) ‖v_t,k‖`` (K,) at velocities v (K, 3).

    Source: De Saxcé & Feng (1998). In interfaces with torsion of uniform pressure the sliding rate depends on the
    normal forces n (K,).
    """
    return np.asarray((problem.friction - problem.dilatancy) * problem.slip(v, n))


def relax(n0: Array, n: Array, beta: float) -> Array:
    """Return ``β n + (1 − β) n0``."""
    return beta * n + (1 - beta) * n0
