"""The console command ``blockstruct``."""

import json
import warnings
from pathlib import Path
from typing import Annotated, Any

import pandas as pd
import typer
from rich.console import Console

import blockstruct as bs
from blockstruct.views import (
    analysis_summary,
    archive_table,
    following,
    iteration_table,
    model_text,
    result_text,
    spread_text,
    summary_table,
)

app = typer.Typer(
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
#: Exit codes.
DIFFERENT, REFUSED, NO_LOAD_FACTOR, VIOLATIONS, INTERRUPTED = 1, 2, 3, 4, 130

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
    model = bs.Model("wall with an opening", blocks, found.interfaces, detection=found.report)
    dead = bs.LoadPattern("self-weight", [bs.SelfWeight()])
    push = bs.LoadPattern("weight sideways, +x", [bs.BodyForce((1, 0, 0))])
    cases = [bs.LimitCase(f"push +x, {flow}", dead, push, flow) for flow in bs.Flow]
    out.print(f"{model.name}: {len(model.blocks)} blocks, {found.report}", markup=False, soft_wrap=True)
    _run(model, cases, bs.ProcedureSettings(), output, quiet, as_json)


@app.command()
def run(
    model: Annotated[Path, typer.Argument(help="A model document, YAML or JSON.", show_default=False)],
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write.", show_default=False)],
    spread: Annotated[bool, typer.Option("--spread", help="Also run the other schedules, and their spread.")] = False,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Run all cases of a model document and keep the analysis."""
    out.quiet = quiet or as_json
    document = bs.read_document(model)
    out.print(
        f"{document.model.name}: {len(document.model.blocks)} blocks, {document.report}", markup=False, soft_wrap=True
    )
    settings = bs.ProcedureSettings.of(document.settings)
    _run(document.model, list(document.cases), settings, output, quiet, as_json, document.hash, spread=spread)


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
    out.print(spread_text(analysis), markup=False, soft_wrap=True, end="")


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
    with following(err, quiet=False) as listeners:
        analysis = bs.AnalysisManager.resume(file, listeners=listeners)
    _report(analysis, file)


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


@app.command("import")
def import_(
    files: Annotated[
        list[Path],
        typer.Argument(help="OBJ, STL or PLY meshes, a DXF drawing or a COMPAS JSON file.", show_default=False),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Model document to write.", show_default=False)],
    unit: Annotated[str, typer.Option(help="Unit of the coordinates: mm, or '0.025 m'.", show_default=False)],
    unit_weight: Annotated[
        list[str],
        typer.Option(help="Of all blocks, '20 kN/m^3', or of a DXF layer, 'WALL=20 kN/m^3'.", show_default=False),
    ],
    friction: Annotated[float, typer.Option(help="Friction coefficient of all joints.", show_default=False)],
    fix: Annotated[
        list[str] | None, typer.Option(help="A support: the name of a block, or lowest.", show_default=False)
    ] = None,
    fix_layer: Annotated[list[str] | None, typer.Option(help="A DXF layer of supports.", show_default=False)] = None,
    thickness: Annotated[
        str | None, typer.Option(help="Of a wall drawn in DXF, as in '30 cm'.", show_default=False)
    ] = None,
    segments: Annotated[int | None, typer.Option(help="Straight pieces of a DXF arc.", show_default=False)] = None,
    gap: Annotated[
        str | None, typer.Option(help="Largest gap in a joint, as in '1 mm'.", show_default="what rounding needs")
    ] = None,
) -> None:
    """Write a model document from blocks drawn elsewhere, then check it."""
    fixed = "lowest" if fix == ["lowest"] else fix or ()
    drawn = files[0].suffix.lower() == ".dxf"
    if len(files) > 1 and any(f.suffix.lower() in (".dxf", ".json") for f in files):
        msg = f"{len(files)} files; several can only be read if all are meshes, import the others one by one"
        raise bs.ModelError(msg)
    if not drawn and (fix_layer or thickness or segments or any("=" in w for w in unit_weight)):
        msg = f"{files[0]}: layers, --thickness and --segments belong to DXF drawings; leave them out"
        raise bs.ModelError(msg)
    material = _materials(unit_weight)
    with warnings.catch_warnings():
        # The report that is printed says the same.
        warnings.simplefilter("ignore", bs.GeometryWarning)
        if drawn:
            found = bs.read_drawing(
                files[0],
                unit=unit,
                material=material,
                thickness=thickness,
                segments=segments,
                supports=fix_layer or (),
                fixed=fixed,
            )
        elif files[0].suffix.lower() == ".json":
            found = bs.read_assembly(files[0], unit=unit, material=material, fixed=fixed)
        else:
            found = bs.read_mesh(files, unit=unit, material=material, fixed=fixed)
    out.print(str(found.report), markup=False, soft_wrap=True)
    if gap is None and found.report.joint_gap:
        gap = f"{found.report.joint_gap:.2g} m"
    dead = bs.LoadPattern("self-weight", [bs.SelfWeight()])
    push = bs.LoadPattern("weight sideways, +x", [bs.BodyForce((1, 0, 0))])
    case = bs.LimitCase("push +x", dead, push)
    joint = bs.JointMaterial("joint", friction)
    bs.write_draft(output, output.stem, found.blocks, joint, [case], tolerance=gap)
    out.print(f"written: {output}, with the case 'push +x': edit its loads and cases", markup=False, soft_wrap=True)
    check(output)


def _materials(unit_weights: list[str]) -> Any:
    """One material, or one for each layer named."""
    layers = {name: weight for name, _, weight in (w.rpartition("=") for w in unit_weights)}
    if len(layers) < len(unit_weights) or ("" in layers and len(layers) > 1):
        msg = "--unit-weight: give it once for all blocks, or once for each layer as in 'WALL=20 kN/m^3'"
        raise bs.ModelError(msg)
    if "" in layers:
        return bs.Material("stone", layers[""])
    return {name: bs.Material(name, weight) for name, weight in layers.items()}


@app.command()
def check(
    model: Annotated[Path, typer.Argument(help="A model document, YAML or JSON.", show_default=False)],
) -> None:
    """Print the blocks and the interfaces of a model document, with what was left out."""
    document = bs.read_document(model)
    bs.AnalysisManager(document.model, settings=bs.ProcedureSettings.of(document.settings)).check(document.cases)
    out.print(model_text(document.model), markup=False, soft_wrap=True)
    out.print(str(document.report), markup=False, soft_wrap=True)
    out.print(f"ready to run: {', '.join(case.name for case in document.cases)}", markup=False, soft_wrap=True)


def _run(
    model: bs.Model,
    cases: list[bs.LimitCase],
    settings: bs.ProcedureSettings,
    output: Path,
    quiet: bool,
    as_json: bool,
    document_hash: str = "",
    *,
    spread: bool = False,
) -> None:
    with following(err, quiet=quiet) as listeners:
        manager = bs.AnalysisManager(model, output, settings=settings, listeners=listeners, document_hash=document_hash)
        analysis = manager.run(cases, spread=spread)
    _report(analysis, output, as_json=as_json)


def _report(analysis: bs.Analysis, output: Path, *, as_json: bool = False) -> None:
    for result in analysis.values():
        out.print(iteration_table(result.history))
        out.print(result_text(result), soft_wrap=True)
    out.print(summary_table(analysis))
    out.print(spread_text(analysis), markup=False, soft_wrap=True, end="")
    out.print(f"written: {output}", markup=False, soft_wrap=True)
    if as_json:
        typer.echo(json.dumps(analysis_summary(analysis), indent=2))
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
