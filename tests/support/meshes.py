"""Small meshes that tests vary: texts and bytes of files, as other programs write them."""

import struct
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

import blockstruct as bs
from structures import STONE

CUBE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
QUADS = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]


def saved(folder: Path, name: str, content: str | bytes) -> Path:
    """Path of a new file."""
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def read(folder: Path, name: str, content: str | bytes, **options: object) -> bs.imports.Imported:
    """Blocks of a mesh in m, of stone."""
    return bs.imports.read_mesh(saved(folder, name, content), **{"unit": "m", "material": STONE} | options)


def obj_text(vertices: Iterable[Sequence[float]] = CUBE, faces: Iterable[Sequence[int]] = QUADS) -> str:
    """An OBJ file of one body."""
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + ["f " + " ".join(str(i + 1) for i in f) for f in faces]
    return "\n".join(lines) + "\n"


def objects_text(bodies: dict[str, Iterable[Sequence[float]]], faces: Iterable[Sequence[int]] = QUADS) -> str:
    """An OBJ file of named bodies of eight corners, with vertices counted from the end of the file."""
    return "".join(
        f"o {name}\n" + obj_text(points, [[i - 9 for i in f] for f in faces]) for name, points in bodies.items()
    )


def fans(faces: Iterable[Sequence[int]]) -> list[tuple[int, int, int]]:
    """Triangles of convex polygons."""
    return [(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)]


def stl_bytes(blocks: Iterable[bs.Block]) -> bytes:
    """A binary STL file of all blocks, one after the other."""
    triangles = [b.shape.vertices[list(t)] for b in blocks for t in fans(b.shape.faces)]
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(t).tolist(), 0) for t in triangles)
    return bytes(80) + struct.pack("<I", len(triangles)) + body


def ascii_stl(blocks: Iterable[bs.Block]) -> str:
    """An ASCII STL file with a named solid for each block."""
    lines = []
    for b in blocks:
        lines.append(f"solid {b.name}")
        for t in fans(b.shape.faces):
            corners = [f"vertex {x!r} {y!r} {z!r}" for x, y, z in b.shape.vertices[list(t)].tolist()]
            lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
        lines.append(f"endsolid {b.name}")
    return "\n".join(lines) + "\n"


def ply_text(blocks: Iterable[bs.Block]) -> str:
    """An ASCII PLY file of all blocks, polygons as they are."""
    vertices, faces = [], []
    for b in blocks:
        faces += [" ".join(map(str, [len(f), *(len(vertices) + i for i in f)])) for f in b.shape.faces]
        vertices += [f"{x!r} {y!r} {z!r}" for x, y, z in b.shape.vertices.tolist()]
    header = [
        "ply",
        "format ascii 1.0",
        f"element vertex {len(vertices)}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    return "\n".join([*header, *vertices, *faces]) + "\n"
