"""Blocks from DXF drawings."""

import sys
from itertools import pairwise

import ezdxf
import numpy as np
import pytest
import shapely
from ezdxf.render import MeshBuilder

import blockstruct as bs
from blockstruct.imports.drawing import divided_arcs, read_outline
from meshes import CUBE, QUADS
from refusals import refused
from structures import STONE

TUFF = bs.Material("tuff", "12 kN/m^3")
JOINT = bs.JointMaterial("joint", 0.6)
MM = 4


@pytest.fixture
def space():
    """The model space of a drawing in mm with layers."""
    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = MM
    for layer in ("STONE", "GROUND", "NOTES"):
        document.layers.add(layer)
    return document.modelspace()


@pytest.fixture
def read(space, tmp_path):
    """Save the drawing and read it, or read another file."""

    def read(path=None, **options):
        space.doc.saveas(tmp_path / "drawing.dxf")
        chosen = {"unit": "mm", "material": STONE, "thickness": "0.3 m"} | options
        return bs.imports.read_drawing(path or tmp_path / "drawing.dxf", **chosen)

    return read


def rectangle(space, x, y, width, height, layer="STONE", **attributes):
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    return space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer} | attributes)


def test_an_elevation_in_millimetres(space, read):
    rectangle(space, 0, -200, 1000, 200, "GROUND")
    for row in range(4):
        for x, width in [(0, 500), (500, 500)] if row % 2 == 0 else [(0, 250), (250, 500), (750, 250)]:
            rectangle(space, x, 200 * row, width, 200)
    found = read(supports="GROUND")
    assert [b.name for b in found.blocks[:3]] == ["GROUND.1", "STONE.1", "STONE.2"]
    assert found.report.supports == ("GROUND.1",)
    assert found.report.extent == pytest.approx((1, 0.3, 1))
    assert found.report.repairs == ()
    size = {"unit_length": "0.5 m", "unit_height": "0.2 m", "thickness": "0.3 m"}
    stones = bs.courses([[1, 1], [0.5, 1, 0.5]] * 2, **size, material=STONE)
    for a, b in zip(found.blocks, stones, strict=True):
        assert a.centroid == pytest.approx(b.centroid)
        assert a.volume == pytest.approx(b.volume)
    reports = [bs.detect_interfaces(blocks, joint_material=JOINT).report for blocks in (found.blocks, stones)]
    assert reports[0].accepted == reports[1].accepted
    assert reports[0].total_area == pytest.approx(reports[1].total_area)


@pytest.mark.parametrize("bulge", [1, -1, np.tan(np.pi / 8), 0.1, 3])
def test_corners_of_arcs_are_on_the_circle(bulge):
    # Over the chord from (0, 0) to (2, 0) the arc rises by the bulge, to the right of it if positive.
    points, rise = divided_arcs(np.array([(0.0, 0.0), (2.0, 0.0)]), np.array([bulge, 0.0]), 10)
    assert points[0] == pytest.approx((0, 0))
    assert points[5] == pytest.approx((1, -bulge))
    assert points[10] == pytest.approx((2, 0))
    radius = (1 + bulge**2) / (2 * abs(bulge))
    assert rise == pytest.approx(radius * (1 - np.cos(4 * np.arctan(abs(bulge)) / 20)))


def voussoirs(space, n, inner, outer):
    """A semicircular arch of n voussoirs between true arcs."""
    angles = np.linspace(0, np.pi, n + 1)
    bulge = np.tan(np.pi / n / 4)
    for a, b in pairwise(angles):
        corners = [(r * np.cos(t), r * np.sin(t)) for r, t in ((outer, a), (outer, b), (inner, b), (inner, a))]
        points = [(*at, turn) for at, turn in zip(corners, (bulge, 0, -bulge, 0), strict=True)]
        space.add_lwpolyline(points, format="xyb", close=True, dxfattribs={"layer": "STONE"})


