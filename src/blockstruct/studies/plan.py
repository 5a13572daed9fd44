"""One run of a study, on any machine, and the settings that all runs share."""

import hashlib
import inspect
import json
import pickle
import tempfile
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Self

from blockstruct.analysis import AnalysisManager, recover
from blockstruct.errors import (
    BusyError,
    LoadFactorWarning,
    ModelError,
    StudyError,
    UnknownKeywordError,
    shown,
)
from blockstruct.limit.settings import ProcedureSettings, schedules_of
from blockstruct.model import Model
from blockstruct.results.analysis import plain_value, restored_value, stored_value
from blockstruct.storage import is_unfinished
from blockstruct.units import own_registry
from blockstruct.vocabulary import Status

#: Function of named parameters that returns a model and its cases.
Build = Callable[..., Any]


@dataclass(frozen=True, slots=True)
class Plan:
    """Settings that all runs of a study share.

    Attributes
    ----------
    build : callable
    settings : ProcedureSettings
    schedules : tuple of str
        Schedules of a spread.
    """

    build: Build
    settings: ProcedureSettings
    schedules: tuple[str, ...]

    @classmethod
    def of(cls, build: Build, settings: ProcedureSettings | None, spread: Any) -> "Plan":
        """Return the plan of a study.

        Raises
        ------
        ModelError
            If ``build`` is not callable, the settings have another type, or a schedule is unknown.
        """
        if not callable(build):
            msg = f"study: build is {shown(build)}; give a function of the parameters that returns a model and cases"
            raise ModelError(msg)
        if not isinstance(settings, ProcedureSettings | None):
            msg = f"study: settings are {shown(settings)}; give ProcedureSettings(…)"
            raise ModelError(msg)
        return cls(build, settings or ProcedureSettings(), schedules_of(spread))

    @property
    def study(self) -> str:
        """Name of the study in its files."""
        return f"build {name_of(self.build)}"

    def model_and_cases(self, values: Mapping[str, Any]) -> tuple[Model, list[Any]]:
        """Return the model and cases that ``build`` returns for values.

        Raises
        ------
        ModelError
            If the returned values are not a model and its cases.
        """
        built = self.build(**values)
        if not isinstance(built, tuple) or len(built) != 2 or not isinstance(built[0], Model):
            msg = f"build {name_of(self.build)}: returned {shown(built)}; return a Model and its cases, model, cases"
            raise ModelError(msg)
        model, cases = built
        return model, list(cases) if isinstance(cases, list | tuple) else [cases]

    def check_names(self, names: Mapping[str, Any]) -> None:
        """Refuse unknown and missing parameters of ``build``.

        Raises
        ------
        UnknownKeywordError
        """
        signature = inspect.signature(self.build)
        try:
            signature.bind(**names)
        except TypeError as error:
            taken = ", ".join(signature.parameters) or "no parameters"
            msg = f"build {name_of(self.build)}: {error}; it takes {taken}, and the study gives {', '.join(names)}"
            raise UnknownKeywordError(msg) from error

    def pickled(self) -> bytes:
        """Return the plan as bytes, with functions of a script, a notebook or a prompt.

        Raises
        ------
        StudyError
            If ``build`` cannot be sent.
        """
        import cloudpickle

        try:
            sent: bytes = cloudpickle.dumps(self)
        except Exception as error:
            msg = (
                f"study: build {name_of(self.build)} cannot be sent to another process ({type(error).__name__}: "
                f"{error}); give it only what can be pickled, or workers=1"
            )
            raise StudyError(msg) from error
        return sent


def name_of(build: Build) -> str:
    """Return a readable name of a build function."""
    inner = build.func if isinstance(build, partial) else build
    return str(getattr(inner, "__qualname__", type(inner).__qualname__))


@dataclass(frozen=True, slots=True)
class Run:
    """One run of a study, which can be sent to other processes.

    Attributes
    ----------
    name : str
        Name of its file without suffix. It depends on the values alone.
    stored : dict
        Values by parameter as JSON stores them. Quantities belong to one process and cannot be sent.
    anew : bool
        Whether to put existing data aside instead of continuing them.
    """

    name: str
    stored: dict[str, Any]
    anew: bool = False

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Return the run of values.

        The name uses coherent SI units: 4 MPa and 4000 kPa give the same name.
        """
        plain = {name: plain_value(value) for name, value in values.items()}
        digest = hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()
        return cls(f"run-{digest[:12]}", {name: stored_value(value) for name, value in values.items()})

    @property
    def values(self) -> dict[str, Any]:
        """Values as ``build`` receives them."""
        return {name: restored_value(value, name) for name, value in self.stored.items()}


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


def carry_out(plan: Plan, run: Run, folder: str | Path) -> Problem:
    """Carry out a run and write its file; return why it has no results."""
    path = Path(folder) / f"{run.name}.h5"
    try:
        killed = is_unfinished(path)
        if not run.anew and (killed or path.is_file()):
            analysis = AnalysisManager.resume(path, progress=False)
        else:
            if killed:
                recover(path)
            values = run.values
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


def carry_out_sent(sent: bytes, run: Run, folder: str) -> Problem:
    """Call :func:`carry_out` in another process."""
    try:
        plan = loaded(sent)
    except Exception as error:
        return Problem.of(error)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LoadFactorWarning)  # The table lists all runs.
        return carry_out(plan, run, folder)


def carry_out_far(sent: bytes, run: Run) -> tuple[Problem, bytes]:
    """Call :func:`carry_out` on another machine.

    Return why the run failed, and the bytes of its file.
    """
    with tempfile.TemporaryDirectory(prefix="blockstruct-") as folder:
        problem = carry_out_sent(sent, run, folder)
        path = Path(folder, f"{run.name}.h5")
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
