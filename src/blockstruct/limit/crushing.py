"""Crushing of rectangular interfaces, on the normal forces of their four corners.

With ``n_e`` the sum of the two corners of edge e, N the sum of all four and ``F = f_c A``, a rectangular stress block
gives ``|M| ≤ (N b / 2) (1 − N / F)`` about an axis as ``n_e ≥ N² / (2 F)`` for the two edges along it. The *uniaxial*
interaction is these four conditions. The stricter *biaxial* interaction, the effective rectangle
``N ≤ f_c (b1 − 2 |e1|) (b2 − 2 |e2|)``, is ``N³ ≤ 4 F n_e n_f`` for every two adjacent edges e, f.

**Flow.** With associative flow a joint that rocks about one axis settles about the other as well, towards its
resultant, by a rotation that is smaller the stronger the joint is but never zero. Over a long path that small rotation
leans a wall on its neighbours, and friction there raises the load factor. Without dilatancy a rectangle therefore rocks
as the strip that bears does. Edges 0 and 2 obey the uniaxial condition of a strip, ``n_e ≥ N² / (2 b F)``, where b is
the share of their length over which the joint bears (:func:`bearing`), and edges 1 and 3 likewise. The yield condition
is still that of the effective rectangle. As the strength grows, condition and flow become those of a joint that does
not crush.

Where a joint has a tensile strength f_t, stresses from −f_t to f_c are a uniform tension f_t and stresses from 0 to
``f_c + f_t``. That tension has no moment about the centroid, and a quarter of it stands at each corner: the conditions
are these of the forces ``n_k + f_t A / 4``, with ``F = (f_c + f_t) A``. All corner forces here are those
(:meth:`LimitProblem.beyond_tension`).
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.problem import LimitProblem

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Corners of the four edges, in turn.
EDGES = np.array([(0, 1), (1, 2), (2, 3), (3, 0)])
#: The corners in turn, beginning with each.
TURNED = (np.arange(4)[:, None] + np.arange(4)) % 4
#: Row e marks the corners of edge e.
EDGE_OF_CORNER = np.array([[corner in edge for corner in range(4)] for edge in EDGES.tolist()], dtype=float)


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
        N = np.clip(problem.beyond_tension(x[:, 0]).sum(axis=1), 0, problem.capacity)
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


#: Normal force, in local units, that is added to both edges: a joint without force bears over its whole length.
_CENTRED = 1e-6
#: Relative change of the bearing length by which a derivative is taken.
_CHANGE = 1e-4


def bearing(problem: LimitProblem, n: Array, before: Array | None = None) -> Array:
    """Return the share of the length over which rectangles bear, (R, 2).

    The first is the share of edges 0 and 2, the second of edges 1 and 3: ``1 − 2 |e| / b`` for the eccentricity e
    along them. Where the resultant is nearer to the other edges it is at least ``√(N / F)``, the share that both have
    where the effective rectangle is similar to the joint. It limits bending then.

    Parameters
    ----------
    n : (K,) array
        Normal forces of all contact points.
    before : (R, 2) array
        Shares of the last step, with which the geometric mean is taken. Each share of a joint that bends about both
        axes decides the other: near the diagonal they would swing around their mean for ever.
    """
    share = np.maximum(*_shares(problem, n))
    return share if before is None else np.sqrt(share * before)


def shift(problem: LimitProblem, v: Array, n: Array, *, biaxial: bool) -> Array:
    """Return the growth of the work that crushing dissipates with the normal forces, (K,).

    It grows with the length over which joints bear. Like the shift of De Saxcé & Feng (1998) for sliding, it makes
    the flow-rule gap of given velocities linear in the forces, to first order. It is zero where the length does not
    matter: with uniaxial interaction, and with associative flow.

    Parameters
    ----------
    v : (K, 3) array
        Relative velocities.
    n : (K,) array
        Normal forces about which the growth is taken.
    biaxial
        Interaction of crushing about the two axes.
    """
    grown, corners = np.zeros(problem.n_points), problem.rectangles
    if not biaxial or problem.is_associative or not len(corners):
        return grown
    w = (problem.dilatancy * problem.slip(v, n) - v[:, 0])[corners]
    flow, lengths = CrushingFlow.of(problem, n, biaxial=True), bearing(problem, n)
    forces = problem.beyond_tension(n)
    N, n_e = np.maximum(forces.sum(axis=1), 0.0), edge_sums(forces)
    by_edge, by_size = _shares(problem, n)
    for axis in (0, 1):
        change = 1 + _CHANGE * np.array([axis == 0, axis == 1])
        more, less = (replace(flow, bearing=lengths * c).dissipation(w) for c in (change, 2 - change))
        # Relative growth of the share with each corner: of that of an edge, or of √(N / F).
        edge = 1 - axis + 2 * n_e[:, [1 - axis, 3 - axis]].argmin(axis=1)
        least = np.maximum(n_e[np.arange(len(edge)), edge], 0.0)
        of_edge = EDGE_OF_CORNER[edge] / (least + _CENTRED)[:, None] - 1 / (N + 2 * _CENTRED)[:, None]
        of_size = 1 / (2 * N + _CENTRED)[:, None]
        growth = np.where((by_edge >= by_size)[:, axis, None], of_edge, of_size)
        grown[corners] += ((more - less) / (2 * _CHANGE))[:, None] * growth
    return grown


def _shares(problem: LimitProblem, n: Array) -> tuple[Array, Array]:
    """Shares (R, 2) of the length that bear, by the eccentricity and by the size of the force."""
    forces = problem.beyond_tension(n)
    N, n_e = np.maximum(forces.sum(axis=1), 0.0), edge_sums(forces)
    least = np.maximum(np.minimum(n_e[:, [1, 0]], n_e[:, [3, 2]]), 0.0)
    by_edge = 2 * (least + _CENTRED) / (N + 2 * _CENTRED)[:, None]
    by_size = np.sqrt(np.minimum(N / problem.capacity, 1.0))
    return by_edge, np.repeat(by_size[:, None], 2, axis=1)


@dataclass(frozen=True, slots=True)
class CrushingFlow:
    """Forces that the flow rule compares with those of R rectangles.

    Attributes
    ----------
    capacity : (R,) array
    bearing : (R, 2) array or None
        Share of the length of edges 0 and 2, and of edges 1 and 3, over which they bear. None with associative flow
        of the biaxial interaction, where all admissible forces are compared.
    largest : (R,) array
        Normal force up to which they are compared: twice the normal force of the joint, or one unit more. Forces that
        do the most work among these do the most among all, and the gap of a state does not grow with the strength.
    """

    capacity: Array
    bearing: Array | None
    largest: Array

    @classmethod
    def of(cls, problem: LimitProblem, n: Array, *, biaxial: bool) -> Self:
        """Flow at normal forces (K,)."""
        if biaxial and problem.is_associative:
            return cls(problem.capacity, None, np.full(len(problem.capacity), np.inf))
        N = problem.beyond_tension(n).sum(axis=1)
        share = bearing(problem, n) if biaxial else np.ones((len(N), 2))
        return cls(problem.capacity, share, N + np.maximum(N, 1.0))

    def part(self, rectangles: Flags) -> Self:
        """Some of the rectangles."""
        own = None if self.bearing is None else self.bearing[rectangles]
        return type(self)(self.capacity[rectangles], own, self.largest[rectangles])

    def dissipation(self, w: Array) -> Array:
        """Work that crushing dissipates, (R,): largest ``n·w`` of the forces at penetration rates w, (R, 4)."""
        return np.asarray((self.hardest(w) * w).sum(axis=1))

    def hardest(self, w: Array) -> Array:
        """Corner forces with the largest work at penetration rates w, both (R, 4).

        Let the resultant lean towards corner 0, so that p and q, the shares of N on the two edges off it, are at most a
        half. N and its two moments leave one share free, r at the corner across: the corners have
        ``1 − p − q + r, p − r, r, q − r`` in turn, with ``0 ≤ r ≤ min(p, q)``. The work is linear in N and in r, thus
        largest at their ends.

        With given bearing lengths the best p and q are as small as they may be, ``p = N / (2 b_p F)`` and
        ``q = N / (2 b_q F)``; or both are the larger of the two, and all that leaves corner 0 stands across. Each time
        the work is a parabola in N.

        Of the effective rectangle, ``N ≤ 4 F p q``: at ``N = 4 F p q`` the work is ``4 F p q (w0 + a p + b q)``, with
        ``a = w1 − w0, b = w3 − w0`` over the square where r = 0, with ``a = w2 − w3`` instead over the triangle where
        ``r = p ≤ q``, and with ``b = w2 − w1`` over that where ``r = q ≤ p``. It is largest where both derivatives are
        zero, ``a p = b q = −w0 / 3``, or on an edge. Rates need not be those of a plane: with dilatancy every corner is
        lifted by its own sliding.
        """
        # The corner that the resultant leans towards first, in turn.
        turned = w[:, TURNED]
        if self.bearing is None:
            patterns = _biaxial(turned)
        else:
            # Off corner 0 are an edge of the second pair and one of the first, off the next corner the reverse.
            b = self.bearing[:, (np.arange(4)[:, None] + [1, 0]) % 2]
            patterns = _uniaxial(turned, b, (self.largest / self.capacity)[:, None])
        work = np.einsum("mrkc,rkc->rkm", patterns, turned).reshape(len(w), 4 * len(patterns))
        best = work.argmax(axis=1)
        corner, pattern = np.divmod(best, len(patterns))
        every = np.arange(len(w))
        found = np.zeros_like(w)
        found[every[:, None], TURNED[corner]] = patterns[pattern, every, corner] * self.capacity[:, None]
        return np.where((work[every, best] > 0)[:, None], found, 0.0)


def _uniaxial(w: Array, b: Array, limit: Array) -> Array:
    """The best forces of three patterns towards the first corner, (3, R, 4, 4), in multiples of the capacity."""
    corner, after, across, before = np.moveaxis(w, -1, 0)
    b_p, b_q = np.moveaxis(b, -1, 0)
    p, q = 0.5 / b_p, 0.5 / b_q
    least, larger = np.minimum(p, q), np.maximum(p, q)
    shares = ((p, q, 0 * p), (p, q, least), (larger, larger, larger))
    p, q, r = (np.stack(part) for part in zip(*shares, strict=True))
    growth = p * (after - corner) + q * (before - corner) + r * (corner - after + across - before)
    nu = _peak(corner, growth, np.minimum(np.minimum(b_p, b_q), limit))
    return _towards(nu, p * nu, q * nu, r * nu)


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


def _peak(c0: Array, c1: Array, most: Array) -> Array:
    """Where ``c0 ν + c1 ν²`` is largest over 0 ≤ ν ≤ most."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(c1 < 0, np.clip(-c0 / (2 * c1), 0, most), most))
