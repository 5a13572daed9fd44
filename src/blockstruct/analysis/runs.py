"""Analyses in one call: run cases, or those of a stored analysis again."""

from collections.abc import Iterable
from pathlib import Path

from blockstruct.analysis.events import Listener
from blockstruct.analysis.manager import AnalysisManager
from blockstruct.limit import ProcedureSettings
from blockstruct.model import LimitCase, Model
from blockstruct.results import Analysis, Comparison, compare


def run(
    model: Model,
    cases: LimitCase | Iterable[LimitCase],
    store: str | Path | None = None,
    *,
    settings: ProcedureSettings | None = None,
    spread: bool | str | Iterable[str] = False,
    listeners: Iterable[Listener] = (),
) -> Analysis:
    """Run limit cases of a model: :class:`AnalysisManager` in one call.

    Parameters
    ----------
    model, store, settings, listeners
        As for :class:`AnalysisManager`.
    cases, spread
        As for :meth:`AnalysisManager.run`; a single case will do.

    Raises
    ------
    ModelError, StorageError, SolverError, GeometryError
        As both do.
    """
    listed = [cases] if isinstance(cases, LimitCase) else cases
    return AnalysisManager(model, store, settings=settings, listeners=listeners).run(listed, spread=spread)


def reproduce(analysis: Analysis, *, listeners: Iterable[Listener] = ()) -> Comparison:
    """Run the model and the cases of an analysis again, each with its own settings, and compare.

    Parameters
    ----------
    analysis
        An analysis, as a rule from a file.
    listeners
        As for :class:`blockstruct.AnalysisManager`.

    Returns
    -------
    Comparison
        The analysis, and as the other one what this installation finds; versions that differ are part of it.
    """
    return compare(analysis, AnalysisManager.again(analysis, listeners=listeners))
