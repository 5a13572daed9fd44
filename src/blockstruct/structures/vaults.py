"""Arches, barrel and cross vaults, and domes of fitting voussoirs."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array
from blockstruct.errors import ModelError
from blockstruct.geometry.polyhedron import BOX_FACES
from blockstruct.model import Block, Material
from blockstruct.model.fields import check_total, checked_count
from blockstruct.structures.builder import block, builder, lengths, prism, prismatoid
from blockstruct.units import QuantityLike, VectorLike, si, si_vector


@dataclass(frozen=True, slots=True)
class ArchProfile:
    """Joints of an arch in the plane (x, z): x from the middle of the span, z from the springing line, m.

    Attributes
    ----------
    inner, outer : (n + 1, 2) arrays
        Ends of the joints on the intrados and on the extrados, from left to right.
    """

    inner: Array
    outer: Array

    @classmethod
    def of(
        cls,
        span: QuantityLike,
        thickness: QuantityLike,
        voussoirs: Any,
        rise: QuantityLike | None = None,
        skewback: QuantityLike = "20 deg",
        who: str = "arch",
    ) -> "ArchProfile":
        """Return the profile with a rise of the intrados over its span.

        Half the span (the default) gives a semicircular profile, less a segmental profile. More gives a pointed profile
        of two arcs with centres on the springing line; it has a joint at the crown and an even number of voussoirs.
        Zero gives a flat profile, whose joints meet in one point.

        Parameters
        ----------
        span, thickness : quantity, length
            Clear span and thickness of the ring.
        voussoirs
            Number of wedges with straight sides and corners on the intrados and the extrados.
        rise : quantity, length
            Rise of the intrados over the springing line.
        skewback : quantity, angle
            Angle between the vertical and the end joints of a flat arch.
        who
            Name of the builder in error messages.
        """
        s, t = lengths(who, span=span, thickness=thickness)
        n = checked_count(voussoirs, 2, f"{who}: voussoirs")
        f = s / 2 if rise is None else si(rise, "length", f"{who}: rise")
        if f < 0 or 0 < f < NEGLIGIBLE * s:
            msg = f"{who}: rise {f:.6g} m; give zero (flat) or a larger length"
            raise ModelError(msg)
        if f == 0:
            angle = si(skewback, "angle", f"{who}: skewback")
            if not 0 < angle < math.pi / 3:
                msg = f"{who}: skewback {math.degrees(angle):.4g} deg; give an angle between 0 and 60 deg"
                raise ModelError(msg)
            x = np.linspace(-s / 2, s / 2, n + 1)
            # All joints point to one point, (s/2) / tan(skewback) below the middle.
            spread = 1 + t / (s / 2 / math.tan(angle))
            return cls(_points(x, 0 * x), _points(x * spread, 0 * x + t))
        if f <= s / 2 * (1 + ROUNDING):
            radius = (s**2 / 4 + f**2) / (2 * f)
            half = math.pi / 2 if rise is None else math.asin(min(1.0, s / 2 / radius))
            angle_of = np.linspace(-half, half, n + 1)
            direction = _points(np.sin(angle_of), np.cos(angle_of))
            centre = np.array([0.0, f - radius])
            return cls(centre + radius * direction, centre + (radius + t) * direction)
        if n % 2:
            msg = f"{who}: {n} voussoirs; a pointed arch has a joint at the crown, give an even number"
            raise ModelError(msg)
        inner, outer = half_profile(s, f, t, n // 2)
        outer[-1] = 0.0, math.sqrt((pointed_radius(s, f) + t) ** 2 - (pointed_radius(s, f) - s / 2) ** 2)
        mirror = np.array([-1.0, 1.0])
        return cls(np.concatenate([inner * mirror, inner[-2::-1]]), np.concatenate([outer * mirror, outer[-2::-1]]))


def pointed_radius(span: float, rise: float) -> float:
    """Return the radius of the arc from the springing to the crown with its centre on the springing line, m."""
    return (rise**2 + span**2 / 4) / span


def half_profile(span: float, rise: float, thickness: float, parts: int, opening: float = 0.0) -> tuple[Array, Array]:
    """Return the radial joints of the right half of a semicircular or pointed profile.

    The joints run from the springing to the point of the intrados at half an ``opening`` from the axis. All lengths are
    in m. The result is the ends of the joints on the intrados and on the extrados, each of shape (parts + 1, 2).
    """
    radius = pointed_radius(span, rise)
    centre = np.array([span / 2 - radius, 0.0])
    angle = np.linspace(0.0, math.acos((opening / 2 - centre[0]) / radius), parts + 1)
    direction = _points(np.cos(angle), np.sin(angle))
    return centre + radius * direction, centre + (radius + thickness) * direction


def _points(x: Array, z: Array) -> Array:
    return np.column_stack([x, z])


@builder
def arch(
    *,
    span: QuantityLike,
    thickness: QuantityLike,
    depth: QuantityLike,
    voussoirs: int,
    material: Material,
    rise: QuantityLike | None = None,
    skewback: QuantityLike = "20 deg",
    abutments: bool = True,
    origin: VectorLike = ("0 m", "0 m", "0 m"),
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of an arch in the x–z plane: semicircular, segmental, pointed or flat.

    Parameters
    ----------
    span, thickness, depth : quantity, length
        Clear span along x, thickness of the ring, and depth along y.
    voussoirs
        Number of wedges with straight sides and corners on the intrados and the extrados.
    material
        Material of all blocks.
    rise : quantity, length
        Rise of the intrados. Half the span (the default) gives a semicircular arch, less a segmental arch, more a
        pointed arch (with an even number of voussoirs), zero a flat arch.
    skewback : quantity, angle
        Angle between the vertical and the end joints of a flat arch.
    abutments
        Whether to add fixed blocks at both ends, ``left`` and ``right``, as thick as the ring.
    origin : quantity, length, three components
        Middle of the span, on the springing line, at the smallest y.
    prefix
        Start of all names. The voussoirs are ``1``, ``2`` … from left to right.

    Examples
    --------
    A semicircular arch with a centreline radius of 10 m, less than a per cent above the minimum thickness:

    >>> stone = Material("stone", "20 kN/m^3")
    >>> blocks = arch(span="18.925 m", thickness="1.075 m", depth="1 m", voussoirs=27, material=stone)
    >>> len(blocks), blocks[0].name, blocks[-1].name, blocks[14].centroid[2].round(3).item()
    (29, 'left', 'right', 9.993)
    """
    return barrel_vault(
        span=span,
        thickness=thickness,
        length=depth,
        voussoirs=voussoirs,
        units=None,
        material=material,
        rise=rise,
        skewback=skewback,
        abutments=abutments,
        origin=origin,
        prefix=prefix,
    )


