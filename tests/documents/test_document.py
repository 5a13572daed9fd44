"""Model documents: what they hold, walls in them, and documents that are written and read again."""

import copy
import json

import numpy as np
import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

import blockstruct as bs
from blockstruct import Q_
from blockstruct.documents import yaml_core
from blockstruct.structures import Buttress, Opening, RoundOpening, Rubble, Sidewall
from refusals import refused
from structures import PIER, every_load, model_of, moved, rotation

BASIC = yaml.safe_load("""\
blockstruct: model-1
name: two blocks
materials: {stone: {density: 2000 kg/m^3}}
joint_materials: {dry: {friction_angle: 30 deg, cohesion: 0 MPa}}
blocks:
  - {name: base, material: stone, fixed: true, box: {origin: [0 m, 0 m, -20 cm], size: [1 m, 1 m, 20 cm]}}
  - name: wedge
    material: stone
    polyhedron:
      unit: cm
      vertices: [[0, 0, 0], [100, 0, 0], [0, 0, 50], [0, 100, 0], [100, 100, 0], [0, 100, 50]]
      faces: [[0, 1, 2], [3, 5, 4], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]]
interfaces: {joint_material: dry, tolerance: 0.1 mm}
load_patterns:
  dead: [{kind: self_weight}]
  push:
    - {kind: body_force, direction: [1, 0, 0]}
    - {kind: point_load, block: wedge, point: [0 m, 50 cm, 25 cm], force: [1 kN, 0 N, 0 N]}
    - {kind: face_load, block: wedge, face: 4, traction: [1 kPa, 0 Pa, 0 Pa]}
    - {kind: moment, block: wedge, moment: [0 N*m, 1 N*m, 0 N*m]}
cases: [{name: push, dead: dead, variable: push, flow: associative}]
settings: {crushing_cells: 30}
""")

#: Names that a model may have, and texts that a version of YAML takes for something else.
TEXTS = st.text().filter(str.isprintable) | st.text("0123456789_:.xobe-+~=<&*!?#'\" nys", max_size=6)


def text_of(content):
    return yaml.safe_dump(content, sort_keys=False)


def write(tmp_path, content, suffix=".yaml"):
    """A file of content, or of a text."""
    path = tmp_path / f"model{suffix}"
    if not isinstance(content, str):
        content = json.dumps(content) if suffix == ".json" else text_of(content)
    path.write_text(content, encoding="utf-8")
    return path


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_a_document_with_every_kind_of_entry(tmp_path, suffix):
    document = bs.read_document(write(tmp_path, BASIC, suffix))
    wedge = document.model.block("wedge")
    assert wedge.volume == pytest.approx(0.25)
    assert wedge.weight == pytest.approx(0.25 * 2000 * 9.80665)
    joint = document.model.joint_materials["dry"]
    assert joint.friction_coefficient == pytest.approx(np.tan(np.pi / 6))
    (case,) = document.cases
    assert case.flow is bs.Flow.ASSOCIATIVE
    assert case.variable.loads[1] == bs.PointLoad("wedge", Q_([0, 0.5, 0.25], "m"), Q_([1, 0, 0], "kN"))
    assert document.settings == {"crushing_cells": 30}
    assert document.report.accepted == 1
    result = bs.AnalysisManager(document.model).run(document.cases)["push"]
    # Sliding: (W + 1 kN + 1 kPa · 0.5 m²) α = μ W; the couple takes no part in it.
    W = wedge.weight
    assert result.load_factor == pytest.approx(np.tan(np.pi / 6) * W / (W + 1500), rel=1e-6)


def joints_of(document):
    return {i.name: i.joint_material.name for i in document.model.interfaces}


