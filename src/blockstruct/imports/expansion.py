"""What the blocks of a drawing stand for, counted before any of it is made."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from blockstruct.errors import GeometryFileError

#: Entities that the blocks of a drawing may stand for: a few nested ones can stand for more than any memory holds.
MOST_EXPANDED = 100_000


def check_expansion(drawing: Any, path: Path, depth: int) -> None:
    """Refuse a drawing whose inserted blocks stand for too many entities, followed to a depth.

    Raises
    ------
    GeometryFileError
        If it does; the message names the inserted block of the model space that stands for most.
    """
    known: dict[tuple[str, int], int] = {}

    def inside(name: str, level: int) -> int:
        """Entities of a block, those of the blocks in it too."""
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
    if sum(sizes) > MOST_EXPANDED:
        worst = inserts[sizes.index(max(sizes))]
        msg = (
            f"{path}: its blocks stand for {sum(sizes):.3g} entities, block {_name(worst)!r} alone for "
            f"{max(sizes):.3g}, the limit is {MOST_EXPANDED}; remove what is not a stone, or draw fewer copies"
        )
        raise GeometryFileError(msg)


def _name(insert: Any) -> str:
    return str(insert.dxf.get("name", ""))


def _copies(insert: Any) -> int:
    """Rows times columns, as the file states them; more than a billion are no more than that."""
    rows, columns = (int(insert.dxf.get(f"{what}_count", 1)) for what in ("row", "column"))
    return min(max(1, rows) * max(1, columns), 10**9)
