"""Loads on blocks, and load patterns: named sums of them."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import ModelError, shown
from blockstruct.keywords import checked_keywords
from blockstruct.model.block import Block
from blockstruct.model.checks import checked_name, checked_tuple
from blockstruct.units import VectorLike, si, si_vector

Vector = tuple[float, float, float]

_AXES = {
    f"{sign}{axis}": tuple(float(f"{sign}{int(k == j)}") + 0.0 for k in range(3))
    for j, axis in enumerate("xyz")
    for sign in "+-"
}
#: How far from 1 the length of a typed direction may be, and that of one that is left as it is.
_LENGTH, _ROUNDING = 1e-3, 1e-12


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
    direction : three floats or str
        Of length 1, or the name of an axis: ``(1, 0, 0)`` and ``"+x"`` are the same. A vector of another length would
        scale the load factor unseen and is refused.
    share : float
        Force in multiples of each block's weight.

    Raises
    ------
    ModelError
        A direction that is zero or not of length 1, or a share that is zero.

    Examples
    --------
    >>> BodyForce("-y").direction
    (0.0, -1.0, 0.0)
    >>> BodyForce((0.6, 0.8, 0), share=0.5).share
    0.5
    """

    direction: Vector
    share: float

    def __init__(self, direction: VectorLike, share: Any = 1.0) -> None:
        if isinstance(direction, str) and direction.strip() in _AXES:
            direction = _AXES[direction.strip()]
        vector = si_vector(direction, "dimensionless", "BodyForce: direction")
        length = math.hypot(*vector)
        if length == 0:
            msg = f"BodyForce: direction {vector} is zero; give a direction such as (1, 0, 0) or '+x'"
            raise ModelError(msg)
        if abs(length - 1) > _LENGTH:
            msg = (
                f"BodyForce: direction {vector} has the length {length:.6g}, not 1; give a direction of length 1, and "
                f"share={length:.6g} if {length:.6g} times the weight is meant"
            )
            raise ModelError(msg)
        if abs(length - 1) > _ROUNDING:
            vector = (vector[0] / length, vector[1] / length, vector[2] / length)
        of_weight = si(share, "dimensionless", "BodyForce: share")
        if of_weight == 0:
            msg = "BodyForce: share 0; give a share of the weight that acts"
            raise ModelError(msg)
        object.__setattr__(self, "direction", vector)
        object.__setattr__(self, "share", of_weight)


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

    def __init__(self, block: str, point: VectorLike, force: VectorLike) -> None:
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

    def __init__(self, block: str, face: int, traction: VectorLike) -> None:
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

    def __init__(self, block: str, moment: VectorLike) -> None:
        who = f"Moment on {checked_name(block, 'block')!r}"
        object.__setattr__(self, "block", block)
        object.__setattr__(self, "moment", si_vector(moment, "moment", f"{who}: moment"))


Load = SelfWeight | BodyForce | PointLoad | FaceLoad | Moment


@dataclass(frozen=True, slots=True)
class LoadKind:
    """What documents and files need to know of a kind of load.

    Parameters
    ----------
    type
        Its class, whose constructor takes ``named`` and then ``vectors``.
    vectors
        Dimension of each vector, a key of :data:`blockstruct.units.SI_UNITS`.
    named
        Attributes that are names or indices.
    scalars
        Plain numbers, with their defaults.
    """

    type: Callable[..., Load]
    vectors: Mapping[str, str]
    named: tuple[str, ...] = ()
    scalars: Mapping[str, float] = field(default_factory=dict)


#: The one table of loads: kind of each, as documents and files write it.
LOAD_KINDS: Mapping[str, LoadKind] = MappingProxyType(
    {
        "self_weight": LoadKind(SelfWeight, {}),
        "body_force": LoadKind(BodyForce, {"direction": "dimensionless"}, scalars={"share": 1.0}),
        "point_load": LoadKind(PointLoad, {"point": "length", "force": "force"}, ("block",)),
        "face_load": LoadKind(FaceLoad, {"traction": "stress"}, ("block", "face")),
        "moment": LoadKind(Moment, {"moment": "moment"}, ("block",)),
    }
)
_KINDS = {kind.type: name for name, kind in LOAD_KINDS.items()}


def kind_of(load: Load) -> str:
    """Kind of a load: a key of :data:`LOAD_KINDS`."""
    return _KINDS[type(load)]


@checked_keywords
@dataclass(frozen=True, slots=True, init=False)
class LoadPattern:
    """A named sum of loads.

    Parameters
    ----------
    name
        Unique among the patterns of an analysis.
    loads
        SelfWeight, BodyForce, PointLoad, FaceLoad or Moment, in any number.

    Examples
    --------
    >>> LoadPattern("dead", [SelfWeight()]).loads
    (SelfWeight(),)
    """

    name: str
    loads: tuple[Load, ...]

    def __init__(self, name: str, loads: Iterable[Load]) -> None:
        checked_name(name, "load pattern")
        loads = checked_tuple(loads, Load, f"load pattern {name!r}: loads")
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "loads", loads)

    def applied(self, blocks: Sequence[Block]) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """Index of the block (n,), point (n, 3) in m and force (n, 3) in N of every force; couples have none.

        Weight and body forces are those of the blocks that are no supports, at their centroids.
        """
        index = {b.name: i for i, b in enumerate(blocks)}
        free = [i for i, b in enumerate(blocks) if not b.fixed]
        forces: list[tuple[int, Any, Any]] = []
        for load in self.loads:
            match load:
                case SelfWeight():
                    forces += [(i, blocks[i].centroid, (0.0, 0.0, -blocks[i].weight)) for i in free]
                case BodyForce(direction=direction, share=share):
                    forces += [(i, blocks[i].centroid, share * blocks[i].weight * np.array(direction)) for i in free]
                case PointLoad(block=name, point=point, force=force):
                    forces.append((index[name], point, force))
                case FaceLoad(block=name, face=face, traction=traction):
                    shape = blocks[index[name]].shape
                    forces.append((index[name], shape.face_centroid(face), shape.areas[face] * np.array(traction)))
        of_block, points, vectors = zip(*forces, strict=True) if forces else ((), (), ())
        return (
            np.array(of_block, dtype=np.int64),
            np.array(points, dtype=float).reshape(-1, 3),
            np.array(vectors, dtype=float).reshape(-1, 3),
        )
