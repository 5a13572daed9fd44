"""Convert a model and results of cases to Datasets and back; find contradictions in a file; read version 1."""

import json
import math
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import attrs
import numpy as np
import xarray as xr

from blockstruct.arrays import ROUNDING
from blockstruct.errors import FormatError
from blockstruct.geometry.neighbours import unsupported
from blockstruct.geometry.polyhedron import polyhedron
from blockstruct.limit import Outcome
from blockstruct.limit.settings import FictitiousSchedule, Numerics
from blockstruct.model import (
    JOINT_PROPERTIES,
    LOAD_KINDS,
    TIE_KINDS,
    TIE_QUANTITIES,
    AnyTie,
    Block,
    Case,
    DetectionReport,
    DetectionTolerances,
    FoundContact,
    Interface,
    JointMaterial,
    LimitCase,
    Load,
    LoadPattern,
    Material,
    Model,
    Pushover,
    RecordCase,
    SettlementCase,
    given_quantities,
    kind_of,
    tie_kind_of,
)
from blockstruct.model.fields import dimensions, is_anchor
from blockstruct.motion.state import CurveOutcome
from blockstruct.results import CERTIFICATE_MEASURES
from blockstruct.results.case_result import CaseResult, LazyHistory
from blockstruct.schema import dressed, stated
from blockstruct.units import SI_UNITS, to_quantity
from blockstruct.vocabulary import (
    AXES,
    COMPONENTS,
    CurveEnd,
    Flow,
    JointOrientation,
    PathEnd,
    Procedure,
    Reason,
    SolverStatus,
    Stage,
    Status,
    Torsion,
)

#: Coordinates of a model.
_NAMES = ("axis", "material", "joint_material", "block", "interface", "load_pattern")
#: Variables of loads that every file has, whatever its loads.
_ALWAYS = tuple(f"{name}_of_load" for name in ("direction", "point", "force", "traction", "moment", "share"))
#: Variables of a model that are 0 or 1.
_MODEL_FLAGS = ("fixed", "floating", "untouched", "near_miss_of_contact")
#: Field of the tolerances of a detection, and its variable.
_TOLERANCES = {"gap": "gap_tolerance", "angle": "angle_tolerance", "area": "area_tolerance", "close": "close_distance"}
#: Columns of the contacts and of the faces of a detection, and its properties of blocks.
_CONTACT = ("minus", "plus", "interface", "reason", "orientation", "near_miss", "gap", "angle", "area")
_FACE, _FLAGGED = ("block", "face", "deviation"), ("floating", "untouched")
#: Types of values by their kind in the schema.
_DTYPES: Mapping[str, type] = {"f": float, "i": np.int64, "text": object}
#: Pairs of blocks: field of the report, its dimension in the file, the measure.
_PAIRS = (("overlaps", "overlap", "depth"), ("close", "close_pair", "distance"))
#: Numbers of an outcome that are stored if finite.
_FACTS = (
    *("peak", "carried", "load_ratio", "without_crushing", "uniform_torsion", "biaxial_crushing", "other_procedure"),
    *("lowered_friction", "collapse_time"),
)
#: Texts of a result that are stored if not empty.
_TEXTS = ("schedule", "of_case", "damage")
#: Attribute of a case by its kind, and the members of the attribute.
_OF_KIND: dict[type[Case], tuple[str, tuple[str, ...]]] = {
    Pushover: ("pushover", ("control", "control_point", "steps", "corner_rounding")),
    SettlementCase: ("settlement", ("supports", "direction", "about", "displacement", "steps")),
    RecordCase: ("record", ("direction", "interval", "time_step")),
}
#: Rounding of a length, relative to its coordinates.
_ROUNDING = 1e-12
#: A place in a file and the fault there.
Finding = tuple[str, str]

