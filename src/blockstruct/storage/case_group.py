"""The result of a case as a Dataset, and back."""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import xarray as xr

from blockstruct.errors import FormatError
from blockstruct.limit import Outcome
from blockstruct.model import Case, LimitCase, LoadPattern, Model, Point, Pushover, SettlementCase
from blockstruct.results import CERTIFICATE_MEASURES, CaseResult, LazyHistory
from blockstruct.units import SI_UNITS, to_quantity
from blockstruct.vocabulary import PathEnd, Procedure, Reason, Status

#: Numbers of an outcome that are stored where they are finite, and texts of a result where they are not empty.
_FACTS = ("peak", "carried", "load_ratio", "without_crushing")
_TEXTS = ("schedule", "of_case", "damage", "curve_ended")
#: What the attribute of a settlement holds.
_MOTION = ("supports", "direction", "about")


def group_name(name: str) -> str:
    """Group name of a case: what HDF5 cannot hold in a name is escaped, and the escape character itself."""
    escaped = name.replace("%", "%25").replace("/", "%2F")
    return escaped.replace(".", "%2E") if escaped in (".", "..") else escaped


def case_dataset(result: CaseResult, versions: Mapping[str, str]) -> xr.Dataset:
    """Scalars of a result; texts are attributes, and versions where they are not those of its analysis."""
    number = {"units": SI_UNITS["dimensionless"]}
    variables: dict[str, Any] = {
        "load_factor": ((), result.load_factor, number),
        "n_iterations": ((), result.n_iterations, number),
        "duration": ((), result.duration, {"units": SI_UNITS["time"]}),
        "settled": ((), int(result.settled), number),
    }
    outcome = result.outcome
    if outcome.drift is not None:
        variables |= {f"drift_{end}": ((), v, number) for end, v in zip(("low", "high"), outcome.drift, strict=True)}
    variables |= {name: ((), v, number) for name in _FACTS if math.isfinite(v := getattr(outcome, name))}
    if outcome.programs:
        variables["programs"] = ((), outcome.programs, number)
    if result.n_iterations:
        variables["associative_load_factor"] = ((), result.associative_load_factor, number)
    if result.certificate is not None:
        for name, value in result.certificate.measures.items():
            variables[name] = ((), int(value) if isinstance(value, bool) else value, number)
    if isinstance(result.case, SettlementCase):
        reaction = float(result.reaction.magnitude)
        variables["reaction"] = ((), reaction, {"units": SI_UNITS[result.answer.dimension]})
    attrs = {
        "name": result.name,
        "status": result.status.value,
        "reason": outcome.reason.value,
        "procedure": outcome.procedure.value if outcome.procedure else "",
        "flow": result.case.flow.value,
        "dead": result.case.dead.name,
        "variable": result.case.patterns[-1].name if isinstance(result.case, LimitCase) else "",
        "settings": json.dumps(asdict(result.settings)),
        "started_at": result.started_at,
    }
    if outcome.path_end:
        attrs["path_end"] = outcome.path_end.value
    attrs |= {name: json.dumps(v) for name in ("hung", "jammed") if (v := getattr(result, name))}
    attrs |= {name: text for name in _TEXTS if (text := getattr(result, name))}
    made_by = [dict(each) for each in result.versions]
    if result.n_iterations and made_by not in ([], [dict(versions)]):
        attrs["versions"] = json.dumps(made_by, sort_keys=True)
    if isinstance(result.case, Pushover):
        attrs["pushover"] = json.dumps(
            {name: getattr(result.case, name) for name in ("control", "control_point", "steps", "corner_rounding")}
        )
    if isinstance(result.case, SettlementCase):
        attrs["settlement"] = json.dumps({name: getattr(result.case, name) for name in _MOTION})
    return xr.Dataset(variables, attrs=attrs)


def read_result(
    ds: xr.Dataset,
    history: xr.Dataset | LazyHistory,
    model: Model,
    patterns: Mapping[str, LoadPattern],
    versions: Mapping[str, str],
    capacity: xr.Dataset | None = None,
) -> CaseResult:
    """Result of a Dataset, its history, the model, its load patterns, and its capacity curve if it has one.

    The versions are those of the file, which made what does not tell its own.
    """
    a = ds.attrs
    return CaseResult.restored(
        model=model,
        case=_case(ds.attrs, patterns),
        settings=json.loads(a["settings"]),
        outcome=_outcome(ds, model),
        certificate={name: ds[name].item() for name in CERTIFICATE_MEASURES if name in ds},
        **{name: a[name] for name in _TEXTS if name in a},
        history=history,
        started_at=a["started_at"],
        duration=float(ds["duration"]),
        capacity=capacity,
        versions=versions_of(a, versions) if int(ds["n_iterations"]) else (),
    )


def _outcome(ds: xr.Dataset, model: Model) -> Outcome:
    a, free = ds.attrs, [block.name for block in model.blocks if not block.fixed]
    facts: dict[str, Any] = {name: float(ds[name]) for name in _FACTS if name in ds}
    for name in ("hung", "jammed"):
        facts[name] = tuple(free.index(block) for block in json.loads(a.get(name, "[]")))
    return Outcome(
        Status(a["status"]),
        float(ds["load_factor"]),
        Reason(a["reason"]),
        procedure=Procedure(a["procedure"]) if a["procedure"] else None,
        settled=bool(ds["settled"]),
        drift=(float(ds["drift_low"]), float(ds["drift_high"])) if "drift_low" in ds else None,
        path_end=PathEnd(a["path_end"]) if "path_end" in a else None,
        programs=int(ds["programs"]) if "programs" in ds else 0,
        **facts,
    )


def versions_of(attrs: Mapping[str, Any], versions: Mapping[str, str]) -> tuple[Mapping[str, str], ...]:
    """Versions that made the numbers of a case, by its attributes and the versions of its file.

    Raises
    ------
    FormatError
        If they are none.
    """
    found = json.loads(attrs.get("versions", json.dumps([versions])))
    if not isinstance(found, list) or not found or not all(isinstance(each, dict) for each in found):
        msg = "attribute versions is not a JSON list of objects"
        raise FormatError(msg)
    return tuple(found)


def _case(attrs: Mapping[str, Any], patterns: Mapping[str, LoadPattern]) -> Case:
    dead, flow = patterns[attrs["dead"]], attrs["flow"]
    if "pushover" in attrs:
        own = json.loads(attrs["pushover"])
        point = None if own["control_point"] is None else Point(*map(float, own["control_point"]))
        rounding = to_quantity(own.get("corner_rounding", 0.0), "length")
        more = {"control": own["control"], "control_point": point, "steps": own["steps"], "corner_rounding": rounding}
        return Pushover(attrs["name"], dead, patterns[attrs["variable"]], flow, **more)
    if "settlement" not in attrs:
        return LimitCase(attrs["name"], dead, patterns[attrs["variable"]], flow)
    motion = json.loads(attrs["settlement"])
    about = None if motion["about"] is None else to_quantity(motion["about"], "length")
    return SettlementCase(attrs["name"], dead, motion["supports"], motion["direction"], about=about, flow=flow)
