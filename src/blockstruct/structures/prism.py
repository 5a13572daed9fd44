"""Blocks extruded along y from a plane outline, and blocks between two level polygons."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from blockstruct.geometry import lofted, polyhedron
from blockstruct.model import Block, Material


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
    return Block(name, polyhedron(*lofted(_at(corners, y[0]), _at(corners, y[1])), name), material, fixed)


def prismatoid(name: str, points: NDArray[np.float64], material: Material, *, fixed: bool = False) -> Block:
    """Return the block between two level polygons (2 k, 3) of k corners, the lower first, both counter-clockwise."""
    return Block(name, polyhedron(*lofted(*np.split(points, 2)), name), material, fixed)


def _at(corners: NDArray[np.float64], y: float) -> NDArray[np.float64]:
    return np.column_stack([corners[:, 0], np.full(len(corners), y), corners[:, 1]])