def test_joints_by_rule_with_tolerances_and_explicit_interfaces(tmp_path):
    content = yaml.safe_load(PIER)
    content["joint_materials"]["dry"] = {"friction_coefficient": 0.6}
    shape = {"origin": ["0.5 m", "0 m", "0 m"], "size": ["1 m", "1 m", "20 cm"]}
    content["blocks"].append({"name": "side", "material": "tuff", "fixed": True, "box": shape})
    content["blocks"][1]["box"]["origin"][0] = "0.2 mm"
    tolerances = {"tolerance": "1 mm", "angle_tolerance": "2 deg", "area_tolerance": "1 cm^2"}
    content["interfaces"] = {"joint_material": {"base|*": "lime", "*": "dry"}, **tolerances}
    document = bs.read_document(write(tmp_path, content))
    assert joints_of(document) == {"base|pier": "lime", "pier|side": "dry"}
    limits = document.report.tolerances
    assert (limits.gap, limits.angle, limits.area) == pytest.approx((1e-3, np.radians(2), 1e-4))
    polygon = [[0, 0, 0], [25, 0, 0], [25, 100, 0], [0, 100, 0]]
    given = {"minus": "base", "plus": "pier", "unit": "cm", "polygon": polygon, "joint_material": "dry"}
    content["interfaces"]["explicit"] = [given]
    document = bs.read_document(write(tmp_path, content))
    assert joints_of(document) == {"base|pier": "dry", "pier|side": "dry"}
    assert document.model.interfaces[0].area == pytest.approx(0.25)
    content["interfaces"]["joint_material"] = {"beds": "dry"}
    with refused(bs.errors.ModelError, "'beds' pattern"):
        bs.read_document(write(tmp_path, content))


REMOVED = object()


def changed(*path, to):
    content = copy.deepcopy(BASIC)
    *parents, last = path
    place = content
    for key in parents:
        place = place[key]
    if to is REMOVED:
        del place[last]
    else:
        place[last] = to
    return content


STONE, DRY = ("materials", "stone"), ("joint_materials", "dry")
DOCUMENT, MODEL, UNKNOWN = bs.errors.DocumentError, bs.errors.ModelError, bs.errors.UnknownNameError
BOTH = {"friction_coefficient": 0.6, "friction_angle": "30 deg"}


@pytest.mark.parametrize(
    ("error", "words", "path", "value"),
    [
        # The schema is violated: the message has the place and the value.
        (DOCUMENT, "/blockstruct model-1", ("blockstruct",), "model-2"),
        (DOCUMENT, "'materials' required", ("materials",), REMOVED),
        (DOCUMENT, "/materials/stone/density 2600 unit", STONE, {"density": 2600}),
        (DOCUMENT, "/joint_materials/dry 'friction' friction_coefficient friction_angle", DRY, {"friction": 0.65}),
        (DOCUMENT, "/blocks/0", ("blocks", 0, "box", "size"), ["1 m", "1 m"]),
        (DOCUMENT, "/cases/0/flow dilatant", ("cases", 0, "flow"), "dilatant"),
        (DOCUMENT, "/cases/0: variable directions", ("cases", 0, "directions"), 4),
        (DOCUMENT, "/cases/0", ("cases", 0, "vertical"), 1),
        (DOCUMENT, "/cases/0", ("cases", 0), {"name": "push", "dead": "dead", "directions": [30]}),
        # The document follows the schema, but describes no model.
        (UNKNOWN, "'glass' stone", ("blocks", 1, "material"), "glass"),
        (UNKNOWN, "'push' 'live'", ("cases", 0, "dead"), "live"),
        (MODEL, "case names push", ("cases",), 2 * BASIC["cases"]),
        (MODEL, "'two blocks' fixed=True", ("blocks", 0, "fixed"), False),
        (bs.errors.UnitError, "'base' 'much'", ("blocks", 0, "box", "origin"), ["0 m", "0 m", "much"]),
    ],
)
def test_refused_documents(tmp_path, error, words, path, value):
    with refused(error, words):
        bs.read_document(write(tmp_path, changed(*path, to=value)))


