"""Closed outlines in a drawing plane, and the prisms over them."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Face = tuple[int, ...]


def divided_arcs(points: Array, bulges: Array, segments: int) -> tuple[Array, float]:
    """Corners of a closed outline whose arcs are divided into straight segments, and the largest rise over one.

    Parameters
    ----------
    points : (n, 2) array
    bulges : (n,) array
        Tangent of a quarter of the angle of the arc from each corner to the next, counter-clockwise if positive;
        zero where the outline is straight.
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
    """Vertices (2n, 3) and outward faces of the prism over an outline (n, 2) at a level over the drawing plane.

    Standing, x and y of the drawing become x and z, and the prism reaches along +y; otherwise it rises along +z.
    """
    x, y = points.T
    if np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) < 0:
        points = points[::-1]
    n = len(points)
    x, y = np.tile(points, (2, 1)).T
    # The drawing's own z looks at the reader: standing up, it points to -y.
    z = level + np.repeat([-thickness, 0.0] if standing else [0.0, thickness], n)
    sides = [(i, (i + 1) % n, (i + 1) % n + n, i + n) for i in range(n)]
    faces = [tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides]
    return np.column_stack([x, -z, y] if standing else [x, y, z]), faces
