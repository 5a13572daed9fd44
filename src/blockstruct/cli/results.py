"""Commands that look at analyses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import blockstruct as bs
from blockstruct.cli import verification
from blockstruct.cli.app import (
    CsvOption,
    Exit,
    FileArgument,
    JsonOption,
    app,
    argument,
    option,
    out,
    print_results,
    say,
    say_table,
)
from blockstruct.errors import check_known
from blockstruct.vocabulary import counted

if TYPE_CHECKING:
    import pandas as pd

#: Printed variables of each state of a pushover, and of a response to a record.
_OF_STATES = (
    *(
        "displacement [meter]",
        "largest_displacement [meter]",
        "load_factor",
        "reaction [newton]",
        "holds",
        "penetration [meter]",
        "energy_error",
    ),
    *("kinetic_energy [joule]", "dead_work [joule]", "record_work [joule]", "dissipated_energy [joule]"),
)


@app.command()
def show(file: FileArgument, as_json: JsonOption = False) -> None:
    """Print the results of an analysis, with their certificates."""
    from blockstruct.views.console import analysis_summary, parameter_texts

    analysis = bs.open_analysis(file)
    if as_json:
        typer.echo(json.dumps(analysis_summary(analysis), indent=2))
        return
    model = analysis.model
    ties = f", {counted(len(model.ties), 'tie')}" if model.ties else ""
    interfaces = counted(len(model.interfaces), "interface")
    say(f"{model.name}: {counted(len(model.blocks), 'block')}, {interfaces}{ties}")
    say(f"model hash {model.hash[:16]}…, created {analysis.created_at}, {analysis.status}")
    say(f"blockstruct {analysis.versions.get('blockstruct')}")
    for name, result in analysis.items():
        made_by = [each.get("blockstruct", "?") for each in result.versions]
        if any(each != analysis.versions for each in result.versions):
            say(f"  {name}: by blockstruct {', then '.join(made_by)}")
    if analysis.parameters:
        say("with " + ", ".join(f"{name} = {value}" for name, value in parameter_texts(analysis)))
    print_results(analysis)


@app.command()
def history(
    file: FileArgument,
    case: Annotated[str | None, argument("Name of a case; without it, the cases are listed.")] = None,
    variable: Annotated[
        str | None,
        option(
            "Print one variable: any of the history or of the states, or state, force, moment, eccentricity of the "
            "interfaces."
        ),
    ] = None,
    interface: Annotated[str | None, option("Print one interface only.")] = None,
    pushover: Annotated[
        bool, option("Print the states of a pushover or a settlement, not the iterations.", "--pushover")
    ] = False,
    last: Annotated[bool, option("Print the last iteration, or state, only.", "--last")] = False,
    csv: CsvOption = None,
) -> None:
    """Print the iterations of a case, or the states of a pushover, settlement or record."""
    from blockstruct.views.console import iteration_table

    analysis = bs.open_analysis(file)
    if case is None:
        say("\n".join(analysis))
        return
    result = analysis[case]
    some = slice(-1 if last else None, None)
    if pushover or result.response is not None:
        frame = _states(result, variable, interface, some)
        if csv is None and variable is None:
            # The multiplier of a settlement is its reaction in another unit.
            names = [name for name in _OF_STATES if name in frame]
            frame = frame[[name for name in names if name != "load_factor" or "reaction [newton]" not in names]]
    else:
        chosen = result.history.isel(iteration=some)
        if variable is None and interface is not None:
            variable = "force"
        if variable is None and csv is None:
            out.print(iteration_table(chosen))
            return
        frame = chosen.blockstruct.frame(variable)
        if interface is not None:
            frame = _of_interface(frame, interface, chosen.interface.to_numpy().tolist())
    if csv is None:
        say(frame.to_string())
    else:
        _write_csv(frame, csv)


def _states(result: bs.CaseResult, variable: str | None, interface: str | None, some: slice) -> pd.DataFrame:
    """Return some states of a pushover or of a record."""
    from blockstruct.views.words import without_curve_words

    motion, dim = (result.capacity, "step") if result.response is None else (result.response, "time")
    if motion is None:
        msg = f"--pushover: case {result.name!r}: {without_curve_words(result)}"
        raise bs.errors.ModelError(msg)
    if interface is not None:
        msg = "--interface: moved blocks have no interfaces, contacts are found anew; leave it out"
        raise bs.errors.ModelError(msg)
    return bs.results.capacity_frame(motion.isel({dim: some}), variable)


def _of_interface(frame: pd.DataFrame, interface: str, known: list[str]) -> pd.DataFrame:
    """Return the rows of a table that belong to an interface."""
    check_known(interface, known, "--interface: no")
    if "interface_of_contact_point" in frame:
        return frame[frame["interface_of_contact_point"] == interface]
    if "interface" in frame.index.names:
        return frame[frame.index.get_level_values("interface") == interface]
    msg = "--interface: this variable is not one of interfaces; give --variable contact_force, force or state"
    raise bs.errors.ModelError(msg)


@app.command()
def archive(
    folder: Annotated[Path, argument("A folder of analysis files.")],
    where: Annotated[str | None, option('Rows to print, such as "load_factor < 0.3".')] = None,
    csv: CsvOption = None,
) -> None:
    """Print a row for each case of the analyses in a folder and its subfolders; a CSV file has every column."""
    from blockstruct.views.console import archive_table

    table = bs.Archive(folder).select(where, all_columns=csv is not None)
    if csv is not None:
        _write_csv(table.set_index(["path", "case"]), csv)
        return
    say_table(archive_table(table))
    for path, problem in table.loc[table["problem"] != "", ["path", "problem"]].itertuples(index=False):
        say(f"{path}: {problem}")


@app.command()
def diff(
    one: Annotated[Path, argument("An analysis file, or a folder of them.")],
    other: Annotated[Path, argument("Another one.")],
    tolerance: Annotated[float, option("Relative tolerance of load factors.", default=True)] = 1e-6,
) -> None:
    """Compare two analyses, or two folders, case by case; exit code 1 if they differ."""
    if not tolerance >= 0:
        msg = f"--tolerance {tolerance:g}: give a number of zero or more"
        raise bs.errors.ModelError(msg)
    if one.is_dir():
        table = bs.Archive(one).difference(bs.Archive(other))
        same = bool((table["agree"] & (table["relative_difference"].abs() <= tolerance)).all())
        read = table.drop(columns=["model_hash", "model_hash_other"])
        statuses = ["status", "status_other"]
        read[statuses] = read[statuses].replace("_", " ", regex=True)
        say(read.to_string())
    else:
        comparison = bs.results.compare(bs.open_analysis(one), bs.open_analysis(other))
        same = comparison.agrees(tolerance)
        say(str(comparison))
    if not same:
        raise typer.Exit(Exit.DIFFERENT)


@app.command()
def view(
    file: FileArgument,
    output: Annotated[Path | None, option("File to write; FILE.html otherwise.", "--output", "-o")] = None,
    show_it: Annotated[bool, option("Show the page in the browser.", "--open")] = False,
) -> None:
    """Write an interactive page of an analysis: structure, mechanism, forces, states of all iterations."""
    from blockstruct.views.page import write_page

    target = _beside(output or file.with_suffix(".html"), file)
    _written(write_page(bs.open_analysis(file), target), show_it=show_it)


@app.command()
def report(
    file: FileArgument,
    output: Annotated[
        Path | None, option("HTML or PDF to write; FILE-report.html otherwise.", "--output", "-o")
    ] = None,
    template: Annotated[Path | None, option("A Jinja2 template of your own.")] = None,
    project: Annotated[list[str] | None, option("A line of its head, as in 'client=Town of Lucca'.")] = None,
    spectrum: verification.SpectrumOption = None,
    case: verification.CaseOption = None,
    confidence_factor: verification.FactorOption = None,
    knowledge_level: verification.LevelOption = None,
    method: verification.MethodOption = None,
    mode: verification.ModeOption = None,
    show_it: Annotated[bool, option("Show the report in the browser.", "--open")] = False,
) -> None:
    """Write a report of an analysis, as a page or as PDF, with checks of local mechanisms for a given site."""
    from blockstruct.views.report import write_report

    target = _beside(output or file.with_name(f"{file.stem}-report.html"), file, template)
    head = dict(_project_line(line) for line in project or ())
    analysis = bs.open_analysis(file)
    wanted = {"confidence_factor": confidence_factor, "knowledge_level": knowledge_level, "method": method}
    checks = verification.checks_of(analysis, spectrum, mode, case, wanted)
    _written(write_report(analysis, target, project=head, checks=checks, template=template), show_it=show_it)


@app.command()
def figures(
    file: FileArgument,
    output: Annotated[Path, option("Folder to write into.", "--output", "-o")],
    look: Annotated[str | None, option("x, y (elevations), z (plan) or 3d; what fits otherwise.")] = None,
    file_format: Annotated[str, option("png, svg or pdf.", "--format", default=True)] = "png",
) -> None:
    """Write the figures of every case: mechanism, states, sliding, forces, crushing, convergence, certificate."""
    from blockstruct.views.figures import write_figures

    for path in write_figures(bs.open_analysis(file), output, look=look, file_format=file_format):
        say(f"written: {path}")


@app.command()
def export(
    file: FileArgument,
    output: Annotated[
        Path,
        option(
            "File to write: .glb (animation), .obj, .stl (moved blocks), .json (COMPAS), .pvd (ParaView), .xlsx; "
            "a folder for CSV.",
            "--output",
            "-o",
        ),
    ],
    case: Annotated[str | None, option("Name of the case; not for tables.", default="the only case")] = None,
    amplitude: Annotated[str | None, option("Largest translation in the mechanism, as in '20 cm'.")] = None,
    step: Annotated[
        int | None, option("State of a pushover, settlement or record, for OBJ or STL; -1 is the last.")
    ] = None,
) -> None:
    """Write results for other programs: Blender, Rhino, COMPAS, ParaView, Excel."""
    from blockstruct.views import export as views
    from blockstruct.views import paraview

    moved = (views.write_moved, {"amplitude", "step"})
    writers: dict[str, Any] = {".glb": (views.write_glb, {"amplitude"}), ".obj": moved, ".stl": moved}
    writers |= {".json": (views.write_assembly, set()), ".pvd": (paraview.write_paraview, set())}
    analysis = bs.open_analysis(file)
    suffix, target = output.suffix.lower(), _beside(output, file)
    write, allowed = writers.get(suffix, (None, set()))
    moves = {name: value for name, value in (("amplitude", amplitude), ("step", step)) if value is not None}
    if wrong := sorted(moves.keys() - allowed):
        msg = f"--{wrong[0]}: does not apply to {output}; leave it out"
        raise bs.errors.ModelError(msg)
    if suffix in ("", ".xlsx"):
        say(f"written: {views.write_tables(analysis, target)}")
        return
    names = list(analysis.headlines)
    if case is None and len(names) > 1:
        msg = f"--case: {file} has the cases {', '.join(map(repr, names))}; give one of them"
        raise bs.errors.ModelError(msg)
    if write is None:
        msg = f"{output}: unknown kind of file; names end in .glb, .obj, .stl, .json, .pvd or .xlsx"
        raise bs.errors.ModelError(msg)
    _written(write(analysis[names[0] if case is None else case], target, **moves))


def _project_line(line: str) -> tuple[str, str]:
    what, equals, text = line.partition("=")
    if not (what and equals):
        msg = f"--project {line!r}: no name and text; give both, as in 'client=Town of Lucca'"
        raise bs.errors.ModelError(msg)
    return what, text


def _beside(target: Path, *read: Path | None) -> Path:
    """Return the target of a view, which must differ from its input files."""
    if any(file is not None and _is_same(target, file) for file in read):
        msg = f"{target}: the view is made from this file, which it would replace; choose another one with --output"
        raise bs.errors.StorageError(msg)
    return target


def _is_same(one: Path, other: Path) -> bool:
    """Return whether both paths exist and are one file."""
    try:
        return one.samefile(other)
    except OSError:
        return False


def _written(path: Path, *, show_it: bool = False) -> None:
    say(f"written: {path}, {path.stat().st_size / 1e6:.1f} MB")
    if show_it:
        typer.launch(path.resolve().as_uri())


def _write_csv(frame: pd.DataFrame, path: Path) -> None:
    from blockstruct.views.output import target_with, write_csv

    write_csv(frame, target_with(path, ".csv"))
    say(f"{path}: {counted(len(frame), 'row')}")
