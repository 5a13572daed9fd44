"""Solve one step of finite displacement with non-dilatant sliding.

The programs have a shifted objective.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit.bodies import Bodies
from blockstruct.limit.certificate import FORCES, Certificate, certify
from blockstruct.limit.friction import Sliding, frozen_sliding, shift_of, true_sliding
from blockstruct.limit.iteration import is_solved
from blockstruct.limit.moved import MovedProblem
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Objective, ProgramData, Solution, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.solvers.interior_point import ContactProblem, Step

Array = NDArray[np.float64]

#: Feasibility and duality gap of the programs. Measured on a sliding block: 1e-7 rotates it by 1e-7.
TOLERANCE = 1e-8
#: Flow-rule gaps, relative to the work of the step: sliding and shift agree below the first, and the second is
#: certified.
AGREED, CERTIFIED = 2e-3, 1e-2
#: Flow-rule gap up to which forces belong to the last motion. Rows of sliding units may continue in many ways. With a
#: different motion in every step, curves end arbitrarily.
GOES_ON = 1e-5
#: Normal force, relative to the mean, from which a contact is closed; share of the friction limit below which it
#: sticks.
PRESSED, STICKS = 1e-3, 1 - 1e-3
#: Tolerance of the least squares that find the continued motion.
EXACT = 1e-12
#: Work of friction, relative to the work of the step, from which blocks slide and forces remember friction.
RUBS = 1e-3
#: Relative change below which friction counts as unchanged.
REMEMBERED = 1e-2
#: Normal force, relative to the mean, up to which a contact was unloaded in the last step. Relative increase of its
#: shift if blocks rock. Without it, any force at a contact that now slides faster would raise the objective.
IDLE, LOSS = 1e-2, 2e-2
#: Interior-point loop: elastic displacement, as a share of the motion of a step; tolerance; most factorisations; first
#: normal forces, relative to the program before; and a normal force that counts as zero.
TRACE, LOOP_TOLERANCE, LOOP_ITERATIONS = 2e-5, 1e-2, 80
LOOP_FORCES, NO_FORCE = (0.7, 0.2), 1e-9
#: Complementarity gap, relative to the work of the step, above which a loop has failed. Measured on walls of 55 and 205
#: blocks: loops end below 0.1, and programs close them, or above 2, and no program does.
NOWHERE = 1.0
#: Largest certified interpenetration.
PENETRATING = 5e-2


@dataclass(frozen=True, slots=True)
class Solved:
    """State of a step.

    Attributes
    ----------
    load_factor : float
        Load factor α.
    x : (K, 3) array
        Contact forces.
    u : (6 F,) array
        Velocities, ``w_L·u = 1``.
    tie_force : (M,) array
        Tie forces T.
    certificate : Certificate
        Certificate of the state.
    dissipation : float
        Work of friction and of ties per unit of work of the variable load.
    slides : bool
        Whether friction does more than :data:`RUBS` of the work.
    falling : float
        Work of the dead load that ties do not take up, per unit of work of the variable load.
    reaching, tightening : (K,) and (M,) arrays
        Share of the step's work by each contact force while its gap closes. Share by each tie force while its slack
        closes.
    missed : float
        Flow-rule gap relative to the work of the loads and the dissipated work.
    """

    load_factor: float
    x: Array
    u: Array
    tie_force: Array
    certificate: Certificate
    dissipation: float
    slides: bool
    falling: float
    reaching: Array
    tightening: Array
    missed: float

    @property
    def holds(self) -> bool:
        """Return whether the certificate meets the tolerances of a step."""
        return self.beyond == 0 and self.missed <= CERTIFIED

    @property
    def beyond(self) -> float:
        """Return zero within the tolerances of a step, else infinity."""
        c = self.certificate
        within = max(c.equilibrium_residual, c.yield_excess) <= FORCES and c.interpenetration <= PENETRATING
        return 0.0 if within else np.inf


@dataclass(frozen=True, slots=True)
class Question:
    """Data of a step from a placement, of all blocks or of bodies.

    Attributes
    ----------
    problem : LimitProblem
        The problem at the placement.
    gap : (K,) array
        Gap of each contact point, in units of relative velocity.
    slack : (M,) array
        Slack of each tie, in units of relative velocity.
    motion : (6 F,) array
        Velocities of the last motion, whose sliding gives the first shift.
    rubbing : (K, 3) array
        Remembered forces of the last step, zero at new contact points. Only friction is remembered.
    least : float
        Lower bound of the work that scales the flow-rule gap, per unit of work of the variable load.
    rocks : bool
        Whether blocks rock at collapse, and hardly slide.
    """

    problem: LimitProblem
    gap: Array
    slack: Array
    motion: Array
    rubbing: Array
    least: float
    rocks: bool

    @classmethod
    def of(cls, moved: MovedProblem, work: float, twist: Array, least: float, *, rocks: bool) -> Self:
        """Return a step in which the unit variable load does a work, J.

        The last motion has twists (B, 6) at 1 W.
        """
        gap, none = moved.gap(work), np.zeros((moved.problem.n_points, 3))
        return cls(moved.problem, gap, moved.slack_in(work), moved.velocities(twist), none, least, rocks)

    def remembers(self, x: Array) -> bool:
        """Return whether forces x (K, 3) keep the friction of the last step."""
        change = np.linalg.norm(x[:, 1:] - self.rubbing[:, 1:])
        return bool(change <= REMEMBERED * np.linalg.norm(self.rubbing[:, 1:]))

    def of_bodies(self, bodies: Bodies) -> Self:
        """Return the same step for bodies."""
        of_points = {name: getattr(self, name)[bodies.between] for name in ("gap", "rubbing")}
        return replace(self, problem=bodies.problem, motion=bodies.of_blocks(self.motion), **of_points)

    def state(self, alpha: float, x: Array, u: Array, T: Array, settings: ProcedureSettings) -> Solved:
        """Return the state of a load factor, forces and velocities."""
        problem, gap = self.problem, self.gap
        certificate = certify(problem, x, u, alpha, settings, T, gap=gap, slack=self.slack, speed=problem.fastest(u))
        friction, of_ties = dissipated(problem, x, T, u)
        dissipation = friction + of_ties
        scale = max(abs(alpha) + dissipation, self.least)
        return Solved(
            load_factor=alpha,
            x=x,
            u=u,
            tie_force=T,
            certificate=certificate,
            dissipation=dissipation,
            slides=friction > RUBS * scale,
            falling=float(problem.w_D @ u) - of_ties,
            reaching=x[:, 0] * np.maximum(gap, 0.0) / scale,
            tightening=T * np.maximum(self.slack, 0.0) / scale,
            missed=certificate.flow_rule_gap / scale,
        )


def dissipated(problem: LimitProblem, x: Array, T: Array, u: Array) -> tuple[float, float]:
    """Return the rates of work that friction and ties dissipate.

    Forces are x (K, 3) and T (M,), in a motion u (6 F,).
    """
    v = (problem.A.T @ u).reshape(-1, 3)
    return -float(np.einsum("kj,kj->", x[:, 1:], v[:, 1:])), float(T @ problem.ties.elongation(u))


class CountingSolver:
    """Count the programs and interior-point iterations of a solver.

    The count of iterations includes the iterations of loops.
    """

    def __init__(self, solver: Solver) -> None:
        self._solver = solver
        self.programs = self.iterations = 0

    def solve(self, program: ConicProgram, data: ProgramData, tolerance: float) -> Solution:
        """Solve one program."""
        solution = self._solver.solve(program, data, tolerance)
        self.programs, self.iterations = self.programs + 1, self.iterations + solution.iterations
        return solution

    def spent(self) -> tuple[int, int]:
        """Return programs and iterations since the last call, and reset."""
        spent = self.programs, self.iterations
        self.programs = self.iterations = 0
        return spent


def solve_finite_step(question: Question, settings: ProcedureSettings, solver: CountingSolver) -> Solved | None:
    """Maximise ``s α − Σ (g_k + σ_k) n_k`` for one step.

    Equilibrium holds at the start of the step, and contacts are closed or open at its end. The program contains the
    gaps g before the step. The shift ``σ = μ ‖v_t‖`` of De Saxcé & Feng (1998) belongs to the displacement of the step
    itself. The dual of the program is then ``v_n + g ≥ 0`` and ``w_L·Δu = s``. Contacts close, penetrations are pushed
    out, and sliding does not dilate. The load factor is an unknown, so the step also follows softening.

    The first shift belongs to the last motion. If blocks slide, a motion does not determine normal forces, and so
    neither friction nor the load factor. If friction differs from the last step, the interior-point loop, which
    remembers friction, finds normal forces. Two programs then find the motion and the forces. The loop also runs if
    sliding and shift do not agree. States without memory come last: among several possible motions they select any. The
    last motion continues if the forces satisfy its flow rule.

    Parameters
    ----------
    question, settings, solver
        Data of the step; settings and solver of the case.

    Returns
    -------
    Solved or None
        The state that misses the flow rule least. None if no program is solved, for example if nothing holds a block.
    """
    problem = question.problem
    if not problem.n_points:
        return None
    programs = _Programs(question, settings, solver)
    first = programs.begun()
    if first is None:
        return None
    found = [first]
    wide, narrow = LOOP_FORCES
    if not _agreed(found) or (first.slides and not question.remembers(first.x)):
        remembered = programs.remembered(first, wide)
        found = remembered if _agreed(remembered) else found + remembered
    if not _agreed(found):
        found += programs.closed(first.x[:, 0])
    if not _agreed(found) and found[-1].x is not first.x:
        found += programs.closed(found[-1].x[:, 0])
    if not _agreed(found):
        found += programs.remembered(first, narrow)
    best = min(found, key=_missed)
    if best.slides:
        going_on = question.state(best.load_factor, best.x, _going_on(question, best.x), best.tie_force, settings)
        best = going_on if _missed(going_on) <= GOES_ON else best
    return best


def _going_on(question: Question, x: Array) -> Array:
    """Return the motion nearest to the last one that fits given forces.

    Contacts under pressure stay closed, and sticking contacts stick. Without this correction, errors of the last motion
    would add up from step to step.
    """
    problem, motion = question.problem, question.motion
    size = np.linalg.norm(x[:, 1:], axis=1)
    pressed = x[:, 0] > PRESSED * x[:, 0].mean()
    sticks = pressed & (size < STICKS * problem.friction * x[:, 0])
    held = np.column_stack([pressed, sticks, sticks])
    opening = np.zeros_like(x)
    opening[:, 0] = question.gap
    rows = sp.vstack([sp.csr_array(problem.A[:, held.ravel()].T), sp.csr_array(problem.w_L[None])], format="csr")
    missed = rows @ motion + np.append(opening[held], -1.0)
    return np.asarray(motion - sp.linalg.lsmr(rows, missed, atol=EXACT, btol=EXACT)[0])


def _missed(found: Solved) -> float:
    return found.missed + found.beyond


def _agreed(found: list[Solved]) -> bool:
    """Return whether one of the states has a motion that fits its forces."""
    return min(map(_missed, found), default=np.inf) <= AGREED


class _Programs:
    """Solve the programs of one step."""

    def __init__(self, question: Question, settings: ProcedureSettings, solver: CountingSolver) -> None:
        self._question, self._settings, self._solver = question, settings, solver
        self._program = ConicProgram(question.problem, settings)

    def begun(self) -> Solved | None:
        """Find forces with the shift of the last motion.

        If blocks rock, the shift of unloaded contacts is increased by :data:`LOSS`.
        """
        question, problem = self._question, self._question.problem
        v, before = (problem.A.T @ question.motion).reshape(-1, 3), question.rubbing
        shift = shift_of(problem, v, np.zeros(problem.n_points))
        rubbed = -float((before[:, 1:] * v[:, 1:]).sum()) > RUBS * question.least
        if question.rocks and before.any() and not rubbed:
            shift[before[:, 0] <= IDLE * before[:, 0].mean()] *= 1 + LOSS
        return self._shifted(shift)

    def remembered(self, before: Solved, force: float) -> list[Solved]:
        """Return states with the normal forces of the interior-point loop.

        The loop begins with a share ``force`` of a state's normal forces.
        """
        normal = self._looped(before, force)
        return [] if normal is None else self.closed(normal)

    def closed(self, normal: Array) -> list[Solved]:
        """Return states for given normal forces (K,).

        The motion belongs to friction at these normal forces, and the last program finds forces for this motion.
        """
        problem = self._question.problem
        moving = self._found(frozen_sliding(problem, np.maximum(normal, 0.0)), np.zeros(problem.n_points))
        if moving is None:
            return []
        last = self._shifted(shift_of(problem, (problem.A.T @ moving.u).reshape(-1, 3), moving.x[:, 0]))
        if last is None:
            return []
        return [self._question.state(last.load_factor, last.x, moving.u, last.tie_force, self._settings), last]

    def _looped(self, before: Solved, force: float) -> Array | None:
        """Find normal forces (K,) by the interior-point loop.

        The loop begins with a share ``force`` of a state's normal forces. Return None if it diverges. Joints have a
        trace of compliance and remember friction. Forces that a rigid structure does not determine then stay as they
        were.
        """
        question, problem, K = self._question, self._question.problem, self._question.problem.n_points
        mean, speed = (float(np.abs(a).mean()) for a in (before.x[:, 0], problem.A.T @ before.u))
        contact = ContactProblem(self._program, np.full((K, 3), TRACE * speed / max(mean, NO_FORCE)))
        opening, reference = np.zeros((2, contact.conditions.size))
        opening[: 3 * K : 3] = question.gap
        opening[contact.ties] = question.slack
        friction = question.rubbing.copy()
        friction[:, 0] = 0.0
        reference[: 3 * K] = friction.ravel()
        looped = contact.solve(
            Step(reference, opening, 1.0),
            contact.afresh(force * mean, 1.0, before.load_factor),
            centring=None,
            tolerance=LOOP_TOLERANCE,
            max_iterations=LOOP_ITERATIONS,
        )
        self._solver.iterations += looped.iterations
        return looped.state.x[: 3 * K : 3] if looped.gap <= NOWHERE else None

    def _shifted(self, shift: Array) -> Solved | None:
        """Find forces inside the true cones for a shift (K,)."""
        return self._found(true_sliding(self._question.problem), shift)

    def _found(self, sliding: Sliding, shift: Array) -> Solved | None:
        question, program = self._question, self._program
        data = program.data(sliding, objective=Objective(question.gap + shift, price=question.slack))
        solution = self._solver.solve(program, data, TOLERANCE)
        if not is_solved(solution.status):
            return None
        return question.state(*program.unpack(solution), program.tie_force(solution), self._settings)
