"""The wall of a model document."""

from typing import Any

from blockstruct.model import Block, Material
from blockstruct.structures import Buttress, Opening, RoundOpening, Rubble, Sidewall, wall


def wall_of(entry: dict[str, Any], material: Material) -> list[Block]:
    """Return the blocks of a wall entry that follows the schema, with its sidewalls and buttresses."""
    parts: dict[str, Any] = {
        "openings": _openings(entry),
        "sidewalls": [Sidewall(**side | {"openings": _openings(side)}) for side in entry.get("sidewalls", [])],
        "buttresses": [Buttress(**buttress) for buttress in entry.get("buttresses", [])],
    }
    if "rubble" in entry:
        parts["rubble"] = Rubble(**entry["rubble"])
    return wall(**entry | parts | {"material": material})


def _openings(entry: dict[str, Any]) -> list[Opening | RoundOpening]:
    """Return the openings of a wall or a sidewall. An opening with a centre is round."""
    return [
        RoundOpening(**opening) if "centre" in opening else Opening(**opening) for opening in entry.get("openings", [])
    ]
