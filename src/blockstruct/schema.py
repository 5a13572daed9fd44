"""The JSON schemas that ship with blockstruct, and what an instance violates."""

import json
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any


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
    """Each violation of a schema, or of a part of it, as (path inside the instance, message), in order of the paths."""
    import jsonschema

    found = []
    for error in _validator(name, part).iter_errors(instance):
        best = jsonschema.exceptions.best_match([error]) or error
        path = "/" + "/".join(str(p) for p in best.absolute_path)
        message = best.message
        if best.validator in ("const", "enum", "pattern"):
            message = f"found {best.instance!r}, {message}"
        elif best.validator == "type" and "description" in best.schema:
            message = f"{message}; {best.schema['description']}"
        if len(message) > 300:
            message = f"{message[:300]} …"
        found.append((path, message))
    return sorted(found)


def listed_violations(found: list[tuple[str, str]]) -> str:
    """Violations as a text, a line each."""
    count = "a violation" if len(found) == 1 else f"{len(found)} violations"
    return "\n".join([f"{count} of the schema:", *(f"  {where}: {what}" for where, what in found)])
