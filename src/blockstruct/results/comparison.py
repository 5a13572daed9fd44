"""Two analyses side by side."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from numpy.typing import NDArray

from blockstruct.results.analysis import Analysis


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """What differs between two analyses.

    Attributes
    ----------
    same_model : bool
        Whether both have the same model, to the last bit.
    cases : pandas.DataFrame
        Indexed by the name of the case, of one analysis or both: ``load_factor``, ``status`` and ``n_iterations`` of
        each, with ``_other`` for the other one's, ``relative_difference`` of the load factor (0 where both are the
        same, as two infinite ones are), and whether loads, flow and ``settings`` are ``same_question``.
    versions : mapping
        Packages of different versions, and both versions.
    settings : mapping
        Of each case with different settings: the settings, and both values.
    """

    same_model: bool
    cases: pd.DataFrame
    versions: Mapping[str, tuple[str, str]]
    settings: Mapping[str, Mapping[str, tuple[Any, Any]]]

    def agrees(self, rtol: float = 1e-6) -> bool:
        """Whether all cases ended alike, with load factors that differ by no more than a relative tolerance."""
        c = self.cases
        alike = c["status"].eq(c["status_other"]) & c["relative_difference"].abs().le(rtol)
        return bool(self.same_model and alike.all())

    def __str__(self) -> str:
        lines = [f"{'the same model' if self.same_model else 'different models'}, {len(self.cases)} cases"]
        for name, row in self.cases.iterrows():
            lines.append(
                f"  {name}: {row['status']} {row['load_factor']:.8g}, other {row['status_other']} "
                f"{row['load_factor_other']:.8g}, relative difference {row['relative_difference']:.1e}"
                f"{'' if row['same_question'] else ', another question'}"
            )
        lines += [f"  {package}: {one}, other {two}" for package, (one, two) in self.versions.items()]
        for case, changed in self.settings.items():
            lines += [f"  {case}: {name} {one!r}, other {two!r}" for name, (one, two) in changed.items()]
        return "\n".join(lines)


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
            row[f"load_factor{suffix}"] = np.nan if result is None else result.load_factor
            row[f"status{suffix}"] = "missing" if result is None else result.status.value
            row[f"n_iterations{suffix}"] = 0 if result is None else result.n_iterations
        row["relative_difference"] = float(relative_difference(row["load_factor"], row["load_factor_other"]))
        row["same_question"] = False
        if first is not None and second is not None:
            changed = _changed(asdict(first.settings), asdict(second.settings))
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


def relative_difference(one: npt.ArrayLike, other: npt.ArrayLike) -> NDArray[np.float64]:
    """Difference of load factors relative to the first; 0 where both are the same, infinite or missing (NaN)."""
    a, b = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0.0, (b - a) / np.abs(a))


def _changed(one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    keys = dict.fromkeys((*one, *other))
    return {key: (one.get(key), other.get(key)) for key in keys if one.get(key) != other.get(key)}