#: Index variables whose values are in ascending order.
_ASCENDING = (
    *("block_of_vertex", "block_of_face", "face_of_face_corner", "interface_of_contact_point"),
    *("interface_of_interface_corner", "tie_of_model", "step_of_contact", "state_of_contact"),
)
#: Index variables and the dimension into which each points: mostly its first word.
_INDICES = {
    **{name: name.partition("_of_")[0] for name in _ASCENDING},
    **dict.fromkeys(("block_of_load", "block_of_tie", "block_of_nonplanar_face"), "block"),
    **dict.fromkeys((f"{side}_{of}" for side in ("minus", "plus") for of in ("block", "of_contact")), "block"),
    **dict.fromkeys((f"{nth}_of_{of}" for nth in ("first", "second") for of in ("overlap", "close_pair")), "block"),
    **{"material_of_block": "material", "joint_material_of_interface": "joint_material", "state_of_contact": "time"},
    **{"vertex_of_face_corner": "vertex", "pattern_of_load": "load_pattern", "interface_of_contact": "interface"},
}
#: Indices of which −1 means none.
_OR_NONE = ("block_of_load", "block_of_tie", "interface_of_contact")
#: Labels of dimensions, and their values.
_LABELS = {"axis": AXES, "component": COMPONENTS}
#: Variables of a curve that are 0 or 1, and those that count.
_FLAGS = ("holds", "falls")
_COUNTS = ("contact_points", "solver_iterations")
#: Tolerances and measures of a detection that are never negative; a gap may be a penetration.
_NOT_NEGATIVE = (
    *("gap_tolerance", "angle_tolerance", "area_tolerance", "close_distance"),
    *("angle_of_contact", "area_of_contact", "depth_of_overlap", "distance_of_close_pair"),
    "deviation_of_nonplanar_face",
)
#: Texts of iterations, and their values.
_WORDS = {"stage": Stage, "solver_status": SolverStatus}
#: All groups of a file, by their path.
Groups = Mapping[str, xr.Dataset]
#: Reason of a case by its status, for files of version 1, which stored it as a sentence.
_REASONS = {
    Status.CONVERGED: Reason.CERTIFIED,
    Status.UNSTABLE: Reason.DEAD_LOAD_NOT_CARRIED,
    Status.SELF_STRESS: Reason.DEAD_LOAD_COLLAPSES,
    Status.UNBOUNDED: Reason.NEVER_COLLAPSES,
    Status.NOT_CONVERGED: Reason.NO_CERTIFICATE,
    Status.INTERRUPTED: Reason.INTERRUPTED,
}


def _integers(values: Any) -> np.ndarray:
    return np.asarray(list(values), dtype=np.int64)


def _texts(values: Any) -> np.ndarray:
    return np.array(list(values), dtype=object)


def model_dataset(model: Model, patterns: list[LoadPattern]) -> xr.Dataset:
    """Return a model and its load patterns as a Dataset, ragged data flat."""
    materials, joints = list(model.materials.values()), list(model.joint_materials.values())
    blocks, interfaces = model.blocks, model.interfaces
    index = {b.name: i for i, b in enumerate(blocks)}
    n_vertices = [len(b.shape.vertices) for b in blocks]
    first_vertex = np.cumsum([0, *n_vertices[:-1]])
    faces = [(i, face) for i, b in enumerate(blocks) for face in b.shape.faces]
    loads = [(p, load) for p, pattern in enumerate(patterns) for load in pattern.loads]
    of_material, of_joint = ([m.name for m in some].index for some in (materials, joints))
    values: dict[str, Any] = {
        "axis": _texts(AXES),
        "material": _texts(m.name for m in materials),
        "joint_material": _texts(j.name for j in joints),
        "block": _texts(index),
        "interface": _texts(i.name for i in interfaces),
        "load_pattern": _texts(p.name for p in patterns),
        "unit_weight": [m.unit_weight for m in materials],
        "material_of_block": _integers(of_material(b.material.name) for b in blocks),
        "fixed": np.array([b.fixed for b in blocks], dtype=np.int8),
        "volume": [b.volume for b in blocks],
        "centroid": [b.centroid for b in blocks],
        "vertex_position": np.concatenate([b.shape.vertices for b in blocks]),
        "block_of_vertex": np.repeat(np.arange(len(blocks)), n_vertices),
        "block_of_face": _integers(i for i, _ in faces),
        "face_of_face_corner": np.repeat(np.arange(len(faces)), [len(f) for _, f in faces]),
        "vertex_of_face_corner": np.concatenate([first_vertex[i] + _integers(f) for i, f in faces]),
        "minus_block": _integers(index[i.minus] for i in interfaces),
        "plus_block": _integers(index[i.plus] for i in interfaces),
        "joint_material_of_interface": _integers(of_joint(i.joint_material.name) for i in interfaces),
        "area": [i.area for i in interfaces],
        "interface_corner_position": np.concatenate([i.polygon for i in interfaces]),
        "interface_of_interface_corner": np.repeat(np.arange(len(interfaces)), [len(i.polygon) for i in interfaces]),
        "pattern_of_load": _integers(p for p, _ in loads),
        "kind_of_load": _texts(kind_of(load) for _, load in loads),
        "block_of_load": _integers(index.get(getattr(load, "block", None) or "", -1) for _, load in loads),
        "face_of_load": _integers(getattr(load, "face", -1) for _, load in loads),
    }
    if any(b.is_roller for b in blocks):
        values["held_motions"] = _texts(" ".join(b.held) for b in blocks)
    values |= {name: [getattr(j, name) for j in joints] for name in JOINT_PROPERTIES}
    values["torsion"] = _texts(str(j.torsion) for j in joints)
    for name in [name for name, v in stated("model").items() if name.endswith("_of_load") and v.kind == "f"]:
        given = [getattr(load, name.removesuffix("_of_load"), None) for _, load in loads]
        if name in _ALWAYS or any(value is not None for value in given):
            shape = (3,) if "axis" in stated("model")[name].dims else ()
            numbers = np.array([np.full(shape, np.nan) if value is None else value for value in given], dtype=float)
            values[name] = numbers.reshape(len(loads), *shape)
    for dim, some in (("material", materials), ("joint_material", joints)):
        if any(each.source for each in some):
            values[f"source_of_{dim}"] = _texts(each.source for each in some)
    if model.detection is not None:
        values |= _detection_values(model.detection, index, {i.name: k for k, i in enumerate(interfaces)})
    variables = dressed("model", values | _tie_values(model, index))
    for name in variables.keys() & set(_MODEL_FLAGS):  # The schema leaves them open: older files lack these units.
        variables[name][2]["units"] = "dimensionless"
    coords = {name: variables.pop(name) for name in [name for name in variables if name in _NAMES]}
    return xr.Dataset(variables, coords=xr.Coordinates(coords, indexes={}), attrs={"name": model.name})


