"""Walls of courses, stacks of blocks, and columns of drums."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from blockstruct.arrays import ROUNDING
from blockstruct.errors import DimensionError, ModelError, shown
from blockstruct.geometry.polyhedron import box
from blockstruct.model import Block, Material, checked_tuple
from blockstruct.model.fields import check_total, checked_count
from blockstruct.structures.builder import block, builder, lengths, prismatoid
from blockstruct.units import QuantityLike, VectorLike, si, si_array, si_vector


@builder
def courses(
    rows: Sequence[Sequence[float]],
    *,
    unit_length: QuantityLike,
    unit_height: QuantityLike,
    thickness: QuantityLike,
    material: Material,
    origin: VectorLike = ("0 m", "0 m", "0 m"),
    base: bool = True,
    prefix: str = "",
) -> list[Block]:
    """Return the blocks of a straight wall in the x–z plane, from the lengths of its units.

    Parameters
    ----------
    rows
        One list per course, bottom to top. A number is the length of a unit in multiples of ``unit_length``; a negative
        number is the length of a void (opening).
    unit_length, unit_height, thickness : quantity, length
        Length of a whole unit along x, height of every course along z, thickness of the wall along y.
    material
        Material of all blocks.
    origin : quantity, length, three components
        Corner of the first course with the smallest x, y and z.
    base
        Whether to add a fixed block, one course high, below the whole first course.
    prefix
        Start of all names. The base is ``base``, the k-th unit of the j-th course ``j.k``. Numbers begin at one
        and skip voids.

    Raises
    ------
    ModelError
        If courses have different lengths, a unit has length zero, or a size is not positive.
    """
    length, height, t = lengths("courses", unit_length=unit_length, unit_height=unit_height, thickness=thickness)
    x0, y0, z0 = si_vector(origin, "length", "courses: origin")
    rows = [_lengths(row, j) for j, row in enumerate(checked_tuple(rows, object, "courses: rows"), start=1)]
    check_total(sum(map(len, rows)), "courses")
    if not rows:
        msg = "courses: a course without units; give at least one course, and one unit in each"
        raise ModelError(msg)
    width = math.fsum(abs(u) for u in rows[0])

    def unit(name: str, x: float, x_end: float, z: float, z_end: float, *, fixed: bool = False) -> Block:
        corner = (x0 + x * length, y0, z0 + z * height)
        body = box(corner, ((x_end - x) * length, t, (z_end - z) * height))
        return block(prefix + name, body, material, fixed=fixed)

    blocks = [unit("base", 0.0, width, -1.0, 0.0, fixed=True)] if base else []
    for j, row in enumerate(rows, start=1):
        if not math.isclose(math.fsum(abs(u) for u in row), width, rel_tol=ROUNDING):
            msg = (
                f"courses: course {j} is {math.fsum(abs(u) for u in row):.6g} times the unit long, the first "
                f"{width:.6g}; make all courses equally long, and give voids as negative lengths"
            )
            raise ModelError(msg)
        x, k = 0.0, 0
        for u in row:
            if u > 0:
                k += 1
                blocks.append(unit(f"{j}.{k}", x, x + u, j - 1.0, float(j)))
            x += abs(u)
    return blocks


def _lengths(row: Any, course: int) -> list[float]:
    """Return the lengths of the units of a course."""
    who = f"courses: course {course}"
    lengths = []
    for u in checked_tuple(row, object, who):
        length = si(u, "dimensionless", f"{who}: length of a unit")
        if length == 0:
            msg = f"{who} has a unit of length {u}; give a length, or a negative one for a void"
            raise ModelError(msg)
        lengths.append(length)
    if not lengths:
        msg = f"{who}: a course without units; give at least one course, and one unit in each"
        raise ModelError(msg)
    return lengths


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
