"""Blocks from meshes, and damaged and hostile meshes: one clear refusal each, that names the file and the remedy."""

import sys
import warnings
from contextlib import nullcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import blockstruct as bs
from blockstruct.imports.surface import closed_surface
from meshes import CUBE, QUADS, ascii_stl, fans, obj_text, objects_text, ply_text, read, saved, stl_bytes
from properties import few
from refusals import refused
from structures import STONE, box, moved, rotation

JOINT, CUBES = bs.JointMaterial("joint", 0.6), [box("b", [0, 0, 0])]
STL, PLY = stl_bytes(CUBES), ply_text(CUBES)
ROWS = [[1, 1, 1], [0.5, 1, 1, 0.5], [1, 1, 1]]
#: Its coordinates are exact in single precision.
WALL = bs.courses(ROWS, unit_length="0.5 m", unit_height="0.25 m", thickness="0.25 m", material=STONE)


def same_bodies(one, other, rel=1e-9):
    """Blocks of the same places and sizes, in the same order."""
    assert len(one) == len(other)
    for a, b in zip(one, other, strict=True):
        assert a.volume == pytest.approx(b.volume, rel=rel)
        assert a.centroid == pytest.approx(b.centroid, abs=rel)
        assert sorted(map(len, a.shape.faces)) == sorted(map(len, b.shape.faces))


@pytest.mark.parametrize(("name", "write"), [("wall.stl", stl_bytes), ("ascii.stl", ascii_stl), ("wall.ply", ply_text)])
def test_a_wall_of_triangles_keeps_its_interfaces(tmp_path, name, write):
    found = read(tmp_path, name, write(WALL), fixed="lowest")
    same_bodies(found.blocks, WALL)
    assert [b.fixed for b in found.blocks] == [b.fixed for b in WALL]
    assert found.report.warnings == ()
    before, after = (bs.detect_interfaces(blocks, joint_material=JOINT) for blocks in (WALL, found.blocks))
    assert after.report.accepted == before.report.accepted
    assert after.report.total_area == pytest.approx(before.report.total_area, rel=1e-9)


def test_obj_keeps_blocks_to_the_last_digit(tmp_path):
    wall = moved(WALL, rotation((1, 2, 3), 0.7), (0.1, 0.2, 0.3))
    path = bs.imports.write_obj(tmp_path / "wall.obj", wall)
    found = bs.imports.read_mesh(path, unit="m", material=STONE, fixed=["base"])
    for a, b in zip(found.blocks, wall, strict=True):
        assert (a.name, a.fixed) == (b.name, b.fixed)
        assert a.shape.vertices.tolist() == b.shape.vertices.tolist()
        assert a.shape.faces == b.shape.faces
    assert found.report.repairs == ()
    assert found.report.supports == ("base",)


@given(unit=st.sampled_from(["mm", "cm", "inch", "0.025 m"]), turn=st.floats(0, 3))
@few(8)
def test_units_and_orientation_have_no_effect(tmp_path_factory, unit, turn):
    blocks = moved(WALL, rotation((1, 1, 0.3), turn))
    path = bs.imports.write_obj(tmp_path_factory.mktemp("obj") / "wall.obj", blocks, unit=unit)
    same_bodies(bs.imports.read_mesh(path, unit=unit, material=STONE).blocks, blocks)


MIDDLE = [(4, 8, 6, 7), (8, 5, 6), (4, 5, 8)]


def cube(**changes):
    return obj_text(**{"vertices": CUBE, "faces": QUADS} | changes)


@pytest.mark.parametrize(
    ("text", "kind", "faces"),
    [
        (cube(faces=[*QUADS[:3], QUADS[3][::-1], *QUADS[4:]]), "turned", 6),
        (cube(faces=[*QUADS, QUADS[2][2:] + QUADS[2][:2]]), "twin", 6),
        (cube(faces=[*QUADS, (4, 4, 5)]), "no area", 6),
        (cube(faces=fans(QUADS)), "merged", 6),
        (cube(faces=[*QUADS, *QUADS]), "doubled", 6),
        (cube(faces=[f for face in QUADS for f in (face, face[::-1])]), "doubled", 6),
        # A corner in the middle of an edge of one face only, closed by a triangle without area.
        (cube(vertices=[*CUBE, (0.5, 0, 1)], faces=[*MIDDLE, *QUADS[:1], *QUADS[2:]]), "no area", 6),
        (cube(vertices=[*CUBE[:6], (1, 1, 1.002), CUBE[7]]), "flattened", 6),
        (cube(vertices=[*CUBE[:6], (1, 1, 1.1), CUBE[7]]), "split", 7),
        # Two corners a hair apart.
        (cube(vertices=[*CUBE, (1, 1, 1 + 1e-6)], faces=[(4, 5, 8, 7), *QUADS[:1], *QUADS[2:]]), "welded", 6),
    ],
)
def test_every_repair_is_reported(tmp_path, text, kind, faces):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = read(tmp_path, "cube.obj", text)
    (block,) = found.blocks
    assert kind in {r.kind for r in found.report.repairs}
    assert len(block.shape.faces) == faces
    assert block.volume == pytest.approx(1, abs=0.04)
    assert len(said) == (kind != "merged")


