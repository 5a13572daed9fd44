"""Analyses in one call: run cases, repeat a stored analysis, or keep the iterations of a killed run."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from blockstruct.analysis.events import Listener, Progress
from blockstruct.analysis.manager import AnalysisManager
from blockstruct.analysis.plan import blank_history
from blockstruct.errors import ModelError
from blockstruct.limit import ProcedureSettings
from blockstruct.model import Case, Model
from blockstruct.results import Analysis, Comparison, compare
from blockstruct.storage import Checkpoint


def run(
    model: Model,
    cases: Case | Iterable[Case],
    store: str | Path | None = None,
    *,
    settings: ProcedureSettings | None = None,
    spread: bool | str | Iterable[str] = False,
    parameters: Mapping[str, Any] = MappingProxyType({}),
    listeners: Iterable[Listener] = (),
    progress: Progress = "auto",
) -> Analysis:
    """Run cases of a model: :class:`AnalysisManager` in one call.

    Parameters
    ----------
    model, store, settings, parameters, listeners, progress
        As for :class:`AnalysisManager`.
    cases, spread
        As for :meth:`AnalysisManager.run`; ``cases`` may be a single case.

    Raises
    ------
    ModelError, StorageError, SolverError, GeometryError
        As :class:`AnalysisManager` and its method ``run``.
    """
    listed = [cases] if isinstance(cases, Case) else cases
    manager = AnalysisManager(
        model, store, settings=settings, parameters=parameters, listeners=listeners, progress=progress
    )
    return manager.run(listed, spread=spread)


def reproduce(analysis: Analysis, *, listeners: Iterable[Listener] = ()) -> Comparison:
    """Run an analysis again, each case with its own settings, and compare.

    Parameters
    ----------
    analysis
        An analysis, as a rule from a file.
    listeners
        As for :class:`blockstruct.AnalysisManager`.

    Returns
    -------
    Comparison
        The stored analysis, and the new one of this installation as the other, with the versions that differ.

    Raises
    ------
    ModelError
        If the argument is not an analysis, such as the name of a file.
    """
    if not isinstance(analysis, Analysis):
        msg = f"reproduce: {type(analysis).__name__} is not an analysis; give bs.open_analysis(file)"
        raise ModelError(msg)
    return compare(analysis, AnalysisManager.again(analysis, listeners=listeners))


def recover(path: str | Path) -> Analysis:
    """Make the analysis file of a killed run from its committed iterations.

    Cases that had not ended get the status ``interrupted``. :meth:`blockstruct.AnalysisManager.resume` continues
    either the killed run or the recovered file.

    Parameters
    ----------
    path
        The file that the run would have written. A file that was there when the run began is replaced, as the run would
        have done. No other file is replaced.

    Raises
    ------
    StorageError
        If there is no killed run, it is still under way, or the path cannot be written.
    FormatError
        If the working data are damaged at their root.
    """
    with Checkpoint.reopen(path, blank_history) as working:
        analysis = working.analysis()
        working.finish(analysis)
    return analysis
