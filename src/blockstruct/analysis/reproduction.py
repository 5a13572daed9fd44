"""Running a stored analysis again."""

from collections.abc import Iterable

from blockstruct.analysis.events import Listener
from blockstruct.analysis.manager import AnalysisManager
from blockstruct.results import Analysis, Comparison, compare


def reproduce(analysis: Analysis, *, listeners: Iterable[Listener] = ()) -> Comparison:
    """Run the model and the cases of an analysis again, each with its own settings, and compare.

    Parameters
    ----------
    analysis
        An analysis, as a rule from a file.
    listeners
        As of :class:`blockstruct.AnalysisManager`.

    Returns
    -------
    Comparison
        The analysis, and as the other one what this installation finds; versions that differ are part of it.
    """
    return compare(analysis, AnalysisManager.again(analysis, listeners=listeners))
