"""Commands that run analyses and studies."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import blockstruct as bs
from blockstruct.cli.app import (
    CsvOption,
    Exit,
    FileArgument,
    JsonOption,
    QuietOption,
    app,
    argument,
    err,
    option,
    out,
    print_results,
    say,
    say_table,
)
from blockstruct.vocabulary import counted

if TYPE_CHECKING:
    import pandas as pd

#: Extra of each of the suggested commands, and its packages.
_NEEDS = {"view": ("viz", ["plotly"]), "report": ("report", ["jinja2", "matplotlib"])}


@app.command()
def demo(
    output: Annotated[Path, option("File to write.", "--output", "-o", default=True)] = Path("blockstruct-demo.h5"),
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Push a wall with an opening sideways until it collapses, and keep the analysis."""
    out.quiet = quiet or as_json
    tuff = bs.Material("tuff", unit_weight="12 kN/m^3")
    lime = bs.JointMaterial("lime mortar", friction_coefficient=0.65)
    half, jamb = [0.5, 1, 1, 1, 0.5], [0.5, 1, -1, 1, 0.5]
    # The wall of the README.
    rows: list[list[float]] = [[1, 1, 1, 1], half, [1, 1, -1, 1], jamb, [1, 2, 1], half]
    blocks = bs.courses(rows, unit_length="40 cm", unit_height="17.5 cm", thickness="30 cm", material=tuff)
    found = bs.detect_interfaces(blocks, joint_material=lime)
    model = bs.Model("wall with an opening", blocks, found)
    dead = bs.LoadPattern("self-weight", [bs.SelfWeight()])
    push = bs.LoadPattern("weight sideways, +x", [bs.BodyForce((1, 0, 0))])
    cases = [bs.LimitCase(f"push +x, {flow}", dead, push, flow) for flow in bs.Flow]
    say(f"{model.name}: {counted(len(model.blocks), 'block')}, {found.report}")
    _run(model, cases, bs.ProcedureSettings(), output, quiet, as_json)


@app.command()
def run(
    model: Annotated[Path, argument("A model document, YAML or JSON.")],
    output: Annotated[
        Path | None, option("File to write.", "--output", "-o", default="MODEL with the ending .h5")
    ] = None,
    spread: Annotated[bool, option("Also run variants of the loading path.", "--spread")] = False,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
) -> None:
    """Run all cases of a model document and keep the analysis."""
    out.quiet = quiet or as_json
    document = bs.read_document(model)
    say(f"{document.model.name}: {counted(len(document.model.blocks), 'block')}, {document.report}")
    settings = bs.ProcedureSettings.of(document.settings)
    store = output or model.with_suffix(".h5")
    _run(document.model, list(document.cases), settings, store, quiet, as_json, document.hash, spread=spread)


@app.command()
def recover(file: FileArgument) -> None:
    """Write the analysis file of a run that was killed, with every committed iteration."""
    analysis = bs.recover(file)
    say(str(analysis))
    say(f"written: {file}")


@app.command()
def resume(file: FileArgument, quiet: QuietOption = False) -> None:
    """Continue a killed or interrupted run from its last committed iteration."""
    from blockstruct.views.console import following

    out.quiet = quiet
    events: list[Any] = []
    killed = bs.storage.is_unfinished(file)
    with following(err, quiet=quiet) as listeners:
        analysis = bs.AnalysisManager.resume(file, listeners=[*listeners, events.append])
    if not events:
        say(f"{file}: every case had ended, nothing was left to run")
    _report(analysis, file, written=killed or bool(events))


@app.command()
def migrate(file: FileArgument) -> None:
    """Rewrite an analysis file in place in the current format."""
    bs.save_analysis(bs.open_analysis(file), file)
    say(f"written: {file}")


