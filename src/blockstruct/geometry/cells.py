"""Subdivision of polygons into cells, and the test for rectangles."""

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.errors import GeometryError
from blockstruct.geometry.tolerances import NO_CELL, RECTANGLE, SAME_GRID

Array = NDArray[np.float64]
Cells = tuple[Array, Array]

#: Directions of edges that grids lie along, and numbers of columns in multiples of those of a square grid.
_TRIED, _COLUMNS = 2, np.linspace(0.7, 1.3, 7)
#: Rows that are tried first, in multiples of those that areas tell.
_MORE = 1.25
#: Number of cells beyond which one grid is as good as another.
_SEARCHED = 256
#: Directions of bending, and mean pressures in multiples of the strength, at which grids are compared with one of so
#: many times as many cells.
_ANGLES = np.linspace(0, 2 * np.pi, 48, endpoint=False)
_AROUND = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)])
_FINE = 16
_PRESSURES = np.array([0.001, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5])
#: Difference of losses, of lengths of edges and of numbers of rows that is rounding. Which grid is taken must not
#: depend on it: on another machine the cells would not be those of a file.
_SAME = 1e-6
#: Decimals of corners, in multiples of the extent, by which outlines are the same.
_DIGITS = 6


def is_rectangle(points: Array) -> bool:
    """Whether a plane polygon, shape (k, 3), has four corners whose diagonals halve each other and are equally long."""
    if len(points) != 4:
        return False
    first, second = points[2] - points[0], points[3] - points[1]
    limit = RECTANGLE * np.linalg.norm(first)
    apart = np.linalg.norm(points[0] + points[2] - points[1] - points[3])
    return bool(apart <= limit and abs(np.linalg.norm(first) - np.linalg.norm(second)) <= limit)


def polygon_cells(
    points: Array, centroid: Array, normal: Array, count: int, name: str, *, regular: bool = False
) -> Cells:
    """Centroids (m, 3) and areas (m,) of about ``count`` cells of a polygon, convex or not.

    The cells lie in the plane through the centroid, even if the polygon is not plane: a grid over a rectangle around
    the polygon, cut by its outline. A uniform stress on a cell acts at its centroid, so limits of the cells are never
    less safe than those of the polygon.

    Rows and columns are thin at the edges and thick inside, the projections of equal arcs of a half circle. In bending
    across n rows a rectangle then loses about the same share of its moment, ``(π / 2 n)²``, wherever the neutral axis
    is: in the outer row of its lever, in the others by the row that the axis cuts. Of grids along the longest edges,
    with different numbers of columns, the one is taken that loses least in the worst direction at the worst pressure.

    ``regular`` grids have rows of equal height, as all grids of earlier files.

    Raises
    ------
    GeometryError
        If the outline of the polygon crosses itself.
    """
    arms = points - centroid
    arms = arms - np.outer(arms @ normal, normal)
    edges = np.roll(arms, -1, axis=0) - arms
    lengths = np.linalg.norm(edges, axis=1)
    longest = np.argmax(lengths if regular else _rounded(lengths))
    s = edges[longest] / lengths[longest]
    axes = np.stack([s, np.cross(normal, s)])
    corners = arms @ axes.T
    if not shapely.Polygon(corners).is_valid:
        msg = f"interface {name!r}: the outline crosses itself and cannot be divided into cells; correct its corners"
        raise GeometryError(msg)
    centres, areas = _regular(corners, count) if regular else _graded(corners, count)
    return centroid + centres @ axes, areas


def _regular(corners: Array, count: int) -> Cells:
    outline = shapely.Polygon(corners)
    x0, y0, x1, y1 = outline.bounds
    columns = max(1, round(np.sqrt(count * (x1 - x0) / (y1 - y0))))
    rows = max(1, round(count / columns))
    return _cut(outline, _boxes(np.linspace(x0, x1, columns + 1), np.linspace(y0, y1, rows + 1)))


def _graded(corners: Array, count: int) -> Cells:
    axis, columns = 0, 1.0
    if count <= _SEARCHED:
        # Congruent joints have the same grid, found once.
        axis, columns = _best((np.round(corners / np.ptp(corners), _DIGITS) + 0.0).tobytes(), count)
    axes = _axes(corners, axis + 1)[axis]
    ((_, (centres, areas)),) = _grids(corners @ axes.T, count, np.array([columns]))
    return centres @ axes, areas