def read_model(ds: xr.Dataset) -> Model:
    """Return the model of a Dataset, built by the same constructors and checks as any other."""
    stored = _values(ds)
    names = {dim: [str(name) for name in stored[dim]] for dim in ("material", "block", "interface")}
    weights, sources = stored["unit_weight"], _sources(stored, "material")
    materials = [
        Material(name, to_quantity(value, "force/volume"), source=source)
        for name, value, source in zip(names["material"], weights, sources, strict=True)
    ]
    joints = [_joint(stored, k) for k in range(ds.sizes["joint_material"])]
    vertices = _parts(stored["vertex_position"], stored["block_of_vertex"], ds.sizes["block"])
    first = np.searchsorted(stored["block_of_vertex"], np.arange(ds.sizes["block"]))
    corners = _parts(stored["vertex_of_face_corner"], stored["face_of_face_corner"], ds.sizes["face"])
    faces: list[list[list[int]]] = [[] for _ in names["block"]]
    for block, corner in zip(stored["block_of_face"], corners, strict=True):
        faces[block].append((corner - first[block]).tolist())
    held: list[bool | list[str]] = [bool(fixed) for fixed in stored["fixed"]]
    if "held_motions" in stored:
        held = [str(motions).split() for motions in stored["held_motions"]]
    of_block = (stored["material_of_block"], held)
    blocks = [
        Block(name, polyhedron(v, f, name), materials[m], fixed)
        for name, v, f, m, fixed in zip(names["block"], vertices, faces, *of_block, strict=True)
    ]
    owner = stored["interface_of_interface_corner"]
    polygons = _parts(stored["interface_corner_position"], owner, ds.sizes["interface"])
    of_interface = (stored[name] for name in ("minus_block", "plus_block", "joint_material_of_interface"))
    interfaces = [
        Interface(name, blocks[minus].name, blocks[plus].name, to_quantity(polygon, "length"), joints[joint])
        for name, polygon, minus, plus, joint in zip(names["interface"], polygons, *of_interface, strict=True)
    ]
    ties = [_tie(ds.isel(tie=k)) for k in range(ds.sizes.get("tie", 0))]
    return Model(ds.attrs["name"], blocks, interfaces, detection=_detection(stored, names), ties=ties)


def read_patterns(ds: xr.Dataset) -> dict[str, LoadPattern]:
    """Return the load patterns of a Dataset by name."""
    stored = _values(ds)
    names = [str(name) for name in stored["load_pattern"]]
    loads: list[list[Load]] = [[] for _ in names]
    for k, pattern in enumerate(stored["pattern_of_load"]):
        loads[pattern].append(_load(stored, k))
    return {name: LoadPattern(name, items) for name, items in zip(names, loads, strict=True)}


def _joint(stored: Mapping[str, Any], k: int) -> JointMaterial:
    values = {name: float(stored[name][k]) for name in JOINT_PROPERTIES}
    # Files of the first version know the torsion of corners alone.
    torsion = str(stored["torsion"][k]) if "torsion" in stored else Torsion.CORNERS
    name, source = str(stored["joint_material"][k]), _sources(stored, "joint_material")[k]
    return JointMaterial.from_si(name, values, torsion, source)


def _values(ds: xr.Dataset) -> dict[str, Any]:
    """Return the values of the variables of a Dataset by name; quicker than a DataArray of each."""
    return {str(name): variable.to_numpy() for name, variable in ds.variables.items()}


def _sources(stored: Mapping[str, Any], dim: str) -> list[str]:
    return [str(text) for text in stored.get(f"source_of_{dim}", [""] * len(stored[dim]))]


