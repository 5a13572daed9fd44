"""Damaged and hostile meshes: one clear refusal each, that names the file and the remedy."""

import struct
import sys

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.imports.surface import closed_surface
from meshes import CUBE, QUADS, ascii_stl, fans, obj_text, objects_text, ply_text, read, stl_bytes
from refusals import refused
from structures import STONE, box

BLOCK = [box("b", [0, 0, 0], [1, 1, 1])]
TWO = [*BLOCK, box("c", [2, 0, 0], [1, 1, 1])]
NOISE = np.random.default_rng(1).integers(0, 256, 4000, dtype=np.uint8).tobytes()
STL, PLY = stl_bytes(BLOCK), ply_text(BLOCK)


def sphere(n):
    """Vertices and triangles of a sphere of n bands of n triangles and two caps."""
    z, a = np.linspace(-0.9, 0.9, n + 1), np.linspace(0, 2 * np.pi, n, endpoint=False)
    ring = np.array([(np.sqrt(1 - h * h) * np.cos(t), np.sqrt(1 - h * h) * np.sin(t), h) for h in z for t in a])
    faces = []
    for band in range(n):
        for k in range(n):
            i, j = band * n + k, band * n + (k + 1) % n
            faces += [(i, j, j + n), (i, j + n, i + n)]
    top, bottom = len(ring), len(ring) + 1
    faces += [(k, bottom, (k + 1) % n) for k in range(n)] + [(n * n + k, n * n + (k + 1) % n, top) for k in range(n)]
    return np.vstack([ring, [(0, 0, 1), (0, 0, -1)]]), faces


def without_a_vertex(stl):
    lines = stl.splitlines(keepends=True)
    return "".join(lines[:3] + lines[4:])


@pytest.mark.parametrize(
    ("name", "words", "content"),
    [
        ("a.obj", "empty", ""),
        ("a.stl", "empty", b""),
        ("a.obj", "text", NOISE),
        ("a.stl", "4000 bytes", NOISE),
        ("a.ply", "PLY", NOISE),
        ("a.obj", "line 1: 'hello world'", "hello world\n"),
        ("a.obj", "line 14: face '4 1'", obj_text()[:-4]),
        ("a.obj", "open 7 edges", obj_text()[:-12]),
        ("a.obj", "line 7: vertex '1 1'", obj_text().replace("v 1 1 1", "v 1 1")),
        ("a.obj", "line 7: vertex '1 1 nan'", obj_text().replace("v 1 1 1", "v 1 1 nan")),
        ("a.obj", "face '5 6 7 9' 1..8", obj_text().replace("f 5 6 7 8", "f 5 6 7 9")),
        ("a.obj", "no solid", "v 0 0 0\n"),
        ("a.stl", "677 bytes", STL[:-7]),
        ("a.stl", "60 bytes", STL[:60]),
        ("a.stl", "'endsolid'", ascii_stl(BLOCK)[:-300]),
        (
            "a.stl",
            "line vertex '0.0 zero 0.0'",
            ascii_stl(BLOCK).replace("vertex 0.0 0.0 0.0", "vertex 0.0 zero 0.0", 1),
        ),
        ("a.stl", "line 7: 2 vertices triangles", without_a_vertex(ascii_stl(BLOCK))),
        ("a.stl", "line 'inner loop'", ascii_stl(BLOCK).replace("outer loop", "inner loop", 1)),
        ("a.ply", "14 vertices 13 lines", PLY[:-10]),
        ("a.ply", "14 vertices 15 lines", PLY + "0 0 0\n"),
        ("a.ply", "28 vertices", ply_text(TWO)[:-60]),
        ("a.ply", "vertex 99 8", PLY.replace("4 0 3 2 1", "4 0 3 2 99")),
        ("a.ply", "a.ply", PLY.replace("element vertex 8", "element vertex 800000000000")),
        ("a.ply", "6000000 500000", PLY.replace("element face 6", "element face 6000000")),
        ("a.obj", "open 4 edges one face", obj_text(faces=QUADS[:-1])),
        ("a.obj", "'a.2' open 4 edges", obj_text(faces=[*QUADS, (0, 1, 6, 7)])),
        ("a.obj", "'a'", obj_text(vertices=[(x, y, 0) for x, y, _ in CUBE])),
        ("a.obj", "'a' corner (0, 0, 1) m", obj_text(faces=[*QUADS[:5], (4, 0, 3, 7, 3, 7)])),
    ],
)
def test_refused_meshes(tmp_path, name, words, content):
    with refused(bs.errors.GeometryFileError, f"{tmp_path / name} {words}"):
        read(tmp_path, name, content)


