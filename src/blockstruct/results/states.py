"""States of blocks in motion as arrays, by the names that the schema gives their variables."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstruct.limit import RecordState
from blockstruct.model import Model
from blockstruct.motion import MotionState
from blockstruct.schema import Stated, stated
from blockstruct.vocabulary import AXES

Arrays = Mapping[str, NDArray[Any]]


def state_variables(kind: type[MotionState | RecordState]) -> dict[str, Stated]:
    """Return the variables of a curve or of a response that are attributes of a state, by name."""
    names, part = {f.name for f in fields(kind)}, "capacity" if kind is MotionState else "response"
    return {name: variable for name, variable in stated(part).items() if name in names}


def state_arrays(states: Sequence[MotionState] | Sequence[RecordState]) -> dict[str, NDArray[Any]]:
    """Return an array of each attribute of one or more states.

    The contact points of all states stand one after the other, with their numbers in ``loaded_points``.
    """
    arrays = {"loaded_points": np.array([len(state.force_of_contact) for state in states])}
    for name, variable in state_variables(type(states[0])).items():
        kind = np.float64 if variable.kind == "f" else np.int64
        values = [np.asarray(getattr(state, name), dtype=kind) for state in states]
        arrays[name] = np.concatenate(values) if "contact" in variable.dims else np.stack(values)
    return arrays


def coordinates_of(model: Model, dim: str, values: NDArray[Any], arrays: Arrays) -> dict[str, NDArray[Any]]:
    """Return the names of blocks and axes, the states along their dimension, and the state of each contact point."""
    of_contact = "step_of_contact" if dim == "step" else "state_of_contact"
    return {
        dim: values,
        "block": np.array([b.name for b in model.blocks], dtype=object),
        "axis": np.array(AXES, dtype=object),
        of_contact: np.repeat(np.arange(len(values)), arrays["loaded_points"]),
    }
