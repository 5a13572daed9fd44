"""Import of blocks from OBJ, STL and PLY meshes."""

import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from blockstruct.errors import GeometryFileError, ModelError
from blockstruct.imports.import_report import Imported
from blockstruct.imports.obj import read_obj
from blockstruct.imports.solid import Content, Solid, make_blocks
from blockstruct.imports.source import checked_faces, package, read_bytes, read_number
from blockstruct.imports.stl import read_stl
from blockstruct.model import Material
from blockstruct.units import QuantityLike
from blockstruct.vocabulary import counted

#: Line in the header of a PLY file with coordinates in single precision.
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
    """Read the blocks of one or several OBJ, STL or PLY files.

    Every closed body becomes a block. Its name is the name of the OBJ object or group, of the STL solid if there are
    several, or of the file. Several bodies with one name are numbered. With several files, block names start with the
    name of the file, as in ``arch.stone 1``. Close corners are joined, all faces look outward, neighbours in one plane
    become one face, and duplicates are dropped. The report lists all repairs. A warning names unusual repairs.

    Parameters
    ----------
    files
        Names that end in ``.obj``, ``.stl`` or ``.ply``. PLY needs ``pip install "blockstruct[mesh]"``.
    unit : text or quantity, length
        Unit of the coordinates: ``"mm"``, or a scale such as ``"0.025 m"``. These formats do not contain it.
    material
        Material of all blocks.
    fixed
        Supports: names of blocks, where ``*`` matches any text; ``"lowest"`` for all blocks within 1 % of the mean
        block size of the lowest level, or ``"lowest 3 cm"``; ``"ground"`` for a new fixed block ``ground`` under the
        structure, or ``"ground 0.5 m"`` for one with its top at this height. A support drawn as a single face becomes
        a fixed block behind the face. ``"NAME:x,z"`` holds some motions only: :attr:`blockstruct.Block.held`.
    exclude
        Names of blocks to ignore; ``*`` matches any text.
    up : {"z", "y", "x"}
        Vertical axis of the file. It becomes the z axis of the structure.
    tolerance : quantity, length
        Largest deviation from the plane of a face. By default it is 0.5 % of the size of a block for polygons, whose
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
        If there are repairs other than merged coplanar faces, or blocks have an unlikely size.
    """
    paths = [Path(f) for f in ([files] if isinstance(files, str | Path) else files)]
    if not paths:
        msg = "read_mesh: no files; give at least one"
        raise ModelError(msg)
    contents = [mesh_content(path, material) for path in paths]
    return make_blocks(contents, paths, unit=unit, fixed=fixed, exclude=exclude, up=up, tolerance=tolerance)


def mesh_content(path: Path, material: Material) -> Content:
    """Return the content of an OBJ, STL or PLY file."""
    readers = {".obj": read_obj, ".stl": read_stl, ".ply": _read_ply}
    suffix = path.suffix.lower()
    if suffix not in readers:
        msg = f"{path}: unknown kind of file; names end in .obj, .stl, .ply, .dxf, .json, .3dm or .ifc"
        raise ModelError(msg)
    return Content(*readers[suffix](path, material))


def _read_ply(path: Path, material: Material) -> tuple[list[Solid], list[str]]:
    """Return the solid of a PLY file, and texts on ignored content."""
    content = read_bytes(path)
    stated = _stated_ply(content, path)
    trimesh = package("trimesh", "mesh", f"{path}: reading PLY")
    try:
        # process=False: trimesh would otherwise drop and join corners and faces without a report.
        mesh = trimesh.load(io.BytesIO(content), file_type="ply", process=False)
        vertices = np.asarray(mesh.vertices, dtype=float)
        faces = [tuple(f) for f in np.asarray(mesh.faces).tolist()]
    except Exception as error:  # A damaged file may raise any error.
        msg = (
            f"{path}: not a readable PLY file ({error}); export it again, a binary one with all faces of as many "
            "corners, such as triangles"
        )
        raise GeometryFileError(msg) from error
    if len(faces) < stated or not faces:
        msg = (
            f"{path}: states {counted(stated, 'face')}, {len(faces)} can be read; it is incomplete or damaged, export "
            "it again"
        )
        raise GeometryFileError(msg)
    unused = len(vertices) - len({i for face in faces for i in face})
    single = _SINGLE.search(content.partition(b"end_header")[0]) is not None
    solid = Solid(path.stem, vertices, faces, material, single=single)
    return [solid], [counted(unused, "vertex of no face", "vertices of no face")] if unused > 0 else []


def _stated_ply(content: bytes, path: Path) -> int:
    """Return the number of faces in the header of a PLY file."""
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
        try:
            for word in body.split():
                read_number(word.decode("latin-1"))
        except ValueError as error:
            msg = f"{path}: {error}; correct it, or export the file again"
            raise GeometryFileError(msg) from error
    return count
