"""Model documents: what they say, and what is refused."""

import copy
import json

import numpy as np
import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

import blockstruct as bs
from blockstruct import Q_
from blockstruct.documents import reader, yaml_core

BASIC = {
    "blockstruct": "model-1",
    "name": "two blocks",
    "materials": {"stone": {"density": "2000 kg/m^3"}},
    "joint_materials": {"dry": {"friction_angle": "30 deg", "cohesion": "0 MPa"}},
    "blocks": [
        {
            "name": "base",
            "material": "stone",
            "fixed": True,
            "box": {"origin": ["0 m", "0 m", "-20 cm"], "size": ["1 m", "1 m", "20 cm"]},
        },
        {
            "name": "wedge",
            "material": "stone",
            "polyhedron": {
                "unit": "cm",
                "vertices": [[0, 0, 0], [100, 0, 0], [0, 0, 50], [0, 100, 0], [100, 100, 0], [0, 100, 50]],
                "faces": [[0, 1, 2], [3, 5, 4], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]],
            },
        },
    ],
    "interfaces": {"joint_material": "dry", "tolerance": "0.1 mm"},
    "load_patterns": {
        "dead": [{"kind": "self_weight"}],
        "push": [
            {"kind": "body_force", "direction": [1, 0, 0]},
            {
                "kind": "point_load",
                "block": "wedge",
                "point": ["0 m", "50 cm", "25 cm"],
                "force": ["1 kN", "0 N", "0 N"],
            },
            {"kind": "face_load", "block": "wedge", "face": 4, "traction": ["1 kPa", "0 Pa", "0 Pa"]},
            {"kind": "moment", "block": "wedge", "moment": ["0 N*m", "1 N*m", "0 N*m"]},
        ],
    },
    "cases": [{"name": "push", "dead": "dead", "variable": "push", "flow": "associative"}],
    "settings": {"crushing_cells": 30},
}

#: Names that a model may have, and texts that a version of YAML takes for something else.
TEXTS = st.text().filter(str.isprintable) | st.text("0123456789_:.xobe-+~=<&*!?#'\" nys", max_size=6)


def write(tmp_path, content, suffix=".yaml"):
    path = tmp_path / f"model{suffix}"
    text = json.dumps(content) if suffix == ".json" else yaml.safe_dump(content, sort_keys=False)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_everything_a_document_can_say(tmp_path, suffix):
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


def test_joints_by_rule_with_tolerances_and_explicit_interfaces(tmp_path):
    content = copy.deepcopy(BASIC)
    content["joint_materials"]["lime"] = {"friction_coefficient": 0.7}
    box = {"material": "stone", "box": {"origin": ["1 m", "0 m", "0 m"], "size": ["1 m", "1 m", "20 cm"]}}
    content["blocks"] += [box | {"name": "side", "fixed": True}]
    content["blocks"][0]["box"]["size"] = ["2 m", "1 m", "20 cm"]
    content["blocks"][1] = {
        "name": "wedge",
        "material": "stone",
        "box": {"origin": ["0.2 mm", "0 m", "0 m"], "size": ["1 m", "1 m", "50 cm"]},
    }
    content["load_patterns"]["push"].pop(2)
    content["interfaces"] = {
        "joint_material": {"base|*": "lime", "*": "dry"},
        "tolerance": "1 mm",
        "angle_tolerance": "2 deg",
        "area_tolerance": "1 cm^2",
    }
    document = bs.read_document(write(tmp_path, content))
    assert {i.name: i.joint_material.name for i in document.model.interfaces} == {
        "base|wedge": "lime",
        "wedge|side": "dry",
    }
    limits = document.report.tolerances
    assert (limits.gap, limits.angle, limits.area) == pytest.approx((1e-3, np.radians(2), 1e-4))
    content["interfaces"]["explicit"] = [
        {
            "minus": "base",
            "plus": "wedge",
            "unit": "cm",
            "polygon": [[0, 0, 0], [50, 0, 0], [50, 100, 0], [0, 100, 0]],
            "joint_material": "dry",
        }
    ]
    document = bs.read_document(write(tmp_path, content))
    assert {i.name: i.joint_material.name for i in document.model.interfaces} == {
        "base|wedge": "dry",
        "wedge|side": "dry",
    }
    assert document.model.interfaces[0].area == pytest.approx(0.5)
    content["interfaces"]["joint_material"] = {"beds": "dry"}
    with pytest.raises(bs.errors.ModelError, match="'beds' is not a pattern"):
        bs.read_document(write(tmp_path, content))


