"""What a schema cannot say of the groups of a file: index ranges, sizes across groups, contradictions."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from blockstruct.geometry import unsupported
from blockstruct.model import Model
from blockstruct.results import CaseResult
from blockstruct.storage.case_group import group_name
from blockstruct.vocabulary import AXES, COMPONENTS, SolverStatus, Stage, Status

#: Relative difference of reactions, and of sizes of the model, that rounding makes.
_SAME = 1e-9
#: Rounding of a length, relative to the coordinates that it is of.
_ROUNDING = 1e-12
#: A place in a file and what is wrong there.
Finding = tuple[str, str]

#: Index variables and the dimension each must stay within; −1 means none where it is allowed.
_INDICES = {
    "material_of_block": ("material", 0),
    "block_of_vertex": ("block", 0),
    "block_of_face": ("block", 0),
    "face_of_face_corner": ("face", 0),
    "vertex_of_face_corner": ("vertex", 0),
    "minus_block": ("block", 0),
    "plus_block": ("block", 0),
    "joint_material_of_interface": ("joint_material", 0),
    "interface_of_contact_point": ("interface", 0),
    "interface_of_interface_corner": ("interface", 0),
    "pattern_of_load": ("load_pattern", 0),
    "block_of_load": ("block", -1),
    "block_of_tie": ("block", -1),
    "tie_of_model": ("tie", 0),
    "step_of_contact": ("step", 0),
    "minus_of_contact": ("block", 0),
    "plus_of_contact": ("block", 0),
    "interface_of_contact": ("interface", -1),
    "first_of_overlap": ("block", 0),
    "second_of_overlap": ("block", 0),
    "first_of_close_pair": ("block", 0),
    "second_of_close_pair": ("block", 0),
    "block_of_nonplanar_face": ("block", 0),
}
_ASCENDING = (
    "block_of_vertex",
    "block_of_face",
    "face_of_face_corner",
    "interface_of_contact_point",
    "interface_of_interface_corner",
    "tie_of_model",
    "step_of_contact",
)
#: Labels by which values are looked up, and what they must be.
_LABELS = {"axis": AXES, "component": COMPONENTS}
#: What is 0 or 1 in the states of a curve, and what is a number of something.
_FLAGS = ("holds", "dropped", "drops_next", "divided")
_COUNTS = ("body", "contact_points", "programs", "solver_iterations", "body_failures", "body_waits")
#: What a detection measured, and its tolerances, that no sign belongs to; a gap may be a penetration.
_NOT_NEGATIVE = (
    *("gap_tolerance", "angle_tolerance", "area_tolerance", "close_distance"),
    *("angle_of_contact", "area_of_contact", "depth_of_overlap", "distance_of_close_pair"),
    "deviation_of_nonplanar_face",
)
#: Texts of iterations, and what each can be.
_WORDS = {"stage": Stage, "solver_status": SolverStatus}


def index_findings(path: str, ds: xr.Dataset) -> Iterator[Finding]:
    """Indices of a group that are out of their range or order, and labels that are not those of the format."""
    for name, labels in _LABELS.items():
        if name in ds.variables and tuple(ds[name].to_numpy()) != labels:
            yield f"{path}/{name}", f"the labels are not {', '.join(labels)}"
    for name, (dim, least) in _INDICES.items():
        if name not in ds.variables:
            continue
        values = ds[name].to_numpy()
        if values.size and (values.min() < least or values.max() >= ds.sizes[dim]):
            yield f"{path}/{name}", f"an index is outside {least}..{ds.sizes[dim] - 1}"
        if name in _ASCENDING and np.any(np.diff(values) < 0):
            yield f"{path}/{name}", "the indices are not in ascending order"


def model_findings(path: str, ds: xr.Dataset, model: Model) -> Iterator[Finding]:
    """What a file says of a model that follows from the rest of it, for readers that do not compute it."""
    corners = np.concatenate([b.shape.vertices for b in model.blocks])
    # Of coordinates far from the origin, rounding is that of their digits.
    length = float(np.ptp(corners, axis=0).max() + _ROUNDING / _SAME * np.abs(corners).max())
    derived = {
        "volume": ("block", [b.volume for b in model.blocks], max(b.volume for b in model.blocks)),
        "centroid": ("block", [b.centroid for b in model.blocks], length),
        "area": ("interface", [i.area for i in model.interfaces], max(i.area for i in model.interfaces)),
    }
    if model.detection is not None:
        joined = [(c.minus, c.plus) for c in model.detection.contacts if not c.reason]
        ends = np.array([[model.block_index[name] for name in pair] for pair in joined], dtype=np.int64)
        floating = np.zeros(len(model.blocks))
        floating[unsupported(np.array([b.fixed for b in model.blocks]), ends)] = 1
        untouched = ~np.isin(np.arange(len(model.blocks)), ends)
        derived |= {"floating": ("block", floating, 0.0), "untouched": ("block", untouched, 0.0)}
        yield from _detection_findings(path, ds, model)
    for name, (dim, values, scale) in derived.items():
        expected = np.asarray(values, dtype=float)
        off = ~(np.abs(ds[name].to_numpy() - expected) <= _SAME * scale)
        if off.any():
            at = tuple(np.argwhere(off)[0])
            who, stated = ds[dim].to_numpy()[at[0]], ds[name].to_numpy()[at]
            yield f"{path}/{name}", f"that of {who!r} is {stated:.6g}, and {expected[at]:.6g} by the rest of the model"


def _detection_findings(path: str, ds: xr.Dataset, model: Model) -> Iterator[Finding]:
    """Blocks of contacts against those of their interfaces, and measures that are negative."""
    joined = {i.name: {i.minus, i.plus} for i in model.interfaces}
    for k, contact in enumerate(model.detection.contacts if model.detection else ()):
        if contact.interface and {contact.minus, contact.plus} != joined[contact.interface]:
            pair = f"{contact.minus!r} and {contact.plus!r}"
            yield f"{path}/interface_of_contact", f"that of contact {k} of {pair} is {contact.interface!r}"
    for name in _NOT_NEGATIVE:
        if np.any(ds[name].to_numpy() < 0):
            yield f"{path}/{name}", "there is a negative number"


def case_findings(path: str, case: xr.Dataset, load_factors: Any, *, has_curve: bool) -> Iterator[Finding]:
    """What a result says against its own place, its curve, and the load factors of its history."""
    if has_curve and "pushover" not in case.attrs:
        yield path, "there is a capacity curve, but no attribute pushover: nothing tells what was pushed how"
    if group_name(str(case.attrs["name"])) != path.rpartition("/")[2]:
        yield path, "the attribute name is not that of the group"
    if int(case["n_iterations"]) != len(load_factors):
        yield path, "n_iterations is not the length of the history"
    if case.attrs["status"] == Status.CONVERGED:
        last = load_factors[-1] if len(load_factors) else np.nan
        expected = last if "settlement" in case.attrs else max(last, 0.0)
        if "without_crushing" in case:
            expected = min(expected, float(case["without_crushing"]))
        if "holds" not in case or not int(case["holds"]) or float(case["load_factor"]) != expected:
            yield path, "converged, but the certificate does not hold or the load factor is not the last of the history"


def reaction_findings(path: str, case: xr.Dataset, result: CaseResult) -> Iterator[Finding]:
    """What the reaction of a settlement says against its load factor and the dead load of the model."""
    if "reaction" in case:
        stated, found = float(case["reaction"]), result.answer.factor * result.load_factor
        if not np.isclose(stated, found, rtol=_SAME, atol=0.0, equal_nan=True):
            unit = result.answer.unit
            yield f"{path}/reaction", f"the reaction is {stated:.6g} {unit}, that of its load factor {found:.6g} {unit}"


def bound_findings(path: str, case: xr.Dataset, history: xr.Dataset) -> Iterator[Finding]:
    """What the associative load factor of a result says against its history."""
    found = history["load_factor"].to_numpy()[history["stage"].to_numpy() == Stage.ASSOCIATIVE.value]
    if "associative_load_factor" in case:
        stated, last = float(case["associative_load_factor"]), found[-1] if len(found) else np.nan
        if not np.array_equal(stated, last, equal_nan=True):
            yield path, f"associative_load_factor is {stated:.6g}, that of the history {last:.6g}"


def history_findings(path: str, history: xr.Dataset, model: xr.Dataset) -> Iterator[Finding]:
    """What a history says against itself or the model."""
    wrong = list(index_findings(path, history))
    yield from wrong
    yield from _count_findings(path, history, "iteration")
    for name, words in _WORDS.items():
        unknown = set(history[name].to_numpy()) - set(words)
        if unknown:
            yield f"{path}/{name}", f"{min(unknown)!r} is none of {', '.join(words)}"
    if not wrong:
        of_point = history["interface"].to_numpy()[history["interface_of_contact_point"].to_numpy()]
        if np.any(history["contact_point"].to_numpy() != of_point):
            yield f"{path}/contact_point", "the names of contact points are not those of their interfaces"
    for dim in ("block", "interface"):
        if history.sizes[dim] != model.sizes[dim]:
            yield path, f"{history.sizes[dim]} along {dim}, but /model has {model.sizes[dim]}"
        elif np.any(history[dim].to_numpy() != model[dim].to_numpy()):
            yield path, f"the {dim} names of the history are not those of /model"


def _count_findings(path: str, ds: xr.Dataset, dim: str) -> Iterator[Finding]:
    if not np.array_equal(ds[dim].to_numpy(), np.arange(ds.sizes[dim])):
        yield f"{path}/{dim}", "the numbers are not 0, 1, …"


def capacity_findings(path: str, capacity: xr.Dataset, model: xr.Dataset) -> Iterator[Finding]:
    """What a capacity curve says against itself or the model."""
    yield from _count_findings(path, capacity, "step")
    for names, most, words in ((_FLAGS, 1, "other than 0 and 1"), (_COUNTS, np.inf, "a negative number")):
        for name in (name for name in names if name in capacity.variables):
            values = capacity[name].to_numpy()
            if np.any((values < 0) | (values > most)):
                yield f"{path}/{name}", f"there is {words}"
    if capacity.sizes["block"] != model.sizes["block"] or np.any(
        capacity["block"].to_numpy() != model["block"].to_numpy()
    ):
        yield path, "the block names of the capacity curve are not those of /model"
    elif "tie" in capacity.variables and not np.array_equal(capacity["tie"].to_numpy(), model["tie"].to_numpy()):
        yield path, "the names of ties of the capacity curve are not those of /model"
    else:
        yield from index_findings(path, capacity)
