"""Motions of the blocks of a result, its mechanism or its states, moved (OBJ, STL) and animated (GLB, glTF 2.0)."""

import json
import struct
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.arrays import Array, Index
from blockstruct.geometry.screws import screw_motions
from blockstruct.geometry.triangles import triangulated
from blockstruct.units import si
from blockstruct.views.output import target_with, write_bytes, write_text
from blockstruct.views.selection import given_result
from blockstruct.views.solids import Solids
from blockstruct.views.style import AMPLITUDE, DISPLACEMENT, EDGE, SUPPORT

#: Positions of a mechanism in one animation, and duration of an animation, s.
_FRAMES, _DURATION = 24, 4.0
#: A triangle of binary STL: normal, corners, and two bytes without meaning.
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


@dataclass(frozen=True, slots=True)
class Motion:
    """Rigid motion of all blocks.

    Attributes
    ----------
    time : (T,) array
        Increasing, from zero, s.
    position : (T, B, 3) array
        Centroids, m.
    rotation : (T, B, 3, 3) array
        Rotation of each block from its place in the model.
    """

    time: Array
    position: Array
    rotation: Array

    def points(self, solids: Solids, frame: int) -> Array:
        """Return the vertices (V, 3) of the blocks in a frame, m."""
        return self.moved(solids.vertices, solids.block_of_vertex, solids.centroids, frame)

    def moved(self, points: Array, blocks: Index, centroids: Array, frame: int) -> Array:
        """Return points (…, 3) of blocks (…,), m, in a frame."""
        arms = points - centroids[blocks]
        turned = np.einsum("...ij,...j->...i", self.rotation[frame, blocks], arms)
        return np.asarray(self.position[frame, blocks] + turned)


def mechanism_motion(result: bs.CaseResult, amplitude: Any = None, shares: Array | None = None) -> Motion:
    """Return the mechanism of a result: each block moves along the screw of its velocity.

    Parameters
    ----------
    result
        The result of a case.
    amplitude : quantity, length
        Length of the largest path of a centroid. The default is the amplitude of the figures.
    shares : (T,) array
        Shares of the amplitude, one for each frame. By default the blocks move to the amplitude and back.

    Raises
    ------
    ModelError
        If the result has no mechanism.
    UnitError, DimensionError
        If the amplitude is not a length.
    """
    solids = Solids.of(result.model)
    if not result.n_iterations or not np.isfinite(first := solids.displacement(result, -1)).all():
        remedy = "run the case again" if result.response is None else "give a step, a state of the record"
        msg = f"case {result.name!r}: no mechanism, {result.status.words}; {remedy}"
        raise bs.errors.ModelError(msg)
    if amplitude is None:
        factor = AMPLITUDE * solids.size * solids.drawn_share(first)
    else:
        factor = si(amplitude, "length", "export: amplitude")
    if shares is None:
        shares = (1 - np.cos(np.linspace(0, 2 * np.pi, _FRAMES + 1))) / 2
    twist = np.hsplit(factor * bs.results.twists(result.mechanism), 2)
    moved = [screw_motions(*(share * part for part in twist)) for share in shares]
    time = np.linspace(0, _DURATION, len(shares))
    return Motion(time, np.array([solids.centroids + t for _, t in moved]), np.array([R for R, _ in moved]))


def has_states(result: bs.CaseResult) -> bool:
    """Whether a result has the states of a motion: of a pushover, a settlement or a record."""
    return result.capacity is not None or result.response is not None


def motion_of_states(result: bs.CaseResult) -> Motion:
    """Return the states of a motion, those of a record at their times.

    The control point of a pushover and the supports of a settlement move at constant speed.

    Raises
    ------
    ModelError
        If the result has no states.
    """
    curve, response = result.capacity, result.response
    if response is not None:
        rest = np.array([block.centroid for block in result.model.blocks])
        position = rest + response["displacement"].transpose("time", "block", "axis").to_numpy()
        return Motion(response["time"].to_numpy(), position, bs.results.block_rotations(response))
    if curve is None:
        msg = f"case {result.name!r}: no states of a motion; run a Pushover, or export the mechanism"
        raise bs.errors.ModelError(msg)
    way = np.abs(np.diff(curve["displacement"].to_numpy(), prepend=curve["displacement"].to_numpy()[:1])).cumsum()
    # Times increase even between two states of one displacement.
    time = way / (way[-1] or 1.0) + np.arange(len(way)) / (100 * len(way))
    position = curve["position"].transpose("step", "block", "axis").to_numpy()
    return Motion(_DURATION * time / (time[-1] or 1.0), position, bs.results.block_rotations(curve))


