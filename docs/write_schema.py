"""Writes the variables of ``analysis-2.json`` as the tables of ``docs/file-format.md`` state them.

A variable is added by a row of its table, and by running this from the root of the repository.
"""

import json
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PAGE, SCHEMA = ROOT / "docs" / "file-format.md", ROOT / "schemas" / "analysis-2.json"
TITLES = {
    "model": "`/model`",
    "case": "a case",
    "history": "a history",
    "capacity": "a capacity curve",
    "response": "a response",
}
KINDS: dict[str, Any] = {"float": {"const": "f"}, "integer": {"enum": ["i", "u"]}, "text": {"const": "text"}}


def rows(part: str) -> list[list[str]]:
    """Rows of the table of a part: name, dimensions, kind, units, MUST or MAY, meaning."""
    section = PAGE.read_text(encoding="utf-8").split(f"### Variables of {TITLES[part]}\n")[1].split("\n#")[0]
    found = re.findall(r"^\| `.*$", section, re.MULTILINE)
    return [[cell.strip() for cell in row.replace("`", "", 2).split("|")[1:-1]] for row in found]


def variables(part: str) -> dict[str, Any]:
    """What the schema says of the variables of a part."""
    properties = {}
    for name, dims, kind, units, _, meaning in rows(part):
        stated = {"dims": {"const": [] if dims == "scalar" else dims.split(", ")}, "kind": KINDS[kind]}
        either = units.split(" or ")
        if units:
            stated["units"] = {"const": units} if len(either) == 1 else {"enum": either}
        properties[name] = {
            "description": re.sub(r"`|\[([^]]*)\]\([^)]*\)", r"\1", meaning),
            "properties": stated,
            "required": list(stated),
        }
    return {"required": [row[0] for row in rows(part) if row[4] == "MUST"], "properties": properties}


def schema() -> dict[str, Any]:
    """The schema, with the variables that the page states."""
    found: dict[str, Any] = json.loads(SCHEMA.read_text(encoding="utf-8"))
    for part in TITLES:
        found["$defs"][part]["properties"]["variables"] |= variables(part)
    return found


def text() -> str:
    """The schema as text, a variable a line."""
    found, lines = schema(), {}
    for part in TITLES:
        held = found["$defs"][part]["properties"]["variables"]
        for holder, key in [*((held["properties"], name) for name in held["properties"]), (held, "required")]:
            lines[f"{part} {key}"] = json.dumps(holder[key], ensure_ascii=False)
            holder[key] = f"{part} {key}"
    words = json.dumps(found, indent=2, ensure_ascii=False)
    for place, line in lines.items():
        words = words.replace(f'"{place}"', line)
    return words + "\n"


if __name__ == "__main__":
    SCHEMA.write_text(text(), encoding="utf-8")
