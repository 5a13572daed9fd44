"""One step of finite displacement: non-dilatant sliding by programs whose objective is shifted."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.bodies import Bodies
from blockstruct.limit.certificate import Certificate, certify
from blockstruct.limit.friction import relax, shift_of, true_sliding
from blockstruct.limit.iteration import is_solved
from blockstruct.limit.moved import MovedProblem
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.solvers.interior_point import ContactProblem, Step

Array = NDArray[np.float64]

#: Feasibility and duality gap of the programs, and of those of bodies, which are small. Measured on a wall of 46
#: blocks: 1e-6 saves 2 % of the iterations.
TOLERANCE, TIGHT = 1e-7, 1e-9
#: Flow-rule gap, relative to the work of the step, at which sliding and shift agree, and that is certified.
AGREED, CERTIFIED = 2e-3, 1e-2
#: Programs of one step, and those of them that take the new shift as it is.
MOST, UNDAMPED = 8, 3
#: Of the interior-point loop: complementarity and displacements, and a tenth of it of forces; factorisations; and the
#: normal force to begin with. Measured: from 1 or from 0.1 it fails more often on 205 blocks.
LOOP_TOLERANCE, LOOP_ITERATIONS, LOOP_FORCE = 1e-5, 60, 0.3
#: Residual of equilibrium and yield excess, and interpenetration, that are certified.
FORCES, PENETRATING = 1e-5, 5e-2


@dataclass(frozen=True, slots=True)
class Solved:
    """State of a step.

    Attributes
    ----------
    load_factor : float
    x : (K, 3) array
        Contact forces.
    u : (6 F,) array
        Velocities, ``w_L·u = 1``.
    tie_force : (M,) array
    certificate : Certificate
    dissipation : float
        Work of friction and of ties per unit of work of the variable load.
    falling : float
        Work of the dead load per unit of work of the variable load.
    reaching : (K,) array
        Share of the step's work that the force at each contact does while its gap closes.
    missed : float
        Flow-rule gap relative to the work of the loads and of what is dissipated.
    programs, iterations : int
        All of them, and not those alone that came before this state.
    """

    load_factor: float
    x: Array
    u: Array
    tie_force: Array
    certificate: Certificate
    dissipation: float
    falling: float
    reaching: Array
    missed: float
    programs: int = 0
    iterations: int = 0

    @property
    def holds(self) -> bool:
        """Whether the measures of the certificate are within the tolerances of a step."""
        return self.beyond == 0 and self.missed <= CERTIFIED

    @property
    def beyond(self) -> float:
        """Zero, or infinity if forces or velocities are beyond the tolerances of a step."""
        c = self.certificate
        within = max(c.equilibrium_residual, c.yield_excess) <= FORCES and c.interpenetration <= PENETRATING
        return 0.0 if within else np.inf


@dataclass(frozen=True, slots=True)
class Question:
    """A step from a placement, of all blocks or of the bodies that they move as.

    Attributes
    ----------
    problem : LimitProblem
    gap : (K,) array
        Of each contact point, in units of relative velocity.
    slack : (M,) array
        Of each tie, likewise.
    sliding : (K, 3) array
        Relative velocities whose sliding gives the first shift.
    least : float
        Work per unit of work of the variable load to which what is missed is relative, where there is less.
    """

    problem: LimitProblem
    gap: Array
    slack: Array
    sliding: Array
    least: float

    @classmethod
    def of(cls, moved: MovedProblem, work: float, twist: Array, least: float) -> Self:
        """A step in which the unit variable load does a work, J, after a motion, twists (B, 6) at 1 W."""
        sliding = moved.relative(twist) * moved.problem.force_unit[:, None]
        return cls(moved.problem, moved.gap(work), moved.slack_in(work), sliding, least)

    def of_bodies(self, bodies: Bodies) -> Self:
        """The same step of bodies."""
        return replace(self, problem=bodies.problem, gap=self.gap[bodies.between], sliding=self.sliding[bodies.between])

    def shift(self, solved: Solved) -> Array:
        """Shift (K,) of the sliding of a state."""
        v = (self.problem.A.T @ solved.u).reshape(-1, 3)
        return shift_of(self.problem, v, solved.x[:, 0])

    def state(self, alpha: float, x: Array, u: Array, T: Array, settings: ProcedureSettings) -> Solved:
        """What a load factor, forces and velocities are worth."""
        problem, gap = self.problem, self.gap
        v = (problem.A.T @ u).reshape(-1, 3)
        certificate = certify(problem, x, u, alpha, settings, T, gap=gap, slack=self.slack, speed=problem.fastest(u))
        friction = max(-float(np.einsum("kj,kj->", x[:, 1:], v[:, 1:])), 0.0)
        friction += float(T @ np.maximum(problem.ties.elongation(u), 0.0))
        scale = max(abs(alpha) + friction, self.least)
        return Solved(
            load_factor=alpha,
            x=x,
            u=u,
            tie_force=T,
            certificate=certificate,
            dissipation=friction,
            falling=float(problem.w_D @ u),
            reaching=x[:, 0] * np.maximum(gap, 0.0) / scale,
            missed=certificate.flow_rule_gap / scale,
        )


def solve_finite_step(
    question: Question,
    settings: ProcedureSettings,
    solver: Solver,
    *,
    motion: Array | None = None,
    whole: bool = True,
) -> Solved | None:
    """Maximise ``s α − Σ (g_k + σ_k) n_k``: equilibrium now, contacts closed or open at the end of the step.

    With the gaps g before the step and the shift ``σ = μ ‖v_t‖`` of De Saxcé & Feng (1998), of the displacement of the
    step itself, the program's dual says ``v_n + g ≥ 0`` and ``w_L·Δu = s``: contacts close, penetrations are pushed
    out, and sliding does not dilate. The load factor is an unknown, so that softening is found as well. The shift is
    that of the last motion first. Where sliding and shift do not agree then, the interior-point loop that has the shift
    inside solves the step; where it does not, the shift is that of the programs in turn.

    Parameters
    ----------
    question, settings, solver
        The step, and of the case.
    motion : (6 F,) array
        Velocities to begin with, which may be those of the step already: then forces alone are to be found.
    whole
        Whether these are all blocks, and no bodies: then the loop is tried as well.

    Returns
    -------
    Solved or None
        The state that misses the flow rule least; None if no program is solved, as where nothing holds a block.
    """
    problem = question.problem
    if not problem.n_points:
        return None
    program, sliding = ConicProgram(problem, settings), true_sliding(problem)
    before = question.sliding if motion is None else (problem.A.T @ motion).reshape(-1, 3)
    shift = shift_of(problem, before, np.zeros(problem.n_points))
    best: Solved | None = None
    programs = iterations = 0
    for k in range(MOST):
        objective = Objective(question.gap + shift, price=question.slack)
        solution = solver.solve(program, program.data(sliding, objective=objective), TOLERANCE if whole else TIGHT)
        programs, iterations = k + 1, iterations + solution.iterations
        if not is_solved(solution.status):
            break
        alpha, x, u = program.unpack(solution)
        T = program.tie_force(solution)
        found = [question.state(alpha, x, u, T, settings)]
        if motion is not None and k == 0:
            found.append(question.state(alpha, x, motion, T, settings))
        shift = relax(shift, question.shift(found[0]), 1.0 if k < UNDAMPED else 0.5)
        if whole and k == 0 and min(f.missed for f in found) > AGREED:
            looped = _looped(question, program, alpha, settings)
            iterations += looped.iterations
            found.append(looped)
        best = min([f for f in (best, *found) if f is not None], key=lambda f: f.missed + f.beyond)
        if best.missed <= AGREED:
            break
    return best and replace(best, programs=programs, iterations=iterations)


def _looped(question: Question, program: ConicProgram, alpha: float, settings: ProcedureSettings) -> Solved:
    """The step by the interior-point loop, of joints without compliance, from a load factor."""
    problem = question.problem
    contact = ContactProblem(program, np.zeros((problem.n_points, 3)))
    opening = np.zeros(contact.conditions.size)
    opening[: 3 * problem.n_points : 3] = question.gap
    opening[contact.ties] = question.slack
    found = contact.solve(
        Step(np.zeros_like(opening), opening, 1.0),
        contact.afresh(LOOP_FORCE, 1.0, alpha),
        centring=None,
        tolerance=LOOP_TOLERANCE,
        max_iterations=LOOP_ITERATIONS,
    )
    state = found.state
    x = state.x[: 3 * problem.n_points].reshape(-1, 3)
    T = state.x[contact.ties] + problem.ties.prestress(state.alpha)
    solved = question.state(state.alpha, x, state.u, T, settings)
    return replace(solved, iterations=found.iterations)
