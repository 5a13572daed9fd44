"""One limit case of a model, non-dimensional."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.errors import ModelError
from blockstruct.model import LimitCase
from blockstruct.statics import Statics, wrenches
from blockstruct.vocabulary import Flow

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LimitProblem:
    """Equilibrium, loads and strength of one limit case, non-dimensional.

    Attributes
    ----------
    A : (6 F, 3 K) sparse array
    w_D, w_L : (6 F,) arrays
        Dead and variable wrenches of the free blocks.
    friction, cohesion, tension : (K,) arrays
        Friction coefficient μ, cohesion ``c A_k`` and tensile strength ``f_t A_k``.
    compression : (K,) array
        Compressive strength ``f_c A_k`` of a cell; infinite at corners.
    rectangles : (R, 4) array
        Corners, in turn, of the interfaces that crush as rectangles.
    capacity : (R,) array
        Their strength in pure compression, ``f_c A``.
    dilatancy : (K,) array
        tan ψ that the case flows with: the friction coefficient if associative, the joint's own otherwise.
    length, force : float
        Units of length (m) and force (N).
    """

    A: sp.csc_array
    w_D: Array  # noqa: N815 (the symbols of the formulation)
    w_L: Array  # noqa: N815
    friction: Array
    dilatancy: Array
    cohesion: Array
    tension: Array
    compression: Array
    rectangles: NDArray[np.int64]
    capacity: Array
    length: float
    force: float

    @classmethod
    def of(cls, statics: Statics, case: LimitCase) -> Self:
        """Limit problem of a case.

        Raises
        ------
        ModelError
            A variable load that is zero on every free block.
        UnknownNameError
            A load on a block that the model does not have.
        """
        scale = np.repeat([1.0, statics.length], 3)
        dead, variable = (wrenches(statics.model, p)[statics.free] / scale for p in (case.dead, case.variable))
        if not variable.any():
            msg = (
                f"limit case {case.name!r}: the variable load {case.variable.name!r} is zero on every free block; "
                "give it a load that acts, and blocks of weight above zero if it is mass-proportional"
            )
            raise ModelError(msg)
        governing = dead if dead.any() else variable
        force = float(np.linalg.norm(governing, axis=1).mean())
        points = statics.points
        return cls(
            A=statics.A,
            w_D=dead.ravel() / force,
            w_L=variable.ravel() / force,
            friction=points.friction,
            dilatancy=points.friction if case.flow is Flow.ASSOCIATIVE else points.dilatancy,
            cohesion=points.cohesion / force,
            tension=points.tension / force,
            compression=points.compression / force,
            rectangles=points.rectangles,
            capacity=(points.strength * points.area)[points.interface[points.rectangles[:, 0]]] / force,
            length=statics.length,
            force=force,
        )

    @property
    def n_points(self) -> int:
        """Number K of contact points."""
        return len(self.friction)

    @property
    def load_factor_scale(self) -> float:
        """Ratio of the total dead to the total variable load, a load factor in size; 1 without dead load."""
        return total(self.w_D) / total(self.w_L) or 1.0


def total(w: Array) -> float:
    """Sum of the magnitudes of the wrenches of all blocks."""
    return float(np.linalg.norm(w.reshape(-1, 6), axis=1).sum())