def test_a_hole_keeps_its_triangles(tmp_path):
    # A square tube: the ends are rings, which no single polygon can be.
    outer = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (3, 0), (3, 3), (0, 3))]
    inner = [(x, y, z) for z in (0, 1) for x, y in ((1, 1), (2, 1), (2, 2), (1, 2))]
    sides = [(i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in range(4)]
    holes = [tuple(8 + j for j in side[::-1]) for side in sides]
    ends = [(i + 4, (i + 1) % 4 + 4, (i + 1) % 4 + 12, i + 12) for i in range(4)]
    ends += [((i + 1) % 4, i, i + 8, (i + 1) % 4 + 8) for i in range(4)]
    (tube,) = read(tmp_path, "tube.obj", obj_text(outer + inner, fans(sides + holes + ends))).blocks
    assert tube.volume == pytest.approx(8)
    assert sorted(map(len, tube.shape.faces)) == [3] * 16 + [4] * 8


@given(data=st.data())
@few(15)
def test_order_and_orientation_of_faces_have_no_effect(tmp_path_factory, data):
    # Two cubes, one upon the other, as triangles: any order within a cube, any of them turned.
    soup = []
    for level in (0, 1):
        triangles = data.draw(st.permutations(fans(QUADS)))
        turned = data.draw(st.lists(st.booleans(), min_size=12, max_size=12))
        for t, back in zip(triangles, turned, strict=True):
            soup += [(*CUBE[i][:2], CUBE[i][2] + level) for i in (t[::-1] if back else t)]
    text = obj_text(soup, [(i, i + 1, i + 2) for i in range(0, len(soup), 3)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bs.errors.GeometryWarning)
        found = read(tmp_path_factory.mktemp("soup"), "s.obj", text)
    assert [b.volume for b in found.blocks] == pytest.approx([1, 1])
    assert [len(b.shape.faces) for b in found.blocks] == [6, 6]
    assert bs.detect_interfaces(found.blocks, joint_material=JOINT).report.accepted == 1


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.obj", "o empty\no cube\n" + obj_text().replace("f", "l 1 2\nf", 1), "1 statement 'l', .* object 'empty'"),
        ("a.obj", obj_text([*CUBE, (5, 5, 5)]), "left out: 1 vertex of no face"),
        ("a.ply", PLY.replace("vertex 8", "vertex 9").replace("\n4 0 3", "\n5 5 5\n4 0 3", 1), "1 vertex of no face"),
    ],
)
def test_what_has_no_face_is_reported(tmp_path, name, content, words):
    with pytest.warns(bs.errors.GeometryWarning, match=words):
        assert len(read(tmp_path, name, content).blocks) == 1


def test_solids_of_an_stl_file_keep_any_names(tmp_path):
    names = ["Solid_1", "Solid_2", "arch solid 3", "endsolid", "facet vertex 5", "-6 %"]
    blocks = [box(n, [0, 0, k]) for k, n in enumerate(names)]
    text = ascii_stl(blocks).replace("facet normal", "\tFACET\tnormal").replace("\n", "\r\n")
    found = read(tmp_path, "a.stl", "\ufeff" + text)
    assert [(b.name, b.centroid[2]) for b in found.blocks] == [(n, k + 0.5) for k, n in enumerate(names)]
    assert found.report.warnings == ()


@pytest.mark.parametrize("name", ["a.stl", "a.ply"])
@pytest.mark.parametrize(("east", "told"), [(500, False), (512_345.67, True)])
def test_large_coordinates_in_single_precision_give_a_warning(tmp_path, name, east, told):
    block = box("a", [east, 0, 0], [0.37, 0.3, 0.21])
    content = stl_bytes([block]) if name == "a.stl" else ply_text([block]).replace("double", "float")
    with pytest.warns(bs.errors.GeometryWarning, match=r"rounds .* by up to 0.0156 m \(a\)") if told else nullcontext():
        (found,) = read(tmp_path, name, content).blocks
    width = np.ptp(found.shape.vertices[:, 0])
    assert abs(width - 0.37) > 1e-3 if told else width == pytest.approx(0.37, abs=1e-4)


