"""The dead-load program: can the structure stand at all."""

from collections.abc import Generator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit.friction import true_sliding
from blockstruct.limit.iteration import Iteration, Outcome, of_weights_apart
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Stage, Status


def dead_load_program(
    problem: LimitProblem, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, Outcome | NDArray[np.float64]]:
    """Find the share ρ ≤ 1 of the dead load that the joints can carry alone.

    Maximises ρ subject to ``A x + ρ w_D = 0`` and the true conditions. That program always has a solution, so
    either answer comes with a proof: forces in equilibrium with the whole dead load, or a mechanism by which it
    falls.

    Yields
    ------
    Iteration
        The program, if the structure is not shown to stand. Its load factor is NaN.

    Returns
    -------
    Outcome or array
        Normal forces (K,) under the dead load if the structure stands.
    """
    if not problem.w_D.any():
        return np.zeros(problem.n_points)
    own = replace(problem.dead_load_alone, dilatancy=problem.friction)
    # Crushing enters exactly, whatever the settings: one program has no iterate to linearise about.
    program, sliding = ConicProgram(own, replace(settings, crushing="conic")), true_sliding(own)
    step = solve_step(program, sliding, Stage.DEAD_LOAD, settings, solver, max_load_factor=1.0)
    share, proof = step.load_factor, step.certificate
    whole = share >= 1 - settings.equilibrium_tolerance
    if whole and proof.admissible:
        return step.x[:, 0]
    yield replace(step, load_factor=np.nan, u=problem.released(step.u))
    if proof.holds and not whole:
        what = "dead load and prestress" if problem.ties.prestress_D.any() else "dead load"
        # Less than a solver's tolerance is nothing.
        carried = round(max(share, 0.0), 6)
        return Outcome(Status.UNSTABLE, np.nan, f"the joints carry {carried:.3g} of the {what} at most")
    return Outcome(
        Status.NOT_CONVERGED,
        np.nan,
        f"the solver ended the dead-load program as {step.solver_status}: neither forces that carry the dead load "
        f"nor a mechanism by which it falls{of_weights_apart(problem)}",
    )
