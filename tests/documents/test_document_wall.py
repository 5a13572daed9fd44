"""Walls of model documents equal walls of ``bs.wall``."""

import pytest
import yaml

import blockstruct as bs
from blockstruct.structures import Buttress, Opening, RoundOpening, Rubble, Sidewall
from refusals import refused

STONE = bs.Material("stone", "20 kN/m^3")
SIZE = {"length": "4 m", "courses": 12, "unit_height": "25 cm", "thickness": "0.5 m"}
UNITS = {"unit_length": "0.5 m"}
DOOR = {"start": "0.5 m", "sill": "0 m", "width": "1 m", "height": "1 m"}
DOOR |= {"rise": "0.5 m", "ring": "0.3 m", "voussoirs": 9}
ROUND = {"centre": ["2.75 m", "1.625 m"], "diameter": "0.7 m", "ring": "0.2 m", "voussoirs": 12}
HOLE = {"start": "0.5 m", "sill": "0.5 m", "width": "0.5 m", "height": "0.5 m", "bearing": "0 m"}
SIDE = {"name": "side", "at": "0 m", "length": "1.5 m", "bonded": False}
PIER = {"name": "pier", "at": "3 m", "width": "0.5 m", "courses": 8, "projection": "0.6 m", "top_projection": "0.3 m"}
RUBBLE = {"seed": 3, "shortest": "0.25 m", "longest": "0.7 m", "overlap": "0.1 m"}


def written(folder, entry, **others):
    content = {
        "blockstruct": "model-1",
        "materials": {"stone": {"unit_weight": "20 kN/m^3"}},
        "joint_materials": {"lime": {"friction_coefficient": 0.6}},
        "wall": {**SIZE, "material": "stone", **entry},
        "interfaces": {"joint_material": "lime"},
        "load_patterns": {"dead": [{"kind": "self_weight"}], "push": [{"kind": "body_force", "direction": [0, 1, 0]}]},
        "cases": [{"name": "push", "dead": "dead", "variable": "push"}],
    }
    path = folder / "wall.yaml"
    path.write_text(yaml.safe_dump(content | others), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("entry", "same"),
    [
        (
            UNITS | {"openings": [DOOR, ROUND], "gable": "1.2 m", "prefix": "f."},
            UNITS | {"openings": [Opening(**DOOR), RoundOpening(**ROUND)], "gable": "1.2 m", "prefix": "f."},
        ),
        (
            {"rubble": RUBBLE, "sidewalls": [SIDE | {"openings": [HOLE]}], "buttresses": [PIER]},
            {
                "rubble": Rubble(**RUBBLE),
                "sidewalls": [Sidewall(**SIDE, openings=[Opening(**HOLE)])],
                "buttresses": [Buttress(**PIER)],
            },
        ),
        (UNITS | {"leaves": 2, "header_every": 3, "base": True}, UNITS | {"leaves": 2, "header_every": 3}),
    ],
    ids=["arch, round window and gable", "rubble, sidewall and buttress", "leaves"],
)
def test_a_wall_equals_the_wall_of_the_builder(tmp_path, entry, same):
    model = bs.read_document(written(tmp_path, entry)).model
    blocks = bs.wall(**SIZE, material=STONE, **same)
    assert model.hash == bs.Model("wall", blocks, bs.detect_interfaces(blocks, bs.JointMaterial("lime", 0.6))).hash


def test_a_room_equals_the_room_of_the_builder(tmp_path):
    size = {"length": "4 m", "width": "3 m", "height": "3 m", "unit_length": "1 m", "unit_height": "0.5 m"}
    size |= {"thickness": "0.5 m", "gable": "1 m", "bonded": False}
    path = written(tmp_path, {}, room=size | {"material": "stone", "openings": {"left": [HOLE | {"start": "1 m"}]}})
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    del content["wall"]
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    hole = Opening("1 m", "0.5 m", "0.5 m", "0.5 m", "0 m")
    blocks = bs.room(**size, material=STONE, openings={"left": [hole]})
    same = bs.Model("wall", blocks, bs.detect_interfaces(blocks, bs.JointMaterial("lime", 0.6)))
    assert bs.read_document(path).model.hash == same.hash


def test_a_wall_and_blocks(tmp_path):
    shape = {"origin": ["1 m", "0 m", "3 m"], "size": ["1 m", "0.5 m", "1 m"]}
    post = {"name": "post", "material": "stone", "box": shape}
    model = bs.read_document(written(tmp_path, {"unit_length": "0.5 m"}, blocks=[post])).model
    assert {"base", "12.1", "post"} <= {block.name for block in model.blocks}


@pytest.mark.parametrize(
    ("entry", "error", "words"),
    [
        ({"material": "glass"}, bs.errors.UnknownNameError, "'glass' stone"),
        ({}, bs.errors.ModelError, "unit_length rubble"),
        ({"openings": [DOOR | {"centre": ["1 m", "1 m"]}]}, bs.errors.DocumentError, "/wall/openings/0 start"),
        (UNITS | {"depth": "1 m"}, bs.errors.DocumentError, "/wall 'depth' thickness"),
        ({"rubble": {"seed": 3}}, bs.errors.DocumentError, "/wall/rubble shortest"),
    ],
)
def test_refused_walls(tmp_path, entry, error, words):
    with refused(error, words):
        bs.read_document(written(tmp_path, entry))
