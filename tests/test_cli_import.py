"""``blockstruct import`` and ``blockstruct check``, called as a user would."""

import json

import ezdxf
import pytest

import blockstruct as bs
from meshes import CUBE, QUADS, obj_text, stl_bytes

STONE = ["--unit-weight", "20 kN/m^3", "--friction", "0.6"]


@pytest.fixture
def stack(tmp_path):
    """Three cubes of 0.5 m, in mm."""
    text = "".join(
        f"o stone {k}\n"
        + obj_text([(500 * x, 500 * y, 500 * (z + k)) for x, y, z in CUBE], [[i - 9 for i in f] for f in QUADS])
        for k in range(3)
    )
    path = tmp_path / "stack.obj"
    path.write_text(text, encoding="utf-8")
    return path


def test_import_check_and_run(call, stack, tmp_path):
    model = tmp_path / "stack.yaml"
    code, out, err = call("import", stack, "-o", model, "--unit", "mm", *STONE, "--fix", "lowest")
    assert (code, err) == (0, "")
    assert "3 blocks of 18 faces, 1 of them fixed" in out
    assert "2 interfaces, 0.5 m^2" in out
    code, out, _ = call("check", model)
    assert code == 0
    assert "stack: 3 blocks, 1 of them fixed (stone 0)" in out
    assert "their weight 5 kN" in out
    assert "ready to run: push +x" in out
    code, _, _ = call("run", model, "-o", tmp_path / "stack.h5")
    assert code == 0
    # Two stones of slenderness 2 on the third: they rock together at width / height.
    assert bs.open_analysis(tmp_path / "stack.h5")["push +x"].load_factor == pytest.approx(0.5, rel=1e-4)


def test_without_supports_the_draft_is_written_and_the_check_says_why(call, stack, tmp_path):
    code, out, err = call("import", stack, "-o", tmp_path / "m.yaml", "--unit", "mm", *STONE)
    assert code == 2
    assert "written" in out
    assert "no block is fixed" in err
    assert "2 interfaces" in err


def test_repairs_are_printed_once(call, tmp_path):
    block = bs.Block.box("b", bs.Q_([0, 0, 0], "m"), bs.Q_([1, 1, 1], "m"), bs.Material("s", "20 kN/m^3"))
    scans = [tmp_path / "a.stl", tmp_path / "b.stl"]
    for scan in scans:
        scan.write_bytes(stl_bytes([block], inward=True))
    _, out, err = call("import", *scans, "-o", tmp_path / "m.yaml", "--unit", "m", *STONE)
    assert out.count("faces turned to look outward: 24 (a, b)") == 1
    assert "GeometryWarning" not in err


def test_moved_vertices_widen_the_joints_and_say_so(call, tmp_path):
    warped = obj_text([*CUBE[:6], (1, 1, 1.002), CUBE[7]])
    (tmp_path / "a.obj").write_text(warped, encoding="utf-8")
    _, out, _ = call("import", tmp_path / "a.obj", "-o", tmp_path / "m.yaml", "--unit", "m", *STONE)
    assert "coordinates are rounded: allow a gap of 0.005 m in joints" in out
    assert "tolerance: 0.005 m" in (tmp_path / "m.yaml").read_text(encoding="utf-8")


def test_a_drawing(call, tmp_path):
    drawing = ezdxf.new()
    drawing.header["$INSUNITS"] = 4
    for layer, y in (("GROUND", -200), ("WALL", 0)):
        drawing.layers.add(layer)
        corners = [(0, y), (500, y), (500, y + 200), (0, y + 200)]
        drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
    drawing.saveas(tmp_path / "wall.dxf")
    words = ["--unit", "mm", "--thickness", "30 cm", "--friction", "0.6", "--fix-layer", "GROUND"]
    layers = ["--unit-weight", "WALL=20 kN/m^3", "--unit-weight", "GROUND=25 kN/m^3"]
    code, out, _ = call("import", tmp_path / "wall.dxf", "-o", tmp_path / "m.yaml", *words, *layers)
    assert code == 0
    assert "1 interfaces, 0.15 m^2" in out
    assert bs.read_document(tmp_path / "m.yaml").model.block("WALL.1").weight == pytest.approx(600)


def test_an_assembly(call, tmp_path):
    vertex = {str(i): dict(zip("xyz", v, strict=True)) for i, v in enumerate(CUBE)}
    mesh = {"vertex": vertex, "face": {str(i): f for i, f in enumerate(QUADS)}}
    (tmp_path / "a.json").write_text(json.dumps({"node": {"0": {"block": mesh}}}), encoding="utf-8")
    _, out, _ = call("import", tmp_path / "a.json", "-o", tmp_path / "m.json", "--unit", "m", *STONE)
    assert "1 blocks of 6 faces" in out


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["none.obj"], "none.obj: cannot be read"),
        (["STACK", "a.dxf"], "several can only be read if all are meshes"),
        (["STACK", "--thickness", "1 m"], "belong to DXF drawings"),
        (["STACK", "--fix", "stone 9"], "no block 'stone 9' to fix"),
        (["STACK", "--unit-weight", "30 kN/m^3"], "--unit-weight: give it once"),
        (["wall.dwg"], "ends in .obj, .stl or .ply"),
    ],
)
def test_bad_input_is_one_message_and_no_document(call, stack, tmp_path, words, expected):
    words = [stack if w == "STACK" else w for w in words]
    code, _, err = call("import", *words, "-o", tmp_path / "m.yaml", "--unit", "mm", *STONE)
    assert code == 2
    assert err.startswith("error: ")
    assert expected in err
    assert not (tmp_path / "m.yaml").exists()


def test_a_document_is_not_replaced(call, stack, tmp_path):
    stack.with_suffix(".yaml").write_text("mine", encoding="utf-8")
    code, _, err = call("import", stack, "-o", stack.with_suffix(".yaml"), "--unit", "mm", *STONE)
    assert code == 2
    assert "exists and is not replaced" in err
    assert stack.with_suffix(".yaml").read_text(encoding="utf-8") == "mine"
