"""One run of a study, on any machine."""

import pickle
import tempfile
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Self

from blockstruct.analysis import AnalysisManager, recover
from blockstruct.errors import BusyError, LoadFactorWarning
from blockstruct.results import restored_value
from blockstruct.storage import is_unfinished
from blockstruct.studies.plan import Plan
from blockstruct.units import own_registry
from blockstruct.vocabulary import Status


@dataclass(frozen=True, slots=True)
class Job:
    """A run to carry out.

    Attributes
    ----------
    name : str
        Name of its file, without suffix.
    values : dict
        Values as JSON stores them.
    anew : bool
        Whether to put existing data aside instead of continuing them.
    """

    name: str
    values: dict[str, Any]
    anew: bool = False


@dataclass(frozen=True, slots=True)
class Problem:
    """Why a run has no results; false if it has results.

    Attributes
    ----------
    text : str
    is_elsewhere : bool
        Whether another study is carrying the run out. Such a run has not failed.
    """

    text: str = ""
    is_elsewhere: bool = False

    @classmethod
    def of(cls, error: BaseException) -> Self:
        """Return the problem of an error."""
        return cls(described(error), isinstance(error, BusyError))

    def __bool__(self) -> bool:
        return bool(self.text)

    def __str__(self) -> str:
        return self.text


def carry_out(plan: Plan, job: Job, folder: str | Path) -> Problem:
    """Carry out a run and write its file; return why it has no results."""
    path = Path(folder) / f"{job.name}.h5"
    try:
        killed = is_unfinished(path)
        if not job.anew and (killed or path.is_file()):
            analysis = AnalysisManager.resume(path, progress=False)
        else:
            if killed:
                recover(path)
            values = values_of(job.values)
            model, cases = plan.model_and_cases(values)
            manager = AnalysisManager(
                model, path, settings=plan.settings, parameters=values, study=plan.study, progress=False, effects=False
            )
            analysis = manager.run(cases, spread=plan.schedules or False)
    except Exception as error:
        return Problem.of(error)
    if any(result.status is Status.INTERRUPTED for result in analysis.values()):
        raise KeyboardInterrupt
    return Problem()


def values_of(stored: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a run as ``build`` receives them."""
    return {name: restored_value(value, name) for name, value in stored.items()}


def carry_out_sent(sent: bytes, job: Job, folder: str) -> Problem:
    """Call :func:`carry_out` in another process."""
    try:
        plan = loaded(sent)
    except Exception as error:
        return Problem.of(error)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LoadFactorWarning)  # The table lists all runs.
        return carry_out(plan, job, folder)


def carry_out_far(sent: bytes, job: Job) -> tuple[Problem, bytes]:
    """Call :func:`carry_out` on another machine.

    Return why the run failed, and the bytes of its file.
    """
    with tempfile.TemporaryDirectory(prefix="blockstruct-") as folder:
        problem = carry_out_sent(sent, job, folder)
        path = Path(folder, f"{job.name}.h5")
        return problem, path.read_bytes() if path.is_file() else b""


@lru_cache(maxsize=2)
def loaded(sent: bytes) -> Plan:
    """Return the plan that was sent, the same for many runs."""
    own_registry()  # Quantities that a function refers to need the registry of its code.
    plan: Plan = pickle.loads(sent)
    return plan


def described(error: BaseException) -> str:
    """Return kind, text and notes of an error on one line."""
    text = str(error) or "it says nothing more; memory may have run out"
    notes = [text, *getattr(error, "__notes__", ())]
    return f"{type(error).__name__}: {' '.join('; '.join(notes).split())}"
