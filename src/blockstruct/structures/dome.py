"""Domes built of rings of blocks."""

import math

import numpy as np

from blockstruct.arrays import Array
from blockstruct.errors import ModelError
from blockstruct.geometry.tolerances import ROUNDING
from blockstruct.model import Block, Material
from blockstruct.model.checks import check_total, checked_count
from blockstruct.structures.arch import half_profile
from blockstruct.structures.builder import builder, lengths
from blockstruct.structures.prism import block, prismatoid
from blockstruct.units import QuantityLike, si


@builder
def dome(
    *,
    span: QuantityLike,
    thickness: QuantityLike,
    courses: int,
    units: int,
    oculus: QuantityLike,
    material: Material,
    rise: QuantityLike | None = None,
    staggered: bool = True,
    keystone: bool = False,
    base: bool = True,
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of a dome about the z axis from z = 0: hemispherical or pointed, open at the top.

    Joints between courses are radial to the profile, so that each ring lies on a cone of flat facets. In a staggered
    dome every block spans two facets and every course is rotated by one facet, so that the joints fit exactly.

    Parameters
    ----------
    span, thickness : quantity, length
        Clear diameter at the springing, and thickness of the shell. Corners lie on these circles.
    courses, units
        Number of rings, and number of blocks in each ring (at least three).
    oculus : quantity, length
        Clear diameter of the opening at the top.
    material
        Material of all blocks.
    rise : quantity, length
        Height at which the intrados would meet the axis. Half the span (the default) gives a hemisphere, more a pointed
        dome.
    staggered
        Whether the joints of a course are over the middle of the blocks below.
    keystone
        Whether one block closes the oculus.
    base
        Whether to add a fixed block under the whole dome.
    prefix
        Start of all names. The k-th block of the j-th ring from below is ``j.k``; the others are ``base`` and
        ``keystone``.

    Examples
    --------
    >>> stone = Material("stone", "20 kN/m^3")
    >>> blocks = dome(span="8 m", thickness="0.8 m", courses=6, units=12, oculus="2 m", material=stone)
    >>> len(blocks), blocks[0].name, blocks[-1].name
    (73, 'base', '6.12')
    """
    s, t, opening = lengths("dome", span=span, thickness=thickness, oculus=oculus)
    rings, count = checked_count(courses, 1, "dome: courses"), checked_count(units, 3, "dome: units")
    check_total(rings * count, "dome")
    height = s / 2 if rise is None else si(rise, "length", "dome: rise")
    if height < s / 2 * (1 - ROUNDING):
        msg = f"dome: rise {height:.6g} m; give half the span, {s / 2:.6g} m (hemispherical), or more (pointed)"
        raise ModelError(msg)
    if opening >= s:
        msg = f"dome: oculus {opening:.6g} m; give less than the span, {s:.6g} m"
        raise ModelError(msg)
    inner, outer = half_profile(s, height, t, rings, opening)
    facets = 2 if staggered else 1
    angles = 2 * math.pi * np.arange(facets * count) / (facets * count)
    around = np.column_stack([np.cos(angles), np.sin(angles)])

    blocks = []
    if base:
        rim = np.concatenate([_ring(around, outer[0] - [0.0, z]) for z in (t, 0.0)])
        blocks.append(prismatoid(f"{prefix}base", rim, material, fixed=True))
    for j in range(rings):
        shift = j % 2 if staggered else 0
        for k in range(count):
            pick = around[(np.arange(facets + 1) + facets * k + shift) % len(around)]
            profile = (inner[j], outer[j], outer[j + 1], inner[j + 1])
            corners = np.stack([_ring(pick, point) for point in profile], axis=1)
            blocks.append(_unit(f"{prefix}{j + 1}.{k + 1}", corners, material))
    if keystone:
        plug = np.concatenate([_ring(around, point[-1]) for point in (inner, outer)])
        blocks.append(prismatoid(f"{prefix}keystone", plug, material))
    return blocks


def _ring(around: Array, point: Array) -> Array:
    """Return points (m, 3) at the radius and height of a profile point (2,), in horizontal directions (m, 2)."""
    return np.column_stack([point[0] * around, np.full(len(around), point[1])])


def _unit(name: str, corners: Array, material: Material) -> Block:
    """Return the block with corners (m, 4, 3): on each of m meridians, inner and outer below, outer and inner above."""
    m = len(corners)
    # Faces from one meridian to the next: joint below, extrados, joint above, intrados.
    strips: list[list[tuple[int, ...]]] = [
        [(4 * k + a, 4 * k + 4 + a, 4 * k + 4 + b, 4 * k + b) for k in range(m - 1)]
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))
    ]
    if m == 3 and np.ptp(corners[:, :2, 2]) == 0.0:
        strips[0] = [(0, 4, 8, 9, 5, 1)]
    ends = [(0, 1, 2, 3), tuple(4 * m - 4 + i for i in (3, 2, 1, 0))]
    faces = tuple(face for strip in (*strips, ends) for face in strip)
    return block(name, (corners.reshape(-1, 3), faces), material)
