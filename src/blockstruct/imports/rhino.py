"""Import of blocks from Rhino files."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from blockstruct.arrays import Array
from blockstruct.errors import GeometryFileError
from blockstruct.geometry.polygon import Face, Planes, plane_axes
from blockstruct.imports.solid import Content, LeftOut, Solid, agreed_scale, check_layers, make_blocks
from blockstruct.imports.source import Imported, checked_faces, package, read_bytes
from blockstruct.imports.tolerances import DEPTH, EXACT
from blockstruct.model import Material
from blockstruct.units import QuantityLike

#: Units of a file in m, by their name in Rhino.
_UNITS = {
    **{"Microns": 1e-6, "Millimeters": 1e-3, "Centimeters": 1e-2, "Decimeters": 0.1, "Meters": 1.0},
    **{"Dekameters": 10.0, "Hectometers": 100.0, "Kilometers": 1e3, "Microinches": 2.54e-8, "Mils": 2.54e-5},
    **{"Inches": 0.0254, "Feet": 0.3048, "Yards": 0.9144, "Miles": 1609.344, "NauticalMiles": 1852.0},
}


def read_rhino(
    file: str | Path,
    *,
    material: Material | Mapping[str, Material],
    unit: QuantityLike | None = None,
    override_unit: bool = False,
    supports: Iterable[str] = (),
    fixed: str | Iterable[str] = (),
    exclude: Iterable[str] = (),
    tolerance: QuantityLike | None = None,
) -> Imported:
    """Read the blocks of a Rhino file. Needs ``pip install "blockstruct[rhino]"``.

    Closed polysurfaces with planar faces and straight edges, extrusions and meshes become blocks, also inside block
    instances. A block has the name of its object, or ``layer.k`` if the object has no name. Everything else is ignored
    and reported by layer: curved polysurfaces, SubDs, curves, annotations, hidden objects and layers.

    Parameters
    ----------
    file
        A ``.3dm`` file.
    material
        Material of all blocks, or a material per layer. Layers without a material are ignored. The name of a sublayer
        contains its parents: ``"Walls::Lower"``.
    unit : text or quantity, length
        Unit of the coordinates; by default the unit of the file. If both are known, the two must agree.
    override_unit
        Whether ``unit`` overrides the unit of the file.
    supports
        Layers whose blocks are fixed.
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
        If the file is damaged, the units differ, or solids are not blocks.
    MissingExtraError
        If rhino3dm is not installed.
    UnknownNameError
        If the file does not have a layer.

    Warns
    -----
    GeometryWarning
        If something was ignored or repaired.
    """
    path = Path(file)
    content = rhino_content(path, unit, material, override_unit, supports)
    return make_blocks([content], [path], unit=unit, fixed=fixed, exclude=exclude, up="z", tolerance=tolerance)


def rhino_content(
    path: Path,
    unit: QuantityLike | None,
    material: Material | Mapping[str, Material],
    override_unit: bool = False,
    supports: Iterable[str] = (),
) -> Content:
    """Return the content of a Rhino file; parameters as for :func:`read_rhino`."""
    file = _opened(path)
    stated = _UNITS.get(file.Settings.ModelUnitSystem.name)
    scale, notes = agreed_scale(unit, stated, path, override=override_unit)
    shown = {layer.FullPath: bool(layer.Visible) for layer in file.Layers}
    materials = material if isinstance(material, Mapping) else None
    fixed_layers = {supports} if isinstance(supports, str) else set(supports)
    objects = list(_objects(file, path))
    check_layers({*(materials or ()), *fixed_layers}, {*shown, *(layer for _, layer, _ in objects)}, path)
    left_out, solids = LeftOut(), list[Solid]()
    count: Counter[str] = Counter()
    for geometry, layer, attributes in objects:
        kind, named = type(geometry).__name__, attributes.Name or str(attributes.Id)
        parents = layer.split("::")
        if not all(shown.get("::".join(parents[: k + 1]), True) for k in range(len(parents))):
            left_out.add(f"{kind} on layer {layer}, which is hidden", named)
        elif not attributes.Visible:
            left_out.add(f"{kind} on layer {layer} that is hidden", named)
        elif materials is not None and layer not in materials:
            left_out.add(f"{kind} on layer {layer}, which has no material", named)
        elif (surface := _surface(geometry)) is None:
            remedy = ", to be meshed in Rhino" if kind in ("Brep", "Extrusion", "SubD", "Surface") else ""
            left_out.add(f"{kind} on layer {layer}{remedy}", named)
        else:
            count[layer] += 1
            stone: Any = material if materials is None else materials[layer]
            name, (vertices, faces, single) = attributes.Name or f"{layer}.{count[layer]}", surface
            solids.append(Solid(name, vertices, faces, stone, layer in fixed_layers, single))
    checked_faces(sum(len(solid.faces) for solid in solids), path)
    return Content(solids, left_out.texts(), [], notes, scale)


def _opened(path: Path) -> Any:
    content = read_bytes(path)
    rhino3dm = package("rhino3dm", "rhino", f"{path}: reading Rhino files")
    file = rhino3dm.File3dm.Read(str(path)) if content.startswith(b"3D Geometry File Format") else None
    if file is None:
        msg = f"{path}: not a readable Rhino file; save it again as .3dm"
        raise GeometryFileError(msg)
    return file


def _objects(file: Any, path: Path) -> Iterator[tuple[Any, str, Any]]:
    """Yield geometry, layer and attributes of all objects; objects of block instances where they are inserted."""
    names = {layer.Index: layer.FullPath for layer in file.Layers}

    def expanded(geometry: Any, attributes: Any, depth: int) -> Iterator[tuple[Any, str, Any]]:
        if type(geometry).__name__ != "InstanceReference":
            yield geometry, names.get(attributes.LayerIndex, "Default"), attributes
            return
        if depth == DEPTH:
            msg = f"{path}: block instance {attributes.Id} is {DEPTH} blocks deep; explode it"
            raise GeometryFileError(msg)
        definition = file.InstanceDefinitions.FindId(geometry.ParentIdefId)
        for member in definition.GetObjectIds() if definition else ():
            found = file.Objects.FindId(member)
            moved = found.Geometry.Duplicate()
            moved.Transform(geometry.Xform)
            yield from expanded(moved, found.Attributes, depth + 1)

    for each in file.Objects:
        if not each.Attributes.IsInstanceDefinitionObject:
            yield from expanded(each.Geometry, each.Attributes, 0)


def _surface(geometry: Any) -> tuple[Array, list[Face], bool] | None:
    """Return vertices and faces of a mesh or a solid with planar faces, and whether the precision is single."""
    kind = type(geometry).__name__
    if kind == "Mesh":
        points = [geometry.Vertices.Point3dAt(i) for i in _all(geometry.Vertices)]
        # A triangle repeats its last vertex.
        faces = [tuple(dict.fromkeys(geometry.Faces[i])) for i in _all(geometry.Faces)]
        return _coordinates(points), faces, not geometry.Vertices.UseDoublePrecisionVertices
    brep = geometry.ToBrep(True) if kind == "Extrusion" else geometry
    if type(brep).__name__ != "Brep":
        return None
    vertices = _coordinates(brep.Vertices[i].Location for i in _all(brep.Vertices))
    rounding = EXACT * float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    polygons: list[Face] = []
    for i in _all(brep.Faces):
        face = brep.Faces[i]
        loops = [
            [loop.Trims[k] for k in range(loop.TrimCount)] for loop in map(face.Loops.__getitem__, _all(face.Loops))
        ]
        edges = [trim.EdgeIndex for loop in loops for trim in loop]
        straight = all(e >= 0 and brep.Edges[e].IsLinear(rounding) for e in edges)
        if not straight or not face.UnderlyingSurface().IsPlanar(rounding):
            return None
        corners = _without_holes(vertices, [tuple(trim.StartVertexIndex for trim in loop) for loop in loops])
        polygons += [polygon[::-1] for polygon in corners] if face.OrientationIsReversed else corners
    return vertices, polygons, False


def _all(table: Any) -> range:
    """Return the indices of a table of rhino3dm, which is not a sequence."""
    return range(len(table))


def _coordinates(points: Iterable[Any]) -> Array:
    return np.array([(p.X, p.Y, p.Z) for p in points], dtype=float).reshape(-1, 3)


def _without_holes(vertices: Array, loops: list[Face]) -> list[Face]:
    """Return the outer loop of a planar face, or triangles if it has holes."""
    if len(loops) == 1:
        return loops
    plane = Planes.of(vertices, loops[:1])
    axes = np.stack(plane_axes(plane.normal), axis=1)[0]
    flat = (vertices - plane.centre[0]) @ axes.T
    region = shapely.Polygon(flat[list(loops[0])], [flat[list(hole)] for hole in loops[1:]])
    index = {tuple(flat[i].tolist()): i for loop in loops for i in loop}
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(region))
    # In the order of rotation of the outer loop.
    step = 1 if triangles[0].exterior.is_ccw == region.exterior.is_ccw else -1
    return [tuple(index[corner] for corner in t.exterior.coords[:3])[::step] for t in triangles]
