"""Tables and texts of results and studies for a terminal of 80 columns, and the progress of a run there."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import asdict
from textwrap import indent
from typing import Any

import pandas as pd
import xarray as xr
from rich.console import Console, ConsoleOptions, JustifyMethod, RenderResult
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column, Table
from rich.text import Text

import blockstruct as bs
from blockstruct.analysis import Listener
from blockstruct.analysis.events import follow
from blockstruct.text import study
from blockstruct.text.case import response_number
from blockstruct.units import SI_UNITS, short_unit
from blockstruct.views import words
from blockstruct.views.selection import compasses
from blockstruct.vocabulary import in_words

#: Characters in a table column, for texts and for titles of numbers, from the most to the least.
_FOLDS = ((math.inf, math.inf), (12, math.inf), (12, 12), (8, 8), (4, 4))
#: Runs of a summary without a finite load factor.
_NOT_FINITE = ("unstable", "unbounded", "unknown")


def study_table(data: xr.Dataset) -> Table:
    """Return the table of a study, a row per case of each run: case, parameters, load factor, status, problem."""
    frame, most = bs.studies.frame_of(data), pd.get_option("display.max_rows")
    varied = [str(name) for name in data.coords if name not in ("run", "case") and data[name].ndim]
    table = _case_table(frame.head(most), ["case"], varied, frame.attrs["units"])
    if len(frame) > most:
        table.add_row(Text(f"… {len(frame)} rows"))
    return table


def archive_table(rows: pd.DataFrame) -> Table:
    """Return the table of rows of :meth:`blockstruct.Archive.table`, without unreadable files."""
    varied = [str(name) for name in rows.columns if name.startswith("parameter_")]
    return _case_table(rows[rows["problem"] == ""], ["path", "case"], varied, rows.attrs.get("units", {}))


def _case_table(frame: pd.DataFrame, names: Sequence[str], varied: Sequence[str], units: Mapping[str, str]) -> Table:
    """Return the table of cases with their parameters; a cell is empty if a case has no value."""
    rows = frame.to_dict("records")
    columns: list[tuple[str, list[str], JustifyMethod]] = [
        (name, [row[name] for row in rows], "left") for name in names
    ]
    for name, short in zip(varied, short_names([name.removeprefix("parameter_") for name in varied]), strict=True):
        unit = units.get(name, "dimensionless")
        symbol = "" if " or " in unit else short_unit(unit)
        columns.append((f"{short} [{symbol}]" if symbol else short, [_cell(row[name]) for row in rows], "right"))
    columns.append(numbers_column(map(_number, rows)))
    if any(math.isfinite(row.get("curve_end", math.nan)) for row in rows):
        columns.append(("d0 [m]", [_d0(row) for row in rows], "right"))
    if "path" in names:
        columns.append(("programs", [f"{row['n_iterations']:.0f}" for row in rows], "right"))
    columns.append(("status", [_ending(row) for row in rows], "left"))
    return folded_table(columns)


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return str(value)


def _ending(row: Mapping[Any, Any]) -> str:
    """Return the status of a case, and why its run failed or it has no curve."""
    drifts = row["status"] == bs.Status.CONVERGED and not row["settled"]
    why = row["problem"] or (f"no capacity curve, {row['missing_curve']}" if row.get("missing_curve") else "")
    return ": ".join(filter(None, ("NOT SETTLED" if drifts else in_words(row["status"]), why)))


class FoldedTable(Table):
    """Table that folds to the width of a terminal: first texts, then titles, never numbers."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for folds in _FOLDS:
            widths = [_width(column, *folds) for column in self.columns]
            needed = sum(widths) + (self.padding[1] + self.padding[3]) * (len(widths) - 1)
            if needed <= options.max_width:
                break
        for column, width in zip(self.columns, widths, strict=True):
            # Texts share the width that numbers leave.
            column.width = None if column.justify == "left" else width
        yield from super().__rich_console__(console, options.update_width(max(needed, options.max_width)))


def _width(column: Column, of_texts: float, of_titles: float) -> int:
    """Return the width of a column whose texts, or titles of numbers, fold at a number of characters."""
    cells, title = [str(cell) for cell in column.cells], str(column.header)
    if column.justify == "left":
        return int(min(max(map(len, [title, *cells])), of_texts))
    if of_titles < math.inf:
        cells, title = [word for cell in cells for word in cell.split()], max(title.split(), key=len)
    return int(max([min(len(title), of_titles), *map(len, cells)]))


