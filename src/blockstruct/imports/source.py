"""Contents of files, optional packages, and reports of imports."""

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, Self

import numpy as np
import pandas as pd

from blockstruct.arrays import Array
from blockstruct.errors import GeometryFileError, MissingExtraError
from blockstruct.files import read_file
from blockstruct.geometry.polygon import Planes
from blockstruct.imports.tolerances import EDGE, EXTENT, LEAST_HEIGHT, MOST_BYTES, MOST_FACES
from blockstruct.model import Block
from blockstruct.vocabulary import counted, listed

#: Numbers as all formats write them. Python also reads ``1_0``, ``nan`` and the digits of other scripts.
_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_WHOLE = re.compile(r"[-+]?[0-9]{1,18}")


def read_number(text: str) -> float:
    """Return the finite number that a text is; anything else is a ValueError.

    >>> read_number("-1.5e-3"), read_number(repr(2))
    (-0.0015, 2.0)
    """
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    if not math.isfinite(value):
        msg = f"{text[:60]!r} is not a finite number"
        raise ValueError(msg)
    return value


def read_whole(text: str) -> int:
    """Return the whole number that a text is; anything else is a ValueError."""
    if not _WHOLE.fullmatch(text):
        msg = f"{text[:60]!r} is not a whole number"
        raise ValueError(msg)
    return int(text)


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a file.

    Raises
    ------
    StorageError
        If the file cannot be read, or is larger than any mesh that is imported.
    GeometryFileError
        If the file is empty.
    """
    content = read_file(path, "a mesh, drawing or assembly", MOST_BYTES)
    if not content.strip():
        msg = f"{path}: is empty; export it again"
        raise GeometryFileError(msg)
    return content


def checked_faces(faces: int, path: Path) -> int:
    """Return the number of faces of a file; refuse too many before slow steps."""
    if faces > MOST_FACES:
        msg = (
            f"{path}: {faces} faces, the limit is {MOST_FACES}; simplify the meshes first: a rigid block "
            "needs the shape of its joints, not the grain of its surface"
        )
        raise GeometryFileError(msg)
    return faces


def read_text(path: Path) -> str:
    """Return the text of a file, as :func:`read_bytes`; refuse other content."""
    content = read_bytes(path)
    if b"\0" in content:
        msg = f"{path}: is not text; export it again"
        raise GeometryFileError(msg)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Older programs write names in the code page of Windows or of their own; digits are the same in all.
        return content.decode("cp1252", errors="replace")


def package(name: str, extra: str, needed_for: str) -> Any:
    """Import a package of an extra.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise MissingExtraError.of(error, extra, needed_for) from error


#: Text of each kind of repair.
KINDS = {
    "rounded": "coordinates far from the origin, which single precision rounds (export them nearer to it)",
    "welded": "corners joined with others close by",
    "no area": "faces without area dropped",
    "twin": "faces given twice dropped",
    "doubled": "bodies whose faces are all given twice, once each kept",
    "copy": "bodies given again under another name, dropped",
    "turned": "faces turned to look outward",
    "merged": "faces joined with neighbours in one plane",
    "flattened": "vertices moved into the planes of their faces",
    "split": "warped faces divided into triangles",
    "divided": "solids of more than one body divided, each body a block",
    "closed": "outlines closed whose ends lie apart",
    "retraced": "corners dropped at which an outline runs over its own edges again",
    "arcs": "arcs taken as straight pieces, which they exceed",
    "renamed": "name used twice",
    "behind": "supports drawn as one face, each a fixed block behind the face",
}
#: Kinds without a warning: most imports of triangles need them, or the file asks for them.
_ROUTINE = ("merged", "divided", "behind")
#: Kinds whose amount is a length.
_LENGTHS = ("rounded", "flattened", "closed", "arcs")


@dataclass(frozen=True, slots=True)
class Repair:
    """One repair of one body.

    Attributes
    ----------
    block : str
        Name of the block, or of the solid before it was divided.
    kind : str
        A key of :data:`KINDS`.
    amount : float
        Number, or length in m.
    """

    block: str
    kind: str
    amount: float


