"""Solve frictional contact over one step of displacement by splitting.

A step is (16) of docs/theory.md. The iteration alternates between the elastic structure and its contacts.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import ROUNDING, Array
from blockstruct.solvers.anderson import accelerate
from blockstruct.solvers.interior_point import ContactProblem, ContactState, Step
from blockstruct.solvers.interior_point.cones import ConeVector
from blockstruct.solvers.interior_point.schur import OPTIONS

#: Smaller numbers count as this share of a usual one: forces in a penalty or at the start of a search, relative to the
#: mean normal force; work of a state, relative to the first state.
LEAST = 0.05
#: Share of the change of normal forces and slip that friction and dilatancy follow in one iteration. Measured: with
#: 0.05 or 0.2 the forces of 2,430 blocks settle more slowly.
FOLLOWS = 0.1
#: Over-relaxation of forces (Boyd et al., section 3.4.3).
RELAXED = 1.5


@dataclass(frozen=True, slots=True)
class SplitSolution:
    """State with the errors of its step.

    Attributes
    ----------
    state : ContactState
        Its forces are in equilibrium.
    missed, changed, lag : float
        Relative norms. The first is the violation of the conditions, the second the change in the last iteration. The
        third is the distance of friction from the normal forces that it follows. The scale is the norm of all forces,
        or of the dead load if that is larger.
    iterations : int
        Number of iterations.
    """

    state: ContactState
    missed: float
    changed: float
    lag: float
    iterations: int

    @property
    def residual(self) -> float:
        """Return the largest of the three errors; NaN if one is NaN."""
        return float(np.max([self.missed, self.changed, self.lag]))


class Splitting:
    """Find x, u and α of a step to about three digits.

    The step is the one of :class:`~blockstruct.solvers.interior_point.ContactProblem`. The method uses alternating
    directions (S. Boyd, N. Parikh, E. Chu, B. Peleato, J. Eckstein, Foundations and Trends in Machine Learning 3 (2011)
    1–122, doi:10.1561/2200000016). Each iteration first solves the structure with elastic contacts. All iterations of a
    step share one factorisation. Each iteration then satisfies every condition separately, by projection.

    The resistance ``c A_k + μ n`` of a contact follows the normal forces of earlier iterations, smoothed. The opening
    ``tan ψ ‖w_t‖`` by which it dilates follows their slip, smoothed. The rest is convex.

    Measured: without smoothing, the forces of walls of 400 blocks oscillate for ever. The load factor of a wall of 21
    blocks depends by 9 % on the order of the blocks. With smoothing, the forces of walls of 2,400 blocks oscillate
    unless iterations are accelerated (:class:`~blockstruct.solvers.anderson.Anderson`).

    Parameters
    ----------
    contact
        Contacts and ties, and their compliance.
    """

    def __init__(self, contact: ContactProblem) -> None:
        self._contact, self._rows = contact, _Rows(contact)

    def start(self) -> ContactState:
        """Return a state without forces."""
        own = self._contact.conditions
        nothing = 0.0 * own.identity()
        return ContactState(np.zeros(own.size), nothing, nothing, np.zeros(self._contact.A.shape[0]), 0.0)

    def predicted(self, state: ContactState, ratio: float) -> ContactState:
        """Predict the start of a step if the last motion continues.

        ``ratio`` is the length of the step relative to the last.
        """
        line, K = ratio * state.z.line, self._contact.problem.n_points
        # The opening of contacts accumulates over all steps.
        opening, last = state.z.line[:K], (self._contact.AT @ state.u)[: 3 * K : 3]
        line[:K] = np.where(opening > 0, np.maximum(opening + ratio * last, 0.0), 0.0)
        return ContactState(state.x, state.y, ConeVector(ratio * state.z.soc, line), state.u, state.alpha)

    def solve(
        self, step: Step, guess: ContactState, *, penalty: float, tolerance: float, patience: int
    ) -> SplitSolution:
        """Solve a step.

        Parameters
        ----------
        step
            The step.
        guess
            State to begin with.
        penalty
            Factor on the compliance of each joint. The product is the displacement per unit of force by which a contact
            misses its conditions. A suitable value is the length of the step in elastic displacements.
        tolerance
            Tolerance of the residual.
        patience
            Number of iterations in which the residual must halve. If it does not, the method returns the state at that
            point.

        Raises
        ------
        RuntimeError
            If there are blocks that no contact holds.
        """
        alternation = _Alternation(self._contact, self._rows, step, guess, penalty)
        iterations, _ = accelerate(alternation, alternation.measure, tolerance=tolerance, patience=patience)
        return alternation.solution(iterations)


class _Rows:
    """Rows of the conditions in the order of the iteration, and their projection.

    The order is: half-lines, both directions of sliding, and the other cones. The first rows of sliding cones are
    resistances.

    Attributes
    ----------
    order : (R,) array
        Rows of a state in this order.
    discs : (D,) array
        Cones whose first row is a resistance: the cones of contact points, and the second cones of uniform torsion.
    dilates : bool
        Whether a disc dilates as it slips.
    E, offset : (R + D, X) sparse array and (R + D,) array
        Conditions in this order, then the resistance of each disc.
    ET : (X, R + D) sparse array
        Relative displacements for unit multipliers of the conditions, then for unit slips.
    """

    def __init__(self, contact: ContactProblem) -> None:
        own, points = contact.conditions, contact.problem.n_points
        lines, cones = len(own.offset.line), len(own.offset.soc)
        self._contact, self._lines = contact, lines
        self.discs = np.concatenate([np.arange(points), np.arange(cones - len(contact.problem.torsion), cones)])
        self._cones = np.setdiff1d(np.arange(cones), self.discs)
        first, others = lines + 3 * self.discs, lines + 3 * self._cones
        self.order = np.concatenate([np.arange(lines), first + 1, first + 2, (others[:, None] + np.arange(3)).ravel()])
        self._shear, self._after = slice(lines, lines + 2 * len(first)), slice(lines + 2 * len(first), len(self.order))
        dilates = sp.csc_array(own.F[first].T)
        dilates.eliminate_zeros()
        self.dilates = dilates.nnz > 0
        self._convex = np.ones(own.E.shape[0])
        self._convex[first] = 0.0
        outputs = np.concatenate([self.order, first])
        self.E, self.offset = sp.csr_array(own.E[outputs]), own.offset.rows[outputs]
        self.ET = sp.hstack([own.E[self.order].T, dilates], format="csr")
        self._members = [
            np.concatenate(
                [(lines + 3 * g.cones[:, :, None] + np.arange(3)).reshape(len(g.cones), -1), g.lines], axis=1
            )
            for g in own.groups
        ]
        # The last two auxiliary variables of the effective rectangle are not forces: one grows with the strength.
        rectangles, torsion = len(contact.problem.rectangles), len(contact.problem.torsion)
        self._is_force = np.ones(own.size, dtype=bool)
        self._is_force[3 * points + 2 * rectangles : contact.ties.start - torsion] = False
        self._soft = self._softness()

    def _softness(self) -> Array:
        """Return the compliance of every row in the row's own unit.

        Ties have no compliance and get the median of all joints.
        """
        E = sp.diags_array(self._convex) @ self._contact.conditions.E
        square = E.multiply(E)
        of_row: Array = np.asarray(square.sum(axis=1)).ravel()
        soft = square @ self._contact.compliance / np.maximum(of_row, 1e-300)
        soft, of_row = np.where(soft > 0, soft, 1.0), np.where(of_row > 0, of_row, 1.0)
        # A projection onto a cone needs the same unit in all its rows.
        for values in (soft, of_row):
            values[self._lines :] = np.repeat(values[self._lines :].reshape(-1, 3).max(axis=1), 3)
        return np.asarray(soft / of_row)

    def weights(self, x: Array) -> Array:
        """Return the weight of each row.

        The weight is the row's compliance, reduced if forces are large.
        """
        weights = self._soft.copy()
        mean = np.abs(x[: 3 * self._contact.problem.n_points : 3]).mean()
        if mean > 0:
            forces = np.where(self._is_force, np.abs(x), 0.0)
            for group, rows in zip(self._contact.conditions.groups, self._members, strict=True):
                force = forces[group.columns].max(axis=1)
                weights[rows] *= (mean / np.maximum(force, LEAST * mean))[:, None]
        return weights

    def inverse(self, weight: Array) -> sp.csr_array:
        """Return ``(C + Eᵀ P E)⁻¹``, a matrix of small blocks."""
        size, entries = self._contact.conditions.size, []
        for group, rows in zip(self._contact.conditions.groups, self._members, strict=True):
            H = np.einsum("gri,gr,grj->gij", group.E, (weight * self._convex)[rows], group.E)
            own = np.arange(H.shape[1])
            H[:, own, own] += self._contact.compliance[group.columns]
            i = np.broadcast_to(group.columns[:, :, None], H.shape)
            entries.append([part.ravel() for part in (np.linalg.inv(H), i, i.transpose(0, 2, 1))])
        values, i, j = (np.concatenate(part) for part in zip(*entries, strict=True))
        inverse = sp.csr_array((values, (i, j)), shape=(size, size))
        inverse.eliminate_zeros()
        return inverse

    def weighted(self, weight: Array) -> sp.csr_array:
        """Return ``ET`` with weights (R,) of the conditions."""
        ET = self.ET
        data = ET.data * np.concatenate([weight, np.ones(len(self.discs))])[ET.indices]
        return sp.csr_array((data, ET.indices, ET.indptr), shape=ET.shape)

    def projected(self, rows: Array, resistance: Array) -> Array:
        """Return the nearest rows that satisfy every condition separately."""
        nearest = np.empty_like(rows)
        np.maximum(rows[: self._lines], 0.0, out=nearest[: self._lines])
        share = resistance / np.maximum(self.slip(rows), 1e-300)
        np.multiply(self.shear(rows), np.minimum(share, 1.0, out=share), out=self.shear(nearest))
        if len(self._cones):
            others = ConeVector(rows[self._after].reshape(-1, 3), np.zeros(0))
            nearest[self._after] = others.clipped(0.0, np.inf).soc.ravel()
        return nearest

    def shear(self, rows: Array) -> Array:
        """Return a view of both directions of sliding, (2, D)."""
        return rows[self._shear].reshape(2, -1)

    def slip(self, rows: Array) -> Array:
        s, t = np.square(self.shear(rows))
        s += t
        return np.asarray(np.sqrt(s, out=s))

    def as_cones(self, rows: Array, first: Array) -> ConeVector:
        soc = np.empty((len(self.discs) + len(self._cones), 3))
        soc[self.discs] = np.column_stack([first, *self.shear(rows)])
        soc[self._cones] = rows[self._after].reshape(-1, 3)
        return ConeVector(soc, rows[: self._lines].copy())


class _Alternation:
    """Iteration of a step between the elastic structure and its contacts.

    Its point consists of the moved rows (the rows ``y`` of the contacts plus their scaled dual), the smoothed
    resistances, and the smoothed slip.

    Attributes
    ----------
    measure : (N,) array
        Weights of a change of the point in its norm, as in work. The slip has zero weight.
    """

    def __init__(self, contact: ContactProblem, rows: _Rows, step: Step, guess: ContactState, penalty: float) -> None:
        weights = penalty * rows.weights(guess.x)
        H, weight = rows.inverse(weights), weights[rows.order]
        self._rows, self._step, self._weight = rows, step, weight
        # Forces are linear in the targets of the conditions, the dilatant slip rates and the velocities. All three
        # are parts of one array of inputs.
        size, targets = len(weight), len(weight) + len(rows.discs)
        self._inputs = np.zeros(targets + contact.A.shape[0])
        self._targets, self._u = np.split(self._inputs, [targets])
        AH, weighted = contact.A @ H, rows.weighted(weight)
        self._of_targets, self._of_motion = H @ weighted, sp.csr_array(-AH.T)
        self._targets[:size] = weight * rows.offset[:size]
        self._at_rest = H @ (contact.compliance * step.reference - step.opening - rows.ET @ self._targets)
        self._outputs = sp.hstack([rows.E @ self._of_targets, rows.E @ self._of_motion], format="csr")
        self._outputs_at_rest = rows.E @ self._at_rest + rows.offset
        self._pulls, self._loads = AH @ weighted, contact.A @ self._at_rest + contact.problem.w_D
        stiffness = AH @ contact.AT
        if contact.problem.idle.any():
            stiffness = stiffness + contact.at_rest
        self._solve = factorised(sp.coo_array(stiffness))
        self._w_L, self._least = contact.problem.w_L, max(norm(contact.problem.w_D), 1e-300)
        self._push = self._solve(self._w_L)
        self._stiffness = dot(self._w_L, self._push)
        self._y, self._dual = guess.y.rows[rows.order], -guess.z.rows[rows.order] / weight
        self._point = np.concatenate([self._y + self._dual, guess.y.soc[rows.discs, 0], guess.z.soc[rows.discs, 0]])
        self._moved, self._resistance, self._slip = np.split(self._point, [size, targets])
        of_slip = np.zeros(len(rows.discs))
        self.measure = np.sqrt(np.concatenate([weight, of_slip + np.median(weight), of_slip]))

    @property
    def point(self) -> Array:
        return self._point.copy()

    def move(self, point: Array) -> None:
        rows = len(self._moved)
        np.maximum(point[rows:], 0.0, out=point[rows:])
        self._point[:] = point
        self._project()

    def advance(self) -> None:
        rows = len(self._y)
        np.subtract(self._y, self._dual, out=self._targets[:rows])
        self._targets[rows:] = self._slip
        b = self._pulls @ self._targets
        b += self._loads
        s = self._step.displacement
        self._alpha = 0.0 if s is None else (s - dot(self._push, b)) / self._stiffness
        b += self._alpha * self._w_L
        self._u[:] = self._solve(b)
        outputs = self._outputs @ self._inputs
        outputs += self._outputs_at_rest
        self._forces, self._wanted = outputs[:rows], outputs[rows:]
        np.maximum(self._wanted, 0.0, out=self._wanted)
        self._resistance += FOLLOWS * (self._wanted - self._resistance)
        np.add(self._dual, self._y, out=self._moved)
        self._moved += RELAXED * (self._forces - self._y)
        # Forces have local units and are near one. Adding and subtracting one turns tiny numbers, for which arithmetic
        # is slow, into zeros.
        self._moved += 1.0
        self._moved -= 1.0
        self._before = self._y
        self._project()
        if self._rows.dilates:
            self._slip += FOLLOWS * (self._rows.slip(-self._weight * self._dual) - self._slip)

    def _project(self) -> None:
        self._y = self._rows.projected(self._moved, self._resistance)
        np.subtract(self._moved, self._y, out=self._dual)

    def _errors(self) -> tuple[float, float, float]:
        # No forces are left if the load lifts everything.
        size, of_friction = (max(norm(v), self._least) for v in (self._y, self._resistance))
        missed, changed = norm(self._forces - self._y) / size, norm(self._y - self._before) / size
        return missed, changed, norm(self._wanted - self._resistance) / of_friction

    def residual(self) -> float:
        return float(np.max(self._errors()))

    def solution(self, iterations: int) -> SplitSolution:
        """Return the state after the last iteration."""
        rows, z = self._rows, -self._weight * self._dual
        x = self._at_rest + self._of_targets @ self._targets + self._of_motion @ self._u
        y, z_cones = rows.as_cones(self._y, self._resistance), rows.as_cones(z, rows.slip(z))
        return SplitSolution(ContactState(x, y, z_cones, self._u, float(self._alpha)), *self._errors(), iterations)


def factorised(M: sp.coo_array) -> Callable[[Array], Array]:
    """Return a function that solves with M.

    Without the noise between them, a wall pushed in its plane separates into two problems.
    """
    scale = np.sqrt(M.diagonal())
    i, j = M.coords
    # On walls pushed in their plane, rounding is up to 1e-10 of the diagonal, and no entries lie between that and 1e-8.
    kept = np.abs(M.data) > ROUNDING * scale[i] * scale[j]
    matrix = sp.csc_matrix((M.data[kept], (i[kept], j[kept])), shape=M.shape)
    lu = sp.linalg.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options=OPTIONS)
    return lambda b: np.asarray(lu.solve(b), dtype=float)


def dot(a: Array, b: Array) -> float:
    """Return the inner product without the threads of a BLAS.

    For vectors of this length, threads cost more time than they save.
    """
    return float(np.einsum("i,i->", a, b))


def norm(a: Array) -> float:
    """Return the Euclidean norm, like :func:`dot`."""
    return float(np.sqrt(dot(a, a)))
