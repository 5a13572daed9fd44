"""What self-stress leaves open: loads that only jammed blocks carry.

Forces that balance each other without any load, as between the jambs of a flat arch, raise the friction of the joints
they press. Their size is not part of the model. A dilatant structure makes them as large as it needs; without dilatancy
they are what the building left behind.
"""

from collections.abc import Generator, Sequence
from dataclasses import replace

import numpy as np

from blockstruct.limit.friction import shift_of, true_sliding
from blockstruct.limit.iteration import Iteration, Outcome, given_up
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.program import ConicProgram, Objective, Solver
from blockstruct.limit.settings import ProcedureSettings
from blockstruct.limit.ties import Ties
from blockstruct.procedures.step import solve_step
from blockstruct.vocabulary import Stage, Status

#: A load factor grows without limit after this many increments, each larger than the one before and than a share of the
#: load factor, to this multiple of the first one. Measured: increments alone also grow for a while on paths that end.
_INCREMENTS, _SHARE, _MULTIPLE = 5, 0.05, 10.0


def collapse_of_dead_load(
    problem: LimitProblem, found: Iteration, settings: ProcedureSettings, solver: Solver
) -> Generator[Iteration, None, Outcome]:
    """Ask whether the mechanism of a negative load factor is one of the dead load alone.

    Such a mechanism is driven by the dead load, and held by friction. If forces carry the whole dead load that this
    mechanism has used up, the dead load itself is at collapse; as forces of another self-stress carry it as well,
    the model does not tell whether the structure stands.

    Parameters
    ----------
    problem
        The limit problem, with the dilatancy of its flow.
    found
        A certified state at a negative load factor.
    settings, solver
        Tolerances and solver.

    Yields
    ------
    Iteration
        The state under the dead load, certified with its own normalisation ``w_D·u = 1``. Its load factor is NaN.
    """
    own, work = problem.dead_load_alone, float(problem.w_D @ found.u)
    why = f"the collapse state found has the negative load factor {found.load_factor:.4g}, which is not an answer"
    if not work > 0:
        return given_up(problem, why, found)
    mechanism = replace(found, u=found.u / work)
    step = solve_step(
        ConicProgram(own, replace(settings, crushing="conic")),
        true_sliding(own),
        Stage.DEAD_LOAD,
        settings,
        solver,
        # The flow-rule gap is linear in the forces; the weight above one asks for the whole dead load first.
        objective=Objective(shift_of(own, found.v / work, found.x[:, 0]), 2.0),
        max_load_factor=1.0,
        mechanism=mechanism,
    )
    yield replace(step, load_factor=np.nan)
    if step.certificate.holds and step.load_factor >= 1 - settings.gap_tolerance:
        message = (
            "the dead load by itself has a non-associative collapse state: friction holds it in some states of "
            f"self-stress and not in others (the iteration ended at the negative load factor {found.load_factor:.4g})"
        )
        return Outcome(Status.SELF_STRESS, np.nan, message)
    return given_up(problem, why, found)


def grows_without_limit(load_factors: Sequence[float]) -> bool:
    """Whether load factors of successive programs end in a growth that nothing slows down."""
    last = np.array(load_factors[-_INCREMENTS - 1 :])
    increments = np.diff(last)
    return bool(
        len(increments) == _INCREMENTS
        and np.all(np.diff(increments) > 0)
        and np.all(increments > _SHARE * np.abs(last[1:]))
        and last[-1] > _MULTIPLE * load_factors[0] > 0
    )


def can_jam(problem: LimitProblem, settings: ProcedureSettings, solver: Solver) -> bool:
    """Whether the joints may bear normal forces that balance each other without any load.

    They may not if there is a motion that opens all of them faster than friction could close them,
    ``v_n > μ ‖v_t‖``: it would do work on such forces. Without that proof they may.
    """
    # What ties press together is limited, and does not count.
    own = replace(problem, w_D=np.zeros_like(problem.w_D), ties=Ties.none(len(problem.w_D)))
    program = ConicProgram(own, replace(settings, crushing="conic"))
    opening = Objective(np.full(own.n_points, -1.0 / own.n_points))
    data = program.data(true_sliding(own), objective=opening, max_load_factor=0.0)
    _, _, u = program.unpack(solver.solve(program, data, settings.solver_tolerance))
    v = (own.A.T @ u).reshape(-1, 3)
    # A NaN, where the solver gives no multipliers, proves nothing.
    return not bool((v[:, 0] - own.friction * np.linalg.norm(v[:, 1:], axis=1)).min() > 0.5 / own.n_points)
