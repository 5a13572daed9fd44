"""Wrenches of load patterns."""

import numpy as np
from numpy.typing import NDArray

from blockstruct.errors import ModelError, UnknownNameError
from blockstruct.model import Block, BodyForce, FaceLoad, LoadPattern, Model, Moment, PointLoad, SelfWeight

Array = NDArray[np.float64]


def wrenches(model: Model, pattern: LoadPattern) -> Array:
    """Force (N) and moment about the centroid (N·m) of a load pattern on every block, shape (B, 6).

    Loads that cancel on a block but for rounding count as zero.

    Raises
    ------
    UnknownNameError
        If a load acts on a block that the model does not have.
    ModelError
        If a face load acts on a face that its block does not have, or a point load away from its block.
    """
    weight = np.array([b.weight for b in model.blocks])
    index = {b.name: i for i, b in enumerate(model.blocks)}
    w = np.zeros((len(model.blocks), 6))
    # Sums of the magnitudes, whose rounding is what is left where loads cancel.
    gross = np.zeros((len(model.blocks), 2))

    def at(load: PointLoad | FaceLoad | Moment) -> int:
        if load.block not in index:
            names = list(index)
            msg = (
                f"load pattern {pattern.name!r}: {type(load).__name__} on block {load.block!r}, which model "
                f"{model.name!r} does not have; it has {', '.join(names[:10])}{', …' if len(names) > 10 else ''}"
            )
            raise UnknownNameError(msg)
        return index[load.block]

    def add_force(i: int, point: Array, force: Array) -> None:
        centroid, size = model.blocks[i].centroid, float(np.linalg.norm(force))
        w[i, :3] += force
        w[i, 3:] += np.cross(point - centroid, force)
        gross[i] += size, (np.linalg.norm(point) + np.linalg.norm(centroid)) * size

    for load in pattern.loads:
        match load:
            case SelfWeight():
                w[:, 2] -= weight
                gross[:, 0] += weight
            case BodyForce(direction=direction, share=share):
                w[:, :3] += share * weight[:, None] * np.array(direction)
                gross[:, 0] += abs(share) * weight
            case Moment(moment=moment):
                w[at(load), 3:] += moment
                gross[at(load), 1] += np.linalg.norm(moment)
            case PointLoad(point=point, force=force):
                i = at(load)
                _check_on_block(model.blocks[i], point, pattern.name)
                add_force(i, np.array(point), np.array(force))
            case FaceLoad(face=face, traction=traction):
                i = at(load)
                shape = model.blocks[i].shape
                if face >= len(shape.faces):
                    msg = (
                        f"load pattern {pattern.name!r}: FaceLoad on face {face} of block {load.block!r}, "
                        f"which has faces 0..{len(shape.faces) - 1}"
                    )
                    raise ModelError(msg)
                centre = shape.face_centroid(face)
                add_force(i, centre, shape.areas[face] * np.array(traction))
    rounding = 4 * max(len(pattern.loads), 4) * np.finfo(float).eps * gross
    for column, part in enumerate((slice(0, 3), slice(3, 6))):
        w[np.linalg.norm(w[:, part], axis=1) <= rounding[:, column], part] = 0.0
    return w


def _check_on_block(block: Block, point: tuple[float, float, float], pattern: str) -> None:
    low, high = block.shape.vertices.min(axis=0), block.shape.vertices.max(axis=0)
    slack = 1e-3 * (high - low).max()
    if np.any(point < low - slack) or np.any(point > high + slack):
        msg = (
            f"load pattern {pattern!r}: PointLoad on block {block.name!r} acts at {point} m, outside the block, which "
            f"reaches from {low.round(6).tolist()} to {high.round(6).tolist()} m; correct the point, or add a Moment "
            "for a force with a longer arm"
        )
        raise ModelError(msg)
