"""The command, its options and exit codes."""

from __future__ import annotations

import contextlib
import io
import math
import os
import sys
import warnings
from collections.abc import Iterator
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console, ConsoleOptions
from rich.segment import Segment
from typer.core import TyperGroup

import blockstruct as bs
from blockstruct.vocabulary import printable

if TYPE_CHECKING:
    from rich.table import Table


def option(text: str, *names: str, default: bool | str = False) -> Any:
    """Return an option with its help; the help shows its default, another text instead, or neither."""
    return typer.Option(*names, help=text, show_default=default)


def argument(text: str) -> Any:
    """Return an argument with its help."""
    return typer.Argument(help=text, show_default=False)


class Exit(IntEnum):
    """Exit codes; the last two follow the signals SIGINT and SIGPIPE."""

    DIFFERENT = 1
    REFUSED = 2
    NO_LOAD_FACTOR = 3
    VIOLATIONS = 4
    INTERRUPTED = 130
    UNREAD = 141


#: Width, in characters, that no table reaches.
_WHOLE = 10_000


class _Console(Console):
    """A console that prints no control of a text, and lets the command decide how to end without a reader."""

    def render(self, renderable: Any, options: Any = None) -> Iterator[Segment]:
        """Render with the characters of other people's texts escaped; rich writes its own controls later."""
        for text, style, control in super().render(renderable, options):
            yield Segment(text if control else printable(text), style, control)

    @property
    def options(self) -> ConsoleOptions:
        """Options of a print; a pipe or a file has lines of any length, so that tables stay whole."""
        return super().options if self.is_terminal else super().options.update_width(_WHOLE)

    def on_broken_pipe(self) -> None:
        """Raise the BrokenPipeError that is being handled."""
        raise


out = _Console(highlight=False)
err = _Console(stderr=True, highlight=False)


@contextlib.contextmanager
def _while_read() -> Iterator[None]:
    """Print while there is a reader, and then end silently, as after a SIGPIPE."""
    try:
        yield
    except BrokenPipeError:
        # Python flushes at exit, and would complain.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(nowhere, stream.fileno())
        raise SystemExit(Exit.UNREAD) from None


class _Commands(TyperGroup):
    """The commands, with a message after an interruption, which Typer lacks."""

    @_while_read()
    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as interrupt:
            err.print("\n".join(["interrupted", *getattr(interrupt, "__notes__", ())]), markup=False, soft_wrap=True)
            raise typer.Exit(Exit.INTERRUPTED) from None


app = typer.Typer(cls=_Commands, pretty_exceptions_enable=False, rich_markup_mode=None)

FileArgument = Annotated[Path, argument("An analysis file.")]
QuietOption = Annotated[bool, option("Print nothing but errors.", "--quiet", "-q")]
CsvOption = Annotated[Path | None, option("Write a .csv file instead.", "--csv")]
JsonOption = Annotated[bool, option("Print the results as JSON, instead of tables.", "--json")]


@_while_read()
def main() -> None:
    """Run the command; an input error gives one message and exit code 2, without a traceback."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        # A pipe on Windows, or the C locale, cannot encode every name of a model.
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        with warnings.catch_warnings():
            # Print the message of a warning without its line of code.
            warnings.showwarning = _show_warning
            # The text of every result contains its warnings.
            warnings.simplefilter("ignore", bs.errors.LoadFactorWarning)
            app()
    except bs.errors.BlockstructError as error:
        err.print("[bold red]error:[/]", end=" ")
        err.print(str(error), markup=False, soft_wrap=True)
        for note in getattr(error, "__notes__", ()):
            err.print(f"  {note}", markup=False, soft_wrap=True)
        raise SystemExit(Exit.REFUSED) from None


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    err.print("[bold yellow]warning:[/]", end=" ")
    err.print(str(message), markup=False, soft_wrap=True)


@app.callback(
    invoke_without_command=True,
    epilog="Exit codes: 0 done; 1 diff found differences; 2 refused input, with one message; "
    "3 a case ended without a load factor, or a pushover without a curve; 4 a file violates its schema; "
    "130 interrupted; 141 the reader of the output stopped.",
)
def top(
    context: typer.Context, version: Annotated[bool, option("Print the version and exit.", "--version")] = False
) -> None:
    """Collapse load of masonry structures: rigid-block limit analysis in 3D."""
    out.quiet = False
    if version:
        out.print(bs.__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        out.print(context.get_help(), markup=False)


def say(text: str) -> None:
    """Print a text without markup, and without breaking lines."""
    out.print(text, markup=False, soft_wrap=True)


def say_table(table: Table) -> None:
    """Print a table folded to the terminal, and wider if its numbers need more."""
    out.print(table, crop=False)


def print_results(analysis: bs.Analysis, *, iterations: bool = False) -> None:
    """Print every case with its certificate, on request with its iterations, and then a table."""
    from blockstruct.text.case import tilting_table
    from blockstruct.views.console import directions_text, iteration_table, result_text, summary_table
    from blockstruct.views.words import cells_of

    for result in analysis.values():
        if iterations:
            out.print(iteration_table(result.history))
        out.print(result_text(result), soft_wrap=True)
        if (angle := _angle_of_table(result)) is not None:
            say(f"  {tilting_table(angle)}\n")
    say_table(summary_table(analysis))
    for text in cells_of(analysis.values()):
        say(text)
    out.print(directions_text(analysis), markup=False, soft_wrap=True, end="")


def _angle_of_table(result: bs.CaseResult) -> float | None:
    """Return the angle, degrees, at which a structure falls on a tilting table.

    It is None unless weight is the only load.
    """
    if not isinstance(result.case, bs.LimitCase):
        return None
    dead, variable = result.case.dead.loads, result.case.variable.loads
    weight = all(isinstance(load, bs.SelfWeight) for load in dead) and len(dead) == 1
    if not weight or len(variable) != 1 or not isinstance(variable[0], bs.BodyForce):
        return None
    x, y, z = (variable[0].share * v for v in variable[0].direction)
    if z or result.status is not bs.Status.CONVERGED:
        return None
    # Cohesion and ties do not scale with the weight, so the table would give another result.
    joints = [i.joint_material for i in result.model.interfaces]
    if result.model.ties or any(j.cohesion or j.tensile_strength or j.compressive_strength < math.inf for j in joints):
        return None
    # On a table tilted by θ the weight W has W cos θ into the table and W sin θ along it.
    return math.degrees(math.atan(result.load_factor * math.hypot(x, y)))
