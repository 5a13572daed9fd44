"""Comparison of two analyses, and of two capacity curves."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import xarray as xr

from blockstruct.arrays import SLIGHT, Array
from blockstruct.results.analysis import Analysis
from blockstruct.results.case_result import CaseResult
from blockstruct.results.history import motions_in
from blockstruct.results.interfaces import at_points
from blockstruct.text.case import response_number
from blockstruct.text.note import EFFECT
from blockstruct.units import readable
from blockstruct.vocabulary import counted, in_words

#: Difference of load factors, relative to the largest of both curves, and of the ends of two curves, from which they
#: count as different.
APART = EFFECT


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """Differences between two analyses.

    Attributes
    ----------
    same_model : bool
        Whether both have the same model, to the last bit.
    cases : pandas.DataFrame
        Indexed by the cases of either analysis. A column with the suffix ``_other`` belongs to the other analysis.

        - ``load_factor`` (of a settlement its reaction), its ``unit`` (N or N·m, empty for a load factor), ``status``,
          ``n_iterations``;
        - ``relative_difference`` of the load factor, 0 if both are equal or infinite;
        - ``force_difference`` and ``mechanism_difference`` of the final states, relative to the largest contact force
          and relative velocity; infinite if they cannot be compared;
        - ``same_certificate``, within the tolerances of the settings; ``same_question``: loads, flow and settings;
        - for records ``peak_displacement`` (m), ``collapse_time`` (s) and ``response_difference``, the largest of the
          relative differences of both numbers and of the displacements of all blocks at common times, infinite if they
          cannot be compared;
        - for pushovers ``d0``, ``curve_ended``, ``curve_difference`` and ``curves_part_at``:
          :func:`blockstruct.results.compared_curves`.
    versions : mapping
        Packages with different versions, and both versions.
    settings : mapping
        Cases with different settings: each setting, and both values.
    """

    same_model: bool
    cases: pd.DataFrame
    versions: Mapping[str, tuple[str, str]]
    settings: Mapping[str, Mapping[str, tuple[Any, Any]]]

    def agrees(self, rtol: float = 1e-6, state_rtol: float = 1e-2, curve_rtol: float = 1e-2) -> bool:
        """Return whether all cases ended alike.

        Parameters
        ----------
        rtol
            Largest relative difference of load factors.
        state_rtol
            Largest relative difference of forces and velocities; infinity ignores them. Neither is unique, and both
            depend on the last digits of a solver more than the load factor does.
        curve_rtol
            Largest difference of capacity curves and of responses; infinity ignores them.
        """
        c = self.cases
        alike = c["status"].eq(c["status_other"]) & c["relative_difference"].abs().le(rtol) & c["same_certificate"]
        for difference in ("force_difference", "mechanism_difference"):
            alike &= c[difference].le(state_rtol)
        alike &= c["curve_difference"].le(curve_rtol) & c["response_difference"].le(curve_rtol)
        return bool(self.same_model and alike.all())

    def __str__(self) -> str:
        lines = [f"{'the same model' if self.same_model else 'different models'}, {counted(len(self.cases), 'case')}"]
        for name, row in self.cases.iterrows():
            ended = [in_words(row[f"status{suffix}"]) for suffix in ("", "_other")]
            question = "" if row["same_question"] else ", another question"
            if np.isfinite([row["peak_displacement"], row["peak_displacement_other"]]).any():
                lines.append(f"  {name}: {_of_responses(row, ended)}{question}")
                continue
            answers = [_answer(row[f"load_factor{suffix}"], row[f"unit{suffix}"]) for suffix in ("", "_other")]
            lines.append(
                f"  {name}: {ended[0]} {answers[0]}, other {ended[1]} {answers[1]}, "
                f"relative difference {row['relative_difference']:.1e}, "
                f"of forces {_shown(row['force_difference'])}, "
                f"of the mechanism {_shown(row['mechanism_difference'])}"
                f"{'' if row['same_certificate'] else ', another certificate'}"
                f"{question}"
            )
            if row["curve_ended"] or row["curve_ended_other"] or row["curve_difference"]:
                lines += _of_curves(row)
        lines += [f"  {package}: {one}, other {two}" for package, (one, two) in self.versions.items()]
        for case, changed in self.settings.items():
            lines += [f"  {case}: {name} {one!r}, other {two!r}" for name, (one, two) in changed.items()]
        return "\n".join(lines)


def _shown(difference: float) -> str:
    """Return the difference of two states as text."""
    return f"{difference:.1e}" if np.isfinite(difference) else "not comparable"


def _answer(value: float, unit: str) -> str:
    """Return a load factor, or a reaction in a readable unit, as text."""
    if not (unit and np.isfinite(value)):
        return f"{value:.8g}"
    scale, readable_unit = readable(value, unit)
    return f"{value * scale:.8g} {readable_unit}"


def _of_responses(row: Any, ended: Sequence[str]) -> str:
    """Return the clause on the differences between two responses to a record, which ended so."""
    numbers = [
        response_number(row[f"peak_displacement{suffix}"], row[f"collapse_time{suffix}"]) for suffix in ("", "_other")
    ]
    one, other = (f"{end}, {name} {text}" for end, (name, text) in zip(ended, numbers, strict=True))
    return f"{one}, other {other}, relative difference of responses {_shown(row['response_difference'])}"


def _of_curves(row: Any) -> list[str]:
    """Return the lines on the differences between two capacity curves."""
    parted = f", from {row['curves_part_at']:.4g} m on" if np.isfinite(row["curves_part_at"]) else ""
    ends = [in_words(row[name]) or "no end" for name in ("curve_ended", "curve_ended_other")]
    d0s = f"    d0 {row['d0']:.6g} m, other {row['d0_other']:.6g} m"
    line = f"{d0s}, curves differ by {row['curve_difference']:.1e}{parted}"
    return [line] + [f"    {ends[0]}; other: {ends[1]}"] * (ends[0] != ends[1])


def compare(one: Analysis, other: Analysis) -> Comparison:
    """Compare two analyses, case by case.

    Parameters
    ----------
    one, other
        Analyses of one model, or of two.
    """
    rows, settings = {}, {}
    for name in dict.fromkeys((*one, *other)):
        first, second = (a.get(name) for a in (one, other))
        row: dict[str, Any] = {}
        for result, suffix in ((first, ""), (second, "_other")):
            row[f"load_factor{suffix}"] = np.nan if result is None else result.answer.factor * result.load_factor
            row[f"unit{suffix}"] = "" if result is None else result.answer.unit
            row[f"status{suffix}"] = "missing" if result is None else result.status.value
            row[f"n_iterations{suffix}"] = 0 if result is None else result.n_iterations
            for number in ("peak_displacement", "collapse_time"):
                row[f"{number}{suffix}"] = np.nan if result is None else getattr(result, number)
        row["relative_difference"] = float(relative_difference(row["load_factor"], row["load_factor_other"]))
        row |= {"force_difference": np.inf, "mechanism_difference": np.inf, "same_certificate": False}
        row["same_question"] = False
        row |= compared_curves(*(None if result is None else result.capacity for result in (first, second)))
        row["response_difference"] = _response_difference(first, second)
        for result, suffix in ((first, ""), (second, "_other")):
            outcome = None if result is None else result.curve_outcome
            row[f"curve_ended{suffix}"] = "" if outcome is None else outcome.end.value
        if first is not None and second is not None:
            row["force_difference"] = _state_difference(first, second, lambda last: at_points(last, "contact_force"))
            motions = (lambda last: at_points(last, "relative_velocity")), motions_in
            row["mechanism_difference"] = max(_state_difference(first, second, motion) for motion in motions)
            row["same_certificate"] = _same_certificate(first, second)
            changed = _changed(first.settings.flat, second.settings.flat)
            row["same_question"] = not changed and first.case == second.case
            if changed:
                settings[name] = changed
        rows[name] = row
    cases = pd.DataFrame.from_dict(rows, orient="index").rename_axis("case")
    return Comparison(
        same_model=one.model.hash == other.model.hash,
        cases=cases,
        versions=_changed(one.versions, other.versions),
        settings=settings,
    )


def relative_difference(one: npt.ArrayLike, other: npt.ArrayLike) -> Array:
    """Return the relative difference of load factors.

    It is 0 if both are equal, infinite or missing (NaN).
    """
    a, b = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0.0, (b - a) / np.abs(a))


def _state_difference(one: CaseResult, other: CaseResult, values: Callable[[xr.Dataset], Any]) -> float:
    """Return the largest difference of values in the last iterations.

    The difference is relative to the largest value.

    It is infinite if they cannot be compared. Two states without numbers are equal.
    """
    first, second = (values(r.history.isel(iteration=-1)) if r.n_iterations else np.empty(0) for r in (one, other))
    if first.shape != second.shape:
        return np.inf
    if np.array_equal(first, second, equal_nan=True):
        return 0.0
    difference = np.abs(first - second).max() / max(np.abs(first).max(), np.abs(second).max())
    return float(difference) if np.isfinite(difference) else np.inf


def _response_difference(one: CaseResult | None, other: CaseResult | None) -> float:
    """Return the largest relative difference of two responses; 0 if neither is one, infinite if only one is."""
    first, second = (None if result is None else result.response for result in (one, other))
    if one is None or other is None or first is None or second is None:
        return 0.0 if first is second else np.inf
    numbers = ((getattr(one, name), getattr(other, name)) for name in ("peak_displacement", "collapse_time"))
    apart = [float(np.abs(relative_difference(*pair))) for pair in numbers]
    a, b = xr.align(first["displacement"], second["displacement"])
    if largest := max(float(np.abs(values).max()) for values in (first["displacement"], second["displacement"])):
        apart.append(np.abs(a.to_numpy() - b.to_numpy()).max(initial=0.0) / largest)
    return float(np.nan_to_num(apart, nan=np.inf).max())


def _same_certificate(one: CaseResult, other: CaseResult) -> bool:
    """Return whether both certificates agree within their tolerances."""
    a, b = one.certificate, other.certificate
    if a is None or b is None:
        return a is b
    s, limit = one.settings, np.fmax(a.flow_rule_gap_limit, b.flow_rule_gap_limit)
    pairs = (
        (a.equilibrium_residual, b.equilibrium_residual, s.numerics.equilibrium_tolerance),
        # A yield excess below zero is inside the conditions; its size does not matter.
        (max(a.yield_excess, 0.0), max(b.yield_excess, 0.0), s.numerics.yield_tolerance),
        (a.interpenetration, b.interpenetration, s.numerics.interpenetration_tolerance),
        (a.flow_rule_gap, b.flow_rule_gap, limit),
    )
    # Two NaN agree with each other, and a NaN with nothing else.
    alike = (np.isnan([x, y]).all() or abs(x - y) <= max(scale, SLIGHT * abs(x)) for x, y, scale in pairs)
    return a.holds == b.holds and all(alike)


def _changed(one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    keys = dict.fromkeys((*one, *other))
    return {key: (one.get(key), other.get(key)) for key in keys if one.get(key) != other.get(key)}


def compared_curves(one: xr.Dataset | None, other: xr.Dataset | None) -> dict[str, Any]:
    """Compare two capacity curves; return the values of one row.

    Returns
    -------
    dict
        ``d0`` (m, NaN without one) of each curve, with the suffix ``_other`` for the second.

        ``curve_difference`` is the larger of two differences. One is the largest difference of load factors at the same
        displacement, relative to the largest load factor of both. The other is the difference of the final
        displacements, relative to the larger one. It is 0 if neither is a pushover. It is infinite if only one is a
        pushover, or only one curve reaches zero.

        ``curves_part_at`` (m) is the first displacement at which the load factors differ by more than 1 % of the
        largest; NaN if they do not.
    """
    row: dict[str, Any] = {}
    for curve, suffix in ((one, ""), (other, "_other")):
        row[f"d0{suffix}"] = np.nan if curve is None else float(curve["d0"])
    if one is None or other is None:
        return row | {"curve_difference": 0.0 if one is other else np.inf, "curves_part_at": np.nan}
    (way, alpha), (way_other, alpha_other) = _along(one), _along(other)
    common = np.union1d(way, way_other)
    common = common[common <= min(way[-1], way_other[-1])]
    largest = max(np.abs(alpha).max(), np.abs(alpha_other).max(), np.finfo(float).tiny)
    apart = np.abs(np.interp(common, way, alpha) - np.interp(common, way_other, alpha_other)) / largest
    parted = common[apart > APART]
    row["curves_part_at"] = float(np.interp(parted[0], way, one["displacement"])) if len(parted) else np.nan
    ends = [row[name] if np.isfinite(row[name]) else way_[-1] for name, way_ in (("d0", way), ("d0_other", way_other))]
    furthest = max(np.abs(ends).max(), np.finfo(float).tiny)
    both = np.isfinite(row["d0"]) == np.isfinite(row["d0_other"])
    row["curve_difference"] = float(max(apart.max(), abs(ends[0] - ends[1]) / furthest)) if both else np.inf
    return row


def _along(curve: xr.Dataset) -> tuple[Array, Array]:
    """Return the path length of the control point, m, and load factors.

    The length adds motions to and fro along the direction of the point.
    """
    displacement, alpha = (curve[name].transpose("step").to_numpy() for name in ("displacement", "load_factor"))
    return np.abs(np.diff(displacement, prepend=displacement[0])).cumsum(), alpha
