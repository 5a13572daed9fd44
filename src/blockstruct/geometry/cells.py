"""Divide polygons into cells; test for rectangles."""

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array
from blockstruct.errors import GeometryError
from blockstruct.geometry.tolerances import SAME_GRID

#: Centres, areas and widths of cells.
Cells = tuple[Array, Array, Array]

#: Number of directions of the grids, and their numbers of columns relative to a square grid.
_TRIED, _COLUMNS = 2, np.linspace(0.7, 1.3, 7)
#: First trial of the number of rows, relative to the number from the areas.
_MORE = 1.25
#: Number of cells above which the choice of the grid has no effect.
_SEARCHED = 256
#: Directions of bending, ratio of the cells of the reference grid, and mean pressures relative to the strength at
#: which grids are compared with the reference grid.
_ANGLES = np.linspace(0, 2 * np.pi, 48, endpoint=False)
_AROUND = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)])
_FINE = 16
_PRESSURES = np.array([0.001, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5])


def is_rectangle(points: Array) -> bool:
    """Whether a plane polygon, shape (k, 3), has four corners and equal diagonals that bisect each other."""
    if len(points) != 4:
        return False
    first, second = points[2] - points[0], points[3] - points[1]
    limit = NEGLIGIBLE * np.linalg.norm(first)
    apart = np.linalg.norm(points[0] + points[2] - points[1] - points[3])
    return bool(apart <= limit and abs(np.linalg.norm(first) - np.linalg.norm(second)) <= limit)


def polygon_cells(
    points: Array, centroid: Array, normal: Array, count: int, name: str, *, regular: bool = False
) -> tuple[Array, Array]:
    """Return centroids (m, 3) and areas (m,) of about ``count`` cells of a polygon, convex or not.

    The cells lie in the plane through the centroid, even if the polygon is not plane. They are a grid over a rectangle
    around the polygon, cut by its outline. A uniform stress on a cell acts at its centroid, so the limits of the cells
    are on the safe side of the limits of the polygon.

    Rows and columns are thin at the edges and thick inside: projections of equal arcs of a half circle. In bending
    across n rows a rectangle then loses about the share ``(π / 2 n)²`` of its moment, for any position of the neutral
    axis: in the outer row the lever is shorter, in other rows the axis cuts the row. The grid with the smallest loss in
    the worst direction at the worst pressure is chosen, among grids along the longest edges with different numbers of
    columns.

    ``regular`` grids have rows of equal height, as in earlier files.

    Raises
    ------
    GeometryError
        If the outline of the polygon crosses itself.
    """
    return polygon_cells_with_widths(points, centroid, normal, count, name, regular=regular)[:2]


