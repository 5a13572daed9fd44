"""Resume a case: its history answers the programs already solved.

The procedure is deterministic: its next step depends only on the problem, the settings and the earlier solutions. So
it runs again from the start, with a solver that knows the first solutions.
"""

from dataclasses import replace

import numpy as np
import xarray as xr

from blockstruct.errors import FormatError
from blockstruct.limit import (
    ConicProgram,
    Iteration,
    LimitProblem,
    Outcome,
    ProgramData,
    Solution,
    Solver,
    velocities_of,
)
from blockstruct.limit.iteration import Steps
from blockstruct.statics import Statics
from blockstruct.vocabulary import SolverStatus, Stage

#: Stages whose iterations are not programs of the problem.
_FOUND_ANEW = (Stage.DEAD_LOAD, Stage.DEAD_LOAD_COLLAPSE, Stage.LARGEST_REACTION, Stage.LOADING_PATH)


class ReplaySolver:
    """Answers programs from the history of a case, then from a solver.

    :meth:`follow` counts the iterations, to which programs belong. A loading path finds some of its closing states by
    its own loop, which runs again.

    The dead-load program is solved again, because the history of a stable structure does not contain it. An unbounded
    program is solved again, because a history keeps no ray. Steps of the loading path are not programs; they are
    computed again.

    Parameters
    ----------
    statics, problem
        Statics and limit problem of the history.
    history
        Iterations to replay; it may have no iterations.
    solver
        Solves the later programs.
    """

    def __init__(self, statics: Statics, problem: LimitProblem, history: xr.Dataset, solver: Solver) -> None:
        self._problem, self._solver = problem, solver
        self._history = history
        motion = [self._history[name].to_numpy() for name in ("block_velocity", "block_angular_velocity")]
        self._x = self._history["contact_force"].to_numpy() / problem.force_unit[:, None]
        self._T = np.zeros((len(self._x), 0))
        if len(problem.ties):
            self._T = self._history["tie_force"].to_numpy() / problem.ties.force_unit - problem.ties.prestress_D
        self._u = velocities_of(statics, problem, np.concatenate(motion, axis=2)) * problem.load_unit
        self._found_anew = np.isin(history["stage"].to_numpy(), [s.value for s in _FOUND_ANEW])
        self._next = 0

    def follow(self, steps: Steps) -> Steps:
        """Yield the steps of a case while they agree with its history.

        Raises
        ------
        FormatError
            If this version of blockstruct would solve other programs than the history has.
        """
        while True:
            try:
                step = next(steps)
            except StopIteration as stop:
                outcome: Outcome = stop.value
                return outcome
            if self._next < self._history.sizes["iteration"]:
                _compare(step, self._history.isel(iteration=self._next), self._next)
            self._next += 1
            yield step

    def solve(self, program: ConicProgram, data: ProgramData, tolerance: float) -> Solution:
        """Return the solution of one program."""
        k = self._next
        if program.problem is not self._problem or k >= len(self._u) or self._found_anew[k]:
            return self._solver.solve(program, data, tolerance)
        alpha = float(self._history["load_factor"][k]) * self._problem.load_unit
        if np.isposinf(alpha):
            return self._solver.solve(program, data, tolerance)
        y, z = np.zeros(program.G.shape[1]), np.zeros(program.G.shape[0])
        y[0] = alpha * program.unit
        y[1 : 1 + self._x[k].size] = self._x[k].ravel()
        y[program.tie_columns] = self._T[k]
        z[: program.zero_rows] = self._u[k] * program.total
        status = SolverStatus(str(self._history["solver_status"].to_numpy()[k]))
        iterations, time = (self._history[name].to_numpy()[k] for name in ("solver_iterations", "solver_time"))
        return Solution(status, y, z, int(iterations), float(time))


def kept_state(statics: Statics, problem: LimitProblem, history: xr.Dataset, last: Iteration) -> Iteration:
    """Return the last iteration with its numbers in a history.

    Conversion to SI units and back changes their last digits. A run that continues from the stored numbers alone ends
    with the same digits as a run that was killed and resumed.
    """
    row = history.isel(iteration=[-1])
    motion = np.concatenate([row[name].to_numpy() for name in ("block_velocity", "block_angular_velocity")], axis=2)
    tie_force = row["tie_force"].to_numpy()[0] / problem.ties.force_unit if len(problem.ties) else last.tie_force
    return replace(
        last,
        load_factor=float(row["load_factor"][0]),
        x=row["contact_force"].to_numpy()[0] / problem.force_unit[:, None],
        u=velocities_of(statics, problem, motion)[0],
        tie_force=tie_force,
    )


def _compare(step: Iteration, stored: xr.Dataset, k: int) -> None:
    ours = (step.stage.value, step.c0, step.a)
    theirs = (str(stored["stage"].item()), float(stored["schedule_cohesion"]), float(stored["schedule_slope"]))
    if ours[0] != theirs[0] or not np.allclose(ours[1:], theirs[1:], rtol=1e-9, atol=0):
        msg = (
            f"iteration {k} of the history is the {theirs[0]} program with c0 = {theirs[1]:g} and a = {theirs[2]:g}, "
            f"but this version of blockstruct solves the {ours[0]} program with c0 = {ours[1]:g} and a = {ours[2]:g}; "
            "run the case anew"
        )
        raise FormatError(msg)
