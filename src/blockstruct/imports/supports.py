"""Supports as people draw them: a face that blocks stand on, and level ground."""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from blockstruct.errors import GeometryFileError
from blockstruct.geometry import lofted, plane_axes
from blockstruct.geometry.planes import Planes
from blockstruct.imports.tolerances import LOWEST
from blockstruct.model import Block
from blockstruct.units import si, to_quantity

Array = NDArray[np.float64]


def block_behind(face: Array, bodies: Sequence[Array]) -> tuple[Array, list[tuple[int, ...]]]:
    """Return vertices and faces of the block behind a face, on the side away from the body nearest to the face.

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
    if low[2] < top - LOWEST * size:
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
