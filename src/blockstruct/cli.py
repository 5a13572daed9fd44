"""The console command ``blockstruct``."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

import blockstruct as bs
from blockstruct.analysis import CaseFinished, CaseStarted, Event, IterationDone
from blockstruct.views import analysis_summary, history_frame, iteration_table, result_text, summary_table

app = typer.Typer(
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
#: Exit codes.
REFUSED, NO_LOAD_FACTOR, VIOLATIONS, INTERRUPTED = 2, 3, 4, 130

out = Console(highlight=False)
err = Console(stderr=True, highlight=False)

FileArgument = Annotated[Path, typer.Argument(help="An analysis file.", show_default=False)]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print the results as JSON, instead of tables.")]


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


@app.callback(
    invoke_without_command=True,
    epilog="Exit codes: 0 done; 2 refused input, with one message; 3 a case ended without a load factor; "
    "4 a file violates its schema; 130 interrupted.",
)
def top(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    """Collapse load of masonry structures: rigid-block limit analysis in 3D."""
    out.quiet = False
    if version:
        out.print(bs.__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        out.print(context.get_help(), markup=False)


@app.command()
def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write.")] = Path("blockstruct-demo.h5"),
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Push a wall with an opening sideways until it collapses, and keep the analysis."""
    out.quiet = quiet or as_json
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
    _run(model, cases, bs.ProcedureSettings(), output, quiet, as_json)


@app.command()
def run(
    model: Annotated[Path, typer.Argument(help="A model document, YAML or JSON.", show_default=False)],
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write.", show_default=False)],
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Run all cases of a model document and keep the analysis."""
    out.quiet = quiet or as_json
    document = bs.read_document(model)
    out.print(
        f"{document.model.name}: {len(document.model.blocks)} blocks, {document.report}", markup=False, soft_wrap=True
    )
    _run(document.model, list(document.cases), bs.ProcedureSettings.of(document.settings), output, quiet, as_json)


@app.command()
def show(file: FileArgument, as_json: JsonOption = False) -> None:
    """Print the results of an analysis, with their certificates."""
    analysis = bs.open_analysis(file)
    if as_json:
        typer.echo(json.dumps(analysis_summary(analysis), indent=2))
        return
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
    if csv is not None and csv.suffix.lower() != ".csv":
        msg = f"{csv}: give a name that ends in .csv"
        raise bs.StorageError(msg)
    result = bs.open_analysis(file)[case]
    if variable is None and csv is None:
        out.print(iteration_table(result.history))
        return
    frame = history_frame(result, variable)
    if csv is None:
        out.print(frame.to_string(), markup=False, soft_wrap=True)
        return
    try:
        frame.to_csv(csv)
    except OSError as error:
        msg = f"{csv}: cannot be written ({error.strerror or error}); choose another file"
        raise bs.StorageError(msg) from error
    out.print(f"{csv}: {len(frame)} rows", markup=False, soft_wrap=True)


@app.command()
def view(
    file: FileArgument,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="File to write; FILE.html otherwise.", show_default=False)
    ] = None,
    show_it: Annotated[bool, typer.Option("--open", help="Show the page in the browser.")] = False,
) -> None:
    """Write an interactive page of an analysis: structure, mechanism, forces, states of all iterations."""
    from blockstruct.views.page import write_page

    _written(write_page(bs.open_analysis(file), output or file.with_suffix(".html")), show_it)


@app.command()
def report(
    file: FileArgument,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="File to write; FILE-report.html otherwise.", show_default=False),
    ] = None,
    template: Annotated[
        Path | None, typer.Option("--template", help="A Jinja2 template of your own.", show_default=False)
    ] = None,
    show_it: Annotated[bool, typer.Option("--open", help="Show the report in the browser.")] = False,
) -> None:
    """Write a report of an analysis, to read and to print."""
    from blockstruct.views.report import write_report

    target = output or file.with_name(f"{file.stem}-report.html")
    _written(write_report(bs.open_analysis(file), target, template=template), show_it)


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


def _written(path: Path, show_it: bool) -> None:
    out.print(f"written: {path}, {path.stat().st_size / 1e6:.1f} MB", markup=False, soft_wrap=True)
    if show_it:
        typer.launch(path.resolve().as_uri())


def _run(
    model: bs.Model,
    cases: list[bs.LimitCase],
    settings: bs.ProcedureSettings,
    output: Path,
    quiet: bool,
    as_json: bool,
) -> None:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=20),
        TimeElapsedColumn(),
        TextColumn("{task.fields[rest]}"),
    )
    drawn = err.is_terminal and not quiet
    with Progress(*columns, console=err, transient=True, disable=not drawn) as progress:
        listeners = [] if quiet else [_bar(progress, settings) if drawn else bs.print_lines()]
        manager = bs.AnalysisManager(model, output, settings=settings, listeners=listeners)
        analysis = manager.run(cases)
    for result in analysis.values():
        out.print(iteration_table(result.history))
        out.print(result_text(result), soft_wrap=True)
    out.print(summary_table(analysis))
    out.print(f"written: {output}", markup=False, soft_wrap=True)
    if as_json:
        typer.echo(json.dumps(analysis_summary(analysis), indent=2))
    if any(r.status is not bs.Status.CONVERGED for r in analysis.values()):
        raise typer.Exit(NO_LOAD_FACTOR)


def _bar(progress: Progress, settings: bs.ProcedureSettings) -> Callable[[Event], None]:
    task = progress.add_task("", total=1, rest="")

    def listen(event: Event) -> None:
        match event:
            case CaseStarted(case):
                # A case is usually certified soon after it may be: when its patience ends, by two more programs.
                usual = settings.patience + 2 if case.flow is bs.Flow.NONASSOCIATIVE else 1
                progress.reset(task, description=case.name, total=usual, rest="")
            case IterationDone(case, index, iteration):
                done, total = index + 1, progress.tasks[task].total or 1
                left = (progress.tasks[task].elapsed or 0.0) / done * (total - done)
                text = (
                    f"{case.name}: {index} {iteration.stage}, α = {iteration.load_factor:.4f}, "
                    f"gap {iteration.certificate.flow_rule_gap:.0e}"
                )
                rest = f"about {left:.0f} s left" if done < total else "longer than usual"
                progress.update(task, completed=min(done, total), description=text, rest=rest)
            case CaseFinished():
                progress.update(task, completed=progress.tasks[task].total, rest="")

    return listen
