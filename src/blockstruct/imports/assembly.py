"""Blocks from COMPAS: assemblies, block models and lists of meshes as JSON."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from blockstruct.arrays import Array
from blockstruct.errors import GeometryFileError, shown
from blockstruct.files import unique_pairs
from blockstruct.geometry.polygon import Face
from blockstruct.imports.solid import Content, Solid, make_blocks
from blockstruct.imports.source import Imported, checked_faces, read_number, read_text, read_whole
from blockstruct.model import Material
from blockstruct.units import QuantityLike
from blockstruct.vocabulary import counted

#: Keys of the solid in a node or an element, and of the contacts in an edge.
_SOLIDS = ("block", "part", "geometry", "mesh", "shape")
_CONTACTS = ("interfaces", "interface", "contacts", "interface_points")
#: Frame of an element whose geometry is in global coordinates.
_WORLD = {"point": [0, 0, 0], "xaxis": [1, 0, 0], "yaxis": [0, 1, 0]}


@dataclass(frozen=True, slots=True)
class _Part:
    key: str
    name: str | None
    vertices: Array
    faces: list[Face]
    support: bool


def read_assembly(
    file: str | Path,
    *,
    unit: QuantityLike,
    material: Material,
    fixed: str | Iterable[str] = (),
    exclude: Iterable[str] = (),
    up: str = "z",
    tolerance: QuantityLike | None = None,
) -> Imported:
    """Read the blocks of a COMPAS JSON file.

    The file is an assembly (compas, compas_assembly, compas_cra of all versions: a graph with blocks in its nodes), a
    model (compas_model, compas_dem: elements with a geometry), a mesh or a list of meshes. A model is refused if only
    COMPAS can compute its geometry: with features, modifiers, frames, or transformations within groups. Blocks keep
    their names if all names differ. Otherwise the name is the key of the node or a running number. Blocks with
    ``is_support`` true or 1 are fixed. Interfaces in the file are ignored; detect them again.

    Parameters
    ----------
    file
        A ``.json`` file.
    unit : text or quantity, length
        Unit of the coordinates; the file does not contain it.
    material
        Material of all blocks.
    fixed, exclude, up, tolerance
        As for :func:`read_mesh`; ``fixed`` adds to the supports of the file.

    Returns
    -------
    Imported
        ``.blocks`` and ``.report``.

    Raises
    ------
    StorageError
        If the file cannot be read.
    GeometryFileError
        If the file is of another kind, ``is_support`` is neither true nor false, or solids are not blocks.

    Warns
    -----
    GeometryWarning
        If something was ignored or repaired.
    """
    path = Path(file)
    contents = [assembly_content(path, material)]
    return make_blocks(contents, [path], unit=unit, fixed=fixed, exclude=exclude, up=up, tolerance=tolerance)


def assembly_content(path: Path, material: Material) -> Content:
    """Return the content of a COMPAS JSON file."""
    try:
        content = json.loads(read_text(path), object_pairs_hook=unique_pairs)
    except (ValueError, RecursionError) as error:
        msg = f"{path}: not valid JSON ({error}); export it again with compas.json_dump"
        raise GeometryFileError(msg) from error
    left_out: list[str] = []
    try:
        parts = list(_parts(content, path, left_out))
    except GeometryFileError:
        raise
    except (AttributeError, KeyError, RecursionError, TypeError, ValueError) as error:
        # The layout differs from the detected layout.
        raise GeometryFileError(_unknown(path, content)) from error
    checked_faces(sum(len(p.faces) for p in parts), path)
    names = [p.name for p in parts]
    unique = None not in names and len(set(names)) == len(names)
    solids = [Solid(str(p.name if unique else p.key), p.vertices, p.faces, material, p.support) for p in parts]
    return Content(solids, left_out)


def _parts(content: Any, path: Path, left_out: list[str]) -> Iterator[_Part]:
    """Yield the parts of a file in any layout."""
    body = _body(content)
    if isinstance(body, list):
        for number, mesh in enumerate(_flat(body)):
            data = _body(mesh)
            # An element has its name and marks next to its geometry.
            element = isinstance(data, dict) and bool(data.keys() & set(_SOLIDS))
            yield from _part(str(number), mesh, {**(data.get("attributes") or {}), **data} if element else {}, path)
    elif not isinstance(body, dict):
        raise GeometryFileError(_unknown(path, body))
    elif "elements" in body:
        yield from _elements(body, path, left_out)
    elif isinstance(body.get("blocks"), dict):
        # First versions: blocks, and a network whose vertices mark the supports.
        nodes = _body(body.get("assembly") or {}).get("vertex", {})
        for key, mesh in body["blocks"].items():
            yield from _part(key, mesh, nodes.get(key, {}), path)
    elif "graph" in body or "node" in body:
        yield from _nodes(_body(body.get("graph", body)), path, left_out)
    elif "vertex" in body or "vertices" in body:
        yield from _part("0", body, {}, path)
    else:
        raise GeometryFileError(_unknown(path, body))


def _nodes(graph: Any, path: Path, left_out: list[str]) -> Iterator[_Part]:
    """Yield the parts of an assembly, one per node."""
    if not isinstance(graph, dict) or not isinstance(graph.get("node"), dict):
        raise GeometryFileError(_unknown(path, graph))
    default = graph.get("default_node_attributes") or graph.get("dna") or {}
    for key, node in graph["node"].items():
        solid = next((node[k] for k in _SOLIDS if isinstance(node, dict) and node.get(k)), None)
        if solid is None:
            msg = f"{path}: node {key} has no block ({', '.join(_SOLIDS)}); give an assembly with blocks in its nodes"
            raise GeometryFileError(msg)
        yield from _part(key, solid, {**default, **node}, path)
    _note_contacts(graph, left_out)


def _elements(model: dict[str, Any], path: Path, left_out: list[str]) -> Iterator[_Part]:
    """Yield the parts of a model, one per element."""
    elements = model["elements"]
    whole = _matrix(model.get("transformation"), path)
    tree = model.get("tree") or {}
    grouped = any(child.get("children") for child in (tree.get("root") or {}).get("children", []))
    for number, element in enumerate(elements.values() if isinstance(elements, dict) else elements):
        data = _body(element)
        if not isinstance(data, dict):
            raise GeometryFileError(_unknown(path, data))
        local = _matrix(data.get("transformation"), path)
        obstacle = ""
        if data.get("features"):
            obstacle = "features"
        elif data.get("frame") and _body(data["frame"]) != _WORLD:
            obstacle = "a frame of its own"
        elif grouped and not np.array_equal(local, np.eye(4)):
            obstacle = "a transformation inside a group"
        if obstacle:
            msg = f"{path}: element {number} has {obstacle}, which only COMPAS can apply; export its final geometry"
            raise GeometryFileError(msg)
        if str(element.get("dtype", "")).endswith("/Group"):
            continue
        for part in _part(str(number), data.get("geometry") or data, data, path):
            moved = np.column_stack([part.vertices, np.ones(len(part.vertices))]) @ (whole @ local).T
            yield _Part(part.key, part.name, moved[:, :3], part.faces, part.support)
    graph = _body(model.get("graph") or {})
    if any(edge.get("modifiers") for edge in _edges(graph)):
        msg = (
            f"{path}: some elements modify others (such as a boolean difference), which only COMPAS can apply; export "
            "their final geometry"
        )
        raise GeometryFileError(msg)
    _note_contacts(graph, left_out)


def _part(key: str, solid: Any, attributes: dict[str, Any], path: Path) -> Iterator[_Part]:
    """Yield the parts of a solid or a list of solids: meshes with keyed vertices and faces, or polyhedra of lists."""
    outer, body = solid, _body(solid)
    while isinstance(body, dict) and (inner := next((body[k] for k in _SOLIDS if body.get(k)), None)) is not None:
        outer, body = inner, _body(inner)
    name = next((n for n in (attributes.get("name"), _name(outer), _name(solid)) if isinstance(n, str) and n), None)
    if isinstance(body, list):
        members = list(_flat(body))
        for k, member in enumerate(members, start=1):
            end = f".{k}" if len(members) > 1 else ""
            yield from _part(f"{key}{end}", member, {**attributes, "name": name and f"{name}{end}"}, path)
        return
    try:
        if "vertex" in body:
            default = body.get("default_vertex_attributes") or body.get("dva") or {}
            number = {str(name): i for i, name in enumerate(body["vertex"])}
            rows = [[{**default, **v}[axis] for axis in "xyz"] for v in body["vertex"].values()]
            faces = [tuple(number[str(i)] for i in face) for face in body["face"].values()]
        else:
            rows = [_body(v) for v in body["vertices"]]
            faces = [tuple(read_whole(repr(i)) for i in face) for face in body["faces"]]
        vertices = _numbers(rows).reshape(len(rows), 3)
        if not faces or min(map(len, faces)) < 3:
            msg = "a face of fewer than three corners"
            raise ValueError(msg)
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        msg = (
            f"{path}: block {key} has no readable mesh ({type(error).__name__}: {error}); give vertices with "
            "x, y, z and faces of their keys, as compas.json_dump writes them"
        )
        raise GeometryFileError(msg) from error
    marks = {**(body.get("attributes") or {}), **attributes}
    yield _Part(str(key), name, vertices, faces, _support(marks.get("is_support"), str(key), path))


def _support(mark: Any, key: str, path: Path) -> bool:
    """Return whether the mark of a block makes it a support. A block without a mark is free."""
    # Some programs write 0 and 1 for false and true.
    if mark is None or (isinstance(mark, bool | int) and mark in (0, 1)):
        return bool(mark)
    msg = f"{path}: block {key}: is_support is {shown(mark)}; give true or false"
    raise GeometryFileError(msg)


def _name(solid: Any) -> Any:
    if not isinstance(solid, dict):
        return None
    attributes = (_body(solid) or {}).get("attributes") or {}
    return solid.get("name") or attributes.get("name")


def _body(item: Any) -> Any:
    """Return an item without the wrappers that state its type and version."""
    while isinstance(item, dict) and (item.keys() & {"dtype", "datatype"} or item.keys() <= {"data", "guid", "compas"}):
        inner = item.get("data", item.get("value"))
        if inner is None:
            break
        item = inner
    return item


def _flat(items: list[Any]) -> Iterator[Any]:
    for item in items:
        if isinstance(item, list):
            yield from _flat(item)
        else:
            yield item


def _matrix(transformation: Any, path: Path) -> Array:
    if not transformation:
        return np.eye(4)
    body = _body(transformation)
    try:
        matrix = _numbers(body["matrix"] if isinstance(body, dict) else body).reshape(4, 4)
    except (KeyError, TypeError, ValueError) as error:
        msg = f"{path}: a transformation is not a matrix of 4 × 4 numbers; export the model again with compas.json_dump"
        raise GeometryFileError(msg) from error
    return matrix


def _numbers(rows: Any) -> Array:
    """Return rows of JSON numbers as an array: the text of true, or of a text, is not a number."""
    return np.array([[read_number(repr(value)) for value in row] for row in rows])


def _edges(graph: Any) -> Iterator[dict[str, Any]]:
    """Yield the data of each edge of a graph."""
    edges = graph.get("edge") or {} if isinstance(graph, dict) else {}
    yield from (e for ends in edges.values() for e in ends.values() if isinstance(e, dict))


def _note_contacts(graph: Any, left_out: list[str]) -> None:
    count = sum(any(edge.get(k) for k in _CONTACTS) for edge in _edges(graph))
    if count:
        left_out.append(f"the interfaces of {counted(count, 'pair of blocks', 'pairs of blocks')}, to be detected anew")


def _unknown(path: Path, body: Any) -> str:
    keys = ", ".join(sorted(map(str, body))[:8]) if isinstance(body, dict) else type(body).__name__
    return (
        f"{path}: not a COMPAS assembly, model or list of meshes (found {keys or 'nothing'}); "
        "write one with compas.json_dump(assembly, file)"
    )