def test_arcs_need_segments(space, read):
    voussoirs(space, 9, 1900, 2100)
    with pytest.raises(bs.errors.GeometryFileError, match="segments"):
        read()
    with pytest.warns(bs.errors.GeometryWarning, match="arcs .* m"):
        found = read(segments=6)
    rise = 2.1 * (1 - np.cos(np.pi / 9 / 12))
    assert found.report.table().query("kind == 'arcs'").amount.max() == pytest.approx(rise)
    # Of a polygon between the arcs: r² sin(θ)/2 for each of 54 pieces of θ = 180°/54.
    area = 54 * (2.1**2 - 1.9**2) * np.sin(np.pi / 54) / 2
    assert found.report.volume == pytest.approx(0.3 * area)
    assert bs.detect_interfaces(found.blocks, joint_material=JOINT).report.accepted == 8


def cube_at(x):
    return [(400 * a + x, 400.0 * b, 400.0 * c) for a, b, c in CUBE], QUADS


def test_bodies_in_three_dimensions(space, read):
    vertices, faces = cube_at(0)
    with space.add_mesh(dxfattribs={"layer": "GROUND"}).edit_data() as mesh:
        mesh.vertices, mesh.faces = vertices, faces
    for x in (400, 800):
        vertices, faces = cube_at(x)
        for face in faces:
            space.add_3dface([vertices[i] for i in face], dxfattribs={"layer": "STONE"})

    builder = MeshBuilder()
    builder.add_mesh(vertices=cube_at(1200)[0], faces=cube_at(1200)[1])
    builder.render_polyface(space, dxfattribs={"layer": "STONE"})
    found = read(supports=["GROUND"], thickness=None)
    assert [b.volume for b in found.blocks] == pytest.approx([0.4**3] * 4)
    assert sorted(b.centroid[0] for b in found.blocks) == pytest.approx([0.2, 0.6, 1.0, 1.4])
    assert bs.detect_interfaces(found.blocks, joint_material=JOINT).report.accepted == 3


def test_layers_have_materials_and_ignored_entities_are_reported(space, read):
    rectangle(space, 0, 0, 500, 250)
    rectangle(space, 0, -250, 500, 250, "GROUND")
    rectangle(space, 900, 0, 100, 100, "NOTES")
    space.add_text("elevation", dxfattribs={"layer": "NOTES"})
    line = space.add_lwpolyline([(0, 0), (400, 0), (400, 300)], dxfattribs={"layer": "STONE"})
    space.add_circle((0, 0), 100, dxfattribs={"layer": "STONE"})
    left = "left out: 1 CIRCLE on layer STONE .*; 1 LWPOLYLINE on layer NOTES"
    with pytest.warns(bs.errors.GeometryWarning, match=left):
        found = read(material={"STONE": TUFF, "GROUND": STONE})
    assert {b.name: b.material.name for b in found.blocks} == {"STONE.1": "tuff", "GROUND.1": "stone"}
    handle = f"(handle {line.dxf.handle} (ends 0.5 m apart))"
    assert f"1 open polyline on layer STONE {handle}" in found.report.left_out
    space.doc.layers.get("GROUND").off()
    with pytest.warns(bs.errors.GeometryWarning, match="LWPOLYLINE on layer GROUND, which is off or frozen"):
        assert len(read(material={"STONE": TUFF, "GROUND": STONE}).blocks) == 1


def test_blocks_of_the_drawing_are_followed(space, read):
    unit = space.doc.blocks.new("UNIT")
    rectangle(unit, 0, 0, 500, 250, "0")
    for x in (0, 500):
        space.add_blockref("UNIT", (x, 0), dxfattribs={"layer": "STONE"})
    # Mirrored: what was seen from above is seen from below.
    space.add_blockref("UNIT", (1500, 0), dxfattribs={"layer": "GROUND", "xscale": -1})
    found = read(material={"STONE": STONE, "GROUND": TUFF})
    assert [b.name for b in found.blocks] == ["STONE.1", "STONE.2", "GROUND.1"]
    assert [b.centroid[0] for b in found.blocks] == pytest.approx([0.25, 0.75, 1.25])


