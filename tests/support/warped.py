"""Shells of warped stones, whose corners were surveyed or rounded one stone at a time."""

from itertools import pairwise

import numpy as np

import blockstruct as bs
from blockstruct import Q_
from meshes import QUADS
from structures import STONE


def triangles(rng: np.random.Generator) -> list[list[int]]:
    """Every quadrilateral divided along one of its diagonals."""
    halves = []
    for a, b, c, d in QUADS:
        halves += [[a, b, c], [a, c, d]] if rng.random() < 0.5 else [[a, b, d], [b, c, d]]
    return halves


def warped_vault(
    stones: int = 7, rows: int = 3, *, warp: float = 0.0, noise: float = 0.0, seed: int = 0, thickness: float = 0.25
) -> list[bs.Block]:
    """Barrel vault of 2 m radius in bond, on its springers.

    Parameters
    ----------
    stones, rows
        Along the arch, and whole ones along the barrel.
    warp
        Largest displacement, m, along each axis, of corners that neighbours share: joints warp, and stay closed.
    noise
        The same of each stone by itself: joints gape and stones penetrate each other.
    """
    rng = np.random.default_rng(seed)
    angle, y, radius = np.meshgrid(
        np.pi * np.arange(stones + 1) / stones, np.linspace(0, 2, 2 * rows + 1), [2.0, 2.0 + thickness], indexing="ij"
    )
    nodes = np.stack([-radius * np.cos(angle), y, radius * np.sin(angle)], axis=-1)
    nodes += rng.uniform(-warp, warp, nodes.shape)
    blocks = []
    for i in range(stones):
        cuts = range(0, 2 * rows + 1, 2) if i % 2 == 0 else [0, *range(1, 2 * rows, 2), 2 * rows]
        for a, b in pairwise(cuts):
            corners = np.array([nodes[k, j, r] for k in (i, i + 1) for j, r in ((a, 0), (b, 0), (b, 1), (a, 1))])
            points = Q_(corners + rng.uniform(-noise, noise, corners.shape), "m")
            name, fixed = f"{i}.{a}", i in (0, stones - 1)
            blocks.append(bs.Block.from_faces(name, points, triangles(rng), STONE, fixed=fixed))
    return blocks
