"""Assemble the failure conditions as rows of a conic program.

The rows are ``h − G y ∈ cone`` for the variables ``y = (κ α, n_1, s_1, t_1, …)``. The conditions are equations (4) to
(11) of docs/theory.md.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import Array, Index
from blockstruct.limit.crushing import EDGES, TANGENTS
from blockstruct.limit.problem import LimitProblem


@dataclass(frozen=True, slots=True)
class ConstraintRows:
    """Constraint rows of a program: sparse G and right-hand side h."""

    G: sp.csr_array
    h: Array

    def __len__(self) -> int:
        return len(self.h)


def normal_force(points: Index) -> Index:
    """Return the columns of the normal forces of contact points."""
    return np.asarray(1 + 3 * points)


def n_auxiliary(problem: LimitProblem, *, biaxial: bool) -> int:
    """Return the number of auxiliary variables of crushing.

    Their columns follow the contact forces.
    """
    return (4 if biaxial else 1) * len(problem.rectangles)


def no_tension(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """Return the rows of ``n_k ≥ −f_t A_k``."""
    n = normal_force(np.arange(problem.n_points))
    return ConstraintRows(_matrix(n_columns, (n, -1.0)), problem.tension)


def cells(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """Return the rows of ``n_k ≤ f_c A_k`` at cells that crush."""
    k = np.flatnonzero(np.isfinite(problem.compression))
    return ConstraintRows(_matrix(n_columns, (normal_force(k), 1.0)), problem.compression[k])


def ties(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """Return the rows of the limits of ties, with T' in the last columns.

    The conditions are ``0 ≤ T'``, ``T' ≤ T_y − T0`` if this limit is finite, and force changes within the bond. Rows
    with a limit above one are divided by this limit, so that ties of all sizes have similar rows.
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


def tangents(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """Return the rows of ``slope N − offset ≤ m`` of each rectangle.

    m is an auxiliary variable. Each step sets slopes and offsets. Together with :func:`edges` the condition is
    ``n_e ≥ slope N − offset``.
    """
    corners = np.repeat(normal_force(problem.rectangles), TANGENTS, axis=0)
    m = 1 + 3 * problem.n_points + np.repeat(np.arange(len(problem.rectangles)), TANGENTS)
    return ConstraintRows(_matrix(n_columns, (m, -1.0), *((column, 1.0) for column in corners.T)), np.zeros(len(m)))


def sliding(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """Return the cones ``‖(s_k, t_k)‖ ≤ bound_k + slope_k n_k``.

    Each step sets bound and slope. Unlimited shear forces have zeros in these rows. By duality, there is no slip along
    these forces.
    """
    force = 1 + np.arange(3 * problem.n_points)
    limited = np.full(len(force), -1.0)
    limited[problem.free_shear] = 0.0
    return ConstraintRows(_matrix(n_columns, (force, limited)), np.zeros(len(force)))


def torsion(problem: LimitProblem, n_columns: int, first: int) -> ConstraintRows:
    """Return the cones of each interface of uniform torsion.

    The condition is ``‖(V_s, V_t, T / r̄)‖ ≤ Σ (bound_k + slope_k n_k)``. Each step sets bound and slope. An auxiliary
    variable q splits it into two three-dimensional cones: ``‖(V_s, V_t)‖ ≤ q`` and
    ``‖(q, T / r̄)‖ ≤ Σ (bound_k + slope_k n_k)``. ``first`` is the first column of q.
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


def edges(problem: LimitProblem, n_columns: int, *, biaxial: bool) -> ConstraintRows:
    """Return the rows of ``n_e ≥ m`` at the four edges of each rectangle.

    With biaxial interaction, the edges have ``m1`` and ``m2`` alternately instead of m.
    """
    R = len(problem.rectangles)
    of_edge = R * np.array([0, 1, 0, 1] if biaxial else [0, 0, 0, 0])
    m = 1 + 3 * problem.n_points + np.add.outer(np.arange(R), of_edge).ravel()
    n_e = [(column, -1.0) for column in normal_force(problem.rectangles)[:, EDGES].reshape(-1, 2).T]
    return _beyond_tension(problem, ConstraintRows(_matrix(n_columns, (m, 1.0), *n_e), np.zeros(len(m))))


def crushing(problem: LimitProblem, n_columns: int) -> ConstraintRows:
    """Return the cones ``N² ≤ 2 F m`` of each rectangle.

    m is an auxiliary variable. The cone is ``‖(m − 1, √(2/F) N)‖ ≤ m + 1``. Together with :func:`edges` it gives
    ``n_e ≥ N² / (2 F)`` by one cone per rectangle.
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
    """Return the cones of ``N³ ≤ 4 F m1 m2`` of each rectangle.

    m1 and m2 are auxiliary variables. Together with :func:`edges` the condition is ``N³ ≤ 4 F n_e n_f``.

    The condition is a power cone. ``q² ≤ c N``, ``p² ≤ m1 m2`` and ``N² ≤ p q √(4 F / c)`` replace it by three
    second-order cones, which every conic solver has: ``N⁴ ≤ 4 F p² q² / c ≤ 4 F m1 m2 N``. ``c = √F = F / c`` keeps the
    relative accuracy of small and large N equal. With c = 1 a block whose dead loads cancel had no certificate.
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
    """Turn conditions on ``n_k + f_t A_k`` at corners into rows of n_k."""
    y = np.zeros(rows.G.shape[1])
    y[normal_force(problem.rectangles)] = problem.tension[problem.rectangles]
    return ConstraintRows(rows.G, rows.h - rows.G @ y)


def _matrix(n_columns: int, *terms: tuple[Index, float | Array]) -> sp.csr_array:
    """Return the matrix whose row i has value i of each term in column i."""
    m = len(terms[0][0])
    rows = np.tile(np.arange(m), len(terms))
    columns = np.concatenate([column for column, _ in terms])
    values = np.concatenate([np.broadcast_to(value, m) for _, value in terms])
    return sp.csr_array((values, (rows, columns)), shape=(m, n_columns))


def _cones(*parts: ConstraintRows) -> ConstraintRows:
    """Return rows of three-dimensional cones: row i of each part in cone i."""
    m = len(parts[0])
    order = np.arange(3 * m).reshape(3, m).T.ravel()
    joined = _joined(*parts)
    return ConstraintRows(joined.G[order], joined.h[order])


def _joined(*parts: ConstraintRows) -> ConstraintRows:
    return ConstraintRows(sp.vstack([p.G for p in parts], format="csr"), np.concatenate([p.h for p in parts]))
