"""The collapse mechanism, and the bodies in it: blocks that move together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr

from blockstruct.arrays import SLIGHT, Array, Index
from blockstruct.model import LoadPattern, Model, tie_segments
from blockstruct.results.history import motions_in
from blockstruct.results.interfaces import AT_REST, block_pairs
from blockstruct.statics.carried import carried_weights
from blockstruct.vocabulary import AXES

#: Relative velocity at a joint below which its blocks move together, relative to the largest velocity of any joint.
TOGETHER = 0.02
#: Unit of each vector of a body.
_UNITS = {"centroid": "meter", "translation": "dimensionless", "rotation": "radian / meter", "axis": "meter"}


def largest_motion(history: xr.Dataset) -> float:
    """Return the velocity that scales the mechanism, m/s; one at rest.

    The last iteration counts.
    """
    from scipy.spatial import cKDTree

    u = motions_in(history.isel(iteration=-1))
    arms, _ = cKDTree(history["contact_point_position"].to_numpy()).query(history["block_position"].to_numpy())
    translation, turning = np.linalg.norm(u[:, :3], axis=1).max(), (arms * np.linalg.norm(u[:, 3:], axis=1)).max()
    largest = float(translation if translation > SLIGHT * turning else turning)
    return largest if largest > 0 else 1.0


def mechanism(history: xr.Dataset) -> xr.Dataset:
    """Return the mechanism of the last iteration, scaled.

    The largest translation of a centroid is one.

    If all centroids rest within rounding, rotations set the scale. Each rotation is multiplied by the distance from
    the block's centroid to the nearest contact point. The largest product is then one.

    Parameters
    ----------
    history
        History of a case.

    Returns
    -------
    xarray.Dataset
        ``translation`` of the centroid and ``rotation`` about it (small-angle vector) of every block, global
        axes. With a translation in metres, the rotation is in radians per metre of the largest motion.

    Raises
    ------
    IndexError
        If the history has no iterations.
    """
    u = motions_in(history.isel(iteration=-1)) / largest_motion(history)
    dims = ("block", "axis")
    return xr.Dataset(
        {
            "translation": (dims, u[:, :3], {"units": "dimensionless", "long_name": "translation of the centroid"}),
            "rotation": (dims, u[:, 3:], {"units": "radian / meter", "long_name": "rotation about the centroid"}),
        },
        coords={"block": history["block"], "axis": np.array(AXES, dtype=object)},
    )


def twists(mechanism: xr.Dataset) -> Array:
    """Return translations and rotations (B, 6) of the blocks in a mechanism."""
    return np.hstack([mechanism[name].transpose("block", "axis").to_numpy() for name in ("translation", "rotation")])


def velocities(model: Model, motion: Array, blocks: Index, points: Array) -> Array:
    """Return the velocities (…, 3) of points (…, 3), m, of blocks (…,) by index, in a motion (B, 6) of the blocks."""
    arms = points - np.array([block.centroid for block in model.blocks])[blocks]
    return np.asarray(motion[blocks, :3] + np.cross(motion[blocks, 3:], arms))


def with_motion(model: Model, history: xr.Dataset, motion: Array) -> xr.Dataset:
    """Return the last iteration with another motion of the blocks, (blocks, 6) as in :func:`motions_in`."""
    last = history.isel(iteration=[-1]).load().copy()
    index, of_point = model.block_index, last["interface_of_contact_point"].to_numpy()
    minus, plus = block_pairs(model)[of_point].T
    points, frame = last["contact_point_position"].to_numpy(), last["interface_frame"].to_numpy()[of_point]
    of_sides = [velocities(model, motion, blocks, points) for blocks in (minus, plus)]
    apart = np.einsum("kij,kj->ki", frame, of_sides[1] - of_sides[0])
    values: dict[str, tuple[tuple[str, ...], Array]] = {
        "block_velocity": (("iteration", "block", "axis"), motion[None, :, :3]),
        "block_angular_velocity": (("iteration", "block", "axis"), motion[None, :, 3:]),
        "relative_velocity": (("iteration", "contact_point", "component"), apart[None]),
    }
    if model.ties:
        ties = tie_segments(model.ties, model.blocks)
        start, end = (np.array([getattr(tie, name) for tie in ties]) for name in ("start", "end"))
        along = (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
        blocks = np.array([[index[name] for name in tie.blocks] for tie in ties])
        at_start, at_end = (velocities(model, motion, blocks[:, k], end) for k, end in enumerate((start, end)))
        rate = np.einsum("ta,ta->t", along, at_end - at_start)
        values["tie_elongation_rate"] = (("iteration", "tie"), rate[None])
    for name, (dims, array) in values.items():
        last[name] = (dims, array, last[name].attrs)
    return last


@dataclass(frozen=True, slots=True)
class MacroBlock:
    """Free blocks that move as one body.

    Attributes
    ----------
    name : str
        ``"body 1"``, ``"body 2"`` … for moving bodies, ``"at rest 1"`` … for others; the heaviest first.
    blocks : tuple of str
        In the order of the model.
    weight : float
        Weight of the blocks themselves, N.
    carried : float
        Weight of the masses that the blocks carry and a mass-proportional push moves, N.
    centroid : (3,) array
        Centroid of the blocks themselves, m.
    translation : (3,) array
        Translation of the centroid, in the scale of the mechanism.
    rotation : (3,) array
        Rotation about the centroid, radian per metre in that scale.
    speed : float
        Largest velocity of a corner of its joints, relative to the largest at any joint.
    departure : float
        Largest velocity of a block's centroid relative to the rigid motion of the body, relative to the same velocity.
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
        """Weight P + Q of the blocks and the masses they carry, N."""
        return self.weight + self.carried

    @property
    def moves(self) -> bool:
        """Whether the body takes part in the mechanism."""
        return self.speed > AT_REST

    @property
    def axis(self) -> tuple[Array, Array] | None:
        """Direction and nearest point (m) of the axis; None if the body slides.

        A body slides if its rotation in radians is at most a thousandth of its translation in metres.
        """
        turning = float(np.linalg.norm(self.rotation))
        moved = float(np.linalg.norm(self.translation))
        if turning <= SLIGHT * moved:
            return None
        return self.rotation / turning, self.centroid + np.cross(self.rotation, self.translation) / turning**2


