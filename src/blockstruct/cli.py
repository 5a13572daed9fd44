"""The console command ``blockstruct``."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

import blockstruct as bs
from blockstruct.analysis import CaseFinished, CaseStarted, Event, IterationDone
from blockstruct.views import archive_table, iteration_table, result_text, summary_table

app = typer.Typer(
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
#: Exit codes.
DIFFERENT, REFUSED, NO_LOAD_FACTOR, VIOLATIONS, INTERRUPTED = 1, 2, 3, 4, 130

out = Console(highlight=False)
err = Console(stderr=True, highlight=False)

FileArgument = Annotated[Path, typer.Argument(help="An analysis file.", show_default=False)]


def main() -> None:
    """Run the command; an error of the input is one message and exit code 2, never a traceback."""
    try:
        app()
    except bs.BlockstructError as error:
        err.print("[bold red]error:[/]", end=" ")
        err.print(str(error), markup=False, soft_wrap=True)
        for note in getattr(error, "__notes__", ()):
            err.print(f"  {note}", markup=False, soft_wrap=True)
        raise SystemExit(REFUSED) from None
    except KeyboardInterrupt:
        err.print("interrupted", markup=False)
        raise SystemExit(INTERRUPTED) from None


@app.callback(invoke_without_command=True)
def top(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    """Collapse load of masonry structures: rigid-block limit analysis in 3D."""
    if version:
        out.print(bs.__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        out.print(context.get_help(), markup=False)


@app.command()
def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write.")] = Path("blockstruct-demo.h5"),
) -> None:
    """Push a wall with an opening sideways until it collapses, and keep the analysis."""
    tuff = bs.Material("tuff", unit_weight="12 kN/m^3")
    lime = bs.JointMaterial("lime mortar", friction_coefficient=0.65)
    solid, half = [1.0, 1, 1, 1], [0.5, 1, 1, 1, 0.5]
    jamb, toothed = [0.5, 1, -1, 1, 0.5], [1, 0.5, -1, 0.5, 1]
    rows = [solid, half, solid, jamb, toothed, jamb, solid, half, solid]
    blocks = bs.courses(rows, unit_length="0.4 m", unit_height="0.175 m", depth="0.3 m", material=tuff)
    found = bs.detect_interfaces(blocks, joint_material=lime)
    model = bs.Model("wall with an opening", blocks, found.interfaces)
    dead = bs.LoadPattern("self-weight", [bs.SelfWeight()])
    push = bs.LoadPattern("weight sideways, +x", [bs.BodyForce((1, 0, 0))])
    cases = [bs.LimitCase(f"push +x, {flow}", dead, push, flow) for flow in bs.Flow]
    out.print(f"{model.name}: {len(model.blocks)} blocks, {found.report}", markup=False, soft_wrap=True)
    _run(model, cases, bs.ProcedureSettings(), output)


@app.command()
def run(
    model: Annotated[Path, typer.Argument(help="A model document, YAML or JSON.", show_default=False)],
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write.", show_default=False)],
) -> None:
    """Run all cases of a model document and keep the analysis."""
    document = bs.read_document(model)
    out.print(
        f"{document.model.name}: {len(document.model.blocks)} blocks, {document.report}", markup=False, soft_wrap=True
    )
    _run(document.model, list(document.cases), bs.ProcedureSettings.of(document.settings), output, document.hash)


@app.command()
def show(file: FileArgument) -> None:
    """Print the results of an analysis, with their certificates."""
    analysis = bs.open_analysis(file)
    model = analysis.model
    out.print(f"{model.name}: {len(model.blocks)} blocks, {len(model.interfaces)} interfaces", markup=False)
    out.print(f"model hash {model.hash[:16]}…, created {analysis.created_at}, {analysis.status}", markup=False)
    out.print(f"blockstruct {analysis.versions.get('blockstruct')}", markup=False)
    for result in analysis.values():
        out.print(result_text(result), soft_wrap=True)
    out.print(summary_table(analysis))


@app.command()
def history(
    file: FileArgument,
    case: Annotated[str, typer.Argument(help="Name of a case.", show_default=False)],
    variable: Annotated[
        str | None,
        typer.Option(
            "--variable",
            help="Print one variable: any of the history, or state, force, moment, eccentricity of the interfaces.",
            show_default=False,
        ),
    ] = None,
    csv: Annotated[Path | None, typer.Option("--csv", help="Write a .csv file instead.", show_default=False)] = None,
) -> None:
    """Print the iteration history of a case."""
    result = bs.open_analysis(file)[case]
    if variable is None and csv is None:
        out.print(iteration_table(result.history))
        return
    frame = result.history.blockstruct.frame(variable)
    if csv is None:
        out.print(frame.to_string(), markup=False, soft_wrap=True)
        return
    _write_csv(frame, csv)


@app.command()
def archive(
    folder: Annotated[Path, typer.Argument(help="A folder of analysis files.", show_default=False)],
    query: Annotated[
        str | None,
        typer.Option("--query", help='Rows to print, such as "load_factor < 0.3".', show_default=False),
    ] = None,
    csv: Annotated[Path | None, typer.Option("--csv", help="Write a .csv file instead.", show_default=False)] = None,
) -> None:
    """Print a row for each case of the analyses in a folder and its subfolders."""
    found = bs.Archive(folder)
    table = found.table() if query is None else found.query(query)
    if csv is None:
        out.print(archive_table(table))
        for path, problem in table.loc[table["problem"] != "", ["path", "problem"]].itertuples(index=False):
            out.print(f"{path}: {problem}", markup=False, soft_wrap=True)
        return
    _write_csv(table.set_index(["path", "case"]), csv)


@app.command()
def diff(
    one: Annotated[Path, typer.Argument(help="An analysis file, or a folder of them.", show_default=False)],
    other: Annotated[Path, typer.Argument(help="Another one.", show_default=False)],
    tolerance: Annotated[float, typer.Option("--tolerance", help="Relative tolerance of load factors.")] = 1e-6,
) -> None:
    """Compare two analyses, or two folders of them, case by case; exit code 1 if they differ."""
    if one.is_dir():
        table = bs.Archive(one).difference(bs.Archive(other))
        same = bool((table["relative_difference"].abs() <= tolerance).all())
        out.print(table.drop(columns=["model_hash", "model_hash_other"]).to_string(), markup=False, soft_wrap=True)
    else:
        found = bs.compare(bs.open_analysis(one), bs.open_analysis(other))
        same = found.agrees(tolerance)
        out.print(str(found), markup=False, soft_wrap=True)
    if not same:
        raise typer.Exit(DIFFERENT)


@app.command()
def recover(file: FileArgument) -> None:
    """Make the file of a run that was killed, with every iteration that it committed."""
    analysis = bs.recover(file)
    out.print(str(analysis), markup=False, soft_wrap=True)
    out.print(f"written: {file}", markup=False, soft_wrap=True)


@app.command()
def resume(file: FileArgument) -> None:
    """Go on with a run that was killed or interrupted, from its last committed iteration."""
    with _followed() as listener:
        analysis = bs.AnalysisManager.resume(file, listeners=[listener])
    _report(analysis, file)


@app.command()
def validate(
    file: Annotated[Path, typer.Argument(help="An analysis file, or a model document.", show_default=False)],
) -> None:
    """Check an analysis file or a model document against its schema."""
    try:
        if file.suffix.lower() in (".yaml", ".yml", ".json"):
            document = bs.read_document(file)
            settings = bs.ProcedureSettings.of(document.settings)
            bs.AnalysisManager(document.model, settings=settings).check(document.cases)
            out.print(f"{file}: a valid model document", markup=False, soft_wrap=True)
            out.print(f"{len(document.model.blocks)} blocks, {document.report}", markup=False, soft_wrap=True)
        else:
            analysis = bs.open_analysis(file)
            out.print(f"{file}: a valid analysis of {len(analysis)} cases", markup=False, soft_wrap=True)
    except (bs.FormatError, bs.ModelError) as error:
        out.print("\n".join([str(error), *getattr(error, "__notes__", ())]), markup=False, soft_wrap=True)
        raise typer.Exit(VIOLATIONS) from None


def _run(
    model: bs.Model, cases: list[bs.LimitCase], settings: bs.ProcedureSettings, output: Path, document_hash: str = ""
) -> None:
    with _followed() as listener:
        manager = bs.AnalysisManager(
            model, output, settings=settings, listeners=[listener], document_hash=document_hash
        )
        analysis = manager.run(cases)
    _report(analysis, output)


def _report(analysis: bs.Analysis, output: Path) -> None:
    for result in analysis.values():
        out.print(iteration_table(result.history))
        out.print(result_text(result), soft_wrap=True)
    out.print(summary_table(analysis))
    out.print(f"written: {output}", markup=False, soft_wrap=True)
    if any(r.status is not bs.Status.CONVERGED for r in analysis.values()):
        raise typer.Exit(NO_LOAD_FACTOR)


def _write_csv(frame: pd.DataFrame, path: Path) -> None:
    if path.suffix.lower() != ".csv":
        msg = f"{path}: give a name that ends in .csv"
        raise bs.StorageError(msg)
    try:
        frame.to_csv(path)
    except OSError as error:
        msg = f"{path}: cannot be written ({error.strerror or error}); choose another file"
        raise bs.StorageError(msg) from error
    out.print(f"{path}: {len(frame)} rows", markup=False, soft_wrap=True)


@contextmanager
def _followed() -> Iterator[Callable[[Event], None]]:
    """Listener that shows how a run goes on: a bar on a terminal, a line an event elsewhere."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f}/{task.total:.0f} programs at most"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as progress:
        yield _bar(progress) if err.is_terminal else bs.print_lines()


def _bar(progress: Progress) -> Callable[[Event], None]:
    most = bs.ProcedureSettings().max_programs
    task = progress.add_task("", total=most)

    def listen(event: Event) -> None:
        match event:
            case CaseStarted(case):
                progress.reset(task, description=case.name, total=most)
            case IterationDone(case, index, iteration):
                text = f"{case.name}: load factor {iteration.load_factor:.4f}"
                progress.update(task, completed=index + 1, description=text)
            case CaseFinished():
                progress.update(task, completed=most)

    return listen
