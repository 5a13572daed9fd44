"""The page on the file format and the schema say the same."""

import json
import re
from pathlib import Path

import h5py
import pytest

import blockstruct as bs

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "file-format.md").read_text(encoding="utf-8")
SCHEMA = json.loads((ROOT / "schemas" / "analysis-2.json").read_text(encoding="utf-8"))
KINDS = {"float": {"const": "f"}, "integer": {"enum": ["i", "u"]}, "text": {"const": "text"}}


@pytest.mark.parametrize(
    ("title", "group"),
    [("`/model`", "model"), ("a case", "case"), ("a history", "history"), ("a capacity curve", "capacity")],
    ids=lambda t: t,
)
def test_every_variable_is_stated_as_the_schema_has_it(title, group):
    section = PAGE.split(f"### Variables of {title}\n")[1].split("\n#")[0]
    rows = [[c.strip() for c in line.split("|")[1:-1]] for line in section.splitlines() if line.startswith("| `")]
    variables = SCHEMA["$defs"][group]["properties"]["variables"]
    assert [row[0].strip("`") for row in rows] == list(variables["properties"])
    for name, dims, kind, units, must, _ in rows:
        stated = variables["properties"][name.strip("`")]["properties"]
        assert stated["dims"]["const"] == ([] if dims == "scalar" else dims.split(", "))
        assert stated["kind"] == KINDS[kind]
        either = stated.get("units", {})
        assert " or ".join(either.get("enum", [either.get("const", "")])) == units
        assert (name.strip("`") in variables["required"]) == (must == "MUST")


def test_every_attribute_is_stated():
    stated = {
        group: {
            name
            for line in re.findall(rf"^\| `{re.escape(group)}` \| (.*?) \| MUST", PAGE, re.MULTILINE)
            for name in re.findall(r"`(\w+)`", line)
        }
        for group in ("/", "/model", "/cases/<name>")
    }
    assert stated["/"] == set(SCHEMA["properties"]["attrs"]["required"])
    assert stated["/model"] == set(SCHEMA["$defs"]["model"]["properties"]["attrs"]["required"])
    assert stated["/cases/<name>"] == set(SCHEMA["$defs"]["case"]["properties"]["attrs"]["required"])


def test_every_variable_tells_what_it_is(small_model, small_cases, tmp_path):
    """As readers without blockstruct show it; flags count nothing, but have units as every number that is no index."""
    found = bs.detect_interfaces(small_model.blocks, joint_material=small_model.interfaces[0].joint_material)
    push = small_cases[0]
    curve = bs.Pushover("curve", push.dead, push.variable, control=(small_model.blocks[-1].name, (1, 0, 0)), steps=3)
    path = tmp_path / "x.h5"
    bs.AnalysisManager(bs.Model("told", small_model.blocks, found), path).run([*small_cases, curve])
    bare = []

    def look(name, item):
        if isinstance(item, h5py.Dataset) and b"not a netCDF variable" not in bytes(item.attrs.get("NAME", b"")):
            bare.extend([] if item.attrs.get("long_name") else [name])
            assert item.dtype.kind != "f" or "units" in item.attrs, name

    with h5py.File(path) as file:
        file.visititems(look)
        for flag in ("fixed", "floating", "untouched", "near_miss_of_contact"):
            assert file[f"model/{flag}"].attrs["units"] == "dimensionless"
        assert file["model/material_of_block"].attrs["long_name"] == "index of its material"
    assert bare == ["schema"]
    bs.check_file(path)