def changed(*path, to=None, remove=False):
    content = copy.deepcopy(BASIC)
    *parents, last = path
    place = content
    for key in parents:
        place = place[key]
    if remove:
        del place[last]
    else:
        place[last] = to
    return content


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (changed("blockstruct", to="model-2"), ["/blockstruct", "model-1"]),
        (changed("materials", remove=True), ["'materials' is a required property"]),
        (changed("materials", "stone", to={}), ["/materials/stone"]),
        (changed("joint_materials", "dry", "friction_angle", to=30), ["/joint_materials/dry/friction_angle", "30"]),
        (changed("joint_materials", "dry", "friction_angel", to="30 deg"), ["friction_angel"]),
        (changed("blocks", 0, "box", "size", to=["1 m", "1 m"]), ["/blocks/0"]),
        (changed("blocks", 0, "colour", to="red"), ["/blocks/0", "colour"]),
        (changed("load_patterns", "push", 0, "kind", to="wind"), ["/load_patterns/push/0"]),
        (changed("cases", 0, "flow", to="dilatant"), ["/cases/0/flow", "dilatant"]),
    ],
)
def test_violations_of_the_schema_name_their_place(tmp_path, content, words):
    with pytest.raises(bs.errors.DocumentError) as caught:
        bs.read_document(write(tmp_path, content))
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("content", "error", "words"),
    [
        (changed("blocks", 1, "material", to="glass"), bs.errors.UnknownNameError, ["'glass'", "stone"]),
        (changed("interfaces", "joint_material", to="glue"), bs.errors.UnknownNameError, ["'glue'", "dry"]),
        (changed("cases", 0, "dead", to="live"), bs.errors.UnknownNameError, ["'push'", "'live'"]),
        (
            changed("cases", to=2 * BASIC["cases"]),
            bs.errors.ModelError,
            ["case names used more than once: push; rename"],
        ),
        (changed("materials", "stone", to={"unit_weight": "-1 N/m^3"}), bs.errors.ModelError, ["'stone'", "negative"]),
        (changed("blocks", 1, "polyhedron", "unit", to="kg"), bs.errors.DimensionError, ["'wedge'", "length"]),
        (changed("blocks", 0, "fixed", to=False), bs.errors.ModelError, ["no block is fixed"]),
        (changed("blocks", 0, "box", "origin", to=["0 m", "0 m", "much"]), bs.errors.UnitError, ["'base'", "'much'"]),
    ],
)
def test_documents_that_describe_no_model(tmp_path, content, error, words):
    with pytest.raises(error) as caught:
        bs.read_document(write(tmp_path, content))
    for word in words:
        assert word in str(caught.value)


def test_numbers_without_a_point_are_numbers(tmp_path):
    path = write(tmp_path, BASIC)
    path.write_text(path.read_text(encoding="utf-8") + "  gap_tolerance: 1e-3\n", encoding="utf-8")
    assert bs.read_document(path).settings["gap_tolerance"] == 1e-3


@pytest.mark.parametrize("number", ["040", "010", "08", "1:30", "1_000", "0o17", "0b11", "-0x1F"])
def test_numbers_that_versions_of_yaml_read_differently_are_refused(tmp_path, number):
    path = write(tmp_path, BASIC)
    path.write_text(path.read_text(encoding="utf-8") + f"  patience: {number}\n", encoding="utf-8")
    with pytest.raises(
        bs.errors.DocumentError, match=rf"{number} is read differently.*'{number}' in quotes[^$]*at line \d+"
    ):
        bs.read_document(path)


@pytest.mark.parametrize(("word", "truth"), [("yes", "true"), ("Off", "false")])
def test_yes_and_no_are_refused(tmp_path, word, truth):
    path = write(tmp_path, BASIC)
    path.write_text(path.read_text(encoding="utf-8").replace("fixed: true", f"fixed: {word}"), encoding="utf-8")
    with pytest.raises(
        bs.errors.DocumentError, match=f"{word} is {truth} in YAML 1.1 and a text in YAML 1.2; write {truth}"
    ):
        bs.read_document(path)


@pytest.mark.parametrize(("text", "number"), [("1e3", 1000), ("+30", 30), ("0x1F", 31), ("1.", 1), (".5", 0.5)])
def test_numbers_of_the_core_schema(text, number):
    assert yaml_core.load(f"[{text}]") == [number]


@given(content=st.recursive(TEXTS | st.integers() | st.floats(allow_nan=False), st.lists, max_leaves=5))
@example(content=["1e5", "040", "1:30", "yes", "2026-01-31", "<<", "=", "null", "", "0x1F", ".nan", "1_0", "~", "0o7"])
def test_what_is_written_is_read_back(content):
    assert yaml_core.load(yaml_core.dump({"a": content})) == {"a": content}