@builder
def barrel_vault(
    *,
    span: QuantityLike,
    thickness: QuantityLike,
    length: QuantityLike,
    voussoirs: int,
    units: int | None,
    material: Material,
    rise: QuantityLike | None = None,
    skewback: QuantityLike = "20 deg",
    staggered: bool = True,
    abutments: bool = True,
    origin: VectorLike = ("0 m", "0 m", "0 m"),
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of a barrel vault along y, with the profile of :func:`arch`.

    Parameters
    ----------
    span, thickness, length : quantity, length
        Clear span along x, thickness, and length along y.
    voussoirs
        Number of rows of blocks from left to right.
    units
        Number of blocks in a row. With None each row is one block, named by the row alone.
    material
        Material of all blocks.
    rise, skewback
        As for :func:`arch`.
    staggered
        Whether every second row begins and ends with half a block.
    abutments
        Whether to add a fixed block along each side, ``left`` and ``right``.
    origin : quantity, length, three components
        Middle of the span, on the springing line, at the smallest y.
    prefix
        Start of all names. The k-th block along y of the j-th row from the left is ``j.k``.

    Examples
    --------
    >>> stone = Material("stone", "20 kN/m^3")
    >>> size = {"span": "4 m", "thickness": "0.4 m", "length": "3 m", "material": stone}
    >>> blocks = barrel_vault(**size, voussoirs=11, units=4)
    >>> len(blocks) == 2 + 6 * 4 + 5 * 5, blocks[1].name, blocks[5].name
    (True, '1.1', '2.1')
    """
    profile = ArchProfile.of(span, thickness, voussoirs, rise, skewback)
    reach, t = lengths("arch", **{"depth or length": length, "thickness": thickness})
    x0, y0, z0 = si_vector(origin, "length", "arch: origin")
    inner, outer = (ends + np.array([x0, z0]) for ends in (profile.inner, profile.outer))
    whole = (y0, y0 + reach)
    count = 1 if units is None else checked_count(units, 1, "barrel_vault: units")
    check_total(count * (len(inner) - 1), "barrel_vault")
    blocks = []
    for row in range(len(inner) - 1):
        outline = [inner[row], outer[row], outer[row + 1], inner[row + 1]]
        if units is None:
            blocks.append(prism(f"{prefix}{row + 1}", outline, whole, material))
            continue
        ends = np.linspace(0.0, 1.0, count + 1)
        if staggered and row % 2:
            ends = np.concatenate([[0.0], (ends[:-1] + ends[1:]) / 2, [1.0]])
        y = y0 + reach * ends
        blocks += [prism(f"{prefix}{row + 1}.{k + 1}", outline, (y[k], y[k + 1]), material) for k in range(len(y) - 1)]
    if not abutments:
        return blocks
    left = prism(f"{prefix}left", _abutment(inner[0], outer[0], t, -1.0), whole, material, fixed=True)
    right = prism(f"{prefix}right", _abutment(inner[-1], outer[-1], t, 1.0), whole, material, fixed=True)
    return [left, *blocks, right]


@builder
def arch_on_piers(
    *,
    span: QuantityLike,
    thickness: QuantityLike,
    depth: QuantityLike,
    voussoirs: int,
    pier_width: QuantityLike,
    pier_height: QuantityLike,
    pier_courses: int,
    material: Material,
    rise: QuantityLike | None = None,
    skewback: QuantityLike = "20 deg",
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of an arch on two piers, on a fixed block ``base`` at z = 0.

    Parameters
    ----------
    span, thickness, depth, voussoirs, rise, skewback
        As for :func:`arch`.
    pier_width, pier_height : quantity, length
        Width along x, at least the width of the springing, and height up to the springing line.
    pier_courses
        Number of blocks of each pier.
    material
        Material of all blocks.
    prefix
        Start of all names. Voussoirs are ``1``, ``2`` …, blocks of the piers ``left.1``, ``right.1`` … from the ground,
        and the blocks below an inclined springing ``left.springer`` and ``right.springer``.

    Examples
    --------
    >>> stone = Material("stone", "20 kN/m^3")
    >>> size = {"span": "4 m", "thickness": "0.5 m", "depth": "1 m", "pier_width": "1 m", "pier_height": "2 m"}
    >>> blocks = arch_on_piers(**size, rise="1 m", voussoirs=9, pier_courses=4, material=stone)
    >>> [b.name for b in blocks if "left" in b.name or b.fixed]
    ['base', 'left.1', 'left.2', 'left.3', 'left.4', 'left.springer']
    """
    profile = ArchProfile.of(span, thickness, voussoirs, rise, skewback, "arch_on_piers")
    sizes = {"depth": depth, "pier_width": pier_width, "pier_height": pier_height}
    d, width, height = lengths("arch_on_piers", **sizes)
    courses = checked_count(pier_courses, 1, "arch_on_piers: pier_courses")
    inner, outer = (ends + np.array([0.0, height]) for ends in (profile.inner, profile.outer))
    end = inner[-1, 0] + width
    if end < outer[-1, 0] * (1 - ROUNDING):
        msg = (
            f"arch_on_piers: pier_width {width:.6g} m is less than the springing, "
            f"{outer[-1, 0] - inner[-1, 0]:.6g} m wide; give wider piers"
        )
        raise ModelError(msg)
    y = (0.0, d)
    step = height / courses
    blocks = [prism(f"{prefix}base", _rectangle(-end, end, -step, 0.0), y, material, fixed=True)]
    z = np.linspace(0.0, height, courses + 1)
    for side, sense in (("left", -1.0), ("right", 1.0)):
        foot, edge = sense * inner[-1, 0], sense * end
        blocks += [
            prism(f"{prefix}{side}.{k + 1}", _rectangle(foot, edge, z[k], z[k + 1]), y, material)
            for k in range(courses)
        ]
        top = outer[-1, 1]
        if top > height + ROUNDING * step:
            corners = [(foot, height), (edge, height), (edge, top), (sense * outer[-1, 0], top)]
            distinct = corners if abs(edge - corners[-1][0]) > ROUNDING * width else corners[:-1]
            blocks.append(prism(f"{prefix}{side}.springer", distinct, y, material))
    ring = [
        prism(f"{prefix}{k + 1}", [inner[k], outer[k], outer[k + 1], inner[k + 1]], y, material)
        for k in range(len(inner) - 1)
    ]
    return blocks + ring


def _abutment(inner: Array, outer: Array, thickness: float, sense: float) -> list[Array]:
    """Return the outline of the block at an end joint, on the side away from the arch."""
    along = (outer - inner) / np.linalg.norm(outer - inner)
    away = sense * np.array([along[1], -along[0]]) * thickness
    return [inner, outer, outer + away, inner + away]


def _rectangle(x0: float, x1: float, z0: float, z1: float) -> list[tuple[float, float]]:
    return [(x0, z0), (x1, z0), (x1, z1), (x0, z1)]


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
