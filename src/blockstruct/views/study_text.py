"""Studies and directions as tables and texts for a terminal."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import xarray as xr
from rich.console import Console, ConsoleOptions, JustifyMethod, RenderResult
from rich.table import Column, Table
from rich.text import Text

import blockstruct as bs
from blockstruct.text import study
from blockstruct.units import short_unit
from blockstruct.views.selection import compasses

#: Rows that a terminal shows; the store holds the rest.
_SHOWN = 50
#: Characters in a table column, for texts and for titles of numbers, from the most to the least.
_FOLDS = ((math.inf, math.inf), (12, math.inf), (12, 12), (8, 8), (4, 4))
#: Runs of a summary without a finite load factor.
_NOT_FINITE = ("unstable", "unbounded", "unknown")
#: Characters between columns.
_GAP = 2


def study_table(data: xr.Dataset) -> Table:
    """Return the table of a study, a row per case of each run: parameters, load factor, status, problem."""
    frame = bs.studies.frame_of(data)
    varied = [str(name) for name in data.coords if name not in ("run", "case") and data[name].ndim]
    rows = frame.head(_SHOWN).to_dict("records")
    columns = parameter_columns(rows, varied, frame.attrs["units"])
    columns.append(("case", [row["case"] for row in rows], "left"))
    columns.append((answer_title(rows), [answer_cell(row) for row in rows], "right"))
    columns.append(("status", [_ending(row) for row in rows], "left"))
    table = folded_table(columns)
    if len(frame) > _SHOWN:
        table.add_row(Text(f"… {len(frame)} rows"))
    return table


def parameter_columns(
    rows: Sequence[Mapping[Any, Any]], names: Sequence[str], units: Mapping[str, str], prefix: str = ""
) -> list[tuple[str, list[str], JustifyMethod]]:
    """Return the columns of parameters, with short names and units; a cell is empty if a row has no value."""
    columns: list[tuple[str, list[str], JustifyMethod]] = []
    for name, short in zip(names, short_names([name.removeprefix(prefix) for name in names]), strict=True):
        unit = units.get(name, "dimensionless")
        symbol = "" if " or " in unit else short_unit(unit)
        columns.append((f"{short} [{symbol}]" if symbol else short, [_cell(row[name]) for row in rows], "right"))
    return columns


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return str(value)


def _ending(row: Mapping[Any, Any]) -> str:
    """Return the status of a case, and why its run failed or it has no curve."""
    why = row["problem"] or (f"no capacity curve, {row['missing_curve']}" if row["missing_curve"] else "")
    return ": ".join(filter(None, (status_cell(row), why)))


class FoldedTable(Table):
    """Table that folds to the width of a terminal: first texts, then titles, never numbers."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for folds in _FOLDS:
            widths = [_width(column, *folds) for column in self.columns]
            needed = sum(widths) + _GAP * (len(widths) - 1)
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
    table = FoldedTable(box=None, padding=(0, _GAP, 0, 0), pad_edge=False, header_style="bold")
    of_rows = []
    for title, cells, side in columns:
        # As Text, since "[m]" in a str would be markup.
        table.add_column(Text(title), justify=side, overflow="fold")
        of_rows.append(map(Text, cells))
    for row in zip(*of_rows, strict=True):
        table.add_row(*row)
    return table


def answer_title(rows: Iterable[Mapping[Any, Any]]) -> str:
    """Return the title of a column of load factors, and reactions if there are any."""
    return "load factor / reaction" if any(_reactions(row) for row in rows) else "load factor"


def answer_cell(row: Mapping[Any, Any]) -> str:
    """Return the load factor of a case, or the reaction of a settlement with its unit."""
    return (_reactions(row) or [bs.results.LOAD_FACTOR.text(row["load_factor"], 6)])[0]


def status_cell(row: Mapping[Any, Any]) -> str:
    """Return the status of a case, and whether its load factor settled."""
    drifts = row["status"] == bs.Status.CONVERGED and not row["settled"]
    return "NOT SETTLED" if drifts else str(row["status"]).replace("_", " ")


def _reactions(row: Mapping[Any, Any]) -> list[str]:
    units = {"reaction": "N", "reaction_moment": "N·m"}
    return [f"{row[name]:.6g} {unit}" for name, unit in units.items() if math.isfinite(row.get(name, math.nan))]


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
