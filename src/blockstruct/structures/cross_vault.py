"""Cross vaults: two barrel vaults that intersect in groins over a square bay."""

import math

import numpy as np

from blockstruct.arrays import Array
from blockstruct.geometry.polyhedron import BOX_FACES
from blockstruct.model import Block, Material
from blockstruct.model.checks import check_total, checked_count
from blockstruct.structures.builder import builder, lengths
from blockstruct.structures.prism import block
from blockstruct.units import QuantityLike


@builder
def cross_vault(
    *,
    span: QuantityLike,
    thickness: QuantityLike,
    courses: int,
    units: int,
    material: Material,
    base: bool = True,
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of a cross vault of two semicircular barrel vaults, along x and y, that spring at z = 0.

    The vertical planes of the groins and the crowns cut the blocks; at the groins the blocks meet their mirror images.
    At its four corners the vault is one thickness wider than the springing, so that every course has a length.

    Parameters
    ----------
    span, thickness : quantity, length
        Clear span of both barrels, and thickness of the shell.
    courses
        Number of courses from the springing to the crown.
    units
        Number of blocks along half a barrel at the crown. Courses are staggered by half a block.
    material
        Material of all blocks.
    base
        Whether to add a fixed block under each of the four corners, ``base1`` to ``base4``.
    prefix
        Start of all names. ``w.j.k`` is the k-th block from the groin in the j-th course of the w-th half web. Half
        webs are numbered around the z axis from the half web on +x at +y.

    Examples
    --------
    >>> stone = Material("stone", "20 kN/m^3")
    >>> blocks = cross_vault(span="4 m", thickness="0.4 m", courses=6, units=4, material=stone)
    >>> len(blocks), blocks[0].name, blocks[4].name
    (100, 'base1', '1.1.1')
    """
    s, t = lengths("cross_vault", span=span, thickness=thickness)
    radius = s / 2
    rows = checked_count(courses, 2, "cross_vault: courses")
    count = checked_count(units, 1, "cross_vault: units")
    check_total(8 * rows * count, "cross_vault")
    end = radius + 2 * t
    angle = np.linspace(0.0, math.pi / 2, rows + 1)
    y, z = np.cos(angle), np.sin(angle)
    y[-1] = 0.0

    blocks = []
    if base:
        corner = np.array([[x, y, z] for z in (-t, 0.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)
        corner[:, :2] = radius + corner[:, :2] * (end - radius)
        blocks += [_turned(f"{prefix}base{k + 1}", corner, 2 * k, material, fixed=True) for k in range(4)]
    for web in range(8):
        for j in range(rows):
            profile = np.array(
                [(r * y[i], r * z[i]) for i, r in ((j, radius), (j, radius + t), (j + 1, radius + t), (j + 1, radius))]
            )
            joints = (np.arange(count) + (0.5 if j % 2 else 0.0)) * end / count
            # A block shorter than a quarter at the groin is joined to its neighbour.
            joints = joints[joints > profile[:, 0].max() + end / count / 4]
            starts = [profile[:, 0], *(np.full(4, x) for x in joints)]
            ends = [*starts[1:], np.full(4, end)]
            for k, (x0, x1) in enumerate(zip(starts, ends, strict=True), start=1):
                corners = np.concatenate([np.column_stack([x, profile]) for x in (x0, x1)])
                blocks.append(_turned(f"{prefix}{web + 1}.{j + 1}.{k}", corners, web, material))
    return blocks


def _turned(name: str, corners: Array, web: int, material: Material, *, fixed: bool = False) -> Block:
    """Move a hexahedron (8, 3) of the web on +x at +y to another web: mirrored for odd webs, then rotated."""
    points = corners.copy()
    quarter, mirrored = divmod(web, 2)
    if mirrored:
        # About the groin x = y.
        points = points[:, [1, 0, 2]]
    for _ in range(quarter):
        points = points[:, [1, 0, 2]] * [-1.0, 1.0, 1.0]
    faces = tuple(face[::-1] for face in BOX_FACES) if mirrored else BOX_FACES
    return block(name, (points, faces), material, fixed=fixed)