def write_moved(result: bs.CaseResult, path: str | Path, *, amplitude: Any = None, step: int | None = None) -> Path:
    """Write the blocks as a mechanism has moved them, or where they are in a state, in m.

    OBJ has an object for each block. STL has the triangles of all blocks in single precision.

    Parameters
    ----------
    result
        The result of a case.
    path
        An ``.obj`` or ``.stl`` file; an existing file is replaced.
    amplitude : quantity, length
        Largest translation of a centroid in the mechanism; ``"0 m"`` for the blocks at rest. The default is the
        amplitude of the figures.
    step
        State of a pushover, settlement or record, instead of the mechanism; −1 is the last.

    Raises
    ------
    ModelError
        If the argument is not a result, has no mechanism, or has no such state.
    StorageError
        If the path ends in another suffix or cannot be written.
    """
    target = target_with(path, ".obj", ".stl")
    given_result(result, "write_moved")
    if step is None:
        motion, frame = mechanism_motion(result, amplitude, np.ones(1)), 0
    else:
        motion, frame = motion_of_states(result), step
        if not -len(motion.time) <= step < len(motion.time):
            msg = f"case {result.name!r}: no state {step}; it has 0 to {len(motion.time) - 1} (-1 is the last)"
            raise bs.errors.ModelError(msg)
    solids = Solids.of(result.model)
    points = motion.points(solids, frame)
    if target.suffix.lower() == ".obj":
        lines = [f"# {result.name}: {result.headline}"]
        start = 0
        for block in result.model.blocks:
            n = len(block.shape.vertices)
            lines.append(f"o {block.name}")
            lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in points[start : start + n].tolist()]
            lines += [f"f {' '.join(str(start + i + 1) for i in face)}" for face in block.shape.faces]
            start += n
        return write_text("\n".join(lines) + "\n", target)
    corners = points[[triangle for loop in solids.loops for triangle in triangulated(points, loop.tolist())]]
    body = np.zeros(len(corners), dtype=_TRIANGLE)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    body["normal"] = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    body["corners"] = corners
    return write_bytes(bytes(80) + np.uint32(len(corners)).tobytes() + body.tobytes(), target)


def write_glb(result: bs.CaseResult, path: str | Path, *, amplitude: Any = None) -> Path:
    """Write an animation of a result: its states if it has some, otherwise its mechanism.

    Each block is a node with its name, and blocks are darker where they move farther. In a mechanism the blocks move
    along their screws to the amplitude and back. An animation takes 4 s, that of a record as long as the motion. Ties
    are not drawn.

    Parameters
    ----------
    result
        The result of a case.
    path
        A ``.glb`` file; an existing file is replaced.
    amplitude : quantity, length
        Largest translation of a centroid in the mechanism. A result with states then shows its mechanism. The
        default is the amplitude of the figures.

    Raises
    ------
    ModelError
        If the argument is not a result, or has no mechanism.
    StorageError
        If the path does not end in ``.glb`` or cannot be written.
    """
    target = target_with(path, ".glb")
    given_result(result, "write_glb")
    moves = has_states(result) and amplitude is None
    motion = motion_of_states(result) if moves else mechanism_motion(result, amplitude)
    return write_bytes(_glb(result, motion, "states" if moves else "mechanism"), target)


class _Code(IntEnum):
    """Codes of glTF 2.0: of the mode of a primitive, and of component types."""

    LINES = 1
    UNSIGNED = 5125
    FLOAT = 5126


