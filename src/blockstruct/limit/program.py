"""The conic program of a limit problem, and what a solver gives and takes."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit import conditions
from blockstruct.limit.crushing import EDGE_OF_CORNER, EDGES, Linearisation
from blockstruct.limit.friction import Sliding
from blockstruct.limit.problem import LimitProblem, total
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.vocabulary import SolverStatus

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class ProgramData:
    """The numbers of one program of a fixed pattern: values of G, right-hand side h, objective q."""

    G: Array
    h: Array
    q: Array


@dataclass(frozen=True, slots=True)
class Objective:
    """Maximise ``weight α − shift·n − price·T'`` instead of α; ``shift`` is (K,), ``price`` (M,) or 0."""

    shift: Array
    weight: float = 1.0
    price: Array | float = 0.0


@dataclass(frozen=True, slots=True)
class Solution:
    """What a solver says of one program.

    Attributes
    ----------
    status : SolverStatus
    y, z : arrays
        Variables, and multipliers of the rows.
    iterations, time
        Interior-point iterations and seconds.
    """

    status: SolverStatus
    y: Array
    z: Array
    iterations: int
    time: float


class Solver(Protocol):
    """Solves programs of one pattern after another."""

    def solve(self, program: "ConicProgram", data: ProgramData, tolerance: float) -> Solution:
        """Minimise ``q·y`` subject to ``h − G y`` in the cones of the program, to a feasibility and duality gap."""