def _load(stored: Mapping[str, Any], k: int) -> Load:
    kind: Any = LOAD_KINDS[str(stored["kind_of_load"][k])]
    block, arguments = int(stored["block_of_load"][k]), dict[str, Any]()
    for field in attrs.fields(kind):
        value = stored[f"{field.name}_of_load"][k] if f"{field.name}_of_load" in stored else np.nan
        if field.name == "block":
            arguments["block"] = str(stored["block"][block]) if block >= 0 else None
        elif "dimension" not in field.metadata:  # The index of a face, or True or False.
            arguments[field.name] = field.type(value)
        elif field.default is not None or not np.isnan(value).all():
            arguments[field.name] = to_quantity(value, field.metadata["dimension"])
    load: Load = kind(**arguments)
    return load


def _parts(values: np.ndarray, owner: np.ndarray, n: int) -> list[np.ndarray]:
    """Return the values of each of n owners, which are in ascending order."""
    return np.split(values, np.searchsorted(owner, np.arange(1, n)))


def _table(dim: str, names: Sequence[str], rows: Sequence[tuple[Any, ...]]) -> dict[str, Any]:
    """Return the columns of a table, with names such as ``gap_of_contact``."""
    columns = zip(*rows, strict=True) if rows else ((),) * len(names)
    kinds = stated("model")
    named = ((f"{name}_of_{dim}", column) for name, column in zip(names, columns, strict=True))
    return {name: np.array(column, dtype=_DTYPES[kinds[name].kind]) for name, column in named}


def _rows(stored: Mapping[str, Any], dim: str, names: Sequence[str]) -> Iterator[tuple[Any, ...]]:
    """Return the rows of a table as plain values."""
    return zip(*(stored[f"{name}_of_{dim}"].tolist() for name in names), strict=True)


def _detection_values(
    report: DetectionReport, block: Mapping[str, int], interface: Mapping[str, int]
) -> dict[str, Any]:
    """Return the values of a detection report, for blocks and interfaces by their index."""
    contacts = [
        (
            *(block[c.minus], block[c.plus], interface[c.interface] if c.interface else -1),
            *(c.reason, c.orientation.value, c.near_miss, c.gap, c.angle, c.area),
        )
        for c in report.contacts
    ]
    values: dict[str, Any] = {name: getattr(report.tolerances, field) for field, name in _TOLERANCES.items()}
    values |= _table("contact", _CONTACT, contacts)
    for field, dim, measure in _PAIRS:
        pairs = [(block[first], block[second], value) for first, second, value in getattr(report, field)]
        values |= _table(dim, ("first", "second", measure), pairs)
    values |= _table("nonplanar_face", _FACE, [(block[name], face, off) for name, face, off in report.nonplanar_faces])
    return values | {name: np.isin([*block], getattr(report, name)).astype(np.int8) for name in _FLAGGED}


def _detection(stored: Mapping[str, Any], names: Mapping[str, Sequence[str]]) -> DetectionReport | None:
    """Return the detection report of the values of a model; None without one."""
    if "gap_tolerance" not in stored:
        return None
    block = names["block"]
    # Index −1, the last entry, stands for a contact without interface.
    interface = [*names["interface"], ""]
    parts: dict[str, Any] = {
        field: tuple((block[i], block[j], v) for i, j, v in _rows(stored, dim, ("first", "second", measure)))
        for field, dim, measure in _PAIRS
    }
    parts |= {name: tuple(np.array(block, dtype=object)[stored[name] != 0]) for name in _FLAGGED}
    return DetectionReport(
        DetectionTolerances(**{field: float(stored[name]) for field, name in _TOLERANCES.items()}),
        tuple(
            FoundContact(block[i], block[j], interface[k], reason, gap, angle, area, JointOrientation(lie), bool(near))
            for i, j, k, reason, lie, near, gap, angle, area in _rows(stored, "contact", _CONTACT)
        ),
        nonplanar_faces=tuple((block[i], face, off) for i, face, off in _rows(stored, "nonplanar_face", _FACE)),
        **parts,
    )


def _tie_values(model: Model, index: Mapping[str, int]) -> dict[str, Any]:
    """Return the values of the ties of a model; none without ties."""
    rows: list[tuple[Any, ...]] = []
    for tie in model.ties:
        given = given_quantities(tie)
        blocks, points = zip(*(end if is_anchor(end) else ("", end) for end in (tie.start, tie.end)), strict=True)
        quantities = [given.get(name, np.nan) for name in TIE_QUANTITIES]
        rows.append((tie_kind_of(tie), [index.get(block, -1) for block in blocks], points, *quantities))
    columns = _table("tie", ("kind", "block", "end", *TIE_QUANTITIES), rows)
    return {"tie": _texts(tie.name for tie in model.ties)} | columns if rows else {}