SQUARE = [(0, 0), (500, 0), (500, 250), (0, 250)]


def line(*corners, closed=False):
    return lambda space: space.add_lwpolyline(corners, close=closed, dxfattribs={"layer": "STONE"})


def other_drawing(space):
    space.doc.add_xref_def("other.dxf", "OTHER")
    space.add_blockref("OTHER", (0, 0))


def frozen_unit(space):
    space.doc.layers.get("NOTES").freeze()
    rectangle(space.doc.blocks.new("UNIT"), 0, 0, 500, 250, "STONE")
    space.add_blockref("UNIT", (0, 0), dxfattribs={"layer": "NOTES"})


def smoothed_mesh(space):
    mesh = space.add_mesh(dxfattribs={"layer": "STONE", "subdivision_levels": 2})
    with mesh.edit_data() as data:
        data.vertices, data.faces = cube_at(0)


def on_paper(space):
    sheet = space.doc.layout("Layout1")
    sheet.add_viewport(center=(100, 100), size=(50, 50), view_center_point=(0, 0), view_height=500)
    return rectangle(sheet, 0, 500, 1000, 500, "stone")


@pytest.mark.parametrize(
    ("add", "words"),
    [
        (lambda space: rectangle(space, 0, 0, 500, 250, invisible=1), "1 LWPOLYLINE on layer STONE"),
        (other_drawing, "1 block 'OTHER'"),
        (frozen_unit, "1 block 'UNIT' on layer NOTES"),
        (smoothed_mesh, "1 MESH on layer STONE"),
        (lambda space: rectangle(space, 0, 0, 9, 9, extrusion=(0, -1, 0)), "1 polyline out of the drawing plane"),
        (line(*SQUARE), "1 open polyline on layer STONE (handle {} (ends 0.25 m apart))"),
        (line((0, 0), (200, 100), *SQUARE[1:], (0, 0), (100, 100)), "STONE (handle {} (ends 0.141 m apart))"),
        (line(*SQUARE[:2], closed=True), "1 polyline without area on layer STONE (handle {})"),
        (line(*SQUARE[:2], (200, 0), closed=True), "1 polyline without area on layer STONE (handle {})"),
        (on_paper, "1 LWPOLYLINE on layer STONE in paper space, Layout1 (handle {})"),
    ],
)
def test_what_is_left_out_is_reported(space, read, add, words):
    rectangle(space, 0, 250, 500, 250)
    added = add(space)
    with pytest.warns(bs.errors.GeometryWarning, match="left out"):
        found = read()
    assert [b.centroid[2] for b in found.blocks] == pytest.approx([0.375])
    assert words.format(added and added.dxf.handle) in "; ".join(found.report.left_out)


def test_control_points_of_a_spline_are_ignored(space, read):
    corners = [(0, 0), (500, -90), (500, 0), (500, 250), (250, 400), (0, 250)]
    fitted = space.add_polyline2d(corners, close=True, dxfattribs={"layer": "STONE", "flags": 1 | 4})
    for vertex, flag in zip(fitted.vertices, (8, 16, 8, 8, 16, 8), strict=True):
        vertex.dxf.flags = flag
    (block,) = read().blocks
    assert block.volume == pytest.approx(0.5 * 0.25 * 0.3)


@pytest.mark.parametrize("given", [None, "0.7 m"])
@pytest.mark.parametrize(("plane", "axis"), [("elevation", 1), ("plan", 2)])
@pytest.mark.parametrize(
    ("attributes", "reach"),
    [
        ({"thickness": 700}, (0, 0.7)),
        ({"thickness": 700, "elevation": -100}, (-0.1, 0.6)),
        ({"thickness": -700, "elevation": 1000}, (0.3, 1)),
        ({"thickness": 700, "elevation": -2000, "extrusion": (0, 0, -1)}, (1.3, 2)),
        ({"thickness": -700, "elevation": -2000, "extrusion": (0, 0, -1)}, (2, 2.7)),
    ],
)
def test_the_sign_of_a_thickness_gives_the_side_of_the_prism(space, read, plane, axis, attributes, reach, given):
    rectangle(space, 0, 0, 500, 250, **attributes)
    (block,) = read(plane=plane, thickness=given).blocks
    along = block.shape.vertices[:, axis]
    assert (along.min(), along.max()) == pytest.approx(reach)
    # Seen from behind, x of the drawing runs the other way.
    assert block.centroid[0] == pytest.approx(-0.25 if "extrusion" in attributes else 0.25)
    assert block.shape.volume == pytest.approx(0.5 * 0.25 * 0.7)


