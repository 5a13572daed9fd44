"""``blockstruct import`` and ``blockstruct check``, called as a user would."""

import ezdxf
import numpy as np
import pytest

import blockstruct as bs
from meshes import CUBE, objects_text, saved

STONE = ["--unit-weight", "20 kN/m^3", "--friction", "0.6"]


@pytest.fixture
def stack(tmp_path):
    """Three cubes of 0.5 m, in mm."""
    cubes = {f"stone {k}": [(500 * x, 500 * y, 500 * (z + k)) for x, y, z in CUBE] for k in range(3)}
    return saved(tmp_path, "stack.obj", objects_text(cubes))


def test_import_check_and_run(call, done, stack, tmp_path):
    model = tmp_path / "stack.yaml"
    code, out, err = call("import", stack, "-o", model, "--unit", "mm", *STONE, "--fix", "lowest")
    assert (code, err) == (0, "")
    assert "3 blocks of 18 faces, 1 fixed" in out
    assert "2 interfaces, 0.5 m^2" in out
    assert "ready to run: push +x" in done("check", model)
    done("run", model, "-o", tmp_path / "stack.h5")
    # Two stones of slenderness 2 on the third: they rock together at width / height.
    assert bs.open_analysis(tmp_path / "stack.h5")["push +x"].load_factor == pytest.approx(0.5, rel=1e-4)


def test_joints_opened_by_repairs_are_closed_and_listed_and_no_others(call, tmp_path):
    # Two stones on a slab, 2 mm apart; a corner of the one is 2 mm too low, in the slab.
    stones = [[(x * 0.9 + k * 0.902, y, z * 0.5) for x, y, z in CUBE] for k in range(2)]
    stones[0][0] = (0, 0, -0.002)
    slab = [(3 * x - 0.5, 2 * y - 0.5, z * 0.3 - 0.3) for x, y, z in CUBE]
    path = saved(tmp_path, "a.obj", objects_text({"slab": slab, "low": stones[0], "level": stones[1]}))
    model = tmp_path / "m.yaml"
    code, out, err = call("import", path, "-o", model, "--unit", "m", "--fix", "slab", *STONE)
    assert (code, err) == (0, "")
    assert "1 joint closed that repairs of its faces opened" in out
    assert "slab | low: " in out
    found = {(i.minus, i.plus) for i in bs.read_document(model).model.interfaces}
    assert found == {("slab", "low"), ("slab", "level")}


def test_directions_flow_and_the_angle_of_a_tilting_table(call, done, stack, tmp_path):
    model = tmp_path / "m.yaml"
    words = ["--unit", "mm", "--fix", "lowest", *STONE, "--flow", "associative", "--tilt"]
    done("import", stack, "-o", model, *words, "--direction", "-y", "--direction", "3,4,0")
    cases = bs.read_document(model).cases
    assert [(case.name, case.flow) for case in cases] == [("tilt -y", "associative"), ("tilt (3,4,0)", "associative")]
    assert [case.variable.loads[0].direction for case in cases] == [(0, -1, 0), pytest.approx((0.6, 0.8, 0))]
    # Two stones of slenderness 2 rock about an edge at a load factor of 1/2.
    angle = f"on a tilting table: falls at {np.degrees(np.arctan(0.5)):.4g} deg"
    assert angle in call("run", model, "-o", tmp_path / "m.h5")[1]
    # With cohesion the weight across the joints counts less than the weight along them.
    text, friction = model.read_text(encoding="utf-8"), "friction_coefficient: 0.6"
    model.write_text(text.replace(friction, f"{friction}, cohesion: 1 kPa"), encoding="utf-8")
    code, out, _ = call("run", model, "-o", tmp_path / "glued.h5")
    assert (code, "on a tilting table" in out) == (0, False)
    assert bs.read_document(model).model.interfaces[0].joint_material.cohesion == 1000


def test_a_drawing_and_a_mesh_in_one_import(done, stack, tmp_path):
    drawing = ezdxf.new()
    drawing.header["$INSUNITS"] = 4
    for layer, y in (("GROUND", 0), ("WALL", 200)):
        corners = [(2000, y), (2500, y), (2500, y + 200), (2000, y + 200)]
        drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
    drawing.saveas(path := tmp_path / "wall.dxf")
    words = ["--unit", "mm", "--thickness", "30 cm", "--friction", "0.6", "--fix-layer", "GROUND"]
    layers = ["--unit-weight", "WALL=20 kN/m^3", "--unit-weight", "GROUND=25 kN/m^3"]
    assert "1 interface, 0.15 m^2" in done("import", path, "-o", tmp_path / "m.yaml", *words, *layers)
    assert bs.read_document(tmp_path / "m.yaml").model.block("WALL.1").weight == pytest.approx(600)
    words = ["--unit", "mm", "--fix", "lowest", *STONE, "--thickness", "50 cm"]
    done("import", stack, path, "-o", tmp_path / "both.yaml", *words)
    names = [b.name for b in bs.read_document(tmp_path / "both.yaml").model.blocks]
    assert names == ["stack.stone 0", "stack.stone 1", "stack.stone 2", "wall.GROUND.1", "wall.WALL.1"]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["none.obj"], "none.obj: no such file"),
        (["LOOSE"], "no block is fixed"),
        (["STACK", "STACK", "--unit-weight", "A=30 kN/m^3"], "--unit-weight: give it once"),
        (["STACK", "--closing", "1 mm"], "closing belongs to .dxf"),
        (["STACK", "--override-unit"], "override_unit belongs to .dxf and .3dm"),
        (["STACK", "--up", "w"], "up is 'w'; give the axis"),
        (["STACK", "--exclude", "brick*"], "no block 'brick*' to exclude"),
        (["STACK", "--direction", "north"], "--direction 'north': give +x"),
        (["STACK", "--direction", "+z", "--tilt"], "a table tilts to a level direction"),
        (["STACK", "--fix", "stone 9"], "no block 'stone 9' to fix"),
        (["wall.dwg"], "end in .obj, .stl, .ply"),
    ],
)
def test_bad_input_is_one_message_and_no_document(call, stack, tmp_path, words, expected):
    fixed = [] if words == ["LOOSE"] else ["--fix", "lowest"]
    words = [stack if w in ("STACK", "LOOSE") else w for w in words]
    code, _, err = call("import", *words, *fixed, "-o", tmp_path / "m.yaml", "--unit", "mm", *STONE)
    assert code == 2
    assert err.startswith("error: ")
    assert expected in err
    assert not (tmp_path / "m.yaml").exists()


@pytest.mark.parametrize("content", ["", "no mesh at all"])
def test_a_document_is_never_replaced(fails, stack, tmp_path, content):
    stack.with_suffix(".yaml").write_text("mine", encoding="utf-8")
    stack.write_text(content, encoding="utf-8")
    fails("exists and is not replaced", "import", stack, "-o", stack.with_suffix(".yaml"), "--unit", "mm", *STONE)
    assert stack.with_suffix(".yaml").read_text(encoding="utf-8") == "mine"
    fails("not the name of a model document", "import", stack, "-o", tmp_path / "m.txt", "--unit", "mm", *STONE)
