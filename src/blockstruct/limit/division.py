"""Divide sliding of dilating joints between contact points and torsion.

The conditions of an interface with torsion of uniform pressure define one domain of its normal and shear forces. The
largest work of admissible forces at the relative velocities of its points is the support function of this domain. By
duality it is ::

    min over w of  Σ c A_k r_k + h(μ r − v_n),   r_k = ‖v_t,k − J_k w‖ + ‖w‖,

with h the support function of the domain of normal forces alone. h is the dissipation of crushing. For rigid points it
is zero if no point penetrates and ∞ otherwise. The motions w are the multipliers of the torsion cone. Velocities are
thus admissible if *some* division r lets no point penetrate. The dissipation of friction does not determine this
division. In a joint without forces every division dissipates nothing. If only a few points are pressed, the sliding of
the other points stays undetermined.

The chosen division is therefore the one with the least violation of the flow rule. This violation is the largest
possible work of friction, normal forces and crushing less their actual work. Penetration of rigid points adds to the
violation. It is a convex, non-smooth function of w with three variables per joint. Ellipsoids enclose its minimum. A
subgradient cuts off the part of the ellipsoid without a smaller value. The next ellipsoid is the smallest around the
remaining part.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from blockstruct.arrays import ROUNDING, Array, Flags, Index
from blockstruct.limit import crushing
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.torsion import UniformTorsion


def sliding(problem: LimitProblem, x: Array, v: Array, *, biaxial: bool) -> Array:
    """Return the sliding rate of each contact point, (K,).

    The rate includes sliding with the torsion cone of the interface. It is ``‖v_t‖`` except in interfaces of uniform
    torsion. In these it is :meth:`UniformTorsion.slip` if the joint does not dilate, or if this rate already satisfies
    the flow rule.

    Parameters
    ----------
    x, v : (K, 3) arrays
        Contact forces, and relative velocities including the initial open gap.
    biaxial
        Whether crushing about the two axes interacts.
    """
    found = problem.slip(v, x[:, 0])
    own = problem.torsion
    dilates = own.total(problem.dilatancy) > 0
    if not dilates.any() or not np.isfinite(x).all() or not np.isfinite(v).all():
        return found
    largest = float((np.linalg.norm(v, axis=1) / problem.force_unit).max())
    flow = _Flow.of(problem, own.part(dilates), x, v, biaxial=biaxial)
    unit = np.empty(len(flow.torsion))
    unit[flow.torsion.owner] = problem.force_unit[flow.torsion.point]
    # Work that counts as zero, next to the resistance of the joint at the largest velocity.
    none = ROUNDING * largest * unit * flow.force
    missed, _ = flow.missed(found[flow.torsion.point])
    chosen = np.flatnonzero(dilates)[missed > none]
    if len(chosen):
        flow = _Flow.of(problem, own.part(np.isin(np.arange(len(own)), chosen)), x, v, biaxial=biaxial)
        found[flow.torsion.point] = flow.divided(found[flow.torsion.point], none[missed > none])
    return found


@dataclass(frozen=True, slots=True)
class _Flow:
    """Flow rule of I interfaces of uniform torsion with P contact points.

    It holds forces, velocities and strengths at these points. ``corners`` (R, 4) are the indices, among the P points,
    of the corners of rectangles that crush.
    """

    torsion: UniformTorsion
    n: Array
    v: Array
    resistance: Array
    done: Array
    dilatancy: Array
    tension: Array
    compression: Array
    rigid: Flags
    corners: Index
    capacity: Array
    biaxial: bool
    force: Array

    @classmethod
    def of(cls, problem: LimitProblem, torsion: UniformTorsion, x: Array, v: Array, *, biaxial: bool) -> Self:
        at = torsion.point
        place = np.full(problem.n_points, -1)
        place[at] = np.arange(len(at))
        mine = (place[problem.rectangles] >= 0).all(axis=1)
        n = x[at, 0]
        resistance = np.maximum(problem.cohesion[at] + problem.friction[at] * n, 0.0)
        return cls(
            torsion=torsion,
            n=n,
            v=v[at],
            resistance=resistance,
            done=np.einsum("pc,pc->p", x[at, 1:], v[at, 1:]),
            dilatancy=problem.dilatancy[at],
            tension=problem.tension[at],
            compression=problem.compression[at],
            rigid=~problem.crushes[at],
            corners=place[problem.rectangles[mine]],
            capacity=problem.capacity[mine],
            biaxial=biaxial,
            force=np.maximum(torsion.summed(resistance), 1.0),
        )

    def missed(self, rate: Array) -> tuple[Array, Array]:
        """Return the missed work (I,) at sliding rates (P,), and its slope (P,).

        The slope is the derivative of the work with respect to each rate. A unit of penetration of rigid points counts
        as much as a unit of sliding against the whole resistance of the joint.
        """
        penetration = self.dilatancy * rate - self.v[:, 0]
        inwards = penetration > 0
        price = self.force[self.torsion.owner]
        beyond = np.maximum(self.n + self.tension, 0.0) * np.sign(penetration) + price * inwards
        of_cell = np.isfinite(self.compression)
        beyond = np.where(of_cell, np.where(inwards, self.compression, -self.tension) - self.n, beyond)
        most = crushing.hardest(penetration[self.corners], self.capacity, biaxial=self.biaxial)
        beyond[self.corners] = most - (self.n + self.tension)[self.corners]
        work = self.torsion.summed(self.resistance * rate + self.done + beyond * penetration)
        # A negative slope is rounding only: the dissipation of a point grows with its sliding.
        return work, np.maximum(self.resistance + self.dilatancy * beyond, 0.0)

    def divided(self, rate: Array, none: Array) -> Array:
        """Return the sliding rates (P,) with the least missed work.

        The search starts from rates (P,). It covers motions w up to the velocity of the fastest point. All points slide
        faster with a larger w than with w = 0.
        """
        own, along = self.torsion, self.v[:, 1:]
        best, (least, _) = rate.copy(), self.missed(rate)
        fastest = np.zeros(len(own))
        np.maximum.at(fastest, own.owner, np.linalg.norm(along, axis=1))
        w, E = np.zeros((len(own), 3)), fastest[:, None, None] ** 2 * np.eye(3)
        # No rate is larger in the first ellipsoid.
        largest, _ = self.missed((3 + np.linalg.norm(own.place, axis=1)) * fastest[own.owner])
        # Each ellipsoid has at most e^(−1/8) times the volume of the previous one. After n ellipsoids the best work is
        # at most e^(−n/24) times the range of the work above the least.
        for _ in range(int(np.ceil(24 * np.log(np.maximum(largest / none, 1.0)).max()))):
            apart = along - own.moved(w)
            of_points, of_cone = np.linalg.norm(apart, axis=1), np.linalg.norm(w, axis=1)
            rate = of_points + of_cone[own.owner]
            work, growth = self.missed(rate)
            better = work < least
            least = np.where(better, work, least)
            best = np.where(better[own.owner], rate, best)

            slope = -own.resultant((growth / np.where(of_points > 0, of_points, 1.0))[:, None] * apart)
            slope += (own.summed(growth) / np.where(of_cone > 0, of_cone, 1.0))[:, None] * w
            to_edge = np.einsum("iab,ib->ia", E, slope)
            width = np.sqrt(np.maximum(np.einsum("ia,ia->i", slope, to_edge), 0.0))
            # The work at the centre less the width is a lower bound inside the ellipsoid.
            left = (least > none) & (least - work + width > none)
            if not left.any():
                break
            held = np.where(left, width, 1.0)
            to_edge, depth = to_edge / held[:, None], np.where(left, (work - least) / held, 0.0)
            step, grown = (1 + 3 * depth) / 4, 9 * (1 - depth**2) / 8
            shrunk = (1 + 3 * depth) / (2 * (1 + depth))
            w = np.where(left[:, None], w - step[:, None] * to_edge, w)
            outer = shrunk[:, None, None] * np.einsum("ia,ib->iab", to_edge, to_edge)
            E = np.where(left[:, None, None], grown[:, None, None] * (E - outer), E)
        return best
