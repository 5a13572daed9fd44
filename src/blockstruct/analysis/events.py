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
from blockstruct.motion.state import MotionState
from blockstruct.notebook import in_notebook, is_terminal, is_watched
from blockstruct.results.case_result import CaseResult
from blockstruct.statics.statics import Statics
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


def describe(event: Event) -> tuple[str, float]:
    """Return a text on an event, and the share of its case that is done, 1 at its end."""
    match event:
        case CaseStarted(case, blocks, points):
            how = case.question if isinstance(case, RecordCase) else f"{case.flow} flow"
            return f"{counted(blocks, 'block')}, {counted(points, 'contact point')}, {how}", 0.0
        case IterationDone(case, index, i):
            at = f"{_answer(case, i)}, gap {i.certificate.flow_rule_gap:.0e}, {in_words(i.stage)}"
            return f"numerical iteration {index}, {at}", 1 - 1 / (index + 2)
        case StepDone(case, index, step):
            at = f"displacement {step.displacement:.4g} m, {_answer(case, step)}"
            return f"state {index}, {at}", min(index / case.steps, 0.99)
        case StateDone(case, _, state):
            elapsed = state.time - float(case.times[0])
            if elapsed > case.duration:
                return f"{elapsed - case.duration:.2f} s after the record, not yet at rest", 0.99
            return f"{elapsed:.2f} s of {case.duration:.4g} s", min(elapsed / case.duration, 0.99)
        case CaseFinished(result):
            states = result.response if result.capacity is None else result.capacity
            count = counted(result.n_iterations, "numerical iteration")
            count = count if states is None else counted(len(states["displacement"]), "state")
            return f"{result.status.words} after {count}", 1.0


def _answer(case: Case, iteration: Iteration | MotionState) -> str:
    if isinstance(case, SettlementCase):
        return f"reaction {-iteration.load_factor:.4f} of the dead load"
    return f"load factor {iteration.load_factor:.4f}"


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
        text, done = describe(event)
        if isinstance(event, CaseStarted):
            begin = perf_counter()
            place = f"case {event.number} of {event.count}, " * (event.count > 1) + event.case.name
        elif isinstance(event, StateDone) and 0 < done < 0.99:
            text += f", about {(perf_counter() - begin) * (1 - done) / done:.0f} s left"
        write(f"{place}: {text}", done)

    return listen


def print_lines() -> Listener:
    """Return a listener that prints a line per event to stderr; of a record, every 40th state."""
    listen = follow(lambda text, _: print(text, file=sys.stderr, flush=True))
    return lambda event: None if isinstance(event, StateDone) and event.index % _EVERY else listen(event)


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
