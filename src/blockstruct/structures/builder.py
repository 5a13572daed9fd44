"""Check arguments of builders; make blocks from outlines and points."""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from blockstruct.arrays import Array
from blockstruct.errors import ModelError, shown
from blockstruct.geometry.polyhedron import Loops, lofted, polyhedron
from blockstruct.model import Block, Material
from blockstruct.model.fields import checked_count, positive_length
from blockstruct.units import QuantityLike

_Function = TypeVar("_Function", bound=Callable[..., Any])

_KINDS: dict[str, tuple[type, str]] = {
    "material": (Material, "a Material"),
    "prefix": (str, "a text"),
    **dict.fromkeys(("abutments", "base", "keystone", "staggered"), (bool, "True or False")),
}


def builder(function: _Function) -> _Function:
    """Return a builder that refuses shared arguments of a wrong type."""

    @wraps(function)
    def build(*args: Any, **keywords: Any) -> Any:
        for name, value in keywords.items():
            kind, remedy = _KINDS.get(name, (object, ""))
            if not isinstance(value, kind):
                msg = f"{function.__name__}: {name} is {shown(value)}; give {remedy}"
                raise ModelError(msg)
        return function(*args, **keywords)

    return cast(_Function, build)


def lengths(who: str, **values: Any) -> list[float]:
    """Return the lengths of a builder, m, in the order of its arguments."""
    return [positive_length(value, f"{who}: {name}") for name, value in values.items()]


def length(value: QuantityLike, dimension: str = "", what: str = "") -> float:
    """Return a length in m, within the range of buildings."""
    return positive_length(value, what)


def optional_length(value: QuantityLike | None, dimension: str = "", what: str = "") -> float | None:
    """Return a length in m that may be left out."""
    return None if value is None else positive_length(value, what)


def count(value: int, least: int = 1, what: str = "") -> int:
    """Return a whole number from ``least``."""
    return checked_count(value, least, what)


def optional_count(value: int | None, least: int = 1, what: str = "") -> int | None:
    """Return a whole number from ``least`` that may be left out."""
    return None if value is None else checked_count(value, least, what)


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
