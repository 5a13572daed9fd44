"""Model documents: a structure, its loads and its cases as YAML or JSON, read and written."""

import hashlib
import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, is_dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
import yaml

from blockstruct.arrays import ROUNDING
from blockstruct.contacts.detection import detect_interfaces
from blockstruct.documents import yaml_core
from blockstruct.errors import BlockstructError, DocumentError, ModelError, StorageError, UnknownNameError
from blockstruct.files import check_new, read_file, unique_pairs, write_new
from blockstruct.model import (
    LOAD_KINDS,
    TIE_KINDS,
    AnyTie,
    Block,
    Case,
    Detection,
    DetectionReport,
    Interface,
    JointMaterial,
    LimitCase,
    LoadPattern,
    Material,
    Model,
    Pushover,
    RecordCase,
    SettlementCase,
    check_unrepeated,
    direction_cases,
    kind_of,
    tie_kind_of,
)
from blockstruct.model.fields import absent_value, is_anchor
from blockstruct.schema import listed_violations, violations
from blockstruct.structures import Buttress, Opening, RoundOpening, Rubble, Sidewall, room, wall
from blockstruct.structures.courses import courses
from blockstruct.units import parse, si, si_text, to_quantity
from blockstruct.vocabulary import counted


def wall_of(entry: dict[str, Any], material: Material) -> list[Block]:
    """Return the blocks of a wall entry that follows the schema, with its sidewalls and buttresses."""
    parts: dict[str, Any] = {
        "openings": _openings(entry),
        "sidewalls": [Sidewall(**side | {"openings": _openings(side)}) for side in entry.get("sidewalls", [])],
        "buttresses": [Buttress(**buttress) for buttress in entry.get("buttresses", [])],
    }
    return wall(**entry | parts | _rubble(entry) | {"material": material})


def room_of(entry: dict[str, Any], material: Material) -> list[Block]:
    """Return the blocks of a room entry that follows the schema."""
    holes = {name: _openings({"openings": listed}) for name, listed in entry.get("openings", {}).items()}
    return room(**entry | {"openings": holes} | _rubble(entry) | {"material": material})


def _rubble(entry: dict[str, Any]) -> dict[str, Rubble]:
    return {"rubble": Rubble(**entry["rubble"])} if "rubble" in entry else {}


def _openings(entry: dict[str, Any]) -> list[Opening | RoundOpening]:
    """Return the openings of a wall or a sidewall. An opening with a centre is round."""
    return [
        RoundOpening(**opening) if "centre" in opening else Opening(**opening) for opening in entry.get("openings", [])
    ]


#: Largest size of a model document, bytes. A block takes about 400 bytes.
MOST_BYTES = 64_000_000
#: The kind of file, for messages.
DOCUMENT = "a YAML or JSON document"


@dataclass(frozen=True, slots=True)
class Document:
    """Content of a model document.

    Attributes
    ----------
    model : Model
    cases : tuple of LimitCase, Pushover, SettlementCase or RecordCase
    settings : dict
        Settings of the procedure, arguments of :class:`blockstruct.ProcedureSettings`.
    report : DetectionReport
        Report on the detection of the interfaces.
    hash : str
        SHA-256 of the file.
    """

    model: Model
    cases: tuple[Case, ...]
    settings: dict[str, Any]
    report: DetectionReport
    hash: str


def read_document(path: str | Path) -> Document:
    """Read a model document.

    Parameters
    ----------
    path
        A ``.yaml``, ``.yml`` or ``.json`` file that follows ``schemas/model-1.json``.

    Raises
    ------
    StorageError
        If the file cannot be read.
    DocumentError
        If the file is not YAML or JSON, repeats a key or violates the schema. The message lists every violation.
    ModelError
        If the document does not describe a valid model.
    """
    path = Path(path)
    stored = read_file(path, DOCUMENT, MOST_BYTES)
    content = _content(stored, path, "model-1")
    try:
        return _build(content, path.stem, hashlib.sha256(stored).hexdigest())
    except BlockstructError as error:
        error.add_note(f"in {path}")
        raise


