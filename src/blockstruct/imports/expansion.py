"""Count of the entities in nested blocks of a drawing, before they are expanded."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from blockstruct.errors import GeometryFileError
from blockstruct.model.checks import MOST_BLOCKS


def check_expansion(drawing: Any, path: Path, depth: int) -> None:
    """Refuse a drawing whose inserted blocks expand to too many entities, followed to a depth.

    Raises
    ------
    GeometryFileError
        If there are too many. The message names the block in the model space with the most entities.
    """
    known: dict[tuple[str, int], int] = {}

    def inside(name: str, level: int) -> int:
        """Return the number of entities in a block, including nested blocks."""
        key = (name.lower(), level)
        if key not in known:
            known[key] = sum(counted(drawing.blocks.get(name) or (), level)) if level <= depth else 0
        return known[key]

    def counted(entities: Iterable[Any], level: int) -> Iterable[int]:
        for entity in entities:
            yield 1
            if entity.dxftype() == "INSERT":
                yield _copies(entity) * (1 + inside(_name(entity), level + 1))

    inserts = [e for e in drawing.modelspace() if e.dxftype() == "INSERT"]
    sizes = [_copies(e) * (1 + inside(_name(e), 1)) for e in inserts]
    if sum(sizes) > MOST_BLOCKS:
        worst = inserts[sizes.index(max(sizes))]
        msg = (
            f"{path}: its blocks expand to {sum(sizes):.3g} entities, block {_name(worst)!r} alone to "
            f"{max(sizes):.3g}, the limit is {MOST_BLOCKS}; remove entities that are not stones, or draw fewer copies"
        )
        raise GeometryFileError(msg)


def _name(insert: Any) -> str:
    return str(insert.dxf.get("name", ""))


def _copies(insert: Any) -> int:
    """Return rows times columns in the file, at most a billion."""
    rows, columns = (int(insert.dxf.get(f"{what}_count", 1)) for what in ("row", "column"))
    return min(max(1, rows) * max(1, columns), 10**9)
