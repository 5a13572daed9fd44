"""Test whether the structure stands under its dead load."""

from collections.abc import Generator
from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.arrays import NEGLIGIBLE
from blockstruct.limit.certificate import certify
from blockstruct.limit.friction import true_sliding
from blockstruct.limit.iteration import Iteration, Outcome, Steps, given_up
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, ProgramData, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Reason, Stage, Status


def dead_load_program(
    problem: LimitProblem, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, Outcome | NDArray[np.float64]]:
    """Find the share ρ ≤ 1 of the dead load that the joints carry.

    Maximises ρ subject to ``A x + ρ w_D = 0`` and the true conditions. This program always has a solution, so either
    answer has a proof. Forces in equilibrium with the whole dead load prove that the structure stands. A mechanism that
    releases work of the dead load proves that it falls. For a share of zero there are many such mechanisms. The last
    program then finds the mechanism in which the structure begins to fall.

    Yields
    ------
    Iteration
        The program, unless the structure is proved to stand. Its load factor is NaN.

    Returns
    -------
    Outcome or array
        Normal forces (K,) under the dead load if the structure stands.
    """
    if not problem.w_D.any():
        return np.zeros(problem.n_points)
    own = replace(problem.dead_load_alone, dilatancy=problem.friction)
    # Crushing enters exactly, whatever the settings: a single program has no iterate to linearise about.
    program, sliding = ConicProgram(own, replace(settings, crushing="conic")), true_sliding(own)
    step = solve_step(program, sliding, Stage.DEAD_LOAD, settings, solver, max_load_factor=1.0)
    whole = step.load_factor >= 1 - settings.numerics.equilibrium_tolerance
    if whole and step.certificate.admissible:
        return step.x[:, 0]
    if step.load_factor <= NEGLIGIBLE or not step.certificate.holds:
        step = _as_it_falls(own, step, settings, solver)
    yield replace(step, load_factor=np.nan, u=problem.released(step.u))
    if step.certificate.holds and not whole:
        # A share below the solver's tolerance is zero.
        share = round(max(step.load_factor, 0.0), 6)
        return Outcome(Status.UNSTABLE, np.nan, Reason.DEAD_LOAD_NOT_CARRIED, carried=share)
    return given_up(problem, Reason.DEAD_LOAD_UNDECIDED)


def solve_dead_load(problem: LimitProblem, settings: ProcedureSettings, solver: Solver) -> Steps:
    """Test whether a structure stands under its dead load, as :func:`dead_load_program`.

    Returns
    -------
    Outcome
        Value of the generator; its status is ``stands`` if the structure does.
    """
    found = yield from dead_load_program(problem, settings, solver)
    return found if isinstance(found, Outcome) else Outcome(Status.STANDS, np.nan, Reason.AT_REST)


def _as_it_falls(own: LimitProblem, step: Iteration, settings: ProcedureSettings, solver: Solver) -> Iteration:
    """Return the mechanism in which the structure begins to fall.

    Its forces are zero. If joints carry no share of the dead load, any mechanism that releases work proves collapse. A
    solver then returns a mechanism in which all blocks move.
    """
    program = _LeastConstraint(_without_limits(own), settings)
    _, _, u = program.unpack(solver.solve(program, program.at_rest(), settings.numerics.solver_tolerance))
    x, T, work = np.zeros_like(step.x), own.ties.prestress(0.0), float(own.w_L @ u)
    u = u / work if work > 0 else step.u
    certificate = certify(own, x, u, 0.0, settings, T)
    if not certificate.holds:
        return step
    v, elongation = (own.A.T @ u).reshape(-1, 3), own.ties.elongation(u)
    return replace(step, load_factor=0.0, x=x, u=u, v=v, tie_force=T, elongation=elongation, certificate=certificate)


def _without_limits(own: LimitProblem) -> LimitProblem:
    """Return the problem with all strengths of joints and ties infinite.

    The whole dead load acts. Strengths play no part without load. A mechanism in which they did would not belong to
    zero load.
    """
    ties = own.ties.at(1.0)
    return replace(
        own,
        w_D=own.w_L,
        compression=np.full(own.n_points, np.inf),
        rectangles=own.rectangles[:0],
        capacity=np.empty(0),
        ties=replace(ties, capacity=np.full(len(ties), np.inf), bond_rows=ties.bond_rows[:0], bond=np.empty(0)),
    )


class _LeastConstraint(ConicProgram):
    """Minimise ``Σ W_b ‖r_b‖²`` of the unbalanced wrenches r.

    This is Gauss's principle of least constraint for blocks at rest. The wrench ``r = A x + Σ a_j T_j + w_D`` of each
    block is in multiples of the block's dead wrench. So ``W_b r_b`` are its first velocities, with the inertia of a
    ball of the characteristic length. The wrench is zero for blocks that stand. The variables r and q follow the
    program's other variables, and the cones ``r_i² ≤ q_i`` follow its other cones.
    """

    def __init__(self, problem: LimitProblem, settings: ProcedureSettings) -> None:
        super().__init__(problem, settings)
        n, (rows, columns) = self.zero_rows, self.G.shape
        i = np.arange(n)
        r, q, cone = columns + i, columns + n + i, rows + 3 * i
        row, column = np.concatenate([i, cone, cone + 1, cone + 2]), np.concatenate([r, q, r, q])
        entry = np.repeat([-1.0, -1.0, -2.0, -1.0], n)
        own = self.G.tocoo()
        G = sp.coo_array(
            (np.append(own.data, entry), (np.append(own.row, row), np.append(own.col, column))),
            shape=(rows + 3 * n, columns + 2 * n),
        )
        self.G = sp.csc_array(G)
        self._h = np.append(self._h, np.tile([1.0, 0.0, -1.0], n))
        self.cones += n

    def at_rest(self) -> ProgramData:
        """Return the program's data without the variable load."""
        weight = self.problem.wrench_unit
        data = self.data(true_sliding(self.problem), max_load_factor=0.0, loaded=False)
        data.q[-self.zero_rows :] = self.total * np.repeat(weight / weight.max(), 6)
        return data


def largest_reaction(problem: LimitProblem, settings: ProcedureSettings, solver: Solver) -> Iteration:
    """Find the largest reaction that statics allows under the dead load.

    It is the least reaction against the opposite motion, with associative flow. No forces in equilibrium inside the
    true conditions give a larger one. A load factor of minus infinity means that friction may jam the structure between
    its supports by any force. Velocities and certificate belong to the opposite motion.
    """
    own = replace(problem, w_L=-problem.w_L, dilatancy=problem.friction)
    program = ConicProgram(own, replace(settings, crushing="conic"))
    step = solve_step(program, true_sliding(own), Stage.LARGEST_REACTION, settings, solver)
    return replace(step, load_factor=-step.load_factor)