def folded_table(columns: Iterable[tuple[str, Sequence[str], JustifyMethod]]) -> Table:
    """Return a table of titles, cells and alignments: numbers to the right, texts to the left."""
    table = FoldedTable(box=None, pad_edge=False, header_style="bold")
    of_rows = []
    for title, cells, side in columns:
        # As Text, since "[m]" in a str would be markup.
        table.add_column(Text(title), justify=side, overflow="fold")
        of_rows.append(map(Text, cells))
    for row in zip(*of_rows, strict=True):
        table.add_row(*row)
    return table


def numbers_column(named: Iterable[tuple[str, str]]) -> tuple[str, list[str], JustifyMethod]:
    """Return the column of the numbers of cases: load factors, reactions, displacements, times of collapse."""
    names, numbers = zip(*named, strict=True) if (named := list(named)) else (["load factor"], [])
    return " / ".join(dict.fromkeys(names)), list(numbers), "right"


def _number(row: Mapping[Any, Any]) -> tuple[str, str]:
    """Return name and number of a case: load factor, reaction with its unit, or number of a response."""
    if math.isfinite(largest := row.get("peak_displacement", math.nan)):
        return response_number(largest, row.get("collapse_time", math.nan))
    for name, unit in (("reaction", "N"), ("reaction_moment", "N·m")):
        if math.isfinite(row.get(name, math.nan)):
            return "reaction", f"{row[name]:.6g} {unit}"
    return "load factor", bs.results.LOAD_FACTOR.text(row["load_factor"], 6)


def study_summary(summary: xr.Dataset) -> str:
    """Return the fractiles of a study of samples, a line each."""
    lines = []
    for case in summary["case"].to_numpy():
        of_case = summary.sel(case=case)
        runs = of_case["runs"].item()
        finite = runs - sum(of_case[name].item() for name in _NOT_FINITE)
        mean, deviation = (of_case[name].item() for name in ("mean_load_factor", "standard_deviation"))
        lines.append(study.sample_line(case, runs, finite, mean, deviation))
        for fractile in summary["fractile"].to_numpy():
            one = of_case.sel(fractile=fractile)
            alpha, low, high = (one[name].item() for name in ("load_factor", "lower", "upper"))
            lines.append(f"  {study.fractile_line(fractile, alpha, (low, high), summary.attrs['confidence'])}")
        lines += [f"  {line}" for line in out_of_the_ordinary(of_case)]
    if not summary.attrs["exact"]:
        lines.append(f"  {study.NOT_INDEPENDENT}")
    return "\n".join(lines)


def out_of_the_ordinary(of_case: xr.Dataset) -> list[str]:
    """Return the counts of runs without a settled load factor."""
    return [f"{count} {words}" for name, words in study.COUNTED_AS.items() if (count := of_case[name].item())]


def directions_text(analysis: bs.Analysis) -> str:
    """Return the load factors around the compass as text."""
    try:
        each = compasses(analysis)
    except bs.errors.ModelError as error:
        return f"no load factors around the compass: {error}\n"
    return "".join(f"case {name}, {around}\n" if len(each) > 1 else f"{around}\n" for name, around in each)


def parameter_texts(analysis: bs.Analysis) -> list[tuple[str, str]]:
    """Return the parameters of an analysis, name and value with its unit."""
    return [
        (name, f"{value:~C}" if hasattr(value, "units") else str(value)) for name, value in analysis.parameters.items()
    ]


def short_names(names: Sequence[str]) -> list[str]:
    """Return the shortest distinct ends of dotted names, none of which begins with an index.

    >>> short_names(["joint_materials.lime.cohesion", "joint_materials.dry.cohesion", "height"])
    ['lime.cohesion', 'dry.cohesion', 'height']
    >>> short_names(["blocks.left.box.size.2"])
    ['size.2']
    """
    parts = [name.split(".") for name in names]
    ends = [[".".join(p[-k:]) for k in range(1, len(p) + 1)] for p in parts]
    taken = Counter(end for own in ends for end in own)
    return [next((end for end in own if taken[end] == 1 and not end[:1].isdigit()), own[-1]) for own in ends]


