"""Keep the iterations of a killed run."""

from pathlib import Path

from blockstruct.analysis.planning import blank_history
from blockstruct.results import Analysis
from blockstruct.storage import Checkpoint


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
