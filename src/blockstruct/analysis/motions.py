"""Follow motions beyond collapse and under records; resume cases.

To resume a case, its history answers the programs already solved. The procedure is deterministic: its next step depends
only on the problem, the settings and the earlier solutions. So it runs again from the start, with a solver that knows
the first solutions.
"""

import contextlib
from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from blockstruct.analysis.events import Listener, StateDone, StepDone, tell
from blockstruct.errors import FormatError
from blockstruct.limit import ConicProgram, Iteration, LimitProblem, Outcome
from blockstruct.limit.iteration import Steps, changed_steps, conclude
from blockstruct.limit.motion import velocities_of
from blockstruct.limit.program import ProgramData, Solution, Solver
from blockstruct.model import RecordCase, has_curve
from blockstruct.motion.curve import follow
from blockstruct.motion.moving_problem import MovingProblem
from blockstruct.motion.record import respond
from blockstruct.results.capacity import (
    arrays_of_response,
    beginning_of,
    capacity_of,
    response_of,
    state_arrays,
    steps_of,
)
from blockstruct.results.case_result import CaseResult
from blockstruct.results.history import forces_in, motions_in
from blockstruct.statics.statics import Statics
from blockstruct.vocabulary import Reason, SolverStatus, Stage, Status

_Item = TypeVar("_Item")
_Value = TypeVar("_Value")


def collect(
    steps: Generator[_Item, None, _Value], hear: Callable[[int, _Item], object], kept: Sequence[_Item] = ()
) -> tuple[list[_Item], _Value | None]:
    """Return the items of a generator after kept ones, and its value; None after a KeyboardInterrupt.

    A function hears each item with its number.
    """
    items = list(kept)

    def add(item: _Item) -> None:
        items.append(item)
        hear(len(items) - 1, item)

    with contextlib.suppress(KeyboardInterrupt):
        return items, conclude(steps, add)
    return items, None


def trace_curve(
    result: CaseResult, statics: Statics, problem: LimitProblem, collapse: Iteration, listeners: Iterable[Listener]
) -> CaseResult:
    """Trace a case beyond collapse, and return its result with the capacity curve.

    A curve that the result has already is continued. A KeyboardInterrupt ends it; the result is then interrupted.

    Parameters
    ----------
    result
        Converged result of a case with a curve.
    statics, problem
        Statics and limit problem of the result.
    collapse
        The collapse state.
    listeners
        Called with every state.
    """
    case, start = result.case, perf_counter()
    if not has_curve(case):
        return result
    kept = [] if result.capacity is None else steps_of(result.capacity)
    for k, state in enumerate(kept):
        tell(listeners, StepDone(case, k, state))
    going = follow(MovingProblem(statics, problem, case), collapse, result.settings, list(kept))
    states, ended = collect(going, lambda k, state: tell(listeners, StepDone(case, k, state)), kept)
    return replace(
        result,
        outcome=INTERRUPTED if ended is None else result.outcome,
        capacity=capacity_of(statics.model, case, state_arrays(states)) if states else None,
        curve_outcome=ended,
        duration=result.duration + perf_counter() - start,
    )


#: Outcome of a case that a KeyboardInterrupt ends.
INTERRUPTED = Outcome(Status.INTERRUPTED, np.nan, Reason.INTERRUPTED)
_STATUS = {
    Reason.AT_REST: Status.STANDS,
    Reason.BLOCKS_FALLEN: Status.COLLAPSES,
    Reason.STILL_MOVING: Status.UNDECIDED,
    Reason.STEP_NOT_SOLVED: Status.UNDECIDED,
}


def trace_record(result: CaseResult, statics: Statics, case: RecordCase, listeners: Iterable[Listener]) -> CaseResult:
    """Trace a structure under a record, and return its result with the response.

    A response that the result already has is continued. A KeyboardInterrupt ends it; the result is then interrupted.

    Parameters
    ----------
    result
        Result of the dead load, which the structure carries.
    statics
        Statics of the model.
    case
        The record.
    listeners
        Called with every state.
    """
    start, last, count = perf_counter(), None, 0
    pieces: list[Any] = []
    if result.response is not None:
        k, last = beginning_of(result.response)
        count = k + 1
        is_kept = result.response["state_of_contact"] <= k
        pieces.append(arrays_of_response(result.response.isel(time=slice(count), contact=is_kept.to_numpy())))
    states, reason = collect(respond(statics, case, last), lambda k, s: tell(listeners, StateDone(case, count + k, s)))
    outcome = INTERRUPTED
    if reason is not None:
        last = states[-1] if states else last
        time = last.time if last is not None and reason is Reason.BLOCKS_FALLEN else np.nan
        outcome = Outcome(_STATUS[reason], np.nan, reason, collapse_time=time)
    pieces += [state_arrays(states)] if states else []
    response = None
    if pieces:
        response = response_of(statics.model, {name: np.concatenate([p[name] for p in pieces]) for name in pieces[0]})
    return replace(result, outcome=outcome, response=response, duration=result.duration + perf_counter() - start)


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
        self._x, T = forces_in(problem, history)
        self._T = T - problem.ties.prestress_D
        self._u = velocities_of(statics, problem, motions_in(history)) * problem.load_unit
        self._found_anew = np.isin(history["stage"].to_numpy(), [s.value for s in _FOUND_ANEW])
        self._next = 0

    def follow(self, steps: Steps) -> Steps:
        """Yield the steps of a case while they agree with its history.

        Raises
        ------
        FormatError
            If this version of blockstruct would solve other programs than the history has.
        """

        def compared(step: Iteration) -> Iteration:
            if self._next < self._history.sizes["iteration"]:
                _compare(step, self._history.isel(iteration=self._next), self._next)
            self._next += 1
            return step

        return changed_steps(steps, compared)

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
    x, T = forces_in(problem, row)
    u = velocities_of(statics, problem, motions_in(row))
    return replace(last, load_factor=float(row["load_factor"][0]), x=x[0], u=u[0], tie_force=T[0])


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
