"""Tables and texts for a terminal of 80 columns."""

import math
from collections.abc import Mapping
from textwrap import indent
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from rich.console import JustifyMethod
from rich.table import Table
from rich.text import Text

import blockstruct as bs
from blockstruct.text.numbers import LISTED
from blockstruct.units import SI_UNITS
from blockstruct.views.study_text import answer_cell, answer_title, folded_table, parameter_columns, status_cell
from blockstruct.views.words import (
    admissible_words,
    pushover_words,
    range_words,
    response_words,
    roller_words,
    tie_words,
)
from blockstruct.vocabulary import counted, listed

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


def model_text(model: bs.Model) -> str:
    """Return name, supports, size and weight of a model."""
    points = np.concatenate([b.shape.vertices for b in model.blocks])
    x, y, z = np.ptp(points, axis=0)
    fixed = [b.name for b in model.blocks if b.fixed]
    rollers = [f"{b.name} holds {', '.join(b.held)}" for b in model.blocks if b.is_roller]
    weight = sum(b.weight for b in model.blocks if not b.fixed)
    text = (
        f"{model.name}: {counted(len(model.blocks), 'block')}, {len(fixed)} fixed ({listed(fixed, LISTED)})\n"
        f"{x:.4g} × {y:.4g} × {z:.4g} m, mean size of the free blocks {model.characteristic_length:.3g} m, "
        f"their weight {weight / 1e3:.4g} kN"
    )
    if rollers:
        text += f"\n{counted(len(rollers), 'support')} of some motions: {listed(rollers, LISTED).replace(', ', '; ')}"
    if model.ties:
        text += f"\n{counted(len(model.ties), 'tie')}: {listed([tie.name for tie in model.ties], LISTED)}"
    return text


def result_text(result: bs.CaseResult) -> Text:
    """Return load factor, notes and certificate of a case."""
    case, c = result.case, result.certificate
    text = Text("\n").append(f"{result.name}\n", style="bold")
    text.append(f"  {case.question}\n")
    text.append(f"  {result.headline}\n", style="bold")
    if reactions := range_words(result):
        text.append(f"  {reactions}\n")
    for warning in (*result.warnings, *result.owed):
        text.append(f"  warning: {warning}\n", style="bold yellow")
    left = admissible_words(result)
    if left:
        text.append(f"  {left}\n")
    for sentence in (*roller_words(result), *tie_words(result), *pushover_words(result), *response_words(result)):
        text.append(f"  {sentence}\n")
    if c is None:
        return text
    if result.status.is_of_dead_load:
        return text.append(f"  proof of the mechanism {'holds' if c.holds else 'does not hold'}\n")
    return text.append(indent(f"{c}\n", "  "))


def summary_table(analysis: bs.Analysis) -> Table:
    """Return the table of an analysis, a row per case."""
    kinds = dict.fromkeys(r.answer.name for r in analysis.values())
    results = list(analysis.values())
    return folded_table(
        [
            ("case", [r.name for r in results], "left"),
            ("flow", [r.case.flow.value for r in results], "left"),
            ("status", [r.ended for r in results], "left"),
            (" / ".join(kinds) or "load factor", [r.answer.text(r.load_factor, 6) for r in results], "right"),
            ("programs", [str(r.n_iterations) for r in results], "right"),
            ("time [s]", [f"{r.duration:.2f}" for r in results], "right"),
        ]
    )


def archive_table(rows: pd.DataFrame) -> Table:
    """Return the table of rows of :meth:`blockstruct.Archive.table`, without unreadable files."""
    units = rows.attrs.get("units", {})
    shown = rows[rows["problem"] == ""].to_dict("records")
    varied = [c for c in rows.columns if c.startswith("parameter_")]
    columns: list[tuple[str, list[str], JustifyMethod]] = [
        (name, [row[name] for row in shown], "left") for name in ("path", "case")
    ]
    columns += parameter_columns(shown, varied, units, "parameter_")
    columns.append(("status", [status_cell(row) for row in shown], "left"))
    columns.append((answer_title(shown), [answer_cell(row) for row in shown], "right"))
    if any(math.isfinite(row["curve_end"]) for row in shown):
        columns.append(("d0 [m]", [_d0(row) for row in shown], "right"))
    columns.append(("programs", [f"{row['n_iterations']:.0f}" for row in shown], "right"))
    return folded_table(columns)


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
                "status": r.status.value,
                "load_factor": None if r.answer.is_reaction else r.load_factor,
                "reaction": _reaction(r),
                "iterations": r.n_iterations,
                "duration": r.duration,
                **_outcome(r),
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


def _outcome(r: bs.CaseResult) -> dict[str, Any]:
    """Return the outcome of a case as plain values."""
    o = r.outcome
    return {
        "reason": o.reason.value,
        "procedure": o.procedure and o.procedure.value,
        "settled": o.settled,
        "drift": o.drift,
        "peak": o.peak,
        "path_end": o.path_end and o.path_end.value,
        "without_crushing": o.without_crushing,
        "hung": list(r.hung),
        "jammed": list(r.jammed),
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
        return [f"{kind}: {part}" for part in bs.results.doubtful_parts(r.capacity, r.settings.procedure)]
    return [f"{kind}: {r.missing_curve}"] if r.missing_curve else []
