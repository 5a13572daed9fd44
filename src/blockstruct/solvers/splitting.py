"""Frictional contact over one step of displacement: the elastic structure and its contacts in turn."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.solvers.anderson import Anderson
from blockstruct.solvers.interior_point import ContactProblem, ContactState, Step
from blockstruct.solvers.interior_point.cones import ConeVector
from blockstruct.solvers.interior_point.schur import OPTIONS

Array = NDArray[np.float64]

#: Smallest force that a penalty is made for, in mean normal forces.
LEAST_FORCE = 0.05
#: Share of the change of normal forces and of slip that friction and dilatancy follow in one iteration, once the
#: residual has stalled with all of it. Measured: with 0.03 or 0.2 the forces of 800 to 2,400 blocks settle more slowly.
FOLLOWS = 0.1
#: Iterations between two looks at the residual, each of which accelerates them, and changes remembered for that.
LOOK, MEMORY = 5, 20
#: Over-relaxation of forces (Boyd et al., section 3.4.3).
RELAXED = 1.5
#: Entries of the matrix that are rounding, relative to its diagonal. Measured on walls pushed in their plane: up to
#: 1e-10 of it, and nothing from there to 1e-8.
NOISE = 1e-9


@dataclass(frozen=True, slots=True)
class SplitSolution:
    """A state, and how far it is from solving its step.

    Attributes
    ----------
    state : ContactState
        Its forces are in equilibrium.
    missed, changed, lag : float
        Norms relative to that of all forces, or of the dead load where it is larger: by how much they miss their
        conditions, by how much the last iteration has changed them, and how far friction is from the normal forces
        that it follows.
    iterations : int
    """

    state: ContactState
    missed: float
    changed: float
    lag: float
    iterations: int

    @property
    def residual(self) -> float:
        """Largest of the three; NaN if one is."""
        return float(np.max([self.missed, self.changed, self.lag]))


class Splitting:
    """Finds x, u and α of a step of :class:`~blockstruct.solvers.interior_point.ContactProblem`, to three digits or so.

    Alternating directions (S. Boyd, N. Parikh, E. Chu, B. Peleato, J. Eckstein, Foundations and Trends in Machine
    Learning 3 (2011) 1–122, doi:10.1561/2200000016): the structure with elastic contacts, for which all iterations of
    a step share one factorisation; then every condition by itself, by projection. The resistance ``c A_k + μ n`` of a
    contact and the opening ``tan ψ ‖w_t‖`` by which it dilates follow normal forces and slip of the last iteration. The
    rest is convex. Iterations are accelerated (:class:`~blockstruct.solvers.anderson.Anderson`). Once a residual
    stalls, resistance and opening follow smoothed, in this step and all later ones. Measured: without smoothing, the
    forces of 800 blocks swing for ever. With it from the first step on, a dome of 60 blocks takes another state of
    equilibrium, 1.4 % above that of an independent solver.

    Parameters
    ----------
    contact
        Contacts and ties, and their compliance.
    """

    def __init__(self, contact: ContactProblem) -> None:
        own, points = contact.conditions, contact.problem.n_points
        lines, cones = len(own.offset.line), len(own.offset.soc)
        self._contact, self._points, self._lines = contact, points, lines
        # Cones whose first row is a resistance: those of contact points, and the second ones of uniform torsion.
        self._discs = np.concatenate([np.arange(points), np.arange(cones - len(contact.problem.torsion), cones)])
        self._cones = np.setdiff1d(np.arange(cones), self._discs)
        first, others = lines + 3 * self._discs, lines + 3 * self._cones
        # The rows in which a state is told apart: half-lines, both directions of sliding, and the other cones.
        self._order = np.concatenate([np.arange(lines), first + 1, first + 2, (others[:, None] + np.arange(3)).ravel()])
        self._s, self._t = (slice(lines + k * len(first), lines + (k + 1) * len(first)) for k in (0, 1))
        self._resists, self._dilates = sp.csr_array(own.E[first]), sp.csr_array(own.F[first].T)
        self._dilates.eliminate_zeros()
        self._resistance = own.offset.soc[self._discs, 0]
        self._convex = np.ones(own.E.shape[0])
        self._convex[first] = 0.0
        self._E, self._offset = sp.csr_array(own.E[self._order]), own.offset.rows[self._order]
        self._rows = [
            np.concatenate(
                [(lines + 3 * g.cones[:, :, None] + np.arange(3)).reshape(len(g.cones), -1), g.lines], axis=1
            )
            for g in own.groups
        ]
        self._soft = self._softness()
        self._follows = 1.0

    def _softness(self) -> Array:
        """Compliance of every row in its own unit; of ties, which have none, the median of all joints."""
        E = sp.diags_array(self._convex) @ self._contact.conditions.E
        square = E.multiply(E)
        of_row: Array = np.asarray(square.sum(axis=1)).ravel()
        soft = square @ self._contact.compliance / np.maximum(of_row, 1e-300)
        soft, of_row = np.where(soft > 0, soft, 1.0), np.where(of_row > 0, of_row, 1.0)
        # A projection onto a cone needs one and the same unit in its rows.
        for values in (soft, of_row):
            values[self._lines :] = np.repeat(values[self._lines :].reshape(-1, 3).max(axis=1), 3)
        return np.asarray(soft / of_row)

    def start(self) -> ContactState:
        """A state without forces."""
        own = self._contact.conditions
        nothing = 0.0 * own.identity()
        return ContactState(np.zeros(own.size), nothing, nothing, np.zeros(self._contact.A.shape[0]), 0.0)

    def predicted(self, state: ContactState, ratio: float, whole: float) -> ContactState:
        """What to begin a step with if everything goes on as it did.

        Parameters
        ----------
        state
            Of the last step.
        ratio, whole
            Displacement of the step relative to the last step, and displacement after it relative to before.
        """
        line, K = ratio * state.z.line, self._points
        # The opening of contacts is that of all steps together.
        opening, last = state.z.line[:K], (self._contact.AT @ state.u)[: 3 * K : 3]
        line[:K] = np.where(opening > 0, np.maximum(opening + ratio * last, 0.0), 0.0)
        # Rectangles remember all that they have turned.
        soc, strips = ratio * state.z.soc, self._contact.strips
        soc[strips] = whole * state.z.soc[strips]
        return ContactState(state.x, state.y, ConeVector(soc, line), state.u, state.alpha)

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
            Displacement that a force costs by which a contact misses its conditions, in multiples of the compliance
            of the joint under a mean force: about as much more as the step is longer than the elastic displacement.
        tolerance
            Of the residual.
        patience
            Iterations in which the residual must halve. If it does not, friction follows smoothed; if it then does not,
        the state is returned.

        Raises
        ------
        RuntimeError
            If there are blocks that no contact holds.
        """
        contact, w_D, w_L = self._contact, self._contact.problem.w_D, self._contact.problem.w_L
        all_weights = penalty * self._weights(guess.x)
        H, weight = self._inverse(all_weights), all_weights[self._order]
        AH = sp.csr_array(contact.A @ H)
        solve = _factorised(sp.coo_array(AH @ contact.AT))
        push = solve(w_L)
        stiffness = _dot(w_L, push)
        # Forces are linear in what conditions ask for, in the rate of sliding where it dilates, and in velocities.
        asked = sp.csr_array(sp.hstack([self._E.T @ sp.diags_array(weight), self._dilates]))
        of_asked, of_motion = sp.csr_array(H @ asked), sp.csr_array(-AH.T)
        at_rest = H @ (contact.compliance * step.reference - step.opening - self._E.T @ (weight * self._offset))
        loads, pulls = contact.A @ at_rest + w_D, sp.csr_array(AH @ asked)
        told = sp.csr_array(sp.vstack([self._E, self._resists]))
        rows_of = sp.csr_array(sp.hstack([told @ of_asked, told @ of_motion]))
        rows_at_rest = told @ at_rest + np.concatenate([self._offset, self._resistance])
        y, dual = guess.y.rows[self._order], -guess.z.rows[self._order] / weight
        resistance, slip = guess.y.soc[self._discs, 0], guess.z.soc[self._discs, 0]
        parts = np.cumsum([len(y), len(resistance)])
        begun = np.concatenate([y + dual, resistance, slip])
        accelerated = Anderson(self._measure(weight), MEMORY)
        least, reached = np.inf, 0
        for k in count(1):
            wishes = np.concatenate([y - dual, slip])
            b = pulls @ wishes
            b += loads
            alpha = 0.0 if step.displacement is None else (step.displacement - _dot(push, b)) / stiffness
            b += alpha * w_L
            u = solve(b)
            rows = rows_of @ np.concatenate([wishes, u])
            rows += rows_at_rest
            forces, wanted = rows[: len(y)], np.maximum(rows[len(y) :], 0.0)
            resistance = resistance + self._follows * (wanted - resistance)
            # Adding one and taking it off makes zeros of numbers that arithmetic is slow with.
            moved, before = dual + y + RELAXED * (forces - y), y
            moved += 1.0
            moved -= 1.0
            y = self._projected(moved, resistance)
            dual = moved - y
            if self._dilates.nnz:
                slip = slip + self._follows * (self._slip(-weight * dual) - slip)
            if k % LOOK == 0:
                # Where the load lifts everything, no forces are left.
                size, of_friction = (max(_size(v), _size(w_D), 1e-300) for v in (y, resistance))
                missed, changed = _size(forces - y) / size, _size(y - before) / size
                lag = _size(wanted - resistance) / of_friction
                residual = max(missed, changed, lag)
                if 2 * residual <= least:
                    least, reached = residual, k
                if not residual > tolerance:
                    break
                if k >= reached + patience:
                    if self._follows == FOLLOWS:
                        break
                    self._follows, least, reached = FOLLOWS, residual, k
                begun = accelerated.point(begun, np.concatenate([moved, resistance, slip]))
                np.maximum(begun[parts[0] :], 0.0, out=begun[parts[0] :])
                moved, resistance, slip = np.split(begun, parts)
                y = self._projected(moved, resistance)
                dual = moved - y
        z = -weight * dual
        x = at_rest + of_asked @ wishes + of_motion @ u
        state = ContactState(x, self._as_cones(y, resistance), self._as_cones(z, self._slip(z)), u, float(alpha))
        return SplitSolution(state, missed, changed, lag, k)

    def _measure(self, weight: Array) -> Array:
        """Weights of forces, resistances and slip in the norm of a change: those of work, slip going along."""
        of_slip = np.zeros(len(self._discs))
        return np.asarray(np.sqrt(np.concatenate([weight, of_slip + np.median(weight), of_slip])))

    def _weights(self, x: Array) -> Array:
        """What each row weighs: its compliance, and the less the more force there is."""
        weights = self._soft.copy()
        mean = np.abs(x[: 3 * self._points : 3]).mean()
        if mean > 0:
            forces = np.abs(x)
            for group, rows in zip(self._contact.conditions.groups, self._rows, strict=True):
                force = forces[group.columns].max(axis=1)
                weights[rows] *= (mean / np.maximum(force, LEAST_FORCE * mean))[:, None]
        return weights

    def _inverse(self, weight: Array) -> sp.csr_array:
        """``(C + Eᵀ P E)⁻¹``, a matrix of small blocks."""
        size, entries = self._contact.conditions.size, []
        for group, rows in zip(self._contact.conditions.groups, self._rows, strict=True):
            H = np.einsum("gri,gr,grj->gij", group.E, (weight * self._convex)[rows], group.E)
            own = np.arange(H.shape[1])
            H[:, own, own] += self._contact.compliance[group.columns]
            i = np.broadcast_to(group.columns[:, :, None], H.shape)
            entries.append([part.ravel() for part in (np.linalg.inv(H), i, i.transpose(0, 2, 1))])
        values, i, j = (np.concatenate(part) for part in zip(*entries, strict=True))
        inverse = sp.csr_array((values, (i, j)), shape=(size, size))
        inverse.eliminate_zeros()
        return inverse

    def _projected(self, rows: Array, resistance: Array) -> Array:
        """Nearest rows that fulfil every condition, each by itself."""
        nearest = rows.copy()
        np.maximum(rows[: self._lines], 0.0, out=nearest[: self._lines])
        size = np.maximum(self._slip(rows), 1e-300)
        share = np.minimum(resistance / size, 1.0, out=size)
        nearest[self._s] *= share
        nearest[self._t] *= share
        if len(self._cones):
            others = ConeVector(nearest[self._t.stop :].reshape(-1, 3), np.zeros(0))
            nearest[self._t.stop :] = others.clipped(0.0, np.inf).soc.ravel()
        return nearest

    def _slip(self, rows: Array) -> Array:
        s, t = rows[self._s], rows[self._t]
        size: Array = np.sqrt(s * s + t * t)
        return size

    def _as_cones(self, rows: Array, first: Array) -> ConeVector:
        soc = np.empty((len(self._discs) + len(self._cones), 3))
        soc[self._discs] = np.column_stack([first, rows[self._s], rows[self._t]])
        soc[self._cones] = rows[self._t.stop :].reshape(-1, 3)
        return ConeVector(soc, rows[: self._lines].copy())


def _factorised(M: sp.coo_array) -> Callable[[Array], Array]:
    """What solves with M. A wall pushed in its plane falls into two problems if the noise between them is left out."""
    scale = np.sqrt(M.diagonal())
    i, j = M.coords
    kept = np.abs(M.data) > NOISE * scale[i] * scale[j]
    matrix = sp.csc_matrix((M.data[kept], (i[kept], j[kept])), shape=M.shape)
    lu = sp.linalg.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options=OPTIONS)
    return lambda b: np.asarray(lu.solve(b), dtype=float)


def _dot(a: Array, b: Array) -> float:
    """Inner product without the threads of a BLAS, which cost more than they save on vectors of this length."""
    return float(np.einsum("i,i->", a, b))


def _size(a: Array) -> float:
    return float(np.sqrt(_dot(a, a)))
