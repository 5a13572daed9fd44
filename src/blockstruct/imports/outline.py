"""Closed outlines in a drawing plane, and the prisms over them."""

from dataclasses import dataclass

import numpy as np
import shapely

from blockstruct.arrays import Array
from blockstruct.geometry.polyhedron import lofted
from blockstruct.geometry.tolerances import NEGLIGIBLE

Face = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Outline:
    """A closed outline of a drawing, and its repairs.

    Attributes
    ----------
    corners : (n, 2) array
    rise : float
        Largest rise of an arc over its straight segments.
    gap : float
        Distance of the joined ends.
    retraced : int
        Number of dropped corners, where the outline turns back on itself or repeats.
    """

    corners: Array
    rise: float
    gap: float
    retraced: int


def read_outline(
    points: Array, bulges: Array, segments: int, *, closed: bool, tolerance: float | None
) -> Outline | float:
    """Return the outline of a polyline, or the distance of its ends if it is open.

    A polyline is closed if it is marked as closed, if its ends meet, or if its existing edges cover the gap. Edges
    drawn forth and back are dropped, and repeated rounds after the first.

    Parameters
    ----------
    points : (n, 2) array
    bulges : (n,) array
        As for :func:`divided_arcs`.
    segments
        Number of segments of each arc.
    closed
        Whether the polyline is marked as closed.
    tolerance
        Largest distance of ends that meet; by default a millionth of the size of the polyline.
    """
    size = float(np.ptp(points, axis=0).max())
    gap = float(np.linalg.norm(points[-1] - points[0]))
    # In a polyline marked as closed, close ends are separate corners.
    meets = len(points) > 2 and gap <= (NEGLIGIBLE * size if closed or tolerance is None else tolerance)
    if meets:
        points, bulges = points[:-1], bulges[:-1]
    ring = closed or meets
    bulges = bulges if ring else np.append(bulges[:-1], 0.0)
    path, rise = divided_arcs(points, bulges, segments)
    corners, retraced = _once(path, NEGLIGIBLE * size)
    if not ring:
        # The polyline is closed only if it repeats edges and the outline covers all edges.
        around = shapely.buffer(shapely.linearrings(corners), 2 * NEGLIGIBLE * size) if len(corners) > 2 else None
        if not retraced or not shapely.covers(around, shapely.linestrings(path)):
            return gap
    return Outline(corners, rise, gap if meets else 0.0, retraced)


def _once(ring: Array, rounding: float) -> tuple[Array, int]:
    """Drop edges that run back over the previous edge, and repeated rounds; return corners and number dropped."""
    points = ring @ [1, 1j]
    points = points[np.abs(np.roll(points, -1) - points) > rounding]
    n = len(points)
    turns = (k for k in range(3, n // 2 + 1) if n % k == 0 and np.all(np.abs(points - np.roll(points, k)) <= rounding))
    corners = points[: next(turns, n)].tolist()
    k, steady = 0, 0
    while len(corners) > 2 and steady < len(corners):
        k %= len(corners)
        a, b, c = corners[k - 1], corners[k], corners[(k + 1) % len(corners)]
        if _turns_back(b - a, c - b, rounding):
            del corners[k]
            if abs(c - a) <= rounding:
                del corners[k % len(corners)]
            k, steady = max(k - 2, 0), 0
        else:
            k, steady = k + 1, steady + 1
    kept = np.array(corners)
    return np.column_stack([kept.real, kept.imag]), n - len(corners)


def _turns_back(there: complex, back: complex, rounding: float) -> bool:
    """Whether two successive edges overlap: they lie on one line in opposite directions."""
    product = there.conjugate() * back
    return product.real < 0 and abs(product.imag) <= rounding * max(abs(there), abs(back))


def divided_arcs(points: Array, bulges: Array, segments: int) -> tuple[Array, float]:
    """Divide the arcs of a closed outline into straight segments; return corners and the largest rise over one.

    Parameters
    ----------
    points : (n, 2) array
    bulges : (n,) array
        Tangent of a quarter of the angle of the arc from each corner to the next, counter-clockwise if positive;
        zero for a straight edge.
    segments
        Number of segments of each arc.
    """
    start = points @ [1, 1j]
    chord = np.roll(start, -1) - start
    pieces, rise = [], 0.0
    for p, c, b in zip(start, chord, bulges, strict=True):
        if b == 0:
            pieces.append(np.array([p]))
            continue
        centre = p + c / 2 + 1j * c * (1 - b * b) / (4 * b)
        turn = 4 * np.arctan(b) / segments
        pieces.append(centre + (p - centre) * np.exp(1j * turn * np.arange(segments)))
        rise = max(rise, float(abs(p - centre) * (1 - np.cos(turn / 2))))
    corners = np.concatenate(pieces)
    return np.column_stack([corners.real, corners.imag]), rise


def prism(points: Array, level: float, thickness: float, *, standing: bool) -> tuple[Array, list[Face]]:
    """Return vertices (2n, 3) and outward faces of the prism over an outline (n, 2), from a level by a thickness.

    The thickness may be negative. If ``standing``, x, y and z of the drawing become x, z and y.
    """
    low, high = sorted((level, level + thickness))
    # In a standing drawing z points into the page, which reverses the outlines.
    levels = (high, low) if standing else (low, high)
    vertices, faces = lofted(*(np.insert(points, 1 if standing else 2, z, axis=1) for z in levels))
    return vertices, list(faces)


def enclosed(points: Array) -> float:
    """Return the enclosed area of an outline (n, 2); if it crosses itself, the total area of its loops."""
    outline = shapely.polygons(points)
    return max(float(outline.area), float(shapely.make_valid(outline).area))
