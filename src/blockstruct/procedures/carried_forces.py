"""Forces inside bodies: those of a state before, corrected for loads that have turned with them."""

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
#: Share of the way to the boundary of the cones.
SHORT = 0.9
#: Relative addition to the diagonal: nothing holds the rigid motions of bodies.
REGULARISATION = 1e-10


def carried_forces(A: sp.csc_array, friction: Array, before: Array, wanted: Array) -> Array | None:
    """Forces in equilibrium inside the cones of friction, near those before.

    Each correction is the least in the metric of the cones' barrier at the forces as they are, so that what is small
    changes little (I. I. Dikin, 1967).

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
    B = sp.csr_array(A[:, np.repeat(carries, 3)])
    BT, x, mu = sp.csr_array(B.T), before[carries], np.maximum(friction[carries], LEAST_FRICTION)
    size = np.linalg.norm(x[:, 1:], axis=1)
    x[:, 1:] *= np.minimum(INSIDE * mu * x[:, 0] / np.maximum(size, 1e-300), 1.0)[:, None]
    place = 3 * np.arange(len(x))[:, None, None]
    rows, columns = np.broadcast_arrays(place + np.arange(3)[:, None], place + np.arange(3))
    share, residual = 0.0, np.inf
    for _ in range(CORRECTIONS + 1):
        missed = wanted - B @ x.ravel()
        last, residual = residual, float(np.abs(missed).max())
        # Whole corrections come down to rounding, a few digits each.
        if not len(x) or residual < EXACT or (share == 1.0 and residual > last / 10):
            break
        metric = sp.csr_array((_metric(x, mu).ravel(), (rows.ravel(), columns.ravel())))
        stiff = sp.csr_array(B @ metric @ BT)
        M = sp.csc_array(stiff + REGULARISATION * stiff.diagonal().max() * sp.eye_array(stiff.shape[0]))
        lu = sp.linalg.splu(M, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options={"SymmetricMode": True})
        push = lu.solve(missed)
        push += lu.solve(missed - M @ push)
        change = (metric @ (BT @ push)).reshape(-1, 3)
        share = min(1.0, SHORT * _cones(x, mu).longest_step(_cones(change, mu)))
        x = x + share * change
    if not residual <= BALANCED:
        return None
    found = np.zeros_like(before)
    found[carries] = x
    return found


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
