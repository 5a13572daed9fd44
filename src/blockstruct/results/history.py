"""The history of a case: every iteration as one xarray Dataset."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.limit import Iteration, LimitProblem, Settlement, block_motion
from blockstruct.model import Model
from blockstruct.statics import Division, Statics, TieTable
from blockstruct.units import SI_UNITS
from blockstruct.vocabulary import AXES, COMPONENTS

Array = NDArray[np.float64]


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
    model, points, force = statics.model, statics.points, problem.force_unit
    of_iterations = iteration_variables(statics, problem, iterations)
    names = _text([i.name for i in model.interfaces])
    coords = {
        **{name: of_iterations.pop(name) for name in ("iteration", "stage")},
        "component": ("component", _text(COMPONENTS), _named("normal n, and s and t in the plane of the interface")),
        "axis": ("axis", _text(AXES), _named("axes of the model")),
        "block": ("block", _text([b.name for b in model.blocks]), _named("names of the blocks")),
        "interface": ("interface", names, _named("names of the interfaces")),
        "block_position": (
            ("block", "axis"),
            np.array([b.centroid for b in model.blocks]),
            _attrs("length", "centroid"),
        ),
        "contact_point_position": (("contact_point", "axis"), points.position, _attrs("length", "contact point")),
        "contact_point": (
            "contact_point",
            names[points.interface],
            _named("name of the interface of each contact point"),
        ),
        "interface_of_contact_point": ("contact_point", points.interface, _named("index of the interface")),
        "contact_force_unit": (
            "contact_point",
            force,
            _attrs("force", "unit in which the forces there are solved"),
        ),
        "friction_coefficient": (
            "contact_point",
            points.friction,
            _attrs("dimensionless", "friction coefficient μ"),
        ),
        "dilatancy": ("contact_point", problem.dilatancy, _attrs("dimensionless", "tan ψ that the case flows with")),
        "cohesion": ("contact_point", points.cohesion, _attrs("force", "cohesion, c times the tributary area")),
        "tensile_strength": (
            "contact_point",
            points.tension,
            _attrs("force", "tensile strength, f_t times the tributary area"),
        ),
        "cell_strength": (
            "contact_point",
            points.compression,
            _attrs("force", "f_c times the area of a cell; infinite where the contact point is a corner"),
        ),
        "compressive_strength": ("interface", points.strength, _attrs("stress", "compressive strength f_c")),
        "interface_corner_position": (
            ("interface_corner", "axis"),
            np.concatenate([i.polygon for i in model.interfaces]),
            _attrs("length", "corner of an interface"),
        ),
        "interface_of_interface_corner": (
            "interface_corner",
            np.repeat(np.arange(len(model.interfaces)), [len(i.polygon) for i in model.interfaces]),
            _named("index of the interface"),
        ),
        "interface_area": ("interface", points.area, _attrs("area", "area")),
        "interface_position": (("interface", "axis"), points.centroid, _attrs("length", "centroid")),
        "interface_frame": (
            ("interface", "component", "axis"),
            points.frame,
            _attrs("dimensionless", "unit vectors n (from minus to plus), s (horizontal) and t = n × s"),
        ),
    }
    if len(statics.ties):
        coords |= _ties(statics.ties)
    if len(problem.torsion):
        what = "lever of the torsion of uniform pressure; infinite where contact points alone limit the torque"
        coords["torsion_lever"] = ("interface", points.torsion_lever, _attrs("length", what))
    return xr.Dataset(of_iterations, coords=coords, attrs={"long_name": "iteration history"})


def division_of(model: Model, cells: int, history: xr.Dataset) -> Division:
    """Return how the interfaces of a history are divided into cells."""
    in_cells = np.isfinite(history["cell_strength"].to_numpy())
    interface = history["interface_of_contact_point"].to_numpy()[in_cells]
    position = history["contact_point_position"].to_numpy()[in_cells]
    return Division.of_cells(model, cells, interface, position)


def iteration_variables(
    statics: Statics, problem: LimitProblem, iterations: Sequence[Iteration]
) -> dict[str, tuple[Any, NDArray[Any], dict[str, str]]]:
    """Return dimensions, values and attributes of iteration variables, SI."""
    force = problem.force_unit
    n, K = len(iterations), problem.n_points

    def stacked(values: list[Any], shape: tuple[int, ...] = ()) -> Array:
        return np.array(values, dtype=float).reshape(n, *shape)

    velocity = block_motion(statics, problem, stacked([i.u for i in iterations], (problem.A.shape[0],)))
    per_point = ("iteration", "contact_point")
    of_ties: dict[str, Any] = {}
    if len(problem.ties):
        per_tie, unit = ("iteration", "tie"), problem.ties.force_unit
        of_ties["tie_force"] = (
            per_tie,
            stacked([i.tie_force for i in iterations], (len(unit),)) * unit,
            _attrs("force", "force of the tie, tension positive"),
        )
        of_ties["tie_elongation_rate"] = (
            per_tie,
            stacked([i.elongation for i in iterations], (len(unit),)) / unit,
            _attrs("velocity", "rate of elongation, at 1 W"),
        )
    found = {
        "iteration": ("iteration", np.arange(n), _named("iteration, from 0")),
        "stage": ("iteration", _text([i.stage.value for i in iterations]), _named("program of the iteration")),
        "load_factor": _number([i.load_factor for i in iterations], "load factor α"),
        "contact_force": (
            (*per_point, "component"),
            stacked([i.x for i in iterations], (K, 3)) * force[:, None],
            _attrs("force", "contact force on the plus block, compression positive"),
        ),
        "relative_velocity": (
            (*per_point, "component"),
            stacked([i.v for i in iterations], (K, 3)) / force[:, None],
            _attrs("velocity", "velocity of the plus block relative to the minus block, opening positive, at 1 W"),
        ),
        "block_velocity": (
            ("iteration", "block", "axis"),
            velocity[..., :3],
            _attrs("velocity", "velocity of the centroid, at 1 W"),
        ),
        "block_angular_velocity": (
            ("iteration", "block", "axis"),
            velocity[..., 3:],
            _attrs("angular velocity", "angular velocity about the centroid, at 1 W"),
        ),
        **of_ties,
        "fictitious_cohesion": (
            per_point,
            stacked([i.sliding.bound for i in iterations], (K,)) * force,
            _attrs("force", "b of the sliding condition of the program, |(s, t)| <= b + m n"),
        ),
        "fictitious_slope": (
            per_point,
            stacked([i.sliding.slope for i in iterations], (K,)),
            _attrs("dimensionless", "m of the sliding condition of the program, |(s, t)| <= b + m n"),
        ),
        "crushing_linearisation": (
            ("iteration", "interface"),
            _linearised_at(statics, problem, iterations),
            _attrs("force", "normal force N0 about which crushing is linearised in the program, if it is"),
        ),
        "schedule_cohesion": _number([i.c0 for i in iterations], "c0 of the schedule, in units of contact_force_unit"),
        "schedule_slope": _number([i.a for i in iterations], "a of the schedule"),
        "equilibrium_residual": _number(
            [i.certificate.equilibrium_residual for i in iterations], "in multiples of the dead wrench of the block"
        ),
        "yield_excess": _number(
            [i.certificate.yield_excess for i in iterations],
            "beyond the true conditions, in multiples of the dead wrench of the lighter block or of the normal force",
        ),
        "interpenetration": _number(
            [i.certificate.interpenetration for i in iterations], "relative to the largest relative velocity"
        ),
        "flow_rule_gap": _number(
            [i.certificate.flow_rule_gap for i in iterations],
            "work by which the flow rule is missed, in units of α",
        ),
        "flow_rule_gap_limit": _number(
            [i.certificate.flow_rule_gap_limit for i in iterations], "flow-rule gap within the settings"
        ),
        "displacement": _displacement(problem, iterations),
        "solver_status": (
            "iteration",
            _text([i.solver_status.value for i in iterations]),
            _named("how the solver ended"),
        ),
        "solver_iterations": (
            "iteration",
            np.array([i.solver_iterations for i in iterations], dtype=np.int64),
            _attrs("dimensionless", "interior-point iterations"),
        ),
        "solver_time": (
            "iteration",
            stacked([i.solver_time for i in iterations]),
            _attrs("time", "time in the solver"),
        ),
    }
    if problem.settlement is not None:
        found["reaction"] = _reaction(problem.settlement, iterations)
    return found


def _ties(table: TieTable) -> dict[str, Any]:
    """Return the coordinates on ties."""
    return {
        "tie": (
            "tie",
            _text(table.name),
            _named("name of the tie, with the blocks of a stretch of a bonded bar"),
        ),
        "tie_of_model": ("tie", table.tie, _named("index of the tie in the model")),
        "tie_position": (("tie", "tie_end", "axis"), table.position, _attrs("length", "where it ends in its blocks")),
        "tie_capacity": ("tie", table.capacity, _attrs("force", "largest force")),
        "tie_prestress": ("tie", table.prestress, _attrs("force", "least force")),
        "tie_governing": ("tie", _text(table.governing), _named("which limit the largest force is")),
        "tie_bond": (
            ("tie", "tie_end"),
            table.bond,
            _attrs("force", "largest change of the force in the block at each end; infinite at an anchor"),
        ),
        "tie_elongation_limit": ("tie", table.elongation_limit, _attrs("length", "infinite if none was given")),
    }


def _linearised_at(statics: Statics, problem: LimitProblem, iterations: Sequence[Iteration]) -> Array:
    N0 = np.full((len(iterations), len(statics.points.area)), np.nan)
    corner, tension = problem.rectangles[:, 0], problem.tension[problem.rectangles].sum(axis=1)
    for row, iteration in zip(N0, iterations, strict=True):
        if iteration.linearised_at is not None:
            row[statics.points.interface[corner]] = (iteration.linearised_at - tension) * problem.force_unit[corner]
    return N0


def _reaction(settlement: Settlement, iterations: Sequence[Iteration]) -> tuple[str, Array, dict[str, str]]:
    what = "of the supports that give way: what joints and ties bring to them, against the motion"
    values = settlement.reaction(np.array([i.load_factor for i in iterations], dtype=float))
    return "iteration", values, _attrs("moment" if settlement.rotates else "force", what)


def _displacement(problem: LimitProblem, iterations: Sequence[Iteration]) -> tuple[str, Array, dict[str, str]]:
    given = np.isfinite(problem.displacement_unit)
    what = "displacement of the variable load, the mean of its points in its direction, since the dead load"
    if problem.settlement is not None:
        what = "displacement of the supports that give way, since the dead load"
        what += f", at {problem.length:.6g} m from their axis" * problem.settlement.rotates
    attrs = _attrs("length", what) if given else _attrs("dimensionless", f"{what}; only ratios count")
    return "iteration", np.array([i.displacement for i in iterations], dtype=float), attrs


def _attrs(dimension: str, long_name: str) -> dict[str, str]:
    return {"units": SI_UNITS[dimension], "long_name": long_name}


def _named(long_name: str) -> dict[str, str]:
    return {"long_name": long_name}


def _number(values: list[float], long_name: str) -> tuple[str, Array, dict[str, str]]:
    return "iteration", np.array(values, dtype=float), _attrs("dimensionless", long_name)


def _text(values: Sequence[str]) -> NDArray[Any]:
    # A netCDF file returns object strings of any length. An empty array needs an explicit dtype.
    return np.array(values, dtype=object) if len(values) else np.array([], dtype="U1")