def read_content(path: str | Path, schema: str) -> dict[str, Any]:
    """Return the content of a document that follows a schema; errors as in :func:`read_document`."""
    return _content(read_file(Path(path), DOCUMENT, MOST_BYTES), Path(path), schema)


def document_of(content: dict[str, Any], name: str) -> Document:
    """Return the document of a content.

    Parameters
    ----------
    content
        Content of a model document, as :func:`read_content` returns it.
    name
        Name of the model, if the content has no name.

    Raises
    ------
    DocumentError
        If the content violates the schema.
    ModelError
        If the content does not describe a valid model.
    """
    check_content(content, "model-1", name)
    return _build(content, name, "")


def _content(stored: bytes, path: Path, schema: str) -> dict[str, Any]:
    try:
        text = stored.decode("utf-8")
    except UnicodeDecodeError as error:
        msg = f"{path}: is not text; give a YAML or JSON document. `blockstruct show` prints an analysis file"
        raise StorageError(msg) from error
    content: dict[str, Any] = _load(text, path)
    check_content(content, schema, path)
    return content


def check_content(content: Any, schema: str, where: object) -> None:
    """Refuse a content that violates a schema."""
    problems = violations(content, schema)
    if problems:
        msg = f"{where}: {listed_violations(problems)}"
        raise DocumentError(msg)


def _load(text: str, path: Path) -> Any:
    try:
        if path.suffix.lower() == ".json":
            return json.loads(text, object_pairs_hook=unique_pairs)
        return yaml_core.load(text)
    except (ValueError, yaml.YAMLError, RecursionError) as error:
        reason = str(error).replace('in "<unicode string>", ', "at ")
        msg = f"{path}: not valid {'JSON' if path.suffix.lower() == '.json' else 'YAML'}: {reason}"
        raise DocumentError(msg) from error


def _build(content: dict[str, Any], stem: str, digest: str) -> Document:
    materials = {name: Material(name, **values) for name, values in content["materials"].items()}
    joints = {name: JointMaterial(name, **values) for name, values in content["joint_materials"].items()}
    blocks: list[Block] = []
    for entry in content.get("courses", []):
        blocks += courses(**entry | {"material": _named(materials, entry["material"], "material")})
    for name, build in (("wall", wall_of), ("room", room_of)):
        if name in content:
            blocks += build(content[name], _named(materials, content[name]["material"], "material"))
    for entry in content.get("blocks", []):
        blocks.append(_block_from(entry, _named(materials, entry["material"], "material")))
    detection = _detection(blocks, content["interfaces"], joints)
    ties = [_tie_from(entry) for entry in content.get("ties", [])]
    try:
        model = Model(content.get("name", stem), blocks, detection, ties=ties)
    except BlockstructError as error:
        # The report of the detection usually shows the cause.
        error.add_note(f"{counted(len(blocks), 'block')}, {detection.report}")
        raise

    patterns = {
        name: LoadPattern(name, [_load_from(entry) for entry in loads])
        for name, loads in content["load_patterns"].items()
    }
    cases = [case for entry in content["cases"] for case in _cases(entry, patterns)]
    check_unrepeated((case.name for case in cases), "case")
    return Document(model, tuple(cases), content.get("settings", {}), detection.report, digest)


def _detection(blocks: list[Block], entry: dict[str, Any], joints: dict[str, JointMaterial]) -> Detection:
    limits = {key: entry[key] for key in ("tolerance", "angle_tolerance", "area_tolerance") if key in entry}
    names = entry["joint_material"]
    rule: Any = (
        {pattern: _named(joints, name, "joint material") for pattern, name in names.items()}
        if isinstance(names, dict)
        else _named(joints, names, "joint material")
    )
    explicit = [
        Interface(
            joint.get("name", f"{joint['minus']}|{joint['plus']}"),
            joint["minus"],
            joint["plus"],
            _points(joint["polygon"], joint["unit"], f"interface of {joint['minus']!r} and {joint['plus']!r}"),
            _named(joints, joint["joint_material"], "joint material"),
        )
        for joint in entry.get("explicit", [])
    ]
    return detect_interfaces(blocks, rule, **limits, explicit=explicit)


