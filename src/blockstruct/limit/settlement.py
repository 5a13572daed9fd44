"""Model the degree of freedom in which supports settle."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from blockstruct.arrays import Array, Index
from blockstruct.errors import ModelError, UnknownNameError
from blockstruct.model import Model, SettlementCase
from blockstruct.statics.equilibrium import equilibrium_matrix
from blockstruct.statics.statics import Statics
from blockstruct.statics.wrenches import wrenches
from blockstruct.vocabulary import listed


@dataclass(frozen=True, slots=True)
class Settlement:
    """Supports that move as one rigid body, and the unit of their reaction.

    The reaction R replaces the variable load. ``A`` has one more row: the work of the joints on the unit motion ŵ of
    the supports, ``ŵᵀ B x + α w_L = 0``. R is ``−α`` times :attr:`reaction_unit`, so that the largest α gives the least
    reaction. The velocity of this row is the velocity of the supports along ŵ.

    Attributes
    ----------
    supports : (S,) array
        Indices of the blocks.
    motion : (S, 6) array
        Velocity, m/s, and angular velocity, rad/s, of each support at unit speed. Unit speed of a rotation is one
        characteristic length per second at one characteristic length from the axis.
    row : (3 K,) array
        Work of a unit force at each contact point on this motion.
    tie_row : (M,) array
        Work of a unit force in each tie on this motion.
    force : float
        Unit of the row, N: the mean dead wrench of the free blocks.
    reaction_unit : float
        Reaction at α = −1, N or N·m: :func:`reaction_unit`.
    rotates : bool
        Whether the reaction is a moment.
    """

    supports: Index
    motion: Array
    row: Array
    tie_row: Array
    force: float
    reaction_unit: float
    rotates: bool

    @classmethod
    def of(cls, statics: Statics, case: SettlementCase, wrench_unit: Array) -> Self:
        """Return the settlement of a case.

        ``wrench_unit`` (F,) are the units of the wrenches of the free blocks, N.

        Raises
        ------
        UnknownNameError
            If the model does not have a support.
        ModelError
            If a support is a free block, or the supports carry nothing.
        """
        who, blocks = f"settlement case {case.name!r}", statics.model.blocks
        supports = np.array([_support(statics, who, name) for name in case.supports])
        centroids = np.array([b.centroid for b in blocks])
        direction, turn = np.array(case.direction), np.zeros(3)
        if case.about is not None:
            turn = direction / statics.length
        along = direction if case.about is None else np.cross(turn, centroids[supports] - np.array(case.about))
        motion = np.hstack([np.broadcast_to(along, (len(supports), 3)), np.broadcast_to(turn, (len(supports), 3))])
        tie_row = motion.ravel() @ statics.ties.columns(centroids, supports, 1.0)
        touched = np.isin(supports, [*statics.points.minus, *statics.points.plus]).any()
        if not touched and not tie_row.any():
            msg = (
                f"{who}: no interface touches {listed(case.supports)} and no tie pulls along the motion, nothing is "
                "held by what settles; name the supports that carry the structure"
            )
            raise ModelError(msg)
        return cls(
            supports=supports,
            motion=motion,
            row=motion.ravel() @ equilibrium_matrix(statics.points, centroids, supports, 1.0),
            tie_row=tie_row,
            force=float(wrench_unit.mean()),
            reaction_unit=reaction_unit(statics.model, case),
            rotates=case.about is not None,
        )

    @property
    def speed(self) -> float:
        """Largest speed in unit motion, m/s.

        It is the largest speed of a contact point of the supports, or of the lengthening of a tie.
        """
        at_ties = np.abs(self.tie_row).max(initial=0.0)
        return float(np.linalg.norm(self.row.reshape(-1, 3), axis=1).max(initial=at_ties))

    def reaction(self, alpha: Array) -> Array:
        """Return the reactions at load factors, N or N·m."""
        return np.asarray(-alpha * self.reaction_unit + 0.0)


def reaction_unit(model: Model, case: SettlementCase) -> float:
    """Return the sum of the dead wrenches of the free blocks, N.

    For a rotation it is multiplied by the characteristic length, N·m.
    """
    length = model.characteristic_length
    free = np.array([not b.fixed for b in model.blocks])
    dead = wrenches(model, case.dead, case.dead)[free] / np.repeat([1.0, length], 3)
    return float(np.linalg.norm(dead, axis=1).sum()) * (1.0 if case.about is None else length)


def _support(statics: Statics, who: str, name: str) -> int:
    model = statics.model
    fixed = [b.name for b in model.blocks if b.fixed]
    for i, block in enumerate(model.blocks):
        if block.name == name and block.fixed:
            return i
        if block.name == name:
            msg = f"{who}: block {name!r} is free; name supports, which are {listed(fixed)}"
            raise ModelError(msg)
    msg = f"{who}: model {model.name!r} has no support {name!r}; it has {listed(fixed)}"
    raise UnknownNameError(msg)