def test_the_closing_gap(space, read):
    rectangle(space, 600, 0, 500, 250)
    line(*SQUARE, (0, 3))(space)
    with pytest.warns(bs.errors.GeometryWarning, match=r"1 open polyline on layer STONE .*\(ends 0.003 m apart\)"):
        assert len(read(closing="2 mm").blocks) == 1
    closed = r"outlines closed whose ends lie apart by up to 0.003 m \(STONE.2\)"
    with pytest.warns(bs.errors.GeometryWarning, match=closed):
        found = read(closing="4 mm")
    assert found.blocks[1].volume == pytest.approx(0.5 * 0.25 * 0.3)


@pytest.mark.parametrize(
    ("corners", "closed"),
    [
        ([*SQUARE, SQUARE[0], (200, 0)], False),  # on over a part of the first edge
        ([*SQUARE, *SQUARE], True),  # twice round
        ([*SQUARE[:2], (700, -300), (900, 100), (700, -300), *SQUARE[1:]], True),  # out into the open, and back
        ([*SQUARE[:2], (500, 150), (500, 50), *SQUARE[2:]], True),  # back a part of the way
    ],
)
def test_edges_that_are_retraced_are_dropped_and_reported(space, read, corners, closed):
    line(*corners, closed=closed)(space)
    with pytest.warns(bs.errors.GeometryWarning, match=r"runs over its own edges again: \d+ \(STONE.1\)"):
        (block,) = read().blocks
    assert (block.volume, len(block.shape.faces)) == (pytest.approx(0.5 * 0.25 * 0.3), 6)


@pytest.mark.parametrize("seed", range(20))
def test_random_repeated_outlines_are_restored(seed):
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(5, 12)))
    outline = np.column_stack([np.cos(angles), np.sin(angles)]) * rng.uniform(0.5, 1, len(angles))[:, None]
    outline = outline * 10 ** rng.uniform(-3, 6) + rng.normal(size=2)
    drawn = list(outline)
    for k in sorted(rng.integers(1, len(outline), 3).tolist(), reverse=True):
        share = rng.uniform(0.1, 0.9)
        back = outline[k] + share * (outline[k - 1] - outline[k])
        drawn[k + 1 : k + 1] = [back, outline[k]]
    found = read_outline(np.array(drawn), np.zeros(len(drawn)), 1, closed=True, tolerance=None)
    ring, expected = map(shapely.LinearRing, (found.corners, outline))
    assert ring.is_ccw == expected.is_ccw
    assert shapely.Polygon(ring).area == pytest.approx(shapely.Polygon(expected).area, rel=1e-9)
    assert found.retraced >= 3


def test_copies_must_have_the_same_material_and_support(space, read):
    rectangle(space, 0, 0, 500, 250)
    rectangle(space, 0, 0, 500, 250, "GROUND")
    with pytest.warns(bs.errors.GeometryWarning, match=r"dropped: 1 \(GROUND.1 = STONE.1\)"):
        assert [b.name for b in read().blocks] == ["STONE.1"]
    for options in ({"supports": ["GROUND"]}, {"material": {"STONE": TUFF, "GROUND": STONE}}):
        with refused(bs.errors.GeometryFileError, "'STONE.1' 'GROUND.1'"):
            read(**options)
    assert [b.name for b in read(supports=["GROUND"], exclude="STONE.*").blocks] == ["GROUND.1"]


