"""The JSON schemas of blockstruct, and violations by an instance."""

import json
from collections.abc import Mapping
from functools import cache
from importlib import resources
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from blockstruct.errors import decimal_point, did_you_mean, shown

#: Largest number of violations listed. An instance with more is of another kind.
MOST_VIOLATIONS = 100


@cache
def schema_text(name: str) -> str:
    """Return the text of a schema: ``"model-1"`` or ``"analysis-2"``."""
    shipped = resources.files("blockstruct") / "schemas" / f"{name}.json"
    if shipped.is_file():
        return shipped.read_text(encoding="utf-8")
    # An editable install reads the working tree, with schemas/ next to src/.
    return (Path(__file__).parents[2] / "schemas" / f"{name}.json").read_text(encoding="utf-8")


@cache
def schema(name: str) -> dict[str, Any]:
    """Return a schema; callers do not change it."""
    content: dict[str, Any] = json.loads(schema_text(name))
    return content


class Stated(NamedTuple):
    """Dimensions, kind (``f`` for a float, ``i`` or ``text``) and attributes of a variable of an analysis file."""

    dims: tuple[str, ...]
    kind: str
    attrs: dict[str, str]


@cache
def stated(part: str) -> dict[str, Stated]:
    """Return the variables of a part of an analysis file, in the order of ``docs/file-format.md``.

    A variable with one of several units has no ``units``: they follow from its case.
    """
    found = {}
    for name, variable in schema("analysis-2")["$defs"][part]["properties"]["variables"]["properties"].items():
        of_file = variable["properties"]
        units = {"units": of_file["units"]["const"]} if "const" in of_file.get("units", {}) else {}
        attrs = units | {"long_name": variable["description"]}
        found[name] = Stated(tuple(of_file["dims"]["const"]), of_file["kind"].get("const", "i"), attrs)
    return found


def dressed(part: str, values: Mapping[str, Any]) -> dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]:
    """Return variables for xarray: values by name, with their dimensions, units and description."""
    known = stated(part)
    return {name: (known[name].dims, value, dict(known[name].attrs)) for name, value in values.items()}


@cache
def _validator(name: str, part: str) -> Any:
    import jsonschema

    whole = schema(name)
    chosen = {"$defs": whole["$defs"], "$ref": f"#/$defs/{part}"} if part else whole
    return jsonschema.Draft202012Validator(chosen)


def violations(instance: Any, name: str, part: str = "") -> list[tuple[str, str]]:
    """Return the violations of a schema, or of a part of a schema.

    The list has up to a hundred pairs (path, message), in order of the paths.
    """
    import jsonschema

    found, misspelt, lacking = list[tuple[str, str]](), set[str](), list[tuple[str, str]]()
    for error in islice(_validator(name, part).iter_errors(instance), MOST_VIOLATIONS):
        best = jsonschema.exceptions.best_match([error]) or error
        path = "/" + "/".join(str(p) for p in best.absolute_path)
        message = best.message
        if best.validator == "additionalProperties" and isinstance(best.instance, dict):
            known = best.schema.get("properties", {})
            unknown = [key for key in best.instance if key not in known][:10]
            message = "; ".join(f"unknown key {shown(key)}, {did_you_mean(key, known)}" for key in unknown)
            misspelt.add(_cut(path))
        elif alternatives := _alternatives(best):
            given = [key for key in alternatives if key in best.instance]
            if not given:
                lacking.append((_cut(path), _cut(f"give one of {', '.join(alternatives)}")))
                continue
            message = f"{' and '.join(given)} are given; give one of {', '.join(alternatives)}"
        elif best.validator in ("oneOf", "anyOf") and "description" in best.schema:
            message = f"found {shown(best.instance)}; {best.schema['description']}"
        elif best.validator == "const":
            message = f"found {shown(best.instance)}, {message}"
        elif best.validator == "type" and isinstance(best.instance, str) and (meant := decimal_point(best.instance)):
            message = f"{message}; write {meant}, with a decimal point"
        elif best.validator == "maxItems" and any(isinstance(item, int) for item in best.instance):
            message = f"{message}; a comma parts numbers of a list: write 0.5, with a decimal point, for 0,5"
        elif best.schema.get("title") == "quantity" and isinstance(best.instance, int | float):
            message = f"{shown(best.instance)} has no unit; give {best.schema['description']}"
        elif best.validator == "type" and "description" in best.schema:
            message = f"{message}; {best.schema['description']}"
        found.append((_cut(path), _cut(message)))
    # A missing key is usually the misspelt one.
    return sorted([*found, *(violation for violation in lacking if violation[0] not in misspelt)])


def _alternatives(error: Any) -> list[str]:
    """Return the keys of which an error requires one; empty for others."""
    options = error.validator_value if error.validator in ("oneOf", "anyOf") else []
    if not isinstance(error.instance, dict) or any(set(option) != {"required"} for option in options):
        return []
    return [key for option in options for key in option["required"]]


def listed_violations(found: list[tuple[str, str]]) -> str:
    """Return violations as a text, one line per violation."""
    count = "a violation" if len(found) == 1 else f"{len(found)} violations"
    return "\n".join([f"{count} of the schema:", *(f"  {where}: {what}" for where, what in found)])


def _cut(text: str) -> str:
    return text if len(text) <= 300 else f"{text[:300]} …"
