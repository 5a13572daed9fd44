"""Solids as a file gives them, and the blocks that they become."""

import warnings
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import GeometryError, GeometryFileError, GeometryWarning, ModelError, UnknownNameError
from blockstruct.imports.import_report import Imported, ImportReport, Repair
from blockstruct.imports.soup import closed_bodies, compact, gathered, welded
from blockstruct.imports.surface import closed_surface
from blockstruct.model import Block, Material
from blockstruct.units import parse, si, to_quantity

Array = NDArray[np.float64]
Face = tuple[int, ...]

#: Height above the lowest point, relative to the mean block size, up to which a block belongs to the lowest ones.
LOWEST = 1e-2


@dataclass(frozen=True, slots=True)
class Solid:
    """Faces that a file keeps together: one body or several, not yet checked.

    Attributes
    ----------
    name : str
    vertices : (n, 3) array
        In units of the file.
    faces
        Vertex indices of each face.
    material : Material
    fixed : bool
        Whether the file itself makes it a support.
    """

    name: str
    vertices: Array
    faces: list[Face]
    material: Material
    fixed: bool = False


def scale_of(unit: Any, source: str) -> float:
    """Metres of one coordinate unit: of ``"mm"``, or of a length such as ``"0.025 m"``."""
    what = f"{source}: unit of the coordinates"
    if isinstance(unit, str) and unit.strip()[:1].isalpha():
        unit = parse(f"1 {unit.strip()}", what)
    scale = si(unit, "length", what)
    if scale <= 0:
        msg = f"{what}: {scale:.6g} m; give a length above zero, such as 'mm' or '0.025 m'"
        raise ModelError(msg)
    return scale


def blocks_of(
    solids: Iterable[Solid],
    source: str,
    *,
    unit: Any,
    fixed: str | Iterable[str],
    tolerance: Any,
    left_out: Iterable[str] = (),
    repairs: Iterable[Repair] = (),
) -> Imported:
    """Blocks of solids, each body a block, with the report on what was repaired.

    Raises
    ------
    GeometryFileError
        No solid, or solids that are no blocks: all of them are listed.
    UnknownNameError
        A name in ``fixed`` that no block has.
    """
    scale = scale_of(unit, source)
    flat = None if tolerance is None else si(tolerance, "length", f"{source}: tolerance")
    if flat is not None and flat <= 0:
        msg = f"{source}: tolerance {flat:.6g} m; give a length above zero"
        raise ModelError(msg)
    left_out, repairs = tuple(left_out), list(repairs)
    bodies = _renamed([body for solid in solids for body in _bodies(solid, scale, source, repairs)], repairs)
    if not bodies:
        others = f" (left out: {'; '.join(left_out)})" if left_out else ""
        msg = f"{source}: holds no solid{others}; give a file with closed bodies"
        raise GeometryFileError(msg)
    blocks, refused = [], []
    for body in bodies:
        try:
            surface = closed_surface(body.vertices, body.faces, body.name, flat)
            points = to_quantity(surface.vertices, "length")
            block = Block.from_faces(body.name, points, surface.faces, body.material, fixed=body.fixed)
        except GeometryError as error:
            refused.append(str(error))
            continue
        blocks.append(block)
        repairs += [Repair(body.name, kind, amount) for kind, amount in surface.repairs.items()]
    if refused:
        rest = f"\n  and {len(refused) - 10} more" if len(refused) > 10 else ""
        listed = "\n  ".join(refused[:10])
        msg = f"{source}: {len(refused)} of {len(bodies)} bodies are no blocks:\n  {listed}{rest}"
        raise GeometryFileError(msg)
    blocks = _supported(blocks, fixed, source)
    report = ImportReport.of(blocks, source, scale, tuple(repairs), left_out)
    if report.warnings:
        warnings.warn(f"{source}: {'; '.join(report.warnings)}", GeometryWarning, stacklevel=4)
    return Imported(tuple(blocks), report)


def _bodies(solid: Solid, scale: float, source: str, repairs: list[Repair]) -> list[Solid]:
    """Closed bodies of a solid in m, with welded corners."""
    given = [f for f in solid.faces if len(f) > 2]
    if not given:
        return []
    known, named = len(solid.vertices), list(chain.from_iterable(given))
    if min(named) < 0 or max(named) >= known:
        wrong = min(named) if min(named) < 0 else max(named)
        msg = f"{source}: {solid.name!r}: a face names vertex {wrong}, there are {known}; the file is damaged"
        raise GeometryFileError(msg)
    points, loops = compact(solid.vertices, given)
    if not np.all(np.isfinite(points)):
        msg = f"{source}: {solid.name!r}: a vertex has a coordinate that is not finite; correct the file"
        raise GeometryFileError(msg)
    vertices, faces, moved = welded(points * scale, gathered(loops))
    proper = [f for f in faces if len(f) > 2]
    parts, twins = closed_bodies(proper)
    dropped = len(solid.faces) - len(proper)
    done = {"welded": moved, "no area": dropped, "twin": twins, "divided": len(parts) - 1}
    repairs += [Repair(solid.name, kind, amount) for kind, amount in done.items() if amount > 0]
    names = [solid.name] if len(parts) == 1 else [f"{solid.name}.{k}" for k in range(1, len(parts) + 1)]
    bodies = [compact(vertices, [proper[i] for i in part]) for part in parts]
    return [replace(solid, name=n, vertices=v, faces=f) for n, (v, f) in zip(names, bodies, strict=True)]


def _renamed(bodies: list[Solid], repairs: list[Repair]) -> list[Solid]:
    """Bodies with unique names: the second ``a`` becomes ``a#2``."""
    taken = {body.name for body in bodies}
    seen: Counter[str] = Counter()
    unique = []
    for body in bodies:
        seen[body.name] += 1
        name = body.name
        while seen[body.name] > 1 and (name := f"{body.name}#{seen[body.name]}") in taken:
            seen[body.name] += 1
        if name != body.name:
            taken.add(name)
            repairs.append(Repair(name, "renamed", 1))
        unique.append(replace(body, name=name))
    return unique


def _supported(blocks: list[Block], fixed: str | Iterable[str], source: str) -> list[Block]:
    if isinstance(fixed, str):
        if fixed != "lowest":
            msg = f"{source}: fixed is {fixed!r}; give 'lowest' or a list of block names"
            raise ModelError(msg)
        low = np.array([b.shape.vertices[:, 2].min() for b in blocks])
        size = float(np.mean([b.volume for b in blocks]) ** (1 / 3))
        names = {b.name for b, z in zip(blocks, low, strict=True) if z <= low.min() + LOWEST * size}
    else:
        names = set(fixed)
    unknown = sorted(names - {b.name for b in blocks})
    if unknown:
        few = ", ".join(b.name for b in blocks[:10])
        msg = f"{source}: no block {unknown[0]!r} to fix; there are {few}{' …' if len(blocks) > 10 else ''}"
        raise UnknownNameError(msg)
    return [replace(b, fixed=b.fixed or b.name in names) for b in blocks]
