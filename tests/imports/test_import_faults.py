"""A drawing and a mesh with every fault at once: from the command line to the load factor of the wall meant."""

import ezdxf
import numpy as np
import pytest

import blockstruct as bs
from meshes import CUBE, QUADS

WORDS = ["--unit", "mm", "--unit-weight", "20 kN/m^3", "--friction", "0.6"]
STONE, DRY = bs.Material("stone", "20 kN/m^3"), bs.JointMaterial("dry", 0.6)
#: Stones of three courses, mm: left end, right end and bed; the head joints are open by 8 mm.
COURSES = [(x + shift, x + shift + 492, z) for z, shift in ((0, 0), (250, 200), (500, 0)) for x in range(0, 2000, 500)]


@pytest.fixture(scope="module")
def meant():
    """Load factor of the wall as boxes."""
    slab = bs.Block.box("slab", bs.Q_([-500, 0, -250], "mm"), bs.Q_([3000, 250, 250], "mm"), STONE, fixed=True)
    stones = [
        bs.Block.box(f"stone {k}", bs.Q_([a, 0, z], "mm"), bs.Q_([b - a, 250, 250], "mm"), STONE)
        for k, (a, b, z) in enumerate(COURSES)
    ]
    found = bs.detect_interfaces([slab, *stones], DRY)
    dead, push = bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("push", [bs.BodyForce("+x")])
    model = bs.Model("wall", [slab, *stones], found.interfaces)
    return bs.AnalysisManager(model).run([bs.LimitCase("push", dead, push)])["push"].load_factor


def draw(path):
    """The wall as a drawing in mm whose template was in inches."""
    document = ezdxf.new()
    document.header["$INSUNITS"] = 1
    for layer in ("GROUND", "STONE", "NOTES", "OLD"):
        document.layers.add(layer)
    document.layers.get("OLD").off()
    space = document.modelspace()
    rings = []
    for a, b, z in [(-500, 2500, -250), *COURSES]:
        rings.append([(a, z), (b, z), (b, z + 250), (a, z + 250)])
    drawn = {
        1: [*rings[1], (rings[1][0][0] + 1e-9, rings[1][0][1])],  # ends that meet to rounding, not marked as closed
        2: [*rings[2], rings[2][0], rings[2][1]],  # the first edge once more
        3: [*rings[3][:2], (5000, 0), *rings[3][1:]],  # out along a line and back
        4: [*rings[4], *rings[4]],  # twice round
        5: [*rings[5], (rings[5][0][0], rings[5][0][1] + 2)],  # ends 2 mm apart
        6: [*rings[6][:2], rings[6][1], *rings[6][2:]],  # a corner twice
    }
    for number, ring in enumerate(rings):
        corners = drawn.get(number, ring)
        space.add_lwpolyline(
            corners, close=number not in (1, 2, 5), dxfattribs={"layer": "STONE" if number else "GROUND"}
        )
    space.add_lwpolyline(rings[7], close=True, dxfattribs={"layer": "STONE"})  # a stone drawn twice
    space.add_lwpolyline([(0, 900), (300, 900), (300, 1300)], dxfattribs={"layer": "STONE"})  # open
    space.add_lwpolyline([(0, 900), (300, 900)], close=True, dxfattribs={"layer": "STONE"})  # a line
    space.add_circle((0, 0), 50, dxfattribs={"layer": "STONE"})
    space.add_text("elevation", dxfattribs={"layer": "NOTES"})
    space.add_lwpolyline(rings[1], close=True, dxfattribs={"layer": "OLD"})
    space.add_lwpolyline([(9000, 0), (9500, 0), (9500, 250), (9000, 250)], close=True, dxfattribs={"layer": "NOTES"})
    document.saveas(path)


def model_in(folder):
    """The wall as a mesh in mm with y up, in two files, with the slab in the second."""
    lines, vertices = ["l 1 2", "v 9000 9000 9000"], 1

    def body(name, box, faces=QUADS, lift=0.0):
        nonlocal vertices
        a, b, z, t = box
        corners = np.array([(a + (b - a) * x, 250 * y, z + 250 * u) for x, y, u in CUBE], dtype=float)
        corners[6, 2] += lift
        lines.append(f"o {name}")
        # (x, y, z) of the wall is (x, z, -y) of the file.
        lines.extend(f"v {x:.4f} {z:.4f} {-y + t:.4f}" for x, y, z in corners)
        lines.extend("f " + " ".join(str(i + 1 + vertices) for i in face) for face in faces)
        vertices += 8

    for number, (a, b, z) in enumerate(COURSES):
        faces = {
            0: [*QUADS, *QUADS],  # all faces twice
            1: [f for face in QUADS for f in (face, face[::-1])],  # and once from the inside
            2: [face[::-1] for face in QUADS],  # inside out
            3: [*QUADS, (4, 4, 5)],  # a face without area
        }.get(number, QUADS)
        body("stone", (a, b, z, 0), faces, lift=-3.5 if number == 6 else 0.0)
    body("stone", (*COURSES[5], 0))  # once more
    body("scaffold", (9000, 9100, 0, 0), QUADS[:-1])  # open
    (folder / "wall.obj").write_text("\n".join([lines[1], lines[0], *lines[2:]]) + "\n", encoding="utf-8")
    lines.clear()
    vertices = 0
    body("stone", (-500, 2500, -250, 0))
    (folder / "ground.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return [folder / "wall.obj", folder / "ground.obj"]


def load_factor(done, document, store):
    done("run", document, "-o", store)
    result = bs.open_analysis(store)["push +x"]
    assert result.certificate.holds
    return result.load_factor


def test_a_drawing_with_every_fault(fails, done, tmp_path, meant):
    draw(tmp_path / "wall.dxf")
    words = ["import", tmp_path / "wall.dxf", "-o", tmp_path / "wall.yaml", *WORDS]
    words += ["--thickness", "25 cm", "--fix-layer", "GROUND", "--closing", "5 mm", "--exclude", "NOTES.*"]
    fails("--override-unit", *words)
    out = done(*words, "--override-unit")
    assert "13 blocks of 78 faces, 1 fixed" in out
    assert load_factor(done, tmp_path / "wall.yaml", tmp_path / "wall.h5") == pytest.approx(meant, rel=1e-3)


def test_a_mesh_with_every_fault(fails, done, tmp_path, meant):
    files = model_in(tmp_path)
    words = ["import", *files, "-o", tmp_path / "wall.yaml", *WORDS, "--up", "y", "--fix", "lowest"]
    fails("'wall.scaffold': the surface is open at 4 edges", *words)
    out = done(*words, "--exclude", "wall.scaffold")
    for said in (
        "13 blocks of 78 faces, 1 fixed",
        "bodies whose faces are all given twice, once each kept: 2 (wall.stone)",
        "name used twice",
        "2 joints closed that repairs of their faces opened",
    ):
        assert said in out
    model = bs.read_document(tmp_path / "wall.yaml").model
    # The corner that is off opens two bed joints, which are closed; the head joints of 8 mm stay open.
    assert len(model.interfaces) == 4 + 7 + 7
    assert all(abs(i.normal[2]) > 0.99 for i in model.interfaces)
    assert load_factor(done, tmp_path / "wall.yaml", tmp_path / "wall.h5") == pytest.approx(meant, rel=1e-2)
