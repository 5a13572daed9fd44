"""Blocks extruded along y from a plane outline, and blocks between two level polygons."""

import numpy as np
from numpy.typing import ArrayLike

from blockstruct.arrays import Array
from blockstruct.geometry.polyhedron import Loops, lofted, polyhedron
from blockstruct.model import Block, Material


def block(name: str, body: tuple[Array, Loops], material: Material, *, fixed: bool | tuple[str, ...] = False) -> Block:
    """Return the block with vertices, m, and outward faces."""
    return Block(name, polyhedron(*body, name), material, fixed)


def prism(name: str, outline: ArrayLike, y: tuple[float, float], material: Material, *, fixed: bool = False) -> Block:
    """Return the block with an outline in the x–z plane, between two values of y.

    Parameters
    ----------
    name
        Unique in the model.
    outline : (k, 2) array
        Corners (x, z) in either order of rotation, m.
    y
        Smallest and largest y, m.
    material
        Material of the block.
    fixed
        Whether the block is a support.
    """
    corners = np.asarray(outline, dtype=float)
    x, z = corners.T
    # Counter-clockwise seen from −y, where x points right and z up.
    if np.sum(x * np.roll(z, -1) - z * np.roll(x, -1)) < 0:
        corners = corners[::-1]
    return block(name, lofted(*(np.insert(corners, 1, end, axis=1) for end in y)), material, fixed=fixed)


def prismatoid(name: str, points: Array, material: Material, *, fixed: bool = False) -> Block:
    """Return the block between two level polygons (2 k, 3) of k corners, the lower first, both counter-clockwise."""
    return block(name, lofted(*np.split(points, 2)), material, fixed=fixed)
