"""The wall and the room of a model document."""

from typing import Any

from blockstruct.model import Block, Material
from blockstruct.structures import Buttress, Opening, RoundOpening, Rubble, Sidewall, room, wall


def wall_of(entry: dict[str, Any], material: Material) -> list[Block]:
    """Return the blocks of a wall entry that follows the schema, with its sidewalls and buttresses."""
    parts: dict[str, Any] = {
        "openings": _openings(entry),
        "sidewalls": [Sidewall(**side | {"openings": _openings(side)}) for side in entry.get("sidewalls", [])],
        "buttresses": [Buttress(**buttress) for buttress in entry.get("buttresses", [])],
    }
    return wall(**entry | parts | _rubble(entry) | {"material": material})


def room_of(entry: dict[str, Any], material: Material) -> list[Block]:
    """Return the blocks of a room entry that follows the schema."""
    holes = {name: _openings({"openings": listed}) for name, listed in entry.get("openings", {}).items()}
    return room(**entry | {"openings": holes} | _rubble(entry) | {"material": material})


def _rubble(entry: dict[str, Any]) -> dict[str, Rubble]:
    return {"rubble": Rubble(**entry["rubble"])} if "rubble" in entry else {}


def _openings(entry: dict[str, Any]) -> list[Opening | RoundOpening]:
    """Return the openings of a wall or a sidewall. An opening with a centre is round."""
    return [
        RoundOpening(**opening) if "centre" in opening else Opening(**opening) for opening in entry.get("openings", [])
    ]
