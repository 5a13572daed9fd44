"""The wall of a model document."""

from typing import Any

from blockstruct.model import Block, Material
from blockstruct.structures import Buttress, Opening, RoundOpening, Rubble, Sidewall, wall


def wall_of(entry: dict[str, Any], material: Material) -> list[Block]:
    """Blocks of a wall, which follows the schema, with all that belongs to it."""
    belongings: dict[str, Any] = {
        "openings": _openings(entry),
        "sidewalls": [Sidewall(**given | {"openings": _openings(given)}) for given in entry.get("sidewalls", [])],
        "buttresses": [Buttress(**given) for given in entry.get("buttresses", [])],
    }
    if "rubble" in entry:
        belongings["rubble"] = Rubble(**entry["rubble"])
    return wall(**entry | belongings | {"material": material})


def _openings(entry: dict[str, Any]) -> list[Opening | RoundOpening]:
    """Openings of a wall or a sidewall: those with a centre are round."""
    return [RoundOpening(**given) if "centre" in given else Opening(**given) for given in entry.get("openings", [])]
