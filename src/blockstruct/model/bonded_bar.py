"""Bars bonded along their length."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.geometry import stretches_inside
from blockstruct.model.block import Block
from blockstruct.model.checks import checked_name
from blockstruct.model.tie_segments import TieSegment, Vector, positive_quantities, set_fields
from blockstruct.units import QuantityLike, VectorLike, si_vector
from blockstruct.vocabulary import listed


@dataclass(frozen=True, slots=True, init=False)
class BondedBar:
    """A straight bar, bonded along its length to all blocks that it runs through.

    It has one force in each stretch from one block to the next. From stretch to stretch the force changes by no more
    than the bond in the block between them, ``π d τ_b ℓ``, with ℓ the length inside the block, and that of the first
    and the last stretch is no more than the bond at the end behind it.

    Parameters
    ----------
    name
        Unique among the ties of a model.
    start, end : quantity, length, three components
        Ends of the bar, in global coordinates. It may stick out of the blocks. It is bonded to a block where its whole
        cross-section is inside: where it runs in a joint, or its axis within half the diameter of one or of a free
        surface, it is bonded to none of the blocks beside it.
    diameter : quantity, length
        Of the surface d along which it is bonded, and of the cross-section that ``strength`` counts on.
    bond_strength : quantity, stress
        τ_b.
    yield_force : quantity, force
        Of the bar.
    strength : quantity, stress
        Instead of the yield force: yield strength of the full cross-section.
    elongation_limit : quantity, length
        Of each stretch; beyond it the bar breaks: a result tells when a mechanism reaches it.

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
        If there is no strength, it is not above zero, or both ends are at one point.
    UnitError, DimensionError
        If a bare number is given where a unit is due, or a quantity of another dimension.
    """

    name: str
    start: Vector
    end: Vector
    diameter: float
    bond_strength: float
    yield_force: float | None
    strength: float | None
    elongation_limit: float | None

    def __init__(
        self,
        name: str,
        start: VectorLike,
        end: VectorLike,
        *,
        diameter: QuantityLike,
        bond_strength: QuantityLike,
        yield_force: QuantityLike | None = None,
        strength: QuantityLike | None = None,
        elongation_limit: QuantityLike | None = None,
    ) -> None:
        who = f"bonded bar {checked_name(name, 'bonded bar')!r}"
        given = {
            "diameter": diameter,
            "bond_strength": bond_strength,
            "yield_force": yield_force,
            "strength": strength,
            "elongation_limit": elongation_limit,
        }
        values = positive_quantities(given, who)
        if (yield_force is None) == (strength is None):
            msg = f"{who}: give either yield_force or strength"
            raise ModelError(msg)
        ends = {end: si_vector(v, "length", f"{who}: {end}") for end, v in (("start", start), ("end", end))}
        if ends["start"] == ends["end"]:
            msg = f"{who}: both ends are at {ends['start']} m; give two points"
            raise ModelError(msg)
        set_fields(self, name=name, **ends, **values)

    @property
    def capacity(self) -> float:
        """Yield force of the bar, N."""
        if self.yield_force is not None:
            return self.yield_force
        return math.pi * self.diameter**2 / 4 * (self.strength or 0.0)

    @property
    def governing(self) -> str:
        """Name of the limit of the bar itself."""
        return "yield"

    def segments(self, blocks: Mapping[str, Block]) -> tuple[TieSegment, ...]:
        """Stretches of the bar from one block to the next.

        Raises
        ------
        ModelError
            If the bar runs through fewer than two blocks, or through supports alone.
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
                f"bonded bar {self.name!r} from {self.start} to {self.end} m runs through {through}, so that it holds "
                "nothing together; give ends between which it runs inside two blocks or more (not in their faces, nor "
                f"with its axis within {self.diameter / 2:g} m of them, half its diameter), one of them free"
            )
            raise ModelError(msg)
        bond = [math.pi * self.diameter * self.bond_strength * (b - a) for (a, b), _ in inside]
        last = len(inside) - 1
        ends = [min(bond[0] if k == 0 else math.inf, bond[-1] if k + 1 == last else math.inf) for k in range(last)]
        # The stretches meet in the middles of the blocks between them.
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
