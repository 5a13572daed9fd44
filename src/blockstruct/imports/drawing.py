"""Blocks from drawings: DXF files."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import BlockstructError, GeometryFileError, ModelError, UnknownNameError
from blockstruct.imports.expansion import check_expansion
from blockstruct.imports.import_report import Imported, Repair
from blockstruct.imports.profile import divided_arcs, prism
from blockstruct.imports.solid import Face, Solid, blocks_of, scale_of
from blockstruct.imports.source import checked_faces, content_of, package
from blockstruct.keywords import checked_keywords
from blockstruct.model import Material
from blockstruct.model.checks import positive_length

Array = NDArray[np.float64]

#: Metres of the units that a drawing may state ($INSUNITS).
_STATED_UNITS = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 7: 1e3, 10: 0.9144, 14: 0.1}
#: Bodies that only the program that made them can divide into faces.
_SOLID_MODELS = ("3DSOLID", "BODY", "EXTRUDEDSURFACE", "LOFTEDSURFACE", "REVOLVEDSURFACE", "SURFACE", "SWEPTSURFACE")
#: Levels of blocks inside blocks of a drawing that are followed.
_DEPTH = 16


@checked_keywords
def read_drawing(
    file: str | Path,
    *,
    unit: Any,
    material: Material | Mapping[str, Material],
    thickness: Any = None,
    plane: str = "elevation",
    segments: int | None = None,
    supports: Iterable[str] = (),
    fixed: str | Iterable[str] = (),
    tolerance: Any = None,
) -> Imported:
    """Blocks of a DXF drawing: ``pip install "blockstruct[cad]"``.

    Closed polylines become prisms; meshes, polyface meshes and closed sets of 3D faces become blocks as they are.
    The k-th on a layer is called ``layer.k``. Everything else in the model space is left out and reported, as is
    what lies on a layer that is off or frozen.

    Parameters
    ----------
    file
        A ``.dxf`` file.
    unit : text or quantity, length
        Unit of the coordinates: ``"mm"``, or a scale such as ``"0.025 m"``. Where the drawing states its unit, the
        two must agree.
    material
        Material of all blocks, or a material for each layer to be read: other layers are left out.
    thickness : quantity, length
        Of the prisms. Polylines that have a thickness of their own in the drawing need none.
    plane
        ``"elevation"`` stands the drawing up: its x and y become x and z, and prisms reach from y = 0 to the
        thickness. ``"plan"`` keeps x and y, and prisms rise from z = 0. Bodies in 3D stay where they are.
    segments
        Number of straight segments that stand for each arc of a polyline; without it, arcs are refused.
    supports
        Layers whose blocks are fixed.
    fixed, tolerance
        As for :func:`read_mesh`.

    Returns
    -------
    Imported
        ``.blocks`` and ``.report``.

    Raises
    ------
    StorageError
        A file that cannot be read.
    GeometryFileError
        A damaged file, a drawing in another unit, arcs without ``segments``, solids that are no blocks.
    MissingExtraError
        No ezdxf.
    UnknownNameError
        A layer that the drawing does not have.

    Warns
    -----
    GeometryWarning
        Whatever was left out or repaired.
    """
    path = Path(file)
    scale = scale_of(unit, str(path))
    depth = None if thickness is None else positive_length(thickness, f"{path}: thickness") / scale
    if plane not in ("elevation", "plan"):
        msg = f"{path}: plane is {plane!r}; give 'elevation' or 'plan'"
        raise ModelError(msg)
    if segments is not None and (not isinstance(segments, int) or segments < 1):
        msg = f"{path}: segments is {segments!r}; give a whole number of straight pieces for each arc, one or more"
        raise ModelError(msg)
    drawing = _opened(path)
    _check_unit(drawing, scale, path)
    check_expansion(drawing, path, _DEPTH)
    reading = _Reading(path, depth, plane == "elevation", segments)
    layers = {layer.dxf.name: layer for layer in drawing.layers}
    # DXF does not tell layers apart by case, and entities may lie on layers that no table lists.
    listed = {name.lower(): name for name in layers}
    entities = [(e, listed.get(name.lower(), name)) for e, name in _entities(drawing.modelspace(), reading.left_out)]
    known = {*layers, *(layer for _, layer in entities)}
    materials = material if isinstance(material, Mapping) else None
    fixed_layers = set(supports)
    for name in sorted({*(materials or ()), *fixed_layers} - known):
        msg = f"{path}: has no layer {name!r}; it has {', '.join(sorted(known))}"
        raise UnknownNameError(msg)
    for entity, layer in entities:
        if layer in layers and (layers[layer].is_off() or layers[layer].is_frozen()):
            reading.left_out[f"{entity.dxftype()} on layer {layer}, which is off or frozen"] += 1
        elif materials is not None and layer not in materials:
            reading.left_out[f"{entity.dxftype()} on layer {layer}, which has no material"] += 1
        else:
            reading.add(entity, layer)
    bodies = reading.bodies + [
        (layer, np.concatenate(corners), [tuple(range(k, k + len(c))) for k, c in _numbered(corners)])
        for layer, corners in reading.loose.items()
    ]
    checked_faces(sum(len(faces) for _, _, faces in bodies), path)
    count: Counter[str] = Counter()
    solids = []
    for layer, vertices, faces in bodies:
        count[layer] += 1
        stone: Any = material if materials is None else materials[layer]
        solids.append(Solid(f"{layer}.{count[layer]}", vertices, faces, stone, layer in fixed_layers))
    return blocks_of(
        solids,
        str(path),
        unit=unit,
        fixed=fixed,
        tolerance=tolerance,
        left_out=[f"{number} {what}" for what, number in sorted(reading.left_out.items())],
        repairs=[Repair(layer, "arcs", rise * scale) for layer, rise in reading.arcs.items()],
    )


@dataclass(slots=True)
class _Reading:
    """What a drawing holds, by layer and in coordinate units, as it is read."""

    path: Path
    thickness: float | None
    standing: bool
    segments: int | None
    bodies: list[tuple[str, Array, list[Face]]] = field(default_factory=list)
    loose: dict[str, list[Array]] = field(default_factory=dict)
    arcs: dict[str, float] = field(default_factory=dict)
    left_out: Counter[str] = field(default_factory=Counter)

    def add(self, entity: Any, layer: str) -> None:
        """Add an entity, or note that it is left out."""
        try:
            self._add(entity, layer)
        except BlockstructError:
            raise
        except Exception as error:  # Data of a damaged entity are missing or of any kind.
            msg = f"{self.path}: {entity.dxftype()} on layer {layer!r} is damaged ({error}); draw it again"
            raise GeometryFileError(msg) from error

    def _add(self, entity: Any, layer: str) -> None:
        kind = entity.dxftype()
        if kind == "LWPOLYLINE":
            corners = [(x, y, entity.dxf.elevation, bulge) for x, y, bulge in entity.get_points("xyb")]
            self._polyline(entity, layer, corners, entity.closed)
        elif kind == "POLYLINE" and entity.is_2d_polyline:
            level = entity.dxf.elevation.z
            corners = [(v.dxf.location.x, v.dxf.location.y, level, v.dxf.bulge) for v in entity.vertices]
            self._polyline(entity, layer, corners, entity.is_closed)
        elif kind == "MESH" or (kind == "POLYLINE" and (entity.is_poly_face_mesh or entity.is_polygon_mesh)):
            builder = package("ezdxf.render", "cad", str(self.path)).MeshBuilder
            mesh = builder.from_mesh(entity) if kind == "MESH" else builder.from_polyface(entity)
            vertices = np.array([tuple(v) for v in mesh.vertices], dtype=float).reshape(-1, 3)
            self.bodies.append((layer, vertices, [tuple(map(int, face)) for face in mesh.faces]))
        elif kind == "3DFACE":
            self.loose.setdefault(layer, []).append(np.array([tuple(v) for v in entity.wcs_vertices()], dtype=float))
        else:
            remedy = ", to be exported as a mesh" if kind in _SOLID_MODELS else ""
            self.left_out[f"{kind} on layer {layer}{remedy}"] += 1

    def _polyline(
        self, entity: Any, layer: str, corners: list[tuple[float, float, float, float]], closed: bool
    ) -> None:
        if len(corners) > 2 and corners[0][:2] == corners[-1][:2]:
            corners, closed = corners[:-1], True
        if not closed or len(corners) < 2:
            self.left_out[f"open polyline on layer {layer}"] += 1
            return
        ocs = entity.ocs()
        if abs(ocs.uz.z) < 1 - 1e-9:
            self.left_out[f"polyline out of the drawing plane on layer {layer}"] += 1
            return
        points = np.array([tuple(ocs.to_wcs(c[:3])) for c in corners], dtype=float)
        x, y, level = points[0]
        outline = points[:, :2]
        # Seen from below, an arc turns the other way.
        bulges = np.array([c[3] for c in corners]) * np.sign(ocs.uz.z)
        if np.any(bulges):
            if self.segments is None:
                msg = (
                    f"{self.path}: the polyline from ({x:.6g}, {y:.6g}) on layer {layer!r} has arcs; "
                    "give segments, the number of straight pieces for each arc"
                )
                raise GeometryFileError(msg)
            outline, rise = divided_arcs(outline, bulges, self.segments)
            self.arcs[layer] = max(rise, self.arcs.get(layer, 0.0))
        thickness = self.thickness or abs(entity.dxf.get("thickness", 0.0))
        if not thickness:
            msg = f"{self.path}: the polyline from ({x:.6g}, {y:.6g}) on layer {layer!r} is flat; give a thickness"
            raise GeometryFileError(msg)
        self.bodies.append((layer, *prism(outline, float(level), thickness, standing=self.standing)))


def _numbered(corners: list[Array]) -> Iterator[tuple[int, Array]]:
    """Each face with the number of its first corner."""
    return zip(accumulate((len(c) for c in corners), initial=0), corners, strict=False)


def _opened(path: Path) -> Any:
    content = content_of(path)
    if content.startswith(b"AC10"):
        msg = f"{path}: is a DWG drawing; save it as DXF"
        raise GeometryFileError(msg)
    ezdxf = package("ezdxf", "cad", f"{path}: reading DXF")
    try:
        return ezdxf.readfile(path)
    except Exception as error:  # A reader of foreign files fails in as many ways as files can be damaged.
        msg = f"{path}: no readable DXF drawing ({error or type(error).__name__}); save it again as DXF"
        raise GeometryFileError(msg) from error


def _check_unit(drawing: Any, scale: float, path: Path) -> None:
    stated = _STATED_UNITS.get(int(drawing.header.get("$INSUNITS", 0)))
    if stated is not None and abs(stated - scale) > 1e-9 * stated:
        msg = (
            f"{path}: the drawing states that its unit is {stated:g} m ($INSUNITS), unit= says {scale:g} m; "
            "give the unit of the drawing, or correct it there"
        )
        raise GeometryFileError(msg)


def _entities(
    layout: Iterable[Any], left_out: Counter[str], parent: str = "0", depth: int = 0
) -> Iterator[tuple[Any, str]]:
    """Entities with their layers, those inside blocks too: on layer 0 there, they take the layer of the block."""
    for entity in layout:
        layer = entity.dxf.layer if entity.dxf.hasattr("layer") else "0"
        layer = parent if layer == "0" else layer
        if entity.dxftype() != "INSERT":
            yield entity, layer
        elif entity.block() is None:
            left_out[f"block {entity.dxf.get('name', '')!r}, which the drawing does not have"] += 1
        elif depth == _DEPTH:
            left_out[f"block {entity.dxf.name!r}, {_DEPTH} blocks deep"] += 1
        else:

            def skipped(inner: Any, reason: str, layer: str = layer) -> None:
                left_out[f"{inner.dxftype()} in a block on layer {layer} ({reason})"] += 1

            for single in entity.multi_insert() if entity.mcount > 1 else [entity]:
                parts = single.virtual_entities(skipped_entity_callback=skipped)
                yield from _entities(parts, left_out, layer, depth + 1)
