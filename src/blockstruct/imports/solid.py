"""Solids in files, their supports, and their conversion to blocks."""

import math
import re
import warnings
from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, count, islice
from pathlib import Path

import attrs
import numpy as np
import shapely

from blockstruct.arrays import Array
from blockstruct.errors import GeometryError, GeometryFileError, GeometryWarning, ModelError, UnknownNameError, shown
from blockstruct.geometry.polygon import Face, Planes, plane_axes
from blockstruct.geometry.polyhedron import lofted
from blockstruct.imports.source import Imported, ImportReport, Repair
from blockstruct.imports.surface import closed_bodies, closed_surface, collapsed, compact, gathered, welded
from blockstruct.imports.tolerances import FARTHEST, WELD
from blockstruct.model import Block, Material
from blockstruct.model.fields import positive_length
from blockstruct.model.fit import CLOSE, NEAR
from blockstruct.units import QuantityLike, si, to_quantity
from blockstruct.vocabulary import MOTIONS, counted, listed, shortened


def block_behind(face: Array, bodies: Sequence[Array]) -> tuple[Array, list[tuple[int, ...]]]:
    """Return vertices and faces of a support drawn as a face, on its side away from the nearest body.

    The face stays as it is drawn: another area or place of the joint gives another load factor. The block is as thick
    as the bodies, by the median of their smallest extents.

    Parameters
    ----------
    face : (n, 3) array
        Corners of the face, m.
    bodies
        Vertices (k, 3) of every other body, m; at least one.
    """
    plane = Planes.of(face, [tuple(range(len(face)))])
    centre, normal = plane.centre[0], plane.normal[0]
    axes = np.stack(plane_axes(normal), axis=1)
    outline = shapely.Polygon((face - centre) @ axes)
    heights = [(body - centre) @ normal for body in bodies]
    distances = [
        float(np.hypot(height, shapely.distance(outline, shapely.points((body - centre) @ axes))).min())
        for body, height in zip(bodies, heights, strict=True)
    ]
    side = np.copysign(1.0, heights[int(np.argmin(distances))].sum())
    thickness = float(np.median([np.ptp(body, axis=0).min() for body in bodies]))
    vertices, faces = lofted(face, face - side * thickness * normal)
    return vertices, list(faces)


def ground_under(blocks: Sequence[Block], level: str, source: str) -> Block:
    """Return a fixed block ``ground`` under all blocks, on every side larger by the extent of the structure.

    Parameters
    ----------
    blocks
    level
        Height of its top, ``"0.5 m"``; ``""`` or ``"lowest"`` for the lowest point of the blocks.
    source
        The files, for messages.

    Raises
    ------
    GeometryFileError
        If a block reaches below the level.
    """
    points = np.concatenate([b.shape.vertices for b in blocks])
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.mean([b.volume for b in blocks]) ** (1 / 3))
    top = float(low[2]) if level in ("", "lowest") else si(level, "length", f"{source}: level of the ground")
    if low[2] < top - NEAR * size:
        deepest = min(blocks, key=lambda b: float(b.shape.vertices[:, 2].min()))
        msg = (
            f"{source}: block {deepest.name!r} reaches down to {low[2]:.6g} m, below the ground at {top:.6g} m; give a "
            "lower level, or exclude the block"
        )
        raise GeometryFileError(msg)
    margin = float((high - low).max())
    origin = np.array([low[0] - margin, low[1] - margin, top - size])
    extent = np.array([high[0] - low[0] + 2 * margin, high[1] - low[1] + 2 * margin, size])
    corner, sizes = to_quantity(origin, "length"), to_quantity(extent, "length")
    return Block.box("ground", corner, sizes, blocks[0].material, fixed=True)


#: Axes of the file that become x, y and z of the model, and their signs, by the vertical axis of the file.
_UP = {"x": ([1, 2, 0], [1, 1, 1]), "y": ([0, 2, 1], [1, -1, 1]), "z": ([0, 1, 2], [1, 1, 1])}


@dataclass(frozen=True, slots=True)
class Solid:
    """Faces of one object of a file: one body or several, before the checks.

    Attributes
    ----------
    name : str
    vertices : (n, 3) array
        In units of the file.
    faces
        Vertex indices of each face.
    material : Material
    fixed : bool
        Whether the file marks it as a support.
    single : bool
        Whether the file stores coordinates in single precision.
    """

    name: str
    vertices: Array
    faces: list[Face]
    material: Material
    fixed: bool = False
    single: bool = False


