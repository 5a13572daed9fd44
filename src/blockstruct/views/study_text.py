"""Studies and directions as tables and texts for a terminal."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from rich.table import Table
from rich.text import Text

import blockstruct as bs
from blockstruct.units import short_unit
from blockstruct.views.selection import compasses

#: Rows that a terminal shows; the rest is in the store.
_SHOWN = 50


def study_table(data: xr.Dataset) -> Table:
    """Table of a study, a row per case of each run: what varies, load factor, status; why it failed or has no curve."""
    frame = bs.studies.frame_of(data)
    units = frame.attrs["units"]
    varied = [str(name) for name in data.coords if name not in ("run", "case") and data[name].ndim]
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
    for name, short in zip(varied, short_names(varied), strict=True):
        symbol = short_unit(units.get(name, "dimensionless"))
        table.add_column(Text(short + (f" [{symbol}]" if symbol else "")), justify="right", overflow="fold")
    rows = frame.head(_SHOWN).to_dict("records")
    answer = answer_title(rows)
    for title in ("case", answer, "status"):
        table.add_column(title, justify="right" if title == answer else "left", overflow="fold")
    for row in rows:
        values = [f"{row[n]:.6g}" if isinstance(row[n], float) else str(row[n]) for n in varied]
        why = row["problem"] or (f"no capacity curve, {row['missing_curve']}" if row["missing_curve"] else "")
        status = ": ".join(filter(None, (status_cell(row), why)))
        table.add_row(*map(Text, (*values, row["case"], answer_cell(row), status)))
    if len(frame) > _SHOWN:
        table.add_row(Text(f"… {len(frame)} rows"))
    return table


def answer_title(rows: Iterable[Mapping[Any, Any]]) -> str:
    """Title of a column of answers: load factors, and reactions if there are any."""
    return "load factor / reaction" if any(_reactions(row) for row in rows) else "load factor"


def answer_cell(row: Mapping[Any, Any]) -> str:
    """Load factor of a case, or of a settlement its reaction with the unit."""
    return (_reactions(row) or [f"{row['load_factor']:.6g}"])[0]


def status_cell(row: Mapping[Any, Any]) -> str:
    """Status of a case, and that its load factor was still drifting when the procedure was stopped."""
    drifts = row["status"] == bs.Status.CONVERGED and not row["settled"]
    return f"{row['status']}, still drifting" if drifts else str(row["status"]).replace("_", " ")


def _reactions(row: Mapping[Any, Any]) -> list[str]:
    units = {"reaction": "N", "reaction_moment": "N·m"}
    return [f"{row[name]:.6g} {unit}" for name, unit in units.items() if math.isfinite(row.get(name, math.nan))]


def study_summary(summary: xr.Dataset) -> str:
    """Fractiles of a study of samples, a line each, with their confidence intervals and what is left out."""
    share = f"{summary.attrs['confidence']:.0%}"
    lines = []
    for case in summary["case"].to_numpy():
        of_case = summary.sel(case=case)
        mean, deviation = of_case["mean_load_factor"].item(), of_case["standard_deviation"].item()
        lines.append(f"{case}: {of_case['runs'].item()} runs, mean {mean:.4g}, standard deviation {deviation:.2g}")
        for fractile in summary["fractile"].to_numpy():
            one = of_case.sel(fractile=fractile)
            low, high = (_number(one[name].item()) for name in ("lower", "upper"))
            lines.append(
                f"  {fractile:.0%} fractile {_number(one['load_factor'].item())} ({share} confidence: {low} to {high})"
            )
        for name, what in (
            ("unstable", "unstable under their dead load, counted as −∞"),
            ("unbounded", "unbounded, counted as ∞"),
            ("unknown", "without a load factor: the intervals are as wide as if they could lie anywhere"),
        ):
            if count := of_case[name].item():
                lines.append(f"  {count} {what}")
    if not summary.attrs["exact"]:
        lines.append("  of a Latin hypercube, whose runs are not independent: the intervals are not exact")
    return "\n".join(lines)


def directions_text(analysis: bs.Analysis) -> str:
    """Load factors around the compass of each case with directions; without one, of three pushes or more together."""
    try:
        each = compasses(analysis)
    except bs.errors.ModelError as error:
        return f"no load factors around the compass: {error}\n"
    return "".join(f"case {name}, {around}\n" if len(each) > 1 else f"{around}\n" for name, around in each)


def parameter_texts(analysis: bs.Analysis) -> list[tuple[str, str]]:
    """What an analysis was made with, name and value with its unit."""
    return [
        (name, f"{value:~C}" if hasattr(value, "units") else str(value)) for name, value in analysis.parameters.items()
    ]


def short_names(names: Sequence[str]) -> list[str]:
    """Ends of dotted names, as long as it takes to tell them apart, none of them beginning with the place in a list.

    >>> short_names(["joint_materials.lime.cohesion", "joint_materials.dry.cohesion", "height"])
    ['lime.cohesion', 'dry.cohesion', 'height']
    >>> short_names(["blocks.left.box.size.2"])
    ['size.2']
    """
    parts = [name.split(".") for name in names]
    ends = [[".".join(p[-k:]) for k in range(1, len(p) + 1)] for p in parts]
    taken = Counter(end for own in ends for end in own)
    return [next((end for end in own if taken[end] == 1 and not end[:1].isdigit()), own[-1]) for own in ends]


def _number(value: float) -> str:
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return "none" if np.isnan(value) else f"{value:.4g}"
