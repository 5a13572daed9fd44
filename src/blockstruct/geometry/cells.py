"""Subdivision of polygons into cells, and the test for rectangles."""

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.errors import GeometryError
from blockstruct.geometry.tolerances import NO_CELL, RECTANGLE

Array = NDArray[np.float64]


def is_rectangle(points: Array) -> bool:
    """Whether a plane polygon, shape (k, 3), has four corners whose diagonals halve each other and are equally long."""
    if len(points) != 4:
        return False
    first, second = points[2] - points[0], points[3] - points[1]
    limit = RECTANGLE * np.linalg.norm(first)
    apart = np.linalg.norm(points[0] + points[2] - points[1] - points[3])
    return bool(apart <= limit and abs(np.linalg.norm(first) - np.linalg.norm(second)) <= limit)


def polygon_cells(points: Array, centroid: Array, normal: Array, count: int, name: str) -> tuple[Array, Array]:
    """Centroids (m, 3) and areas (m,) of about ``count`` cells of a polygon, convex or not.

    The cells lie in the plane through the centroid, even if the polygon is not plane: a regular grid over the smallest
    rectangle around the polygon, cut by its outline. A uniform stress on a cell acts at its centroid, so limits of the
    cells are never less safe than those of the polygon.

    Raises
    ------
    GeometryError
        If the outline of the polygon crosses itself.
    """
    arms = points - centroid
    arms = arms - np.outer(arms @ normal, normal)
    edges = np.roll(arms, -1, axis=0) - arms
    lengths = np.linalg.norm(edges, axis=1)
    s = edges[np.argmax(lengths)] / lengths.max()
    axes = np.stack([s, np.cross(normal, s)])
    outline = shapely.Polygon(arms @ axes.T)
    if not outline.is_valid:
        msg = f"interface {name!r}: the outline crosses itself and cannot be divided into cells; correct its corners"
        raise GeometryError(msg)
    x0, y0, x1, y1 = outline.bounds
    columns = max(1, round(np.sqrt(count * (x1 - x0) / (y1 - y0))))
    rows = max(1, round(count / columns))
    x, y = np.linspace(x0, x1, columns + 1), np.linspace(y0, y1, rows + 1)
    left, low = (a.ravel() for a in np.meshgrid(x[:-1], y[:-1]))
    right, high = (a.ravel() for a in np.meshgrid(x[1:], y[1:]))
    parts = shapely.get_parts(shapely.intersection(shapely.box(left, low, right, high), outline))
    areas = shapely.area(parts)
    keep = areas > NO_CELL * outline.area
    centres = shapely.get_coordinates(shapely.centroid(parts[keep]))
    return centroid + centres @ axes, areas[keep]
