"""The response to a record: every kept state as one xarray Dataset."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import Fall, RecordState
from blockstruct.model import Model
from blockstruct.statics import Placement
from blockstruct.text import response_sentences
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import AXES

_OF_BLOCK, _OF_CONTACT = ("time", "block", "axis"), ("contact", "axis")
#: Dimensions, dimension of the unit, and long name of every variable.
_VARIABLES: dict[str, tuple[tuple[str, ...], str | None, str]] = {
    "displacement": (_OF_BLOCK, "length", "of each centroid, relative to the ground"),
    "rotation": (_OF_BLOCK, "angle", "rotation vector of each block from where the model has it"),
    "velocity": (_OF_BLOCK, "velocity", "of the centre of mass, in the step to the state"),
    "angular_velocity": (_OF_BLOCK, "angular velocity", "in the step to the state"),
    "peak_displacement": (("time", "block"), "length", "largest displacement so far, also between states"),
    "ground_acceleration": (("time", "axis"), "acceleration", "acceleration of the ground"),
    "base_reaction": (("time", "axis"), "force", "of the supports on the structure, mean since the state before"),
    "acceleration": (("time",), "acceleration", "largest one of a centre of mass, in the step to the state"),
    "kinetic_energy": (("time",), "energy", "in the step to the state"),
    "dead_work": (("time",), "energy", "work of the dead load since the beginning"),
    "record_work": (("time",), "energy", "work of the ground acceleration on the masses since the beginning"),
    "dissipated_energy": (("time",), "energy", "work of friction and impacts since the beginning"),
    "last_step": (("time",), "time", "length of the step to the state"),
    "steps": (("time",), "dimensionless", "number of steps since the beginning"),
    "iterations": (("time",), "dimensionless", "number of linear systems since the beginning"),
    "finds_contacts": (("time",), "dimensionless", "1 if contacts are found anew from the state"),
    "minus_of_contact": (("contact",), None, "index of one of the two blocks, at each contact point with a force"),
    "plus_of_contact": (("contact",), None, "index of the other one"),
    "point_of_contact": (_OF_CONTACT, "length", "where the contact point is"),
    "force_of_contact": (_OF_CONTACT, "force", "on its plus block"),
}
_WHOLE = ("steps", "iterations", "finds_contacts", "minus_of_contact", "plus_of_contact")

Arrays = Mapping[str, NDArray[Any]]


def response_arrays(states: Sequence[RecordState]) -> dict[str, NDArray[Any]]:
    """Return the values of at least one state, an array per attribute.

    The first dimension is time. Values of contact points follow one another, state by state; ``loaded_points`` has
    their number in each state.
    """
    arrays: dict[str, NDArray[Any]] = {
        "loaded_points": np.array([len(state.force_of_contact) for state in states]),
        "time": np.array([state.time for state in states]),
        "time_step": np.array([state.time_step for state in states]),
    }
    for name, (dims, _, _) in _VARIABLES.items():
        values = [np.asarray(getattr(state, name), np.int64 if name in _WHOLE else np.float64) for state in states]
        arrays[name] = np.concatenate(values) if "contact" in dims else np.stack(values)
    return arrays


def response_of(model: Model, arrays: Arrays) -> xr.Dataset:
    """Return the response from the values of its states, in SI units.

    Returns
    -------
    xarray.Dataset
        Dimensions time (s), block, axis (x, y, z) and contact. Contact points with a force follow one another, state by
        state; ``state_of_contact`` has the index of their state. ``time_step`` is the length of the steps of the
        calculation.
    """
    n = len(arrays["time"])
    variables: dict[str, Any] = {
        name: (
            dims,
            arrays[name],
            {"units": SI_UNITS[dimension], "long_name": long_name} if dimension else {"long_name": long_name},
        )
        for name, (dims, dimension, long_name) in _VARIABLES.items()
    }
    second = {"units": SI_UNITS["time"]}
    variables["time_step"] = ((), float(arrays["time_step"][0]), second | {"long_name": "length of the steps"})
    names = np.array([b.name for b in model.blocks], dtype=object)
    coords = {
        "time": ("time", arrays["time"], second | {"long_name": "time of the record"}),
        "block": ("block", names, {"long_name": "names of the blocks"}),
        "axis": ("axis", np.array(AXES, dtype=object), {"long_name": "axes of the model"}),
        "state_of_contact": (
            "contact",
            np.repeat(np.arange(n), arrays["loaded_points"]),
            {"long_name": "state of each contact point with a force"},
        ),
    }
    return xr.Dataset(variables, coords=coords, attrs={"long_name": "response to a record"})


def arrays_of_response(response: xr.Dataset) -> dict[str, NDArray[Any]]:
    """Return the values of the states of a response: the inverse of :func:`response_of`."""
    n = response.sizes["time"]
    arrays = {name: response[name].to_numpy() for name in ("time", *_VARIABLES)}
    arrays["time_step"] = np.full(n, float(response["time_step"]))
    arrays["loaded_points"] = np.bincount(response["state_of_contact"].to_numpy(), minlength=n)
    return arrays


def beginning_of(response: xr.Dataset) -> tuple[int, RecordState]:
    """Return the last state from which a response is continued, and its index."""
    k = int(np.flatnonzero(response["finds_contacts"].to_numpy())[-1])
    of_state = response["state_of_contact"].to_numpy() == k
    values: dict[str, Any] = {"time": float(response["time"][k]), "time_step": float(response["time_step"])}
    for name, (dims, _, _) in _VARIABLES.items():
        array = response[name].to_numpy()
        values[name] = array[of_state] if "contact" in dims else array[k] if len(dims) > 1 else array[k].item()
    values["finds_contacts"] = True
    return k, RecordState(**{f.name: values[f.name] for f in fields(RecordState)})


def fallen_blocks(model: Model, response: xr.Dataset) -> list[str]:
    """Return the names of the blocks that have fallen in the last state of a response."""
    start = np.array([b.centroid for b in model.blocks])
    displacement, rotation = (response[name].isel(time=-1).to_numpy() for name in ("displacement", "rotation"))
    fallen = Fall.of(model).at(Placement.at(start + displacement, rotation))
    return [block.name for block, is_fallen in zip(model.blocks, fallen, strict=True) if is_fallen]


def response_words(model: Model, response: xr.Dataset) -> list[str]:
    """Return the sentences on a response: largest and remaining displacement, fallen blocks, steps."""
    last = response.isel(time=-1)
    at_end = np.linalg.norm(last["displacement"].to_numpy(), axis=1)
    largest, remaining = (
        (float(size.max()), str(response["block"].to_numpy()[size.argmax()]))
        for size in (last["peak_displacement"].to_numpy(), at_end)
    )
    return response_sentences(
        largest=largest,
        remaining=remaining,
        fallen=fallen_blocks(model, response),
        end=float(last["time"]),
        step=float(response["time_step"]),
        steps=int(last["steps"]),
    )
