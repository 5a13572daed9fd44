"""Mass that takes part in a mechanism: weights and displacements of its bodies."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import xarray as xr

from blockstruct.arrays import NEGLIGIBLE, Array, Flags, Index
from blockstruct.assess.lines import Line
from blockstruct.errors import ModelError
from blockstruct.model import STANDARD_GRAVITY, BodyForce, LimitCase, Model
from blockstruct.results import MacroBlock, applied_loads
from blockstruct.results.mechanism import TOGETHER, twists, velocities
from blockstruct.text.numbers import shown


@dataclass(frozen=True, slots=True)
class HorizontalForces:
    """Forces of a horizontal variable load, as the weights of the masses that it pushes.

    Attributes
    ----------
    direction : (3,) array
        Direction of the push.
    share : float
        Horizontal force at load factor 1 over weight.
    block : (n,) array
        Index of the block of each force.
    point : (n, 3) array
        Point of action, m.
    weight : (n,) array
        P of a block, or Q of a carried mass, N.
    """

    direction: Array
    share: float
    block: Index
    point: Array
    weight: Array

    @classmethod
    def of(cls, model: Model, case: LimitCase) -> Self:
        """Return the forces of a case.

        Raises
        ------
        ModelError
            If the push is not horizontal or not proportional to the weight, or has couples or forces across it.
        """
        who = f"case {case.name!r}: variable load {case.variable.name!r}"
        bodies = [load for load in case.variable.loads if isinstance(load, BodyForce)]
        push = sum((load.share * np.array(load.direction) for load in bodies), np.zeros(3))
        share = float(np.linalg.norm(push))
        if share == 0:
            msg = (
                f"{who} has no BodyForce; a local mechanism is checked for horizontal forces in proportion to the "
                "weight (C8.7.1.2.1.1): give a BodyForce with a horizontal direction"
            )
            raise ModelError(msg)
        direction = push / share
        found = applied_loads(model, case.variable, case.dead)
        if abs(direction[2]) > NEGLIGIBLE or found.couple.any():
            msg = (
                f"{who} pushes along {np.round(direction, 4).tolist()} or has couples; a local mechanism is checked "
                "for horizontal forces (C8.7.1.2.1.1): give forces along one horizontal direction"
            )
            raise ModelError(msg)
        acts = ~np.array([b.fixed for b in model.blocks])[found.block] & found.force.any(axis=1)
        block, point, force = _summed(found.block[acts], found.point[acts], found.force[acts])
        along = force @ direction
        across = np.linalg.norm(force - along[:, None] * direction, axis=1)
        if np.any(across > NEGLIGIBLE * np.abs(along).max()) or np.any(along < 0):
            msg = (
                f"{who} has forces across or against its push along {np.round(direction, 4).tolist()}; give forces "
                "along one horizontal direction, each as the weight of a mass times the share of the BodyForce"
            )
            raise ModelError(msg)
        return cls(direction, share, block, point, along / share)

    def displacements(self, model: Model, mechanism: xr.Dataset) -> Array:
        """Return the displacement (n,) of each force along the push in a mechanism."""
        return np.asarray(velocities(model, twists(mechanism), self.block, self.point) @ self.direction)


def _summed(block: Index, point: Array, force: Array) -> tuple[Index, Array, Array]:
    """Return forces with one block and one point added up, as several loads may push one mass."""
    _, first, which = np.unique(np.column_stack([block, point]), axis=0, return_index=True, return_inverse=True)
    total = np.zeros((len(first), 3))
    np.add.at(total, which.reshape(-1), force)
    order = np.argsort(first)
    return block[first[order]], point[first[order]], total[order]


@dataclass(frozen=True, slots=True)
class Participation:
    """Weights P + Q and displacements δ along the push of bodies, and the quantities that follow.

    Attributes
    ----------
    names : tuple of str
    weight : (N,) array
        N.
    displacement : (N,) array
        Scaled to a largest one of 1.
    scale : float
        Divisor of the displacements.
    left_out : Participation or None
        Moving bodies whose centroids hardly move along the push; no sum counts them.
    """

    names: tuple[str, ...]
    weight: Array
    displacement: Array
    scale: float
    left_out: Self | None = None

    @classmethod
    def of(cls, names: Sequence[str], groups: Sequence[Index], weight: Array, displacement: Array) -> Self:
        """Return the participation of groups of forces; a group without weight takes no part."""
        total = np.array([weight[group].sum() for group in groups])
        heavy = np.flatnonzero(total > 0).tolist()
        mean = np.array([np.dot(weight[groups[k]], displacement[groups[k]]) / total[k] for k in heavy])
        largest = np.abs(mean).max(initial=0.0)
        if not largest > 0:
            msg = "no mass moves along the push in this mechanism; push the structure where it moves"
            raise ModelError(msg)
        return cls(tuple(names[k] for k in heavy), total[heavy], mean / largest, float(largest))

    def without_next_to_rest(self) -> Self:
        """Return the participation without bodies whose δ is negligible.

        Their work vanishes with δ, but e* counts their whole weight in Σ (P + Q): a body that turns about a point near
        its centroid would raise a0*. Leaving out bodies with at most half of the mean δ of all weights never lowers e*.
        With the mean m and s = Σ (P + Q) δ² / Σ (P + Q) δ, ln e* grows by (1 − 2 δ/m + δ²/(m s)) / Σ (P + Q) for each
        unit of weight left out. This is above zero for δ ≤ m/2, and m grows with it. If almost all weight hardly moves,
        the mean may be less: then the larger e* counts.
        """
        rests = np.abs(self.displacement) <= TOGETHER
        if not rests.any():
            return self
        taking_part = replace(self._only(~rests), left_out=self._only(rests))
        return taking_part if taking_part.e_star >= self.e_star else self

    def parted(self) -> tuple[Self, Self]:
        """Return the participation of the bodies with more than half of the mean δ of those, and of the others.

        Leaving out the others never lowers e*: see :meth:`without_next_to_rest`.
        """
        kept = np.ones(len(self.weight), dtype=bool)
        while True:
            mean = self.weight[kept] @ self.displacement[kept] / self.weight[kept].sum()
            fast = kept & (self.displacement > mean / 2)
            # Without a mean along the push there is no body to prefer.
            if not fast.any() or (fast == kept).all():
                return self._only(kept), self._only(~kept)
            kept = fast

    def _only(self, which: Flags) -> Self:
        names = tuple(name for name, one in zip(self.names, which, strict=True) if one)
        return replace(self, names=names, weight=self.weight[which], displacement=self.displacement[which])

    @property
    def each(self) -> list[tuple[str, float, float]]:
        """Name, P + Q and δ of every body."""
        return list(zip(self.names, self.weight.tolist(), self.displacement.tolist(), strict=True))

    @property
    def total(self) -> float:
        """Σ (P + Q), N."""
        return float(self.weight.sum())

    @property
    def M_star(self) -> float:
        """Mass that takes part, ``[Σ (P + Q) δ]² / (g Σ (P + Q) δ²) = e* Σ (P + Q) / g``, kg."""
        return float(self.e_star * self.total / STANDARD_GRAVITY)

    @property
    def e_star(self) -> float:
        """Share of the mass that takes part, ``[Σ (P + Q) δ]² / (Σ (P + Q) Σ (P + Q) δ²)``, [C8.7.1.5]."""
        return float(self._first**2 / (self.total * self._second))

    @property
    def factor(self) -> float:
        """``Σ (P + Q) δ² / Σ (P + Q) δ``: displacement of the oscillator at δ = 1, [C8.7.1.4]."""
        return float(self._second / self._first)

    @property
    def _first(self) -> float:
        return float(self.weight @ self.displacement)

    @property
    def _second(self) -> float:
        return float(self.weight @ self.displacement**2)

    def lines(self, of: str) -> list[Line]:
        """Return the lines on M* and e* with their numbers."""
        W, first, second = (shown(force / 1e3, "kN") for force in (self.total, self._first, self._second))
        e = f"e* = [Σ(P+Q)δ]² / (Σ(P+Q) Σ(P+Q)δ²) = ({first})² / ({W} · {second}) = {shown(self.e_star)}"
        M = f"[Σ(P+Q)δ]² / (g Σ(P+Q)δ²) = ({first})² / (g · {second})"
        return [
            Line(f"share of the mass, {of}", e, "C8.7.1.2.1.3 (C8.7.1.5)"),
            Line(f"mass, {of}", f"M* = {M} = {shown(self.M_star / 1e3, 't')}", "C8.7.1.2.1.3"),
        ]


def of_bodies(
    model: Model, forces: HorizontalForces, mechanism: xr.Dataset, bodies: Sequence[MacroBlock]
) -> tuple[Participation, Participation]:
    """Return the participation of macro-blocks, and of their blocks one by one."""
    index = model.block_index
    delta = forces.displacements(model, mechanism)
    moving = [body for body in bodies if body.moves]
    of_body = [np.flatnonzero(np.isin(forces.block, [index[name] for name in body.blocks])) for body in moving]
    whole = Participation.of([body.name for body in moving], of_body, forces.weight, delta).without_next_to_rest()
    names = [name for body in taking_part(bodies, whole) for name in body.blocks]
    of_block = [np.flatnonzero(forces.block == index[name]) for name in names]
    return whole, Participation.of(names, of_block, forces.weight, delta)


def taking_part(bodies: Sequence[MacroBlock], whole: Participation) -> list[MacroBlock]:
    """Return the moving bodies that the sums count."""
    left_out = whole.left_out.names if whole.left_out else ()
    return [body for body in bodies if body.moves and body.name not in left_out]