def body_table(bodies: Sequence[MacroBlock]) -> pd.DataFrame:
    """Return the motion of bodies as a table, one row per body.

    Returns
    -------
    DataFrame
        ``blocks`` (their number), ``weight`` and ``carried``; ``centroid``, ``translation``, ``rotation`` and ``axis``
        (a point of the axis) along x, y and z. ``table.attrs["units"]`` has the units.
    """
    rows = []
    for body in bodies:
        point = np.full(3, np.nan) if body.axis is None else body.axis[1]
        vectors = zip(_UNITS, (body.centroid, body.translation, body.rotation, point), strict=True)
        columns = {f"{name}_{axis}": float(v) for name, vector in vectors for axis, v in zip(AXES, vector, strict=True)}
        rows.append({"body": body.name, "blocks": len(body.blocks), "weight": body.weight, "carried": body.carried})
        rows[-1] |= columns
    table = pd.DataFrame(rows).set_index("body") if rows else pd.DataFrame()
    table.attrs["units"] = {"weight": "newton", "carried": "newton"}
    table.attrs["units"] |= {f"{name}_{axis}": unit for name, unit in _UNITS.items() for axis in AXES}
    return table


def macro_blocks(model: Model, mechanism: xr.Dataset, dead: LoadPattern | None = None) -> list[MacroBlock]:
    """Return the bodies of a mechanism, moving or at rest, the heaviest first.

    Two blocks belong to one body if their relative velocity is at most 2 % of the largest velocity of any joint, at all
    corners of a joint between them. It includes opening, sliding and turning.

    Parameters
    ----------
    model
        The structure.
    mechanism
        Its mechanism: :func:`blockstruct.results.mechanism`.
    dead
        The dead load, whose weights the blocks carry. Without it, blocks carry no weights.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    index = model.block_index
    centroids = np.array([b.centroid for b in model.blocks])
    motion = twists(mechanism)
    translation, rotation = motion[:, :3], motion[:, 3:]
    minus, plus = block_pairs(model).T
    counts = [len(i.polygon) for i in model.interfaces]
    starts = np.cumsum([0, *counts[:-1]])
    corners = np.concatenate([i.polygon for i in model.interfaces])

    at_minus, at_plus = (velocities(model, motion, np.repeat(side, counts), corners) for side in (minus, plus))
    speeds = np.maximum.reduceat(np.linalg.norm([at_minus, at_plus], axis=-1), starts, axis=-1)
    largest = max(float(speeds.max()), np.finfo(float).tiny)
    apart = np.maximum.reduceat(np.linalg.norm(at_plus - at_minus, axis=-1), starts)
    fixed = np.array([b.fixed for b in model.blocks])
    joined = (apart <= TOGETHER * largest) & ~fixed[minus] & ~fixed[plus]
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
    bodies: list[MacroBlock] = []
    for members in members_of:
        # Bodies without weight have a motion, too.
        mass = weights[members] if weights[members].sum() > 0 else np.ones(len(members))
        mass = mass / mass.sum()
        centroid, turn = mass @ centroids[members], mass @ rotation[members]
        moved = mass @ (translation[members] + np.cross(rotation[members], centroid - centroids[members]))
        off = translation[members] - moved - np.cross(turn, centroids[members] - centroid)
        speed = float(speed_of_block[members].max())
        kind = "body" if speed > AT_REST else "at rest"
        bodies.append(
            MacroBlock(
                name=f"{kind} {1 + sum(one.name.startswith(kind) for one in bodies)}",
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
    return bodies