def _tie(one: xr.Dataset) -> AnyTie:
    kind = TIE_KINDS[str(one["kind_of_tie"].item())]
    points = [to_quantity(point, "length") for point in one["end_of_tie"].to_numpy()]
    blocks = [int(block) for block in one["block_of_tie"].to_numpy()]
    start, end = (
        point if block < 0 else (str(one["block"].to_numpy()[block]), point)
        for block, point in zip(blocks, points, strict=True)
    )
    stored = {name: float(one[f"{name}_of_tie"]) for name in TIE_QUANTITIES if f"{name}_of_tie" in one}
    quantities = {n: to_quantity(v, TIE_QUANTITIES[n]) for n, v in stored.items() if not np.isnan(v)}
    return kind(str(one["tie"].item()), start, end, **quantities)


def group_name(name: str) -> str:
    """Return the group name of a case, with characters escaped that HDF5 cannot hold in a name."""
    escaped = name.replace("%", "%25").replace("/", "%2F")
    return escaped.replace(".", "%2E") if escaped in (".", "..") else escaped


def case_dataset(result: CaseResult, versions: Mapping[str, str]) -> xr.Dataset:
    """Return the scalars of a result as variables and its texts as attributes."""
    outcome, case = result.outcome, result.case
    values: dict[str, Any] = {
        "load_factor": result.load_factor,
        "n_iterations": result.n_iterations,
        "duration": result.duration,
        "settled": int(result.settled),
    }
    if outcome.drift is not None:
        values["drift_low"], values["drift_high"] = outcome.drift
    values |= {name: value for name in _FACTS if math.isfinite(value := getattr(outcome, name))}
    values |= {"programs": outcome.programs} if outcome.programs else {}
    values |= {"estimated": 1} if outcome.estimated else {}
    if result.n_iterations:
        values["associative_load_factor"] = result.associative_load_factor
    if result.certificate is not None:
        values |= result.certificate.measures | {"holds": int(result.certificate.holds)}
    if isinstance(case, SettlementCase):
        values["reaction"] = float(result.reaction.magnitude)
    if isinstance(case, RecordCase):
        several = "s" * (case.direction is None)
        values[f"record_acceleration{several}"] = np.array(case.acceleration)
        values["record_interval" if isinstance(case.time, float) else "record_time"] = np.array(case.time)
        values |= {"peak_displacement": peak} if math.isfinite(peak := result.peak_displacement) else {}
    attrs = {
        "name": result.name,
        "status": result.status.value,
        "reason": outcome.reason.value,
        "procedure": outcome.procedure.value if outcome.procedure else "",
        "flow": case.flow.value,
        "dead": case.dead.name,
        "variable": case.patterns[-1].name if isinstance(case, LimitCase) else "",
        "settings": json.dumps(asdict(result.settings)),
        "started_at": result.started_at,
    }
    attrs |= {"path_end": outcome.path_end.value} if outcome.path_end else {}
    attrs |= {name: json.dumps(v) for name in ("hung", "jammed") if (v := getattr(result, name))}
    attrs |= {name: text for name in _TEXTS if (text := getattr(result, name))}
    attrs |= {"curve_ended": result.curve_outcome.text} if result.curve_outcome else {}
    made_by = [dict(each) for each in result.versions]
    if result.n_iterations and made_by not in ([], [dict(versions)]):
        attrs["versions"] = json.dumps(made_by, sort_keys=True)
    for kind, (attribute, members) in _OF_KIND.items():
        if isinstance(case, kind):
            attrs[attribute] = json.dumps({name: getattr(case, name) for name in members})
    variables = dressed("case", values)
    if "reaction" in variables:
        variables["reaction"][2]["units"] = SI_UNITS[result.answer.dimension]
    return xr.Dataset(variables, attrs=attrs)


def read_result(
    ds: xr.Dataset,
    history: xr.Dataset | LazyHistory,
    model: Model,
    patterns: Mapping[str, LoadPattern],
    versions: Mapping[str, str],
    capacity: xr.Dataset | None = None,
    response: xr.Dataset | None = None,
) -> CaseResult:
    """Return the result of a Dataset; a result without versions takes the versions of its file."""
    a = ds.attrs
    outcome = CurveOutcome.read(a.get("curve_ended", ""))
    if capacity is not None and "inertia_time" not in capacity:
        capacity, outcome = None, CurveOutcome(CurveEnd.EARLIER_VERSION)
    return CaseResult.restored(
        model=model,
        case=_case(ds, patterns),
        settings=json.loads(a["settings"]),
        outcome=_outcome(ds, model),
        certificate={name: ds[name].item() for name in CERTIFICATE_MEASURES if name in ds},
        **{name: a[name] for name in _TEXTS if name in a},
        curve_outcome=outcome,
        history=history,
        started_at=a["started_at"],
        duration=float(ds["duration"]),
        capacity=capacity,
        response=response,
        versions=versions_of(a, versions) if int(ds["n_iterations"]) else (),
    )


