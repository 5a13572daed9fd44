"""What an import read, repaired and left out."""

from collections import Counter
from dataclasses import dataclass
from typing import Self

import numpy as np
import pandas as pd

from blockstruct.model import Block

#: Mean block sizes, m, between which masonry is found; a wrong unit leads out of them.
SMALLEST, LARGEST = 5e-3, 20.0
#: Gap in joints, relative to the mean block size, of blocks with rounded coordinates.
ROUNDED_GAP = 1e-3
#: What was done to a body, in words.
KINDS = {
    "welded": "corners joined with others close by",
    "no area": "faces without area dropped",
    "twin": "faces given twice dropped",
    "turned": "faces turned to look outward",
    "merged": "faces joined with neighbours in one plane",
    "flattened": "vertices moved into the planes of their faces",
    "split": "warped faces divided into triangles",
    "divided": "more bodies than one in a solid, each a block",
    "arcs": "arcs taken as straight pieces, which they exceed",
    "renamed": "name used twice",
}
#: Part of most imports of triangles: reported, not warned of.
_ROUTINE = ("merged", "divided")
#: Kinds whose amount is a length.
_LENGTHS = ("flattened", "arcs")


@dataclass(frozen=True, slots=True)
class Repair:
    """One thing done to one body.

    Attributes
    ----------
    block : str
        Name of the block, or of the solid before it was divided.
    kind : str
        A key of :data:`KINDS`.
    amount : float
        How often, or by how many m.
    """

    block: str
    kind: str
    amount: float


@dataclass(frozen=True, slots=True)
class ImportReport:
    """What an import read, repaired and left out.

    Attributes
    ----------
    source : str
        The file.
    scale : float
        Metres of a coordinate unit.
    blocks, faces : int
        How many there are now.
    supports : tuple of str
        Names of the fixed blocks.
    extent : tuple of float
        Size of the whole along x, y and z, m.
    mean_size : float
        Cube root of the mean volume of the blocks, m.
    sizes : (float, float)
        Cube roots of the least and the largest volume, m.
    volume : float
        Of all blocks, m³.
    repairs : tuple of Repair
    left_out : tuple of str
        What the file holds beside solids, a text each.
    """

    source: str
    scale: float
    blocks: int
    faces: int
    supports: tuple[str, ...]
    extent: tuple[float, ...]
    mean_size: float
    sizes: tuple[float, float]
    volume: float
    repairs: tuple[Repair, ...]
    left_out: tuple[str, ...]

    @classmethod
    def of(
        cls, blocks: list[Block], source: str, scale: float, repairs: tuple[Repair, ...], left_out: tuple[str, ...]
    ) -> Self:
        """Report on blocks that were made."""
        points = np.concatenate([b.shape.vertices for b in blocks])
        volumes = [b.volume for b in blocks]
        volume = sum(volumes)
        return cls(
            source=source,
            scale=scale,
            blocks=len(blocks),
            faces=sum(len(b.shape.faces) for b in blocks),
            supports=tuple(b.name for b in blocks if b.fixed),
            extent=tuple(np.ptp(points, axis=0).tolist()),
            mean_size=(volume / len(blocks)) ** (1 / 3),
            sizes=(min(volumes) ** (1 / 3), max(volumes) ** (1 / 3)),
            volume=volume,
            repairs=repairs,
            left_out=left_out,
        )

    @property
    def largest_move(self) -> float:
        """Largest distance, m, by which a vertex moved into the planes of its faces."""
        return max((r.amount for r in self.repairs if r.kind == "flattened"), default=0.0)

    @property
    def joint_gap(self) -> float:
        """Gap, m, to allow in joints because coordinates were rounded: zero if no vertex had to move.

        Ten times the largest move, and no less than a thousandth of the mean block size.
        """
        move = self.largest_move
        return max(ROUNDED_GAP * self.mean_size, 10 * move) if move > 0 else 0.0

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to look at before going on, a text each."""
        found = []
        if not SMALLEST <= self.mean_size <= LARGEST:
            found.append(
                f"the mean block size is {self.mean_size:.3g} m, masonry has {SMALLEST:g} to {LARGEST:g} m: "
                f"is the unit right (1 unit of the file is {self.scale:g} m)?"
            )
        found += [self._line(kind) for kind in KINDS if kind not in _ROUTINE and self._of(kind)]
        if self.left_out:
            found.append(f"left out: {'; '.join(self.left_out)}")
        return tuple(found)

    def table(self) -> pd.DataFrame:
        """Repairs, a row each: block, kind, amount and what the kind means."""
        rows = [(r.block, r.kind, r.amount, KINDS[r.kind]) for r in self.repairs]
        return pd.DataFrame(rows, columns=["block", "kind", "amount", "meaning"])

    def __str__(self) -> str:
        (x, y, z), (least, most) = self.extent, self.sizes
        lines = [
            f"{self.source}: {self.blocks} blocks of {self.faces} faces, {len(self.supports)} of them fixed",
            f"1 unit is {self.scale:g} m; {x:.4g} × {y:.4g} × {z:.4g} m, block sizes {least:.3g} to {most:.3g} m",
        ]
        lines += [self._line(kind) for kind in _ROUTINE if self._of(kind)]
        lines += [f"warning: {text}" for text in self.warnings]
        if self.joint_gap:
            lines.append(f"coordinates are rounded: allow a gap of {self.joint_gap:.2g} m in joints")
        return "\n".join(lines)

    def _of(self, kind: str) -> list[Repair]:
        return [r for r in self.repairs if r.kind == kind]

    def _line(self, kind: str) -> str:
        found = self._of(kind)
        amounts = [r.amount for r in found]
        figure = f"by up to {max(amounts):.3g} m" if kind in _LENGTHS else f"{sum(amounts):.0f}"
        names = list(Counter(r.block for r in found))
        more = f" and {len(names) - 5} more" if len(names) > 5 else ""
        return f"{KINDS[kind]}{' ' if kind in _LENGTHS else ': '}{figure} ({', '.join(names[:5])}{more})"


@dataclass(frozen=True, slots=True)
class Imported:
    """Blocks of a file, and the report on how they were read."""

    blocks: tuple[Block, ...]
    report: ImportReport
