"""Model documents written: the inverse of reading them."""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from blockstruct.builders.detection import detect_interfaces
from blockstruct.builders.source import write_new
from blockstruct.errors import DocumentError, ModelError
from blockstruct.model import (
    Block,
    BodyForce,
    FaceLoad,
    JointMaterial,
    LimitCase,
    LoadPattern,
    Model,
    Moment,
    PointLoad,
)
from blockstruct.schema import listed_violations, violations
from blockstruct.units import si

#: Agreement of interfaces found again with those of the model.
_SAME_AREA = 1e-9


def write_document(
    path: str | Path,
    model: Model,
    cases: Sequence[LimitCase],
    *,
    settings: Mapping[str, Any] | None = None,
    tolerance: Any = None,
) -> Path:
    """Write a model and its cases as a model document, to the last digit.

    Parameters
    ----------
    path
        A new file, ``.yaml``, ``.yml`` or ``.json``; JSON is much faster from thousands of blocks on.
    model
        A document states no interfaces but how to find them: the model must have those that
        :func:`blockstruct.detect_interfaces` finds.
    cases
        At least one.
    settings
        Settings of the procedure by name.
    tolerance : quantity, length
        With which the interfaces of the model were found, if not by default.

    Raises
    ------
    ModelError
        Interfaces that detection does not give, or are of several joint materials; no case.
    StorageError
        A file that exists or cannot be written.
    """
    who = f"{path}: model {model.name!r}"
    if len(model.joint_materials) != 1:
        msg = (
            f"{who} has {len(model.joint_materials)} joint materials, a document has room for one; "
            "keep the model with save_analysis, or give all interfaces one joint material"
        )
        raise ModelError(msg)
    (joint,) = model.joint_materials.values()
    found = {i.name: i for i in detect_interfaces(model.blocks, joint, tolerance).interfaces}
    own = {i.name: i for i in model.interfaces}
    changed = [
        name
        for name in sorted(found.keys() | own.keys())
        if name not in found
        or name not in own
        or not math.isclose(found[name].area, own[name].area, rel_tol=_SAME_AREA)
    ]
    if changed:
        msg = (
            f"{who}: detection with this tolerance does not give its interface {changed[0]!r} ({len(changed)} differ); "
            "give the tolerance they were found with; interfaces of your own have no place in a document, "
            "save_analysis keeps them"
        )
        raise ModelError(msg)
    return write_draft(path, model.name, model.blocks, joint, cases, settings=settings, tolerance=tolerance)


def write_draft(
    path: str | Path,
    name: str,
    blocks: Iterable[Block],
    joint_material: JointMaterial,
    cases: Sequence[LimitCase],
    *,
    settings: Mapping[str, Any] | None = None,
    tolerance: Any = None,
) -> Path:
    """Write blocks that may be no model yet, without supports for instance, as a document to be completed by hand.

    Parameters and errors are those of :func:`write_document`.
    """
    path = Path(path)
    if path.suffix.lower() not in (".yaml", ".yml", ".json"):
        msg = f"{path}: no name of a model document; give one that ends in .yaml, .yml or .json"
        raise ModelError(msg)
    blocks = list(blocks)
    patterns = {p.name: p for case in cases for p in (case.dead, case.variable)}
    if any(patterns[p.name] != p for case in cases for p in (case.dead, case.variable)):
        msg = f"{path}: different load patterns share a name; rename one"
        raise ModelError(msg)
    materials = {b.material.name: b.material for b in blocks}
    if any(materials[b.material.name] != b.material for b in blocks):
        msg = f"{path}: different materials share a name; rename one"
        raise ModelError(msg)
    detection: dict[str, Any] = {"joint_material": joint_material.name}
    if tolerance is not None:
        detection["tolerance"] = f"{si(tolerance, 'length', f'{path}: tolerance')!r} m"
    content: dict[str, Any] = {
        "blockstruct": "model-1",
        "name": name,
        "materials": {n: {"unit_weight": f"{m.unit_weight!r} N/m^3"} for n, m in materials.items()},
        "joint_materials": {joint_material.name: _joint(joint_material)},
        "interfaces": detection,
        "load_patterns": {p.name: _loads(p) for p in patterns.values()},
        "cases": [
            {"name": c.name, "dead": c.dead.name, "variable": c.variable.name, "flow": str(c.flow)} for c in cases
        ],
    }
    if settings:
        content["settings"] = dict(settings)
    content["blocks"] = [_block(b) for b in blocks]
    found = violations(content, "model-1")
    if found:
        msg = f"{path}: {listed_violations(found)}"
        raise DocumentError(msg)
    return write_new(path, json.dumps(content) + "\n" if path.suffix.lower() == ".json" else _yaml(content))


def _yaml(content: Any) -> str:
    dumper = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
    # Collections without collections inside on one line: a vertex, a face, a vector.
    text: str = yaml.dump(
        content, Dumper=dumper, sort_keys=False, default_flow_style=None, width=120, allow_unicode=True
    )
    return text


def _joint(joint: JointMaterial) -> dict[str, Any]:
    values: dict[str, Any] = {"friction_coefficient": joint.friction_coefficient}
    if joint.dilatancy_angle:
        values["dilatancy_angle"] = f"{joint.dilatancy_angle!r} rad"
    for strength in ("cohesion", "tensile_strength", "compressive_strength"):
        value = getattr(joint, strength)
        if value and math.isfinite(value):
            values[strength] = f"{value!r} Pa"
    return values


def _block(block: Block) -> dict[str, Any]:
    shape = {
        "unit": "m",
        "vertices": block.shape.vertices.tolist(),
        "faces": [list(face) for face in block.shape.faces],
    }
    return {"name": block.name, "material": block.material.name, "fixed": block.fixed, "polyhedron": shape}


def _loads(pattern: LoadPattern) -> list[dict[str, Any]]:
    entries: list[dict[str, Any]] = []
    for load in pattern.loads:
        match load:
            case BodyForce(direction=direction):
                entries.append({"kind": "body_force", "direction": list(direction)})
            case PointLoad(block=block, point=point, force=force):
                entries.append(
                    {"kind": "point_load", "block": block, "point": _texts(point, "m"), "force": _texts(force, "N")}
                )
            case FaceLoad(block=block, face=face, traction=traction):
                entries.append({"kind": "face_load", "block": block, "face": face, "traction": _texts(traction, "Pa")})
            case Moment(block=block, moment=moment):
                entries.append({"kind": "moment", "block": block, "moment": _texts(moment, "N*m")})
            case _:
                entries.append({"kind": "self_weight"})
    return entries


def _texts(vector: Sequence[float], unit: str) -> list[str]:
    return [f"{v!r} {unit}" for v in vector]