@pytest.mark.parametrize("text", ["040", "010", "08", "1:30", "1_000", "0o17", "0b11", "-0x1F", "yes", "Off"])
def test_texts_that_versions_of_yaml_read_differently_are_refused(tmp_path, text):
    with refused(DOCUMENT, f"model.yaml {text} '{text}' quotes line"):
        bs.read_document(write(tmp_path, text_of(BASIC) + f"  patience: {text}\n"))


@pytest.mark.parametrize(("text", "number"), [("1e3", 1000), ("+30", 30), ("0x1F", 31), ("1.", 1), (".5", 0.5)])
def test_numbers_of_the_core_schema(text, number):
    assert yaml_core.load(f"[{text}]") == [number]


@given(content=st.recursive(TEXTS | st.integers() | st.floats(allow_nan=False), st.lists, max_leaves=5))
@example(content=["1e5", "040", "1:30", "yes", "2026-01-31", "<<", "=", "null", "", "0x1F", ".nan", "1_0", "~", "0o7"])
def test_any_content_is_written_and_read(content):
    assert yaml_core.load(yaml_core.dump({"a": content})) == {"a": content}


@pytest.mark.parametrize(
    ("point", "comma", "words"),
    [
        ("12 kN/m^3", '"12,5 kN/m^3"', "'tuff' '12,5 kN/m^3' '12.5 kN/m^3'"),
        ("[0.5 m,", "[0,5 m,", "/blocks/1/box/size '5 m' 0.5 0,5"),
        ("0.65", '"0,65"', "/lime/friction_coefficient '0,65' 0.65"),
        ("0.65", "0,65", "model.yaml line 4 0.5 0,5"),
    ],
)
def test_a_decimal_comma_is_refused_with_the_decimal_point(tmp_path, point, comma, words):
    bs.read_document(write(tmp_path, PIER))
    with refused(bs.errors.BlockstructError, words) as caught:
        bs.read_document(write(tmp_path, PIER.replace(point, comma, 1)))
    assert "model.yaml" in "\n".join([str(caught.value), *getattr(caught.value, "__notes__", ())])


@pytest.mark.parametrize(
    ("path", "value", "line"),
    [
        (DRY, BOTH, "/joint_materials/dry: friction_coefficient and friction_angle"),
        (DRY, {"cohesion": "1 kPa"}, "/joint_materials/dry: give one of friction_coefficient, friction_angle"),
        (("materials", "tuff"), {"unitweight": "20 kN/m^3"}, "/materials/tuff: unknown key 'unitweight'"),
        (("load_patterns", "dead", 0), {"kind": "weigth"}, "/load_patterns/dead/0/kind: 'weigth'"),
        (("load_patterns", "dead", 0), {"block": "wedge"}, "/load_patterns/dead/0: 'kind'"),
        (("load_patterns", "dead", 0), {"kind": "self_weight", "share": 1}, "/dead/0: unknown key 'share'"),
    ],
)
def test_one_mistake_is_one_violation(tmp_path, path, value, line):
    with pytest.raises(DOCUMENT) as caught:
        bs.read_document(write(tmp_path, changed(*path, to=value)))
    (violation,) = str(caught.value).splitlines()[1:]
    assert line in violation


@pytest.mark.parametrize("direction", ["+x", [1, 0, 0]])
def test_the_direction_of_a_control_point_may_be_an_axis(tmp_path, direction):
    case = {"kind": "pushover", "name": "p", "dead": "dead", "variable": "push"}
    content = changed("cases", to=[case | {"control": {"block": "wedge", "direction": direction}}])
    content["load_patterns"] = {"dead": [{"kind": "self_weight"}], "push": [{"kind": "body_force", "direction": "+x"}]}
    (read,) = bs.read_document(write(tmp_path, content)).cases
    assert read.control == ("wedge", (1.0, 0.0, 0.0))
    content["cases"][0]["control"]["direction"] = "+w"
    with refused(DOCUMENT, "/cases/0/control/direction '+w' '+x'"):
        bs.read_document(write(tmp_path, content))


