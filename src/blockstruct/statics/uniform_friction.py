"""Compute the exact shear and torque resisted by uniform friction.

The friction per area is uniform over a joint. An area that turns about a point c slides perpendicular to the arm from
c. The work of its friction is proportional to its mean distance from c. A joint resists a shear and torque if their
power does not exceed the work of friction in any motion ``w = (w_s, w_t, r̄ ω)``.

Let r̄ be the mean distance from the centroid. The ellipsoid ``‖(V_s, V_t, T / r̄)‖ ≤ R`` is exact for shear alone and
for torque alone. For both together it is too large: by up to 7.1 % on a square, and by up to 15.5 % for shear across a
narrow joint. A narrow joint may turn about a point at the share v of half its length from its middle. It then resists
the shear v and the torque ``1 − v²``, and the ellipse is ``1 / √(1 − v² + v⁴)`` times as large. For shear along a
narrow joint the ellipsoid is too small, by up to 4.5 %.
"""

from collections.abc import Sequence

import numpy as np

from blockstruct.arrays import NEGLIGIBLE, Array
from blockstruct.geometry.polygon import mean_distances, plane_axes
from blockstruct.model import Interface


def torsion_levers(interfaces: Sequence[Interface]) -> Array:
    """Return :attr:`Interface.torsion_lever` of all interfaces (J,), m, computed together."""
    return _Areas(interfaces).lever


def multiple_of_uniform_friction(interfaces: Sequence[Interface], forces: Array) -> Array:
    """Return the shear and torque relative to the resisted ones, (J,).

    The resisted shear and torque have the same proportions as the forces. If the sum of the shear and torque shares
    is at most one, or if there is no torque, the sum is returned. Otherwise it follows from the least work of friction
    over all motions in which the forces have unit power.

    Parameters
    ----------
    interfaces
        The J interfaces.
    forces : (J, 3) array
        ``(V_s, V_t, T / r̄)`` about the centroid, in multiples of the total friction of each interface.
    """
    size = np.linalg.norm(forces, axis=1)
    at_most: Array = np.linalg.norm(forces[:, :2], axis=1) + np.abs(forces[:, 2])
    twisted = (at_most > 1.0) & (np.abs(forces[:, 2]) > NEGLIGIBLE * size)
    if not twisted.any():
        return at_most
    areas = _Areas([i for i, one in zip(interfaces, twisted.tolist(), strict=True) if one])
    toward = forces[twisted] / size[twisted, None]
    # Two directions perpendicular to each force: a motion along them has no power.
    across = np.linalg.svd(toward[:, None])[2][:, 1:]
    # Steps of central differences that rounding and curvature leave most exact.
    steps = np.cbrt(np.finfo(float).eps) * np.eye(2)

    def work(z: Array) -> Array:
        return areas.work(toward + np.einsum("ja,jac->jc", z, across))

    def total(flat: Array) -> tuple[float, Array]:
        z = flat.reshape(-1, 2)
        slope = np.column_stack([(work(z + step) - work(z - step)) / (2 * step.sum()) for step in steps])
        return float(work(z).sum()), slope.ravel()

    # Loaded here: it is slow to import.
    from scipy.optimize import minimize

    # Each joint has its own motion, so the least sum of all works is the least work of each.
    found = minimize(total, np.zeros(2 * len(toward)), jac=True, method="L-BFGS-B", options={"ftol": 0.0})
    least = work(found.x.reshape(-1, 2))
    at_most[twisted] = size[twisted] / least
    return at_most


class _Areas:
    """Outlines of interfaces in the axes of each, from its centroid."""

    def __init__(self, interfaces: Sequence[Interface]) -> None:
        self._corners = np.concatenate([i.polygon for i in interfaces])
        self._starts = np.cumsum([0, *(len(i.polygon) for i in interfaces[:-1])])
        self._centroid, self._normal = (np.array([getattr(i, of) for i in interfaces]) for of in ("centroid", "normal"))
        self._axes = np.stack(plane_axes(self._normal), axis=1)
        #: Mean distance of each area from its centroid, m.
        self.lever = mean_distances(self._corners, self._starts, self._centroid, self._normal)

    def work(self, motion: Array) -> Array:
        """Return the mean sliding rate (J,) of each area.

        Motions (J, 3) are ``(w_s, w_t, r̄ ω)``.
        """
        shift, turn = np.linalg.norm(motion[:, :2], axis=1), motion[:, 2] / self.lever
        turns = np.abs(motion[:, 2]) > NEGLIGIBLE * shift
        around = np.column_stack([-motion[:, 1], motion[:, 0]]) / np.where(turns, turn, 1.0)[:, None]
        centre = self._centroid + np.einsum("ja,jac->jc", np.where(turns[:, None], around, 0.0), self._axes)
        away = mean_distances(self._corners, self._starts, centre, self._normal)
        return np.asarray(np.where(turns, np.abs(turn) * away, shift))
