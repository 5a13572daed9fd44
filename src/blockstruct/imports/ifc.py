"""Import of blocks from building models (IFC)."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from blockstruct.arrays import Array, Index
from blockstruct.errors import GeometryFileError, ModelError, UnknownNameError
from blockstruct.geometry.polyhedron import lofted
from blockstruct.imports.solid import Content, LeftOut, Solid, agreed_scale, check_layers, make_blocks
from blockstruct.imports.source import Imported, checked_faces, package, read_bytes
from blockstruct.imports.tolerances import EXACT, WELD
from blockstruct.model import Material
from blockstruct.model.fields import positive_length
from blockstruct.structures.bond import divided_wall
from blockstruct.units import QuantityLike
from blockstruct.vocabulary import counted

_PART = "IfcBuildingElementPart"
#: Classes of elements whose bodies become blocks.
_CLASSES = ("IfcWall", "IfcSlab", "IfcBeam", "IfcColumn", "IfcMember", "IfcFooting", "IfcPlate", _PART)


def read_ifc(  # noqa: PLR0913
    file: str | Path,
    *,
    material: Material | Mapping[str, Material],
    classes: Iterable[str] = _CLASSES,
    unit_length: QuantityLike | None = None,
    unit_height: QuantityLike | None = None,
    supports: Iterable[str] = (),
    fixed: str | Iterable[str] = (),
    exclude: Iterable[str] = (),
    tolerance: QuantityLike | None = None,
) -> Imported:
    """Read the blocks of a building model. Needs ``pip install "blockstruct[bim]"``.

    Each body of a wall, slab, beam, column, member, footing, plate or part becomes a block, without its openings. The
    name of a block is ``storey.name``. Its material has the name of the material in the file. Curved faces are divided
    into facets. The unit is the unit of the file. Elements of other classes are ignored and reported.

    Parameters
    ----------
    file
        An ``.ifc`` file.
    material
        Material of all blocks, or a material per name of a material in the file. A layered wall has the material
        ``"brick + plaster"``. With a material per name, elements of other materials are ignored.
    classes
        Classes of elements that become blocks; their subclasses too.
    unit_length, unit_height : quantity, length
        Size of a unit: straight walls of one thickness are cut into units in running bond, as in
        :func:`blockstruct.structures.wall`. All courses of a wall have one height near ``unit_height``. One unit spans
        each opening, with a bearing of half a unit. The k-th unit of the j-th course is ``storey.name.j.k``. By default
        each wall is one block.
    supports
        Classes whose elements are fixed, ``"IfcFooting"`` for instance.
    fixed, exclude, tolerance
        As for :func:`read_mesh`.

    Returns
    -------
    Imported
        ``.blocks``, ``.report`` and ``.moves``.

    Raises
    ------
    StorageError
        If the file cannot be read.
    GeometryFileError
        If the file is damaged or has no unit of length, or bodies are not blocks.
    MissingExtraError
        If ifcopenshell is not installed.
    UnknownNameError
        If the file does not have a material, or its schema does not have a class.

    Warns
    -----
    GeometryWarning
        If something was ignored or repaired, or a wall was not cut into units.
    """
    path = Path(file)
    content = ifc_content(path, None, material, classes, unit_length, unit_height, supports)
    return make_blocks([content], [path], unit=None, fixed=fixed, exclude=exclude, up="z", tolerance=tolerance)


def ifc_content(
    path: Path,
    unit: QuantityLike | None,
    material: Material | Mapping[str, Material],
    classes: Iterable[str] = _CLASSES,
    unit_length: QuantityLike | None = None,
    unit_height: QuantityLike | None = None,
    supports: Iterable[str] = (),
) -> Content:
    """Return the content of a building model; parameters as for :func:`read_ifc`."""
    if (unit_length is None) != (unit_height is None):
        msg = f"{path}: give unit_length and unit_height (--unit-size LENGTH HEIGHT), both of them"
        raise ModelError(msg)
    ifc = package("ifcopenshell", "bim", f"{path}: reading building models")
    model = _opened(ifc, path)
    element_of = package("ifcopenshell.util.element", "bim", str(path))
    scale, _ = agreed_scale(unit, _stated_unit(model, path), path)
    brick = [positive_length(size, f"{path}: size of a unit") / scale for size in (unit_length, unit_height) if size]
    wanted = {classes} if isinstance(classes, str) else set(classes)
    fixed = {supports} if isinstance(supports, str) else set(supports)
    for name in sorted(wanted | fixed):
        try:
            model.by_type(name)
        except RuntimeError as error:
            msg = f"{path}: {model.schema} has no class {name!r}; give one such as IfcWall"
            raise UnknownNameError(msg) from error
    elements = sorted(model.by_type("IfcElement"), key=lambda e: int(e.id()))
    named = {e: " + ".join(m.Name or "" for m in element_of.get_materials(e)) for e in elements}
    materials = material if isinstance(material, Mapping) else None
    check_layers(materials or (), {name for name in named.values() if name}, path, "material")
    left_out, solids, uncut = LeftOut(), list[Solid](), list[str]()
    for element in elements:
        storey = element_of.get_container(element)
        name = ".".join(
            n for n in (storey and storey.Name, element.Name or f"{element.is_a()} {element.GlobalId}") if n
        )
        stone = named[element]
        assembly = element_of.get_aggregate(element)
        # An assembly has a body, or its parts have bodies.
        if element.is_a("IfcFeatureElement") or (element.IsDecomposedBy and not element.Representation):
            continue
        if assembly is not None and getattr(assembly, "Representation", None):
            continue
        if not any(map(element.is_a, wanted)):
            left_out.add(element.is_a(), name)
        elif materials is not None and stone not in materials:
            left_out.add(f"{element.is_a()} {f'of {stone}' if stone else 'without a material'}", name)
        elif (body := _body(element, path)) is None:
            left_out.add(f"{element.is_a()} without a body", name)
        else:
            given: Any = material if materials is None else materials[stone]
            block = Material(stone or given.name, given.quantity("unit_weight"), source=given.source)
            whole = Solid(name, body[0], [tuple(t) for t in body[1].tolist()], block, any(map(element.is_a, fixed)))
            units = _units(whole, body[1], *brick) if brick and element.is_a("IfcWall") else []
            if brick and element.is_a("IfcWall") and not units:
                uncut.append(name)
            solids += units or [whole]
    checked_faces(sum(len(solid.faces) for solid in solids), path)
    texts = left_out.texts()
    if uncut:
        what = counted(len(uncut), "wall")
        texts.append(f"the joints of {what} not straight or not of one thickness, each one block ({', '.join(uncut)})")
    return Content(solids, texts, [], [], scale)


def _opened(ifc: Any, path: Path) -> Any:
    content = read_bytes(path)
    try:
        if not content.lstrip().startswith(b"ISO-10303-21"):
            msg = "it does not begin with ISO-10303-21"
            raise ValueError(msg)
        model = ifc.file.from_string(content.decode("utf-8", errors="replace"))
        if not model.by_type("IfcProject"):
            msg = "it has no project"
            raise ValueError(msg)
    except Exception as error:  # A damaged file may raise any error.
        msg = f"{path}: not a readable IFC file ({error}); export it again as IFC (STEP)"
        raise GeometryFileError(msg) from error
    return model


def _stated_unit(model: Any, path: Path) -> float:
    """Return the metres per unit of length of a file."""
    stated = package("ifcopenshell.util.unit", "bim", str(path))
    if stated.get_project_unit(model, "LENGTHUNIT") is None:
        msg = f"{path}: has no unit of length; export it again with its units"
        raise GeometryFileError(msg)
    return float(stated.calculate_unit_scale(model))


def _body(element: Any, path: Path) -> tuple[Array, Index] | None:
    """Return vertices (n, 3) and triangles (m, 3) of the body of an element in the file's unit, or None."""
    geometry = package("ifcopenshell.geom", "bim", str(path))
    settings = geometry.settings()
    settings.set("use-world-coords", True)
    settings.set("convert-back-units", True)
    if element.Representation is None:
        return None
    try:
        shape = geometry.create_shape(settings, element).geometry
    except RuntimeError:
        return None
    faces = np.array(shape.faces, dtype=np.int64).reshape(-1, 3)
    return (np.array(shape.verts, dtype=float).reshape(-1, 3), faces) if len(faces) else None


