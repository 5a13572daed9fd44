"""Import of blocks from DXF drawings."""

from codecs import BOM_UTF8
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array
from blockstruct.errors import BlockstructError, GeometryFileError, ModelError, shown
from blockstruct.geometry.polygon import Face
from blockstruct.geometry.polyhedron import lofted
from blockstruct.imports.solid import Content, LeftOut, Solid, agreed_scale, check_layers, make_blocks
from blockstruct.imports.source import Imported, Repair, checked_faces, package, read_bytes
from blockstruct.imports.tolerances import DEPTH
from blockstruct.model import Material
from blockstruct.model.fields import MOST, positive_length
from blockstruct.units import QuantityLike


@dataclass(frozen=True, slots=True)
class Outline:
    """A closed outline of a drawing, and its repairs.

    Attributes
    ----------
    corners : (n, 2) array
    rise : float
        Largest rise of an arc over its straight segments.
    gap : float
        Distance of the joined ends.
    retraced : int
        Number of dropped corners, where the outline turns back on itself or repeats.
    """

    corners: Array
    rise: float
    gap: float
    retraced: int


def read_outline(
    points: Array, bulges: Array, segments: int, *, closed: bool, tolerance: float | None
) -> Outline | float:
    """Return the outline of a polyline, or the distance of its ends if it is open.

    A polyline is closed if it is marked as closed, if its ends meet, or if its existing edges cover the gap. Edges
    drawn forth and back are dropped, and repeated rounds after the first.

    Parameters
    ----------
    points : (n, 2) array
    bulges : (n,) array
        As for :func:`divided_arcs`.
    segments
        Number of segments of each arc.
    closed
        Whether the polyline is marked as closed.
    tolerance
        Largest distance of ends that meet; by default a millionth of the size of the polyline.
    """
    size = float(np.ptp(points, axis=0).max())
    gap = float(np.linalg.norm(points[-1] - points[0]))
    # In a polyline marked as closed, close ends are separate corners.
    meets = len(points) > 2 and gap <= (NEGLIGIBLE * size if closed or tolerance is None else tolerance)
    if meets:
        points, bulges = points[:-1], bulges[:-1]
    ring = closed or meets
    bulges = bulges if ring else np.append(bulges[:-1], 0.0)
    path, rise = divided_arcs(points, bulges, segments)
    corners, retraced = _once(path, NEGLIGIBLE * size)
    if not ring:
        # The polyline is closed only if it repeats edges and the outline covers all edges.
        around = shapely.buffer(shapely.linearrings(corners), 2 * NEGLIGIBLE * size) if len(corners) > 2 else None
        if not retraced or not shapely.covers(around, shapely.linestrings(path)):
            return gap
    return Outline(corners, rise, gap if meets else 0.0, retraced)


