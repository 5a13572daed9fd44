"""Crushing of rectangular interfaces, on the normal forces of their four corners.

With ``n_e`` the sum of the two corners of edge e, N the sum of all four and ``F = f_c A``, a rectangular stress block
gives ``|M| ≤ (N b / 2) (1 − N / F)`` about an axis as ``n_e ≥ N² / (2 F)`` for the two edges along it. The four edges
together bound each direction by itself. The stricter *biaxial* interaction, the effective rectangle
``N ≤ f_c (b1 − 2 |e1|) (b2 − 2 |e2|)``, is ``N³ ≤ 4 F n_e n_f`` for every two adjacent edges e, f.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.problem import LimitProblem

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Corners of the four edges, in turn.
EDGES = np.array([(0, 1), (1, 2), (2, 3), (3, 0)])
#: Row e marks the corners of edge e.
EDGE_OF_CORNER = np.array([[corner in edge for corner in range(4)] for edge in EDGES.tolist()], dtype=float)


def edge_sums(n: Array) -> Array:
    """Normal force ``n_e`` of each edge, (R, 4), of corner forces (R, 4)."""
    return np.asarray(n[:, EDGES].sum(axis=2))


def excess(n: Array, capacity: Array, *, biaxial: bool) -> Array:
    """Normal force by which each rectangle misses the true conditions, (R,); negative inside.

    Uniaxial: the largest ``N² / (2 F) − n_e``. Biaxial: the largest ``N − (4 F n_e n_f)^(1/3)``.
    """
    N, n_e = n.sum(axis=1), edge_sums(n)
    if not biaxial:
        return np.asarray(N**2 / (2 * capacity) - n_e.min(axis=1, initial=np.inf))
    products = np.maximum(n_e, 0) * np.maximum(np.roll(n_e, -1, axis=1), 0)
    return np.asarray(N - np.cbrt(4 * capacity * products.min(axis=1, initial=np.inf)))


@dataclass(frozen=True, slots=True)
class Linearisation:
    """Where each rectangle is linearised, (R,): at the normal force N0, by the tangent or by the secant.

    The condition ``n_e ≥ N² / (2 F)`` becomes ``n_e ≥ slope N − offset``. The *tangent* ``(N0 / F) N − N0² / (2 F)``
    touches it at N0 and has its normal, but admits states beyond it elsewhere. The *secant* ``N0 / (2 F) N`` meets it
    at 0 and N0 and admits no state beyond it in between, but its normal is another one.
    """

    N0: Array
    tangent: Flags

    @classmethod
    def first(cls, problem: LimitProblem) -> Self:
        """Before any state is known: the tangent at the full strength, which bounds N and cuts off nothing."""
        return cls(problem.capacity, np.ones(len(problem.capacity), dtype=bool))

    def after(self, problem: LimitProblem, x: Array, v: Array, beta: float) -> Self:
        """Linearisation about a state (x, v), of which β is taken up.

        Rectangles that crush in the mechanism take the tangent: only with the true normal is the mechanism the true
        one. The others take the secant at the largest normal force they had, since theirs is not unique: between
        tangents it would swing for ever.
        """
        corners = problem.rectangles
        N = np.clip(x[corners, 0].sum(axis=1), 0, problem.capacity)
        penetration = problem.dilatancy * problem.slip(v, x[:, 0]) - v[:, 0]
        speed = np.linalg.norm(v, axis=1) / problem.force_unit
        crushes = ((penetration / problem.force_unit)[corners] > 1e-6 * speed.max()).any(axis=1)
        secant = np.where(self.tangent, N, np.maximum(N, self.N0))
        N0 = np.where(crushes, beta * N + (1 - beta) * self.N0, secant)
        return type(self)(N0, crushes)

    def lines(self, capacity: Array) -> tuple[Array, Array]:
        """Slope and offset of each rectangle, each (R,)."""
        slope = np.where(self.tangent, 1.0, 0.5) * self.N0 / capacity
        return slope, np.where(self.tangent, self.N0**2 / (2 * capacity), 0.0)


def dissipation(w: Array, capacity: Array, *, biaxial: bool) -> Array:
    """Work that crushing dissipates, (R,): largest ``n·w`` of admissible forces at penetration rates w, (R, 4).

    Uniaxial: for a given ``ν = N / F`` the best forces stand in one of eight patterns, linear in ν, so the largest
    work is that of eight parabolas over 0 ≤ ν ≤ 1. Biaxial: with the sides of the effective rectangle in shares
    ``a1, a2`` of the edges, the work of a plane distribution of rates is ``F a1 a2 (w0 + G1 (1 − a1) + G2 (1 − a2))``;
    the part of the rates that is not plane (there is none without dilatancy) is counted in full.
    """
    return _biaxial(w) * capacity if biaxial else _uniaxial(w) * capacity


def _uniaxial(w: Array) -> Array:
    best = np.zeros(len(w))
    for k in range(4):
        corner, after, across, before = (np.roll(w, -k, axis=1)[:, m] for m in range(4))
        # Resultant towards a corner: shared with the opposite one, or with its two neighbours.
        for c0, c1 in (
            (corner, (across - corner) / 2),
            (corner, (after + before) / 2 - corner),
        ):
            best = np.maximum(best, _parabola(c0, c1))
    return best


def _parabola(c0: Array, c1: Array) -> Array:
    """Largest ``c0 ν + c1 ν²`` over 0 ≤ ν ≤ 1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        peak = np.where(c1 < 0, np.clip(-c0 / (2 * c1), 0, 1), 1.0)
    return np.asarray(np.maximum(c0 * peak + c1 * peak**2, 0.0))


def _biaxial(w: Array) -> Array:
    w0 = w.mean(axis=1)
    G1 = np.abs(w[:, 1] + w[:, 2] - w[:, 0] - w[:, 3]) / 4
    G2 = np.abs(w[:, 2] + w[:, 3] - w[:, 0] - w[:, 1]) / 4
    w0 = w0 + np.abs(w[:, 0] + w[:, 2] - w[:, 1] - w[:, 3]) / 4

    def share(rest: Array, G: Array) -> Array:
        """Best a of ``a (rest + G (1 − a))``."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(G > 0, np.clip((rest + G) / (2 * G), 0, 1), 1.0))

    def work(a1: Array, a2: Array) -> Array:
        return np.asarray(a1 * a2 * (w0 + G1 * (1 - a1) + G2 * (1 - a2)))

    one = np.ones_like(w0)
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = [np.where(G > 0, np.clip((w0 + G1 + G2) / (3 * G), 0, 1), 1.0) for G in (G1, G2)]
    candidates = [
        work(one, one),
        work(one, share(w0, G2)),
        work(share(w0, G1), one),
        work(inner[0], inner[1]),
        work(inner[0], share(w0 + G1 * (1 - inner[0]), G2)),
        work(share(w0 + G2 * (1 - inner[1]), G1), inner[1]),
    ]
    return np.asarray(np.maximum(np.max(candidates, axis=0), 0.0))