@pytest.mark.parametrize(
    ("written", "name"),
    [
        *(("façade – ‘west’…".encode(code), "façade – ‘west’…") for code in ("utf-8", "utf-8-sig", "cp1252")),
        (b"T\x81r", "T\N{REPLACEMENT CHARACTER}r"),
    ],
)
def test_names_in_any_encoding(tmp_path, written, name):
    mark = b"\xef\xbb\xbf" if written.startswith(b"\xef\xbb\xbf") else b""
    (block,) = read(tmp_path, "a.obj", mark + b"o " + written.removeprefix(mark) + b"\n" + cube().encode()).blocks
    assert block.name == name


def test_numbered_bodies_do_not_take_names_of_objects(tmp_path):
    """A hash within a word is no comment: pier#1 would become the second "pier", and take the name of the first."""
    apart = [*CUBE, *((x + 2, y, z) for x, y, z in CUBE)]
    text = "o arch\n" + obj_text(apart, [*QUADS, *([i + 8 for i in face] for face in QUADS)])
    others = {name: np.add(CUBE, [x, 0, 0]) for name, x in (("arch.1", 4), ("pier#1 # of two", 6), ("pier#1", 8))}
    with pytest.warns(bs.errors.GeometryWarning, match=r"name used twice: 1 \(pier#1#2\)"):
        found = read(tmp_path, "a.obj", text + objects_text(others), fixed=["arch.1"])
    assert [b.name for b in found.blocks] == ["arch.2", "arch.3", "arch.1", "pier#1", "pier#1#2"]
    assert [b.name for b in found.blocks if b.fixed] == ["arch.1"]


def test_several_files_prefix_the_names_of_blocks(tmp_path):
    path = saved(tmp_path, "arch.obj", "o stone\n" + obj_text())
    other = saved(tmp_path, "wall.obj", "o stone\n" + obj_text([(x + 2, y, z) for x, y, z in CUBE]))
    third = saved(tmp_path, "pier.obj", obj_text([(x + 4, y, z) for x, y, z in CUBE]))
    found = bs.imports.read_mesh([path, other, third], unit="m", material=STONE, fixed=["arch.stone"])
    assert [b.name for b in found.blocks] == ["arch.stone", "wall.stone", "pier"]
    assert found.report.supports == ("arch.stone",)


def test_a_copy_with_another_name_is_dropped(tmp_path):
    # Divided into triangles, and to rounding where the first is.
    near = [(x + 1e-9, y, z) for x, y, z in CUBE]
    text = objects_text({"one": CUBE}) + objects_text({"two": near}, fans(QUADS))
    with pytest.warns(bs.errors.GeometryWarning, match=r"given again under another name, dropped: 1 \(two = one\)"):
        found = read(tmp_path, "a.obj", text)
    assert [b.name for b in found.blocks] == ["one"]


def test_the_lowest_blocks_are_within_a_height(tmp_path):
    # Four cubes, of which the second stands 2 cm and the third 8 cm higher than the first.
    text = objects_text({f"c{k}": np.add(CUBE, [2 * k, 0, lift]) for k, lift in enumerate((0, 0.02, 0.08, 1))})
    lowest, some = (read(tmp_path, "c.obj", text, fixed=fixed).report for fixed in ("lowest", ["lowest 3 cm", "c3"]))
    assert (lowest.supports, some.supports) == (("c0",), ("c0", "c1", "c3"))
    (note,) = lowest.notes
    assert "2 more blocks reach down to within 0.08 m of the lowest level and are free" in note
    found = read(tmp_path, "c.obj", text, fixed=note.partition("fix '")[2].partition("'")[0])
    assert (found.report.supports, found.report.notes) == (("c0", "c1", "c2"), ())


@pytest.mark.parametrize("name", ["lowest", "lowest 3 cm"])
def test_a_block_named_as_the_keyword_is_refused(tmp_path, name):
    text = objects_text({"base": CUBE, name: np.add(CUBE, [0, 0, 1])})
    with pytest.raises(bs.errors.ModelError, match=f"fixed is '{name}'.* block"):
        read(tmp_path, "a.obj", text, fixed=["base", name])
    assert read(tmp_path, "a.obj", text, fixed=["base"]).report.supports == ("base",)


