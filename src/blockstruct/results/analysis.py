"""An analysis: a model and the results of its cases."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import xarray as xr

from blockstruct.errors import ModelError, UnknownNameError
from blockstruct.model import LimitCase, Model
from blockstruct.results.case_result import CaseResult
from blockstruct.results.spread import Spread
from blockstruct.vocabulary import Status

Sweep = Callable[[str, Any, LimitCase], xr.Dataset]


@dataclass(frozen=True, slots=True, init=False, eq=False)
class Analysis(Mapping[str, CaseResult]):
    """A mapping of the names of cases to their results, with the model they belong to.

    Attributes
    ----------
    model : Model
    created_at : str
        UTC, ISO 8601.
    versions : mapping
        Version of blockstruct and of every package that made the numbers.
    """

    model: Model
    results: Mapping[str, CaseResult]
    created_at: str
    versions: Mapping[str, str]
    _sweep: Sweep | None

    def __init__(
        self,
        model: Model,
        results: Mapping[str, CaseResult],
        created_at: str,
        versions: Mapping[str, str],
        sweep: Sweep | None = None,
    ) -> None:
        object.__setattr__(self, "model", model)
        object.__setattr__(self, "results", MappingProxyType(dict(results)))
        object.__setattr__(self, "created_at", created_at)
        object.__setattr__(self, "versions", MappingProxyType(dict(versions)))
        object.__setattr__(self, "_sweep", sweep)

    @property
    def cases(self) -> tuple[LimitCase, ...]:
        """The cases, ready to be run again."""
        return tuple(r.case for r in self.results.values())

    @property
    def status(self) -> str:
        """``"interrupted"`` if a case was, ``"finished"`` otherwise."""
        cut = any(r.status is Status.INTERRUPTED for r in self.results.values())
        return "interrupted" if cut else "finished"

    def spread(self, name: str) -> Spread:
        """Answers of the schedules that a case was run with: ``manager.run(cases, spread=True)``.

        Raises
        ------
        UnknownNameError
            No case of this name.
        ModelError
            A case that was run with one schedule only.
        """
        spread = Spread.of(self[name], self)
        if len(spread.runs) == 1 and spread.upper_bound is None:
            msg = f"case {name!r}: was run with one schedule; run it again with spread=True"
            raise ModelError(msg)
        return spread

    def sweep(self, quantity: str, values: Any, case: str | None = None) -> xr.Dataset:
        """Load factor of a case for several values of a joint property: :meth:`AnalysisManager.sweep`.

        Parameters
        ----------
        quantity, values
            As there.
        case
            Name of the case; the only one by default.

        Raises
        ------
        ModelError
            No case named where there are several, or an analysis that was read from a file: nothing there can solve
            it, give its model to an AnalysisManager.
        """
        if self._sweep is None:
            msg = (
                f"analysis of {self.model.name!r}: was read from a file; sweep with "
                "AnalysisManager(analysis.model).sweep(quantity, values, case)"
            )
            raise ModelError(msg)
        if case is None and len(self) != 1:
            msg = f"analysis of {self.model.name!r}: name the case to sweep: {', '.join(self)}"
            raise ModelError(msg)
        result = self[next(iter(self)) if case is None else case]
        return self._sweep(quantity, values, result.case)

    def __getitem__(self, name: str) -> CaseResult:
        if name not in self.results:
            msg = f"analysis of {self.model.name!r}: no case {name!r}; it has {', '.join(self.results) or 'none'}"
            raise UnknownNameError(msg)
        return self.results[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.results)

    def __len__(self) -> int:
        return len(self.results)

    def __str__(self) -> str:
        head = (
            f"analysis of {self.model.name!r}: {len(self.model.blocks)} blocks, {len(self.model.interfaces)} interfaces"
        )
        return "\n".join([head, *(f"  {r}" for r in self.results.values())])