COMMAS = """blockstruct: model-1
materials: {tuff: {unit_weight: 12 kN/m^3}}
joint_materials: {lime: {friction_coefficient: 0.65}}
blocks:
  - {name: base, material: tuff, fixed: true, box: {origin: [-1 m, -1 m, -1 m], size: [3 m, 3 m, 1 m]}}
  - {name: b, material: tuff, box: {origin: [0 m, 0 m, 0 m], size: [0.5 m, 1 m, 1 m]}}
interfaces: {joint_material: lime}
load_patterns: {dead: [{kind: self_weight}], push: [{kind: body_force, direction: +x}]}
cases: [{name: push, dead: dead, variable: push, flow: associative}]
"""


@pytest.mark.parametrize(
    ("point", "comma", "said"),
    [
        (
            "12 kN/m^3",
            '"12,5 kN/m^3"',
            ["material 'tuff'", "'12,5 kN/m^3'", "write '12.5 kN/m^3', with a decimal point"],
        ),
        ("[0.5 m,", '["-0,5 m",', ["block 'b': size", "'-0,5 m'", "write '-0.5 m', with a decimal point"]),
        (
            "[0.5 m,",
            "[0,5 m,",
            ["/blocks/1/box/size: [0, '5 m', '1 m', '1 m']", "write 0.5, with a decimal point, for 0,5"],
        ),
        ("0.65", '"0,65"', ["/lime/friction_coefficient: '0,65'", "write 0.65, with a decimal point"]),
        ("0.65", "0,65", ["line 3", "a key that is not text", "0.5 for 0,5"]),
    ],
)
def test_a_decimal_comma_is_told_to_be_a_point(tmp_path, point, comma, said):
    path = tmp_path / "wall.yaml"
    path.write_text(COMMAS, encoding="utf-8")
    bs.read_document(path)
    path.write_text(COMMAS.replace(point, comma, 1), encoding="utf-8")
    with pytest.raises(bs.errors.BlockstructError) as caught:
        bs.read_document(path)
    text = "\n".join([str(caught.value), *getattr(caught.value, "__notes__", ())])
    assert "wall.yaml" in text
    for words in said:
        assert words in text


def test_a_misspelt_key_is_told_the_one_that_was_meant(tmp_path):
    content = changed("joint_materials", "dry", to={"friction": 0.65})
    with pytest.raises(
        bs.errors.DocumentError, match=r"/dry: unknown key 'friction', did you mean friction_coefficient or"
    ):
        bs.read_document(write(tmp_path, content))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            {"friction_coefficient": 0.6, "friction_angle": "30 deg"},
            "friction_coefficient and friction_angle are given; ",
        ),
        ({"cohesion": "1 kPa"}, ""),
    ],
)
def test_one_of_two_keys_is_asked_for(tmp_path, given, said):
    with pytest.raises(bs.errors.DocumentError) as refused:
        bs.read_document(write(tmp_path, changed("joint_materials", "dry", to=given)))
    assert str(refused.value).splitlines()[1:] == [
        f"  /joint_materials/dry: {said}give one of friction_coefficient, friction_angle"
    ]


def test_a_case_with_a_variable_load_and_directions(tmp_path):
    content = changed("cases", 0, "directions", to=4)
    with pytest.raises(
        bs.errors.DocumentError, match="/cases/0: variable and directions are given; give one of variable"
    ):
        bs.read_document(write(tmp_path, content))


def test_a_misspelt_key_is_one_violation(tmp_path):
    content = changed("materials", "tuff", to={"unitweight": "20 kN/m^3"})
    with pytest.raises(bs.errors.DocumentError) as refused:
        bs.read_document(write(tmp_path, content))
    assert str(refused.value).splitlines()[1:] == [
        "  /materials/tuff: unknown key 'unitweight', did you mean unit_weight?"
    ]


@pytest.mark.parametrize("direction", ["+x", [1, 0, 0]])
def test_the_direction_of_a_control_point_may_be_an_axis(tmp_path, direction):
    case = {"kind": "pushover", "name": "p", "dead": "dead", "variable": "push"}
    content = changed("cases", to=[case | {"control": {"block": "wedge", "direction": direction}}])
    content["load_patterns"] = {"dead": [{"kind": "self_weight"}], "push": [{"kind": "body_force", "direction": "+x"}]}
    (read,) = bs.read_document(write(tmp_path, content)).cases
    assert read.control == ("wedge", (1.0, 0.0, 0.0))
    content["cases"][0]["control"]["direction"] = "+w"
    with pytest.raises(bs.errors.DocumentError, match=r"/cases/0/control/direction: found '\+w'; .* such as '\+x'"):
        bs.read_document(write(tmp_path, content))


