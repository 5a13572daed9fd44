"""Solve steps of a pushover with blocks that move as rigid bodies."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import ContactPoints, Placement
from blockstruct.limit.bodies import Bodies, bodies_of
from blockstruct.limit.capacity_curve import FiniteStep
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.moved import MovedProblem, MovingProblem
from blockstruct.limit.program import Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.carried_forces import carried_forces
from blockstruct.procedures.finite_step import CERTIFIED, IDLE, CountingSolver, Question, Solved, solve_finite_step

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Distance, in characteristic lengths, up to which a contact point inside a body is the same as before.
SAME = 1e-5
#: Gap or penetration inside a body, in characteristic lengths, that counts as zero.
NO_GAP = 1e-7
#: Most steps of all blocks before bodies are tried again, after as many failures in a row.
MOST_WAITS = 4


@dataclass(frozen=True, slots=True)
class Carried:
    """Bodies and contact forces that a state passes to the next step.

    Attributes
    ----------
    body : (B,) array
        Body of each block; zero is the body of the supports.
    place : (2, K, 8) array
        Of each contact point: its two blocks, the lower number first; its position in the axes of either block, in
        characteristic lengths; and the normal towards the second block, :data:`SAME` long.
    force : (K, 3) array
        Force on the second block, in the axes of the first.
    """

    body: Index
    place: Array
    force: Array

    @classmethod
    def of(cls, moved: MovedProblem, x: Array, u: Array, points: ContactPoints | None = None) -> Self:
        """Return the bodies and forces of a solution.

        ``x`` (K, 3) are forces at the problem's contact points, or at ``points``. ``u`` (6 F,) are velocities.
        """
        place, frame = _placed(moved.contacts.points if points is None else points, moved)
        return cls(bodies_of(moved, u), place, np.einsum("kij,ki->kj", frame, x))

    @classmethod
    def of_step(cls, problem: MovingProblem, step: FiniteStep) -> Self:
        """Return the bodies and forces of a kept state."""
        placement, minus, plus = Placement.at(step.position, step.rotation), step.minus_of_contact, step.plus_of_contact
        lower, other = np.minimum(minus, plus), np.maximum(minus, plus)
        towards = np.where(minus < plus, 1.0, -1.0)[:, None]
        normal, length = step.normal_of_contact * towards, problem.statics.length
        place = _places(lower, other, step.point_of_contact, normal, placement, length)
        on_other = towards / np.minimum(problem.unit[minus], problem.unit[plus])[:, None]
        own = np.einsum("kji,kj->ki", placement.rotation[lower], step.force_of_contact)
        return cls(step.body, place, own * on_other)

    def recalled(self, moved: MovedProblem, question: Question) -> Question:
        """Return a step that remembers these forces at its contact points.

        New contact points remember no force. Points of sliding blocks match if they keep their place on one of the two
        blocks. Points at the same place on parts of one face share their forces.
        """
        place, frame = _placed(moved.contacts.points, moved)
        now, before = self._near(place, SAME)
        share = self.force[before] / np.bincount(before)[before, None]
        force = np.zeros_like(question.rubbing)
        np.add.at(force, now, np.einsum("kij,kj->ki", frame[now], share))
        return replace(question, rubbing=force)

    def pressed_near(self, moved: MovedProblem, distance: float) -> NDArray[np.bool_]:
        """Return the contact points (K,) near a loaded point of the same blocks.

        The distance is in characteristic lengths.
        """
        place, _ = _placed(moved.contacts.points, moved)
        now, before = self._near(place, distance)
        force = np.linalg.norm(self.force, axis=1)
        pressed = force > IDLE * force.mean()
        found = np.zeros(place.shape[1], dtype=bool)
        found[now[pressed[before]]] = True
        return found

    def _near(self, place: Array, distance: float) -> tuple[Index, Index]:
        """Return pairs of new and carried points that are near each other.

        Points ``place`` (2, K, 8) match if they are within a distance on one of their two blocks.
        """
        # Loaded here: scipy.spatial is slow to import.
        from scipy.spatial import KDTree

        near = [
            KDTree(new).sparse_distance_matrix(KDTree(old), distance, output_type="ndarray")
            for old, new in zip(self.place, place, strict=True)
        ]
        now, before = np.unique([np.concatenate([n[of] for n in near]) for of in ("i", "j")], axis=1)
        return now, before


class Stepper:
    """Solve successive steps, of bodies if possible, else of all blocks."""

    def __init__(self, settings: ProcedureSettings, solver: Solver) -> None:
        self._settings, self.solver = settings, CountingSolver(solver)
        #: Bodies and forces that the next step begins with: from the kept state, then from later attempts.
        self.carried: Carried | None = None
        #: Number of failures of body steps in a row, and solutions before bodies are tried again.
        self.waiting = 0, 0

    def begin(
        self, moved: MovedProblem, question: Question, collapse: Iteration, points: ContactPoints
    ) -> Solved | None:
        """Return the collapse state as the first state of the curve.

        Return None if contact detection finds other contacts than the collapse state has.
        """
        x = Carried.of(moved, collapse.x, collapse.u, points).recalled(moved, question).rubbing
        found = question.state(collapse.load_factor, x, collapse.u, collapse.tie_force, self._settings)
        return found if found.holds else None

    def go_on(self, carried: Carried | None, waiting: tuple[int, int]) -> None:
        """Begin the next step with the data of a kept state."""
        self.carried, self.waiting = carried, waiting

    def solve(self, moved: MovedProblem, question: Question) -> Solved | None:
        """Solve a step; return None if there is no state."""
        found = None
        failed, waits = self.waiting
        if self.carried is not None:
            question = self.carried.recalled(moved, question)
            if waits == 0:
                found = solve_as_bodies(moved, question, self.carried.body, self._settings, self.solver)
                failed = waits = 0 if found is not None else min(failed + 1, MOST_WAITS)
            else:
                waits -= 1
            self.waiting = failed, waits
        if found is None:
            found = solve_finite_step(question, self._settings, self.solver)
        if found is not None:
            self.carried = Carried.of(moved, found.x, found.u)
        return found


def solve_as_bodies(
    moved: MovedProblem, question: Question, body: Index, settings: ProcedureSettings, solver: CountingSolver
) -> Solved | None:
    """Solve a step of bodies, then find the forces inside the bodies.

    The bodies of a state remain if their joints can carry the forces inside them. Equilibrium of the bodies and inside
    the bodies is equilibrium of all blocks. The flow rule also holds for all blocks, because nothing moves inside a
    body. The certificate covers all blocks.

    Returns
    -------
    Solved or None
        None if the result does not hold. The caller then solves the step of all blocks.
    """
    own = np.unique(body[moved.free])
    # Blocks that all move separately, and a structure at rest, form no bodies.
    if not own.any() or len(own) == len(moved.free):
        return None
    problem, bodies = moved.problem, Bodies.of(moved, body)
    solved = solve_finite_step(question.of_bodies(bodies), settings, solver)
    if solved is None or solved.missed > CERTIFIED:
        return None
    u = bodies.motion @ solved.u
    inside = np.repeat(~bodies.between, 3)
    x = np.zeros((problem.n_points, 3))
    x[bodies.between] = solved.x
    unbalanced = problem.unbalanced(x, solved.tie_force, solved.load_factor)
    before = question.rubbing[~bodies.between]
    forces = carried_forces(problem.A[:, inside], problem.friction[~bodies.between], before, -unbalanced)
    if forces is None:
        return None
    x[~bodies.between] = forces
    none = ~bodies.between & (np.abs(moved.contacts.gap) <= NO_GAP * problem.length)
    closed = replace(question, gap=np.where(none, 0.0, question.gap))
    found = closed.state(solved.load_factor, x, u, solved.tie_force, settings)
    return found if found.holds else None


def _placed(points: ContactPoints, moved: MovedProblem) -> tuple[Array, Array]:
    """Return positions (2, K, 8) and frames (K, 3, 3) of contact points.

    The format is the one of :class:`Carried`.
    """
    lower, other = np.minimum(points.minus, points.plus), np.maximum(points.minus, points.plus)
    frame = points.frame[points.interface]
    frame = np.where((points.minus > points.plus)[:, None, None], -frame, frame)
    place = _places(lower, other, points.position, frame[:, 0], moved.placement, moved.problem.length)
    return place, frame @ moved.placement.rotation[lower]


def _places(lower: Index, other: Index, position: Array, normal: Array, placement: Placement, length: float) -> Array:
    """Return positions (2, K, 8) of contact points on both blocks.

    ``position`` and ``normal`` have shape (K, 3); normals point towards the other block. The format is the one of
    :class:`Carried`. Normals are so short that only directions at least 60 degrees apart differ. In an inner corner two
    blocks touch at one point in two directions.
    """
    found = []
    for block in (lower, other):
        own = placement.rotation[block]
        arm = np.einsum("kji,kj->ki", own, position - placement.position[block]) / length
        direction = np.einsum("kji,kj->ki", own, SAME * normal)
        found.append(np.column_stack([lower, other, arm, direction]))
    return np.stack(found)
