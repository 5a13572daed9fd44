"""The capacity curve: every state of a pushover as one xarray Dataset."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import FiniteStep, zero_displacement
from blockstruct.model import Model
from blockstruct.statics import Placement
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import AXES

#: Dimension in which a value is, and what it is, of every attribute of a step.
_VALUES = {
    "load_factor": ("dimensionless", "load factor α"),
    "displacement": ("length", "displacement of the control point along its direction"),
    "position": ("length", "centroid of each block"),
    "rotation": ("angle", "rotation vector of each block from where the model has it"),
    "velocity": ("velocity", "velocity of the centroid, at 1 W"),
    "angular_velocity": ("angular velocity", "angular velocity about the centroid, at 1 W"),
    "motion_time": ("time", "for which the velocities act until the next state, if the step is not halved"),
    "dissipation": ("dimensionless", "work of friction per unit of work of the variable load"),
    "penetration": ("length", "deepest penetration of two blocks"),
    "energy_error": ("dimensionless", "work that the way from the state before misses, relative to all work so far"),
    "equilibrium_residual": ("dimensionless", "in multiples of the dead wrench of the block"),
    "yield_excess": ("dimensionless", "beyond the true conditions, in multiples of the dead wrench or normal force"),
    "interpenetration": ("dimensionless", "of the next motion, relative to its largest relative velocity"),
    "flow_rule_gap": ("dimensionless", "work by which the flow rule is missed, in units of α"),
    "holds": ("dimensionless", "1 if the certificate of the state holds"),
    "contact_points": ("dimensionless", "number of contact points"),
    "programs": ("dimensionless", "number of conic programs"),
    "solver_iterations": ("dimensionless", "interior-point iterations"),
    "solver_time": ("time", "time of the step"),
}
_WHOLE = ("holds", "contact_points", "programs", "solver_iterations")
_OF_BLOCKS = ("position", "rotation", "velocity", "angular_velocity")

Arrays = Mapping[str, NDArray[Any]]


def step_arrays(steps: Sequence[FiniteStep], n_blocks: int) -> dict[str, NDArray[Any]]:
    """Values of steps, an array each, along the steps first."""
    found: dict[str, NDArray[Any]] = {}
    for name in _VALUES:
        shape = (len(steps), n_blocks, 3) if name in _OF_BLOCKS else (len(steps),)
        kind = np.int64 if name in _WHOLE else np.float64
        found[name] = np.array([getattr(step, name) for step in steps], dtype=kind).reshape(shape)
    return found


def capacity_of(model: Model, arrays: Arrays) -> xr.Dataset:
    """Capacity curve of the values of its steps, in SI units.

    Returns
    -------
    xarray.Dataset
        Dimensions step, block and axis (x, y, z); ``displacement`` is a coordinate along ``step``. ``d0`` is the
        displacement at which the load factor is zero, NaN if the method ended before.
    """
    n = len(arrays["load_factor"])
    variables = {
        name: (
            ("step", "block", "axis") if name in _OF_BLOCKS else ("step",),
            arrays[name],
            {"units": SI_UNITS[dimension], "long_name": long_name},
        )
        for name, (dimension, long_name) in _VALUES.items()
    }
    curve = list(zip(arrays["displacement"].tolist(), arrays["load_factor"].tolist(), strict=True))
    d0 = {"units": SI_UNITS["length"], "long_name": "displacement at which the load factor is zero"}
    coords: dict[str, Any] = {
        "step": ("step", np.arange(n)),
        "displacement": variables.pop("displacement"),
        "block": ("block", np.array([b.name for b in model.blocks], dtype=object)),
        "axis": ("axis", np.array(AXES, dtype=object)),
    }
    data = {**variables, "d0": ((), zero_displacement(curve), d0)}
    return xr.Dataset(data, coords=coords, attrs={"long_name": "capacity curve"})


def steps_of(capacity: xr.Dataset) -> list[FiniteStep]:
    """The steps of a capacity curve."""
    columns = {f.name: capacity[f.name].to_numpy() for f in fields(FiniteStep)}
    steps = []
    for k in range(capacity.sizes["step"]):
        values = {name: v[k] if name in _OF_BLOCKS else v[k].item() for name, v in columns.items()}
        steps.append(FiniteStep(**{**values, "holds": bool(values["holds"])}))
    return steps


def block_rotations(capacity: xr.Dataset) -> NDArray[np.float64]:
    """Rotation matrices (step, block, 3, 3) of the blocks of a capacity curve."""
    vectors = capacity["rotation"].transpose("step", "block", "axis").to_numpy()
    flat = vectors.reshape(-1, 3)
    return Placement.at(np.zeros_like(flat), flat).rotation.reshape(*vectors.shape, 3)
