"""Progress of a run: one line, rewritten with every event."""

import shutil
import sys
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any, Literal

from blockstruct.analysis.events import (
    CaseFinished,
    CaseStarted,
    Event,
    IterationDone,
    Listener,
    StateDone,
    StepDone,
    answer_of,
    print_lines,
)
from blockstruct.errors import ModelError, shown
from blockstruct.notebook import in_notebook, is_terminal, is_watched
from blockstruct.vocabulary import counted

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


def follow(write: Callable[[str, bool], None]) -> Listener:
    """Return a listener that writes progress, and whether a case ended."""
    place, begin = "", 0.0

    def listen(event: Event) -> None:
        nonlocal place, begin
        match event:
            case CaseStarted(case, blocks):
                begin = perf_counter()
                place = f"case {event.number} of {event.count}, {case.name}:"
                write(f"{place} {counted(blocks, 'block')}, {case.flow} flow", False)
            case IterationDone(case, index, iteration):
                at = f"{answer_of(case, iteration, 4)}, gap {iteration.certificate.flow_rule_gap:.0e}"
                write(f"{place} numerical iteration {index}, {at}", False)
            case StepDone(_, index, step):
                at = f"displacement {step.displacement:.4g} m, load factor {step.load_factor:.4f}"
                write(f"{place} state {index}, {at}", False)
            case StateDone(case, _, state):
                share = (state.time - float(case.times[0])) / case.duration
                left = (perf_counter() - begin) * (1 - share) / share if 0 < share < 1 else 0.0
                rest = f"about {left:.0f} s left" if left else "until the structure is at rest"
                write(f"{place} {state.time:.2f} s of {case.duration:.4g} s, {rest}", False)
            case CaseFinished(result):
                count = counted(result.n_iterations, "numerical iteration")
                write(f"{place} {result.status.words} after {count}", True)

    return listen


def _terminal_line(text: str, ended: bool) -> None:
    """Write over the previous line; erase it when a case has ended."""
    width = shutil.get_terminal_size().columns - 1
    sys.stderr.write(f"\r{'' if ended else text[:width]:<{width}}" + ("\r" if ended else ""))
    sys.stderr.flush()


def _notebook_line() -> Callable[[str, bool], None]:
    """Return a writer to one output of the cell, replaced with every event."""
    display = sys.modules["IPython"].display.display
    handle: Any = None

    def write(text: str, _: bool) -> None:
        nonlocal handle
        content = {"text/plain": text}
        if handle is None:
            handle = display(content, raw=True, display_id=True)
        else:
            handle.update(content, raw=True)

    return write