@dataclass(slots=True)
class Content:
    """Content of a file: solids, texts on ignored content, repairs, and notes on requested changes.

    ``scale`` is the metres per unit of a file that states its unit.
    """

    solids: list[Solid] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    repairs: list[Repair] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    scale: float | None = None


@dataclass(slots=True)
class LeftOut:
    """Ignored objects of a file, by kind."""

    names: dict[str, list[str]] = field(default_factory=dict)

    def add(self, kind: str, name: str) -> None:
        """Note an ignored object."""
        self.names.setdefault(kind, []).append(name)

    def texts(self, label: str = "") -> list[str]:
        """Return one text per kind: number, kind and names."""
        return [f"{len(names)} {kind} ({label}{listed(names)})" for kind, names in sorted(self.names.items())]


def metres_per_unit(unit: QuantityLike, source: str) -> float:
    """Return the metres per coordinate unit, from ``"mm"`` or a length such as ``"0.025 m"``."""
    what = f"{source}: unit of the coordinates"
    if isinstance(unit, str) and unit.strip()[:1].isalpha():
        unit = f"1 {unit.strip()}"
    scale = si(unit, "length", what)
    if scale <= 0:
        msg = f"{what}: {scale:.6g} m; give a length above zero, such as 'mm' or '0.025 m'"
        raise ModelError(msg)
    return scale


def agreed_scale(
    unit: QuantityLike | None, stated: float | None, path: Path, *, override: bool = False, where: str = ""
) -> tuple[float, list[str]]:
    """Return the metres per coordinate unit of a file that may state its unit, and a note on a requested change.

    Parameters
    ----------
    unit
        The unit as given; None for the unit of the file.
    stated
        Metres per unit, as the file states it.
    override
        Whether ``unit`` overrides the unit of the file.
    where
        Place of the unit in the file, for messages.
    """
    if unit is None:
        if stated is None:
            msg = f"{path}: does not state its unit; give it as unit= (--unit), 'mm' for instance"
            raise ModelError(msg)
        return stated, []
    scale = metres_per_unit(unit, str(path))
    if stated is None or math.isclose(stated, scale):
        return scale, []
    states = f"the file states that its unit is {stated:g} m{where}"
    if override:
        return scale, [f"{states}, which is overridden: its unit is taken as {scale:g} m"]
    msg = (
        f"{path}: {states}, but unit= is {scale:g} m; give the unit of the file, or override_unit=True "
        "(--override-unit) if the unit in the file comes from a template"
    )
    raise GeometryFileError(msg)


def check_layers(wanted: Iterable[str], known: Collection[str], path: Path, kind: str = "layer") -> None:
    """Refuse names of layers, or of materials, that a file does not have.

    Raises
    ------
    UnknownNameError
        For the first such name.
    """
    for name in sorted(set(wanted) - set(known)):
        msg = f"{path}: has no {kind} {name!r}; it has {', '.join(sorted(known)) or 'none'}"
        raise UnknownNameError(msg)


def _common_scale(contents: Sequence[Content], unit: QuantityLike | None, source: str) -> float:
    """Return the metres per unit of all files: of those that state their unit, and as given for the others."""
    given = None if unit is None else metres_per_unit(unit, source)
    scales = [given if content.scale is None else content.scale for content in contents]
    known = [scale for scale in scales if scale is not None]
    if len(known) < len(scales):
        msg = f"{source}: unit is missing; give the unit of the coordinates (--unit), such as 'mm'"
        raise ModelError(msg)
    if not math.isclose(min(known), max(known)):
        units = ", ".join(f"{scale:g} m" for scale in sorted(set(known)))
        msg = f"{source}: their units differ ({units}); import the files one by one"
        raise GeometryFileError(msg)
    return known[0]


