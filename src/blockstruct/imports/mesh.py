"""Import of blocks from meshes in STL, OBJ and PLY files, and export to OBJ."""

import io
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from blockstruct.arrays import Array
from blockstruct.errors import GeometryFileError, ModelError
from blockstruct.files import write_new
from blockstruct.geometry.polygon import Face
from blockstruct.imports.solid import Content, Solid, make_blocks, metres_per_unit
from blockstruct.imports.source import Imported, checked_faces, package, read_bytes, read_number, read_text, read_whole
from blockstruct.model import Block, Material
from blockstruct.units import QuantityLike
from blockstruct.vocabulary import counted

#: Layout of the header of a binary file, and of a triangle.
_HEADER = np.dtype([("text", "V80"), ("triangles", "<u4")])
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
#: First words of the lines of a facet, except vertices.
_OF_FACET = ("facet", "outer", "endloop", "endfacet")


def read_stl(path: Path, material: Material) -> tuple[list[Solid], list[str]]:
    """Return the solids of an STL file, and texts on ignored content.

    Several solids keep their names. A single solid has the name of the file, because its name is usually the name of
    the program.

    Raises
    ------
    GeometryFileError
        If a line is not STL, a facet is not a triangle, or the file is incomplete.
    """
    content = read_bytes(path)
    count = int.from_bytes(content[: _HEADER.itemsize][-4:], "little")
    if len(content) == _HEADER.itemsize + _TRIANGLE.itemsize * count and checked_faces(count, path):
        # Many programs also begin the header of a binary file with the word solid.
        corners = np.frombuffer(content, _TRIANGLE, offset=_HEADER.itemsize)["corners"].astype(float)
        return [_solid(path.stem, corners.reshape(-1, 3), material, single=True)], []
    if not re.match(rb"(\xef\xbb\xbf)?\s*solid", content, re.IGNORECASE) or b"\0" in content:
        msg = (
            f"{path}: {len(content)} bytes are not a complete STL file "
            "(binary STL has 84 bytes plus 50 per stated triangle); export it again"
        )
        raise GeometryFileError(msg)
    text = read_text(path)
    checked_faces(text.lower().count("endfacet"), path)
    solids = _read_text(text, path)
    named = [(path.stem if len(solids) == 1 or not name else name, points) for name, points in solids]
    left_out = [f"solid {name!r} without faces" for name, points in named if not points]
    return [_solid(name, np.array(points), material) for name, points in named if points], left_out


def _read_text(text: str, path: Path) -> list[tuple[str, list[list[float]]]]:
    """Return the name of each solid, and its corners, three per triangle."""
    if not text.rstrip().splitlines()[-1].lstrip().lower().startswith("endsolid"):
        msg = f"{path}: 'endsolid' is missing, the file is incomplete; export it again"
        raise GeometryFileError(msg)
    solids: list[tuple[str, list[list[float]]]] = []
    inside, corners = False, 0
    for number, line in enumerate(text.splitlines(), start=1):
        keyword, rest = [*line.split(maxsplit=1), "", ""][:2]
        word = keyword.lower()
        if word == "solid" and not inside:
            solids.append((rest.strip(), []))
            inside = True
        elif word == "endsolid" and inside:
            inside = False
        elif word == "vertex" and inside:
            solids[-1][1].append(finite_point(rest.split(), path, number))
            corners += 1
        elif word in _OF_FACET and inside:
            if word == "endfacet" and corners != 3:
                msg = f"{path}, line {number}: a facet of {counted(corners, 'vertex', 'vertices')}; give triangles"
                raise GeometryFileError(msg)
            corners = 0 if word == "endfacet" else corners
        elif word:
            msg = f"{path}, line {number}: {line.strip()[:60]!r} is not a line of STL here; export it again"
            raise GeometryFileError(msg)
    return solids


def _solid(name: str, points: Array, material: Material, *, single: bool = False) -> Solid:
    faces: list[Face] = [(k, k + 1, k + 2) for k in range(0, len(points), 3)]
    return Solid(name, points, faces, material, single=single)


#: Statements without effect on the shape of a solid.
_SILENT = {"vn", "vt", "vp", "s", "usemtl", "mtllib", "mg", "lod", "bevel", "c_interp", "d_interp", "shadow_obj"}
#: Statements of points, lines and free-form curves and surfaces.
_OTHER = {"p", "l", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp", "end"}
_OTHER |= {"cstype", "deg", "bmat", "step"}
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
        a fixed block on the far side of the face. ``"NAME:x,z"`` holds only some motions:
        :attr:`blockstruct.Block.held`.
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