def test_override_unit(space, read):
    rectangle(space, 0, 0, 5000, 2500)
    for number, stated in ((16, "100 m"), (22, "0.0254001 m"), (1, "0.0254 m")):
        space.doc.header["$INSUNITS"] = number
        with pytest.raises(bs.errors.GeometryFileError, match=rf"{stated} \(\$INSUNITS\), .*override_unit=True"):
            read()
    found = read(override_unit=True)
    assert found.report.extent == pytest.approx((5, 0.3, 2.5))
    (note,) = found.report.notes
    assert "0.0254 m" in note
    space.doc.header["$INSUNITS"] = MM
    assert read(override_unit=True).report.notes == ()


@pytest.mark.parametrize(
    ("error", "words", "options"),
    [
        (bs.errors.GeometryFileError, "0.001 m $INSUNITS 1 m", {"unit": "m"}),
        (bs.errors.ModelError, "thickness -1 m", {"thickness": "-1 m"}),
        (bs.errors.GeometryFileError, "polyline from (0, 0) 'STONE' handle flat", {"thickness": None}),
        (bs.errors.ModelError, "plane 'section' 'elevation'", {"plane": "section"}),
        (bs.errors.ModelError, "segments 0", {"segments": 0}),
        (bs.errors.UnknownNameError, "'GROND' GROUND, NOTES, STONE", {"supports": ["GROND"]}),
    ],
)
def test_refused_options(space, read, error, words, options):
    rectangle(space, 0, 0, 500, 250)
    with refused(error, f"drawing.dxf {words}"):
        read(**options)


def test_damaged_drawings_are_refused(space, read, tmp_path, monkeypatch):
    space.add_circle((0, 0), 100)
    space.add_3dsolid().sat = ["700 0 1 0", "End-of-ACIS-data"]
    left = r"left out: 1 3DSOLID on layer 0, to be exported as a mesh .*; 1 CIRCLE on layer 0"
    with pytest.raises(bs.errors.GeometryFileError, match=rf"holds no solid \({left}"):
        read()
    space.delete_all_entities()
    rectangle(space, 0, 0, 500, 250)
    bow_tie = space.add_lwpolyline([(0, 0), (100, 100), (100, 0), (0, 300)], close=True)
    with pytest.raises(bs.errors.GeometryFileError, match=r"'0.1': its surface crosses itself"):
        read()
    space.delete_entity(bow_tie)
    space.add_polyline2d([(0, 0), (1, 0), (1, 1)], close=True).vertices[0].dxf.discard("location")
    with pytest.raises(bs.errors.GeometryFileError, match=r"POLYLINE on layer '0', handle .*, is damaged"):
        read()
    content = (tmp_path / "drawing.dxf").read_bytes()
    half, cut = content[: len(content) // 2], content[:-40]
    for bad in (b"", half, cut, bytes(range(256)) * 20, b"no drawing\n", b"AC1032" + bytes(100)):
        (tmp_path / "bad.dxf").write_bytes(bad)
        with pytest.raises(bs.errors.GeometryFileError, match=r"bad\.dxf"):
            read(tmp_path / "bad.dxf")
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    with pytest.raises(bs.errors.MissingExtraError, match=r'pip install "blockstruct\[cad\]"'):
        read()


@pytest.mark.parametrize("ending", [b"\n", b"\r\n"])
def test_a_byte_order_mark_is_ignored(space, read, tmp_path, ending):
    """As editors put one before a text that they save, and as OBJ and YAML files are read."""
    space.doc.layers.add("PIÈRRE")
    rectangle(space, 0, 0, 1000, 500, "PIÈRRE")
    (plain,) = read().blocks
    content = (tmp_path / "drawing.dxf").read_bytes().replace(b"\r\n", b"\n").replace(b"\n", ending)
    (tmp_path / "marked.dxf").write_bytes(b"\xef\xbb\xbf" + content)
    (marked,) = read(tmp_path / "marked.dxf").blocks
    assert marked.name == plain.name == "PIÈRRE.1"
    np.testing.assert_array_equal(marked.shape.vertices, plain.shape.vertices)
