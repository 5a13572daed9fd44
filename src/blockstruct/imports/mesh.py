"""Blocks from meshes: OBJ, STL and PLY files."""

import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from blockstruct.errors import GeometryFileError, ModelError
from blockstruct.imports.import_report import Imported
from blockstruct.imports.obj import read_obj
from blockstruct.imports.solid import Content, Solid, make_blocks
from blockstruct.imports.source import checked_faces, package, read_bytes
from blockstruct.imports.stl import read_stl
from blockstruct.model import Material
from blockstruct.units import QuantityLike
from blockstruct.vocabulary import counted

#: Header of a PLY file whose coordinates have single precision.
_SINGLE = re.compile(rb"^property\s+float(32)?\s+x\s*$", re.MULTILINE)


def read_mesh(
    files: str | Path | Sequence[str | Path],
    *,
    unit: QuantityLike,
    material: Material,
    fixed: str | Iterable[str] = (),
    exclude: Iterable[str] = (),
    up: str = "z",
    tolerance: QuantityLike | None = None,
) -> Imported:
    """Blocks of one or several OBJ, STL or PLY files.

    Every closed body becomes a block. It takes the name of its OBJ object or group or, where there are several, of its
    STL solid, otherwise that of its file; several bodies of one name are numbered, and of several files each stands
    before the names of its blocks, as in ``arch.stone 1``. Corners close by are joined, all faces are made to look
    outward, neighbours in one plane become one face, and what is given twice is kept once. What was done is in the
    report, and warned of where it may not be meant.

    Parameters
    ----------
    files
        Names that end in ``.obj``, ``.stl`` or ``.ply``. PLY needs ``pip install "blockstruct[mesh]"``.
    unit : text or quantity, length
        Unit of the coordinates, which these formats do not state: ``"mm"``, or a scale such as ``"0.025 m"``.
    material
        Material of all blocks.
    fixed
        The supports: names of blocks, ``"lowest"`` for every block that reaches the lowest level to within 1 % of the
        mean block size, or ``"lowest 3 cm"``.
    exclude
        Names of blocks that are left out, in which ``*`` stands for any text.
    up : {"z", "y", "x"}
        Axis of the file that points up; the structure is turned until it is z.
    tolerance : quantity, length
        Largest deviation from the plane of a face. By default 0.5 % of the size of a block for polygons, whose
        vertices move into their planes, and 0.01 % for neighbouring triangles that become one face.

    Returns
    -------
    Imported
        ``.blocks`` and ``.report``.

    Raises
    ------
    StorageError
        If the file cannot be read.
    GeometryFileError
        If the file is damaged, or bodies are not blocks: open, not manifold, crossing themselves, without volume.
    MissingExtraError
        If the file is PLY and trimesh is not installed.

    Warns
    -----
    GeometryWarning
        If repairs go beyond the joining of coplanar faces, or blocks have an unlikely size.
    """
    paths = [Path(f) for f in ([files] if isinstance(files, str | Path) else files)]
    if not paths:
        msg = "read_mesh: no files; give at least one"
        raise ModelError(msg)
    contents = [mesh_content(path, material) for path in paths]
    return make_blocks(contents, paths, unit=unit, fixed=fixed, exclude=exclude, up=up, tolerance=tolerance)


def mesh_content(path: Path, material: Material) -> Content:
    """Solids of an OBJ, STL or PLY file, and what else it holds."""
    readers = {".obj": read_obj, ".stl": read_stl, ".ply": _read_ply}
    suffix = path.suffix.lower()
    if suffix not in readers:
        msg = f"{path}: not a mesh; give a file that ends in .obj, .stl or .ply"
        raise ModelError(msg)
    return Content(*readers[suffix](path, material))


def _read_ply(path: Path, material: Material) -> tuple[list[Solid], list[str]]:
    """The solid of a PLY file, and what else it holds."""
    content = read_bytes(path)
    stated = _stated_ply(content, path)
    trimesh = package("trimesh", "mesh", f"{path}: reading PLY")
    try:
        # Unprocessed: trimesh would otherwise drop and join corners and faces without a word.
        mesh = trimesh.load(io.BytesIO(content), file_type="ply", process=False)
        vertices = np.asarray(mesh.vertices, dtype=float)
        faces = [tuple(f) for f in np.asarray(mesh.faces).tolist()]
    except Exception as error:  # A reader of foreign files fails in as many ways as files can be damaged.
        msg = (
            f"{path}: not a readable PLY file ({error}); export it again, a binary one with all faces of as many "
            "corners, such as triangles"
        )
        raise GeometryFileError(msg) from error
    if len(faces) < stated or not faces:
        said = counted(stated, "face")
        msg = f"{path}: states {said}, {len(faces)} can be read; it is cut short or damaged, export it again"
        raise GeometryFileError(msg)
    unused = len(vertices) - len({i for face in faces for i in face})
    single = _SINGLE.search(content.partition(b"end_header")[0]) is not None
    solid = Solid(path.stem, vertices, faces, material, single=single)
    return [solid], [counted(unused, "vertex of no face", "vertices of no face")] if unused > 0 else []


def _stated_ply(content: bytes, path: Path) -> int:
    """Number of faces that a PLY file says it has."""
    header, end, body = content.partition(b"end_header")
    faces = re.search(rb"^element\s+face\s+(\d{1,12})\s*$", header, re.MULTILINE)
    if not header.startswith(b"ply") or not end or faces is None:
        msg = f"{path}: not a PLY file with faces; export it again as a mesh"
        raise GeometryFileError(msg)
    count = checked_faces(int(faces[1]), path)
    if re.search(rb"^format\s+ascii", header, re.MULTILINE):
        items = sum(map(int, re.findall(rb"^element\s+\w+\s+(\d{1,12})\s*$", header, re.MULTILINE)))
        lines = sum(bool(line.strip()) for line in body.splitlines())
        if lines != items:
            msg = f"{path}: states {items} vertices and faces and has {lines} lines; it is damaged, export it again"
            raise GeometryFileError(msg)
    return count
