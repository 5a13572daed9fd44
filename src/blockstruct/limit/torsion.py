"""Torsion of uniformly pressed interfaces: one more cone for each, and what slips in it.

Contact points at the corners of an interface resist torsion by up to 1.85 times what a uniformly pressed square does.
With the shear forces ``V_s, V_t`` and the torque T about the centroid, the cone
``‖(V_s, V_t, T / r̄)‖ ≤ Σ (c A_k + μ n_k)`` gives a joint under a central resultant exactly the torsion of uniform
pressure: r̄ is the mean distance of its area from the centroid. Shear and torque together it lets be larger, by up to
15.5 % in narrow joints (:mod:`blockstruct.statics.uniform_friction`). The whole area counts, also where a part of it
opens: r̄ is then above the lever of the pressed part, and a shear force beside the centroid counts as torsion.

Sliding is that of the contact points and that of the cone together. The rate of the two is found from the velocities:
of all ways to divide them the one that dissipates least. Where joints dilate, a certificate asks for more than that:
:mod:`blockstruct.limit.division`.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.statics import ContactPoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Steps of the division of velocities, and the rate that is none, relative to the largest of its interface.
STEPS, NONE = 60, 1e-9


@dataclass(frozen=True, slots=True)
class UniformTorsion:
    """The interfaces whose torsion is that of uniform pressure.

    Attributes
    ----------
    interface : (I,) array
        Their indices.
    point : (P,) array
        Indices of their contact points.
    owner : (P,) array
        Which of the I interfaces each belongs to, ascending.
    place : (P, 2) array
        Position of each along s and t from the centroid, in multiples of r̄.
    """

    interface: Index
    point: Index
    owner: Index
    place: Array

    @classmethod
    def of(cls, points: ContactPoints) -> Self:
        """Of the contact points of a model."""
        point = np.flatnonzero(np.isfinite(points.torsion_lever)[points.interface])
        of_point = points.interface[point]
        arm = points.position[point] - points.centroid[of_point]
        place = np.einsum("pca,pa->pc", points.frame[of_point, 1:], arm) / points.torsion_lever[of_point, None]
        interface, owner = np.unique(of_point, return_inverse=True)
        return cls(interface, point, owner, place)

    def __len__(self) -> int:
        return len(self.interface)

    def part(self, chosen: NDArray[np.bool_]) -> Self:
        """Those of the I interfaces that are chosen, (I,)."""
        mine = chosen[self.owner]
        owner = (np.cumsum(chosen) - 1)[self.owner[mine]]
        return type(self)(self.interface[chosen], self.point[mine], owner, self.place[mine])

    def summed(self, values: Array) -> Array:
        """Sum over each interface, (I,), of values at its own points, (P,)."""
        return np.asarray(np.bincount(self.owner, values, len(self)), dtype=float)

    def total(self, values: Array) -> Array:
        """Sum over each interface, (I,), of values at all K contact points."""
        return self.summed(values[self.point])

    def shear(self, x: Array) -> Array:
        """``(V_s, V_t, T / r̄)`` of contact forces x (K, 3), (I, 3)."""
        s, t = x[self.point, 1:].T
        parts = (s, t, self.place[:, 0] * t - self.place[:, 1] * s)
        return np.column_stack([self.summed(part) for part in parts])

    def excess(self, x: Array, resistance: Array) -> Array:
        """Force by which each interface misses its cone, (I,), for the sliding resistances (K,) of its points."""
        return np.asarray(np.linalg.norm(self.shear(x), axis=1) - self.total(resistance))

    def by_joint(self, values: Array) -> Array:
        """Values at contact points, those of each of these interfaces in one sum."""
        return np.concatenate([np.delete(values, self.point), self.total(values)])

    def slip(self, v: Array, resistance: Array) -> Array:
        """Rate at which each of all contact points slides, by itself and with the cone of its interface, (K,).

        At relative velocities ``v_t,k = J_k w`` of a rigid motion w = (w_s, w_t, r̄ ω) of the cone alone, and of the
        point alone elsewhere, it is ``‖v_t,k − J_k w‖ + ‖w‖`` for the w with the least ``Σ R_k ‖v_t,k − J_k w‖ +
        Σ R_k ‖w‖``: the largest work that forces inside both conditions may do.

        Parameters
        ----------
        v : (K, 3) array
            Relative velocities.
        resistance : (K,) array
            ``R_k = c A_k + μ n_k``, zero or more but for rounding.
        """
        found = np.asarray(np.linalg.norm(v[:, 1:], axis=1))
        # Where the solver found nothing there is nothing to divide.
        if not len(self) or not np.isfinite(found).all():
            return found
        along, R = v[self.point, 1:], np.maximum(resistance[self.point], 0.0)
        fastest = np.zeros(len(self))
        np.maximum.at(fastest, self.owner, found[self.point])
        fastest = np.where(fastest > 0, fastest, 1.0)
        along = along / fastest[self.owner, None]
        # Where nothing resists, any division is as good; the shortest motion is taken.
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
                # From all of the motion, as from none of it, steps of least squares would not come away.
                w = w / 2
            of_points, of_cone = rates(w)
            w = self._fitted(along, R / np.maximum(of_points, NONE), whole / np.maximum(of_cone, NONE))
        of_points, of_cone = rates(best)
        found[self.point] = (of_points + of_cone[self.owner]) * fastest[self.owner]
        return found

    def _fitted(self, along: Array, weight: Array, of_cone: Array) -> Array:
        """Motion w (I, 3) with the least ``Σ weight ‖v_t − J w‖² + of_cone ‖w‖²``."""
        (x, y), (a, b) = self.place.T, along.T

        one, sx, sy, inertia = (self.summed(weight * part) for part in (np.ones_like(x), x, y, x**2 + y**2))
        H = np.zeros((len(self), 3, 3))
        H[:, 0, 0] = H[:, 1, 1] = one + of_cone
        H[:, 2, 2] = inertia + of_cone
        H[:, 0, 2] = H[:, 2, 0] = -sy
        H[:, 1, 2] = H[:, 2, 1] = sx
        right = np.column_stack([self.summed(weight * part) for part in (a, b, x * b - y * a)])
        return np.asarray(np.linalg.solve(H, right[:, :, None])[:, :, 0])