def make_blocks(
    contents: Sequence[Content],
    paths: Sequence[Path],
    *,
    unit: QuantityLike | None,
    fixed: str | Iterable[str],
    exclude: Iterable[str],
    up: str,
    tolerance: QuantityLike | None,
) -> Imported:
    """Convert each body in the solids of files to a block, and report the repairs.

    With several files, block names start with the name of the file, unless they are equal to this name.

    Raises
    ------
    GeometryFileError
        If there is no solid, solids are not blocks (the message lists them), or a body appears twice with different
        materials or only once as a support.
    UnknownNameError
        If no block has a name in ``fixed`` or ``exclude``.
    """
    source = ", ".join(map(str, paths[:3])) + (" …" if len(paths) > 3 else "")
    content = contents[0] if len(contents) == 1 else _joined(contents, paths)
    scale = _common_scale(contents, unit, source)
    flat = None if tolerance is None else positive_length(tolerance, f"{source}: tolerance")
    if up not in _UP:
        msg = f"{source}: up is {shown(up)}; give the axis of the file that points up: 'x', 'y' or 'z'"
        raise ModelError(msg)
    repairs, notes = list(content.repairs), list(content.notes)
    taken = {solid.name for solid in content.solids}
    divided = [b for solid in content.solids for b in _bodies(solid, scale, up, source, repairs, taken)]
    bodies = _renamed(divided, repairs)
    bodies = _without(bodies, exclude, source, notes)
    fixed = [fixed] if isinstance(fixed, str) else list(fixed)
    bodies = _with_supports_behind_faces(bodies, fixed, repairs)
    if not bodies:
        others = f" (left out: {'; '.join(content.left_out)})" if content.left_out else ""
        msg = f"{source}: holds no solid{others}; give a file with closed bodies"
        raise GeometryFileError(msg)
    blocks, moves, refused = [], {}, []
    for body in bodies:
        try:
            surface = closed_surface(body.vertices, body.faces, body.name, flat)
            points = to_quantity(surface.vertices, "length")
            block = Block.from_faces(body.name, points, surface.faces, body.material, fixed=body.fixed)
        except GeometryError as error:
            refused.append(str(error))
            continue
        blocks.append(block)
        if surface.moves.any():
            moves[body.name] = surface.moves
        repairs += [Repair(body.name, kind, amount) for kind, amount in surface.repairs.items()]
    if refused:
        of_bodies = counted(len(bodies), "body", "bodies")
        are_none = "is not a block" if len(refused) == 1 else "are not blocks"
        msg = f"{source}: {len(refused)} of {of_bodies} {are_none}:\n  " + "\n  ".join(shortened(refused))
        raise GeometryFileError(msg)
    blocks = _supported(_without_copies(blocks, source, repairs), fixed, source, notes)
    report = ImportReport.of(
        blocks, source, scale, repairs=tuple(repairs), left_out=tuple(content.left_out), notes=tuple(notes)
    )
    if report.warnings:
        warnings.warn(f"{source}: {'; '.join(report.warnings)}", GeometryWarning, stacklevel=3)
    return Imported(tuple(blocks), report, {b.name: moves[b.name] for b in blocks if b.name in moves})


def _joined(contents: Sequence[Content], paths: Sequence[Path]) -> Content:
    """Join the content of several files; names start with the name of the file."""
    whole = Content()
    for content, path in zip(contents, paths, strict=True):
        names = {s.name: s.name if s.name == path.stem else f"{path.stem}.{s.name}" for s in content.solids}
        whole.solids += [replace(s, name=names[s.name]) for s in content.solids]
        whole.repairs += [replace(r, block=names.get(r.block, r.block)) for r in content.repairs]
        whole.left_out += [f"{path.name}: {text}" for text in content.left_out]
        whole.notes += [f"{path.name}: {text}" for text in content.notes]
    return whole


