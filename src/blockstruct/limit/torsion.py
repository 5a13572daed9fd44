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
import scipy.sparse as sp

from blockstruct.arrays import ROUNDING, Array, Flags, Index
from blockstruct.statics.contacts import ContactPoints

#: Share of the gap, and of the way to the strength of each point, that a step of the division leaves.
LEFT = 0.1


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
        return self.resultant(x[self.point, 1:])

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
        fastest, whole = np.zeros(len(self)), self.summed(R)
        np.maximum.at(fastest, self.owner, found[self.point])
        fastest, whole = np.where(fastest > 0, fastest, 1.0), np.where(whole > 0, whole, 1.0)
        along = along / fastest[self.owner, None]
        # Without resistance any division is equally good: take the shortest motion.
        w = self._divided(along, R / whole[self.owner] + ROUNDING)
        rate = np.linalg.norm(along - self.moved(w), axis=1) + np.linalg.norm(w, axis=1)[self.owner]
        found[self.point] = rate * fastest[self.owner]
        return found

    def moved(self, w: Array) -> Array:
        """Return the velocities ``J_k w`` (P, 2) of the points in rigid motions w (I, 3)."""
        x, y = self.place.T
        return np.asarray(w[self.owner, :2] + w[self.owner, 2:] * np.column_stack([-y, x]))

    def resultant(self, shear: Array) -> Array:
        """Return the resultants ``Σ J_kᵀ s_k`` (I, 3) of shear forces (P, 2) at the points."""
        (x, y), (s, t) = self.place.T, shear.T
        return np.column_stack([self.summed(part) for part in (s, t, x * t - y * s)])

    def _divided(self, along: Array, R: Array) -> Array:
        """Return the motions w (I, 3) of least work at velocities (P, 2) up to one.

        The work ``Σ R_k ‖v_k − J_k w‖ + Σ R_k ‖w‖`` is a sum of norms ``R_k ‖e_k‖``. The cone is one more norm, with
        ``v = 0, J = −1``. Forces with ``‖s_k‖ ≤ R_k`` and ``Σ J_kᵀ s_k = 0`` do at most this work at v. Their largest
        work is the least work of w. Newton's method follows the path ``t_k s_k = R_k e_k`` with
        ``t_k² = e_k² + μ t_k / R_k`` to ``μ = 0``: K. D. Andersen, E. Christiansen, A. R. Conn, M. L. Overton (2000),
        doi:10.1137/S1064827598343954. On the path the two works differ by μ per norm. The loop ends when they differ by
        rounding.

        Parameters
        ----------
        along : (P, 2) array
            Velocities of the points, none longer than one.
        R : (P,) array
            Resistances above zero, with a sum near one in each interface.
        """
        n, (x, y), eps = len(along), self.place.T, np.finfo(float).eps
        owner = np.concatenate([self.owner, np.arange(len(self))])
        J, e, R = np.zeros((len(owner), 3, 3)), np.zeros((len(owner), 3)), np.concatenate([R, self.summed(R)])
        J[:, 0, 0] = J[:, 1, 1] = 1.0
        J[:n, 0, 2], J[:n, 1, 2] = -y, x
        J[n:] = -np.eye(3)
        e[:n, :2] = along
        JJ = (J.transpose(0, 2, 1) @ J).reshape(-1, 9)
        sums = sp.csr_array((np.ones(len(owner)), (owner, np.arange(len(owner)))))

        def summed(a: Array) -> Array:
            return np.asarray(sums @ a)

        def dot(a: Array, b: Array) -> Array:
            return np.asarray(np.einsum("ka,ka->k", a, b))

        def at_centroid(a: Array) -> Array:
            return np.asarray(np.einsum("kab,ka->kb", J, a))

        v, s, w = e, np.zeros_like(e), np.zeros((len(self), 3))
        of_e, of_s, best = at_centroid(e), s, w
        least, most, norms = summed(R * np.sqrt(dot(e, e))), np.zeros(len(self)), np.bincount(owner)
        mu = np.maximum(least, ROUNDING) / norms
        while True:
            half = mu[owner] / (2 * R)
            root = np.sqrt(half**2 + dot(e, e))
            t = root + half
            stiff, bent = (R / t)[:, None], 1 / (root * t)[:, None]
            outer = np.einsum("ka,kb->kab", of_s, bent * of_e).reshape(-1, 9)
            H = summed(stiff * JJ - outer).reshape(-1, 3, 3)
            H = (H + H.transpose(0, 2, 1)) / 2
            # Where the work grows evenly in a direction, H has no more than rounding there.
            H += (eps * np.trace(H, axis1=1, axis2=2))[:, None, None] * np.eye(3)
            dw = np.linalg.solve(H, summed(stiff * of_e)[:, :, None])[:, :, 0]
            de = -np.einsum("kab,kb->ka", J, dw[owner])
            ds = stiff * (e + de) - s - bent * (dot(e, de)[:, None] * s + dot(s, de)[:, None] * e) / 2
            # Each s_k stays inside its sphere.
            a, b, c = dot(ds, ds), dot(s, ds), np.maximum(R**2 - dot(s, s), eps * R**2)
            to_sphere = c / np.maximum(b + np.sqrt(b**2 + a * c), np.finfo(float).tiny)
            share = np.ones(len(self))
            np.minimum.at(share, owner, (1 - LEFT) * to_sphere)
            w, e, s = w + dw, e + de, s + share[owner, None] * ds
            of_e, of_s = at_centroid(e), at_centroid(s)
            work = summed(R * np.sqrt(dot(e, e)))
            # w is at most as large as the work over Σ R_k.
            bound = summed(dot(s, v)) / (1 + np.linalg.norm(summed(of_s), axis=1) / R[n:])
            best = np.where((work < least)[:, None], w, best)
            least, most = np.minimum(work, least), np.maximum(bound, most)
            # μ falls in every step, so that there is a last one.
            left = (least - most > ROUNDING * least) & (mu > eps * ROUNDING)
            if not left.any():
                return best
            mu = np.where(left, np.minimum((1 - LEFT) * mu, LEFT * (work - bound) / norms), mu)
