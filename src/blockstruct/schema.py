"""The JSON schemas that ship with blockstruct, and what an instance violates."""

import json
import reprlib
from functools import cache
from importlib import resources
from itertools import islice
from pathlib import Path
from typing import Any

from blockstruct.keywords import did_you_mean

#: Violations beyond which an instance is of another kind, and more of them say nothing.
MOST_VIOLATIONS = 100


@cache
def schema_text(name: str) -> str:
    """Text of a schema: ``"model-1"`` or ``"analysis-1"``."""
    shipped = resources.files("blockstruct") / "schemas" / f"{name}.json"
    if shipped.is_file():
        return shipped.read_text(encoding="utf-8")
    # An editable install reads the working tree, where schemas/ stands beside src/.
    return (Path(__file__).parents[2] / "schemas" / f"{name}.json").read_text(encoding="utf-8")


@cache
def _validator(name: str, part: str) -> Any:
    import jsonschema

    schema = json.loads(schema_text(name))
    chosen = {"$defs": schema["$defs"], "$ref": f"#/$defs/{part}"} if part else schema
    return jsonschema.Draft202012Validator(chosen)


def violations(instance: Any, name: str, part: str = "") -> list[tuple[str, str]]:
    """Violations of a schema or a part of it, up to a hundred, as (path, message), in order of the paths."""
    import jsonschema

    found = []
    for error in islice(_validator(name, part).iter_errors(instance), MOST_VIOLATIONS):
        best = jsonschema.exceptions.best_match([error]) or error
        path = "/" + "/".join(str(p) for p in best.absolute_path)
        message = best.message
        if best.validator == "additionalProperties" and isinstance(best.instance, dict):
            known = best.schema.get("properties", {})
            unknown = [key for key in best.instance if key not in known][:10]
            message = "; ".join(f"unknown key {reprlib.repr(key)}, {did_you_mean(key, known)}" for key in unknown)
        elif best.validator in ("const", "enum", "pattern"):
            message = f"found {best.instance!r}, {message}"
        elif best.validator == "type" and "description" in best.schema:
            message = f"{message}; {best.schema['description']}"
        found.append((_cut(path), _cut(message)))
    return sorted(found)


def listed_violations(found: list[tuple[str, str]]) -> str:
    """Violations as a text, one line per violation."""
    count = "a violation" if len(found) == 1 else f"{len(found)} violations"
    return "\n".join([f"{count} of the schema:", *(f"  {where}: {what}" for where, what in found)])


def _cut(text: str) -> str:
    return text if len(text) <= 300 else f"{text[:300]} …"
