"""Read STL: triangles of one or several solids, as text or binary."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import GeometryFileError
from blockstruct.imports.obj import finite_point
from blockstruct.imports.solid import Face, Solid
from blockstruct.imports.source import checked_faces, read_bytes, read_text
from blockstruct.model import Material
from blockstruct.vocabulary import counted

#: Header of a binary file, bytes, and layout of a triangle.
_HEADER = 84
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
    count = int.from_bytes(content[_HEADER - 4 : _HEADER], "little")
    if len(content) == _HEADER + _TRIANGLE.itemsize * count and checked_faces(count, path):
        # Many programs also begin the header of a binary file with the word solid.
        corners = np.frombuffer(content, _TRIANGLE, offset=_HEADER)["corners"].astype(float)
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


def _solid(name: str, points: NDArray[np.float64], material: Material, *, single: bool = False) -> Solid:
    faces: list[Face] = [(k, k + 1, k + 2) for k in range(0, len(points), 3)]
    return Solid(name, points, faces, material, single=single)