@lru_cache(maxsize=4096)
def _best(buffer: bytes, count: int) -> tuple[int, float]:
    """Axes and columns of the grid that loses least, of an outline whose corners, shape (k, 2), are in a buffer."""
    corners = np.frombuffer(buffer).reshape(-1, 2)
    grids = [
        (axis, columns, centres @ axes, areas)
        for axis, axes in enumerate(_axes(corners, _TRIED))
        for columns, (centres, areas) in _grids(corners @ axes.T, count, _COLUMNS)
    ]
    ((_, (centres, areas)),) = _grids(corners, _FINE * count, np.ones(1))
    along, _ = _edges(corners)
    across = np.stack([along[:, 1], -along[:, 0]])
    directions = np.concatenate([across, -across, _AROUND], axis=1)
    exact = np.maximum(_moments(centres, areas, directions), np.finfo(float).tiny)
    found = (_moments(centres, areas, directions) for _, _, centres, areas in grids)
    worst = np.array([(1 - moments / exact).max() for moments in found])
    axis, columns, *_ = grids[int(np.argmax(worst <= worst.min() + _SAME))]
    return axis, columns


def _axes(corners: Array, most: int) -> list[Array]:
    """Axes along the longest edges, shape (2, 2) each; of edges at right angles to each other only once."""
    along, lengths = _edges(corners)
    found = list[Array]()
    for s in along[np.argsort(-_rounded(lengths), kind="stable")]:
        if all(np.abs(axes @ s).min() > SAME_GRID for axes in found):
            found.append(np.array([s, [-s[1], s[0]]]))
    return found[:most]


def _edges(corners: Array) -> tuple[Array, Array]:
    """Unit vectors along the edges, and lengths."""
    edges = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(edges, axis=1)
    return edges[lengths > 0] / lengths[lengths > 0, None], lengths[lengths > 0]


def _grids(corners: Array, count: int, shares: Array) -> Iterator[tuple[float, Cells]]:
    """Graded grids of about ``count`` cells, of columns in multiples of those of a square grid, and rows to match."""
    outline = shapely.Polygon(corners)
    shapely.prepare(outline)
    low, high = np.reshape(outline.bounds, (2, 2))
    touching = NO_CELL * float(np.min(high - low))

    def fitting(rows: int, columns: int | None = None) -> tuple[int, NDArray[np.object_]]:
        """As many rows, up to a number, as ``count`` allows; as many columns, if they are not given."""
        while True:
            shape = columns or rows, rows
            x, y = (a + (b - a) * _arcs(m) for a, b, m in zip(low, high, shape, strict=True))
            within = shapely.intersects(outline, _boxes(x, y, inset=touching))
            number = int(within.sum())
            if number <= count:
                return rows, _boxes(x, y)[within]
            fewer = (count / number) ** (1.0 if columns else 0.5)
            rows = min(rows - 1, _upwards(rows * fewer))

    # Boxes beyond the outline are none, so there are more rows than by the areas alone.
    square, _ = fitting(_upwards(_MORE * math.sqrt(count * np.prod(high - low) / outline.area)))
    numbers, first = np.unique(np.maximum(np.round(shares * square), 1).astype(int), return_index=True)
    for columns, share in zip(numbers.tolist(), shares[first].tolist(), strict=True):
        rows, boxes = fitting(_upwards(_MORE * square**2 / columns), columns)
        if rows:
            yield share, _cut(outline, boxes)


def _arcs(n: int) -> Array:
    """Ends of n equal arcs of a half circle, on its diameter from 0 to 1."""
    return np.asarray((1 - np.cos(np.linspace(0, np.pi, n + 1))) / 2)


def _rounded(lengths: Array) -> Array:
    return np.asarray(np.round(lengths / lengths.max() / _SAME))


def _upwards(number: float) -> int:
    return math.ceil(number - _SAME)


def _boxes(x: Array, y: Array, inset: float = 0.0) -> NDArray[np.object_]:
    left, low = (a.ravel() + inset for a in np.meshgrid(x[:-1], y[:-1]))
    right, high = (a.ravel() - inset for a in np.meshgrid(x[1:], y[1:]))
    return np.asarray(shapely.box(left, low, right, high))


def _cut(outline: shapely.Polygon, boxes: NDArray[np.object_]) -> Cells:
    parts = shapely.get_parts(shapely.intersection(boxes, outline))
    areas = shapely.area(parts)
    keep = areas > NO_CELL * outline.area
    return shapely.get_coordinates(shapely.centroid(parts[keep])), areas[keep]


def _moments(centres: Array, areas: Array, directions: Array) -> Array:
    """Largest moments that cells bear with each mean pressure in each direction of bending."""
    arms = centres @ directions
    order = np.argsort(-arms, axis=0)
    pressed = areas[order]
    before = np.cumsum(pressed, axis=0) - pressed
    N = (_PRESSURES * areas.sum())[:, None, None]
    return np.asarray((np.clip(N - before, 0, pressed) * np.take_along_axis(arms, order, 0)).sum(axis=1))
