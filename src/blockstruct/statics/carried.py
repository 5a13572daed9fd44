"""Compute the weights that a load pattern puts on blocks."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from blockstruct.arrays import SLIGHT, Array, Index
from blockstruct.errors import ModelError, UnknownNameError
from blockstruct.geometry.plan import PlanFaces, products
from blockstruct.model import AreaLoad, Block, FillLoad, LineLoad, LoadPattern, Model, Weight
from blockstruct.units import to_quantity
from blockstruct.vocabulary import listed

#: Share of a line or rectangle that may lie over no block, such as over joints; the other blocks carry this share.
_LACKING = 0.01


@dataclass(frozen=True, slots=True)
class CarriedWeights:
    """Weights on blocks, one entry per weight.

    Attributes
    ----------
    load : (n,) array
        Index of the load in its pattern.
    block : (n,) array
        Index of the block.
    point : (n, 3) array, m
        Centre of mass; the weight acts along −z through it.
    weight : (n,) array, N
    pushed : (n,) array, N
        Part of the weight whose mass a mass-proportional load pushes.
    lateral : (n, 3) array, N
        Horizontal force of fill in addition to the weight; it acts at ``lateral_point``.
    lateral_point : (n, 3) array, m
    """

    load: Index
    block: Index
    point: Array
    weight: Array
    pushed: Array
    lateral: Array
    lateral_point: Array

    def __len__(self) -> int:
        return len(self.load)


@dataclass(frozen=True)
class Placing:
    """Places the loads of a pattern on blocks, with cached lookups."""

    model: Model
    pattern: str

    @cached_property
    def index(self) -> dict[str, int]:
        """Index of each block by name."""
        return {b.name: i for i, b in enumerate(self.model.blocks)}

    @cached_property
    def upper(self) -> PlanFaces:
        """All upward faces."""
        return PlanFaces.of([b.shape for b in self.model.blocks], 1.0)

    @cached_property
    def lower(self) -> PlanFaces:
        """All downward faces."""
        return PlanFaces.of([b.shape for b in self.model.blocks], -1.0)

    @cached_property
    def tolerance(self) -> float:
        """Difference up to which two heights count as equal, m."""
        return SLIGHT * self.model.characteristic_length

    def at(self, load: Any) -> int:
        """Return the index of the block of a load.

        Raises
        ------
        UnknownNameError
            If the model does not have this block.
        ModelError
            If the load has no name of a block, and no block is at its point.
        """
        if load.block is None:
            try:
                return self.index[self.model.block_at(to_quantity(load.point, "length")).name]
            except ModelError as error:
                error.add_note(f"in load pattern {self.pattern!r}: {type(load).__name__}")
                raise
        if load.block not in self.index:
            msg = (
                f"load pattern {self.pattern!r}: {type(load).__name__} on block {load.block!r}, which model "
                f"{self.model.name!r} does not have; it has {listed(list(self.index))}"
            )
            raise UnknownNameError(msg)
        return self.index[load.block]

    def refusal(self, load: Any, problem: str) -> ModelError:
        """Return an error that names the pattern and the load."""
        on = f" on block {load.block!r}" if load.block is not None else ""
        return ModelError(f"load pattern {self.pattern!r}: {type(load).__name__}{on} {problem}")

    def check_extent(self, load: Any, points: Array, axes: int, problem: str) -> None:
        """Refuse points (…, 3) outside the extent of a block.

        With two axes, x and y are checked; with three, also z.
        """
        block: Block = self.model.blocks[self.at(load)]
        low, high = block.shape.vertices.min(axis=0), block.shape.vertices.max(axis=0)
        slack = 1e-3 * (high - low).max()
        out = (points < low - slack) | (points > high + slack)
        if np.any(out[..., :axes]):
            reach = f"from {low.round(6).tolist()} to {high.round(6).tolist()} m"
            raise self.refusal(load, problem.format(reach=reach))


_Placed = tuple[Index, Array, Array, Array, Array]


def carried_weights(model: Model, pattern: LoadPattern) -> CarriedWeights:
    """Return the weights that a load pattern puts on the blocks of a model.

    The weights of a load add up to the total weight of its line, area or fill.

    Raises
    ------
    UnknownNameError
        If a load acts on a block that the model does not have.
    ModelError
        If a load is not on its block. If a line or rectangle lies over no block, or only partly over blocks and does
        not span. If fill lies above no face.
    """
    placing, parts = Placing(model, pattern.name), []
    for k, load in enumerate(pattern.loads):
        place: Callable[[Placing, Any], _Placed] | None = _PLACES.get(type(load))
        if place is not None:
            block, point, weight, lateral, lateral_point = place(placing, load)
            share: float = load.mass_share  # type: ignore[union-attr]
            parts.append((np.full(len(block), k), block, point, weight, share * weight, lateral, lateral_point))
    empty = np.empty(0, dtype=np.int64), np.empty((0, 3)), np.empty(0)
    columns = zip(*parts, (empty[0], empty[0], empty[1], empty[2], empty[2], empty[1], empty[1]), strict=True)
    return CarriedWeights(*(np.concatenate(column) for column in columns))


def _concentrated(placing: Placing, load: Weight) -> _Placed:
    point = np.array([load.point])
    problem = (
        f"has its centre of mass at {load.point} m, in plan outside the block, which reaches {{reach}}; correct the "
        "point, or model what it hangs on as a block"
    )
    placing.check_extent(load, point, 2, problem)
    return _plain([placing.at(load)], point, np.array([load.weight]))


def _along_line(placing: Placing, load: LineLoad) -> _Placed:
    ends = np.array([load.start, load.end])
    total = load.weight_per_length * float(np.linalg.norm(ends[1] - ends[0]))
    if load.block is not None:
        placing.check_extent(load, ends, 3, "leaves the block, which reaches {reach}; correct its start or end")
        return _plain([placing.at(load)], ends.mean(axis=0)[None], np.array([total]))
    faces = _level_faces(placing, float(ends[0, 2]))
    span = ends[1, :2] - ends[0, :2]
    reach = float(np.linalg.norm(span))
    # Rounding may shift a line along an edge off the block: search for carrying faces on both sides of the line.
    aside = placing.tolerance / reach * np.array([-span[1], span[0]])
    sides = [_stretches(ends[:, :2] + shift, faces) for shift in (aside, -aside)]
    cuts = np.unique(np.concatenate([[0.0, reach], *(along.ravel() for _, along in sides)]))
    middle, width = (cuts[1:] + cuts[:-1]) / 2, np.diff(cuts)
    over = np.zeros((2, len(faces), len(width)), dtype=bool)
    for on, (face, along) in zip(over, sides, strict=True):
        np.logical_or.at(on, face, (along[:, :1] < middle) & (middle < along[:, 1:]))
    carriers = over.sum(axis=1)
    bearing = (carriers > 0).sum(axis=0)
    share = (over / np.maximum(carriers, 1)[:, None]).sum(axis=0) * width / np.maximum(bearing, 1)
    borne = float(width[bearing > 0].sum())
    _check_cover(placing, load, borne / reach, f"{reach:.6g} m", f"z = {ends[0, 2]:.6g} m")
    length = share.sum(axis=1)
    some = length > 1e-9 * reach
    centre = (share @ middle)[some] / length[some]
    point = ends[0] + (centre / reach)[:, None] * (ends[1] - ends[0])
    return _plain(faces.body[some], point, total * length[some] / length[some].sum())


def _over_area(placing: Placing, load: AreaLoad) -> _Placed:
    if load.start is None or load.end is None:
        own = placing.upper[placing.upper.body == placing.at(load)]
        faces = own.without(placing.lower, 10 * placing.tolerance, reach=10 * placing.tolerance)
        if not len(faces):
            raise placing.refusal(load, "finds no upper face that touches no other block; give start and end")
        area = shapely.area(faces.outline)
        return _plain(faces.body, _centres(faces), load.weight_per_area * area)
    level = load.start[2]
    region = shapely.box(*np.minimum(load.start, load.end)[:2], *np.maximum(load.start, load.end)[:2])
    faces = _level_faces(placing, level).within(region)
    if load.block is not None:
        faces = faces[faces.body == placing.at(load)]
    area = shapely.area(faces.outline)
    _check_cover(placing, load, float(area.sum() / region.area), f"{region.area:.6g} m²", f"z = {level:.6g} m")
    return _plain(faces.body, _centres(faces), load.weight_per_area * region.area * area / area.sum())


def _fill(placing: Placing, load: FillLoad) -> _Placed:
    (low, high), level = sorted((load.start[2], load.end[2])), load.level
    region = shapely.box(*np.minimum(load.start, load.end)[:2], *np.maximum(load.start, load.end)[:2])
    shapes = [b.shape for b in placing.model.blocks]
    upper = PlanFaces.of(shapes, 1.0, low, high).within(region)
    if load.block is not None:
        upper = upper[upper.body == placing.at(load)]
    faces = upper.without(PlanFaces.of(shapes, -1.0, high=high).within(region), 10 * placing.tolerance)
    if not len(faces):
        where = f"from ({load.start[0]:.6g}, {load.start[1]:.6g}, {load.start[2]:.6g}) m to "
        where += f"({load.end[0]:.6g}, {load.end[1]:.6g}, {load.end[2]:.6g}) m"
        raise placing.refusal(load, f"finds no face below it that looks up into the box {where}; correct start and end")
    corners, owner = faces.triangles()
    part = faces[owner]
    z = part.z(corners)
    h = level - z
    side = corners[:, 1:] - corners[:, :1]
    area = np.abs(side[:, 0, 0] * side[:, 1, 1] - side[:, 0, 1] * side[:, 1, 0]) / 2

    def integral(f: Array, g: Array) -> Array:
        return np.asarray(np.bincount(owner, products(area, f, g), minlength=len(faces)), dtype=float)

    volume, square = integral(h, np.ones_like(h)), integral(h, h)
    x, y = (integral(h, corners[..., k]) / volume for k in range(2))
    point = np.column_stack([x, y, level - square / volume / 2])
    on_face = np.column_stack([x, y, level - square / volume])
    # The slopes of the plane z(x, y) are −n_x/n_z and −n_y/n_z. The pressure acts against the outward normal.
    sideways = np.column_stack([faces.height[:, 1:], np.zeros(len(faces))])
    lateral = load.lateral_coefficient * load.unit_weight * volume[:, None] * sideways
    return faces.body, point, load.unit_weight * volume, lateral, on_face


_PLACES: dict[type, Callable[[Placing, Any], _Placed]] = {
    Weight: _concentrated,
    LineLoad: _along_line,
    AreaLoad: _over_area,
    FillLoad: _fill,
}


def _plain(block: Any, point: Array, weight: Array) -> _Placed:
    return np.asarray(block, dtype=np.int64), point, weight, np.zeros_like(point), point


def _level_faces(placing: Placing, level: float) -> PlanFaces:
    upper = placing.upper
    flat = np.linalg.norm(upper.height[:, 1:], axis=1) < SLIGHT
    return upper[flat & (np.abs(_centres(upper)[:, 2] - level) < placing.tolerance)]


def _centres(faces: PlanFaces) -> Array:
    xy = shapely.get_coordinates(shapely.centroid(faces.outline)).reshape(-1, 2)
    return np.column_stack([xy, faces.z(xy)])


def _stretches(ends: Array, faces: PlanFaces) -> tuple[Index, Array]:
    """Return the stretches of a line (2, 2) in plan that lie over faces.

    Each stretch has the index of its face, and two distances (n, 2) from the start of the line.
    """
    line = shapely.LineString(ends)
    parts, face = shapely.get_parts(shapely.intersection(line, faces.outline), return_index=True)
    # The intersection is an empty line with a face that the line misses, and a point with a face that it only touches.
    lines = shapely.length(parts) > 0
    corners = np.stack([shapely.get_coordinates(shapely.get_point(parts[lines], k)) for k in (0, -1)], axis=1)
    along = shapely.line_locate_point(line, shapely.points(corners.reshape(-1, 2))).reshape(-1, 2)
    return face[lines], np.sort(along, axis=1)


def _check_cover(placing: Placing, load: LineLoad | AreaLoad, part: float, size: str, where: str) -> None:
    if part <= 0:
        raise placing.refusal(load, f"lies over no upper face of a block at {where}; correct its level or its place")
    if part < 1 - _LACKING and not load.spanning:
        raise placing.refusal(
            load,
            f"has blocks below {part:.1%} of its {size} at {where}, and would lose the rest; give spanning=True if "
            "they bear all of it, or correct its ends",
        )
