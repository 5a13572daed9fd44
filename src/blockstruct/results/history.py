"""The history of a case: every iteration as one xarray Dataset."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.arrays import Array
from blockstruct.limit import Iteration, LimitProblem
from blockstruct.limit.certificate import CERTIFICATE_MEASURES
from blockstruct.limit.motion import block_motion
from blockstruct.model import Model
from blockstruct.schema import dressed
from blockstruct.statics.contacts import Division
from blockstruct.statics.statics import Statics
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import AXES, COMPONENTS

#: Dimensions, values and attributes of a variable.
Variable = tuple[tuple[str, ...], NDArray[Any], dict[str, str]]
#: Attributes of a history.
HISTORY = {"long_name": "iteration history"}


def history_of(statics: Statics, problem: LimitProblem, iterations: Sequence[Iteration]) -> xr.Dataset:
    """Return the history of a case in SI units.

    Parameters
    ----------
    statics, problem
        The structure and the problem that was solved.
    iterations
        Iterations in order; there may be none.

    Returns
    -------
    xarray.Dataset
        Dimensions iteration, contact_point (selected by the name of its interface), component (n, s, t), interface,
        interface_corner, block and axis (x, y, z). Blocks are in the order of the model. Supports have zero velocity
        unless they move. Ties add the dimensions tie (a stretch with one force) and tie_end.
    """
    variables, coords = history_variables(statics, problem, iterations)
    return xr.Dataset(variables, coords=coords, attrs=HISTORY)


def history_variables(
    statics: Statics, problem: LimitProblem, iterations: Sequence[Iteration]
) -> tuple[dict[str, Variable], dict[str, Variable]]:
    """Return the variables of a history, and its coordinates."""
    variables = iteration_variables(statics, problem, iterations)
    coords = {name: variables.pop(name) for name in ("iteration", "stage")} | coordinates(statics, problem)
    return variables, coords


def coordinates(statics: Statics, problem: LimitProblem) -> dict[str, Variable]:
    """Return positions, frames, names and strengths of a history, which follow from the model and the case."""
    model, points = statics.model, statics.points
    names = _text([i.name for i in model.interfaces])
    sides = [len(i.polygon) for i in model.interfaces]
    values = {
        "component": _text(COMPONENTS),
        "axis": _text(AXES),
        "block": _text([b.name for b in model.blocks]),
        "interface": names,
        "block_position": np.array([b.centroid for b in model.blocks]),
        "contact_point_position": points.position,
        "contact_point": names[points.interface],
        "interface_of_contact_point": points.interface,
        "contact_force_unit": problem.force_unit,
        "friction_coefficient": points.friction,
        "dilatancy": problem.dilatancy,
        "cohesion": points.cohesion,
        "tensile_strength": points.tension,
        "cell_strength": points.compression,
        "compressive_strength": points.strength,
        "interface_corner_position": np.concatenate([i.polygon for i in model.interfaces]),
        "interface_of_interface_corner": np.repeat(np.arange(len(sides)), sides),
        "interface_area": points.area,
        "interface_position": points.centroid,
        "interface_frame": points.frame,
    }
    if len(ties := statics.ties):
        values |= {"tie": _text(ties.name), "tie_of_model": ties.tie, "tie_governing": _text(ties.governing)}
        for name in ("position", "capacity", "prestress", "bond", "elongation_limit"):
            values[f"tie_{name}"] = getattr(ties, name)
    if len(problem.torsion):
        values["torsion_lever"] = points.torsion_lever
    return dressed("history", values)


def division_of(model: Model, cells: int, history: xr.Dataset) -> Division:
    """Return how the interfaces of a history are divided into cells."""
    in_cells = np.isfinite(history["cell_strength"].to_numpy())
    interface = history["interface_of_contact_point"].to_numpy()[in_cells]
    position = history["contact_point_position"].to_numpy()[in_cells]
    return Division.of_cells(model, cells, interface, position)


def rows(history: xr.Dataset, name: str, *dims: str) -> xr.Variable:
    """Return a variable by iteration, without its slow coordinates."""
    return history[name].variable.transpose("iteration", *dims)


def forces_in(problem: LimitProblem, history: xr.Dataset) -> tuple[Array, Array]:
    """Return the forces (n, K, 3) of contacts and (n, M) of ties of a history, in the units of a problem."""
    x = rows(history, "contact_force", "contact_point", "component").to_numpy() / problem.force_unit[:, None]
    if not len(problem.ties):
        return x, np.zeros((len(x), 0))
    return x, rows(history, "tie_force", "tie").to_numpy() / problem.ties.force_unit


def motions_in(history: xr.Dataset) -> Array:
    """Return velocities of centroids and angular velocities (…, B, 6), SI, of a history or of an iteration."""
    names = ("block_velocity", "block_angular_velocity")
    return np.concatenate([history[name].variable.transpose(..., "block", "axis").to_numpy() for name in names], -1)


def iteration_variables(
    statics: Statics, problem: LimitProblem, iterations: Sequence[Iteration]
) -> dict[str, Variable]:
    """Return dimensions, values and attributes of iteration variables, SI."""
    n, K, force = len(iterations), problem.n_points, problem.force_unit

    def stacked(values: list[Any], shape: tuple[int, ...] = ()) -> Array:
        return np.array(values, dtype=float).reshape(n, *shape)

    def of(name: str, *shape: int) -> Array:
        return stacked([getattr(i, name) for i in iterations], shape)

    velocity = block_motion(statics, problem, of("u", problem.A.shape[0]))
    x, v = of("x", K, 3), of("v", K, 3)
    bound, slope = (stacked([getattr(i.sliding, name) for i in iterations], (K,)) for name in ("bound", "slope"))
    values: dict[str, Any] = {
        "iteration": np.arange(n),
        "stage": _text([i.stage.value for i in iterations]),
        "load_factor": of("load_factor"),
        "contact_force": x * force[:, None],
        "relative_velocity": v / force[:, None],
        "block_velocity": velocity[..., :3],
        "block_angular_velocity": velocity[..., 3:],
    }
    if len(problem.ties):
        unit = problem.ties.force_unit
        values["tie_force"] = of("tie_force", len(unit)) * unit
        values["tie_elongation_rate"] = of("elongation", len(unit)) / unit
    values |= {
        "fictitious_cohesion": bound * force,
        "fictitious_slope": slope,
        "crushing_linearisation": _linearised_at(statics, problem, iterations),
        "schedule_cohesion": of("c0"),
        "schedule_slope": of("a"),
    }
    for name in CERTIFICATE_MEASURES:
        if name != "holds":
            values[name] = stacked([getattr(i.certificate, name) for i in iterations])
    values |= {
        "displacement": of("displacement"),
        "solver_status": _text([i.solver_status.value for i in iterations]),
        "solver_iterations": np.array([i.solver_iterations for i in iterations], dtype=np.int64),
        "solver_time": of("solver_time"),
    }
    settlement = problem.settlement
    if settlement is not None:
        values["reaction"] = settlement.reaction(of("load_factor"))
    variables = dressed("history", values)
    is_length = bool(np.isfinite(problem.displacement_unit))
    variables["displacement"][2]["units"] = SI_UNITS["length" if is_length else "dimensionless"]
    if settlement is not None:
        variables["reaction"][2]["units"] = SI_UNITS["moment" if settlement.rotates else "force"]
        what = "displacement of the supports that give way, since the dead load"
        turns = f", at {problem.length:.6g} m from their axis" * settlement.rotates
        variables["displacement"][2]["long_name"] = what + turns
    return variables


def _linearised_at(statics: Statics, problem: LimitProblem, iterations: Sequence[Iteration]) -> Array:
    N0 = np.full((len(iterations), len(statics.points.area)), np.nan)
    corner, tension = problem.rectangles[:, 0], problem.tension[problem.rectangles].sum(axis=1)
    for row, iteration in zip(N0, iterations, strict=True):
        if iteration.linearised_at is not None:
            row[statics.points.interface[corner]] = (iteration.linearised_at - tension) * problem.force_unit[corner]
    return N0


def _text(values: Sequence[str]) -> NDArray[Any]:
    # A netCDF file returns object strings of any length. An empty array needs an explicit dtype.
    return np.array(values, dtype=object) if len(values) else np.array([], dtype="U1")
