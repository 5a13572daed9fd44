"""Columns of drums, and stacks of blocks."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from blockstruct.errors import DimensionError, ModelError, shown
from blockstruct.geometry.polyhedron import box
from blockstruct.model import Block, Material, checked_tuple
from blockstruct.model.checks import checked_count
from blockstruct.structures.builder import block, builder, lengths, prismatoid
from blockstruct.units import QuantityLike, VectorLike, si, si_array, si_vector


@builder
def column(
    *,
    height: QuantityLike,
    diameter: QuantityLike,
    drums: int,
    material: Material,
    top_diameter: QuantityLike | None = None,
    sides: int = 16,
    base: bool = True,
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of a column of drums about the z axis, from z = 0 up.

    Parameters
    ----------
    height, diameter : quantity, length
        Height of the column, and diameter across the corners at the foot.
    drums
        Number of drums of equal height.
    material
        Material of all blocks.
    top_diameter : quantity, length
        Diameter across the corners at the top of a tapered column; ``diameter`` by default.
    sides
        Number of sides of the drums.
    base
        Whether to add a fixed square plinth ``base``, one and a half diameters wide.
    prefix
        Start of all names. The drums are ``1``, ``2`` … from the ground.

    Examples
    --------
    >>> marble = Material("marble", "27 kN/m^3")
    >>> [b.name for b in column(height="6 m", diameter="1 m", top_diameter="0.8 m", drums=3, material=marble)]
    ['base', '1', '2', '3']
    """
    top_diameter = diameter if top_diameter is None else top_diameter
    h, d, top = lengths("column", height=height, diameter=diameter, top_diameter=top_diameter)
    count, n = checked_count(drums, 1, "column: drums"), checked_count(sides, 3, "column: sides")
    angle = 2 * math.pi * np.arange(n) / n
    around = np.column_stack([np.cos(angle), np.sin(angle)])

    blocks = []
    if base:
        plinth = box((-0.75 * d, -0.75 * d, -d / 2), (1.5 * d, 1.5 * d, d / 2))
        blocks.append(block(f"{prefix}base", plinth, material, fixed=True))
    levels = np.linspace(0.0, h, count + 1)
    radii = (d + (top - d) * levels / h) / 2
    for k in range(count):
        corners = np.concatenate([np.column_stack([radii[i] * around, np.full(n, levels[i])]) for i in (k, k + 1)])
        blocks.append(prismatoid(f"{prefix}{k + 1}", corners, material))
    return blocks


@builder
def stack(
    count: int,
    *,
    size: VectorLike,
    material: Material,
    shift: VectorLike = ("0 m", "0 m"),
    base: bool = True,
    prefix: str = "",
) -> list[Block]:
    """Return a stack of equal boxes, each shifted against the box below, from z = 0 up.

    Parameters
    ----------
    count
        Number of boxes.
    size : quantity, length, three components
        Size of every box.
    material
        Material of all blocks.
    shift : quantity, length, two components
        Shift along x and y from each box to the next.
    base
        Whether to add a fixed block ``base`` of the same size under the first box.
    prefix
        Start of all names. The boxes are ``1``, ``2`` … from the ground.

    Examples
    --------
    >>> stone = Material("stone", "20 kN/m^3")
    >>> [b.name for b in stack(3, size=["0.4 m", "0.2 m", "0.2 m"], shift=["5 cm", "0 cm"], material=stone)]
    ['base', '1', '2', '3']
    """
    number = checked_count(count, 1, "stack: count")
    edges = si_vector(size, "length", "stack: size")
    if min(edges) <= 0:
        msg = f"stack: size {edges} m; give three lengths above zero"
        raise ModelError(msg)
    what = "stack: shift"
    listed = isinstance(shift, list | tuple)
    step = [si(v, "length", what) for v in shift] if listed else si_array(shift, "length", what).ravel().tolist()
    if len(step) != 2:
        msg = f"{what}: {shown(shift)} has {len(step)} components; give two, along x and y"
        raise DimensionError(msg)
    dx, dy = step
    blocks = []
    for k in range(0 if base else 1, number + 1):
        name = prefix + (str(k) if k else "base")
        steps = max(k - 1, 0)
        body = box((steps * dx, steps * dy, (k - 1) * edges[2]), edges)
        blocks.append(block(name, body, material, fixed=k == 0))
    return blocks


@builder
def tilted(
    blocks: Iterable[Block],
    angle: QuantityLike,
    *,
    axis: Sequence[float] = (0, 1, 0),
    about: VectorLike = ("0 m", "0 m", "0 m"),
) -> list[Block]:
    """Return blocks rotated about an axis, as a structure on tilted ground.

    Parameters
    ----------
    blocks
        Blocks, supports included.
    angle : quantity, angle
        Right-handed: about +y the top moves towards +x.
    axis
        Direction of the axis, of any length above zero.
    about : quantity, length, three components
        A point of the axis.

    Examples
    --------
    >>> stone = Material("stone", "20 kN/m^3")
    >>> leaning = tilted(stack(3, size=["0.4 m", "0.2 m", "0.2 m"], material=stone), "10 deg")
    >>> leaning[3].centroid.round(3).tolist()
    [0.284, 0.1, 0.458]
    """
    blocks = checked_tuple(blocks, Block, "tilted: blocks")
    theta = si(angle, "angle", "tilted: angle")
    point = np.array(si_vector(about, "length", "tilted: about"))
    direction = np.array(si_vector(axis, "dimensionless", "tilted: axis"))
    length = float(np.linalg.norm(direction))
    if length == 0:
        msg = "tilted: axis (0, 0, 0); give a direction"
        raise ModelError(msg)
    x, y, z = direction / length
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(3) + math.sin(theta) * cross + (1 - math.cos(theta)) * cross @ cross
    return [
        block(b.name, (point + (b.shape.vertices - point) @ turn.T, b.shape.faces), b.material, fixed=b.held)
        for b in blocks
    ]
