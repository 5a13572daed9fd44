"""What a sweep varies, and the runs of a spread."""

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from blockstruct.analysis.provenance import now, solver_options, versions
from blockstruct.errors import ModelError, StorageError, shown
from blockstruct.limit import ProcedureSettings, scheduled
from blockstruct.model import JOINT_PROPERTIES, Case, Interface, JointMaterial, Model
from blockstruct.results import Analysis, CaseResult, run_name
from blockstruct.storage import save_analysis
from blockstruct.units import in_first_unit, parse
from blockstruct.vocabulary import Flow


@dataclass(frozen=True, slots=True)
class Axis:
    """Values of one joint property, as they were given.

    Attributes
    ----------
    quantity : str
    values : tuple
        Quantities; None where the property is absent.
    magnitudes, unit : list of float, str
        The same in the unit of the first of them.
    """

    quantity: str
    values: tuple[Any, ...]
    magnitudes: list[float]
    unit: str


def axes_of(quantity: str | Mapping[str, Any], values: Any) -> list[Axis]:
    """Axes of a sweep along one quantity, or along each of a mapping from quantities to values.

    Raises
    ------
    ModelError
        If joints do not have the quantity, or there is no value.
    """
    return [_axis(name, given) for name, given in _given(quantity, values).items()]


def _given(quantity: Any, values: Any) -> Mapping[Any, Any]:
    if not isinstance(quantity, Mapping):
        return {quantity: values} if isinstance(quantity, str) else {shown(quantity): values}
    if not quantity or values is not None:
        msg = 'sweep: give a quantity and its values, or a mapping such as {"friction_coefficient": [0.5, 0.6]} alone'
        raise ModelError(msg)
    return quantity


def _axis(quantity: Any, values: Any) -> Axis:
    if quantity not in JOINT_PROPERTIES:
        msg = f"sweep: joints have no {shown(quantity)}; give one of {', '.join(JOINT_PROPERTIES)}"
        raise ModelError(msg)
    if isinstance(values, str | Mapping) or not np.iterable(values):
        msg = f"sweep of {quantity}: {shown(values)} is not a list of values; give several, as in Q_([1, 2], 'MPa')"
        raise ModelError(msg)
    found = tuple(values)
    if not found:
        msg = f"sweep of {quantity}: no value; give at least one"
        raise ModelError(msg)
    return Axis(quantity, found, *in_first_unit(found, JOINT_PROPERTIES[quantity].dimension, f"sweep of {quantity}"))


def joints_at(axes: Sequence[Axis], interfaces: Sequence[Interface]) -> Iterator[list[JointMaterial]]:
    """Joint material of every interface at each point of a sweep, the last axis running fastest."""
    for values in itertools.product(*(axis.values for axis in axes)):
        changes = dict(zip((axis.quantity for axis in axes), values, strict=True))
        yield [interface.joint_material.varied(**changes) for interface in interfaces]


def points_of(axes: Sequence[Axis]) -> Iterator[dict[str, Any]]:
    """Values at each point of a sweep by their quantity, as its file keeps them."""
    for values in itertools.product(*(axis.values for axis in axes)):
        given = zip(axes, values, strict=True)
        yield {a.quantity: parse(v, a.quantity) if isinstance(v, str) else v for a, v in given}


def names_at(axes: Sequence[Axis]) -> Iterator[str]:
    """Name of a file for each point of a sweep, as ``friction_coefficient=0.6,cohesion=50-kilopascal``."""
    for magnitudes in itertools.product(*(axis.magnitudes for axis in axes)):
        parts = (
            f"{axis.quantity}={value!r}" + ("" if axis.unit == "dimensionless" else f" {axis.unit}")
            for axis, value in zip(axes, magnitudes, strict=True)
        )
        yield re.sub(r"[^\w.,=+-]+", "-", ",".join(parts))


def keep_point(
    model: Model,
    joints: Sequence[JointMaterial],
    result: CaseResult,
    path: Path,
    tags: Iterable[str],
    parameters: Mapping[str, Any],
) -> None:
    """Save the result at one point of a sweep, with the joints that the model has there.

    Raises
    ------
    StorageError
        If the path cannot be written.
    """
    interfaces = [i.with_joint_material(j) for i, j in zip(model.interfaces, joints, strict=True)]
    varied = Model(model.name, model.blocks, interfaces, detection=model.detection, ties=model.ties)
    options = solver_options([result.settings])
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        msg = f"{path.parent} is not a folder to write to ({error.strerror or error}); choose another store"
        raise StorageError(msg) from error
    results = {result.name: result}
    kept = Analysis(varied, results, now(), versions(), solver_options=options, tags=tags, parameters=parameters)
    save_analysis(kept, path)


@dataclass(frozen=True, slots=True)
class Run:
    """A case to run, with its settings.

    Attributes
    ----------
    case : Case
    settings : ProcedureSettings
    schedule, of_case : str
        The schedule of a run of a spread, and the case that it varies; empty for a case as given.
    """

    case: Case
    settings: ProcedureSettings
    schedule: str = ""
    of_case: str = ""


def runs_of(cases: Sequence[Case], settings: ProcedureSettings, schedules: Sequence[str]) -> list[Run]:
    """Return the runs of cases: as given, by the schedules of a spread, and with associative flow as its bound."""
    runs = []
    for case in cases:
        runs.append(Run(case, settings))
        if not schedules or case.flow is Flow.ASSOCIATIVE:
            continue
        for name in schedules:
            other = scheduled(settings, name)
            # The settings as given need no second run.
            if other != settings:
                runs.append(Run(case.renamed(run_name(case.name, name)), other, name, case.name))
        bound = str(Flow.ASSOCIATIVE)
        runs.append(Run(case.renamed(run_name(case.name, bound), Flow.ASSOCIATIVE), settings, bound, case.name))
    return runs
