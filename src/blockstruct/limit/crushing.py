"""Crushing of rectangular interfaces, on the normal forces of their four corners.

With ``n_e`` the sum of the two corners of edge e, N the sum of all four and ``F = f_c A``, a rectangular stress block
gives ``|M| ≤ (N b / 2) (1 − N / F)`` about an axis as ``n_e ≥ N² / (2 F)`` for the two edges along it. The four edges
together bound each direction by itself. The stricter *biaxial* interaction, the effective rectangle
``N ≤ f_c (b1 − 2 |e1|) (b2 − 2 |e2|)``, is ``N³ ≤ 4 F n_e n_f`` for every two adjacent edges e, f.

Where a joint has a tensile strength f_t, stresses from −f_t to f_c are a uniform tension f_t and stresses from 0 to
``f_c + f_t``. That tension has no moment about the centroid, and a quarter of it stands at each corner: the conditions
are these of the forces ``n_k + f_t A / 4``, with ``F = (f_c + f_t) A``. All corner forces here are those
(:meth:`LimitProblem.beyond_tension`).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.problem import LimitProblem

Array = NDArray[np.float64]

#: Corners of the four edges, in turn.
EDGES = np.array([(0, 1), (1, 2), (2, 3), (3, 0)])
#: The corners in turn, beginning with each.
TURNED = (np.arange(4)[:, None] + np.arange(4)) % 4
#: Tangents of each rectangle. With two, the associative programs swing between states for ever.
TANGENTS = 4


def edge_sums(n: Array) -> Array:
    """Normal force ``n_e`` of each edge, (R, 4), of corner forces (R, 4)."""
    return np.asarray(n[:, EDGES].sum(axis=2))


def excess(n: Array, capacity: Array, *, biaxial: bool) -> Array:
    """Normal force by which each rectangle misses the true conditions, (R,); negative inside.

    Uniaxial: the largest ``N² / (2 F) − n_e``. Biaxial: the largest δ with ``(n_e + δ)(n_f + δ) = N³ / (4 F)``, which
    both edges are short of. The force that N is too large by, ``N − (4 F n_e n_f)^(1/3)``, would be all of N where a
    joint that bears next to nothing is short of the last digit of an edge.
    """
    N, n_e = n.sum(axis=1), edge_sums(n)
    if not biaxial:
        return np.asarray(N**2 / (2 * capacity) - n_e.min(axis=1, initial=np.inf))
    n_f, product = np.roll(n_e, -1, axis=1), np.maximum(N, 0) ** 3 / (4 * capacity)
    short = (np.sqrt((n_e - n_f) ** 2 + 4 * product[:, None]) - n_e - n_f) / 2
    return np.asarray(short.max(axis=1, initial=-np.inf))


@dataclass(frozen=True, slots=True)
class Linearisation:
    """Normal forces at which each rectangle has a tangent, (R, 4), the latest last.

    The condition ``n_e ≥ N² / (2 F)`` becomes ``n_e ≥ (N0 / F) N − N0² / (2 F)`` for each of them.
    """

    N0: Array

    @classmethod
    def first(cls, problem: LimitProblem) -> Self:
        """Before any state is known: the tangent at the full strength, which bounds N and cuts off nothing."""
        return cls(np.repeat(problem.capacity[:, None], TANGENTS, axis=1))

    def after(self, problem: LimitProblem, n: Array) -> Self:
        """Return the linearisation with a tangent at new normal forces n, (K,), instead of the farthest from them."""
        N = np.clip(problem.beyond_tension(n).sum(axis=1), 0, problem.capacity)
        near = np.argsort(-np.abs(self.N0 - N[:, None]), axis=1)[:, 1:]
        return type(self)(np.column_stack([np.take_along_axis(self.N0, near, axis=1), N]))

    def lines(self, capacity: Array) -> tuple[Array, Array]:
        """Slope and offset of each tangent, each (R, 4)."""
        slope = self.N0 / capacity[:, None]
        return slope, slope * self.N0 / 2


def dissipation(w: Array, capacity: Array, *, biaxial: bool) -> Array:
    """Work that crushing dissipates, (R,): largest ``n·w`` of admissible forces at penetration rates w, (R, 4)."""
    return np.asarray((hardest(w, capacity, biaxial=biaxial) * w).sum(axis=1))


def hardest(w: Array, capacity: Array, *, biaxial: bool) -> Array:
    """Admissible corner forces with the largest work at penetration rates w, both (R, 4).

    Uniaxial: for a given ``ν = N / F`` the best forces stand in one of eight patterns, linear in ν, so the largest
    work is that of eight parabolas over 0 ≤ ν ≤ 1.

    Biaxial: let the resultant lean towards corner 0, so that p and q, the shares of N on the two edges off it, are at
    most a half. The effective rectangle has the sides 2 p and 2 q of the whole, ``N ≤ 4 F p q``. N and its two moments
    leave one share free, r at the corner across: the corners have ``1 − p − q + r, p − r, r, q − r`` in turn, with
    ``0 ≤ r ≤ min(p, q)``. The work is linear in N and in r, thus largest at their ends: at ``N = 4 F p q`` it is
    ``4 F p q (w0 + a p + b q)``, with ``a = w1 − w0, b = w3 − w0`` over the square where r = 0, with ``a = w2 − w3``
    instead over the triangle where ``r = p ≤ q``, and with ``b = w2 − w1`` over that where ``r = q ≤ p``. It is
    largest where both derivatives are zero, ``a p = b q = −w0 / 3``, or on an edge. Rates need not be those of a
    plane: with dilatancy every corner is lifted by its own sliding.
    """
    # The corner that the resultant leans towards first, in turn.
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
    """The best forces of two patterns towards the first corner, (2, R, 4, 4), in multiples of the capacity."""
    corner, after, across, before = np.moveaxis(w, -1, 0)
    # Shared with the opposite corner, or with the two neighbours.
    opposite, beside = _peak(corner, (across - corner) / 2), _peak(corner, (after + before) / 2 - corner)
    nu = np.stack([opposite, beside])
    return _towards(nu, nu / 2, nu / 2, np.stack([opposite / 2, 0 * beside]))


def _biaxial(w: Array) -> Array:
    """Forces towards the first corner where the work may be largest, (10, R, 4, 4), in multiples of the capacity."""
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
    """Share ``−c0 / c1``, from 0 to 1/2; the half where the work grows with it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(c1 < 0, np.clip(-c0 / c1, 0, 0.5), 0.5))


def _towards(N: Array, p: Array, q: Array, across: Array) -> Array:
    """Corner forces of resultants N towards the first corner, of shares p and q on the edges off it."""
    return np.stack([1 - p - q + across, p - across, across, q - across], axis=-1) * N[..., None]


def _peak(c0: Array, c1: Array) -> Array:
    """Where ``c0 ν + c1 ν²`` is largest over 0 ≤ ν ≤ 1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(c1 < 0, np.clip(-c0 / (2 * c1), 0, 1), 1.0))
