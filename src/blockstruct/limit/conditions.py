"""The failure conditions as rows ``h − G y ∈ cone`` of a program, for the variables ``y = (κ α, n_1, s_1, t_1, …)``."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit.crushing import EDGES
from blockstruct.limit.problem import LimitProblem

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class ConstraintRows:
    """ConstraintRows of a program: sparse G and right-hand side h."""

    G: sp.csr_array
    h: Array

    def __len__(self) -> int:
        return len(self.h)


def normal_force(points: Index) -> Index:
    """Columns of the normal forces of contact points."""
    return np.asarray(1 + 3 * points)


def n_auxiliary(problem: LimitProblem, *, biaxial: bool) -> int:
    """Number of auxiliary variables, which stand after the contact forces."""
    return (4 if biaxial else 1) * len(problem.rectangles)


def no_tension(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """``n_k ≥ −f_t A_k``."""
    n = normal_force(np.arange(problem.n_points))
    return ConstraintRows(_matrix(n_columns, (n, -1.0)), problem.tension)


def cells(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """``n_k ≤ f_c A_k`` at the cells of interfaces that crush."""
    k = np.flatnonzero(np.isfinite(problem.compression))
    return ConstraintRows(_matrix(n_columns, (normal_force(k), 1.0)), problem.compression[k])


def ties(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """``0 ≤ T'``, ``T' ≤ T_y − T0`` where it is limited, and changes within the bond; T' in the last columns.

    Large limits are in units of their own, so that one stands for all sizes of ties.
    """
    own = problem.ties
    limited = np.isfinite(own.capacity)
    scale, of_bond = np.maximum(own.capacity[limited], 1.0), np.maximum(own.bond, 1.0)
    upper = sp.diags_array(np.ones(len(own))).tocsr()[limited]
    bond = sp.diags_array(1 / of_bond) @ own.bond_rows
    G = sp.vstack([-sp.eye_array(len(own)), sp.diags_array(1 / scale) @ upper, bond, -bond], format="csr")
    before = sp.csr_array((G.shape[0], n_columns - len(own)))
    h = [np.zeros(len(own)), own.capacity[limited] / scale, own.bond / of_bond, own.bond / of_bond]
    return ConstraintRows(sp.csr_array(sp.hstack([before, G])), np.concatenate(h))


def linearised_edges(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """``n_e ≥ slope N − offset`` at the four edges of each rectangle; the step gives slope and offset."""
    corners = np.repeat(normal_force(problem.rectangles), 4, axis=0)
    return ConstraintRows(_matrix(n_columns, *((column, 1.0) for column in corners.T)), np.zeros(len(corners)))


def sliding(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """``‖(s_k, t_k)‖ ≤ bound_k + slope_k n_k``; the step gives bound and slope."""
    force = 1 + np.arange(3 * problem.n_points)
    return ConstraintRows(_matrix(n_columns, (force, -1.0)), np.zeros(len(force)))


def torsion(problem: LimitProblem, n_columns: int, first: int) -> ConstraintRows:
    """``‖(V_s, V_t, T / r̄)‖ ≤ Σ (bound_k + slope_k n_k)`` of each interface of uniform torsion; the step gives both.

    As two cones of three dimensions with the auxiliary q, of which ``first`` is the first column: ``‖(V_s, V_t)‖ ≤ q``
    and ``‖(q, T / r̄)‖ ≤ Σ (bound_k + slope_k n_k)``.
    """
    own = problem.torsion
    q, number = first + np.arange(len(own)), np.arange(len(own))
    n, (x, y) = normal_force(own.point), own.place.T

    def rows(*terms: tuple[Index, Index, Array]) -> ConstraintRows:
        row, column, value = (np.concatenate(part) for part in zip(*terms, strict=True))
        G = sp.csr_array((value, (row, column)), shape=(len(own), n_columns))
        return ConstraintRows(G, np.zeros(len(own)))

    one, of_points = np.ones(len(own)), np.ones(len(n))
    return _joined(
        _cones(rows((number, q, -one)), rows((own.owner, n + 1, -of_points)), rows((own.owner, n + 2, -of_points))),
        _cones(
            rows((own.owner, n, -of_points)),
            rows((number, q, -one)),
            rows((own.owner, n + 2, -x), (own.owner, n + 1, y)),
        ),
    )


def strips(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """``N² ≤ 2 F b n_e`` at the four edges of each rectangle, as ``‖(b n_e − 1, √(2 / F) N)‖ ≤ b n_e + 1``.

    A step gives the share b. Measured: one cone for all four edges, with an auxiliary variable, takes splitting two to
    five times the iterations, and it drifts in long steps.
    """
    of_edge = normal_force(problem.rectangles[:, EDGES]).reshape(-1, 2).T
    corners = np.repeat(normal_force(problem.rectangles), 4, axis=0).T
    scale, one = np.repeat(np.sqrt(2 / problem.capacity), 4), np.ones(4 * len(problem.rectangles))
    n_e = _matrix(n_columns, *((column, -1.0) for column in of_edge))
    N = _matrix(n_columns, *((column, -scale) for column in corners))
    rows = _cones(ConstraintRows(n_e, one), ConstraintRows(n_e, -one), ConstraintRows(N, 0 * one))
    return _beyond_tension(problem, rows)


def edges(problem: LimitProblem, n_columns: int, *, biaxial: bool) -> ConstraintRows:
    """``n_e ≥ m`` at the four edges of each rectangle; of the biaxial interaction ``m1`` and ``m2`` in turn."""
    R = len(problem.rectangles)
    of_edge = R * np.array([0, 1, 0, 1] if biaxial else [0, 0, 0, 0])
    m = 1 + 3 * problem.n_points + np.add.outer(np.arange(R), of_edge).ravel()
    n_e = [(column, -1.0) for column in normal_force(problem.rectangles)[:, EDGES].reshape(-1, 2).T]
    return _beyond_tension(problem, ConstraintRows(_matrix(n_columns, (m, 1.0), *n_e), np.zeros(len(m))))


def crushing(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """``N² ≤ 2 F m`` for the auxiliary m of each rectangle, as ``‖(m − 1, √(2/F) N)‖ ≤ m + 1``.

    With :func:`edges` that is ``n_e ≥ N² / (2 F)`` by one cone.
    """
    m = 1 + 3 * problem.n_points + np.arange(len(problem.rectangles))
    scale, one = np.sqrt(2 / problem.capacity), np.ones(len(m))
    N = [(column, -scale) for column in normal_force(problem.rectangles).T]
    rows = _cones(
        ConstraintRows(_matrix(n_columns, (m, -1.0)), one),
        ConstraintRows(_matrix(n_columns, (m, -1.0)), -one),
        ConstraintRows(_matrix(n_columns, *N), 0 * one),
    )
    return _beyond_tension(problem, rows)


def biaxial_crushing(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """``N³ ≤ 4 F m1 m2`` for the auxiliaries of each rectangle: with :func:`edges`, ``N³ ≤ 4 F n_e n_f``.

    The condition is a power cone. With ``q² ≤ c N``, ``p² ≤ m1 m2`` and ``N² ≤ p q √(4 F / c)`` it is three
    second-order cones, which every conic solver has: ``N⁴ ≤ 4 F p² q² / c ≤ 4 F m1 m2 N``. With ``c = √F = F / c`` they
    lose as few digits of a small N as of a large one: with c = 1 a block whose dead loads cancel was left without a
    certificate.
    """
    R = len(problem.rectangles)
    m1, m2, p, q = 1 + 3 * problem.n_points + np.arange(4 * R).reshape(4, R)
    N = normal_force(problem.rectangles).T
    c = np.sqrt(problem.capacity)

    def rows(h: Array, *terms: tuple[Index, float | Array]) -> ConstraintRows:
        return ConstraintRows(_matrix(n_columns, *terms), h)

    none, (once, scaled) = 0 * c, ([(column, value) for column in N] for value in (-1.0, -2 * (4 * c) ** -0.25))
    cones = _joined(
        _cones(rows(c, *once), rows(-c, *once), rows(none, (q, -2.0))),
        _cones(rows(none, (m1, -1.0), (m2, -1.0)), rows(none, (m1, -1.0), (m2, 1.0)), rows(none, (p, -2.0))),
        _cones(rows(none, (p, -1.0), (q, -1.0)), rows(none, (p, -1.0), (q, 1.0)), rows(none, *scaled)),
    )
    return _beyond_tension(problem, cones)


def _beyond_tension(problem: LimitProblem, rows: ConstraintRows) -> ConstraintRows:
    """Conditions of the forces of corners beyond their tensile strength, ``n_k + f_t A_k``, as rows of n_k."""
    y = np.zeros(rows.G.shape[1])
    y[normal_force(problem.rectangles)] = problem.tension[problem.rectangles]
    return ConstraintRows(rows.G, rows.h - rows.G @ y)


def _matrix(n_columns: int, *terms: tuple[Index, float | Array]) -> sp.csr_array:
    """Matrix whose row i holds, for every term, its value i in its column i."""
    m = len(terms[0][0])
    rows = np.tile(np.arange(m), len(terms))
    columns = np.concatenate([column for column, _ in terms])
    values = np.concatenate([np.broadcast_to(value, m) for _, value in terms])
    return sp.csr_array((values, (rows, columns)), shape=(m, n_columns))


def _cones(*parts: ConstraintRows) -> ConstraintRows:
    """ConstraintRows of three-dimensional cones: row i of every part makes cone i."""
    m = len(parts[0])
    order = np.arange(3 * m).reshape(3, m).T.ravel()
    joined = _joined(*parts)
    return ConstraintRows(joined.G[order], joined.h[order])


def _joined(*parts: ConstraintRows) -> ConstraintRows:
    return ConstraintRows(sp.vstack([p.G for p in parts], format="csr"), np.concatenate([p.h for p in parts]))
