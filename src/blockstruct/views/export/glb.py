"""Animated GLB files (glTF 2.0) for Blender, browsers and other viewers."""

import json
import struct
from enum import IntEnum
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import blockstruct as bs
from blockstruct.geometry.triangles import triangulated
from blockstruct.views.export.motion import Motion, mechanism_motion, pushover_motion
from blockstruct.views.output import target_with, write_bytes
from blockstruct.views.selection import given_result
from blockstruct.views.solids import Solids
from blockstruct.views.style import DISPLACEMENT, EDGE, SUPPORT

Array = NDArray[np.float64]

#: Number of colours for displacements.
_SHADES = 32


def write_glb(result: bs.CaseResult, path: str | Path, *, amplitude: Any = None) -> Path:
    """Write an animation of a result: its pushover if it has one, otherwise its mechanism.

    Each block is a node with its name, and blocks are darker where they move farther. In a mechanism the blocks move
    along their screws to the amplitude and back in 4 s. A pushover takes 8 s. Ties are not drawn.

    Parameters
    ----------
    result
        The result of a case.
    path
        A ``.glb`` file; an existing file is replaced.
    amplitude : quantity, length
        Largest translation of a centroid in the mechanism. A result with a pushover then shows its mechanism. The
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
    pushed = result.capacity is not None and amplitude is None
    motion = pushover_motion(result) if pushed else mechanism_motion(result, amplitude)
    return write_bytes(_glb(result, motion, "pushover" if pushed else "mechanism"), target)


class _Code(IntEnum):
    """Codes of glTF 2.0: of the mode of a primitive, of component types, and of targets."""

    LINES = 1
    UNSIGNED = 5125
    FLOAT = 5126
    VERTICES = 34962
    INDICES = 34963


class _Buffer:
    """The binary chunk, and the accessors of its arrays."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, array: NDArray[Any], kind: str, target: int | None = None) -> int:
        """Add an array (n,) or (n, k), and return the index of its accessor."""
        whole = kind == "SCALAR" and target == _Code.INDICES
        data = array.astype("<u4" if whole else "<f4")
        start = sum(view["byteLength"] for view in self.views)
        view = {"buffer": 0, "byteOffset": start, "byteLength": data.nbytes}
        self.views.append(view if target is None else {**view, "target": target})
        self.parts.append(data.tobytes())
        rows = data.reshape(len(data), -1)
        bounds = {} if whole else {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        component = _Code.UNSIGNED if whole else _Code.FLOAT
        self.accessors.append(
            {"bufferView": len(self.views) - 1, "componentType": component, "count": len(data), "type": kind, **bounds}
        )
        return len(self.accessors) - 1


def _glb(result: bs.CaseResult, motion: Motion, name: str) -> bytes:
    """Return the bytes of the file."""
    model, buffer, solids = result.model, _Buffer(), Solids.of(result.model)
    shade = _shades(model, motion)
    meshes, nodes = list[dict[str, Any]](), list[dict[str, Any]]()
    channels, samplers = list[dict[str, Any]](), list[dict[str, Any]]()
    time = buffer.add(motion.time, "SCALAR")
    quaternions = _quaternions(motion.rotation)
    for k, block in enumerate(model.blocks):
        points, normals, triangles = _flat_faces(block)
        primitive = {
            "attributes": {
                "POSITION": buffer.add(points - solids.centroids[k], "VEC3", _Code.VERTICES),
                "NORMAL": buffer.add(normals, "VEC3", _Code.VERTICES),
            },
            "indices": buffer.add(triangles.ravel(), "SCALAR", _Code.INDICES),
            "material": int(shade[k]),
        }
        shape = block.shape
        ends = {(min(a, b), max(a, b)) for face in shape.faces for a, b in pairwise((*face, face[0]))}
        lines = {
            "attributes": {"POSITION": buffer.add(shape.vertices - solids.centroids[k], "VEC3", _Code.VERTICES)},
            "indices": buffer.add(np.array(sorted(ends)).ravel(), "SCALAR", _Code.INDICES),
            "material": _SHADES + 1,
            "mode": _Code.LINES,
        }
        meshes.append({"name": block.name, "primitives": [primitive, lines]})
        nodes.append({"name": block.name, "mesh": k, "translation": motion.position[0, k].tolist()})
        for way, values, kind in (
            ("translation", motion.position[:, k], "VEC3"),
            ("rotation", quaternions[:, k], "VEC4"),
        ):
            if np.ptp(values, axis=0).any():
                channels.append({"sampler": len(samplers), "target": {"node": k, "path": way}})
                samplers.append({"input": time, "output": buffer.add(values, kind), "interpolation": "LINEAR"})
    # In glTF y points up.
    turn = [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
    nodes.append({"name": model.name, "rotation": turn, "children": list(range(len(model.blocks)))})
    binary = b"".join(buffer.parts)
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
            for colour in [*_colours(np.linspace(0, 1, _SHADES)), _linear(SUPPORT), _linear(EDGE)]
        ],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(binary)}],
    }
    if channels:
        content["animations"] = [{"name": f"{name} of {result.name}", "channels": channels, "samplers": samplers}]
    text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    chunks = [(b"JSON", text), (b"BIN\0", binary)]
    body = b"".join(struct.pack("<I", len(data)) + kind + data for kind, data in chunks)
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def _flat_faces(block: bs.Block) -> tuple[Array, Array, NDArray[np.int64]]:
    """Return corners, normals and triangles of a block, where no two faces share a corner."""
    shape = block.shape
    corners = np.concatenate([list(face) for face in shape.faces])
    starts = np.cumsum([0, *(len(face) for face in shape.faces)])
    triangles = [
        start + np.array(triangulated(shape.vertices[list(face)], range(len(face))))
        for start, face in zip(starts, shape.faces, strict=False)
    ]
    normals = np.repeat(shape.normals, np.diff(starts), axis=0)
    return shape.vertices[corners], normals, np.concatenate(triangles)


def _shades(model: bs.Model, motion: Motion) -> NDArray[np.int64]:
    """Return the material (B,) of each block: its largest displacement, or the colour of supports."""
    way = np.linalg.norm(motion.position - motion.position[0], axis=2).max(axis=0)
    shade = np.round((_SHADES - 1) * way / (way.max() or 1.0)).astype(np.int64)
    return np.where([b.fixed for b in model.blocks], _SHADES, shade)


def _colours(shares: Array) -> list[list[float]]:
    """Return linear colours of shares of the largest displacement."""
    known = np.array([_linear(colour) for colour in DISPLACEMENT])
    at = np.linspace(0, 1, len(known))
    colours: list[list[float]] = np.stack([np.interp(shares, at, channel) for channel in known.T], axis=1).tolist()
    return colours


def _linear(colour: str) -> list[float]:
    """Return a colour ``#rrggbb`` in linear light, as glTF needs it (sRGB, IEC 61966-2-1)."""
    value = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    light: list[float] = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).tolist()
    return light


def _quaternions(rotation: Array) -> Array:
    """Return quaternions (T, B, 4) x, y, z, w of rotations, each nearest to the one before."""
    from scipy.spatial.transform import Rotation

    T, B = rotation.shape[:2]
    quaternions = Rotation.from_matrix(rotation.reshape(-1, 3, 3)).as_quat().reshape(T, B, 4)
    turned = np.einsum("tbk,tbk->tb", quaternions[1:], quaternions[:-1]) < 0
    sign = np.where(np.cumsum(turned, axis=0) % 2, -1.0, 1.0)
    quaternions[1:] *= sign[:, :, None]
    return np.asarray(quaternions)
