"""Correct given forces to equilibrium inside the cones of friction."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array
from blockstruct.solvers.anderson import REGULARISATION
from blockstruct.solvers.interior_point.cones import ConeVector
from blockstruct.solvers.interior_point.contact_step import FRACTION

#: Least friction of a contact point, which keeps its cone from being a line; share of friction at the start.
LEAST_FRICTION, INSIDE = ROUNDING, 1 - NEGLIGIBLE
#: Most corrections, and most iterations that solve for one. Measured: forces that are found need at most 18.
CORRECTIONS = 20


def carried_forces(
    A: sp.csc_array, friction: Array, before: Array, wanted: Array, *, load: Array | None = None, alpha: float = 0.0
) -> Array | None:
    """Find forces near given ones, in equilibrium and within friction.

    Parameters
    ----------
    A : (6 F, 3 K) sparse array
        Equilibrium matrix.
    friction : (K,) array
        Friction coefficients.
    before : (K, 3) array
        Forces to begin with.
    wanted : (6 F,) array
        Required ``A x``, or ``A x + α w_L`` with a load.
    load, alpha
        Load ``w_L`` with a free load factor, and the load factor to begin with. None without a load.

    Returns
    -------
    (K, 3) array or None
        None if the corrections do not find such forces. They may exist all the same.
    """
    carries = before[:, 0] > NEGLIGIBLE
    mu = np.maximum(friction[carries], LEAST_FRICTION)
    x = within(before[carries], mu, INSIDE)
    aim = None if load is None else Aim(load, alpha, free=abs(alpha), cost=np.zeros_like(x), enough=0.0)
    corrected = corrected_forces(A[:, np.repeat(carries, 3)], mu, x, wanted, aim=aim)
    if corrected is None:
        return None
    found = np.zeros_like(before)
    found[carries] = corrected[0]
    return found


def within(x: Array, mu: Array, share: float) -> Array:
    """Limit the friction of forces (K, 3) to a share of ``μ n``."""
    inside, size = x.copy(), np.linalg.norm(x[:, 1:], axis=1)
    inside[:, 1:] *= np.minimum(share * mu * x[:, 0] / np.maximum(size, 1e-300), 1.0)[:, None]
    return inside


@dataclass(frozen=True, slots=True)
class Aim:
    """Load and cost of the forces sought for a mechanism.

    The load factor is unknown, and a linear cost of the forces must become small.

    Attributes
    ----------
    load : (6 F,) array
        ``w_L``.
    alpha, free : float
        Load factor to begin with, and the change of the load factor that counts as much as doubling one force.
    cost : (K, 3) array
        Cost of forces at the contact points. Forces inside the cones have no negative cost.
    enough : float
        Cost that is small enough. Below it, corrections continue only while each halves the cost.
    """

    load: Array
    alpha: float
    free: float
    cost: Array
    enough: float


def corrected_forces(
    A: sp.csc_array, mu: Array, x: Array, wanted: Array, *, aim: Aim | None = None
) -> tuple[Array, float, int] | None:
    """Find forces and load factor with ``A x + α w_L = wanted``.

    Forces stay inside the cones of friction. Each correction is the smallest in the metric of the cones' barrier at the
    current forces, so that small forces change little. Once forces are in equilibrium, corrections reduce the cost by
    steepest descent in that metric (I. I. Dikin, 1967).

    Parameters
    ----------
    A : (6 F, 3 K) sparse array
        Equilibrium matrix.
    mu : (K,) array
        Friction coefficients above zero.
    x : (K, 3) array
        Forces to begin with, inside the cones.
    wanted : (6 F,) array
        Required sum.
    aim
        Load and cost, if the forces belong to a mechanism.

    Returns
    -------
    (K, 3) array, float, int or None
        Forces, load factor and number of factorisations. None if the forces do not reach equilibrium.
    """
    B = sp.csr_array(A)
    BT = sp.csr_array(B.T)
    nothing = np.zeros(len(wanted))
    load, alpha = (nothing, 0.0) if aim is None else (aim.free * aim.load, aim.alpha)
    columns = (3 * np.arange(len(x))[:, None, None] + np.arange(3)).repeat(3, axis=1).ravel()
    starts = np.arange(0, 3 * x.size + 1, 3)
    share = 1.0
    residual = cost = np.inf
    for count in range(CORRECTIONS + 1):
        missed = wanted - B @ x.ravel() - (0.0 if aim is None else alpha * aim.load)
        last, residual = residual, float(np.abs(missed).max(initial=0.0))
        # Full corrections reduce the residual to rounding, by a few digits each.
        balanced = residual < ROUNDING or (share == 1.0 and residual > last / 10)
        if balanced and aim is not None:
            higher, cost = cost, float((aim.cost * x).sum())
        done = balanced and (aim is None or not aim.cost.any() or higher / 2 < cost <= aim.enough)
        if not len(x) or count == CORRECTIONS or done:
            break
        metric = sp.csr_array((_metric(x, mu).ravel(), columns, starts), shape=(x.size, x.size))
        down = np.asarray(metric @ aim.cost.ravel()) if balanced and aim is not None else np.zeros(x.size)
        push = _pushed(sp.csr_array(B @ metric @ BT), load, np.asarray(B @ down) if balanced else missed)
        change = (metric @ (BT @ push) - down).reshape(-1, 3)
        reach = FRACTION * _cones(x, mu).longest_step(_cones(change, mu))
        share = reach if balanced else min(1.0, reach)
        if share == np.inf:
            # No direction lowers the cost.
            break
        x = x + share * change
        if aim is not None:
            alpha += share * aim.free * float(load @ push)
    return (x, alpha, count) if residual <= NEGLIGIBLE else None


def _pushed(stiffness: sp.csr_array, load: Array, missed: Array) -> Array:
    """Solve ``(M + w wᵀ) p = missed``.

    Without a load, motions that M does not resist remain undetermined.
    """
    n = len(missed)
    M = sp.csc_array(stiffness + REGULARISATION * stiffness.diagonal().max() * sp.eye_array(n, format="csr"))
    lu = sp.linalg.splu(M, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options={"SymmetricMode": True})
    if not load.any():
        push = lu.solve(missed)
        return np.asarray(push + lu.solve(missed - M @ push))
    # Only the load resists a mechanism. Conjugate gradients remove the effect of the addition to the diagonal.
    push, _ = sp.linalg.cg(
        sp.linalg.LinearOperator((n, n), matvec=lambda p: stiffness @ p + load * (load @ p), dtype=float),
        missed,
        rtol=ROUNDING,
        maxiter=CORRECTIONS,
        M=sp.linalg.LinearOperator((n, n), matvec=lu.solve, dtype=float),
    )
    return np.asarray(push)


def _metric(x: Array, mu: Array) -> Array:
    """Return the inverse Hessians (K, 3, 3) of the cones' barrier.

    The barrier is ``−log((μ n)² − s² − t²)``.
    """
    y = _cones(x, mu).soc
    determinant = y[:, 0] ** 2 - y[:, 1] ** 2 - y[:, 2] ** 2
    metric = y[:, :, None] * y[:, None, :] - determinant[:, None, None] / 2 * np.diag([1.0, -1.0, -1.0])
    metric[:, 0] /= mu[:, None]
    metric[:, :, 0] /= mu[:, None]
    return np.asarray(metric)


def _cones(x: Array, mu: Array) -> ConeVector:
    """Return ``(μ n, s, t)`` of forces."""
    return ConeVector(np.column_stack([mu * x[:, 0], x[:, 1:]]), np.empty(0))
