"""The answers of several schedules to one case."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Self

import numpy as np

from blockstruct.keywords import made_again
from blockstruct.limit import SCHEDULES
from blockstruct.notebook import html_table
from blockstruct.results.case_result import CaseResult
from blockstruct.results.headline import Headline, is_same, path_text
from blockstruct.vocabulary import ALONG_PATH, Flow, Stage, Status, counted

#: Key of the run with the settings as they were given.
AS_GIVEN = "as given"
#: Flow of the runs of a spread.
FLOWS = dict.fromkeys(SCHEDULES, Flow.NONASSOCIATIVE) | {str(Flow.ASSOCIATIVE): Flow.ASSOCIATIVE}


def run_name(case: str, schedule: str) -> str:
    """Name of the run of a case with a schedule."""
    return f"{case} [{schedule}]"


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Non-associative answers to one case by several schedules, and the associative one above them all.

    The answer of a non-associative structure is not unique and depends on the path: each of these is certified by
    itself, and none is wrong. The lowest of those that settled is the one to rely on. A load factor that was still
    drifting when its run was stopped is not an answer of its schedule, and counts only where none has settled, or none
    but the shift, which does not drift and often ends high.

    Attributes
    ----------
    runs : mapping of str to CaseResult
        Result of each schedule, ``"as given"`` for the settings of the analysis; each has its certificate and history.
    lowest, highest : CaseResult or None
        Of the runs that converged and settled; of all that converged where none has settled but the shift. The run as
        given is the lowest where no other is below it by more than a millionth.
    upper_bound : CaseResult or None
        Result with associative flow, above every non-associative answer (Radenković).
    """

    runs: Mapping[str, CaseResult]
    lowest: CaseResult | None
    highest: CaseResult | None
    upper_bound: CaseResult | None

    def __post_init__(self) -> None:
        object.__setattr__(self, "runs", MappingProxyType(dict(self.runs)))

    def __reduce__(self) -> tuple[Any, ...]:
        return made_again(self)

    @classmethod
    def of(cls, runs: Mapping[str, CaseResult], upper_bound: CaseResult | None) -> Self:
        """Spread of the runs of a case."""
        certified = sorted((r for r in runs.values() if r.status is Status.CONVERGED), key=lambda r: r.load_factor)
        if not _shift_alone(certified):
            certified = [r for r in certified if r.settled] or certified
        lowest, highest = (certified[0], certified[-1]) if certified else (None, None)
        given = next(iter(runs.values()))
        if lowest is not None and given in certified and is_same(given.load_factor, lowest.load_factor):
            lowest = given
        return cls(runs, lowest, highest, upper_bound)

    @property
    def results(self) -> dict[str, CaseResult]:
        """All results by their schedules, that of associative flow last."""
        bound = {} if self.upper_bound is None else {str(Flow.ASSOCIATIVE): self.upper_bound}
        return {**self.runs, **bound}

    @property
    def path_dependence(self) -> tuple[float, float] | None:
        """Lowest and highest load factor along the loading path: by its steps and by the shear stiffness of its joints.

        None without two loading paths that came to their ends.
        """
        found = [run.load_factor for run in self.runs.values() if ALONG_PATH in run.message and run.settled]
        return (min(found), max(found)) if len(found) > 1 else None

    @property
    def certified(self) -> int:
        """Number of schedules that ended with a certified load factor."""
        return self.headline.certified

    @property
    def headline(self) -> Headline:
        """The load factor to rely on, that of :attr:`lowest`, with its range and the associative bound."""
        runs = list(self.runs.values())
        bound = runs[0].associative_load_factor if self.upper_bound is None else self.upper_bound.load_factor
        ends = [(r.status, r.load_factor, r.settled) for r in runs]
        return Headline.of(ends, runs[0].case.flow, bound, runs[0].answer, shift_alone=_shift_alone(runs))

    @property
    def relied_on(self) -> CaseResult:
        """The run that :attr:`headline` stands for: :attr:`lowest`, or the first of those that end with its status."""
        status = self.headline.status
        if self.lowest is not None and status is Status.CONVERGED:
            return self.lowest
        return next(run for run in self.runs.values() if run.status is status)

    @property
    def load_factor(self) -> float:
        """The load factor to rely on: that of :attr:`headline`."""
        return self.headline.load_factor

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the runs that the headline stands for, each once: those of a load factor hold where it is one."""
        status = self.headline.status
        ended = (result for result in self.runs.values() if result.status is status)
        return tuple(dict.fromkeys(text for result in ended for text in result.warnings))

    @property
    def owed(self) -> tuple[str, ...]:
        """What the number owes to torsion and to crushing, of the run that it is of; empty where there is none."""
        counts = self.headline.status is Status.CONVERGED
        return self.lowest.owed if counts and self.lowest is not None else ()

    def __repr__(self) -> str:
        return f"<Spread of {counted(len(self.runs), 'schedule')}: {self.headline}>"

    def _repr_html_(self) -> str:
        answer = next(iter(self.runs.values())).answer.name
        rows = [(name, r.answer.text(r.load_factor, 4), r.ended) for name, r in self.results.items()]
        return html_table(f"{answer.capitalize()} {self.headline}", ["schedule", answer, "status"], rows, self.warnings)

    def __str__(self) -> str:
        lines = [str(self.headline)]
        width = 2 + max(map(len, self.results))
        lines += [f"  {n:<{width}}{r.answer.text(r.load_factor, 4):<12}{r.ended}" for n, r in self.results.items()]
        if self.path_dependence is not None:
            lines.append(f"  {path_text(self.path_dependence, next(iter(self.runs.values())).answer)}")
        return "\n".join([*lines, *(f"  warning: {text}" for text in self.warnings)])


def _shift_alone(runs: Iterable[CaseResult]) -> bool:
    """Whether the runs that settled are all of the shifted objective, and a certified one that drifts is below them."""
    certified = [r for r in runs if r.status is Status.CONVERGED]
    settled = [r for r in certified if r.settled]
    lowest = min((r.load_factor for r in settled), default=-np.inf)
    below = any(r.drifts and r.load_factor < lowest for r in certified)
    return below and all((r.history["stage"] == Stage.SHIFTED.value).any() for r in settled)


def spreads_of(results: Mapping[str, CaseResult]) -> dict[str, Spread]:
    """Spreads of the cases that were run with several schedules, by their names; the names of runs tell."""
    runs: dict[str, dict[str, CaseResult]] = {}
    for name, result in results.items():
        case, schedule = _parts(name)
        given, flow = results.get(case), FLOWS.get(schedule)
        if given and flow and result.case == given.case.renamed(name, flow):
            runs.setdefault(case, {AS_GIVEN: given})[schedule] = result
    bounds = {case: found.pop(Flow.ASSOCIATIVE, None) for case, found in runs.items()}
    return {case: Spread.of(found, bounds[case]) for case, found in runs.items()}


def _parts(name: str) -> tuple[str, str]:
    """Case and schedule of the name of a run; no case for any other name."""
    case, _, schedule = name.rpartition(" [")
    return (case, schedule[:-1]) if schedule.endswith("]") else ("", name)
