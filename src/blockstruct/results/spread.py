"""Results of one case with several schedules."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from blockstruct.arrays import NEGLIGIBLE
from blockstruct.errors import made_again
from blockstruct.notebook import html_table
from blockstruct.results.case_result import CaseResult, Headline
from blockstruct.vocabulary import Flow, Procedure, counted

#: Key of the run with the settings of the analysis.
AS_GIVEN = "as given"


def run_name(case: str, schedule: str) -> str:
    """Return the name of the run of a case with a schedule."""
    return f"{case} [{schedule}]"


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Results of a non-associative case with several schedules.

    The associative case is included.

    The load factor of a non-associative structure is not unique. The headline belongs to the run as given, and the
    variants of the loading path give its range. Schedules of the paper's procedure change neither.

    Attributes
    ----------
    runs : mapping of str to CaseResult
        Result of each schedule, ``"as given"`` for the settings of the analysis.
    upper_bound : CaseResult or None
        Result with associative flow, an upper bound for every non-associative load factor (Radenković).
    """

    runs: Mapping[str, CaseResult]
    upper_bound: CaseResult | None

    def __post_init__(self) -> None:
        object.__setattr__(self, "runs", MappingProxyType(dict(self.runs)))

    def __reduce__(self) -> tuple[Any, ...]:
        return made_again(self)

    @property
    def given(self) -> CaseResult:
        """The run with the settings of the analysis."""
        return self.runs[AS_GIVEN]

    @property
    def results(self) -> dict[str, CaseResult]:
        """All results by schedule, the associative one last."""
        bound = {} if self.upper_bound is None else {str(Flow.ASSOCIATIVE): self.upper_bound}
        return {**self.runs, **bound}

    @property
    def lowest(self) -> CaseResult | None:
        """The settled run with the lowest certified load factor; None without one."""
        return min(self._settled, key=lambda r: r.load_factor, default=None)

    @property
    def highest(self) -> CaseResult | None:
        """Settled run with the highest certified load factor; None without one."""
        return max(self._settled, key=lambda r: r.load_factor, default=None)

    @property
    def relied_on(self) -> CaseResult:
        """Run to rely on: the settled loading path of lowest load factor, or the given run if both are equal.

        It has the range of the loading paths.
        """
        paths = [run for run in self._settled if run.outcome.procedure is Procedure.LOADING_PATH]
        low, given = min(paths, key=lambda run: run.load_factor, default=self.given), self.given
        is_lower = given.load_factor - low.load_factor > NEGLIGIBLE * abs(given.load_factor)
        if not is_lower or given not in self._settled:
            return given
        return low.changed(path_dependence=self.path_dependence)

    @property
    def _settled(self) -> list[CaseResult]:
        # A load factor that crushing raised counts as the one without crushing.
        return [run for run in self.runs.values() if run.settled or np.isfinite(run.outcome.without_crushing)]

    @property
    def path_dependence(self) -> tuple[float, float] | None:
        """Lowest and highest load factor of the settled loading paths.

        None with fewer than two such paths.
        """
        load_factors = [r.load_factor for r in self._settled if r.outcome.procedure is Procedure.LOADING_PATH]
        return (min(load_factors), max(load_factors)) if len(load_factors) > 1 else None

    @property
    def headline(self) -> Headline:
        """Load factor of the given run, with its range and associative bound."""
        return self.given.headline

    @property
    def load_factor(self) -> float:
        """Load factor of the run as given."""
        return self.given.load_factor

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the run as given."""
        return self.given.warnings

    def __repr__(self) -> str:
        return f"<Spread of {counted(len(self.runs), 'schedule')}: {self.headline}>"

    def _repr_html_(self) -> str:
        answer = self.given.answer.name
        rows = [(name, r.answer.text(r.load_factor, 4), r.ended) for name, r in self.results.items()]
        return html_table(f"{self.given.name}: {self.headline}", ["schedule", answer, "status"], rows, self.warnings)

    def __str__(self) -> str:
        width = 2 + max(map(len, self.results))
        lines = [f"  {n:<{width}}{r.answer.text(r.load_factor, 4):<12}{r.ended}" for n, r in self.results.items()]
        return "\n".join([str(self.headline), *lines, *(f"  warning: {text}" for text in self.warnings)])


def spreads_of(results: Mapping[str, CaseResult]) -> dict[str, Spread]:
    """Return the spreads of cases with several schedules, by case name."""
    runs: dict[str, dict[str, CaseResult]] = {}
    for result in results.values():
        if result.of_case in results:
            runs.setdefault(result.of_case, {AS_GIVEN: results[result.of_case]})[result.schedule] = result
    bounds = {case: found.pop(str(Flow.ASSOCIATIVE), None) for case, found in runs.items()}
    return {case: Spread(found, bounds[case]) for case, found in runs.items()}
