"""Import of one structure from several files of any kind."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from blockstruct.errors import ModelError
from blockstruct.imports.assembly import assembly_content
from blockstruct.imports.drawing import drawing_content
from blockstruct.imports.import_report import Imported
from blockstruct.imports.mesh import mesh_content
from blockstruct.imports.solid import make_blocks
from blockstruct.model import Material
from blockstruct.units import QuantityLike


def read_files(
    files: Sequence[str | Path],
    *,
    unit: QuantityLike,
    material: Material | Mapping[str, Material],
    fixed: str | Iterable[str] = (),
    exclude: Iterable[str] = (),
    up: str = "z",
    tolerance: QuantityLike | None = None,
    **drawing: Any,
) -> Imported:
    """Read the blocks of one or several meshes, drawings and COMPAS files, by their file extensions.

    With several files, block names start with the name of the file, as in ``arch.stone 1``.

    Parameters
    ----------
    files
        Names that end in ``.obj``, ``.stl``, ``.ply``, ``.dxf`` or ``.json``.
    unit, material, fixed, exclude, up, tolerance
        As for :func:`read_mesh`, or for :func:`read_drawing` if all files are drawings.
    drawing
        Further arguments of :func:`read_drawing`, for the drawings among the files.

    Returns
    -------
    Imported
        ``.blocks``, ``.report`` and ``.moves``.

    Raises
    ------
    ModelError
        If there are no files, arguments for drawings but no drawing, or materials per layer for other files.
    BlockstructError
        If the reader of one of the files raises it.
    """
    paths = [Path(f) for f in files]
    drawn = [p.suffix.lower() == ".dxf" for p in paths]
    if not paths:
        msg = "read_files: no files; give at least one"
        raise ModelError(msg)
    if (drawing and not any(drawn)) or (isinstance(material, Mapping) and not all(drawn)):
        arguments = ", ".join(drawing) or "materials of layers"
        msg = f"{paths[drawn.index(False)]}: {arguments} belong to DXF drawings; leave them out"
        raise ModelError(msg)
    if up != "z" and any(drawn):
        msg = f"{paths[drawn.index(True)]}: the plane defines the vertical of a drawing; give up for meshes only"
        raise ModelError(msg)
    stone: Any = material
    contents = []
    for path in paths:
        if path.suffix.lower() == ".dxf":
            contents.append(drawing_content(path, unit=unit, material=material, **drawing))
        else:
            read = assembly_content if path.suffix.lower() == ".json" else mesh_content
            contents.append(read(path, stone))
    return make_blocks(contents, paths, unit=unit, fixed=fixed, exclude=exclude, up=up, tolerance=tolerance)
