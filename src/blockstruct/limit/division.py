"""Division of sliding between the contact points of a joint and the cone of its torsion, where joints dilate.

The conditions of an interface with the torsion of uniform pressure meet in one domain of its normal and shear forces.
The work that forces inside may do at most at the relative velocities of its points, the support function of that
domain, is by duality ::

    min over w of  Σ c A_k r_k + h(μ r − v_n),   r_k = ‖v_t,k − J_k w‖ + ‖w‖,

with h that of the domain of normal forces alone: that of crushing, or zero if no point penetrates and ∞ otherwise.
The motions w are the multipliers of the cone. Velocities are thus admissible if *some* division r lets no point
penetrate. Which it is does not follow from what friction dissipates: where a joint carries nothing every division
dissipates nothing, and where a few of its points are pressed these leave it open how the others slide.

So the division is taken by which a state misses the flow rule least: by the work that friction, normal forces and
crushing could do beyond what they do, with what rigid points penetrate. It is a convex function of w, not smooth, of
three variables for each joint, which ellipsoids around its minimum enclose: each is the least that holds the part of
the one before where a subgradient leaves less to be found.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.crushing import CrushingFlow
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.torsion import UniformTorsion

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Index = NDArray[np.int64]

#: Ellipsoids at most, each of e^(−1/8) of the volume of the one before or less.
STEPS = 500
#: Missed work that is none, in multiples of the resistance of a joint times the largest velocity; and how closely
#: missed work that is some is found, relative to it.
NONE, ENOUGH = 1e-8, 1e-3


def sliding(problem: LimitProblem, x: Array, v: Array, *, biaxial: bool) -> Array:
    """Rate at which each contact point slides, (K,), by itself and with the cone of its interface.

    It is ``‖v_t‖`` but in the interfaces of uniform torsion. There it is :meth:`UniformTorsion.slip` without
    dilatancy, and where that already misses nothing.

    Parameters
    ----------
    x, v : (K, 3) arrays
        Contact forces, and relative velocities with the gap that is open before they act.
    biaxial
        Interaction of crushing about the two axes.
    """
    crushes = CrushingFlow.of(problem, x[:, 0], biaxial=biaxial)
    found = problem.slip(v, x[:, 0])
    own = problem.torsion
    dilates = own.total(problem.dilatancy) > 0
    if not dilates.any() or not np.isfinite(x).all() or not np.isfinite(v).all():
        return found
    largest = float((np.linalg.norm(v, axis=1) / problem.force_unit).max())
    flow = _Flow.of(problem, own.part(dilates), x, v, crushes)
    unit = np.empty(len(flow.torsion))
    unit[flow.torsion.owner] = problem.force_unit[flow.torsion.point]
    none = NONE * largest * unit * flow.force
    missed, _ = flow.missed(found[flow.torsion.point])
    chosen = np.flatnonzero(dilates)[missed > none]
    if len(chosen):
        flow = _Flow.of(problem, own.part(np.isin(np.arange(len(own)), chosen)), x, v, crushes)
        found[flow.torsion.point] = flow.divided(found[flow.torsion.point], none[missed > none])
    return found


@dataclass(frozen=True, slots=True)
class _Flow:
    """The flow rule of I interfaces of uniform torsion: forces, velocities and strengths at their P points.

    ``corners`` (R, 4) are those of the rectangles that crush, among the P points.
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
    crushes: CrushingFlow
    force: Array

    @classmethod
    def of(cls, problem: LimitProblem, torsion: UniformTorsion, x: Array, v: Array, crushes: CrushingFlow) -> Self:
        at = torsion.point
        place = np.full(problem.n_points, -1)
        place[at] = np.arange(len(at))
        mine = np.asarray((place[problem.rectangles] >= 0).all(axis=1))
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
            crushes=crushes.part(mine),
            force=np.maximum(torsion.summed(resistance), 1.0),
        )

    def missed(self, rate: Array) -> tuple[Array, Array]:
        """Work missed by each interface, (I,), at rates of sliding (P,), and its growth with each rate, (P,).

        A unit of penetration of rigid points counts as much as sliding against the whole resistance of the joint.
        """
        penetration = self.dilatancy * rate - self.v[:, 0]
        inwards = penetration > 0
        price = self.force[self.torsion.owner]
        beyond = np.maximum(self.n + self.tension, 0.0) * np.sign(penetration) + price * inwards
        of_cell = np.isfinite(self.compression)
        beyond = np.where(of_cell, np.where(inwards, self.compression, -self.tension) - self.n, beyond)
        most = self.crushes.hardest(penetration[self.corners])
        beyond[self.corners] = most - (self.n + self.tension)[self.corners]
        work = self.torsion.summed(self.resistance * rate + self.done + beyond * penetration)
        # Below zero by rounding alone: what a point dissipates grows with its sliding.
        return work, np.maximum(self.resistance + self.dilatancy * beyond, 0.0)

    def divided(self, rate: Array, none: Array) -> Array:
        """Rates of sliding, (P,), by which each interface misses least, beginning with a division of rates (P,).

        No motion beyond the fastest point is better than none at all: with it all points slide faster.
        """
        own, along, (x, y) = self.torsion, self.v[:, 1:], self.torsion.place.T
        best, (least, _) = rate.copy(), self.missed(rate)
        fastest = np.zeros(len(own))
        np.maximum.at(fastest, own.owner, np.linalg.norm(along, axis=1))
        w, E = np.zeros((len(own), 3)), fastest[:, None, None] ** 2 * np.eye(3)
        for _ in range(STEPS):
            apart = along - w[own.owner, :2] - w[own.owner, 2:] * np.column_stack([-y, x])
            of_points, of_cone = np.linalg.norm(apart, axis=1), np.linalg.norm(w, axis=1)
            rate = of_points + of_cone[own.owner]
            work, growth = self.missed(rate)
            better = work < least
            least = np.where(better, work, least)
            best = np.where(better[own.owner], rate, best)

            a, b = (-growth[:, None] * apart / np.where(of_points > 0, of_points, 1.0)[:, None]).T
            slope = np.column_stack([own.summed(part) for part in (a, b, x * b - y * a)])
            slope += (own.summed(growth) / np.where(of_cone > 0, of_cone, 1.0))[:, None] * w
            to_edge = np.einsum("iab,ib->ia", E, slope)
            width = np.sqrt(np.maximum(np.einsum("ia,ia->i", slope, to_edge), 0.0))
            # Nothing inside is less than the work at its centre less the width.
            left = (least > none) & (least - work + width > np.maximum(none, ENOUGH * least))
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