def _points(values: Any, unit: str, who: str) -> Any:
    """Return points as one quantity; their unit is stated once."""
    return to_quantity(values, "dimensionless") * parse(f"1 {unit}", f"{who}: unit")


def _block_from(entry: dict[str, Any], material: Material) -> Block:
    fixed = entry.get("fixed", False)
    if "box" in entry:
        return Block.box(entry["name"], entry["box"]["origin"], entry["box"]["size"], material, fixed=fixed)
    shape = entry["polyhedron"]
    vertices = _points(shape["vertices"], shape["unit"], f"block {entry['name']!r}")
    return Block.from_faces(entry["name"], vertices, shape["faces"], material, fixed=fixed)


def _tie_from(entry: dict[str, Any]) -> AnyTie:
    arguments = {key: value for key, value in entry.items() if key != "kind"}
    anchors = {end: entry[end] for end in ("start", "end") if isinstance(entry[end], dict)}
    return TIE_KINDS[entry["kind"]](**arguments | {end: _place(a, a["point"]) for end, a in anchors.items()})


def _place(entry: dict[str, Any], value: Any) -> Any:
    """Return the block of an entry and a value, or the value alone."""
    return (entry["block"], value) if "block" in entry else value


def _load_from(entry: dict[str, Any]) -> Any:
    return LOAD_KINDS[entry["kind"]](**{key: value for key, value in entry.items() if key != "kind"})


_CASE_KINDS: dict[str, type[Case]] = {
    "limit": LimitCase,
    "pushover": Pushover,
    "settlement": SettlementCase,
    "record": RecordCase,
}


def _cases(entry: dict[str, Any], patterns: dict[str, LoadPattern]) -> Sequence[Case]:
    """Return the case of an entry, or one case per direction."""
    kind = _CASE_KINDS[entry.get("kind", "limit")]
    roles = [role for role in ("dead", "variable") if role in entry]
    named = {role: _named(patterns, entry[role], f"case {entry['name']!r}: {role} load pattern") for role in roles}
    arguments = {key: value for key, value in (entry | named).items() if key != "kind"}
    if kind is Pushover:
        control = arguments["control"]
        arguments |= {"control": _place(control, control["direction"]), "control_point": control.get("point")}
    if kind is RecordCase:
        who = f"case {entry['name']!r}"
        lists = {key: arguments[key] for key in ("acceleration", "time") if isinstance(arguments[key], dict)}
        arguments |= {key: _points(v["values"], v["unit"], f"{who}: {key}") for key, v in lists.items()}
    return direction_cases(**arguments) if "directions" in arguments else [kind(**arguments)]


def _named(known: dict[str, Any], name: str, kind: str) -> Any:
    if name not in known:
        msg = f"{kind} {name!r} is not in the document; it has {', '.join(known) or 'none'}"
        raise UnknownNameError(msg)
    return known[name]


if TYPE_CHECKING:
    from _typeshed import DataclassInstance


