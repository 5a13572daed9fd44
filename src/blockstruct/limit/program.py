"""Assemble the conic program of a limit problem for a solver."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import Array, Index
from blockstruct.limit import conditions
from blockstruct.limit.crushing import TANGENTS, Linearisation
from blockstruct.limit.friction import Sliding
from blockstruct.limit.problem import LimitProblem, total
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.vocabulary import SolverStatus


@dataclass(frozen=True, slots=True)
class ProgramData:
    """Numbers of one program: values of G, right-hand side h, objective q.

    The sparsity pattern of G is fixed.
    """

    G: Array
    h: Array
    q: Array


@dataclass(frozen=True, slots=True)
class Objective:
    """Objective ``weight α − shift·n − price·T'`` to maximise instead of α.

    ``shift`` is (K,), and ``price`` is (M,) or 0.
    """

    shift: Array
    weight: float = 1.0
    price: Array | float = 0.0


@dataclass(frozen=True, slots=True)
class Solution:
    """Result of a solver for one program.

    Attributes
    ----------
    status : SolverStatus
    y, z : arrays
        Variables y, and multipliers z of the rows.
    iterations, time
        Number of interior-point iterations, and time in s.
    """

    status: SolverStatus
    y: Array
    z: Array
    iterations: int
    time: float


class Solver(Protocol):
    """Solves a sequence of programs with the same sparsity pattern."""

    def solve(self, program: "ConicProgram", data: ProgramData, tolerance: float) -> Solution:
        """Minimise ``q·y`` subject to ``h − G y`` in the cones of the program.

        ``tolerance`` applies to feasibility and to the duality gap.
        """


class ConicProgram:
    """Program that maximises α subject to equilibrium and failure conditions.

    In standard form it minimises ``q·y`` subject to ``h − G y ∈ cones``.

    The variables come in this order:

    - ``y = (κ α, n_1, s_1, t_1, …)`` with κ the mean variable wrench, so that a multiple of the variable load gives the
      same program;
    - the auxiliary variables of crushing and of torsion;
    - the forces T' of ties beyond their prestress;
    - the forces of springs.

    The rows come in this order:

    - zero cone: equilibrium of the free blocks;
    - nonnegative cone: upper limit of α, limits of tension, of cells and of ties, edges and tangents of crushing;
    - second-order cones: three rows for each contact point and for each cone of crushing and of torsion.

    The sparsity pattern never changes. :meth:`data` returns the values of a step.

    The objective is α times the total variable load. This factor makes the velocities, the multipliers of equilibrium,
    of order one. Without it an interior-point solver stops several percent too low on thousands of blocks.

    Parameters
    ----------
    problem
        Equilibrium and strength.
    settings
        Settings that choose the form of crushing in the program.
    springs : (6 F, S) sparse array
        Columns b_s of forces f_s that cost ``f_s² / 2`` in units of the objective. At velocities u the cost is
        ``total² Σ (b_s·u)² / 2`` by duality. None by default.
    """

    def __init__(self, problem: LimitProblem, settings: ProcedureSettings, springs: sp.csc_array | None = None) -> None:
        self.problem = problem
        self.is_linearised = settings.crushing != "conic" and len(problem.rectangles) > 0
        biaxial = settings.crushing_interaction == "biaxial"
        equilibrium = problem.A.shape[0]
        self.total = total(problem.w_L)
        self.unit = self.total / (equilibrium // 6)

        of_crushing = conditions.n_auxiliary(problem, biaxial=biaxial)
        n_auxiliary = of_crushing + len(problem.torsion)
        n_columns = 1 + 3 * problem.n_points + n_auxiliary + len(problem.ties)
        load, auxiliary = sp.csr_array(problem.w_L[:, None] / self.unit), sp.csr_array((equilibrium, n_auxiliary))
        wrenches = [load, problem.A, auxiliary, problem.ties.columns]
        balance = conditions.ConstraintRows(sp.hstack(wrenches, format="csr"), -problem.w_D)
        limit = conditions.ConstraintRows(sp.csr_array(([1.0], ([0], [0])), shape=(1, n_columns)), np.ones(1))
        linear = [limit, conditions.no_tension(problem, n_columns), conditions.cells(problem, n_columns)]
        #: Positions of the rows ``0 ≤ T'`` in the nonnegative cone, and of T' among the variables.
        self.slack_rows = slice(sum(map(len, linear)), sum(map(len, linear)) + len(problem.ties))
        self.tie_columns = slice(n_columns - len(problem.ties), n_columns)
        if len(problem.ties):
            linear.append(conditions.ties(problem, n_columns))
        cones = [conditions.sliding(problem, n_columns)]
        if len(problem.rectangles):
            linear.append(conditions.edges(problem, n_columns, biaxial=biaxial))
        if self.is_linearised:
            linear.append(conditions.tangents(problem, n_columns))
        elif len(problem.rectangles):
            of_rectangles = conditions.biaxial_crushing if biaxial else conditions.crushing
            cones.append(of_rectangles(problem, n_columns))
        of_points = sum(map(len, cones))
        if len(problem.torsion):
            cones.append(conditions.torsion(problem, n_columns, 1 + 3 * problem.n_points + of_crushing))

        parts = [part for part in (balance, *linear, *cones) if len(part)]
        G = sp.vstack([p.G for p in parts], format="csc")
        #: Cost of each variable, for half of its square.
        self.cost = np.zeros(n_columns)
        if springs is not None:
            G = sp.hstack([G, sp.vstack([springs, sp.csc_array((G.shape[0] - equilibrium, springs.shape[1]))])], "csc")
            self.cost = np.append(self.cost, np.ones(springs.shape[1]))
        G.sort_indices()
        self.G: sp.csc_array = G
        self._h = np.concatenate([p.h for p in parts])
        self.zero_rows = equilibrium
        self.nonnegative_rows = sum(map(len, linear))
        self.cones = sum(map(len, cones)) // 3

        first = self.zero_rows + self.nonnegative_rows
        self._bound_rows = first + 3 * np.arange(problem.n_points)
        self._limit_row = equilibrium
        self._limit_entry = _position(G, np.array([equilibrium]), np.array([0]))
        points = np.arange(problem.n_points)
        self._slope_entries = _position(G, self._bound_rows, conditions.normal_force(points))
        # The second cones of the interfaces of uniform torsion come last.
        self._torsion_rows = first + of_points + 3 * (len(problem.torsion) + np.arange(len(problem.torsion)))
        of_torsion = self._torsion_rows[problem.torsion.owner]
        self._torsion_entries = _position(G, of_torsion, conditions.normal_force(problem.torsion.point))
        if self.is_linearised:
            self._tangent_rows = np.arange(first - TANGENTS * len(problem.rectangles), first)
            corners = np.repeat(conditions.normal_force(problem.rectangles), TANGENTS, axis=0)
            rows = np.repeat(self._tangent_rows, 4)
            self._tangent_entries = _position(G, rows, corners.ravel()).reshape(-1, 4)

    def data(
        self,
        sliding: Sliding,
        *,
        linearisation: Linearisation | None = None,
        objective: Objective | None = None,
        max_load_factor: float | None = None,
        loaded: bool = True,
    ) -> ProgramData:
        """Return the values of one step.

        Parameters
        ----------
        sliding
            Sliding condition of each contact point.
        linearisation
            Tangents of linearised crushing; at the full strength by default.
        objective
            Objective to maximise; α by default.
        max_load_factor
            Upper limit of α; no limit by default.
        loaded
            Whether α loads the blocks. Without load, α is independent of all other variables and reaches its limit.
        """
        G, h = self.G.data.copy(), self._h.copy()
        G[self._slope_entries] = -sliding.slope
        # The limited shear forces of joints that never slide are redundant: any bound is correct.
        h[self._bound_rows] = np.where(self.problem.never_slides, 1.0, sliding.bound)
        G[self._torsion_entries] = -sliding.slope[self.problem.torsion.point]
        h[self._torsion_rows] = self.problem.torsion.total(sliding.bound)
        if not loaded:
            G[: self.G.indptr[1]] = 0.0
        # Without a limit the row is 0 α ≤ 1, so that its entry stays in the pattern.
        G[self._limit_entry] = 0.0 if max_load_factor is None else 1.0
        h[self._limit_row] = 1.0 if max_load_factor is None else max_load_factor * self.unit
        if self.is_linearised:
            slope, offset = (linearisation or Linearisation.first(self.problem)).lines(self.problem.capacity)
            # Two corners of a rectangle may have the same contact point, in one half of a structure.
            G[self._tangent_entries] = 0.0
            np.add.at(G, self._tangent_entries, slope.reshape(-1, 1))
            # N includes the tensile strength of the corners.
            pulled = self.problem.tension[self.problem.rectangles].sum(axis=1)
            h[self._tangent_rows] = (offset - slope * pulled[:, None]).ravel()
        q = np.zeros(self.G.shape[1])
        q[0] = -self.total / self.unit
        if objective is not None:
            q[0] *= objective.weight
            q[1 : 1 + 3 * self.problem.n_points : 3] = self.total * objective.shift
            q[self.tie_columns] = self.total * objective.price
        return ProgramData(G, h, q)

    def tie_force(self, solution: Solution) -> Array:
        """Return the forces T (M,) of ties, including prestress."""
        return np.asarray(solution.y[self.tie_columns] + self.problem.ties.prestress(solution.y[0] / self.unit))

    def unpack(self, solution: Solution) -> tuple[float, Array, Array]:
        """Return load factor, contact forces and velocities.

        They are α, x (K, 3), and u (6 F,) with ``w_L·u = 1``.
        """
        return (
            float(solution.y[0]) / self.unit,
            solution.y[1 : 1 + 3 * self.problem.n_points].reshape(-1, 3),
            np.where(self.problem.idle, 0.0, solution.z[: self.zero_rows] / self.total),
        )


def _position(G: sp.csc_array, rows: Index, columns: Index) -> Index:
    """Return the positions of entries in the data of a sorted csc array."""
    keys = np.repeat(np.arange(G.shape[1]), np.diff(G.indptr)).astype(np.int64) * G.shape[0] + G.indices
    return np.asarray(np.searchsorted(keys, columns.astype(np.int64) * G.shape[0] + rows))