@pytest.mark.parametrize("kind", ["obj", "stl", "one object"])
@pytest.mark.parametrize("corner", [[(4, 4, 1)] * 8, [(4, 4, z) for *_, z in CUBE]], ids=["point", "line"])
def test_a_body_without_any_area_is_refused(tmp_path, kind, corner):
    """A slender body far from the origin, written with few digits: it is not left out as faces without area."""
    if kind == "stl":
        triangles = [np.array(v)[list(t)] for v in (CUBE, corner) for t in fans(QUADS)]
        rows = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(t).tolist(), 0) for t in triangles)
        name, content, who = "a.stl", bytes(80) + struct.pack("<I", len(triangles)) + rows, "a.2"
    else:
        faces = [[i - 8 for i in f] for f in QUADS]
        text = "".join(f"f {' '.join(map(str, f))}\n" for f in faces)
        points = ["".join(f"v {x} {y} {z}\n" for x, y, z in v) for v in (CUBE, corner)]
        head = ["o wall\n", "o pin\n"] if kind == "obj" else ["o wall\n", ""]
        name, content = "a.obj", "".join(h + p + text for h, p in zip(head, points, strict=True))
        who = "pin" if kind == "obj" else "wall.2"
    place = r"at \(4, 4, 1\) m" if corner[0][2] else r"at \(4, 4, 0\) m"
    with pytest.raises(bs.errors.GeometryFileError, match=rf"(?s)1 of 2 .*{who}.*{place}"):
        read(tmp_path, name, content)
    with pytest.warns(bs.errors.GeometryWarning, match="faces without area dropped"):
        (left,) = read(tmp_path, name, content, exclude=[who]).blocks
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


@pytest.mark.parametrize("aside", [0, 0.01])
def test_a_surface_that_crosses_itself_is_refused(tmp_path, aside):
    vertices, faces = sphere(12)
    (ball,) = read(tmp_path, "ball.obj", obj_text(vertices, faces)).blocks
    assert ball.volume == pytest.approx(4 / 3 * np.pi, rel=0.1)
    vertices[-2] = (aside, aside / 3, -1.5)  # the top pushed through the bottom
    with pytest.raises(bs.errors.GeometryFileError, match="crosses itself near"):
        read(tmp_path, "spike.obj", obj_text(vertices, faces))


def test_a_scan_is_refused(tmp_path):
    vertices, faces = sphere(101)
    with pytest.raises(bs.errors.GeometryFileError, match=r"20604 .* 20000"):
        read(tmp_path, "scan.obj", obj_text(vertices, faces))


def test_a_million_faces_are_refused_before_reading(tmp_path, monkeypatch):
    header = bytes(80) + (1_000_000).to_bytes(4, "little")
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(bs.errors.GeometryFileError, match=r"1000000 .* 500000"):
        read(tmp_path, "million.stl", header + bytes(50 * 1_000_000))


def test_without_trimesh_the_error_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(bs.errors.MissingExtraError, match=r'pip install "blockstruct\[mesh\]"'):
        read(tmp_path, "a.ply", PLY)
    assert len(read(tmp_path, "a.obj", obj_text()).blocks) == 1
    assert len(read(tmp_path, "a.stl", STL).blocks) == 1


@pytest.mark.parametrize(
    ("error", "words", "options"),
    [
        (bs.errors.UnitError, "unit 1 length", {"unit": 1}),
        (bs.errors.DimensionError, "unit kg length", {"unit": "kg"}),
        (bs.errors.ModelError, "unit 0 m", {"unit": "0 m"}),
        (bs.errors.UnitError, "unit furlongs", {"unit": "furlongs per"}),
        (bs.errors.ModelError, "tolerance -0.001 m", {"tolerance": "-1 mm"}),
        (bs.errors.UnitError, "tolerance 1", {"tolerance": 1}),
        (bs.errors.UnknownNameError, "'highest' lowest ground", {"fixed": "highest"}),
        (bs.errors.DimensionError, "lowest blocks", {"fixed": "lowest 3"}),
        (bs.errors.ModelError, "lowest blocks -0.03 m", {"fixed": ["lowest -3 cm"]}),
        (bs.errors.UnknownNameError, "'base' a", {"fixed": ["base"]}),
        (bs.errors.ModelError, "material None Material", {"material": None}),
    ],
)
def test_refused_options(tmp_path, error, words, options):
    with refused(error, f"a {words}"):
        read(tmp_path, "a.obj", obj_text(faces=fans(QUADS)), **options)


@pytest.mark.parametrize(
    ("error", "files"),
    [(bs.errors.StorageError, "none.obj"), (bs.errors.ModelError, "wall.3dm"), (bs.errors.ModelError, [])],
)
def test_refused_names(tmp_path, error, files):
    with pytest.raises(error):
        bs.imports.read_mesh(files and tmp_path / files, unit="m", material=STONE)


def test_the_place_of_a_crossing_is_named(tmp_path):
    """A lintel 10 m long, whose outline crosses itself at its right end."""
    outline = [(0, 0), (10, 0), (10.4, 1), (9.6, 1), (10.2, 0.2), (0, 1)]
    vertices = [(x, y, z) for y in (0, 1) for x, z in outline]
    faces = [tuple(range(6)), tuple(range(11, 5, -1)), *((k, k + 6, (k + 1) % 6 + 6, (k + 1) % 6) for k in range(6))]
    with pytest.raises(bs.errors.GeometryFileError, match="crosses itself near") as caught:
        read(tmp_path, "a.obj", obj_text(vertices, faces))
    x, _, z = map(float, str(caught.value).partition("near (")[2].partition(")")[0].split(","))
    # The edge from (10, 0) to (10.4, 1) meets both edges at (10.2, 0.2).
    assert (x, z) in [pytest.approx((10 + 0.4 * t, t), abs=1e-3) for t in (0.20913, 0.26316)]