def write_document(
    path: str | Path,
    model: Model,
    cases: Sequence[Case],
    *,
    settings: "Mapping[str, Any] | DataclassInstance | None" = None,
    tolerance: Any = None,
    angle_tolerance: Any = None,
    area_tolerance: Any = None,
) -> Path:
    """Write a model and its cases as a model document, with all digits.

    Parameters
    ----------
    path
        A new file, ``.yaml``, ``.yml`` or ``.json``. JSON is much faster for thousands of blocks.
    model
        Interfaces that :func:`blockstruct.detect_interfaces` finds are not listed. The document lists other interfaces,
        and interfaces with other than the most frequent joint material.
    cases
        At least one case.
    settings
        Settings of the procedure by name, or a :class:`blockstruct.ProcedureSettings`.
    tolerance, angle_tolerance, area_tolerance : quantity
        Tolerances of the detection of the interfaces, if not the defaults.

    Raises
    ------
    ModelError
        If detection finds an interface that the model does not have, because a document cannot exclude it.
    StorageError
        If the file exists or cannot be written.
    """
    check_new_document(path)
    known: dict[frozenset[str], list[Interface]] = {}
    for interface in model.interfaces:
        known.setdefault(frozenset((interface.minus, interface.plus)), []).append(interface)
    (joint, _), *_ = Counter(i.joint_material for i in model.interfaces).most_common()
    detected: dict[frozenset[str], list[Interface]] = {pair: [] for pair in known}
    tolerances = {"tolerance": tolerance, "angle_tolerance": angle_tolerance, "area_tolerance": area_tolerance}
    for interface in detect_interfaces(model.blocks, joint, **_limits(path, **tolerances)).interfaces:
        pair = frozenset((interface.minus, interface.plus))
        if pair not in known:
            msg = (
                f"{path}: model {model.name!r}: detection with this tolerance finds interface {interface.name!r}, "
                "which the model does not have; give the tolerance of its detection, or use save_analysis"
            )
            raise ModelError(msg)
        detected[pair].append(interface)
    explicit = [i for pair, joints in known.items() if not _same(joints, detected[pair]) for i in joints]
    more: dict[str, Any] = {"explicit": explicit, "ties": model.ties, "settings": settings}
    return write_draft(path, model.name, model.blocks, joint, cases, **more, **tolerances)


def _same(known: list[Interface], detected: list[Interface]) -> bool:
    """Whether the interfaces of two blocks are equal to the detected interfaces."""
    return len(known) == len(detected) and all(
        (one.name, one.minus, one.joint_material) == (other.name, other.minus, other.joint_material)
        and one.polygon.shape == other.polygon.shape
        and np.allclose(one.polygon, other.polygon, rtol=0, atol=ROUNDING * np.ptp(one.polygon, axis=0).max())
        for one, other in zip(known, detected, strict=True)
    )


def check_new_document(path: str | Path) -> Path:
    """Return the path of a document that can be written.

    Raises
    ------
    ModelError
        If the name does not end in .yaml, .yml or .json.
    StorageError
        If the file exists.
    """
    path = Path(path)
    if path.suffix.lower() not in (".yaml", ".yml", ".json"):
        msg = f"{path}: not the name of a model document; give a name that ends in .yaml, .yml or .json"
        raise ModelError(msg)
    return check_new(path)


def _limits(
    path: str | Path, tolerance: Any = None, angle_tolerance: Any = None, area_tolerance: Any = None
) -> dict[str, Any]:
    """Return the tolerances of detection that are not the default, as texts."""
    tolerances = (
        ("tolerance", tolerance, "length", "m"),
        ("angle_tolerance", angle_tolerance, "angle", "rad"),
        ("area_tolerance", area_tolerance, "area", "m^2"),
    )
    return {n: f"{si(v, dim, f'{path}: {n}')!r} {unit}" for n, v, dim, unit in tolerances if v is not None}


