"""Assemblies for COMPAS: blocks, contact polygons, forces and mechanism as JSON."""

import json
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np

import blockstruct as bs
from blockstruct.arrays import Array
from blockstruct.views.output import target_with, write_text
from blockstruct.views.selection import chosen_iteration, given_result


def write_assembly(result: bs.CaseResult, path: str | Path, *, iteration: int = -1) -> Path:
    """Write a ``compas_assembly`` Assembly, which ``compas.json_load`` reads and COMPAS CRA uses.

    Lengths are in m, forces in N. Each node has a ``block``, ``is_support``, its ``name``, and ``displacement``: the
    translation of the centroid and the rotation vector of the mechanism, whose largest translation is 1. Each edge
    runs from the minus to the plus block of its ``interfaces``. An interface has its ``name``, contact points,
    ``frame`` with the normal as z axis, and ``forces`` at these points, on the plus block: ``c_np`` is compression,
    ``c_nn`` tension, ``c_u`` and ``c_v`` shear along the x and y axes.

    Parameters
    ----------
    result
        The result of a case.
    path
        A ``.json`` file; an existing file is replaced.
    iteration
        Index of the iteration; −1 is the last.

    Raises
    ------
    ModelError
        If the argument is not a result, or has no iterations.
    StorageError
        If the path does not end in ``.json`` or cannot be written.
    """
    target = target_with(path, ".json")
    model, index = result.model, chosen_iteration(given_result(result, "write_assembly"), iteration)
    history = result.history.isel(iteration=[index])
    moves = bs.results.twists(bs.results.mechanism(history))
    nodes = {
        str(k): {
            **dict(zip("xyz", block.centroid.tolist(), strict=True)),
            "block": _typed("compas_assembly.datastructures/Block", _mesh(block), ["compas.datastructures/Mesh"]),
            "name": block.name,
            "is_support": block.fixed,
            "held": list(block.held),
            "displacement": moves[k].tolist(),
        }
        for k, block in enumerate(model.blocks)
    }
    edges: dict[str, dict[str, Any]] = {key: {} for key in nodes}
    force = history["contact_force"].isel(iteration=0).transpose("contact_point", "component").to_numpy()
    position, of = history["contact_point_position"].to_numpy(), history["interface_of_contact_point"].to_numpy()
    frames = history["interface_frame"].to_numpy()
    for j, interface in enumerate(model.interfaces):
        at = np.flatnonzero(of == j)
        minus, plus = (str(model.block_index[name]) for name in (interface.minus, interface.plus))
        edge = edges[minus].setdefault(plus, {"interfaces": []})
        edge["interfaces"].append(_interface(interface, position[at], force[at], frames[j]))
    graph = {
        "attributes": {},
        "default_node_attributes": {
            **{"x": 0.0, "y": 0.0, "z": 0.0, "block": None, "is_support": False, "section": None, "mesh_size": None},
            "displacement": [0, 0, 0, 0, 0, 0],
        },
        "default_edge_attributes": {"interfaces": None},
        "node": nodes,
        "edge": edges,
        "max_node": len(nodes) - 1,
    }
    attributes = {"name": model.name, "case": result.name, "result": str(result.headline)}
    data = {"attributes": attributes, "graph": _typed("compas.datastructures/Graph", graph)}
    content = _typed("compas_assembly.datastructures/Assembly", data)
    return write_text(json.dumps(content, allow_nan=False), target)


def _typed(kind: str, data: Any, inheritance: list[str] | None = None) -> dict[str, Any]:
    return {"dtype": kind, "data": data, "inheritance": inheritance or [], "guid": str(uuid4())}


def _mesh(block: bs.Block) -> dict[str, Any]:
    vertices, faces = block.shape.vertices.tolist(), block.shape.faces
    return {
        "attributes": {"name": block.name},
        "default_vertex_attributes": {"x": 0.0, "y": 0.0, "z": 0.0},
        "default_edge_attributes": {},
        "default_face_attributes": {},
        "vertex": {str(i): dict(zip("xyz", point, strict=True)) for i, point in enumerate(vertices)},
        "face": {str(i): [int(corner) for corner in face] for i, face in enumerate(faces)},
        "facedata": {},
        "edgedata": {},
        "max_vertex": len(vertices) - 1,
        "max_face": len(faces) - 1,
    }


def _interface(interface: bs.Interface, position: Array, force: Array, frame: Array) -> dict[str, Any]:
    n, s, t = force.T.tolist()
    forces = [{"c_np": max(a, 0.0), "c_nn": max(-a, 0.0), "c_u": b, "c_v": c} for a, b, c in zip(n, s, t, strict=True)]
    place = {"point": interface.centroid.tolist(), "xaxis": frame[1].tolist(), "yaxis": frame[2].tolist()}
    data = {
        "points": position.tolist(),
        "size": interface.area,
        "frame": _typed("compas.geometry/Frame", place),
        "forces": forces,
        "mesh": None,
    }
    return {**_typed("compas_assembly.datastructures/Interface", data), "name": interface.name}