_COLUMNS = {
    "load_factor": ("load factor", "{:.6f}"),
    "schedule_cohesion": ("c0", "{:.0e}"),
    "schedule_slope": ("a", "{:.0e}"),
    "yield_excess": ("yield", "{:.0e}"),
    "interpenetration": ("interp.", "{:.0e}"),
    "flow_rule_gap": ("gap", "{:.0e}"),
    "solver_status": ("solver", "{}"),
    "solver_time": ("time", "{:.2f} s"),
}


def iteration_table(history: xr.Dataset) -> Table:
    """Return the table of a history, a row per iteration.

    Columns are load factor or reaction, schedule, certificate and solver.
    """
    table = Table(box=None, padding=(0, 1, 0, 0), header_style="bold")
    table.add_column("#", justify="right")
    table.add_column("program", no_wrap=True)
    columns = dict(_COLUMNS)
    if "reaction" in history:
        unit = "N" if history["reaction"].attrs["units"] == SI_UNITS["force"] else "N·m"
        columns = {"reaction": (f"R [{unit}]", "{:.6g}")} | columns
        del columns["load_factor"]
    for title, _ in columns.values():
        table.add_column(Text(title), justify="right", no_wrap=True)
    for i in range(history.sizes["iteration"]):
        row = history.isel(iteration=i)
        cells = [form.format(row[name].item()).replace("_", " ") for name, (_, form) in columns.items()]
        table.add_row(str(row["iteration"].item()), str(row["stage"].item()).replace("_", " "), *cells)
    return table


def result_text(result: bs.CaseResult) -> Text:
    """Return load factor, notes and certificate of a case."""
    case, c = result.case, result.certificate
    text = Text("\n").append(f"{result.name}\n", style="bold")
    text.append(f"  {case.question}\n")
    text.append(f"  {result.headline}\n", style="bold")
    if reactions := words.range_words(result):
        text.append(f"  {reactions}\n")
    for warning in (*result.warnings, *result.owed):
        text.append(f"  warning: {warning}\n", style="bold yellow")
    left = words.admissible_words(result)
    if left:
        text.append(f"  {left}\n")
    for of_kind in (words.roller_words, words.tie_words, words.pushover_words, words.response_words):
        for sentence in of_kind(result):
            text.append(f"  {sentence}\n")
    if c is None:
        return text
    if result.status.is_of_dead_load:
        return text.append(f"  proof of the mechanism {'holds' if c.holds else 'does not hold'}\n")
    return text.append(indent(f"{c}\n", "  "))


def summary_table(analysis: bs.Analysis) -> Table:
    """Return the table of an analysis, a row per case."""
    results = list(analysis.values())
    return folded_table(
        [
            ("case", [r.name for r in results], "left"),
            ("flow", [r.case.flow.value for r in results], "left"),
            ("status", [r.ended for r in results], "left"),
            numbers_column(r.number(6) for r in results),
            ("programs", [str(r.n_iterations) for r in results], "right"),
            ("time [s]", [f"{r.duration:.2f}" for r in results], "right"),
        ]
    )


def _d0(row: Mapping[Any, Any]) -> str:
    """Return d0 of a pushover, or the end of its curve; empty for another case."""
    if math.isfinite(row["d0"]):
        return f"{row['d0']:.4g}"
    return f"none, ends at {row['curve_end']:.4g}" if math.isfinite(row["curve_end"]) else ""