@pytest.mark.parametrize("name", ["1.10", "-0.50", "7"])
def test_a_name_that_reads_as_a_number_needs_quotes(tmp_path, name):
    """Every YAML reader takes 1.10 for 1.1, which is another block: the message has it as written."""
    quoted = text_of(changed("blocks", 1, "name", to=name))
    assert f"'{name}'" in quoted
    with refused(DOCUMENT, f"/blocks/1/name {name} quote"):
        bs.read_document(write(tmp_path, quoted.replace(f"'{name}'", name)))


def test_aliases_give_independent_copies():
    held = yaml_core.load("a: &m {x: [1]}\nb: &n {m: *m, n: [*m]}\nc: *n\n")
    held["c"]["m"]["x"].append(2)
    one = {"x": [1]}
    assert held == {"a": one, "b": {"m": one, "n": [one]}, "c": {"m": {"x": [1, 2]}, "n": [one]}}


def test_unreadable_and_large_files(tmp_path, monkeypatch):
    (tmp_path / "latin.yaml").write_bytes(b"name: gr\xf6\xdfer")
    for name in ("missing.yaml", "latin.yaml"):
        with refused(bs.errors.StorageError, name):
            bs.read_document(tmp_path / name)
    monkeypatch.setattr("blockstruct.documents.document.MOST_BYTES", 100)
    with refused(bs.errors.StorageError, "MB"):
        bs.read_document(write(tmp_path, BASIC))


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_repeated_keys_are_refused(tmp_path, suffix):
    text = '{"materials": {"a": {"density": "1 kg/m^3"}, "a": {"density": "2 kg/m^3"}}}'
    with refused(DOCUMENT, f"model{suffix} 'a'"):
        bs.read_document(write(tmp_path, text, suffix))


TUFF = bs.Material("tuff", "12 kN/m^3")
SIZE = {"length": "4 m", "courses": 12, "unit_height": "25 cm", "thickness": "0.5 m", "material": "tuff"}
UNITS = {"unit_length": "0.5 m"}
DOOR = {"start": "0.5 m", "sill": "0 m", "width": "1 m", "height": "1 m"}
DOOR |= {"rise": "0.5 m", "ring": "0.3 m", "voussoirs": 9}
ROUND = {"centre": ["2.75 m", "1.625 m"], "diameter": "0.7 m", "ring": "0.2 m", "voussoirs": 12}
HOLE = {"start": "0.5 m", "sill": "0.5 m", "width": "0.5 m", "height": "0.5 m", "bearing": "0 m"}
SIDE = {"name": "side", "at": "0 m", "length": "1.5 m", "bonded": False}
SIDEWALL = Sidewall(**SIDE, openings=[Opening(**HOLE)])
BUTTRESS = {"name": "b", "at": "3 m", "width": "0.5 m", "courses": 8, "projection": "0.6 m", "top_projection": "0.3 m"}
RUBBLE = {"seed": 3, "shortest": "0.25 m", "longest": "0.7 m", "overlap": "0.1 m"}


def written(folder, **others):
    """The document of a pier, with other entries in place of its blocks."""
    content = yaml.safe_load(PIER)
    del content["blocks"]
    return write(folder, content | others)


@pytest.mark.parametrize(
    ("entry", "same"),
    [
        (
            UNITS | {"openings": [DOOR, ROUND], "gable": "1.2 m", "prefix": "f."},
            UNITS | {"openings": [Opening(**DOOR), RoundOpening(**ROUND)], "gable": "1.2 m", "prefix": "f."},
        ),
        (
            {"rubble": RUBBLE, "sidewalls": [SIDE | {"openings": [HOLE]}], "buttresses": [BUTTRESS]},
            {"rubble": Rubble(**RUBBLE), "sidewalls": [SIDEWALL], "buttresses": [Buttress(**BUTTRESS)]},
        ),
        (UNITS | {"leaves": 2, "header_every": 3, "base": True}, UNITS | {"leaves": 2, "header_every": 3}),
    ],
    ids=["arch, round window and gable", "rubble, sidewall and buttress", "leaves"],
)
def test_a_wall_equals_the_wall_of_the_builder(tmp_path, entry, same):
    model = bs.read_document(written(tmp_path, wall=SIZE | entry)).model
    blocks = bs.wall(**SIZE | {"material": TUFF} | same)
    assert model.hash == model_of(blocks, bs.JointMaterial("lime", 0.65)).hash


