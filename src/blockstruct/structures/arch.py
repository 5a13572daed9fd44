"""Arches of wedge voussoirs, on abutments or piers, and barrel vaults."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstruct.arrays import Array
from blockstruct.errors import ModelError
from blockstruct.geometry.tolerances import ROUNDING
from blockstruct.model import Block, Material
from blockstruct.model.checks import SHORTEST, check_total, checked_count
from blockstruct.structures.builder import builder, lengths
from blockstruct.structures.prism import prism
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
        if f < 0 or 0 < f < SHORTEST:
            msg = f"{who}: rise {f:.6g} m; give zero (flat) or a length of at least {SHORTEST:g} m"
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