def polygon_cells_with_widths(
    points: Array, centroid: Array, normal: Array, count: int, name: str, *, regular: bool = False
) -> Cells:
    """Return the cells of :func:`polygon_cells`, and matrices W (m, 3, 3) of their widths.

    A cell is ``dᵀ W d`` wide in a direction d along an edge of the grid.
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
    centres, areas, widths = _regular(corners, count) if regular else _graded(corners, count)
    return centroid + centres @ axes, areas, axes.T @ widths @ axes


def _regular(corners: Array, count: int) -> Cells:
    outline = shapely.Polygon(corners)
    x0, y0, x1, y1 = outline.bounds
    columns = max(1, round(np.sqrt(count * (x1 - x0) / (y1 - y0))))
    rows = max(1, round(count / columns))
    return _cut(outline, _boxes(np.linspace(x0, x1, columns + 1), np.linspace(y0, y1, rows + 1)))


def _graded(corners: Array, count: int) -> Cells:
    axis, columns = 0, 1.0
    if count <= _SEARCHED:
        # Congruent joints have the same grid, which is computed once. It must not depend on rounding: a file has the
        # same cells on every machine.
        axis, columns = _best((np.round(corners / np.ptp(corners) / NEGLIGIBLE) * NEGLIGIBLE + 0.0).tobytes(), count)
    axes = _axes(corners, axis + 1)[axis]
    ((_, (centres, areas, widths)),) = _grids(corners @ axes.T, count, np.array([columns]))
    return centres @ axes, areas, axes.T @ widths @ axes


@lru_cache(maxsize=4096)
def _best(buffer: bytes, count: int) -> tuple[int, float]:
    """Return axes and columns of the grid with the smallest loss; the buffer holds the corners (k, 2)."""
    corners = np.frombuffer(buffer).reshape(-1, 2)
    grids = [
        (axis, columns, centres @ axes, areas)
        for axis, axes in enumerate(_axes(corners, _TRIED))
        for columns, (centres, areas, _) in _grids(corners @ axes.T, count, _COLUMNS)
    ]
    ((_, (centres, areas, _)),) = _grids(corners, _FINE * count, np.ones(1))
    along, _ = _edges(corners)
    across = np.stack([along[:, 1], -along[:, 0]])
    directions = np.concatenate([across, -across, _AROUND], axis=1)
    exact = np.maximum(_moments(centres, areas, directions), np.finfo(float).tiny)
    moments = (_moments(centres, areas, directions) for _, _, centres, areas in grids)
    worst = np.array([(1 - m / exact).max() for m in moments])
    axis, columns, *_ = grids[int(np.argmax(worst <= worst.min() + NEGLIGIBLE))]
    return axis, columns


def _axes(corners: Array, most: int) -> list[Array]:
    """Return axes (2, 2) along the longest edges; perpendicular edges share their axes."""
    along, lengths = _edges(corners)
    frames = list[Array]()
    for s in along[np.argsort(-_rounded(lengths), kind="stable")]:
        if all(np.abs(axes @ s).min() > SAME_GRID for axes in frames):
            frames.append(np.array([s, [-s[1], s[0]]]))
    return frames[:most]


def _edges(corners: Array) -> tuple[Array, Array]:
    """Return unit vectors along the edges, and their lengths."""
    edges = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(edges, axis=1)
    return edges[lengths > 0] / lengths[lengths > 0, None], lengths[lengths > 0]


def _grids(corners: Array, count: int, shares: Array) -> Iterator[tuple[float, Cells]]:
    """Yield graded grids of about ``count`` cells, by the number of columns relative to a square grid."""
    outline = shapely.Polygon(corners)
    shapely.prepare(outline)
    low, high = np.reshape(outline.bounds, (2, 2))
    touching = ROUNDING * float(np.min(high - low))

    def fitting(rows: int, columns: int | None = None) -> tuple[int, NDArray[np.object_]]:
        """Return the largest number of rows within ``count`` cells; by default with as many columns."""
        while True:
            shape = columns or rows, rows
            x, y = (a + (b - a) * _arcs(m) for a, b, m in zip(low, high, shape, strict=True))
            within = shapely.intersects(outline, _boxes(x, y, inset=touching))
            number = int(within.sum())
            if number <= count:
                return rows, _boxes(x, y)[within]
            fewer = (count / number) ** (1.0 if columns else 0.5)
            rows = min(rows - 1, _upwards(rows * fewer))

    # Boxes outside the outline do not count, so there are more rows than the areas give.
    square, _ = fitting(_upwards(_MORE * math.sqrt(count * np.prod(high - low) / outline.area)))
    numbers, first = np.unique(np.maximum(np.round(shares * square), 1).astype(int), return_index=True)
    for columns, share in zip(numbers.tolist(), shares[first].tolist(), strict=True):
        rows, boxes = fitting(_upwards(_MORE * square**2 / columns), columns)
        if rows:
            yield share, _cut(outline, boxes)


def _arcs(n: int) -> Array:
    """Return the ends of n equal arcs of a half circle, projected on its diameter from 0 to 1."""
    return np.asarray((1 - np.cos(np.linspace(0, np.pi, n + 1))) / 2)


def _rounded(lengths: Array) -> Array:
    return np.asarray(np.round(lengths / lengths.max() / NEGLIGIBLE))


def _upwards(number: float) -> int:
    return math.ceil(number - NEGLIGIBLE)


def _boxes(x: Array, y: Array, inset: float = 0.0) -> NDArray[np.object_]:
    left, low = (a.ravel() + inset for a in np.meshgrid(x[:-1], y[:-1]))
    right, high = (a.ravel() - inset for a in np.meshgrid(x[1:], y[1:]))
    return np.asarray(shapely.box(left, low, right, high))


def _cut(outline: shapely.Polygon, boxes: NDArray[np.object_]) -> Cells:
    parts = shapely.get_parts(shapely.intersection(boxes, outline))
    areas = shapely.area(parts)
    keep = areas > ROUNDING * outline.area
    x0, y0, x1, y1 = shapely.bounds(parts[keep]).T
    widths = np.eye(2) * np.column_stack([x1 - x0, y1 - y0])[:, None]
    return shapely.get_coordinates(shapely.centroid(parts[keep])), areas[keep], widths


def _moments(centres: Array, areas: Array, directions: Array) -> Array:
    """Return the largest moments of cells for each mean pressure and each direction of bending."""
    arms = centres @ directions
    order = np.argsort(-arms, axis=0)
    pressed = areas[order]
    before = np.cumsum(pressed, axis=0) - pressed
    N = (_PRESSURES * areas.sum())[:, None, None]
    return np.asarray((np.clip(N - before, 0, pressed) * np.take_along_axis(arms, order, 0)).sum(axis=1))
