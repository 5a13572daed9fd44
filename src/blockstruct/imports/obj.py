"""Read and write Wavefront OBJ: polygons of objects and groups."""

import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from blockstruct.errors import GeometryFileError, ModelError
from blockstruct.files import write_new
from blockstruct.imports.solid import Face, Solid, metres_per_unit
from blockstruct.imports.source import checked_faces, read_number, read_text, read_whole
from blockstruct.model import Block, Material
from blockstruct.units import QuantityLike
from blockstruct.vocabulary import counted

#: Statements without effect on the shape of a solid.
_SILENT = {"vn", "vt", "vp", "s", "usemtl", "mtllib", "mg", "lod", "bevel", "c_interp", "d_interp", "shadow_obj"}
#: Statements of points, lines and free-form curves and surfaces.
_OTHER = {
    "p",
    "l",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "cstype",
    "deg",
    "bmat",
    "step",
}
#: Start of a comment in a line with a name.
_COMMENT_AFTER_NAME = r"(?<!\S)#"


def read_obj(path: Path, material: Material) -> tuple[list[Solid], list[str]]:
    """Return the solids of an OBJ file, and texts on ignored content.

    Each object (``o``) is a solid. In a file without objects each group (``g``) is a solid, and without groups the
    whole file.

    Raises
    ------
    GeometryFileError
        If a line is not a statement, or a face has fewer than three vertices or unknown ones.
    """
    vertices: list[list[float]] = []
    objects: list[tuple[str, list[Face]]] = []
    groups: dict[str, list[Face]] = {}
    group = path.stem
    other: Counter[str] = Counter()
    text = read_text(path)
    checked_faces(text.count("\nf"), path)
    for number, line in _statements(text):
        keyword, *words = line.split()
        if keyword == "v":
            vertices.append(finite_point(words, path, number))
        elif keyword == "f":
            face = _face(words, len(vertices), path, number)
            groups.setdefault(group, []).append(face)
            if objects:
                objects[-1][1].append(face)
        elif keyword == "o":
            if not objects and groups:
                objects.append((path.stem, [f for faces in groups.values() for f in faces]))
            objects.append((" ".join(words) or path.stem, []))
        elif keyword == "g":
            group = " ".join(words) or path.stem
        elif keyword in _OTHER:
            other[keyword] += 1
        elif keyword not in _SILENT:
            msg = (
                f"{path}, line {number}: {line[:60]!r} is not an OBJ statement; export the file again as Wavefront OBJ"
            )
            raise GeometryFileError(msg)
    points = np.array(vertices, dtype=float).reshape(-1, 3)
    named = objects or list(groups.items())
    left_out = [
        f"{counted(count, 'statement')} {keyword!r}, which {'is not a face' if count == 1 else 'are not faces'}"
        for keyword, count in sorted(other.items())
    ]
    unused = len(points) - len({i for _, faces in named for face in faces for i in face})
    if unused:
        left_out.append(counted(unused, "vertex of no face", "vertices of no face"))
    left_out += [f"object {name!r} without faces" for name, faces in named if not faces]
    return [Solid(name, points, faces, material) for name, faces in named if faces], left_out


def _statements(text: str) -> Iterable[tuple[int, str]]:
    """Yield numbered lines without comments; a backslash at the end joins a line to the next."""
    held: list[str] = []
    for number, raw in enumerate((*text.splitlines(), ""), start=1):
        # Inside a word of a name, # is part of the name.
        comment = _COMMENT_AFTER_NAME if (held or raw.split(maxsplit=1))[:1] in (["o"], ["g"]) else "#"
        line = re.split(comment, raw, maxsplit=1)[0].strip()
        held += line.removesuffix("\\").split()
        if held and not line.endswith("\\"):
            yield number, " ".join(held)
            held = []


def finite_point(words: list[str], path: Path, number: int) -> list[float]:
    """Return the three coordinates in a line of a file; further values are ignored."""
    try:
        point = [read_number(w) for w in words[:3]]
    except ValueError:
        point = []
    if len(point) < 3:
        msg = f"{path}, line {number}: vertex {' '.join(words)[:60]!r}; give three finite numbers"
        raise GeometryFileError(msg)
    return point


def _face(words: list[str], known: int, path: Path, number: int) -> Face:
    try:
        index = [read_whole(w.partition("/")[0]) for w in words]
    except ValueError:
        index = []
    if len(index) < 3:
        msg = f"{path}, line {number}: face {' '.join(words)[:60]!r}; give at least three vertex numbers"
        raise GeometryFileError(msg)
    # Negative numbers count back from the latest vertex.
    face = tuple(i - 1 if i > 0 else known + i for i in index)
    if 0 in index or not all(0 <= i < known for i in face):
        msg = f"{path}, line {number}: face {' '.join(words)[:60]!r} names a vertex outside 1..{known}"
        raise GeometryFileError(msg)
    return face


def write_obj(path: str | Path, blocks: Iterable[Block], *, unit: QuantityLike = "m") -> Path:
    """Write blocks as objects of a Wavefront OBJ file, with all digits.

    OBJ does not store materials and supports; :func:`write_document` does.

    Parameters
    ----------
    path
        A new file.
    blocks
        Blocks. Their names are words with single spaces in between. No word begins with ``#``, and no name ends in a
        backslash.
    unit
        Unit of the coordinates: ``"mm"``, or a length.

    Raises
    ------
    ModelError
        If there are no blocks, or OBJ cannot store a name.
    StorageError
        If the file exists or cannot be written.
    """
    blocks = list(blocks)
    scale = metres_per_unit(unit, str(path))
    if not blocks:
        msg = f"{path}: no blocks to write; give at least one"
        raise ModelError(msg)
    lines = [f"# blockstruct: {counted(len(blocks), 'block')}, 1 unit is {scale!r} m"]
    start = 1
    for block in blocks:
        read_back = [line.split() for _, line in _statements(f"o {block.name}")]
        if read_back != [["o", *block.name.split(" ")]]:
            msg = (
                f"{path}: OBJ cannot store the block name {block.name!r}; rename it, without double spaces, '#' at the "
                "start of a word and a backslash at the end"
            )
            raise ModelError(msg)
        lines.append(f"o {block.name}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in (block.shape.vertices / scale).tolist()]
        lines += [f"f {' '.join(str(start + i) for i in face)}" for face in block.shape.faces]
        start += len(block.shape.vertices)
    return write_new(Path(path), "\n".join(lines) + "\n")
