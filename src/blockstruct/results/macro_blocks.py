"""Macro-blocks: blocks that move together in the collapse mechanism."""

from dataclasses import dataclass
from numbers import Real

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from blockstruct.errors import ModelError, shown
from blockstruct.model import LoadPattern, Model
from blockstruct.statics import carried_weights

Array = NDArray[np.float64]

#: Relative velocity at a joint below which its blocks move together, in multiples of the largest velocity of any joint.
TOGETHER = 0.02
#: Least one.
LEAST = 1e-3
#: Velocity, in the same multiples, below which a body rests.
AT_REST = 0.01


@dataclass(frozen=True, slots=True)
class MacroBlock:
    """Free blocks that move as one body.

    Attributes
    ----------
    name : str
        ``"body 1"``, ``"body 2"`` … of those that move, ``"at rest 1"`` … of the others; the heaviest first.
    blocks : tuple of str
        In the order of the model.
    weight : float
        Of the blocks themselves, N.
    carried : float
        Weight of the masses that they carry and a mass-proportional push takes along, N.
    centroid : (3,) array
        Of the blocks themselves, m.
    translation : (3,) array
        Of the centroid, in multiples of the scale of the mechanism.
    rotation : (3,) array
        About the centroid, radian per metre of that scale.
    speed : float
        Largest velocity of any corner of its joints, in multiples of the largest of all joints.
    departure : float
        Largest velocity of a centroid relative to the rigid motion of the body, in the same multiples: what calling its
        blocks one body leaves out.
    """

    name: str
    blocks: tuple[str, ...]
    weight: float
    carried: float
    centroid: Array
    translation: Array
    rotation: Array
    speed: float
    departure: float

    @property
    def total(self) -> float:
        """Weight P + Q of the blocks with what they carry, N: that of the mass M* in :mod:`blockstruct.assess`."""
        return self.weight + self.carried

    @property
    def moves(self) -> bool:
        """Whether it takes part in the mechanism."""
        return self.speed > AT_REST

    @property
    def axis(self) -> tuple[Array, Array] | None:
        """Direction of the axis it turns about and the point of it nearest to the centroid, m; None if it slides.

        A body slides if its axis lies farther away than a thousand times the motion of its centroid could tell.
        """
        turning = float(np.linalg.norm(self.rotation))
        moved = float(np.linalg.norm(self.translation))
        if turning <= 1e-3 * moved:
            return None
        return self.rotation / turning, self.centroid + np.cross(self.rotation, self.translation) / turning**2


def macro_blocks(
    model: Model, mechanism: xr.Dataset, tolerance: float = TOGETHER, dead: LoadPattern | None = None
) -> list[MacroBlock]:
    """Bodies of a mechanism, the heaviest first; those that rest are bodies too.

    Two blocks belong to one body if at no corner of a joint between them they move apart, slide or turn by more than
    the tolerance.

    Parameters
    ----------
    model
        The structure.
    mechanism
        Its mechanism: :func:`blockstruct.results.mechanism`.
    tolerance
        Relative velocity in multiples of the largest velocity at any joint, from 0.001 to 1.
    dead
        The dead load, whose weights blocks carry; without it none.

    Raises
    ------
    ModelError
        If the tolerance is less than a certified mechanism is known by, where blocks that move together fall apart.
    """
    if not isinstance(tolerance, Real) or not LEAST <= tolerance <= 1:
        msg = f"macro_blocks: tolerance {shown(tolerance)}; give a number from {LEAST:g} to 1, such as {TOGETHER:g}"
        raise ModelError(msg)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    index = {b.name: i for i, b in enumerate(model.blocks)}
    centroids = np.array([b.centroid for b in model.blocks])
    translation, rotation = (
        mechanism[name].transpose("block", "axis").to_numpy() for name in ("translation", "rotation")
    )
    minus, plus = (np.array([index[getattr(i, side)] for i in model.interfaces]) for side in ("minus", "plus"))
    counts = [len(i.polygon) for i in model.interfaces]
    starts = np.cumsum([0, *counts[:-1]])
    corners = np.concatenate([i.polygon for i in model.interfaces])

    def velocity(blocks: NDArray[np.int64]) -> Array:
        of_corner = np.repeat(blocks, counts)
        return np.asarray(translation[of_corner] + np.cross(rotation[of_corner], corners - centroids[of_corner]))

    at_minus, at_plus = velocity(minus), velocity(plus)
    speeds = np.maximum.reduceat(np.linalg.norm([at_minus, at_plus], axis=-1), starts, axis=-1)
    largest = max(float(speeds.max()), np.finfo(float).tiny)
    apart = np.maximum.reduceat(np.linalg.norm(at_plus - at_minus, axis=-1), starts)
    fixed = np.array([b.fixed for b in model.blocks])
    joined = (apart <= tolerance * largest) & ~fixed[minus] & ~fixed[plus]
    graph = coo_array((np.ones(joined.sum()), (minus[joined], plus[joined])), shape=(len(index), len(index)))
    _, body = connected_components(graph, directed=False)
    speed_of_block = np.zeros(len(index))
    for side, of_interface in zip((minus, plus), speeds, strict=True):
        np.maximum.at(speed_of_block, side, of_interface / largest)

    weights, carried = np.array([b.weight for b in model.blocks]), np.zeros(len(index))
    if dead is not None:
        on_blocks = carried_weights(model, dead)
        np.add.at(carried, on_blocks.block, on_blocks.pushed)
    members_of = [np.flatnonzero(body == number) for number in np.unique(body[~fixed])]
    members_of.sort(key=lambda members: -(weights + carried)[members].sum())
    found: list[MacroBlock] = []
    for members in members_of:
        # Bodies without weight have a motion, too.
        mass = weights[members] if weights[members].sum() > 0 else np.ones(len(members))
        mass = mass / mass.sum()
        centroid, turn = mass @ centroids[members], mass @ rotation[members]
        moved = mass @ (translation[members] + np.cross(rotation[members], centroid - centroids[members]))
        off = translation[members] - moved - np.cross(turn, centroids[members] - centroid)
        speed = float(speed_of_block[members].max())
        kind = "body" if speed > AT_REST else "at rest"
        found.append(
            MacroBlock(
                name=f"{kind} {1 + sum(one.name.startswith(kind) for one in found)}",
                blocks=tuple(model.blocks[i].name for i in members),
                weight=float(weights[members].sum()),
                carried=float(carried[members].sum()),
                centroid=centroid,
                translation=moved,
                rotation=turn,
                speed=speed,
                departure=float(np.linalg.norm(off, axis=1).max() / largest),
            )
        )
    return found
