"""Read model documents: a structure, its loads and its cases as YAML or JSON."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from blockstruct.contacts.detection import detect_interfaces
from blockstruct.documents import yaml_core
from blockstruct.errors import BlockstructError, DocumentError, StorageError, UnknownNameError
from blockstruct.files import read_file, unique_pairs
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
)
from blockstruct.schema import listed_violations, violations
from blockstruct.structures import Buttress, Opening, RoundOpening, Rubble, Sidewall, room, wall
from blockstruct.structures.courses import courses
from blockstruct.units import parse, to_quantity
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
        blocks.append(_block(entry, _named(materials, entry["material"], "material")))
    detection = _detection(blocks, content["interfaces"], joints)
    ties = [_tie(entry) for entry in content.get("ties", [])]
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


def _block(entry: dict[str, Any], material: Material) -> Block:
    fixed = entry.get("fixed", False)
    if "box" in entry:
        return Block.box(entry["name"], entry["box"]["origin"], entry["box"]["size"], material, fixed=fixed)
    shape = entry["polyhedron"]
    vertices = _points(shape["vertices"], shape["unit"], f"block {entry['name']!r}")
    return Block.from_faces(entry["name"], vertices, shape["faces"], material, fixed=fixed)


def _tie(entry: dict[str, Any]) -> AnyTie:
    kind = TIE_KINDS[entry["kind"]]
    arguments = {key: value for key, value in entry.items() if key != "kind"}
    if kind.anchored:
        arguments |= {end: _place(entry[end], entry[end]["point"]) for end in ("start", "end")}
    return kind.type(**arguments)


def _place(entry: dict[str, Any], value: Any) -> Any:
    """Return the block of an entry and a value, or the value alone."""
    return (entry["block"], value) if "block" in entry else value


def _load_from(entry: dict[str, Any]) -> Any:
    return LOAD_KINDS[entry["kind"]].type(**{key: value for key, value in entry.items() if key != "kind"})


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