def analysis_summary(analysis: bs.Analysis) -> dict[str, Any]:
    """Return the results of an analysis as plain values for JSON.

    None stands for numbers that are not finite. Load factors, the four measures of certificates and counts are
    dimensionless. ``duration`` is in seconds.
    """
    summary = {
        "model": analysis.model.name,
        "model_hash": analysis.model.hash,
        "blocks": len(analysis.model.blocks),
        "interfaces": len(analysis.model.interfaces),
        "ties": len(analysis.model.ties),
        "created_at": analysis.created_at,
        "parameters": {name: bs.results.stored_value(value) for name, value in analysis.parameters.items()},
        "status": analysis.status,
        "cases": [
            {
                "name": r.name,
                "flow": r.case.flow.value,
                **asdict(r.outcome),
                "load_factor": None if r.answer.is_reaction else r.load_factor,
                "hung": r.hung,
                "jammed": r.jammed,
                "reaction": _reaction(r),
                "iterations": r.n_iterations,
                "duration": r.duration,
                "path_dependence": r.path_dependence,
                "text": str(r.headline),
                "warnings": [*r.warnings, *r.owed, *_of_curve(r)],
                "admissible_load_factor": None if r.answer.is_reaction else r.admissible_load_factor,
                "certificate": r.certificate and r.certificate.measures,
                "ties": r.ties.reset_index().to_dict("records"),
                "pushover": _pushover(r),
                "record": _record(r),
            }
            for r in analysis.values()
        ],
        "headlines": {name: _headline(headline) for name, headline in analysis.headlines.items()},
        "spreads": {
            name: {
                "lowest": spread.lowest and spread.lowest.name,
                "highest": spread.highest and spread.highest.name,
                "associative": spread.upper_bound and spread.upper_bound.name,
            }
            for name, spread in analysis.spreads.items()
        },
    }
    return {name: plain(value) for name, value in summary.items()}


def plain(value: Any) -> Any:
    """Return a value for JSON, with None for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {str(name): plain(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _record(result: bs.CaseResult) -> dict[str, Any] | None:
    """Return the figures of the response to a record; None without one."""
    if result.response is None:
        return None
    last = result.response.isel(time=-1)
    return {
        "collapse_time": result.collapse_time,
        "peak_displacement": float(last["peak_displacement"].max()),
        "time_step": float(last["time_step"]),
        "fallen": bs.results.fallen_blocks(result.model, result.response),
        "broken_ties": result.broken_ties.reset_index().to_dict("records") if result.model.ties else [],
    }


def _headline(headline: bs.results.Headline) -> dict[str, Any]:
    answer, ends = headline.answer, headline.path_range
    name, factor = ("reaction", answer.factor) if answer.is_reaction else ("load_factor", 1.0)
    return {
        name: factor * headline.load_factor,
        "range": None if ends is None else sorted(factor * end for end in ends),
        "associative": factor * headline.associative,
        "units": SI_UNITS[answer.dimension],
        "status": headline.status.value,
        "settled": headline.settled,
        "text": str(headline),
    }


def _reaction(r: bs.CaseResult) -> dict[str, Any] | None:
    """Return the reaction of a settlement and its range; None for a limit case."""
    if not r.answer.is_reaction:
        return None
    least, largest = r.reaction_range.magnitude if r.n_iterations else (math.nan, math.nan)
    values = {"value": r.reaction.magnitude, "least": float(least), "largest": float(largest)}
    return {**values, "units": SI_UNITS[r.answer.dimension]}


def _pushover(r: bs.CaseResult) -> dict[str, Any] | None:
    """Return the end of a pushover's curve and its broken ties, m; None without one."""
    curve = r.capacity
    if curve is None:
        return None
    return {
        "d0": float(curve["d0"]),
        "ended": r.curve_ended,
        "states": curve.sizes["step"],
        "certified": int(curve["holds"].sum()),
        "broken_ties": r.broken_ties.reset_index().to_dict("records"),
    }


def _of_curve(r: bs.CaseResult) -> list[str]:
    """Return the doubts on a capacity curve, or why it is missing."""
    kind = "settlement" if isinstance(r.case, bs.SettlementCase) else "pushover"
    if r.capacity is not None:
        return [f"{kind}: {part}" for part in r.curve_doubts]
    return [f"{kind}: {r.missing_curve}"] if r.missing_curve else []


@contextmanager
def following(console: Console, *, quiet: bool) -> Iterator[list[Listener]]:
    """Return listeners that show a run: a bar on a terminal, else lines; none if quiet."""
    # Names of cases are not markup.
    columns = (TextColumn("{task.description}", markup=False), BarColumn(bar_width=20), TimeElapsedColumn())
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
    """Return a listener that moves a bar, with iteration, load factor and gap."""
    task = progress.add_task("", total=1.0)

    def write(text: str, done: float) -> None:
        if not done:
            progress.reset(task)
        progress.update(task, completed=done, description=text)

    return follow(write)
