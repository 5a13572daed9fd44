"""Loads on blocks."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstruct.errors import ModelError, shown
from blockstruct.keywords import checked_keywords
from blockstruct.model.names import checked_name
from blockstruct.units import si_vector

Vector = tuple[float, float, float]


@checked_keywords
@dataclass(frozen=True, slots=True)
class SelfWeight:
    """The weight of every block, acting along −z."""


@checked_keywords
@dataclass(frozen=True, slots=True, init=False)
class BodyForce:
    """Mass-proportional force on every block, at its centroid.

    Parameters
    ----------
    direction : three floats
        Force in multiples of each block's weight: ``(1, 0, 0)`` is the weight turned to +x, and
        ``(0.5, 0, 0)`` half of it. The length counts.
    """

    direction: Vector

    def __init__(self, direction: Any) -> None:
        vector = si_vector(direction, "dimensionless", "BodyForce: direction")
        if not np.any(vector):
            msg = f"BodyForce: direction {vector} is zero; give a direction such as (1, 0, 0)"
            raise ModelError(msg)
        object.__setattr__(self, "direction", vector)


@checked_keywords
@dataclass(frozen=True, slots=True, init=False)
class PointLoad:
    """A force at a point of a block.

    Parameters
    ----------
    block
        Name of the block that carries the load.
    point : quantity, length, three components
        Where the force acts, in global coordinates; it moves with the block.
    force : quantity, force, three components

    Attributes
    ----------
    point, force
        m and N.
    """

    block: str
    point: Vector
    force: Vector

    def __init__(self, block: str, point: Any, force: Any) -> None:
        who = f"PointLoad on {checked_name(block, 'block')!r}"
        object.__setattr__(self, "block", block)
        object.__setattr__(self, "point", si_vector(point, "length", f"{who}: point"))
        object.__setattr__(self, "force", si_vector(force, "force", f"{who}: force"))


@checked_keywords
@dataclass(frozen=True, slots=True, init=False)
class FaceLoad:
    """A uniform traction on a face of a block.

    Parameters
    ----------
    block
        Name of the block that carries the load.
    face
        Index of the face in the block's list of faces.
    traction : quantity, stress, three components
        Force per area of the face, in global coordinates.

    Attributes
    ----------
    traction
        Pa.
    """

    block: str
    face: int
    traction: Vector

    def __init__(self, block: str, face: int, traction: Any) -> None:
        who = f"FaceLoad on {checked_name(block, 'block')!r}"
        if not isinstance(face, int) or face < 0:
            msg = f"{who}: face {shown(face)}; give the index of a face, zero or more"
            raise ModelError(msg)
        object.__setattr__(self, "block", block)
        object.__setattr__(self, "face", face)
        object.__setattr__(self, "traction", si_vector(traction, "stress", f"{who}: traction"))


@checked_keywords
@dataclass(frozen=True, slots=True, init=False)
class Moment:
    """A couple on a block.

    Parameters
    ----------
    block
        Name of the block that carries the couple.
    moment : quantity, moment, three components
        About the global axes, right-handed.

    Attributes
    ----------
    moment
        N·m.
    """

    block: str
    moment: Vector

    def __init__(self, block: str, moment: Any) -> None:
        who = f"Moment on {checked_name(block, 'block')!r}"
        object.__setattr__(self, "block", block)
        object.__setattr__(self, "moment", si_vector(moment, "moment", f"{who}: moment"))


Load = SelfWeight | BodyForce | PointLoad | FaceLoad | Moment