@pytest.mark.parametrize("exclude", [["two"], "t*", ["t*o"]])
def test_blocks_are_excluded_before_the_checks(tmp_path, exclude):
    text = objects_text({"one": CUBE}) + objects_text({"two": CUBE}, QUADS[:-1])
    found = read(tmp_path, "a.obj", text, exclude=exclude)
    assert [b.name for b in found.blocks] == ["one"]
    assert "excluded as asked: two" in str(found.report)
    with pytest.raises(bs.errors.UnknownNameError, match=r"'three'.*one, two"):
        read(tmp_path, "a.obj", text, exclude=["three"])


@pytest.mark.parametrize(("up", "height"), [("x", 1), ("y", 2), ("z", 3)])
def test_the_vertical_axis_becomes_z(tmp_path, up, height):
    # A wedge, so that a mirror image would not pass for it.
    corners = [(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3)]
    text = obj_text(corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
    (block,) = read(tmp_path, "a.obj", text, up=up).blocks
    assert block.volume == pytest.approx(1)
    assert max(block.shape.vertices.tolist(), key=lambda v: v[2]) == [0, 0, height]
    # Of the file, that is x of the model.
    assert np.ptp(block.shape.vertices[:, 0]) == {"x": 2, "y": 1, "z": 1}[up]


@pytest.mark.parametrize(
    ("size", "unit", "expected"),
    [
        ((5000, 500, 3000), "m", "the whole is 5000 m long"),
        ((100, 5, 15), "cm", "the whole is 0.15 m high"),
        ((5, 0.5, 3), "mm", "a typical edge is 0.005 m long"),
    ],
)
def test_unlikely_sizes_are_warned_of(tmp_path, size, unit, expected):
    with pytest.warns(bs.errors.GeometryWarning, match=expected):
        read(tmp_path, "block.obj", obj_text(np.array(CUBE) * size), unit=unit)


def test_obj_refuses_existing_files_and_names_that_it_cannot_store(tmp_path):
    path = bs.imports.write_obj(tmp_path / "wall.obj", WALL)
    with pytest.raises(bs.errors.StorageError, match=r"wall\.obj"):
        bs.imports.write_obj(path, WALL)
    for name in ("a  b", "a #b", "#a", "a\\"):
        with pytest.raises(bs.errors.ModelError, match="OBJ"):
            bs.imports.write_obj(tmp_path / "odd.obj", [box(name, [0, 0, 0])])
    with pytest.raises(bs.errors.ModelError, match=r"none\.obj"):
        bs.imports.write_obj(tmp_path / "none.obj", [])


NOISE = np.random.default_rng(1).integers(0, 256, 4000, dtype=np.uint8).tobytes()
#: The projective plane on six vertices: every edge belongs to two triangles.
ONE_SIDED = [(0, k, 1 + k % 5) for k in range(1, 6)] + [(1, 2, 4), (2, 3, 5), (3, 4, 1), (4, 5, 2), (5, 1, 3)]


def without_a_vertex(stl):
    lines = stl.splitlines(keepends=True)
    return "".join(lines[:3] + lines[4:])


@pytest.mark.parametrize(
    ("name", "words", "content"),
    [
        ("a.obj", "empty", ""),
        ("a.obj", "text", NOISE),
        ("a.stl", "4000 bytes", NOISE),
        ("a.obj", "line 1: 'hello world'", "hello world\n"),
        ("a.obj", "line 14: face '4 1'", obj_text()[:-4]),
        ("a.obj", "line 7: vertex '1 1 nan'", obj_text().replace("v 1 1 1", "v 1 1 nan")),
        ("a.obj", "face '5 6 7 9' 1..8", obj_text().replace("f 5 6 7 8", "f 5 6 7 9")),
        ("a.obj", "no solid", "v 0 0 0\n"),
        ("a.obj", "vertex numbers", obj_text() + "f 1 2 1_0\n"),
        ("a.stl", "677 bytes", STL[:-7]),
        ("a.stl", "'endsolid'", ascii_stl(CUBES)[:-300]),
        ("a.stl", "line vertex '0.0 zero 0.0'", ascii_stl(CUBES).replace(" 0.0 0.0 0.0", " 0.0 zero 0.0", 1)),
        ("a.stl", "line 7: 2 vertices triangles", without_a_vertex(ascii_stl(CUBES))),
        ("a.ply", "14 vertices 13 lines", PLY[:-10]),
        ("a.ply", "PLY", NOISE),
        ("a.ply", "vertex 99 8", PLY.replace("4 0 3 2 1", "4 0 3 2 99")),
        ("a.stl", "line 'inner loop'", ascii_stl(CUBES).replace("outer loop", "inner loop", 1)),
        ("a.ply", "a.ply", PLY.replace("element vertex 8", "element vertex 800000000000")),
        ("a.ply", "6000000 500000", PLY.replace("element face 6", "element face 6000000")),
        ("a.obj", "open 4 edges one face", obj_text(faces=QUADS[:-1])),
        ("a.obj", "'a'", obj_text(vertices=[(x, y, 0) for x, y, _ in CUBE])),
        ("a.obj", "'a' corner (0, 0, 1) m", obj_text(faces=[*QUADS[:5], (4, 0, 3, 7, 3, 7)])),
        ("a.obj", "'a' side", obj_text(np.random.default_rng(0).normal(size=(6, 3)), ONE_SIDED)),
        ("a.obj", "crosses itself near", obj_text([*CUBE[:6], (0.4, 0.45, -1), CUBE[7]], fans(QUADS))),
        ("a.obj", "2 of 3 'l' 'r'", objects_text({"good": CUBE}) + objects_text({"l": CUBE, "r": CUBE}, QUADS[:-1])),
    ],
)
def test_refused_meshes(tmp_path, name, words, content):
    with refused(bs.errors.GeometryFileError, f"{tmp_path / name} {words}"):
        read(tmp_path, name, content)


@pytest.mark.parametrize("corner", [[(4, 4, 1)] * 8, [(4, 4, z) for *_, z in CUBE]], ids=["point", "line"])
def test_a_body_without_any_area_is_refused(tmp_path, corner):
    """A slender body far from the origin, written with few digits: it is not left out as faces without area."""
    text = objects_text({"wall": CUBE, "pin": corner})
    with pytest.raises(bs.errors.GeometryFileError, match=rf"(?s)1 of 2 .*pin.*at \(4, 4, {corner[0][2]}\) m"):
        read(tmp_path, "a.obj", text)
    with pytest.warns(bs.errors.GeometryWarning, match="faces without area dropped"):
        (left,) = read(tmp_path, "a.obj", text, exclude=["pin"]).blocks
    assert left.volume == pytest.approx(1)


def test_two_bodies_with_a_common_edge_are_refused():
    vertices = np.array([*CUBE, *((x + 1, y + 1, z) for x, y, z in CUBE)])
    second = [tuple({0: 2, 4: 6}.get(i, i + 8) for i in f) for f in QUADS]
    with pytest.raises(bs.errors.GeometryError, match=r"'pair'.* 4 "):
        closed_surface(vertices, [*QUADS, *second], "pair")


def test_a_scan_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("blockstruct.imports.surface.MOST_FACES_OF_BODY", 11)
    with pytest.raises(bs.errors.GeometryFileError, match=r"12 .* 11"):
        read(tmp_path, "scan.obj", obj_text(faces=fans(QUADS)))


def test_without_trimesh_the_error_names_the_extra(tmp_path, monkeypatch):
    """A million faces are refused before reading, and other formats need no extra."""
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(bs.errors.MissingExtraError, match=r'pip install "blockstruct\[mesh\]"'):
        read(tmp_path, "a.ply", PLY)
    header = bytes(80) + (1_000_000).to_bytes(4, "little")
    with pytest.raises(bs.errors.GeometryFileError, match=r"1000000 .* 500000"):
        read(tmp_path, "million.stl", header + bytes(50 * 1_000_000))
    for error, files in (
        (bs.errors.StorageError, "none.obj"),
        (bs.errors.ModelError, "wall.3dm"),
        (bs.errors.ModelError, []),
    ):
        with pytest.raises(error):
            bs.imports.read_mesh(files and tmp_path / files, unit="m", material=STONE)
    assert len(read(tmp_path, "a.obj", obj_text()).blocks) == 1
    assert len(read(tmp_path, "a.stl", STL).blocks) == 1


@pytest.mark.parametrize(
    ("error", "words", "options"),
    [
        (bs.errors.UnitError, "unit 1 length", {"unit": 1}),
        (bs.errors.ModelError, "unit 0 m", {"unit": "0 m"}),
        (bs.errors.ModelError, "tolerance -0.001 m", {"tolerance": "-1 mm"}),
        (bs.errors.UnknownNameError, "'highest' lowest ground", {"fixed": "highest"}),
        (bs.errors.DimensionError, "lowest blocks", {"fixed": "lowest 3"}),
        (bs.errors.UnknownNameError, "'base' a", {"fixed": ["base"]}),
        (bs.errors.ModelError, "material None Material", {"material": None}),
    ],
)
def test_refused_options(tmp_path, error, words, options):
    with refused(error, f"a {words}"):
        read(tmp_path, "a.obj", obj_text(faces=fans(QUADS)), **options)