class _Buffer:
    """The binary chunk, and the accessors of its arrays."""

    def __init__(self) -> None:
        self.binary = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, array: NDArray[Any], kind: str) -> int:
        """Add an array (n,) or (n, k) of integers or floats, and return the index of its accessor."""
        data = array.astype("<f4" if array.dtype.kind == "f" else "<u4")
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": data.nbytes})
        self.binary += data.tobytes()
        rows = data.reshape(len(data), -1)
        bounds = {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        component = _Code.FLOAT if data.dtype.kind == "f" else _Code.UNSIGNED
        accessor = {"bufferView": len(self.accessors), "componentType": component, "count": len(data), "type": kind}
        self.accessors.append(accessor | bounds)
        return len(self.accessors) - 1


def _glb(result: bs.CaseResult, motion: Motion, name: str) -> bytes:
    """Return the bytes of the file."""
    from scipy.spatial.transform import Rotation

    model, buffer, solids = result.model, _Buffer(), Solids.of(result.model)
    meshes, nodes = list[dict[str, Any]](), list[dict[str, Any]]()
    channels, samplers = list[dict[str, Any]](), list[dict[str, Any]]()
    time = buffer.add(motion.time, "SCALAR")
    for k, block in enumerate(model.blocks):
        shape = block.shape
        triangles = np.concatenate([triangulated(shape.vertices, face) for face in shape.faces])
        ends = {(min(a, b), max(a, b)) for face in shape.faces for a, b in pairwise((*face, face[0]))}
        # Without normals, viewers shade each face flat.
        corners = {"POSITION": buffer.add(shape.vertices - solids.centroids[k], "VEC3")}
        primitive = {"attributes": corners, "indices": buffer.add(triangles.ravel(), "SCALAR"), "material": k}
        lines = {
            "attributes": corners,
            "indices": buffer.add(np.array(sorted(ends)).ravel(), "SCALAR"),
            "material": len(model.blocks),
            "mode": _Code.LINES,
        }
        meshes.append({"name": block.name, "primitives": [primitive, lines]})
        nodes.append({"name": block.name, "mesh": k, "translation": motion.position[0, k].tolist()})
        for way, values, kind in (
            ("translation", motion.position[:, k], "VEC3"),
            ("rotation", Rotation.from_matrix(motion.rotation[:, k]).as_quat(), "VEC4"),
        ):
            if np.ptp(values, axis=0).any():
                channels.append({"sampler": len(samplers), "target": {"node": k, "path": way}})
                samplers.append({"input": time, "output": buffer.add(values, kind), "interpolation": "LINEAR"})
    # In glTF y points up.
    turn = [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
    nodes.append({"name": model.name, "rotation": turn, "children": list(range(len(model.blocks)))})
    content: dict[str, Any] = {
        "asset": {
            "version": "2.0",
            "generator": f"blockstruct {bs.__version__}",
            "extras": {"case": result.name, "result": str(result.headline)},
        },
        "scene": 0,
        "scenes": [{"nodes": [len(nodes) - 1]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": [*colour, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9}}
            for colour in [*_colours(model, motion), _linear(EDGE)]
        ],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.binary)}],
    }
    if channels:
        content["animations"] = [{"name": f"{name} of {result.name}", "channels": channels, "samplers": samplers}]
    text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    chunks = [(b"JSON", text), (b"BIN\0", bytes(buffer.binary))]
    body = b"".join(struct.pack("<I", len(data)) + kind + data for kind, data in chunks)
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def _colours(model: bs.Model, motion: Motion) -> list[list[float]]:
    """Return the linear colour of each block, by its largest displacement; supports have their own."""
    way = np.linalg.norm(motion.position - motion.position[0], axis=2).max(axis=0)
    known = np.array([_linear(colour) for colour in DISPLACEMENT])
    at = np.linspace(0, way.max() or 1.0, len(known))
    colours = np.stack([np.interp(way, at, channel) for channel in known.T], axis=1)
    colours[[b.fixed for b in model.blocks]] = _linear(SUPPORT)
    listed: list[list[float]] = colours.tolist()
    return listed


def _linear(colour: str) -> list[float]:
    """Return a colour ``#rrggbb`` in linear light, as glTF needs it (sRGB, IEC 61966-2-1)."""
    value = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    light: list[float] = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).tolist()
    return light