def test_a_room_equals_the_room_of_the_builder(tmp_path):
    size = {"length": "4 m", "width": "3 m", "height": "3 m", "unit_length": "1 m", "unit_height": "0.5 m"}
    size |= {"thickness": "0.5 m", "gable": "1 m", "bonded": False}
    room = size | {"material": "tuff", "openings": {"left": [HOLE | {"start": "1 m"}]}}
    read = bs.read_document(written(tmp_path, room=room)).model
    hole = Opening("1 m", "0.5 m", "0.5 m", "0.5 m", "0 m")
    blocks = bs.room(**size, material=TUFF, openings={"left": [hole]})
    assert read.hash == model_of(blocks, bs.JointMaterial("lime", 0.65)).hash


def test_a_wall_and_blocks(tmp_path):
    shape = {"origin": ["1 m", "0 m", "3 m"], "size": ["1 m", "0.5 m", "1 m"]}
    post = {"name": "post", "material": "tuff", "box": shape}
    model = bs.read_document(written(tmp_path, wall=SIZE | UNITS, blocks=[post])).model
    assert {"base", "12.1", "post"} <= {block.name for block in model.blocks}


@pytest.mark.parametrize(
    ("entry", "error", "words"),
    [
        ({"material": "glass"}, bs.errors.UnknownNameError, "'glass' tuff"),
        ({}, bs.errors.ModelError, "unit_length rubble"),
        ({"openings": [DOOR | {"centre": ["1 m", "1 m"]}]}, bs.errors.DocumentError, "/wall/openings/0 start"),
        (UNITS | {"depth": "1 m"}, bs.errors.DocumentError, "/wall 'depth' thickness"),
        ({"rubble": {"seed": 3}}, bs.errors.DocumentError, "/wall/rubble shortest"),
    ],
)
def test_refused_walls(tmp_path, entry, error, words):
    with refused(error, words):
        bs.read_document(written(tmp_path, wall=SIZE | entry))


ANGLES = {"friction_angle": "33 deg", "dilatancy_angle": "4.5 deg"}
STRENGTHS = {"cohesion": "0.11 MPa", "tensile_strength": "0.1 MPa", "compressive_strength": "4.7 MPa"}
LIME = bs.JointMaterial("lime: mortar", **ANGLES, **STRENGTHS)


@pytest.fixture
def model():
    size = {"unit_length": "37 cm", "unit_height": "17.5 cm", "thickness": "0.3333 m"}
    blocks = bs.courses([[1, 1], [0.5, 1, 0.5]], **size, material=TUFF)
    # Turned, so that no coordinate is a round number.
    blocks = moved(blocks, rotation((0, 0, 1), 0.3))
    return bs.Model("wall: turned", blocks, bs.detect_interfaces(blocks, joint_material=LIME).interfaces)


@pytest.fixture
def cases(model):
    weight, *others = every_load(model.block("2.1"))
    dead, push = bs.LoadPattern("dead", [weight, *others]), bs.LoadPattern("push", others[:5])
    return [bs.LimitCase(f"push {flow}", dead, push, flow) for flow in bs.Flow]


