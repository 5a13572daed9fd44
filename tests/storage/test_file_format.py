"""The page on the file format and the schema say the same."""

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "file-format.md").read_text(encoding="utf-8")
SCHEMA = json.loads((ROOT / "schemas" / "analysis-1.json").read_text(encoding="utf-8"))
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
