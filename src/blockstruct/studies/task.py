"""One run of a study, wherever it is carried out."""

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
    """A run that is to be carried out.

    Attributes
    ----------
    name : str
        Of its file, without suffix.
    values : dict
        As JSON keeps them.
    anew : bool
        Whether what is there of it is put aside, instead of gone on with.
    """

    name: str
    values: dict[str, Any]
    anew: bool = False


@dataclass(frozen=True, slots=True)
class Problem:
    """Why a run has no results; false if it has.

    Attributes
    ----------
    text : str
    is_elsewhere : bool
        Whether another study is carrying the run out: it has not failed.
    """

    text: str = ""
    is_elsewhere: bool = False

    @classmethod
    def of(cls, error: BaseException) -> Self:
        """Problem of an error."""
        return cls(described(error), isinstance(error, BusyError))

    def __bool__(self) -> bool:
        return bool(self.text)

    def __str__(self) -> str:
        return self.text


def carry_out(plan: Plan, job: Job, folder: str | Path) -> Problem:
    """Carry out a run, into its file; gives why it has no results."""
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
                model, path, settings=plan.settings, parameters=values, study=plan.study, progress=False
            )
            analysis = manager.run(cases, spread=plan.schedules or False)
    except Exception as error:
        return Problem.of(error)
    if any(result.status is Status.INTERRUPTED for result in analysis.values()):
        raise KeyboardInterrupt
    return Problem()


def values_of(stored: Mapping[str, Any]) -> dict[str, Any]:
    """Values of a run as build gets them."""
    return {name: restored_value(value, name) for name, value in stored.items()}


def carry_out_sent(sent: bytes, job: Job, folder: str) -> Problem:
    """:func:`carry_out` in another process."""
    try:
        plan = loaded(sent)
    except Exception as error:
        return Problem.of(error)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LoadFactorWarning)  # The table lists all runs.
        return carry_out(plan, job, folder)


def carry_out_far(sent: bytes, job: Job) -> tuple[Problem, bytes]:
    """:func:`carry_out` on another machine: why it failed, and the bytes of the file."""
    with tempfile.TemporaryDirectory(prefix="blockstruct-") as folder:
        problem = carry_out_sent(sent, job, folder)
        path = Path(folder, f"{job.name}.h5")
        return problem, path.read_bytes() if path.is_file() else b""


@lru_cache(maxsize=2)
def loaded(sent: bytes) -> Plan:
    """The plan that was sent, which is the same for many runs."""
    own_registry()  # Quantities that a function refers to need the registry of its code.
    plan: Plan = pickle.loads(sent)
    return plan


def described(error: BaseException) -> str:
    """Kind and text of an error, with its notes, on one line."""
    text = str(error) or "it says nothing more; memory may have run out"
    notes = [text, *getattr(error, "__notes__", ())]
    return f"{type(error).__name__}: {' '.join('; '.join(notes).split())}"