@pytest.mark.parametrize("suffix", ["yaml", "yml", "json"])
def test_a_document_keeps_model_cases_and_settings_to_the_last_bit(tmp_path, model, cases, suffix):
    settings = bs.ProcedureSettings(crushing_cells=81, schedule=bs.FictitiousSchedule(max_programs=33))
    path = bs.write_document(tmp_path / f"m.{suffix}", model, cases, settings=settings)
    back = bs.read_document(path)
    assert back.model.hash == model.hash
    assert back.cases == tuple(cases)
    assert bs.ProcedureSettings.of(back.settings) == settings


def test_the_tolerance_is_kept(tmp_path, model, cases):
    apart = [b if b.name != "2.2" else moved([b], rotation((0, 0, 1), 0), (0, 0, 1e-4))[0] for b in model.blocks]
    found = bs.detect_interfaces(apart, joint_material=LIME, tolerance="0.2 mm")
    loose = bs.Model("loose", apart, found.interfaces)
    path = bs.write_document(tmp_path / "m.yaml", loose, cases, tolerance=Q_(0.2, "mm"))
    assert bs.read_document(path).model.hash == loose.hash
    # Without the tolerance the document lists the open joint.
    stated = bs.read_document(bs.write_document(tmp_path / "other.yaml", loose, cases)).model
    assert {i.name for i in stated.interfaces} == {i.name for i in loose.interfaces}


def test_other_interfaces_are_listed(tmp_path, model, cases):
    """Another joint material, and half of a bed."""
    first, second = model.interfaces[:2]
    a, b, c, d = first.polygon
    half = bs.Interface("half", first.minus, first.plus, Q_([a, (a + b) / 2, (c + d) / 2, d], "m"), LIME)
    other = second.with_joint_material(bs.JointMaterial("other", 0.5))
    mixed = bs.Model("mixed", model.blocks, [half, other, *model.interfaces[2:]])
    path = bs.write_document(tmp_path / "m.yaml", mixed, cases)
    assert len(yaml.safe_load(path.read_text(encoding="utf-8"))["interfaces"]["explicit"]) == 2
    # Listed interfaces come first, as here.
    assert bs.read_document(path).model.hash == mixed.hash


def test_a_draft_may_lack_supports(tmp_path, model, cases):
    free = [bs.Block(b.name, b.shape, b.material) for b in model.blocks]
    path = bs.documents.write_draft(tmp_path / "m.yaml", "free", free, LIME, cases)
    with refused(bs.errors.ModelError, "'free' fixed=True"):
        bs.read_document(path)
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    content["blocks"][0]["fixed"] = True
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    assert bs.read_document(path).model.block("base").fixed


def test_bad_documents_are_not_written(tmp_path, model, cases):
    other = bs.LimitCase("other", bs.LoadPattern("dead", []), cases[0].variable)
    for error, words, name, written in [
        (bs.errors.DocumentError, "m.yaml /cases", "m.yaml", []),
        (bs.errors.ModelError, "m.txt .yaml", "m.txt", cases),
        (bs.errors.ModelError, "m.yaml patterns", "m.yaml", [*cases, other]),
        (bs.errors.ModelError, f"m.yaml {cases[0].name}", "m.yaml", [*cases, cases[0]]),
        (bs.errors.StorageError, "none/m.yaml", "none/m.yaml", cases),
    ]:
        with refused(error, words):
            bs.write_document(tmp_path / name, model, written)
    twice = bs.Block("2.3", model.blocks[-1].shape, bs.Material("tuff", "20 kN/m^3"))
    with refused(bs.errors.ModelError, "m.yaml materials"):
        bs.documents.write_draft(tmp_path / "m.yaml", "two tuffs", [*model.blocks[:-1], twice], LIME, cases)
    # A document cannot leave out an interface that detection finds.
    fewer = bs.Model("fewer", model.blocks, model.interfaces[1:])
    with refused(bs.errors.ModelError, f"'fewer' {model.interfaces[0].name!r}"):
        bs.write_document(tmp_path / "m.yaml", fewer, cases)
    assert list(tmp_path.iterdir()) == []
