"""Import of one structure from several files of any kind."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from inspect import signature
from pathlib import Path
from typing import Any

from blockstruct.errors import ModelError
from blockstruct.imports.assembly import assembly_content
from blockstruct.imports.drawing import drawing_content
from blockstruct.imports.ifc import ifc_content
from blockstruct.imports.mesh import mesh_content
from blockstruct.imports.rhino import rhino_content
from blockstruct.imports.solid import Content, make_blocks
from blockstruct.imports.source import Imported
from blockstruct.model import Material
from blockstruct.units import QuantityLike

#: Readers of the formats that name layers or materials, and their arguments besides path, unit and material.
_READERS: dict[str, Callable[..., Content]] = {".dxf": drawing_content, ".3dm": rhino_content, ".ifc": ifc_content}
_OPTIONS = {suffix: tuple(signature(read).parameters)[3:] for suffix, read in _READERS.items()}


def read_files(
    files: Sequence[str | Path],
    *,
    unit: QuantityLike | None = None,
    material: Material | Mapping[str, Material],
    fixed: str | Iterable[str] = (),
    exclude: Iterable[str] = (),
    up: str = "z",
    tolerance: QuantityLike | None = None,
    **options: Any,
) -> Imported:
    """Read the blocks of one or several files of any format, by their file extensions.

    With several files, block names start with the name of the file, as in ``arch.stone 1``.

    Parameters
    ----------
    files
        Names that end in ``.obj``, ``.stl``, ``.ply``, ``.dxf``, ``.json``, ``.3dm`` or ``.ifc``.
    unit
        As for :func:`read_mesh`. By default the unit of the files: Rhino files and building models state it.
    material, fixed, exclude, up, tolerance
        As for :func:`read_mesh`; materials may be given per layer if all files have layers, or materials in IFC.
    options
        Further arguments of :func:`read_drawing`, :func:`read_rhino` and :func:`read_ifc`, for files of their formats.

    Returns
    -------
    Imported
        ``.blocks``, ``.report`` and ``.moves``.

    Raises
    ------
    ModelError
        If there are no files, or an argument belongs to another format.
    BlockstructError
        If the reader of one of the files raises it.
    """
    paths = [Path(f) for f in files]
    if not paths:
        msg = "read_files: no files; give at least one"
        raise ModelError(msg)
    known = [_OPTIONS.get(p.suffix.lower()) for p in paths]
    for name in options:
        if not any(name in (names or ()) for names in known):
            belongs = " and ".join(suffix for suffix, names in _OPTIONS.items() if name in names)
            msg = f"{paths[0]}: {name} belongs to {belongs or 'no format'}; leave it out"
            raise ModelError(msg)
    if isinstance(material, Mapping) and None in known:
        msg = f"{paths[known.index(None)]}: has no layers; give one material"
        raise ModelError(msg)
    if up != "z" and any(known):
        msg = f"{next(p for p, names in zip(paths, known, strict=True) if names)}: its vertical is known; leave out up"
        raise ModelError(msg)
    contents = [_content(path, unit, material, options) for path in paths]
    return make_blocks(contents, paths, unit=unit, fixed=fixed, exclude=exclude, up=up, tolerance=tolerance)


def _content(path: Path, unit: QuantityLike | None, material: Any, options: Mapping[str, Any]) -> Content:
    """Return the content of a file, read with the options of its format."""
    suffix = path.suffix.lower()
    if suffix not in _READERS:
        return (assembly_content if suffix == ".json" else mesh_content)(path, material)
    of_format = {name: value for name, value in options.items() if name in _OPTIONS[suffix]}
    return _READERS[suffix](path, unit, material, **of_format)
