"""Commands that run many analyses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import blockstruct as bs
from blockstruct.cli.app import (
    CsvOption,
    Exit,
    JsonOption,
    QuietOption,
    app,
    argument,
    err,
    option,
    out,
    say,
    say_table,
)
from blockstruct.vocabulary import counted

if TYPE_CHECKING:
    import pandas as pd


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
    from blockstruct.views import study_following, study_summary, study_table
    from blockstruct.views.console import plain
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
