"""Walls of courses of units."""

import math
from collections.abc import Sequence
from typing import Any

from blockstruct.arrays import ROUNDING
from blockstruct.errors import ModelError
from blockstruct.geometry.polyhedron import box
from blockstruct.model import Block, Material, checked_tuple
from blockstruct.model.checks import check_total
from blockstruct.structures.builder import block, builder, lengths
from blockstruct.units import QuantityLike, VectorLike, si, si_vector


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