class ConicProgram:
    """Maximise α subject to equilibrium and the failure conditions: minimise ``q·y``, ``h − G y ∈ cones``.

    The variables are ``y = (κ α, n_1, s_1, t_1, …)`` with κ the mean variable wrench, so that a multiple of the
    variable load gives the same program, then the auxiliary ones of exact crushing and of torsion, and then the
    forces T' of ties beyond their prestress. The rows are, in this order, the equilibrium of the free blocks (zero
    cone); an upper limit of α, the limits of tension, of cells, of ties and of linearised crushing (nonnegative cone);
    three rows of each contact point and of each cone of crushing and of torsion (second-order cones). The pattern
    never changes; :meth:`data` gives the values of a step.

    The objective is α times the total variable load, which makes the multipliers of equilibrium, the
    velocities, of order one: without it an interior-point solver stops percents short on thousands of blocks.

    Parameters
    ----------
    problem
        Equilibrium and strength.
    settings
        How crushing enters the program.
    frozen
        Whether rectangles with biaxial interaction are strips of a length that a step gives.
    exact
        Whether they are inside the effective rectangle.
    """

    def __init__(
        self, problem: LimitProblem, settings: ProcedureSettings, *, frozen: bool = False, exact: bool = True
    ) -> None:
        self.problem = problem
        self.is_linearised = settings.crushing != "conic" and len(problem.rectangles) > 0
        biaxial = settings.crushing_interaction == "biaxial" and len(problem.rectangles) > 0
        #: Whether a step gives the length over which rectangles bear.
        self.is_frozen = frozen and biaxial
        of_cones = len(problem.rectangles) > 0 and not self.is_linearised and (exact or not biaxial)
        equilibrium = problem.A.shape[0]
        self.total = total(problem.w_L)
        self.unit = self.total / (equilibrium // 6)

        of_crushing = conditions.n_auxiliary(problem, biaxial=biaxial) if of_cones else 0
        n_auxiliary = of_crushing + len(problem.torsion)
        n_columns = 1 + 3 * problem.n_points + n_auxiliary + len(problem.ties)
        load, auxiliary = sp.csr_array(problem.w_L[:, None] / self.unit), sp.csr_array((equilibrium, n_auxiliary))
        wrenches = [load, problem.A, auxiliary, problem.ties.columns]
        balance = conditions.ConstraintRows(sp.hstack(wrenches, format="csr"), -problem.w_D)
        limit = conditions.ConstraintRows(sp.csr_array(([1.0], ([0], [0])), shape=(1, n_columns)), np.ones(1))
        linear = [limit, conditions.no_tension(problem, n_columns), conditions.cells(problem, n_columns)]
        #: Where the rows ``0 ≤ T'`` stand among those of the nonnegative cone, and T' among the variables.
        self.slack_rows = slice(sum(map(len, linear)), sum(map(len, linear)) + len(problem.ties))
        self.tie_columns = slice(n_columns - len(problem.ties), n_columns)
        if len(problem.ties):
            linear.append(conditions.ties(problem, n_columns))
        cones = [conditions.sliding(problem, n_columns)]
        if self.is_linearised:
            linear.append(conditions.linearised_edges(problem, n_columns))
        if self.is_frozen:
            cones.append(conditions.strips(problem, n_columns))
        if of_cones:
            linear.append(conditions.edges(problem, n_columns, biaxial=biaxial))
            of_rectangles = conditions.biaxial_crushing if biaxial else conditions.crushing
            cones.append(of_rectangles(problem, n_columns))
        of_points = sum(map(len, cones))
        if len(problem.torsion):
            cones.append(conditions.torsion(problem, n_columns, 1 + 3 * problem.n_points + of_crushing))

        parts = [part for part in (balance, *linear, *cones) if len(part)]
        G = sp.vstack([p.G for p in parts], format="csc")
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
        # The second cones of the interfaces of uniform torsion stand last.
        self._torsion_rows = first + of_points + 3 * (len(problem.torsion) + np.arange(len(problem.torsion)))
        of_torsion = self._torsion_rows[problem.torsion.owner]
        self._torsion_entries = _position(G, of_torsion, conditions.normal_force(problem.torsion.point))
        if self.is_frozen:
            # The first two rows of the cone of each edge hold its normal force.
            strips = first + 3 * (problem.n_points + np.arange(4 * len(problem.rectangles)))
            self._strip_rows = np.stack([strips, strips + 1], axis=1)
            of_edge = conditions.normal_force(problem.rectangles[:, EDGES]).reshape(-1, 1, 2)
            rows, columns = np.broadcast_arrays(self._strip_rows[:, :, None], of_edge)
            self._strip_entries = _position(G, rows.ravel(), columns.ravel()).reshape(rows.shape)
        self._edge_rows = np.arange(first - 4 * len(problem.rectangles), first)
        if self.is_linearised:
            corners = np.repeat(conditions.normal_force(problem.rectangles), 4, axis=0)
            self._edge_entries = _position(G, np.repeat(self._edge_rows, 4), corners.ravel()).reshape(-1, 4)

    def data(
        self,
        sliding: Sliding,
        *,
        linearisation: Linearisation | None = None,
        bearing: Array | None = None,
        objective: Objective | None = None,
        max_load_factor: float | None = None,
        loaded: bool = True,
    ) -> ProgramData:
        """Values of one step.

        Parameters
        ----------
        sliding
            Sliding condition of each contact point.
        linearisation
            Where crushing is linearised, if it is; at the full strength by default.
        bearing : (R, 2) array
            Share of their length over which rectangles bear, if it is frozen; the whole length by default.
        objective
            α by default.
        max_load_factor
            Upper limit of α.
        loaded
            Whether α loads the blocks. Where it does not, it stands alone and ends at its upper limit.
        """
        G, h = self.G.data.copy(), self._h.copy()
        G[self._slope_entries] = -sliding.slope
        h[self._bound_rows] = sliding.bound
        G[self._torsion_entries] = -sliding.slope[self.problem.torsion.point]
        h[self._torsion_rows] = self.problem.torsion.total(sliding.bound)
        if not loaded:
            G[: self.G.indptr[1]] = 0.0
        # Without a limit its row reads 0 α ≤ 1: the entry stays in the pattern.
        G[self._limit_entry] = 0.0 if max_load_factor is None else 1.0
        h[self._limit_row] = 1.0 if max_load_factor is None else max_load_factor * self.unit
        if self.is_linearised:
            slope, offset = (linearisation or Linearisation.first(self.problem)).lines(self.problem.capacity)
            # −n_e + slope N ≤ offset of forces beyond the tensile strength, on the corners of edge e in turn.
            G[self._edge_entries] = np.repeat(slope, 4)[:, None] - np.tile(EDGE_OF_CORNER, (len(slope), 1))
            pulled = np.repeat(self.problem.tension[self.problem.rectangles], 4, axis=0)
            h[self._edge_rows] = np.repeat(offset, 4) - (G[self._edge_entries] * pulled).sum(axis=1)
        if self.is_frozen and bearing is not None:
            # (b n_e + 1, b n_e − 1) of forces beyond the tensile strength.
            share = np.tile(bearing, 2).reshape(-1, 1)
            pulled = self.problem.tension[self.problem.rectangles[:, EDGES]].sum(axis=2).reshape(-1, 1)
            G[self._strip_entries] = -share[:, :, None]
            h[self._strip_rows] = share * pulled + [1.0, -1.0]
        q = np.zeros(self.G.shape[1])
        q[0] = -self.total / self.unit
        if objective is not None:
            q[0] *= objective.weight
            q[1 : 1 + 3 * self.problem.n_points : 3] = self.total * objective.shift
            q[self.tie_columns] = self.total * objective.price
        return ProgramData(G, h, q)

    def tie_force(self, solution: Solution) -> Array:
        """Forces T of ties with their prestress, (M,)."""
        return np.asarray(solution.y[self.tie_columns] + self.problem.ties.prestress(solution.y[0] / self.unit))

    def unpack(self, solution: Solution) -> tuple[float, Array, Array]:
        """Load factor α, contact forces x (K, 3) and velocities u (6 F,) with ``w_L·u = 1``."""
        return (
            float(solution.y[0]) / self.unit,
            solution.y[1 : 1 + 3 * self.problem.n_points].reshape(-1, 3),
            solution.z[: self.zero_rows] / self.total,
        )


def _position(G: sp.csc_array, rows: Index, columns: Index) -> Index:
    """Where the entries (row, column) stand in the data of a sorted csc array."""
    keys = np.repeat(np.arange(G.shape[1]), np.diff(G.indptr)).astype(np.int64) * G.shape[0] + G.indices
    return np.asarray(np.searchsorted(keys, columns.astype(np.int64) * G.shape[0] + rows))