def _once(ring: Array, rounding: float) -> tuple[Array, int]:
    """Drop edges that run back over the previous edge, and repeated rounds; return corners and number dropped."""
    points = ring @ [1, 1j]
    points = points[np.abs(np.roll(points, -1) - points) > rounding]
    n = len(points)
    turns = (k for k in range(3, n // 2 + 1) if n % k == 0 and np.all(np.abs(points - np.roll(points, k)) <= rounding))
    corners = points[: next(turns, n)].tolist()
    k, steady = 0, 0
    while len(corners) > 2 and steady < len(corners):
        k %= len(corners)
        a, b, c = corners[k - 1], corners[k], corners[(k + 1) % len(corners)]
        if _turns_back(b - a, c - b, rounding):
            del corners[k]
            if abs(c - a) <= rounding:
                del corners[k % len(corners)]
            k, steady = max(k - 2, 0), 0
        else:
            k, steady = k + 1, steady + 1
    kept = np.array(corners)
    return np.column_stack([kept.real, kept.imag]), n - len(corners)


def _turns_back(there: complex, back: complex, rounding: float) -> bool:
    """Whether two successive edges overlap: they lie on one line in opposite directions."""
    product = there.conjugate() * back
    return product.real < 0 and abs(product.imag) <= rounding * max(abs(there), abs(back))


def divided_arcs(points: Array, bulges: Array, segments: int) -> tuple[Array, float]:
    """Divide the arcs of a closed outline into straight segments; return corners and the largest rise over one.

    Parameters
    ----------
    points : (n, 2) array
    bulges : (n,) array
        Tangent of a quarter of the angle of the arc from each corner to the next, counter-clockwise if positive;
        zero for a straight edge.
    segments
        Number of segments of each arc.
    """
    start = points @ [1, 1j]
    chord = np.roll(start, -1) - start
    pieces, rise = [], 0.0
    for p, c, b in zip(start, chord, bulges, strict=True):
        if b == 0:
            pieces.append(np.array([p]))
            continue
        centre = p + c / 2 + 1j * c * (1 - b * b) / (4 * b)
        turn = 4 * np.arctan(b) / segments
        pieces.append(centre + (p - centre) * np.exp(1j * turn * np.arange(segments)))
        rise = max(rise, float(abs(p - centre) * (1 - np.cos(turn / 2))))
    corners = np.concatenate(pieces)
    return np.column_stack([corners.real, corners.imag]), rise


def prism(points: Array, level: float, thickness: float, *, standing: bool) -> tuple[Array, list[Face]]:
    """Return vertices (2n, 3) and outward faces of the prism over an outline (n, 2), from a level by a thickness.

    The thickness may be negative. If ``standing``, x, y and z of the drawing become x, z and y.
    """
    low, high = sorted((level, level + thickness))
    # In a standing drawing z points into the page, which reverses the outlines.
    levels = (high, low) if standing else (low, high)
    vertices, faces = lofted(*(np.insert(points, 1 if standing else 2, z, axis=1) for z in levels))
    return vertices, list(faces)


def enclosed(points: Array) -> float:
    """Return the enclosed area of an outline (n, 2); if it crosses itself, the total area of its loops."""
    outline = shapely.polygons(points)
    return max(float(outline.area), float(shapely.make_valid(outline).area))


def check_expansion(drawing: Any, path: Path, depth: int) -> None:
    """Refuse a drawing whose inserted blocks expand to too many entities, followed to a depth.

    Raises
    ------
    GeometryFileError
        If there are too many. The message names the block in the model space with the most entities.
    """
    known: dict[tuple[str, int], int] = {}

    def inside(name: str, level: int) -> int:
        """Return the number of entities in a block, including nested blocks."""
        key = (name.lower(), level)
        if key not in known:
            known[key] = sum(sizes_of(drawing.blocks.get(name) or (), level)) if level <= depth else 0
        return known[key]

    def sizes_of(entities: Iterable[Any], level: int) -> Iterable[int]:
        for entity in entities:
            yield 1
            if entity.dxftype() == "INSERT":
                yield _copies(entity) * (1 + inside(_name(entity), level + 1))

    inserts = [e for e in drawing.modelspace() if e.dxftype() == "INSERT"]
    sizes = [_copies(e) * (1 + inside(_name(e), 1)) for e in inserts]
    if sum(sizes) > MOST:
        worst = inserts[sizes.index(max(sizes))]
        msg = (
            f"{path}: its blocks expand to {sum(sizes):.3g} entities, block {_name(worst)!r} alone to "
            f"{max(sizes):.3g}, the limit is {MOST}; remove entities that are not stones, or draw fewer copies"
        )
        raise GeometryFileError(msg)


def _name(insert: Any) -> str:
    return str(insert.dxf.get("name", ""))


def _copies(insert: Any) -> int:
    """Return rows times columns in the file, at most a billion."""
    rows, columns = (int(insert.dxf.get(f"{what}_count", 1)) for what in ("row", "column"))
    return min(max(1, rows) * max(1, columns), 10**9)


#: Units of a drawing in m, by their code in $INSUNITS, from microinches to miles.
_STATED_UNITS = {
    **{1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 1e-3, 5: 1e-2, 6: 1.0, 7: 1e3, 8: 2.54e-8, 9: 2.54e-5, 10: 0.9144},
    **{13: 1e-6, 14: 0.1, 15: 10.0, 16: 100.0},
    # The foot, inch, yard and mile of surveys.
    **{code: feet * 1200 / 3937 for code, feet in ((21, 1), (22, 1 / 12), (23, 3), (24, 5280))},
}
#: Bodies without faces in the file: only the program that wrote them can compute the faces.
_SOLID_MODELS = ("3DSOLID", "BODY", "EXTRUDEDSURFACE", "LOFTEDSURFACE", "REVOLVEDSURFACE", "SURFACE", "SWEPTSURFACE")
#: Group codes of numbers.
_NUMERIC = {*range(10, 100), *range(110, 180), *range(210, 240), *range(270, 290), *range(370, 390), *range(400, 410)}
_NUMERIC |= {*range(420, 430), *range(440, 470), *range(1010, 1072)}


def read_drawing(  # noqa: PLR0913
    file: str | Path,
    *,
    unit: QuantityLike,
    material: Material | Mapping[str, Material],
    override_unit: bool = False,
    thickness: QuantityLike | None = None,
    plane: str = "elevation",
    segments: int | None = None,
    closing: QuantityLike | None = None,
    supports: Iterable[str] = (),
    fixed: str | Iterable[str] = (),
    exclude: Iterable[str] = (),
    tolerance: QuantityLike | None = None,
) -> Imported:
    """Read the blocks of a DXF drawing. Needs ``pip install "blockstruct[cad]"``.

    Closed polylines become prisms. Meshes, polyface meshes and closed sets of 3D faces become blocks. The name of the
    k-th block on a layer is ``layer.k``. A polyline counts as closed if its ends meet up to rounding. Repeated edges
    are dropped and reported. Everything else is ignored and reported by layer and handle: open polylines with the
    distance of their ends, hidden entities, layers that are off or frozen, paper space, and external references.

    Parameters
    ----------
    file
        A ``.dxf`` file.
    unit : text or quantity, length
        Unit of the coordinates: ``"mm"``, or a scale such as ``"0.025 m"``. If the drawing states its unit, the two
        must agree.
    material
        Material of all blocks, or a material per layer. Layers without a material are ignored.
    override_unit
        Whether ``unit`` overrides the unit in the drawing: ``$INSUNITS`` often comes from a template.
    thickness : quantity, length
        Thickness of the prisms. Not needed for polylines with a thickness in the drawing. If the latter is negative, or
        the polyline was drawn from the back, the prism is on the other side.
    plane : {"elevation", "plan"}
        ``"elevation"`` turns x, y and z of the drawing into x, z and y. Prisms extend from y = 0, or from the elevation
        of their polyline, by the thickness. ``"plan"`` keeps x, y and z, and prisms rise from z = 0 or from the
        elevation. Bodies in 3D keep their coordinates.
    segments
        Number of straight segments per arc of a polyline. Without it, arcs are refused.
    closing : quantity, length
        Largest distance of the ends of a closed polyline; by default a millionth of its size.
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
        If the file is damaged, the units differ, arcs have no ``segments``, or solids are not blocks.
    MissingExtraError
        If ezdxf is not installed.
    UnknownNameError
        If the drawing does not have a layer.

    Warns
    -----
    GeometryWarning
        If something was ignored or repaired.
    """
    path = Path(file)
    content = drawing_content(path, unit, material, override_unit, thickness, plane, segments, closing, supports)
    return make_blocks([content], [path], unit=unit, fixed=fixed, exclude=exclude, up="z", tolerance=tolerance)


def drawing_content(  # noqa: PLR0913
    path: Path,
    unit: QuantityLike,
    material: Material | Mapping[str, Material],
    override_unit: bool = False,
    thickness: QuantityLike | None = None,
    plane: str = "elevation",
    segments: int | None = None,
    closing: QuantityLike | None = None,
    supports: Iterable[str] = (),
) -> Content:
    """Return the content of a DXF drawing; parameters as for :func:`read_drawing`."""
    drawing = _opened(path)
    stated = _STATED_UNITS.get(int(drawing.header.get("$INSUNITS", 0)))
    scale, notes = agreed_scale(unit, stated, path, override=override_unit, where=" ($INSUNITS)")
    depth = None if thickness is None else positive_length(thickness, f"{path}: thickness") / scale
    ends = None if closing is None else positive_length(closing, f"{path}: closing") / scale
    if plane not in ("elevation", "plan"):
        msg = f"{path}: plane is {shown(plane)}; give 'elevation' or 'plan'"
        raise ModelError(msg)
    if segments is not None and (not isinstance(segments, int) or segments < 1):
        msg = f"{path}: segments is {shown(segments)}; give a whole number of straight pieces for each arc, one or more"
        raise ModelError(msg)
    check_expansion(drawing, path, DEPTH)
    frozen = frozenset(layer.dxf.name.lower() for layer in drawing.layers if layer.is_frozen())
    fixed_layers = {supports} if isinstance(supports, str) else set(supports)
    reading = _Reading(path, scale, depth, plane == "elevation", segments, ends, frozen, material, fixed_layers)
    layers = {layer.dxf.name: layer for layer in drawing.layers}
    # DXF ignores the case of layer names, and entities may be on layers outside the table.
    listed = {name.lower(): name for name in layers}
    entities = [(e, listed.get(name.lower(), name), h) for e, name, h in _entities(drawing.modelspace(), reading)]
    known = {*layers, *(layer for _, layer, _ in entities)}
    of_layers = material if isinstance(material, Mapping) else known
    check_layers({*of_layers, *fixed_layers}, known, path)
    for entity, layer, handle in entities:
        if layer in layers and (layers[layer].is_off() or layers[layer].is_frozen()):
            reading.left_out.add(f"{entity.dxftype()} on layer {layer}, which is off or frozen", handle)
        elif entity.dxf.get("invisible", 0):
            reading.left_out.add(f"{entity.dxftype()} on layer {layer}, which is hidden", handle)
        elif layer not in of_layers:
            reading.left_out.add(f"{entity.dxftype()} on layer {layer}, which has no material", handle)
        else:
            reading.add(entity, layer, handle)
    _leave_out_paper_space(drawing, listed, reading)
    for layer, corners in reading.loose.items():
        starts = np.cumsum([0, *(len(c) for c in corners)])
        faces = [tuple(range(a, a + len(c))) for a, c in zip(starts.tolist(), corners, strict=False)]
        reading.add_body(layer, np.concatenate(corners), faces)
    checked_faces(sum(len(body.faces) for body in reading.bodies), path)
    return Content(reading.bodies, reading.left_out.texts("handle "), reading.repairs, notes)


@dataclass(slots=True)
class _Reading:
    """Content of a drawing during reading, by layer and in coordinate units."""

    path: Path
    scale: float
    thickness: float | None
    standing: bool
    segments: int | None
    closing: float | None
    frozen: frozenset[str]
    material: Material | Mapping[str, Material]
    supports: set[str]
    bodies: list[Solid] = field(default_factory=list)
    count: Counter[str] = field(default_factory=Counter)
    loose: dict[str, list[Array]] = field(default_factory=dict)
    repairs: list[Repair] = field(default_factory=list)
    left_out: LeftOut = field(default_factory=LeftOut)

    def add(self, entity: Any, layer: str, handle: str) -> None:
        """Add an entity, or note that it is ignored."""
        try:
            self._add(entity, layer, handle)
        except BlockstructError:
            raise
        except Exception as error:  # A damaged entity may raise any error.
            msg = (
                f"{self.path}: {entity.dxftype()} on layer {layer!r}, handle {handle}, is damaged ({error}); "
                "draw it again"
            )
            raise GeometryFileError(msg) from error

    def add_body(self, layer: str, vertices: Array, faces: list[Face]) -> str:
        """Add a body with the next number of its layer; return its name."""
        self.count[layer] += 1
        name = f"{layer}.{self.count[layer]}"
        stone = self.material[layer] if isinstance(self.material, Mapping) else self.material
        self.bodies.append(Solid(name, vertices, faces, stone, layer in self.supports))
        return name

    def _add(self, entity: Any, layer: str, handle: str) -> None:
        kind = entity.dxftype()
        if kind == "LWPOLYLINE":
            corners = [(x, y, entity.dxf.elevation, bulge) for x, y, bulge in entity.get_points("xyb")]
            self._polyline(entity, layer, handle, corners, closed=entity.closed)
        elif kind == "POLYLINE" and entity.is_2d_polyline:
            level = entity.dxf.elevation.z
            # The control points of a fitted spline are not on the curve.
            control = package("ezdxf.lldxf.const", "cad", str(self.path)).VTX_SPLINE_FRAME_CONTROL_POINT
            drawn = [v for v in entity.vertices if not v.dxf.flags & control]
            corners = [(v.dxf.location.x, v.dxf.location.y, level, v.dxf.bulge) for v in drawn]
            self._polyline(entity, layer, handle, corners, closed=entity.is_closed)
        elif kind == "MESH" and entity.dxf.get("subdivision_levels", 0):
            self.left_out.add(f"MESH on layer {layer} that is drawn smoothed, to be drawn at smoothness 0", handle)
        elif kind == "MESH" or (kind == "POLYLINE" and (entity.is_poly_face_mesh or entity.is_polygon_mesh)):
            builder = package("ezdxf.render", "cad", str(self.path)).MeshBuilder
            mesh = builder.from_mesh(entity) if kind == "MESH" else builder.from_polyface(entity)
            vertices = np.array([tuple(v) for v in mesh.vertices], dtype=float).reshape(-1, 3)
            self.add_body(layer, vertices, [tuple(map(int, face)) for face in mesh.faces])
        elif kind == "3DFACE":
            self.loose.setdefault(layer, []).append(np.array([tuple(v) for v in entity.wcs_vertices()], dtype=float))
        else:
            remedy = ", to be exported as a mesh" if kind in _SOLID_MODELS else ""
            self.left_out.add(f"{kind} on layer {layer}{remedy}", handle)

    def _polyline(
        self, entity: Any, layer: str, handle: str, corners: list[tuple[float, float, float, float]], *, closed: bool
    ) -> None:
        if len(corners) < 2:
            self.left_out.add(f"polyline of fewer than two corners on layer {layer}", handle)
            return
        ocs = entity.ocs()
        if abs(ocs.uz.z) < 1 - ROUNDING:
            remedy = "to be drawn in it or exported as a mesh"
            self.left_out.add(f"polyline out of the drawing plane on layer {layer}, {remedy}", handle)
            return
        points = np.array([tuple(ocs.to_wcs(c[:3])) for c in corners], dtype=float)
        x, y, level = points[0]
        who = f"{self.path}: the polyline from ({x:.6g}, {y:.6g}) on layer {layer!r}, handle {handle},"
        # Seen from below, an arc has the opposite direction.
        bulges = np.array([c[3] for c in corners]) * np.sign(ocs.uz.z)
        outline = read_outline(
            points[:, :2], bulges, closed=closed, segments=self.segments or 1, tolerance=self.closing
        )
        if isinstance(outline, float):
            gap = f"(ends {outline * self.scale:.3g} m apart)"
            self.left_out.add(f"open polyline on layer {layer}", f"{handle} {gap}")
            return
        if np.any(bulges) and self.segments is None:
            msg = f"{who} has arcs; give segments, the number of straight pieces for each arc"
            raise GeometryFileError(msg)
        size = float(np.ptp(points, axis=0).max())
        if len(outline.corners) < 3 or enclosed(outline.corners) <= NEGLIGIBLE * size**2:
            self.left_out.add(f"polyline without area on layer {layer}", handle)
            return
        # Signed thickness along z; the normal of the polyline may look down.
        signed = entity.dxf.get("thickness", 0.0) * float(np.sign(ocs.uz.z))
        thickness = self.thickness or abs(signed)
        if not thickness:
            msg = f"{who} is flat; give a thickness"
            raise GeometryFileError(msg)
        side = -1 if signed < 0 else 1
        body = prism(outline.corners, float(level), side * thickness, standing=self.standing)
        name = self.add_body(layer, *body)
        done = {"arcs": outline.rise * self.scale, "retraced": outline.retraced}
        if outline.gap > NEGLIGIBLE * size:
            done["closed"] = outline.gap * self.scale
        self.repairs += [Repair(name, kind, amount) for kind, amount in done.items() if amount]


def _opened(path: Path) -> Any:
    content = read_bytes(path)
    if content.startswith(b"AC10"):
        msg = f"{path}: is a DWG drawing; save it as DXF"
        raise GeometryFileError(msg)
    ezdxf = package("ezdxf", "cad", f"{path}: reading DXF")
    try:
        if content.startswith(b"AutoCAD Binary DXF"):
            tags = package("ezdxf.lldxf.tagger", "cad", str(path)).binary_tags_loader(content)
            return package("ezdxf.document", "cad", str(path)).Drawing.load(tags)
        # Versions before 2007 state the encoding of their texts in the header, which is ASCII.
        header = StringIO(content.decode("utf-8-sig", errors="ignore"), newline=None)
        encoding = package("ezdxf.filemanagement", "cad", str(path)).dxf_stream_info(header).encoding
        text = content.removeprefix(BOM_UTF8).decode(encoding, errors="surrogateescape")
        _check_numbers(text)
        return ezdxf.read(StringIO(text, newline=None))
    except Exception as error:  # A damaged file may raise any error.
        msg = f"{path}: not a readable DXF drawing ({error or type(error).__name__}); save it again as DXF"
        raise GeometryFileError(msg) from error


def _check_numbers(text: str) -> None:
    """Refuse group codes and numbers that only Python reads as such, ``1_0`` for instance."""
    # Lines end as ezdxf reads them: texts may hold other separators.
    lines = StringIO(text, newline=None).read().split("\n")
    for number, (code, value) in enumerate(zip(lines[::2], lines[1::2], strict=False)):
        if _is_foreign(code) or (int(code) in _NUMERIC and _is_foreign(value)):
            msg = f"{value.strip()[:60]!r} in line {2 * number + 2} is not a number"
            raise ValueError(msg)
        if int(code) == 0 and value.strip() == "EOF":
            return


def _is_foreign(number: str) -> bool:
    return "_" in number or not number.isascii()


def _leave_out_paper_space(drawing: Any, listed: Mapping[str, str], reading: _Reading) -> None:
    """Note the entities in paper space, except viewports, which show the model space."""
    for sheet in drawing.layouts:
        drawn = [] if sheet.is_modelspace else [e for e in sheet if e.dxftype() != "VIEWPORT"]
        for entity in drawn:
            layer = entity.dxf.layer if entity.dxf.hasattr("layer") else "0"
            layer = listed.get(layer.lower(), layer)
            reading.left_out.add(f"{entity.dxftype()} on layer {layer} in paper space, {sheet.name}", entity.dxf.handle)


def _entities(
    layout: Iterable[Any], reading: _Reading, parent: str = "0", within: str = "", depth: int = 0
) -> Iterator[tuple[Any, str, str]]:
    """Yield entities with their layers and handles, including entities inside blocks.

    Entities inside a block have the handle of the insert. On layer 0 they take the layer of the block.
    """
    for entity in layout:
        layer = entity.dxf.layer if entity.dxf.hasattr("layer") else "0"
        layer = parent if layer == "0" else layer
        handle = within or entity.dxf.handle
        if entity.dxftype() != "INSERT":
            yield entity, layer, handle
        elif (block := entity.block()) is None:
            reading.left_out.add(f"block {entity.dxf.get('name', '')!r}, which the drawing does not have", handle)
        elif block.block.is_xref or block.block.is_xref_overlay:
            reading.left_out.add(f"block {entity.dxf.name!r}, another drawing, to be bound to this one", handle)
        elif layer.lower() in reading.frozen or entity.dxf.get("invisible", 0):
            # A frozen or hidden insert hides the whole block. If its layer is off, the layers inside count.
            reading.left_out.add(f"block {entity.dxf.name!r} on layer {layer}, which is hidden or frozen there", handle)
        elif depth == DEPTH:
            reading.left_out.add(f"block {entity.dxf.name!r}, {DEPTH} blocks deep", handle)
        else:

            def skipped(inner: Any, reason: str, layer: str = layer, handle: str = handle) -> None:
                reading.left_out.add(f"{inner.dxftype()} in a block on layer {layer} ({reason})", handle)

            for single in entity.multi_insert() if entity.mcount > 1 else [entity]:
                parts = single.virtual_entities(skipped_entity_callback=skipped)
                yield from _entities(parts, reading, layer, handle, depth + 1)