def _outcome(ds: xr.Dataset, model: Model) -> Outcome:
    a, free = ds.attrs, [block.name for block in model.blocks if not block.fixed]
    facts: dict[str, Any] = {name: float(ds[name]) for name in _FACTS if name in ds}
    for name in ("hung", "jammed"):
        facts[name] = tuple(free.index(block) for block in json.loads(a.get(name, "[]")))
    return Outcome(
        Status(a["status"]),
        float(ds["load_factor"]),
        Reason(a["reason"]),
        procedure=Procedure(a["procedure"]) if a["procedure"] else None,
        settled=bool(ds["settled"]),
        drift=(float(ds["drift_low"]), float(ds["drift_high"])) if "drift_low" in ds else None,
        path_end=PathEnd(a["path_end"]) if "path_end" in a else None,
        programs=int(ds["programs"]) if "programs" in ds else 0,
        estimated="estimated" in ds,
        **facts,
    )


def versions_of(attrs: Mapping[str, Any], versions: Mapping[str, str]) -> tuple[Mapping[str, str], ...]:
    """Return the versions that made the numbers of a case, by default the versions of its file.

    Raises
    ------
    FormatError
        If the attribute holds anything else.
    """
    recorded = json.loads(attrs.get("versions", json.dumps([versions])))
    if not isinstance(recorded, list) or not recorded or not all(isinstance(each, dict) for each in recorded):
        msg = "attribute versions is not a JSON list of objects"
        raise FormatError(msg)
    return tuple(recorded)


def _case(ds: xr.Dataset, patterns: Mapping[str, LoadPattern]) -> Case:
    """Return the case of a Dataset; members that an earlier version did not store have their defaults."""
    a = ds.attrs
    kind: Any = next((kind for kind, (attribute, _) in _OF_KIND.items() if attribute in a), LimitCase)
    attribute, members = _OF_KIND.get(kind, ("", ()))
    values = dict(json.loads(a[attribute])) if attribute else {}
    stored = {name: values[name] for name in members if values.get(name) is not None}
    if kind is RecordCase:
        several = "s" * ("direction" not in stored)
        time = ds["record_interval" if "record_interval" in ds else "record_time"]
        stored |= {"acceleration": ds[f"record_acceleration{several}"].to_numpy(), "time": time.to_numpy()}
    else:
        stored["flow"] = a["flow"]
    units = {name: dimension for name, dimension in dimensions(kind).items() if dimension != "dimensionless"}
    for name in stored.keys() & units:
        stored[name] = to_quantity(np.array(stored[name], dtype=float)[()], units[name])
    variable = (patterns[a["variable"]],) if issubclass(kind, LimitCase) else ()
    case: Case = kind(a["name"], patterns[a["dead"]], *variable, **stored)
    return case


def index_findings(path: str, ds: xr.Dataset) -> Iterator[Finding]:
    """Find indices out of their range or order, and wrong labels."""
    stored = _values(ds)
    for name, labels in _LABELS.items():
        if name in stored and tuple(stored[name]) != labels:
            yield f"{path}/{name}", f"the labels are not {', '.join(labels)}"
    for name, dim in _INDICES.items():
        if name not in stored:
            continue
        values, least = stored[name], -1 if name in _OR_NONE else 0
        if values.size and (values.min() < least or values.max() >= ds.sizes[dim]):
            yield f"{path}/{name}", f"an index is outside {least}..{ds.sizes[dim] - 1}"
        if name in _ASCENDING and np.any(np.diff(values) < 0):
            yield f"{path}/{name}", "the indices are not in ascending order"


def model_findings(path: str, ds: xr.Dataset, model: Model) -> Iterator[Finding]:
    """Find stored values of a model that differ from the ones computed from the rest of the file."""
    corners = np.concatenate([b.shape.vertices for b in model.blocks])
    # Coordinates far from the origin have fewer digits.
    length = float(np.ptp(corners, axis=0).max() + _ROUNDING / ROUNDING * np.abs(corners).max())
    derived = {
        "fixed": ("block", [b.fixed for b in model.blocks], 0.0),
        "volume": ("block", [b.volume for b in model.blocks], max(b.volume for b in model.blocks)),
        "centroid": ("block", [b.centroid for b in model.blocks], length),
        "area": ("interface", [i.area for i in model.interfaces], max(i.area for i in model.interfaces)),
    }
    if model.detection is not None:
        joined = [(c.minus, c.plus) for c in model.detection.contacts if not c.reason]
        ends = np.array([[model.block_index[name] for name in pair] for pair in joined], dtype=np.int64)
        floating = np.zeros(len(model.blocks))
        floating[unsupported(np.array([bool(b.held) for b in model.blocks]), ends)] = 1
        untouched = ~np.isin(np.arange(len(model.blocks)), ends)
        derived |= {"floating": ("block", floating, 0.0), "untouched": ("block", untouched, 0.0)}
        yield from _detection_findings(path, ds, model)
    for name, (dim, values, scale) in derived.items():
        expected = np.asarray(values, dtype=float)
        off = ~(np.abs(ds[name].to_numpy() - expected) <= ROUNDING * scale)
        if off.any():
            at = tuple(np.argwhere(off)[0])
            who, stated = ds[dim].to_numpy()[at[0]], ds[name].to_numpy()[at]
            yield f"{path}/{name}", f"that of {who!r} is {stated:.6g}, and {expected[at]:.6g} by the rest of the model"