@pytest.mark.parametrize(
    ("load", "violations"),
    [
        (
            {"kind": "area_load", "weight_per_aera": "4 kPa", "block": "wedge"},
            [
                "'weight_per_area' is a required property",
                "unknown key 'weight_per_aera', did you mean weight_per_area?",
            ],
        ),
        ({"kind": "weigth"}, ["'weigth' is not one of ['self_weight'"]),
        ({"block": "wedge"}, ["'kind' is a required property"]),
        ({"kind": "self_weight", "share": 1}, ["unknown key 'share', known are kind"]),
    ],
)
def test_a_load_is_told_what_its_own_kind_lacks(tmp_path, load, violations):
    content = copy.deepcopy(BASIC)
    content["load_patterns"]["dead"].append(load)
    path = tmp_path / "m.json"
    path.write_text(json.dumps(content))
    with pytest.raises(bs.errors.DocumentError) as caught:
        bs.read_document(path)
    told = str(caught.value).splitlines()[1:]
    assert len(told) == len(violations)
    assert all(words in line for words, line in zip(violations, told, strict=True))
    assert all("/load_patterns/dead/1" in line for line in told)


def test_a_name_that_reads_as_a_number_is_told_to_be_quoted(tmp_path):
    path = write(tmp_path, changed("blocks", 1, "name", to="1.1"))
    path.write_text(path.read_text(encoding="utf-8").replace("'1.1'", "1.1"), encoding="utf-8")
    with pytest.raises(bs.errors.DocumentError, match=r"/blocks/1/name: 1.1 is not of type 'string'; .* is quoted"):
        bs.read_document(path)


def test_aliases_stand_for_what_they_name(tmp_path):
    text = write(tmp_path, BASIC).read_text(encoding="utf-8")
    shared = text.replace("material: stone", "material: &m stone", 1).replace("material: stone", "material: *m")
    (tmp_path / "shared.yaml").write_text(shared, encoding="utf-8")
    assert shared != text
    assert bs.read_document(tmp_path / "shared.yaml").model.hash == bs.read_document(tmp_path / "model.yaml").model.hash


def test_what_aliases_stand_for_is_changed_place_by_place():
    held = yaml_core.load("a: &m {x: [1]}\nb: &n {m: *m, n: [*m]}\nc: *n\n")
    held["c"]["m"]["x"].append(2)
    assert held == {
        "a": {"x": [1]},
        "b": {"m": {"x": [1]}, "n": [{"x": [1]}]},
        "c": {"m": {"x": [1, 2]}, "n": [{"x": [1]}]},
    }


def test_a_document_of_any_size_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(reader, "MOST_BYTES", 100)
    with pytest.raises(bs.errors.DocumentError, match="divide the structure"):
        bs.read_document(write(tmp_path, BASIC))


def test_errors_of_a_document_name_the_file(tmp_path):
    with pytest.raises(bs.errors.UnitError) as caught:
        bs.read_document(write(tmp_path, changed("materials", "stone", to={"density": "heavy"})))
    assert any("model.yaml" in note for note in caught.value.__notes__)


def test_a_number_where_a_quantity_is_due_is_told_so(tmp_path):
    with pytest.raises(
        bs.errors.DocumentError,
        match=r"/materials/stone/density: 2600 has no unit; give a number, a space and a unit, as",
    ):
        bs.read_document(write(tmp_path, changed("materials", "stone", to={"density": 2600})))


def test_walls_may_stand_anywhere(tuff):
    kwargs = {"unit_length": "1 m", "unit_height": "1 m", "depth": "1 m", "material": tuff, "base": False}
    (unit,) = bs.courses([[1]], **kwargs, origin=["5 m", "-20 cm", "1 m"])
    assert unit.centroid == pytest.approx([5.5, 0.3, 1.5])


def test_unknown_settings_are_refused(tmp_path):
    document = bs.read_document(write(tmp_path, changed("settings", to={"speed": 3})))
    with pytest.raises(bs.errors.ModelError, match="speed"):
        bs.ProcedureSettings.of(document.settings)


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_repeated_keys_are_refused(tmp_path, suffix):
    path = tmp_path / f"m{suffix}"
    path.write_text('{"materials": {"a": {"density": "1 kg/m^3"}, "a": {"density": "2 kg/m^3"}}}', encoding="utf-8")
    with pytest.raises(bs.errors.DocumentError, match=r"repeated keys \['a'\]"):
        bs.read_document(path)


@pytest.mark.parametrize("text", ["a: [1", "!!python/object/apply:os.system ['true']", "\x00", "- 1\n- 2"])
def test_texts_that_are_no_document(tmp_path, text):
    path = tmp_path / "m.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(bs.errors.DocumentError, match=r"m\.yaml"):
        bs.read_document(path)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(bs.errors.StorageError, match="cannot be read"):
        bs.read_document(tmp_path / "missing.yaml")
    (tmp_path / "latin.yaml").write_bytes(b"name: gr\xf6\xdfer")
    with pytest.raises(bs.errors.StorageError, match="is not text"):
        bs.read_document(tmp_path / "latin.yaml")
