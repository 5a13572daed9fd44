"""Capacity curves and responses to records: every state of blocks in motion as one xarray Dataset."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.arrays import MOSTLY, Array, Flags
from blockstruct.limit.response import Fall, RecordState
from blockstruct.limit.settlement import reaction_unit
from blockstruct.model import Case, Model, SettlementCase, tie_segments
from blockstruct.motion.state import MotionState, largest_displacement
from blockstruct.results.ties import break_points
from blockstruct.schema import Stated, dressed, stated
from blockstruct.statics.moved import Placement
from blockstruct.text.case import DoubtfulPart, response_sentences
from blockstruct.text.note import EFFECT
from blockstruct.vocabulary import AXES, CurveDoubt

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


#: Rise of the load factor above its first value, or way back of the control point relative to its way, and jump of the
#: load factor between two states, relative to the first value, from which a caution is given.
RISES, JUMPS = 0.02, 0.03
#: Work of friction and ties, relative to the work of the push at the first state, below which blocks do not slide.
SLIDES = 0.1
#: Values of a curve without joints that crush, where they are not those of its cells.
_WITHOUT_CELLS = {"cell_of_contact": -1, "largest_crushed_depth": 0.0}


def capacity_of(model: Model, case: Case, arrays: Arrays) -> xr.Dataset:
    """Return the capacity curve of the values of its steps, in SI units.

    Parameters
    ----------
    model, case, arrays
        The structure, its case, and the arrays of its states.

    Returns
    -------
    xarray.Dataset
        Dimensions step, block, axis (x, y, z), contact and, with ties, tie; ``displacement`` is a coordinate along
        ``step``. Contact points with a force follow one another, step by step; ``step_of_contact`` is their step.
        ``d0`` is the displacement at which the load factor is zero, NaN if the method ended before; of a settlement,
        the largest displacement of the supports before blocks fall, NaN if none fall. A settlement has ``reaction``;
        ``tie_break_displacement`` that at which each tie breaks, NaN where it does not.
    """
    values = _values_of(MotionState, model, arrays)
    values |= coordinates_of(model, "step", np.arange(len(arrays["load_factor"])), arrays)
    if isinstance(case, SettlementCase):
        values["reaction"] = -reaction_unit(model, case) * arrays["load_factor"] + 0.0
    along = (arrays[name] for name in ("displacement", "load_factor", "falls"))
    values["d0"] = largest_displacement(case, *along)
    if model.ties:
        limit = values["tie_elongation_limit"]
        values["tie_break_displacement"] = break_points(arrays["displacement"], arrays["tie_elongation"], limit)
    curve = xr.Dataset(dressed("capacity", values), attrs={"long_name": "capacity curve"})
    return curve.set_coords([n for n in ("displacement", "step_of_contact", "tie_elongation_limit") if n in values])


def _values_of(kind: type[MotionState | RecordState], model: Model, arrays: Arrays) -> dict[str, Any]:
    """Return the values of states, with the names and elongation limits of ties.

    A model without ties has no tie variables, and one without joints that crush no variables of cells.
    """
    lacks = {dim for dim, there in (("tie", model.ties), ("cell", arrays["crushed_depth"].size)) if not there}
    lacks |= _WITHOUT_CELLS.keys() if "cell" in lacks else set[str]()
    values: dict[str, Any] = {n: arrays[n] for n, v in state_variables(kind).items() if not lacks & {n, *v.dims}}
    if model.ties:
        segments = tie_segments(model.ties, model.blocks)
        values["tie"] = np.array([segment.name for segment in segments], dtype=object)
        values["tie_elongation_limit"] = np.array([segment.elongation_limit for segment in segments])
    return values


def doubtful_parts(capacity: xr.Dataset, procedure: str, collapse: float = np.nan) -> list[DoubtfulPart]:
    """Return the parts of a capacity curve that may depend on its steps or its control point.

    They are beginnings above the load factor ``collapse`` of the collapse state, rises, ways back, jumps, sudden
    rocking, missed work, and states without falls whose certificates do not hold.

    A jump, over one step or two, continues neither the curve before nor the curve after it; a kink is no jump. Jumps
    from the break of a tie are reported with the tie. Jumps from a tie that becomes tight or slack appear in its
    forces. ``procedure`` is the procedure of the settings.
    """
    is_reaction = "reaction" in capacity
    # A reaction changes as the supports move, and a fall ends the curve.
    curve = capacity.isel(step=capacity["falls"].to_numpy() == 0) if is_reaction else capacity
    d, alpha, missed = (curve[name].to_numpy() for name in ("displacement", "load_factor", "energy_error"))
    doubts = [] if is_reaction or len(d) < 3 or not alpha[0] else _changes(curve)
    worst = int(missed.argmax())
    if missed[worst] > EFFECT:
        doubts.append((CurveDoubt.MISSES_WORK, max(worst - 1, 0), worst))
    uncertified = np.flatnonzero((curve["holds"].to_numpy() == 0) & (curve["falls"].to_numpy() == 0))
    if len(uncertified):
        doubts.append((CurveDoubt.NOT_CERTIFIED, int(uncertified[0]), int(uncertified[-1])))
    parts = [
        DoubtfulPart(
            doubt,
            (float(d[first]), float(d[last])),
            (float(alpha[first]), float(alpha[last])),
            float(missed[last]),
            procedure,
            has_ties="tie_force" in curve,
        )
        for doubt, first, last in doubts
    ]
    if not is_reaction and alpha[0] - collapse > RISES * abs(collapse):
        begun = DoubtfulPart(
            CurveDoubt.BEGINS_ABOVE, (float(d[0]),) * 2, (collapse, float(alpha[0])), 0.0, procedure, has_ties=False
        )
        parts.insert(0, begun)
    return parts


def _changes(curve: xr.Dataset) -> list[tuple[CurveDoubt, int, int]]:
    """Return the doubts on the load factors of a curve, each with its first and last state."""
    d, alpha, friction = (curve[name].to_numpy() for name in ("displacement", "load_factor", "dissipation"))
    top = int(alpha.argmax())
    doubts = [(CurveDoubt.RISES, 0, top)] if alpha[top] - alpha[0] > RISES * abs(alpha[0]) else []
    furthest = int(np.abs(d).argmax())
    if abs(d[furthest]) - abs(d[-1]) > RISES * abs(d[furthest]):
        doubts.append((CurveDoubt.GOES_BACK, furthest, len(d) - 1))
    way = np.concatenate([[0.0], np.abs(np.diff(d)).cumsum()])
    of_ties = _of_ties(curve)
    # Rounding may put a state in the middle of a jump.
    for steps in (1, 2):
        beyond = _beyond(way, alpha, of_ties, steps)
        jump = int(beyond.argmax())
        if beyond[jump] > JUMPS * abs(alpha[0]):
            # Ties that yield count as friction.
            slides = friction[jump : jump + steps + 1].max() > SLIDES * abs(alpha[0])
            return [*doubts, (CurveDoubt.SLIPS if slides else CurveDoubt.LEAPS, jump, jump + steps)]
    # Blocks mostly slide, and then no longer do. The branch after a change from sliding to rocking may be wrong by as
    # much as the length of the step.
    ends = (friction[:-2] > MOSTLY * np.abs(alpha[:-2])) & (friction[1:-1] <= MOSTLY * friction[:-2])
    length = np.diff(way)
    shifted = length[:-1] * np.abs(np.diff(alpha)[1:]) / np.maximum(length[1:], 1e-300)
    long = np.flatnonzero(ends & ~of_ties[:-1] & (shifted > EFFECT * abs(alpha[0])))
    if len(long):
        k = int(long[shifted[long].argmax()])
        rocks = friction[k + 1] <= SLIDES * abs(alpha[0])
        doubts.append((CurveDoubt.ROCKS if rocks else CurveDoubt.ROCKS_AND_SLIDES, k, k + 1))
    return doubts


def _beyond(way: Array, alpha: Array, of_ties: Flags, steps: int) -> Array:
    """Return the deviation of a curve (n,) from both sides of each jump.

    The deviation over ``steps`` steps has shape (n − steps,). It is the smaller distance from the extrapolated curves
    before and after the jump. It is zero if ties cause the jump, or if the curve is unknown on both sides. Over more
    than one step both sides must be known. There, a curve above both extrapolations or below both is a bend, not a
    jump.
    """
    begin, end, at_begin, at_end = way[:-steps], way[steps:], alpha[:-steps], alpha[steps:]
    # Extrapolate over an equal length. The curve is unknown beyond its ends and across sudden changes of ties.
    at = 2 * begin - end, 2 * end - begin
    before, behind = (np.interp(x, way, alpha, np.nan, np.nan) for x in at)
    so_far = np.concatenate([[0], of_ties.cumsum()])
    first, last = way.searchsorted(at[0], "right") - 1, np.minimum(way.searchsorted(at[1]), len(way) - 1)
    before[so_far[:-steps] > so_far[first]] = np.nan
    behind[so_far[last] > so_far[steps:]] = np.nan
    leaves, comes = at_end - 2 * at_begin + before, 2 * at_end - at_begin - behind
    beyond = np.fmin(np.abs(leaves), np.abs(comes))
    counts = so_far[:-steps] == so_far[steps:]
    if steps > 1:
        counts &= leaves * comes > 0
    return np.where(counts, np.nan_to_num(beyond), 0.0)


def _of_ties(capacity: xr.Dataset) -> Flags:
    """Return the steps (n − 1,) with a sudden change of a tie.

    A tie breaks, or suddenly becomes tight or slack.
    """
    d = capacity["displacement"].to_numpy()
    sudden = np.zeros(len(d) - 1, dtype=bool)
    if "tie_break_displacement" in capacity:
        broke = capacity["tie_break_displacement"].to_numpy()[:, None]
        sudden |= ((broke >= np.minimum(d[:-1], d[1:])) & (broke <= np.maximum(d[:-1], d[1:]))).any(axis=0)
    if "tie_force" in capacity:
        force = np.nan_to_num(capacity["tie_force"].transpose("step", "tie").to_numpy())
        sudden |= (np.abs(np.diff(force, axis=0)) > MOSTLY * force.max(axis=0)).any(axis=1)
    return sudden


def _arrays_of(kind: type[MotionState | RecordState], motion: xr.Dataset) -> dict[str, NDArray[Any]]:
    """Return the values of the states of a curve or a response, as of :func:`state_arrays`.

    Variables that it lacks are empty without ties or cells, or what they are without joints that crush.
    """
    dim, of_contact = ("step", "step_of_contact") if kind is MotionState else ("time", "state_of_contact")
    arrays = {"loaded_points": np.bincount(motion[of_contact].to_numpy(), minlength=motion.sizes[dim])}
    for name, variable in state_variables(kind).items():
        shape = (*(motion.sizes[d] for d in variable.dims[:1]), 0, len(AXES))[: len(variable.dims)]
        lacking = np.full(shape, _WITHOUT_CELLS.get(name, np.nan))
        arrays[name] = motion[name].to_numpy() if name in motion else lacking
    return arrays


def _state_of(kind: Any, arrays: Arrays, k: int) -> Any:
    """Return a state of the arrays of several."""
    end, values = int(arrays["loaded_points"][: k + 1].sum()), {}
    variables, points = state_variables(kind), slice(end - int(arrays["loaded_points"][k]), end)
    for field in fields(kind):
        part: Any = arrays[field.name][points if "contact" in variables[field.name].dims else k]
        plain: Any = field.type
        values[field.name] = part if part.ndim else plain(part)
    return kind(**values)


def steps_of(capacity: xr.Dataset) -> list[MotionState]:
    """Return the states of a capacity curve."""
    arrays = _arrays_of(MotionState, capacity)
    return [_state_of(MotionState, arrays, k) for k in range(capacity.sizes["step"])]


def block_rotations(capacity: xr.Dataset) -> Array:
    """Return rotation matrices (step, block, 3, 3) of a capacity curve, or (time, block, 3, 3) of a response."""
    vectors = capacity["rotation"].transpose(..., "block", "axis").to_numpy()
    flat = vectors.reshape(-1, 3)
    return Placement.at(np.zeros_like(flat), flat).rotation.reshape(*vectors.shape, 3)


def response_of(model: Model, arrays: Arrays) -> xr.Dataset:
    """Return the response from the values of its states, in SI units.

    Parameters
    ----------
    model
    arrays
        The arrays of its states.
    """
    values = _values_of(RecordState, model, arrays)
    values |= coordinates_of(model, "time", arrays["time"], arrays) | {"time_step": arrays["time_step"][0]}
    if model.ties:
        elongation, limit = arrays["peak_tie_elongation"], values["tie_elongation_limit"]
        values["tie_break_time"] = break_points(arrays["time"], elongation, limit)
    response = xr.Dataset(dressed("response", values), attrs={"long_name": "response to a record"})
    return response.set_coords([n for n in ("state_of_contact", "tie_elongation_limit") if n in values])


def arrays_of_response(response: xr.Dataset) -> dict[str, NDArray[Any]]:
    """Return the values of the states of a response: the inverse of :func:`response_of`."""
    arrays = _arrays_of(RecordState, response)
    return arrays | {"time_step": np.full(response.sizes["time"], arrays["time_step"])}


def beginning_of(response: xr.Dataset) -> tuple[int, RecordState]:
    """Return the last state from which a response is continued, and its index."""
    k = int(np.flatnonzero(response["finds_contacts"].to_numpy())[-1])
    return k, _state_of(RecordState, arrays_of_response(response), k)


def fallen_blocks(model: Model, response: xr.Dataset) -> list[str]:
    """Return the names of the blocks that have fallen in the last state of a response."""
    start = np.array([b.centroid for b in model.blocks])
    displacement, rotation = (response[name].isel(time=-1).to_numpy() for name in ("displacement", "rotation"))
    fallen = Fall.of(model).at(Placement.at(start + displacement, rotation))
    return [block.name for block, is_fallen in zip(model.blocks, fallen, strict=True) if is_fallen]


def response_words(model: Model, response: xr.Dataset) -> list[str]:
    """Return the sentences on a response: largest and remaining displacement, fallen blocks, ties, steps."""
    return response_sentences(response, fallen_blocks(model, response))
