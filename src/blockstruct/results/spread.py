"""The answers of several schedules to one case."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Self

from blockstruct.results.case_result import CaseResult
from blockstruct.vocabulary import Flow, Status

#: Key of the run with the settings as they were given.
AS_GIVEN = "as given"


def run_name(case: str, schedule: str) -> str:
    """Name of the run of a case with a schedule."""
    return f"{case} [{schedule}]"


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Non-associative answers to one case by several schedules, and the associative one above them all.

    The answer of a non-associative structure is not unique and depends on the path: each of these is certified by
    itself, and none is wrong. The lowest is the one to rely on.

    Attributes
    ----------
    runs : mapping of str to CaseResult
        Result of each schedule, ``"as given"`` for the settings of the analysis; each has its certificate and history.
    lowest, highest : CaseResult or None
        Of the runs that converged.
    upper_bound : CaseResult or None
        Result with associative flow, above every non-associative answer (Radenković).
    """

    runs: Mapping[str, CaseResult]
    lowest: CaseResult | None
    highest: CaseResult | None
    upper_bound: CaseResult | None

    @classmethod
    def of(cls, result: CaseResult, results: Mapping[str, CaseResult]) -> Self:
        """Spread of a case, found by the names of its runs."""
        runs = {AS_GIVEN: result}
        start, upper_bound = run_name(result.name, "")[:-1], None
        for name, other in results.items():
            if name.startswith(start) and name.endswith("]"):
                if other.case.flow is Flow.ASSOCIATIVE:
                    upper_bound = other
                else:
                    runs[name[len(start) : -1]] = other
        certified = sorted((r for r in runs.values() if r.status is Status.CONVERGED), key=lambda r: r.load_factor)
        lowest, highest = (certified[0], certified[-1]) if certified else (None, None)
        return cls(MappingProxyType(runs), lowest, highest, upper_bound)

    def __str__(self) -> str:
        lines = [f"spread over {len(self.runs)} schedules"]
        for what, result in (("lowest", self.lowest), ("highest", self.highest), ("associative", self.upper_bound)):
            lines.append(f"  {what:<12}{'none' if result is None else f'{result.load_factor:.6g} ({result.name})'}")
        return "\n".join(lines)