def _detection_findings(path: str, ds: xr.Dataset, model: Model) -> Iterator[Finding]:
    """Find contacts of other blocks than their interface, and negative measures."""
    joined = {i.name: {i.minus, i.plus} for i in model.interfaces}
    for k, contact in enumerate(model.detection.contacts if model.detection else ()):
        if contact.interface and {contact.minus, contact.plus} != joined[contact.interface]:
            pair = f"{contact.minus!r} and {contact.plus!r}"
            yield f"{path}/interface_of_contact", f"that of contact {k} of {pair} is {contact.interface!r}"
    for name in _NOT_NEGATIVE:
        if np.any(ds[name].to_numpy() < 0):
            yield f"{path}/{name}", "there is a negative number"


def case_findings(path: str, case: xr.Dataset, load_factors: Any, parts: Container[str]) -> Iterator[Finding]:
    """Find where a result contradicts its group, its curve, its response or the load factors of its history."""
    if "response" in parts and "record" not in case.attrs:
        yield path, "there is a response, but no attribute record: nothing tells what the ground did"
    if "capacity" in parts and not {"pushover", "settlement"} & set(case.attrs):
        yield path, "there is a capacity curve, but no attribute pushover or settlement: nothing tells what moves how"
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


def result_findings(path: str, case: xr.Dataset, result: CaseResult) -> Iterator[Finding]:
    """Find a reaction that contradicts its load factor, and a certificate that holds against its own measures."""
    certificate, answer = result.certificate, result.answer
    if "reaction" in case:
        stated, found = float(case["reaction"]), answer.factor * result.load_factor
        if not np.isclose(stated, found, rtol=ROUNDING, atol=0.0, equal_nan=True):
            texts = f"{stated:.6g} {answer.unit}, that of its load factor {found:.6g} {answer.unit}"
            yield f"{path}/reaction", f"the reaction is {texts}"
    if certificate is not None and certificate.holds and not certificate.is_within_tolerances:
        texts = ", ".join(f"{name} {value} (tolerance {limit})" for name, (value, limit) in certificate.texts.items())
        yield f"{path}/holds", f"the certificate holds, against its measures: {texts}"


def bound_findings(path: str, case: xr.Dataset, history: xr.Dataset) -> Iterator[Finding]:
    """Find an associative load factor that is not the last of its history."""
    load_factors = history["load_factor"].to_numpy()[history["stage"].to_numpy() == Stage.ASSOCIATIVE.value]
    if "associative_load_factor" in case:
        stated, last = float(case["associative_load_factor"]), load_factors[-1] if len(load_factors) else np.nan
        if not np.array_equal(stated, last, equal_nan=True):
            yield path, f"associative_load_factor is {stated:.6g}, that of the history {last:.6g}"


def value_findings(path: str, ds: xr.Dataset) -> Iterator[Finding]:
    """Find numbers, times, words and flags of a part of a case that are not in order, or none that there are."""
    stored = _values(ds)
    for name in stored.keys() & {"iteration", "step"}:
        if not np.array_equal(stored[name], np.arange(ds.sizes[name])):
            yield f"{path}/{name}", "the numbers are not 0, 1, …"
    if "time" in stored and np.any(np.diff(stored["time"]) <= 0):
        yield f"{path}/time", "the times are not in ascending order"
    for name in stored.keys() & set(_WORDS):
        if unknown := set(stored[name]) - set(_WORDS[name]):
            yield f"{path}/{name}", f"{min(unknown)!r} is none of {', '.join(_WORDS[name])}"
    for names, most, words in ((_FLAGS, 1, "other than 0 and 1"), (_COUNTS, np.inf, "a negative number")):
        for name in stored.keys() & set(names):
            if np.any((stored[name] < 0) | (stored[name] > most)):
                yield f"{path}/{name}", f"there is {words}"


def part_findings(path: str, ds: xr.Dataset, model: xr.Dataset) -> Iterator[Finding]:
    """Find where the history, the capacity curve or the response of a case contradicts itself or the model."""
    wrong, stored = list(index_findings(path, ds)), _values(ds)
    yield from wrong
    yield from value_findings(path, ds)
    if "contact_point" in stored and not wrong:
        of_point = stored["interface"][stored["interface_of_contact_point"]]
        if np.any(stored["contact_point"] != of_point):
            yield f"{path}/contact_point", "the names of contact points are not those of their interfaces"
    # The ties of a history are stretches of the ties of the model.
    for dim in stored.keys() & ({"block", "interface"} if "tie_of_model" in stored else {"block", "interface", "tie"}):
        if dim not in model.variables or not np.array_equal(stored[dim], model.variables[dim].to_numpy()):
            yield path, f"the names along {dim} are not those of /model"


