"""From the layout of an older major version to the present one, step by step."""

import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.errors import FormatError
from blockstruct.limit import FictitiousSchedule, Numerics
from blockstruct.vocabulary import Flow, Procedure, Reason, Stage, Status

#: All groups of a file, by their path.
Groups = Mapping[str, xr.Dataset]
#: Reason of a case of version 1, which kept it as a sentence, by its status.
_REASONS = {
    Status.CONVERGED: Reason.CERTIFIED,
    Status.UNSTABLE: Reason.DEAD_LOAD_NOT_CARRIED,
    Status.SELF_STRESS: Reason.DEAD_LOAD_COLLAPSES,
    Status.UNBOUNDED: Reason.NEVER_COLLAPSES,
    Status.NOT_CONVERGED: Reason.NO_CERTIFICATE,
    Status.INTERRUPTED: Reason.INTERRUPTED,
}


def _from_1(groups: Groups) -> Groups:
    """Version 2 stores how a case ended as facts, and settings in three parts."""
    new = dict(groups)
    for place, ds in groups.items():
        if (at := f"{place}/history") in groups:
            new[place], history = _case_from_1(ds, groups[at]), groups[at]
            if ds.attrs["status"] == Status.SELF_STRESS.value and history.sizes["iteration"]:
                stages = history["stage"].to_numpy().astype(object)
                stages[-1] = Stage.DEAD_LOAD_COLLAPSE.value
                new[at] = history.assign(stage=history["stage"].copy(data=stages))
    return new


def _case_from_1(case: xr.Dataset, history: xr.Dataset) -> xr.Dataset:
    attrs = {name: value for name, value in case.attrs.items() if name != "message"}
    settings, stages = json.loads(attrs["settings"]), history["stage"].to_numpy()
    status, associative = Status(attrs["status"]), attrs["flow"] == Flow.ASSOCIATIVE
    converged = status is Status.CONVERGED
    found = Procedure.ASSOCIATIVE if associative else _procedure(stages)
    attrs |= {
        "reason": _REASONS[status].value,
        "procedure": found.value if converged else "",
        "settings": json.dumps(_settings_from_1(settings)),
    }
    settled = converged and (associative or _has_settled(history, found, settings["load_factor_tolerance"]))
    new = case.assign(settled=((), int(settled), {"units": "dimensionless"}))
    new.attrs = attrs
    return new


def _procedure(stages: Any) -> Procedure:
    for stage, procedure in ((Stage.SHIFTED, Procedure.SHIFTED), (Stage.LOADING_PATH, Procedure.LOADING_PATH)):
        if (stages == stage.value).any():
            return procedure
    return Procedure.FICTITIOUS


def _has_settled(history: xr.Dataset, procedure: Procedure, tolerance: float) -> bool:
    """Whether the last two load factors of a procedure agree: version 1 has no other trace of it."""
    stage = Stage.LOADING_PATH if procedure is Procedure.LOADING_PATH else Stage.NONASSOCIATIVE
    alpha = history["load_factor"].to_numpy()
    last = alpha[(history["stage"].to_numpy() == stage.value) & np.isfinite(alpha)][-2:]
    return procedure is Procedure.SHIFTED or bool(len(last) == 2 and abs(last[1] - last[0]) <= tolerance * abs(last[1]))


def _settings_from_1(settings: dict[str, Any]) -> dict[str, Any]:
    renamed = {name.replace("cohesion", "c0"): value for name, value in settings.items()}
    parts: dict[str, dict[str, Any]] = {
        part: {name: renamed.pop(name) for name in kind.__dataclass_fields__ if name in renamed}
        for part, kind in (("schedule", FictitiousSchedule), ("numerics", Numerics))
    }
    return renamed | parts


#: What turns the groups of a file of one major version into those of the next, by (from, to).
MIGRATIONS: dict[tuple[int, int], Callable[[Groups], Groups]] = {(1, 2): _from_1}


def migrated(groups: Groups, version: int, current: int) -> Groups:
    """Return the groups of a file as the current major version has them.

    Parameters
    ----------
    groups
        As they are in the file.
    version, current
        Major version of the file, and the one that is wanted, which is not older.

    Raises
    ------
    FormatError
        If no step leads from a version to the next.
    """
    for older in range(version, current):
        step = (older, older + 1)
        if step not in MIGRATIONS:
            msg = f"format version {older}: no migration to {older + 1}; read it with an older blockstruct"
            raise FormatError(msg)
        groups = MIGRATIONS[step](groups)
    return groups
