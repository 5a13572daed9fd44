"""Split the failure conditions of a conic program into small groups.

The groups are dense and independent.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.arrays import Array, Index
from blockstruct.limit import ConicProgram, true_sliding
from blockstruct.limit.friction import Sliding
from blockstruct.solvers.interior_point.cones import ConeVector, Scaling


@dataclass(frozen=True, slots=True)
class Group:
    """Members of one shape, each with its own variables and conditions.

    A member is a contact point, a crushing rectangle, or a tie. A rectangle has four contact points and auxiliary
    variables.

    Attributes
    ----------
    columns : (G, d) array
        Variables of each member.
    cones, lines : (G, m), (G, l) arrays
        Cones and half-lines of each member.
    E, F : (G, 3 m + l, d) arrays
        Rows of the conditions on the forces, and of the flow rule; rows of cones come first.
    """

    columns: Index
    cones: Index
    lines: Index
    E: Array
    F: Array

    def weighted(self, square: tuple[Array, Array]) -> Array:
        """Return ``W⁻² E`` of each member, (G, 3 m + l, d)."""
        soc, line = square
        (members, m), d = self.cones.shape, self.columns.shape[1]
        of_cones = np.matmul(soc[self.cones], self.E[:, : 3 * m].reshape(members, m, 3, d))
        of_lines = line[self.lines][:, :, None] * self.E[:, 3 * m :]
        return np.concatenate([of_cones.reshape(members, 3 * m, d), of_lines], axis=1)


class Conditions:
    """Failure conditions ``y = E x + e ∈ K`` and flow rule ``Fᵀ z``.

    The variables x do not include α. With z in the dual cone and ``y ∘ z = 0``, Fᵀ z is the relative velocity at each
    contact point. Sliding is ``(c A_k + μ n, s, t) ⊥ (z_0, w_s, w_t)`` in the second-order cone. No tension is ``n +
    f_t A_k ⊥ ζ ≥ 0``. The opening is ``tan ψ z_0 + ζ``. So E and F differ in one coefficient, μ and tan ψ. The
    complementarity without dilatancy contains no norm. For ``tan ψ = μ`` it is the associative program.

    Parameters
    ----------
    program
        The program, with exact crushing.
    sliding
        Its sliding condition, Coulomb's by default.
    """

    def __init__(self, program: ConicProgram, sliding: Sliding | None = None) -> None:
        problem, first = program.problem, program.zero_rows + 1
        # A cone of zero friction has no interior.
        true = sliding or true_sliding(problem)
        friction = np.maximum(true.slope, 1e-6)
        forces = program.data(Sliding(true.bound, friction))
        flow = program.data(Sliding(true.bound, problem.dilatancy))
        E, F = (
            -sp.csc_array((d.G, program.G.indices, program.G.indptr), shape=program.G.shape)[first:, 1:]
            for d in (forces, flow)
        )
        self._lines = program.nonnegative_rows - 1
        self._cones = program.cones
        self.E, self.F = sp.csr_array(E), sp.csr_array(F)
        self._FT = sp.csr_array(F.T)
        self.offset = self._vector(forces.h[first:])
        self._friction, self._never_slides = friction, problem.never_slides
        self._bound = self.offset.soc[: len(friction), 0]
        self.size = self.E.shape[1]
        self.groups = _groups(self.E, self.F, self._lines)

    def identity(self) -> ConeVector:
        """Return the unit element of all cones."""
        return ConeVector.identity(self._cones, self._lines)

    def of_forces(self, x: Array) -> ConeVector:
        """Return ``E x``."""
        return self._vector(np.asarray(self.E @ x))

    def forces_of(self, y: ConeVector, x: Array) -> Array:
        """Return forces whose sliding cones are the first K cones of y.

        Forces without a sliding limit, and all other variables, come from x.
        """
        sliding = y.soc[: len(self._friction)]
        normal = (sliding[:, 0] - self._bound) / self._friction
        limited = np.column_stack([normal, sliding[:, 1:]])
        forces = np.where(self._never_slides[:, None], x[: limited.size].reshape(-1, 3), limited).ravel()
        return np.concatenate([forces, x[len(forces) :]])

    def flow(self, z: ConeVector) -> Array:
        """Return ``Fᵀ z``."""
        return np.asarray(self._FT @ z.rows)

    def weights(self, scaling: Scaling, compliance: Array) -> "Weights":
        """Return ``(C + Fᵀ W⁻² E)⁻¹``, member by member."""
        square = scaling.inverse_square()
        inverses = []
        for group in self.groups:
            H = np.matmul(group.F.transpose(0, 2, 1), group.weighted(square))
            own = np.arange(H.shape[1])
            H[:, own, own] += compliance[group.columns]
            # Not by cofactors: the weights of a degenerate contact differ by 1e10, and the small ones would be lost.
            inverses.append(np.asarray(np.linalg.inv(H)))
        return Weights(self, square, inverses)

    def _vector(self, rows: Array) -> ConeVector:
        return ConeVector(rows[self._lines :].reshape(-1, 3), rows[: self._lines])


@dataclass(frozen=True, slots=True)
class Weights:
    """Inverse matrices that eliminate the contacts from a Newton step."""

    conditions: Conditions
    square: tuple[Array, Array]
    inverses: list[Array]

    def solve(self, b: Array) -> Array:
        """Return ``(C + Fᵀ W⁻² E)⁻¹ b``."""
        x = np.empty_like(b)
        for group, inverse in zip(self.conditions.groups, self.inverses, strict=True):
            x[group.columns] = np.einsum("gij,gj->gi", inverse, b[group.columns])
        return x

    def times(self, a: ConeVector) -> ConeVector:
        """Return ``W⁻² a``."""
        soc, line = self.square
        return ConeVector(np.einsum("mij,mj->mi", soc, a.soc), line * a.line)


def _groups(E: sp.csr_array, F: sp.csr_array, lines: int) -> list[Group]:
    """Group the connected parts of E by shape."""
    # Loaded here: csgraph is slow to import.
    from scipy.sparse import csgraph

    entries = E.tocoo()
    i, j = entries.coords
    # The three rows of a cone belong together.
    whole = np.where(i < lines, i, lines + (i - lines) // 3)
    pattern = sp.csr_array((np.ones(len(i)), (whole, j)))
    count, of_column = csgraph.connected_components(pattern.T @ pattern, directed=False)
    of_row = np.empty(E.shape[0], dtype=int)
    of_row[i] = of_column[j]
    of_line, of_cone = of_row[:lines], of_row[lines::3]
    shape = np.column_stack([np.bincount(of, minlength=count) for of in (of_column, of_cone, of_line)])
    groups = []
    for d, m, n in np.unique(shape, axis=0):
        members = np.flatnonzero((shape == (d, m, n)).all(axis=1))
        number = np.full(count, -1)
        number[members] = np.arange(len(members))
        columns, cones, own_lines = (_listed(of, number) for of in (of_column, of_cone, of_line))
        local_column, local_row = np.zeros(len(of_column), dtype=int), np.zeros(len(of_row), dtype=int)
        local_column[columns] = np.arange(d)
        local_row[lines + 3 * cones[:, :, None] + np.arange(3)] = np.arange(3 * m).reshape(m, 3)
        local_row[own_lines] = 3 * m + np.arange(n)
        dense = []
        for matrix in (E.tocoo(), F.tocoo()):
            i, j = matrix.coords
            mine = number[of_row[i]] >= 0
            rows = np.zeros((len(members), 3 * m + n, d))
            rows[number[of_row[i[mine]]], local_row[i[mine]], local_column[j[mine]]] = matrix.data[mine]
            dense.append(rows)
        groups.append(Group(columns, cones, own_lines, *dense))
    return groups


def _listed(of: NDArray[Any], number: Index) -> Index:
    """Return the items of each member, (G, items per member)."""
    mine = np.flatnonzero(number[of] >= 0)
    order = mine[np.argsort(number[of[mine]], kind="stable")]
    return order.reshape(number.max() + 1, -1)