def _bodies(
    solid: Solid, scale: float, up: str, source: str, repairs: list[Repair], taken: Collection[str]
) -> list[Solid]:
    """Return the closed bodies of a solid in m, upright, with welded corners and names that no solid has."""
    axis, sign = _UP[up]
    polygons = [f for f in solid.faces if len(f) > 2]
    if not polygons:
        return [replace(solid, vertices=solid.vertices[:, axis] * sign * scale, faces=[])]
    known, named = len(solid.vertices), list(chain.from_iterable(polygons))
    if min(named) < 0 or max(named) >= known:
        wrong = min(named) if min(named) < 0 else max(named)
        msg = f"{source}: {solid.name!r}: a face names vertex {wrong}, there are {known}; the file is damaged"
        raise GeometryFileError(msg)
    points, loops = compact(solid.vertices, polygons)
    if not np.all(np.isfinite(points)):
        msg = f"{source}: {solid.name!r}: a vertex has a coordinate that is not finite; correct the file"
        raise GeometryFileError(msg)
    if np.abs(points).max() > FARTHEST / scale:
        msg = (
            f"{source}: {solid.name!r}: a vertex is more than {FARTHEST:.2g} m from the origin, where rounding exceeds "
            "the tolerance of joints; correct its coordinates, or the unit"
        )
        raise GeometryFileError(msg)
    upright, loops = points[:, axis] * sign * scale, gathered(loops)
    vertices, faces, joined = welded(upright, loops)
    proper = [f for f in faces if len(f) > 2]
    parts, twins, doubled = closed_bodies(proper)
    lost = collapsed(upright, loops, np.array([len(f) < 3 for f in faces])) if len(proper) < len(faces) else []
    n, dropped = len(parts) + len(lost), len(solid.faces) - len(proper)
    if solid.single and proper:
        rounding = float(np.spacing(np.float32(np.abs(points).max()))) / 2 * scale
        edge = np.median([np.linalg.norm(vertices[f[1]] - vertices[f[0]]) for f in proper])
        if rounding > WELD * edge:
            repairs.append(Repair(solid.name, "rounded", rounding))
    done = {"welded": joined, "no area": dropped, "twin": twins, "doubled": doubled, "divided": n - 1}
    repairs += [Repair(solid.name, kind, amount) for kind, amount in done.items() if amount > 0]
    numbered = (name for k in count(1) if (name := f"{solid.name}.{k}") not in taken)
    names = [solid.name] if n == 1 else list(islice(numbered, n))
    bodies = [compact(vertices, [proper[i] for i in part]) for part in parts]
    # Bodies without faces are refused later, unless they are excluded.
    bodies += [(upright[list(face)], []) for face in lost]
    return [replace(solid, name=n, vertices=v, faces=f) for n, (v, f) in zip(names, bodies, strict=True)]


def _renamed(bodies: list[Solid], repairs: list[Repair]) -> list[Solid]:
    """Make names unique: the second ``a`` becomes ``a#2``."""
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


def _with_supports_behind_faces(bodies: list[Solid], fixed: Sequence[str], repairs: list[Repair]) -> list[Solid]:
    """Replace each support of a single face by a fixed block on its far side."""
    whole = [body.vertices for body in bodies if len(body.faces) > 1]
    supports = []
    for body in bodies:
        is_support = body.fixed or any(_pattern(_split(name)[0]).fullmatch(body.name) for name in fixed)
        if len(body.faces) != 1 or not is_support or not whole:
            supports.append(body)
            continue
        vertices, faces = block_behind(body.vertices[list(body.faces[0])], whole)
        supports.append(replace(body, vertices=vertices, faces=faces, fixed=True))
        repairs.append(Repair(body.name, "behind", 1))
    return supports


def _split(text: str) -> tuple[str, tuple[str, ...]]:
    """Return the name of a support, and the motions after its last colon; all motions without them."""
    name, _, motions = text.rpartition(":")
    held = tuple(motion.strip() for motion in motions.split(","))
    return (name, held) if name and set(held) <= set(MOTIONS) else (text, MOTIONS)


def _pattern(text: str) -> re.Pattern[str]:
    """Return the pattern of names where ``*`` matches any text."""
    return re.compile(".*".join(map(re.escape, text.split("*"))), re.DOTALL)


def _without(bodies: list[Solid], exclude: Iterable[str], source: str, notes: list[str]) -> list[Solid]:
    """Drop bodies by name; ``*`` matches any text."""
    if isinstance(exclude, str):
        exclude = [exclude]
    out: set[str] = set()
    for pattern in exclude:
        matches = {b.name for b in bodies if _pattern(pattern).fullmatch(b.name)}
        if not matches:
            raise UnknownNameError(_no_block(pattern, "exclude", [b.name for b in bodies], source))
        out |= matches
    if out:
        notes.append(f"excluded as asked: {listed(sorted(out))}")
    return [b for b in bodies if b.name not in out]


