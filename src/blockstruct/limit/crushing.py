"""Express crushing of rectangles by their corner forces: (6) and (7) of docs/theory.md.

``n_e`` is the sum of the two corner forces of edge e, N the sum of all four, and ``F = f_c A``. For a rectangular
stress block, ``|M| ≤ (N b / 2) (1 − N / F)`` about an axis is ``n_e ≥ N² / (2 F)`` for the two edges along this axis.
The four edges together limit bending about each axis separately. The *biaxial* interaction is stricter. Its effective
rectangle ``N ≤ f_c (b1 − 2 |e1|) (b2 − 2 |e2|)`` is ``N³ ≤ 4 F n_e n_f`` for every two adjacent edges e, f.

With a tensile strength f_t, stresses range from −f_t to f_c. They are the sum of a uniform tension f_t and stresses
from 0 to ``f_c + f_t``. The uniform tension has no moment about the centroid, and each corner takes a quarter. The same
conditions therefore apply to the forces ``n_k + f_t A / 4``, with ``F = (f_c + f_t) A``. All corner forces in this
module include this term (:meth:`LimitProblem.beyond_tension`).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from blockstruct.arrays import Array
from blockstruct.limit.problem import LimitProblem

#: Corners of each of the four edges, in order.
EDGES = np.array([(0, 1), (1, 2), (2, 3), (3, 0)])
#: Indices of the corners in order, starting from each corner.
TURNED = (np.arange(4)[:, None] + np.arange(4)) % 4
#: Number of tangents per rectangle. With two, the associative programs alternate between states without end.
TANGENTS = 4


def edge_sums(n: Array) -> Array:
    """Return the edge forces ``n_e`` (R, 4) of corner forces (R, 4)."""
    return np.asarray(n[:, EDGES].sum(axis=2))


def excess(n: Array, capacity: Array, *, biaxial: bool) -> Array:
    """Return the force by which each rectangle exceeds crushing, (R,).

    It is negative inside. Uniaxial: the largest ``N² / (2 F) − n_e``. Biaxial: the largest δ with
    ``(n_e + δ)(n_f + δ) = N³ / (4 F)``, the force missing at both edges. The excess of N,
    ``N − (4 F n_e n_f)^(1/3)``, is not used: at a nearly unloaded joint, rounding at one edge would make it all of N.
    """
    N, n_e = n.sum(axis=1), edge_sums(n)
    if not biaxial:
        return np.asarray(N**2 / (2 * capacity) - n_e.min(axis=1, initial=np.inf))
    n_f, product = np.roll(n_e, -1, axis=1), np.maximum(N, 0) ** 3 / (4 * capacity)
    short = (np.sqrt((n_e - n_f) ** 2 + 4 * product[:, None]) - n_e - n_f) / 2
    return np.asarray(short.max(axis=1, initial=-np.inf))


@dataclass(frozen=True, slots=True)
class Linearisation:
    """Normal forces N0 (R, 4) at the tangents of each rectangle, latest last.

    The condition ``n_e ≥ N² / (2 F)`` becomes ``n_e ≥ (N0 / F) N − N0² / (2 F)`` for each tangent.
    """

    N0: Array

    @classmethod
    def first(cls, problem: LimitProblem) -> Self:
        """Return the linearisation for the first program.

        Its tangent at the full strength limits N and cuts off no admissible state.
        """
        return cls(np.repeat(problem.capacity[:, None], TANGENTS, axis=1))

    def after(self, problem: LimitProblem, n: Array) -> Self:
        """Return the linearisation with a tangent at new normal forces n (K,).

        The new tangent replaces the farthest tangent.
        """
        N = np.clip(problem.beyond_tension(n).sum(axis=1), 0, problem.capacity)
        near = np.argsort(-np.abs(self.N0 - N[:, None]), axis=1)[:, 1:]
        return type(self)(np.column_stack([np.take_along_axis(self.N0, near, axis=1), N]))

    def lines(self, capacity: Array) -> tuple[Array, Array]:
        """Return slope and offset of each tangent, both (R, 4)."""
        slope = self.N0 / capacity[:, None]
        return slope, slope * self.N0 / 2


def dissipation(w: Array, capacity: Array, *, biaxial: bool) -> Array:
    """Return the rate of work that crushing dissipates, (R,).

    It is the largest ``n·w`` of admissible forces n at penetration rates w (R, 4).
    """
    return np.asarray((hardest(w, capacity, biaxial=biaxial) * w).sum(axis=1))


def hardest(w: Array, capacity: Array, *, biaxial: bool) -> Array:
    """Return the admissible corner forces of largest work, (R, 4).

    The work is at penetration rates w (R, 4). The rates need not belong to a plane: with dilatancy each corner is
    lifted by its own sliding.

    Uniaxial: for a given ``ν = N / F`` the best forces follow one of eight patterns, linear in ν. The largest work is
    the maximum of eight parabolas over 0 ≤ ν ≤ 1.

    Biaxial: let the resultant lean towards corner 0. Let p and q be the shares of N on the two edges away from this
    corner, each at most a half. The effective rectangle has 2 p and 2 q times the sides of the whole, so that
    ``N ≤ 4 F p q``. N and its two moments leave the share r at the opposite corner free. The four corners have
    ``1 − p − q + r, p − r, r, q − r`` in order, with ``0 ≤ r ≤ min(p, q)``. The work is linear in N and in r, so that
    it is largest at the ends of their ranges. At ``N = 4 F p q`` it is ``4 F p q (w0 + a p + b q)``. The coefficients
    are ``a = w1 − w0, b = w3 − w0`` on the square with r = 0. On the triangle with ``r = p ≤ q``, ``a = w2 − w3``
    instead. On the triangle with ``r = q ≤ p``, ``b = w2 − w1`` instead. The work is largest at
    ``a p = b q = −w0 / 3``, where both derivatives are zero, or on an edge.
    """
    if not len(w):
        return np.zeros_like(w)
    # Rotate the corners so that the resultant leans towards the first, for each corner.
    turned = w[:, TURNED]
    patterns = _biaxial(turned) if biaxial else _uniaxial(turned)
    work = np.einsum("mrkc,rkc->rkm", patterns, turned).reshape(len(w), 4 * len(patterns))
    best = work.argmax(axis=1)
    corner, pattern = np.divmod(best, len(patterns))
    every = np.arange(len(w))
    found = np.zeros_like(w)
    found[every[:, None], TURNED[corner]] = patterns[pattern, every, corner] * capacity[:, None]
    return np.where((work[every, best] > 0)[:, None], found, 0.0)


def _uniaxial(w: Array) -> Array:
    """Return the best forces of the two uniaxial patterns, (2, R, 4, 4).

    The resultant leans towards the first corner. Forces are in multiples of the capacity.
    """
    corner, after, across, before = np.moveaxis(w, -1, 0)
    # The force is shared with the opposite corner, or with the two neighbours.
    opposite, beside = _peak(corner, (across - corner) / 2), _peak(corner, (after + before) / 2 - corner)
    nu = np.stack([opposite, beside])
    return _towards(nu, nu / 2, nu / 2, np.stack([opposite / 2, 0 * beside]))


def _biaxial(w: Array) -> Array:
    """Return the biaxial forces whose work may be largest, (10, R, 4, 4).

    The resultant leans towards the first corner. Forces are in multiples of the capacity.
    """
    corner, after, across, before = np.moveaxis(w, -1, 0)
    half = np.full_like(corner, 0.5)
    a, b = after - corner, before - corner
    shares = [(_stationary(corner, 3 * a), _stationary(corner, 3 * b), 0 * half), (half, half, 0 * half)]
    shares += [
        (_stationary(corner + b / 2, 2 * a), half, 0 * half),
        (half, _stationary(corner + a / 2, 2 * b), 0 * half),
    ]
    for of_less, of_more, swapped in ((across - before, b, False), (across - after, a, True)):
        equal = _stationary(2 * corner, 3 * (of_less + of_more))
        inside = _stationary(corner, 3 * of_less), _stationary(corner, 3 * of_more)
        for less, more in (inside, (equal, equal), (_stationary(corner + of_more / 2, 2 * of_less), half)):
            r = np.minimum(less, more)
            shares.append((more, r, r) if swapped else (r, more, r))
    p, q, r = (np.stack(part) for part in zip(*shares, strict=True))
    return _towards(4 * p * q, p, q, r)


def _stationary(c0: Array, c1: Array) -> Array:
    """Return the share ``−c0 / c1``, limited to 0 … 1/2; 1/2 if ``c1 ≥ 0``."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(c1 < 0, np.clip(-c0 / c1, 0, 0.5), 0.5))


def _towards(N: Array, p: Array, q: Array, across: Array) -> Array:
    """Return the corner forces of resultants N towards the first corner.

    p and q are the shares of N on the two edges away from this corner. ``across`` is the share of the opposite corner.
    """
    return np.stack([1 - p - q + across, p - across, across, q - across], axis=-1) * N[..., None]


def _peak(c0: Array, c1: Array) -> Array:
    """Return the ν at which ``c0 ν + c1 ν²`` is largest over 0 ≤ ν ≤ 1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(c1 < 0, np.clip(-c0 / (2 * c1), 0, 1), 1.0))
