"""Bars bonded along their length."""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from attrs import field, frozen
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.geometry import stretches_inside
from blockstruct.model.block import Block
from blockstruct.model.fields import (
    ModelObject,
    Vector,
    has_name,
    label,
    named_arguments,
    optional_scalar,
    positive,
    scalar,
    vector,
)
from blockstruct.model.tie_segments import TieSegment
from blockstruct.vocabulary import listed

_LENGTH, _FORCE, _STRESS = ({"dimension": d} for d in ("length", "force", "stress"))


@frozen(repr=False, field_transformer=named_arguments)
class BondedBar(ModelObject):
    """A straight bar, bonded along its length to all blocks that it crosses.

    It has one force in each segment from one block to the next. From segment to segment the force changes by at most
    the bond in the block between them, ``π d τ_b ℓ``, with the length ℓ inside the block. The force of the first and
    the last segment is at most the bond of the end in its block.

    Parameters
    ----------
    name
        Unique among the ties of a model.
    start, end : quantity, length, three components
        Ends of the bar, in global coordinates, inside or outside the blocks. The bar is bonded to a block where its
        whole cross-section is inside. It is not bonded where it runs in a joint, or where its axis is within half the
        diameter of a joint or a free surface.
    diameter : quantity, length
        Diameter d of the bonded surface, and of the cross-section for ``strength``.
    bond_strength : quantity, stress
        τ_b.
    yield_force : quantity, force
        Of the bar.
    strength : quantity, stress
        Yield strength of the full cross-section, instead of the yield force.
    elongation_limit : quantity, length
        Elongation of a segment at which the bar breaks. A result states when a mechanism reaches it.

    Attributes
    ----------
    start, end : three floats
        m.
    diameter, bond_strength : float
        m and Pa.
    yield_force, strength, elongation_limit : float or None
        N, Pa and m; None if not given.

    Raises
    ------
    ModelError
        If a strength is missing or not above zero, or both ends are at one point.
    UnitError, DimensionError
        If a value has no unit, or its unit has another dimension.
    """

    computed: ClassVar = {"capacity": "force"}

    name: str = field(validator=has_name)
    start: Vector = field(converter=vector, metadata=_LENGTH)
    end: Vector = field(converter=vector, metadata=_LENGTH)
    diameter: float = field(kw_only=True, converter=scalar, validator=positive, metadata=_LENGTH)
    bond_strength: float = field(kw_only=True, converter=scalar, validator=positive, metadata=_STRESS)
    yield_force: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata=_FORCE
    )
    strength: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata=_STRESS
    )
    elongation_limit: float | None = field(
        default=None, kw_only=True, converter=optional_scalar, validator=positive, metadata=_LENGTH
    )

    def __attrs_post_init__(self) -> None:
        if (self.yield_force is None) == (self.strength is None):
            msg = f"{label(self)}: give either yield_force or strength"
            raise ModelError(msg)
        if self.start == self.end:
            msg = f"{label(self)}: both ends are at {self.start} m; give two points"
            raise ModelError(msg)

    @property
    def capacity(self) -> float:
        """Yield force of the bar, N."""
        if self.yield_force is not None:
            return self.yield_force
        return math.pi * self.diameter**2 / 4 * (self.strength or 0.0)

    @property
    def governing(self) -> str:
        """Name of the limit of the bar."""
        return "yield"

    def segments(self, blocks: Mapping[str, Block]) -> tuple[TieSegment, ...]:
        """Return the segments of the bar from one block to the next.

        Raises
        ------
        ModelError
            If the bar crosses fewer than two blocks, or supports only.
        """
        start, end = np.array(self.start), np.array(self.end)
        d = (end - start) / np.linalg.norm(end - start)
        inside = sorted(
            (stretch, name)
            for name, b in blocks.items()
            for stretch in stretches_inside(b.shape, start, end, self.diameter / 2)
        )
        names = list(dict.fromkeys(name for _, name in inside))
        if len(inside) < 2 or all(blocks[name].fixed for name in names):
            through = listed([f"{name!r}" for name in names]) or "no block at all"
            msg = (
                f"bonded bar {self.name!r} from {self.start} to {self.end} m crosses {through}, so it joins "
                "nothing; give ends between which it is inside two blocks or more, one of them free, with its axis at "
                f"least {self.diameter / 2:g} m from their faces, half its diameter"
            )
            raise ModelError(msg)
        bond = [math.pi * self.diameter * self.bond_strength * (b - a) for (a, b), _ in inside]
        last = len(inside) - 1
        ends = [min(bond[0] if k == 0 else math.inf, bond[-1] if k + 1 == last else math.inf) for k in range(last)]
        # Two segments meet in the middle of the block between them.
        at = [inside[0][0][0], *((a + b) / 2 for (a, b), _ in inside[1:-1]), inside[-1][0][1]]
        return tuple(
            TieSegment(
                tie=self.name,
                name=f"{self.name} [{inside[k][1]}|{inside[k + 1][1]}]",
                blocks=(inside[k][1], inside[k + 1][1]),
                start=_point(start + at[k] * d),
                end=_point(start + at[k + 1] * d),
                direction=_point(d),
                capacity=min(self.capacity, ends[k]),
                governing=self.governing if self.capacity <= ends[k] else "bond",
                bond=(bond[k] if k > 0 else math.inf, bond[k + 1] if k + 1 < last else math.inf),
                elongation_limit=math.inf if self.elongation_limit is None else self.elongation_limit,
            )
            for k in range(last)
        )


def _point(values: NDArray[np.float64]) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
