"""Damaged and hostile meshes: one clear refusal each, that names the file and the remedy."""

import sys

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.imports.surface import closed_surface
from meshes import CUBE, QUADS, ascii_stl, fans, obj_text, objects_text, ply_text, read, stl_bytes
from refusals import refused
from structures import STONE, box

BLOCK = [box("b", [0, 0, 0], [1, 1, 1])]
NOISE = np.random.default_rng(1).integers(0, 256, 4000, dtype=np.uint8).tobytes()
STL, PLY = stl_bytes(BLOCK), ply_text(BLOCK)


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
        ("a.stl", "'endsolid'", ascii_stl(BLOCK)[:-300]),
        ("a.stl", "line vertex '0.0 zero 0.0'", ascii_stl(BLOCK).replace(" 0.0 0.0 0.0", " 0.0 zero 0.0", 1)),
        ("a.stl", "line 7: 2 vertices triangles", without_a_vertex(ascii_stl(BLOCK))),
        ("a.ply", "14 vertices 13 lines", PLY[:-10]),
        ("a.ply", "PLY", NOISE),
        ("a.ply", "vertex 99 8", PLY.replace("4 0 3 2 1", "4 0 3 2 99")),
        ("a.stl", "line 'inner loop'", ascii_stl(BLOCK).replace("outer loop", "inner loop", 1)),
        ("a.ply", "a.ply", PLY.replace("element vertex 8", "element vertex 800000000000")),
        ("a.ply", "6000000 500000", PLY.replace("element face 6", "element face 6000000")),
        ("a.obj", "open 4 edges one face", obj_text(faces=QUADS[:-1])),
        ("a.obj", "'a'", obj_text(vertices=[(x, y, 0) for x, y, _ in CUBE])),
        ("a.obj", "'a' corner (0, 0, 1) m", obj_text(faces=[*QUADS[:5], (4, 0, 3, 7, 3, 7)])),
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


def test_all_refused_bodies_are_named(tmp_path):
    text = objects_text({"good": CUBE}) + objects_text({"left": CUBE, "right": CUBE}, QUADS[:-1])
    with pytest.raises(bs.errors.GeometryFileError, match=r"(?s)2 of 3 .*'left'.*'right'"):
        read(tmp_path, "a.obj", text)


def test_two_bodies_with_a_common_edge_are_refused():
    # Two cubes with one edge in common, as one body.
    vertices = np.array([*CUBE, *((x + 1, y + 1, z) for x, y, z in CUBE)])
    second = [tuple({0: 2, 4: 6}.get(i, i + 8) for i in f) for f in QUADS]
    with pytest.raises(bs.errors.GeometryError, match=r"'pair'.* 4 "):
        closed_surface(vertices, [*QUADS, *second], "pair")


def test_a_one_sided_surface_is_refused():
    # The projective plane on six vertices: every edge belongs to two triangles.
    faces = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5), (0, 5, 1)]
    faces += [(1, 2, 4), (2, 3, 5), (3, 4, 1), (4, 5, 2), (5, 1, 3)]
    points = np.random.default_rng(0).normal(size=(6, 3))
    with pytest.raises(bs.errors.GeometryError, match=r"'plane'.*side"):
        closed_surface(points, faces, "plane")


def test_a_scan_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("blockstruct.imports.surface.MOST_FACES_OF_BODY", 11)
    with pytest.raises(bs.errors.GeometryFileError, match=r"12 .* 11"):
        read(tmp_path, "scan.obj", obj_text(faces=fans(QUADS)))


def test_a_corner_through_the_other_side_is_refused(tmp_path):
    vertices = [*CUBE[:6], (0.4, 0.45, -1), CUBE[7]]
    with pytest.raises(bs.errors.GeometryFileError, match="crosses itself near"):
        read(tmp_path, "spike.obj", obj_text(vertices, fans(QUADS)))


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
