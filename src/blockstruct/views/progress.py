"""Progress of a run in a terminal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

import blockstruct as bs
from blockstruct.analysis import CaseFinished, CaseStarted, Event, IterationDone, Listener, StateDone, StepDone

#: Programs and steps of a typical non-associative case: 7 to 11 on walls of 8 to 34 blocks.
_USUAL = 12


@contextmanager
def following(console: Console, *, quiet: bool) -> Iterator[list[Listener]]:
    """Return listeners that show a run: a bar on a terminal, else lines; none if quiet."""
    columns = (
        # Names of cases are not markup.
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=20),
        TimeElapsedColumn(),
        TextColumn("{task.fields[rest]}"),
    )
    drawn = console.is_terminal and not quiet
    progress = Progress(*columns, console=console, transient=True)
    # Do not begin instead of disabling: rich before 14.3 ends a disabled bar with an empty line.
    with progress if drawn else nullcontext():
        yield [] if quiet else [bar(progress) if drawn else bs.analysis.print_lines()]


@contextmanager
def study_following(console: Console, *, quiet: bool) -> Iterator[list[Callable[[bs.studies.StudyProgress], None]]]:
    """Return listeners that show a study: a bar on a terminal, else two lines."""
    columns = (BarColumn(bar_width=20), TextColumn("{task.description}", markup=False))
    drawn = console.is_terminal and not quiet

    def tell(progress: bs.studies.StudyProgress) -> None:
        if progress.done == progress.total:
            console.print(str(progress), markup=False, soft_wrap=True)

    shown = Progress(*columns, console=console, transient=True)
    with shown if drawn else nullcontext():
        task = shown.add_task("", total=None)

        def move(progress: bs.studies.StudyProgress) -> None:
            shown.update(task, completed=progress.done, total=progress.total, description=str(progress))

        yield [] if quiet else [move, tell] if drawn else [tell]


def bar(progress: Progress) -> Listener:
    """Return a listener that moves a bar, with iteration, load factor, gap and the usual remaining time."""
    task, place = progress.add_task("", total=1, rest=""), ""

    def listen(event: Event) -> None:
        nonlocal place
        match event:
            case CaseStarted(case):
                place = f"case {event.number} of {event.count}, " if event.count > 1 else ""
                usual = _USUAL if case.flow is bs.Flow.NONASSOCIATIVE else 1
                progress.reset(task, description=f"{place}{case.name}", total=usual, rest="")
            case IterationDone(case, index, iteration):
                done, total = index + 1, progress.tasks[task].total or 1
                left = (progress.tasks[task].elapsed or 0.0) / done * (total - done)
                text = (
                    f"{place}{case.name}: numerical iteration {index}, {_answer(case, iteration)}, "
                    f"gap {iteration.certificate.flow_rule_gap:.0e}"
                )
                rest = f"about {left:.0f} s left" if done < total else "longer than usual"
                progress.update(task, completed=min(done, total), description=text, rest=rest)
            case StepDone(case, index, step):
                text = f"{case.name}: step {index}, {step.displacement * 1e3:.1f} mm, {_answer(case, step)}"
                progress.update(task, completed=min(index, case.steps), total=case.steps, description=text, rest="")
            case StateDone(case, index, state):
                share = min((state.time - float(case.times[0])) / case.duration, 1.0)
                left = (progress.tasks[task].elapsed or 0.0) * (1 - share) / max(share, 1e-9)
                rest = f"about {left:.0f} s left" if 0 < share < 1 else ""
                text = f"{place}{case.name}: {state.time:.2f} s of {case.duration:.4g} s"
                progress.update(task, completed=share, total=1.0, description=text, rest=rest)
            case CaseFinished():
                progress.update(task, completed=progress.tasks[task].total, rest="")

    return listen


def _answer(case: Any, state: Any) -> str:
    alpha = state.load_factor
    return f"R = {-alpha:.4f} of the dead load" if isinstance(case, bs.SettlementCase) else f"α = {alpha:.4f}"
