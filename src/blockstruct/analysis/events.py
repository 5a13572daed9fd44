"""Events that a running analysis sends to its listeners, and listeners that print them or show the progress."""

import shutil
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, Literal

from blockstruct.errors import ModelError, shown
from blockstruct.limit import Iteration, LimitProblem
from blockstruct.limit.response import RecordState
from blockstruct.model import Case, MovingCase, RecordCase, SettlementCase
from blockstruct.motion import MotionState
from blockstruct.notebook import in_notebook, is_terminal, is_watched
from blockstruct.results.case_result import CaseResult
from blockstruct.statics import Statics
from blockstruct.vocabulary import counted, in_words


@dataclass(frozen=True, slots=True)
class CaseStarted:
    """A case begins: case ``number``, from one, of ``count`` cases.

    ``blocks`` and ``contact_points`` give its size. :func:`blockstruct.results.history_of` makes a history from
    ``statics``, ``problem`` and the iterations.
    """

    case: Case
    blocks: int
    contact_points: int
    statics: Statics = field(repr=False)
    problem: LimitProblem = field(repr=False)
    number: int = 1
    count: int = 1


@dataclass(frozen=True, slots=True)
class IterationDone:
    """A program of a case is solved; ``index`` counts from zero."""

    case: Case
    index: int
    iteration: Iteration


@dataclass(frozen=True, slots=True)
class StepDone:
    """A pushover or a settlement has a new state.

    ``index`` counts from zero, the state without displacement.
    """

    case: MovingCase
    index: int
    step: MotionState


@dataclass(frozen=True, slots=True)
class StateDone:
    """The response to a record has a new state; ``index`` counts from zero, the state at rest."""

    case: RecordCase
    index: int
    state: RecordState


@dataclass(frozen=True, slots=True)
class CaseFinished:
    """A case has ended, with any status."""

    result: CaseResult


#: States of a record for a printed line.
_EVERY = 40

Event = CaseStarted | IterationDone | StepDone | StateDone | CaseFinished
Listener = Callable[[Event], None]


def tell(listeners: Iterable[Listener], event: Event) -> None:
    """Send an event to all listeners, in order."""
    for listener in listeners:
        listener(event)


def print_lines() -> Listener:
    """Return a listener that prints a line per event to stderr; of a record, every 40th state."""

    def listen(event: Event) -> None:
        if not isinstance(event, StateDone) or event.index % _EVERY == 0:
            print(describe(event), file=sys.stderr, flush=True)

    return listen


def describe(event: Event) -> str:
    """Return one line of text on an event."""
    match event:
        case CaseStarted(case, blocks, points):
            place = f" (case {event.number} of {event.count})" if event.count > 1 else ""
            size = f"{counted(blocks, 'block')}, {counted(points, 'contact point')}"
            how = case.question if isinstance(case, RecordCase) else f"{case.flow} flow"
            return f"{case.name}{place}: {size}, {how}"
        case IterationDone(case, index, i):
            return (
                f"{case.name}: {index:3d} {in_words(i.stage):<16} {answer_of(case, i, 6)}, "
                f"gap {i.certificate.flow_rule_gap:.1e}, {in_words(i.solver_status)} in {i.solver_time:.2f} s"
            )
        case StepDone(case, index, step):
            return (
                f"{case.name}: {index:3d} displacement {step.displacement:.4f} m, {answer_of(case, step, 6)}, "
                f"energy error {step.energy_error:.1e}, in {step.solver_time:.2f} s"
            )
        case StateDone(case, _, state):
            largest = 1e3 * float(state.peak_displacement.max())
            return f"{case.name}: {state.time:8.3f} s, {state.steps} steps, largest displacement {largest:.4g} mm"
        case CaseFinished(result):
            return str(result)


def answer_of(case: Case, iteration: Iteration | MotionState, digits: int) -> str:
    """Return the load factor, or the reaction of a settlement, as text.

    ``digits`` is the number of decimals.
    """
    if isinstance(case, SettlementCase):
        return f"reaction {-iteration.load_factor:.{digits}f} of the dead load"
    return f"load factor {iteration.load_factor:.{digits}f}"


Progress = bool | Literal["auto"]


def with_progress(listeners: Sequence[Listener], progress: Progress) -> tuple[Listener, ...]:
    """Return the listeners, plus one that shows the progress if wanted.

    Parameters
    ----------
    listeners
        Listeners of the caller.
    progress
        ``"auto"`` shows the progress on a terminal or in a notebook, unless there are listeners.

    Raises
    ------
    ModelError
        If ``progress`` has another value.
    """
    if progress not in (True, False, "auto"):
        msg = f"AnalysisManager: progress is {shown(progress)}; give True, False or 'auto'"
        raise ModelError(msg)
    if progress is False or (progress == "auto" and (listeners or not is_watched())):
        return tuple(listeners)
    if in_notebook():
        return (*listeners, follow(_notebook_line()))
    return (*listeners, follow(_terminal_line) if is_terminal(sys.stderr) else print_lines())


def follow(write: Callable[[str, float], None]) -> Listener:
    """Return a listener that writes progress: a text, and the share of the case that is done, 1 at its end."""
    place, begin = "", 0.0

    def listen(event: Event) -> None:
        nonlocal place, begin
        match event:
            case CaseStarted(case, blocks):
                begin = perf_counter()
                place = f"case {event.number} of {event.count}, {case.name}:"
                write(f"{place} {counted(blocks, 'block')}, {case.flow} flow", 0.0)
            case IterationDone(case, index, iteration):
                at = f"{answer_of(case, iteration, 4)}, gap {iteration.certificate.flow_rule_gap:.0e}"
                write(f"{place} numerical iteration {index}, {at}", (index + 1) / (index + 2))
            case StepDone(case, index, step):
                at = f"displacement {step.displacement:.4g} m, {answer_of(case, step, 4)}"
                write(f"{place} state {index}, {at}", min(index / case.steps, 0.99))
            case StateDone(case, _, state):
                share = (state.time - float(case.times[0])) / case.duration
                left = (perf_counter() - begin) * (1 - share) / share if 0 < share < 1 else 0.0
                rest = f"about {left:.0f} s left" if left else "until the structure is at rest"
                write(f"{place} {state.time:.2f} s of {case.duration:.4g} s, {rest}", min(share, 0.99))
            case CaseFinished(result):
                states = result.response if result.capacity is None else result.capacity
                count = counted(result.n_iterations, "numerical iteration")
                count = count if states is None else counted(len(states["displacement"]), "state")
                write(f"{place} {result.status.words} after {count}", 1.0)

    return listen


def _terminal_line(text: str, done: float) -> None:
    """Write over the previous line; erase it when a case has ended."""
    width = shutil.get_terminal_size().columns - 1
    sys.stderr.write(f"\r{'' if done == 1 else text[:width]:<{width}}" + ("\r" if done == 1 else ""))
    sys.stderr.flush()


def _notebook_line() -> Callable[[str, float], None]:
    """Return a writer to one output of the cell, replaced with every event."""
    display = sys.modules["IPython"].display.display
    handle: Any = None

    def write(text: str, _: float) -> None:
        nonlocal handle
        content = {"text/plain": text}
        if handle is None:
            handle = display(content, raw=True, display_id=True)
        else:
            handle.update(content, raw=True)

    return write
