"""Progress of a study."""

import sys
from collections.abc import Callable
from dataclasses import dataclass

from blockstruct.vocabulary import counted


@dataclass(frozen=True, slots=True)
class StudyProgress:
    """Count of the runs of a study, sent when a run ends.

    Attributes
    ----------
    done, total : int
        Runs that have ended, including failed and earlier ones, and all runs.
    failed : int
    found : int
        Runs that an earlier study had finished.
    seconds : float
        Since the study began.
    """

    done: int
    total: int
    failed: int
    found: int
    seconds: float

    @property
    def seconds_left(self) -> float:
        """Estimate from the mean duration of ended runs; NaN before the first."""
        now = self.done - self.found
        return self.seconds / now * (self.total - self.done) if now else float("nan")

    def __str__(self) -> str:
        """Return one line of text."""
        text = f"{self.done} of {counted(self.total, 'run')}"
        text += f", {self.found} of them found" if self.found else ""
        text += f", {self.failed} failed" if self.failed else ""
        if self.done == self.total:
            return f"{text}, in {_time(self.seconds)}"
        return f"{text}, about {_time(self.seconds_left)} left" if self.done > self.found else text


Listener = Callable[[StudyProgress], None]


def print_progress(progress: StudyProgress) -> None:
    """Print one line of progress on the terminal, over the previous one."""
    end = "\n" if progress.done == progress.total else ""
    print(f"\r\x1b[K{progress}", end=end, file=sys.stderr, flush=True)


def _time(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"