@dataclass(frozen=True, slots=True)
class ImportReport:
    """Report on imported blocks, repairs and ignored content.

    Attributes
    ----------
    source : str
        Name of the file or files.
    scale : float
        Metres per coordinate unit.
    blocks, faces : int
        Number of blocks, and of their faces after repairs.
    supports : tuple of str
        Names of the fixed blocks.
    extent : tuple of float
        Size of the structure along x, y and z, m.
    edge : float
        Median of the longest edges of all faces, m.
    sizes : (float, float)
        Cube roots of the smallest and the largest volume, m.
    volume : float
        Volume of all blocks, m³.
    repairs : tuple of Repair
    left_out : tuple of str
        Ignored content of the file, one text per item.
    notes : tuple of str
        Requested changes, one text per item.
    """

    source: str
    scale: float
    blocks: int
    faces: int
    supports: tuple[str, ...]
    extent: tuple[float, ...]
    edge: float
    sizes: tuple[float, float]
    volume: float
    repairs: tuple[Repair, ...]
    left_out: tuple[str, ...]
    notes: tuple[str, ...]

    @classmethod
    def of(cls, blocks: list[Block], source: str, scale: float, **lists: Any) -> Self:
        """Return the report on imported blocks, with its repairs, ignored content and notes."""
        points = np.concatenate([b.shape.vertices for b in blocks])
        edges = np.concatenate([Planes.of(b.shape.vertices, b.shape.faces).longest for b in blocks])
        volumes = [b.volume for b in blocks]
        return cls(
            source=source,
            scale=scale,
            blocks=len(blocks),
            faces=sum(len(b.shape.faces) for b in blocks),
            supports=tuple(b.name for b in blocks if b.fixed),
            extent=tuple(np.ptp(points, axis=0).tolist()),
            edge=float(np.median(edges)),
            sizes=(min(volumes) ** (1 / 3), max(volumes) ** (1 / 3)),
            volume=sum(volumes),
            **lists,
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Findings to check, one text per item."""
        texts = [self._unlikely_size] if self._unlikely_size else []
        texts += [self._line(kind) for kind in KINDS if kind not in _ROUTINE and self._of(kind)]
        if self.left_out:
            texts.append(f"left out: {'; '.join(self.left_out)}")
        return tuple(texts)

    def table(self) -> pd.DataFrame:
        """Return the repairs, one row each: block, kind, amount and meaning."""
        rows = [(r.block, r.kind, r.amount, KINDS[r.kind]) for r in self.repairs]
        return pd.DataFrame(rows, columns=["block", "kind", "amount", "meaning"])

    def __str__(self) -> str:
        (x, y, z), (least, most) = self.extent, self.sizes
        lines = [
            f"{self.source}: {counted(self.blocks, 'block')} of {self.faces} faces, {len(self.supports)} fixed",
            f"1 unit is {self.scale:g} m; {x:.4g} × {y:.4g} × {z:.4g} m, block sizes {least:.3g} to {most:.3g} m",
            *self.notes,
        ]
        lines += [self._line(kind) for kind in _ROUTINE if self._of(kind)]
        lines += [f"warning: {text}" for text in self.warnings]
        return "\n".join(lines)

    @property
    def _unlikely_size(self) -> str:
        """Sizes that are unlikely for masonry, in words; empty if there are no such sizes."""
        length, height = max(self.extent), self.extent[2]
        texts = []
        if not EXTENT[0] <= length <= EXTENT[1]:
            texts.append(f"the whole is {length:.4g} m long (masonry {EXTENT[0]:g} to {EXTENT[1]:g} m)")
        if height < LEAST_HEIGHT:
            texts.append(f"the whole is {height:.4g} m high (masonry {LEAST_HEIGHT:g} m or more)")
        if not EDGE[0] <= self.edge <= EDGE[1]:
            texts.append(f"a typical edge is {self.edge:.4g} m long (masonry {EDGE[0]:g} to {EDGE[1]:g} m)")
        return f"{', '.join(texts)}: is the unit right (1 unit of the file is {self.scale:g} m)?" if texts else ""

    def _of(self, kind: str) -> list[Repair]:
        return [r for r in self.repairs if r.kind == kind]

    def _line(self, kind: str) -> str:
        repairs = self._of(kind)
        amounts = [r.amount for r in repairs]
        figure = f"by up to {max(amounts):.3g} m" if kind in _LENGTHS else f"{sum(amounts):.0f}"
        names = listed(list(Counter(r.block for r in repairs)))
        return f"{KINDS[kind]}{' ' if kind in _LENGTHS else ': '}{figure} ({names})"


@dataclass(frozen=True, slots=True)
class Imported:
    """Blocks of a file, and the report on their import.

    Attributes
    ----------
    blocks : tuple of Block
    report : ImportReport
    moves : mapping
        Moves of the vertices of a block into the planes of its faces, shape (n, 3), m, for blocks with moves.
        :func:`blockstruct.contacts.corrected_joints` finds the joints that these moves opened.
    """

    blocks: tuple[Block, ...]
    report: ImportReport
    moves: Mapping[str, Array] = field(repr=False, compare=False)