def _run(
    model: bs.Model,
    cases: Sequence[bs.LimitCase | bs.SettlementCase | bs.RecordCase],
    settings: bs.ProcedureSettings,
    output: Path,
    quiet: bool,
    as_json: bool,
    document_hash: str = "",
    *,
    spread: bool | str = False,
) -> None:
    from blockstruct.views.console import following

    if not output.parent.is_dir():
        msg = f"{output}: there is no folder {output.parent}; make it, or choose another one"
        raise bs.errors.StorageError(msg)
    with following(err, quiet=quiet) as listeners:
        manager = bs.AnalysisManager(
            model, output, settings=settings, listeners=listeners, progress=False, document_hash=document_hash
        )
        analysis = manager.run(cases, spread=spread)
    _report(analysis, output, as_json=as_json)


def _report(analysis: bs.Analysis, output: Path, *, as_json: bool = False, written: bool = True) -> None:
    from blockstruct.views.console import analysis_summary

    # On a terminal the iterations were not printed during the run.
    print_results(analysis, iterations=err.is_terminal)
    if written:
        say(f"written: {output}")
    name = shlex.quote(str(output))
    interrupted = any(r.status is bs.Status.INTERRUPTED for r in analysis.values())
    rest = f"blockstruct resume {name} for the rest, " if interrupted else ""
    # A page plays no records.
    look = "view" if any(r.n_iterations for r in analysis.values()) else "figures"
    say(f"next: {rest}blockstruct {look} {name}, blockstruct report {name}, or blockstruct history {name} CASE")
    lacking = {command: extra for command, (extra, packages) in _NEEDS.items() if not all(map(find_spec, packages))}
    if lacking:
        extras = ",".join(sorted(lacking.values()))
        say(f'{" and ".join(lacking)} need{"s" * (len(lacking) == 1)}: pip install "blockstruct[{extras}]"')
    if as_json:
        typer.echo(json.dumps(analysis_summary(analysis), indent=2))
    if interrupted:
        raise typer.Exit(Exit.INTERRUPTED)
    if any(r.missing_curve or not r.status.is_answer for r in analysis.values()):
        raise typer.Exit(Exit.NO_LOAD_FACTOR)


@app.command()
def study(
    document: Annotated[Path, argument("A study document, YAML or JSON.")],
    output: Annotated[Path, option("Folder that keeps a file of every run.", "--output", "-o")],
    workers: Annotated[int | None, option("Processes; one a processor otherwise.")] = None,
    scheduler: Annotated[str | None, option("Dask scheduler to run on, as tcp://127.0.0.1:8786.")] = None,
    rerun: Annotated[bool, option("Replace runs of another model or other settings.", "--rerun")] = False,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
    csv: CsvOption = None,
) -> None:
    """Run a model document with many values of its parameters; finished runs are not repeated."""
    from blockstruct.views.console import plain, study_following, study_summary, study_table
    from blockstruct.views.output import write_csv

    out.quiet = quiet or as_json
    read = bs.studies.read_study(document)
    try:
        with study_following(err, quiet=quiet) as listeners:
            data = bs.study(
                read.build,
                read.parameters,
                output,
                workers=workers,
                cluster=scheduler,
                settings=read.settings,
                rerun=rerun,
                listeners=listeners,
                **read.options,
            )
    except KeyboardInterrupt as interrupt:
        interrupt.add_note(f"{output} keeps what was done; the same command goes on from there")
        raise
    rows = bs.studies.frame_of(data)
    if csv is not None:
        write_csv(_with_units(rows).set_index("run"), csv)
        say(f"{csv}: {counted(len(rows), 'row')}")
    else:
        say_table(study_table(data))
        if data.attrs["sampling"] in ("monte carlo", "latin hypercube") and bs.studies.cases_with_load_factors(data):
            say(study_summary(bs.studies.summary(data)))
    say(f"kept: {output}; next: blockstruct archive {output}")
    if as_json:
        typer.echo(
            json.dumps(
                {"attrs": data.attrs, "units": rows.attrs["units"], "rows": plain(rows.to_dict("records"))}, indent=2
            )
        )
    if (~rows["status"].isin([s for s in bs.Status if s.is_answer]) | (rows["missing_curve"] != "")).any():
        raise typer.Exit(Exit.NO_LOAD_FACTOR)


def _with_units(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows with the unit of each column in its name, as in tables of histories."""
    units = rows.attrs["units"].items()
    return rows.rename(columns={name: f"{name} [{unit}]" for name, unit in units if unit != "dimensionless"})