def _without_copies(blocks: list[Block], source: str, repairs: list[Repair]) -> list[Block]:
    """Drop copies of other blocks."""
    centres = np.array([b.centroid for b in blocks])
    extents = np.array([np.ptp(b.shape.vertices, axis=0).max() for b in blocks])
    from scipy.spatial import cKDTree

    pairs = cKDTree(centres).query_pairs(WELD * float(extents.max()), output_type="ndarray")
    copies: dict[int, int] = {}
    for i, j in sorted(map(tuple, pairs.tolist())):
        one, other, near = blocks[i], blocks[j], WELD * extents[i]
        if j in copies or i in copies or not _same_shape(one, other, near):
            continue
        if (one.material, one.held) != (other.material, other.held):
            msg = (
                f"{source}: blocks {one.name!r} and {other.name!r} are one body given twice, of different materials or "
                "only once as a support; remove one of them, or exclude it by name"
            )
            raise GeometryFileError(msg)
        copies[j] = i
        repairs.append(Repair(f"{other.name} = {one.name}", "copy", 1))
    return [b for k, b in enumerate(blocks) if k not in copies]


def _same_shape(one: Block, other: Block, near: float) -> bool:
    """Whether two blocks have equal corners and equal volumes."""
    a, b = one.shape.vertices, other.shape.vertices
    if len(a) != len(b) or abs(one.volume - other.volume) > 3 * near / np.ptp(a, axis=0).max() * one.volume:
        return False
    from scipy.spatial import cKDTree

    distance, partner = map(np.asarray, cKDTree(a).query(b))
    return bool(distance.max() <= near and len(np.unique(partner)) == len(a))


def _supported(blocks: list[Block], fixed: Sequence[str], source: str, notes: list[str]) -> list[Block]:
    """Mark supports by name, and on request the lowest blocks and a new block of ground."""
    known = {b.name for b in blocks}
    held: dict[str, set[str]] = {b.name: set(b.held) for b in blocks}
    grounds: list[Block] = []
    for text in fixed:
        name, motions = (text, MOTIONS) if text in known else _split(text)
        keyword, _, rest = name.partition(" ")
        if name in known and keyword == "lowest":
            msg = (
                f"{source}: fixed is {name!r}, which means the lowest blocks and is also the name of a block; rename "
                "this block, give the supports by their names, or give another height, as in 'lowest 3 cm'"
            )
            raise ModelError(msg)
        found = {b for b in known if _pattern(name).fullmatch(b)}
        if keyword == "lowest" and not found:
            found = _lowest(blocks, rest.strip(), source, notes)
        if found:
            for one in found:
                held[one].update(motions)
        elif keyword == "ground" and motions == MOTIONS and "ground" not in known:
            grounds = [ground_under(blocks, rest.strip(), source)]
            notes.append(f"a fixed block 'ground' added, its top at {grounds[0].shape.vertices[:, 2].max():.6g} m")
        else:
            raise UnknownNameError(_no_block(text, "fix", [b.name for b in blocks], source))
    blocks = [attrs.evolve(b, fixed=held[b.name]) for b in blocks]
    notes += [f"held in {', '.join(b.held)} alone: {b.name}" for b in blocks if b.is_roller]
    return [*grounds, *blocks]


def _lowest(blocks: list[Block], height: str, source: str, notes: list[str]) -> set[str]:
    """Return the names of blocks down to a height over the lowest point; note blocks that are only little higher."""
    low = np.array([b.shape.vertices[:, 2].min() for b in blocks])
    low -= low.min()
    size = float(np.mean([b.volume for b in blocks]) ** (1 / 3))
    limit = positive_length(height, f"{source}: height of the lowest blocks") if height else NEAR * size
    nearly = low[(low > limit) & (low <= CLOSE * size)]
    if len(nearly):
        one = len(nearly) == 1
        notes.append(
            f"{counted(len(nearly), 'more block')} reach{'es' * one} down to within {nearly.max():.2g} m of the lowest "
            f"level and {'is' if one else 'are'} free: fix 'lowest {1.06 * nearly.max():.2g} m' makes "
            f"{'it a support' if one else 'them supports'}"
        )
    return {b.name for b, z in zip(blocks, low, strict=True) if z <= limit}


def _no_block(name: str, verb: str, names: Sequence[str], source: str) -> str:
    more = "; or give lowest, ground, or NAME:x,z for some motions" if verb == "fix" else ""
    return f"{source}: no block {name!r} to {verb}; there are {listed(names)}{more}"
