"""The other end of the range of a reaction."""

from dataclasses import replace

from blockstruct.limit.friction import true_sliding
from blockstruct.limit.iteration import Iteration
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Stage


def largest_reaction(problem: LimitProblem, settings: ProcedureSettings, solver: Solver) -> Iteration:
    """Find the largest reaction that statics allows under the dead load.

    It is the least one against the opposite motion, with associative flow: no forces in equilibrium inside the true
    conditions give more. Minus infinity as the load factor says that friction may jam the structure between its
    supports by any force. Velocities and certificate are those of the opposite motion.
    """
    own = replace(problem.associated, w_L=-problem.w_L)
    program = ConicProgram(own, replace(settings, crushing="conic"))
    step = solve_step(program, true_sliding(own), Stage.LARGEST_REACTION, settings, solver)
    return replace(step, load_factor=-step.load_factor)