#: Groups of a case besides its own.
PARTS = ("history", "capacity", "response")


def findings(groups: Groups, load_factors: Callable[[str], Any] = lambda _: None) -> Iterator[Finding]:
    """Find where valid groups of a file contradict themselves or each other.

    Parameters
    ----------
    groups
        By their path.
    load_factors
        Gives the load factors of a case by the path of its group, if its history is not one of the groups; None leaves
        them out.
    """
    model = groups.get("/model")
    if model is not None:
        yield from index_findings("/model", model)
    for place, ds in groups.items():
        parent = place.rpartition("/")[0]
        if parent == "/cases":
            history = groups.get(f"{place}/history")
            alpha = load_factors(place) if history is None else history["load_factor"].to_numpy()
            if alpha is not None:
                yield from case_findings(place, ds, alpha, [part for part in PARTS if f"{place}/{part}" in groups])
            if history is not None:
                yield from bound_findings(place, ds, history)
        elif parent and model is not None:
            yield from part_findings(place, ds, model)


def _from_1(groups: Groups) -> Groups:
    """Store how a case ended as facts, and its settings in three parts."""
    new = dict(groups)
    for place, ds in groups.items():
        if (at := f"{place}/history") in groups:
            new[place], history = _case_from_1(ds, groups[at]), groups[at]
            if ds.attrs["status"] == Status.SELF_STRESS.value and history.sizes["iteration"]:
                stages = history["stage"].to_numpy().astype(object)
                stages[-1] = Stage.DEAD_LOAD_COLLAPSE.value
                new[at] = history.assign(stage=history["stage"].copy(data=stages))
    return new


def _case_from_1(case: xr.Dataset, history: xr.Dataset) -> xr.Dataset:
    attrs = {name: value for name, value in case.attrs.items() if name != "message"}
    settings, stages = json.loads(attrs["settings"]), history["stage"].to_numpy()
    status, associative = Status(attrs["status"]), attrs["flow"] == Flow.ASSOCIATIVE
    converged = status is Status.CONVERGED
    procedure = Procedure.ASSOCIATIVE if associative else _procedure(stages)
    attrs |= {
        "reason": _REASONS[status].value,
        "procedure": procedure.value if converged else "",
        "settings": json.dumps(_settings_from_1(settings)),
    }
    settled = converged and (associative or _has_settled(history, procedure, settings["load_factor_tolerance"]))
    new = case.assign(settled=((), int(settled), {"units": "dimensionless"}))
    new.attrs = attrs
    return new


def _procedure(stages: Any) -> Procedure:
    for stage, procedure in ((Stage.SHIFTED, Procedure.SHIFTED), (Stage.LOADING_PATH, Procedure.LOADING_PATH)):
        if (stages == stage.value).any():
            return procedure
    return Procedure.FICTITIOUS


def _has_settled(history: xr.Dataset, procedure: Procedure, tolerance: float) -> bool:
    """Return whether the last two load factors of a procedure agree; version 1 stores no other sign."""
    stage = Stage.LOADING_PATH if procedure is Procedure.LOADING_PATH else Stage.NONASSOCIATIVE
    alpha = history["load_factor"].to_numpy()
    last = alpha[(history["stage"].to_numpy() == stage.value) & np.isfinite(alpha)][-2:]
    return procedure is Procedure.SHIFTED or bool(len(last) == 2 and abs(last[1] - last[0]) <= tolerance * abs(last[1]))


def _settings_from_1(settings: dict[str, Any]) -> dict[str, Any]:
    renamed = {name.replace("cohesion", "c0"): value for name, value in settings.items()}
    parts: dict[str, dict[str, Any]] = {
        part: {name: renamed.pop(name) for name in kind.__dataclass_fields__ if name in renamed}
        for part, kind in (("schedule", FictitiousSchedule), ("numerics", Numerics))
    }
    return renamed | parts


#: Steps from one major version to the next, by (from, to).
MIGRATIONS: dict[tuple[int, int], Callable[[Groups], Groups]] = {(1, 2): _from_1}


def migrated(groups: Groups, version: int, current: int) -> Groups:
    """Migrate the groups of a file to the current major version.

    Parameters
    ----------
    groups
        Of the file.
    version, current
        Major version of the file, and the current one, which is not older.

    Raises
    ------
    FormatError
        If no step leads from a version to the next.
    """
    for older in range(version, current):
        step = (older, older + 1)
        if step not in MIGRATIONS:
            msg = f"format version {older}: no migration to {older + 1}; read it with an older blockstruct"
            raise FormatError(msg)
        groups = MIGRATIONS[step](groups)
    return groups
