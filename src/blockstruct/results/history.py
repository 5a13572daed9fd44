"""The history of a case: every iteration as one xarray Dataset."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import Iteration, LimitProblem, block_motion
from blockstruct.model import Model
from blockstruct.statics import Division, Statics, TieTable
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import AXES, COMPONENTS

Array = NDArray[np.float64]
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
    frame = "unit vectors n (from minus to plus), s (horizontal) and t = n × s"
    coords = {
        "component": _variable(
            "component", _text(COMPONENTS), None, "normal n, and s and t in the plane of the interface"
        ),
        "axis": _variable("axis", _text(AXES), None, "axes of the model"),
        "block": _variable("block", _text([b.name for b in model.blocks]), None, "names of the blocks"),
        "interface": _variable("interface", names, None, "names of the interfaces"),
        "block_position": _variable("block axis", np.array([b.centroid for b in model.blocks]), "length", "centroid"),
        "contact_point_position": _variable("contact_point axis", points.position, "length", "contact point"),
        "contact_point": _variable(
            "contact_point", names[points.interface], None, "name of the interface of each contact point"
        ),
        "interface_of_contact_point": _variable("contact_point", points.interface, None, "index of the interface"),
        "contact_force_unit": _variable(
            "contact_point", problem.force_unit, "force", "unit in which the forces there are solved"
        ),
        "friction_coefficient": _variable("contact_point", points.friction, "dimensionless", "friction coefficient μ"),
        "dilatancy": _variable("contact_point", problem.dilatancy, "dimensionless", "tan ψ that the case flows with"),
        "cohesion": _variable("contact_point", points.cohesion, "force", "cohesion, c times the tributary area"),
        "tensile_strength": _variable(
            "contact_point", points.tension, "force", "tensile strength, f_t times the tributary area"
        ),
        "cell_strength": _variable(
            "contact_point",
            points.compression,
            "force",
            "f_c times the area of a cell; infinite where the contact point is a corner",
        ),
        "compressive_strength": _variable("interface", points.strength, "stress", "compressive strength f_c"),
        "interface_corner_position": _variable(
            "interface_corner axis",
            np.concatenate([i.polygon for i in model.interfaces]),
            "length",
            "corner of an interface",
        ),
        "interface_of_interface_corner": _variable(
            "interface_corner", np.repeat(np.arange(len(sides)), sides), None, "index of the interface"
        ),
        "interface_area": _variable("interface", points.area, "area", "area"),
        "interface_position": _variable("interface axis", points.centroid, "length", "centroid"),
        "interface_frame": _variable("interface component axis", points.frame, "dimensionless", frame),
    }
    if len(statics.ties):
        coords |= _ties(statics.ties)
    if len(problem.torsion):
        what = "lever of the torsion of uniform pressure; infinite where contact points alone limit the torque"
        coords["torsion_lever"] = _variable("interface", points.torsion_lever, "length", what)
    return coords


def division_of(model: Model, cells: int, history: xr.Dataset) -> Division:
    """Return how the interfaces of a history are divided into cells."""
    in_cells = np.isfinite(history["cell_strength"].to_numpy())
    interface = history["interface_of_contact_point"].to_numpy()[in_cells]
    position = history["contact_point_position"].to_numpy()[in_cells]
    return Division.of_cells(model, cells, interface, position)


def iteration_variables(
    statics: Statics, problem: LimitProblem, iterations: Sequence[Iteration]
) -> dict[str, Variable]:
    """Return dimensions, values and attributes of iteration variables, SI."""
    n, K, force = len(iterations), problem.n_points, problem.force_unit

    def stacked(values: list[Any], shape: tuple[int, ...] = ()) -> Array:
        return np.array(values, dtype=float).reshape(n, *shape)

    def number(name: str, long_name: str) -> Variable:
        return _variable("iteration", stacked([getattr(i, name) for i in iterations]), "dimensionless", long_name)

    def measure(name: str, long_name: str) -> Variable:
        values = stacked([getattr(i.certificate, name) for i in iterations])
        return _variable("iteration", values, "dimensionless", long_name)

    velocity = block_motion(statics, problem, stacked([i.u for i in iterations], (problem.A.shape[0],)))
    x, v = stacked([i.x for i in iterations], (K, 3)), stacked([i.v for i in iterations], (K, 3))
    at_points, unit = "iteration contact_point component", force[:, None]
    bound, slope = (stacked([getattr(i.sliding, name) for i in iterations], (K,)) for name in ("bound", "slope"))
    condition = "of the sliding condition of the program, |(s, t)| <= b + m n"
    of_velocity = "velocity of the plus block relative to the minus block, opening positive, at 1 W"
    variables = {
        "iteration": _variable("iteration", np.arange(n), None, "iteration, from 0"),
        "stage": _variable("iteration", _text([i.stage.value for i in iterations]), None, "program of the iteration"),
        "load_factor": number("load_factor", "load factor α"),
        "contact_force": _variable(
            at_points, x * unit, "force", "contact force on the plus block, compression positive"
        ),
        "relative_velocity": _variable(at_points, v / unit, "velocity", of_velocity),
        "block_velocity": _variable(
            "iteration block axis", velocity[..., :3], "velocity", "velocity of the centroid, at 1 W"
        ),
        "block_angular_velocity": _variable(
            "iteration block axis", velocity[..., 3:], "angular velocity", "angular velocity about the centroid, at 1 W"
        ),
        **_tie_motion(problem, iterations),
        "fictitious_cohesion": _variable("iteration contact_point", bound * force, "force", f"b {condition}"),
        "fictitious_slope": _variable("iteration contact_point", slope, "dimensionless", f"m {condition}"),
        "crushing_linearisation": _variable(
            "iteration interface",
            _linearised_at(statics, problem, iterations),
            "force",
            "normal force N0 about which crushing is linearised in the program, if it is",
        ),
        "schedule_cohesion": number("c0", "c0 of the schedule, in units of contact_force_unit"),
        "schedule_slope": number("a", "a of the schedule"),
        "equilibrium_residual": measure("equilibrium_residual", "in multiples of the dead wrench of the block"),
        "yield_excess": measure(
            "yield_excess",
            "beyond the true conditions, in multiples of the dead wrench of the lighter block or of the normal force",
        ),
        "interpenetration": measure("interpenetration", "relative to the largest relative velocity"),
        "flow_rule_gap": measure("flow_rule_gap", "work by which the flow rule is missed, in units of α"),
        "flow_rule_gap_limit": measure("flow_rule_gap_limit", "flow-rule gap within the settings"),
        "displacement": _displacement(problem, iterations),
        "solver_status": _variable(
            "iteration", _text([i.solver_status.value for i in iterations]), None, "how the solver ended"
        ),
        "solver_iterations": _variable(
            "iteration",
            np.array([i.solver_iterations for i in iterations], dtype=np.int64),
            "dimensionless",
            "interior-point iterations",
        ),
        "solver_time": _variable(
            "iteration", stacked([i.solver_time for i in iterations]), "time", "time in the solver"
        ),
    }
    if problem.settlement is not None:
        what = "of the supports that give way: what joints and ties bring to them, against the motion"
        values = problem.settlement.reaction(stacked([i.load_factor for i in iterations]))
        dimension = "moment" if problem.settlement.rotates else "force"
        variables["reaction"] = _variable("iteration", values, dimension, what)
    return variables


def _ties(table: TieTable) -> dict[str, Variable]:
    """Return the coordinates on ties."""
    name = "name of the tie, with the blocks of a stretch of a bonded bar"
    bond = "largest change of the force in the block at each end; infinite at an anchor"
    return {
        "tie": _variable("tie", _text(table.name), None, name),
        "tie_of_model": _variable("tie", table.tie, None, "index of the tie in the model"),
        "tie_position": _variable("tie tie_end axis", table.position, "length", "where it ends in its blocks"),
        "tie_capacity": _variable("tie", table.capacity, "force", "largest force"),
        "tie_prestress": _variable("tie", table.prestress, "force", "least force"),
        "tie_governing": _variable("tie", _text(table.governing), None, "which limit the largest force is"),
        "tie_bond": _variable("tie tie_end", table.bond, "force", bond),
        "tie_elongation_limit": _variable("tie", table.elongation_limit, "length", "infinite if none was given"),
    }


def _tie_motion(problem: LimitProblem, iterations: Sequence[Iteration]) -> dict[str, Variable]:
    """Return forces and rates of elongation of ties; nothing without ties."""
    if not len(problem.ties):
        return {}
    unit = problem.ties.force_unit
    force, rate = (
        np.array([getattr(i, name) for i in iterations], dtype=float).reshape(len(iterations), len(unit))
        for name in ("tie_force", "elongation")
    )
    return {
        "tie_force": _variable("iteration tie", force * unit, "force", "force of the tie, tension positive"),
        "tie_elongation_rate": _variable("iteration tie", rate / unit, "velocity", "rate of elongation, at 1 W"),
    }


def _linearised_at(statics: Statics, problem: LimitProblem, iterations: Sequence[Iteration]) -> Array:
    N0 = np.full((len(iterations), len(statics.points.area)), np.nan)
    corner, tension = problem.rectangles[:, 0], problem.tension[problem.rectangles].sum(axis=1)
    for row, iteration in zip(N0, iterations, strict=True):
        if iteration.linearised_at is not None:
            row[statics.points.interface[corner]] = (iteration.linearised_at - tension) * problem.force_unit[corner]
    return N0


def _displacement(problem: LimitProblem, iterations: Sequence[Iteration]) -> Variable:
    what = "displacement of the variable load, the mean of its points in its direction, since the dead load"
    if problem.settlement is not None:
        what = "displacement of the supports that give way, since the dead load"
        what += f", at {problem.length:.6g} m from their axis" * problem.settlement.rotates
    is_length = bool(np.isfinite(problem.displacement_unit))
    values = np.array([i.displacement for i in iterations], dtype=float)
    return _variable(
        "iteration",
        values,
        "length" if is_length else "dimensionless",
        what if is_length else f"{what}; only ratios count",
    )


def _variable(dims: str, values: NDArray[Any], dimension: str | None, long_name: str) -> Variable:
    """Return a variable for xarray; names and indices have no dimension, and no units."""
    units = {} if dimension is None else {"units": SI_UNITS[dimension]}
    return tuple(dims.split()), values, {**units, "long_name": long_name}


def _text(values: Sequence[str]) -> NDArray[Any]:
    # A netCDF file returns object strings of any length. An empty array needs an explicit dtype.
    return np.array(values, dtype=object) if len(values) else np.array([], dtype="U1")
