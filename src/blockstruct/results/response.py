"""The response to a record: every kept state as one xarray Dataset."""

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import Fall, RecordState
from blockstruct.model import Model
from blockstruct.results.states import Arrays, coordinates_of, state_variables
from blockstruct.schema import dressed
from blockstruct.statics import Placement
from blockstruct.text import response_sentences


def response_of(model: Model, arrays: Arrays) -> xr.Dataset:
    """Return the response from the values of its states, in SI units.

    Parameters
    ----------
    model
    arrays
        The arrays of its states.
    """
    values: dict[str, Any] = {name: arrays[name] for name in state_variables(RecordState)}
    values |= coordinates_of(model, "time", arrays["time"], arrays) | {"time_step": arrays["time_step"][0]}
    response = xr.Dataset(dressed("response", values), attrs={"long_name": "response to a record"})
    return response.set_coords("state_of_contact")


def arrays_of_response(response: xr.Dataset) -> dict[str, NDArray[Any]]:
    """Return the values of the states of a response: the inverse of :func:`response_of`."""
    n = response.sizes["time"]
    arrays = {name: response[name].to_numpy() for name in state_variables(RecordState)}
    arrays["time_step"] = np.full(n, float(response["time_step"]))
    arrays["loaded_points"] = np.bincount(response["state_of_contact"].to_numpy(), minlength=n)
    return arrays


def beginning_of(response: xr.Dataset) -> tuple[int, RecordState]:
    """Return the last state from which a response is continued, and its index."""
    k = int(np.flatnonzero(response["finds_contacts"].to_numpy())[-1])
    of_state = response["state_of_contact"].to_numpy() == k
    values: dict[str, Any] = {}
    for name, variable in state_variables(RecordState).items():
        array = response[name].to_numpy()
        at = () if not variable.dims else of_state if "contact" in variable.dims else k
        values[name] = array[at] if len(variable.dims) > 1 or "contact" in variable.dims else array[at].item()
    return k, RecordState(**values | {"finds_contacts": True})


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