def write_draft(
    path: str | Path,
    name: str,
    blocks: Sequence[Block],
    joint_material: JointMaterial,
    cases: Sequence[Case],
    *,
    explicit: Sequence[Interface] = (),
    ties: Sequence[AnyTie] = (),
    settings: "Mapping[str, Any] | DataclassInstance | None" = None,
    **tolerances: Any,
) -> Path:
    """Write blocks that are not yet a model, for example without supports, to complete by hand.

    The document lists ``explicit`` interfaces and leaves the others to detection, with ``tolerance``,
    ``angle_tolerance`` and ``area_tolerance``. Other parameters are as for :func:`write_document`.
    """
    path, limits = Path(path), _limits(path, **tolerances)
    check_new_document(path)
    check_unrepeated((case.name for case in cases), f"{path}: case")
    patterns = _by_name([p for case in cases for p in case.patterns], f"{path}: different load patterns")
    materials = _by_name([block.material for block in blocks], f"{path}: different materials")
    joints = _by_name([joint_material, *(i.joint_material for i in explicit)], f"{path}: different joint materials")
    listed = [
        {"name": i.name, "minus": i.minus, "plus": i.plus, "joint_material": i.joint_material.name}
        | {"unit": "m", "polygon": i.polygon.tolist()}
        for i in explicit
    ]
    content: dict[str, Any] = {
        "blockstruct": "model-1",
        "name": name,
        "materials": {n: _entry(m, "name") for n, m in materials.items()},
        "joint_materials": {n: _entry(j, "name") for n, j in joints.items()},
        "interfaces": {"joint_material": joint_material.name, **limits} | ({"explicit": listed} if listed else {}),
        "load_patterns": {n: [{"kind": kind_of(v)} | _entry(v) for v in p.loads] for n, p in patterns.items()},
        "cases": [_case(c) for c in cases],
    }
    if ties:
        content["ties"] = [{"kind": tie_kind_of(t)} | _entry(t) for t in ties]
    if settings:
        content["settings"] = asdict(settings) if is_dataclass(settings) else dict(settings)
    content["blocks"] = [_block(b) for b in blocks]
    check_content(content, "model-1", path)
    return write_new(path, json.dumps(content) + "\n" if path.suffix.lower() == ".json" else yaml_core.dump(content))


def _by_name(items: Sequence[Any], what: str) -> dict[str, Any]:
    named = {item.name: item for item in items}
    if any(named[item.name] != item for item in items):
        msg = f"{what} share a name; rename one"
        raise ModelError(msg)
    return named


def _case(case: Case) -> dict[str, Any]:
    kind = next(name for name, of_case in _CASE_KINDS.items() if of_case is type(case))
    head = {} if kind == "limit" else {"kind": kind}
    entry = head | _entry(case, "control", "control_point", "acceleration", "time")
    if isinstance(case, Pushover):
        block, direction = case.control
        point = {"point": _stated(case.control_point, "length")} if case.control_point else {}
        return entry | {"control": ({"block": block} if block else {}) | {"direction": list(direction)} | point}
    if isinstance(case, RecordCase):
        is_even = isinstance(case.time, float)
        time = _stated(case.time, "time") if is_even else {"unit": "s", "values": list(case.time)}
        return entry | {"acceleration": {"unit": "m/s^2", "values": np.array(case.acceleration).tolist()}, "time": time}
    return entry | {"flow": str(case.flow)}


def _entry(thing: Any, *besides: str) -> dict[str, Any]:
    """Return the fields of an object of a model as a document states them, without those that are left out."""
    values = [(f, getattr(thing, f.name)) for f in attrs.fields(type(thing)) if f.name not in besides]
    return {f.name: _stated(v, f.metadata.get("dimension")) for f, v in values if v != absent_value(f)}


def _stated(value: Any, dimension: str | None) -> Any:
    if isinstance(value, LoadPattern):
        return value.name
    if dimension and is_anchor(value):
        return {"block": value[0], "point": _stated(value[1], dimension)}
    if isinstance(value, tuple):
        return [_stated(v, dimension) for v in value]
    if dimension is None or (dimension == "dimensionless" and math.isfinite(value)):
        return str(value) if isinstance(value, StrEnum) else value
    return si_text(value, dimension).replace("**", "^")


def _block(block: Block) -> dict[str, Any]:
    shape = {
        "unit": "m",
        "vertices": block.shape.vertices.tolist(),
        "faces": [list(face) for face in block.shape.faces],
    }
    fixed = list(block.held) if block.is_roller else block.fixed
    return {"name": block.name, "material": block.material.name, "fixed": fixed, "polyhedron": shape}
