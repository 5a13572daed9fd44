"""Forces in equilibrium inside the cones of friction, near forces that are not."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.solvers.interior_point.cones import ConeVector

Array = NDArray[np.float64]

#: Normal force below which a contact point carries nothing that could be corrected.
NO_FORCE = 1e-7
#: Residual of equilibrium that is good enough, and one that is rounding; and corrections.
BALANCED, EXACT, CORRECTIONS = 1e-6, 1e-8, 8
#: Least friction of a contact point, which keeps its cone from being a line; share of it that forces begin within.
LEAST_FRICTION, INSIDE = 1e-9, 1 - 1e-6
#: Short corrections running that are the last. Measured on 1,596 blocks: after three of them the fourth went on.
STUCK = 5
#: Share of the way to the boundary of the cones.
SHORT = 0.9
#: Relative addition to the diagonal of what is factorised: nothing holds the rigid motions of bodies, nor a mechanism.
REGULARISATION = 1e-10
#: Relative residual of conjugate gradients, and their most iterations.
REFINED, REFINEMENTS = 1e-10, 30


def carried_forces(A: sp.csc_array, friction: Array, before: Array, wanted: Array) -> Array | None:
    """Forces in equilibrium inside the cones of friction, near those before.

    Parameters
    ----------
    A : (6 F, 3 K) sparse array
    friction : (K,) array
    before : (K, 3) array
        Forces to begin with.
    wanted : (6 F,) array
        ``A x``.

    Returns
    -------
    (K, 3) array or None
        None if they are not found, which does not say that there are none.
    """
    carries = before[:, 0] > NO_FORCE
    mu = np.maximum(friction[carries], LEAST_FRICTION)
    corrected = corrected_forces(
        A[:, np.repeat(carries, 3)], mu, within(before[carries], mu, INSIDE), wanted, corrections=CORRECTIONS
    )
    if corrected is None:
        return None
    found = np.zeros_like(before)
    found[carries] = corrected[0]
    return found


def within(x: Array, mu: Array, share: float) -> Array:
    """Forces (K, 3) with friction of at most a share of ``μ n``."""
    inside, size = x.copy(), np.linalg.norm(x[:, 1:], axis=1)
    inside[:, 1:] *= np.minimum(share * mu * x[:, 0] / np.maximum(size, 1e-300), 1.0)[:, None]
    return inside


@dataclass(frozen=True, slots=True)
class Aim:
    """What forces are for: those of a mechanism under a load that is to be found, with little of a linear cost.

    Attributes
    ----------
    load : (6 F,) array
        ``w_L``.
    alpha, free : float
        Load factor to begin with, and the change of it that is as large as doubling one force.
    cost : (K, 3) array
        Of forces at the contact points; none inside the cones lowers it below zero.
    enough : float
        Cost that is little. Corrections go on below it for as long as each takes off half of what is left.
    nowhere : float
        Corrections that go no further than this share of their way, several running, are the last.
    """

    load: Array
    alpha: float
    free: float
    cost: Array
    enough: float
    nowhere: float


def corrected_forces(
    A: sp.csc_array, mu: Array, x: Array, wanted: Array, *, corrections: int, aim: Aim | None = None
) -> tuple[Array, float, int] | None:
    """Forces and load factor with ``A x + α w_L = wanted`` inside the cones of friction.

    Each correction is the least in the metric of the cones' barrier at the forces as they are, so that what is small
    changes little; in equilibrium, the next ones go down with the cost, the steepest way in that metric (I. I. Dikin,
    1967).

    Parameters
    ----------
    A : (6 F, 3 K) sparse array
    mu : (K,) array
        Friction coefficients above zero.
    x : (K, 3) array
        Forces to begin with, inside the cones.
    wanted : (6 F,) array
    corrections
        Most of them.
    aim
        Of the forces, if they are those of a mechanism.

    Returns
    -------
    (K, 3) array, float, int or None
        Forces, load factor and factorisations; None if none are found in equilibrium.
    """
    B = sp.csr_array(A)
    BT = sp.csr_array(B.T)
    nothing = np.zeros(len(wanted))
    load, alpha = (nothing, 0.0) if aim is None else (aim.free * aim.load, aim.alpha)
    place = 3 * np.arange(len(x))[:, None, None]
    rows, columns = np.broadcast_arrays(place + np.arange(3)[:, None], place + np.arange(3))
    share, short = 1.0, 0
    residual = cost = np.inf
    for count in range(corrections + 1):
        missed = wanted - B @ x.ravel() - (0.0 if aim is None else alpha * aim.load)
        last, residual = residual, float(np.abs(missed).max(initial=0.0))
        # Whole corrections come down to rounding, a few digits each.
        balanced = residual < EXACT or (share == 1.0 and residual > last / 10)
        if balanced and aim is not None:
            higher, cost = cost, float((aim.cost * x).sum())
        if not len(x) or count == corrections or (balanced and (aim is None or higher / 2 < cost <= aim.enough)):
            break
        short = short + 1 if aim is not None and share < aim.nowhere else 0
        if short == STUCK:
            break
        metric = sp.csr_array((_metric(x, mu).ravel(), (rows.ravel(), columns.ravel())))
        down = np.asarray(metric @ aim.cost.ravel()) if balanced and aim is not None else np.zeros(x.size)
        push = _pushed(sp.csr_array(B @ metric @ BT), load, np.asarray(B @ down) if balanced else missed)
        change = (metric @ (BT @ push) - down).reshape(-1, 3)
        reach = SHORT * _cones(x, mu).longest_step(_cones(change, mu))
        share = reach if balanced else min(1.0, reach)
        if share == np.inf:
            # Nothing lowers the cost.
            break
        x = x + share * change
        if aim is not None:
            alpha += share * aim.free * float(load @ push)
    return (x, alpha, count) if residual <= BALANCED else None


def _pushed(stiffness: sp.csr_array, load: Array, missed: Array) -> Array:
    """Solution of ``(M + w wᵀ) p = missed``, up to motions that M does not resist if there is no load."""
    n = len(missed)
    M = sp.csc_array(stiffness + REGULARISATION * stiffness.diagonal().max() * sp.eye_array(n))
    lu = sp.linalg.splu(M, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options={"SymmetricMode": True})
    if not load.any():
        push = lu.solve(missed)
        return np.asarray(push + lu.solve(missed - M @ push))
    # Nothing but the load resists a mechanism: conjugate gradients take the addition to the diagonal off again.
    push, _ = sp.linalg.cg(
        sp.linalg.LinearOperator((n, n), matvec=lambda p: stiffness @ p + load * (load @ p)),
        missed,
        rtol=REFINED,
        maxiter=REFINEMENTS,
        M=sp.linalg.LinearOperator((n, n), matvec=lu.solve),
    )
    return np.asarray(push)


def _metric(x: Array, mu: Array) -> Array:
    """Inverse Hessians (K, 3, 3) of the barrier ``−log((μ n)² − s² − t²)``, by twice."""
    y = _cones(x, mu).soc
    determinant = y[:, 0] ** 2 - y[:, 1] ** 2 - y[:, 2] ** 2
    metric = y[:, :, None] * y[:, None, :] - determinant[:, None, None] / 2 * np.diag([1.0, -1.0, -1.0])
    metric[:, 0] /= mu[:, None]
    metric[:, :, 0] /= mu[:, None]
    return np.asarray(metric)


def _cones(x: Array, mu: Array) -> ConeVector:
    """``(μ n, s, t)`` of forces."""
    return ConeVector(np.column_stack([mu * x[:, 0], x[:, 1:]]), np.empty(0))
