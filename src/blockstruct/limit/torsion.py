"""Limit the torsion of interfaces as under uniform pressure.

Contact points at the corners of an interface resist up to 1.85 times the torsion of a uniformly pressed square. One
more cone per interface corrects this, (11) of docs/theory.md: ``‖(V_s, V_t, T / r̄)‖ ≤ Σ (c A_k + μ n_k)``. ``V_s, V_t``
are the shear forces and T is the torque about the centroid. r̄ is the mean distance of the area from the centroid.
Under a central resultant the cone gives exactly the torsion of uniform pressure. It overestimates shear and torque
together by up to 15.5 % in narrow joints (:mod:`blockstruct.statics.uniform_friction`). The cone uses the whole area
even if a part opens: r̄ is then larger than the lever of the pressed part, and an eccentric shear force counts as
torsion.

Sliding is the sum of the sliding of the contact points and the sliding of the cone. Both rates follow from the
velocities: the division with the least dissipation is taken. Certificates of dilating joints need more than this least
dissipation: see :mod:`blockstruct.limit.division`.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from blockstruct.arrays import ROUNDING, Array, Flags, Index
from blockstruct.statics import ContactPoints

#: Number of steps that divide velocities.
STEPS = 60


@dataclass(frozen=True, slots=True)
class UniformTorsion:
    """Interfaces with the torsion of uniform pressure.

    Attributes
    ----------
    interface : (I,) array
        Indices of the interfaces.
    point : (P,) array
        Indices of their contact points.
    owner : (P,) array
        Number, among the I interfaces, of the interface of each point; ascending.
    place : (P, 2) array
        Position of each point along s and t from the centroid, in multiples of r̄.
    """

    interface: Index
    point: Index
    owner: Index
    place: Array

    @classmethod
    def of(cls, points: ContactPoints) -> Self:
        """Return the interfaces of uniform torsion among contact points."""
        point = np.flatnonzero(np.isfinite(points.torsion_lever)[points.interface])
        of_point = points.interface[point]
        arm = points.position[point] - points.centroid[of_point]
        place = np.einsum("pca,pa->pc", points.frame[of_point, 1:], arm) / points.torsion_lever[of_point, None]
        interface, owner = np.unique(of_point, return_inverse=True)
        return cls(interface, point, owner, place)

    def __len__(self) -> int:
        return len(self.interface)

    def part(self, chosen: Flags) -> Self:
        """Return the chosen interfaces (I,)."""
        mine = chosen[self.owner]
        owner = (np.cumsum(chosen) - 1)[self.owner[mine]]
        return type(self)(self.interface[chosen], self.point[mine], owner, self.place[mine])

    def summed(self, values: Array) -> Array:
        """Return the sum (I,) over each interface of values (P,) at its points."""
        return np.asarray(np.bincount(self.owner, values, len(self)), dtype=float)

    def total(self, values: Array) -> Array:
        """Return the sum (I,) over each interface of values (K,)."""
        return self.summed(values[self.point])

    def shear(self, x: Array) -> Array:
        """Return ``(V_s, V_t, T / r̄)`` (I, 3) of contact forces x (K, 3)."""
        s, t = x[self.point, 1:].T
        parts = (s, t, self.place[:, 0] * t - self.place[:, 1] * s)
        return np.column_stack([self.summed(part) for part in parts])

    def excess(self, x: Array, resistance: Array) -> Array:
        """Return the force (I,) by which each interface exceeds its cone.

        ``resistance`` (K,) are the sliding resistances of all contact points.
        """
        return np.asarray(np.linalg.norm(self.shear(x), axis=1) - self.total(resistance))

    def by_joint(self, values: Array) -> Array:
        """Return values at contact points, summed in each of these interfaces.

        The values at all other points come first, followed by the sums (I,).
        """
        return np.concatenate([np.delete(values, self.point), self.total(values)])

    def slip(self, v: Array, resistance: Array) -> Array:
        """Return the sliding rate of each contact point, (K,).

        In these interfaces the rate is ``‖v_t,k − J_k w‖ + ‖w‖``. The rigid motion w = (w_s, w_t, r̄ ω) is the sliding
        of the cone, with the velocities ``J_k w`` at the points. The rest is the sliding of the points. w minimises
        ``Σ R_k ‖v_t,k − J_k w‖ + Σ R_k ‖w‖``. This minimum is the largest work of forces that satisfy both conditions.
        Elsewhere the rate is ``‖v_t‖``.

        Parameters
        ----------
        v : (K, 3) array
            Relative velocities.
        resistance : (K,) array
            ``R_k = c A_k + μ n_k``, not negative apart from rounding.
        """
        found = np.asarray(np.linalg.norm(v[:, 1:], axis=1))
        # There is nothing to divide if the solver found no solution.
        if not len(self) or not np.isfinite(found).all():
            return found
        along, R = v[self.point, 1:], np.maximum(resistance[self.point], 0.0)
        fastest = np.zeros(len(self))
        np.maximum.at(fastest, self.owner, found[self.point])
        fastest = np.where(fastest > 0, fastest, 1.0)
        along = along / fastest[self.owner, None]
        # Without resistance any division is equally good: take the shortest motion.
        R = R + 1e-9 * np.maximum(self.summed(R), 1e-3)[self.owner]
        whole = self.summed(R)

        def rates(w: Array) -> tuple[Array, Array]:
            x, y = self.place.T
            with_cone = w[self.owner, :2] + w[self.owner, 2:] * np.column_stack([-y, x])
            return np.linalg.norm(along - with_cone, axis=1), np.linalg.norm(w, axis=1)

        def work(w: Array) -> Array:
            of_points, of_cone = rates(w)
            return np.asarray(self.summed(R * of_points) + whole * of_cone)

        best = np.zeros((len(self), 3))
        least = work(best)
        w = self._fitted(along, np.ones_like(R), np.zeros(len(self)))
        for step in range(STEPS):
            now = work(w)
            better = now < least
            best[better], least[better] = w[better], now[better]
            if step == 0:
                # Reweighted least squares cannot leave a start in which w takes all or none of the motion.
                w = w / 2
            of_points, of_cone = rates(w)
            w = self._fitted(along, R / np.maximum(of_points, ROUNDING), whole / np.maximum(of_cone, ROUNDING))
        of_points, of_cone = rates(best)
        found[self.point] = (of_points + of_cone[self.owner]) * fastest[self.owner]
        return found

    def _fitted(self, along: Array, weight: Array, of_cone: Array) -> Array:
        """Return the motion w (I, 3) of a weighted least-squares fit.

        It minimises ``Σ weight ‖v_t − J w‖² + of_cone ‖w‖²``.
        """
        (x, y), (a, b) = self.place.T, along.T

        one, sx, sy, inertia = (self.summed(weight * part) for part in (np.ones_like(x), x, y, x**2 + y**2))
        H = np.zeros((len(self), 3, 3))
        H[:, 0, 0] = H[:, 1, 1] = one + of_cone
        H[:, 2, 2] = inertia + of_cone
        H[:, 0, 2] = H[:, 2, 0] = -sy
        H[:, 1, 2] = H[:, 2, 1] = sx
        right = np.column_stack([self.summed(weight * part) for part in (a, b, x * b - y * a)])
        return np.asarray(np.linalg.solve(H, right[:, :, None])[:, :, 0])