def _units(wall: Solid, triangles: Index, unit_length: float, unit_height: float) -> list[Solid]:
    """Return the units of a wall; nothing if the wall is not straight, upright and of one thickness."""
    a, b, c = (wall.vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a) / 2
    size = np.linalg.norm(normal, axis=1)
    upright = np.abs(normal[:, 2]) <= EXACT * size
    if not upright.any():
        return []
    through = normal[np.argmax(np.where(upright, size, 0.0))]
    through = through / np.linalg.norm(through)
    along = np.array([-through[1], through[0], 0.0])
    depth = wall.vertices @ through
    front = normal @ through >= (1 - EXACT) * size
    flat = np.stack([wall.vertices @ along, wall.vertices[:, 2]], axis=1)
    elevation = shapely.union_all(shapely.polygons(flat[triangles[front]]))
    thickness = float(np.ptp(depth))
    volume = abs(float(np.einsum("ij,ij->", a - a[0], normal))) / 3
    is_prism = abs(elevation.area * thickness - volume) <= WELD * volume
    if elevation.geom_type != "Polygon" or not is_prism:
        return []
    try:
        units = divided_wall(elevation, unit_length, unit_height)
    except ModelError:
        return []
    solids = []
    for name, outline in units:
        foot = outline[:, :1] * along + outline[:, 1:] * np.array([0.0, 0.0, 1.0])
        vertices, faces = lofted(foot + depth.min() * through, foot + depth.max() * through)
        solids.append(Solid(f"{wall.name}.{name}", vertices, list(faces), wall.material, wall.fixed))
    return solids
