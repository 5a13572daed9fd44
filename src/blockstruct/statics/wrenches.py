"""Turn load patterns into forces, couples and wrenches on blocks."""

from dataclasses import dataclass

import numpy as np

from blockstruct.arrays import Array, Index
from blockstruct.errors import ModelError
from blockstruct.geometry.plan import clipped, fan, products
from blockstruct.model import BodyForce, FaceLoad, LoadPattern, Model, Moment, PointLoad, SelfWeight, WeightLoad
from blockstruct.statics.carried import Placing, carried_weights


@dataclass(frozen=True, slots=True)
class AppliedLoads:
    """Forces and couples of a load pattern, grouped by load.

    Attributes
    ----------
    load, block : (n,) arrays
        Index of the load in its pattern, and index of the block.
    point : (n, 3) array, m
        Point of application of the force.
    force : (n, 3) array, N
    couple : (n, 3) array, N·m
        Couple in addition to the force.
    """

    load: Index
    block: Index
    point: Array
    force: Array
    couple: Array


def applied_loads(model: Model, pattern: LoadPattern, dead: LoadPattern | None = None) -> AppliedLoads:
    """Return the forces and couples of a load pattern on all blocks.

    The blocks include supports.

    Parameters
    ----------
    model, pattern
        The structure and the loads.
    dead
        Dead load of the case; the pattern itself by default. A :class:`~blockstruct.BodyForce` of the pattern acts on
        the masses of the weights in the dead load.

    Raises
    ------
    UnknownNameError
        If a load acts on a block that the model does not have.
    ModelError
        If a load is not on its block or its face, or if a mass-proportional variable load contains weights with a
        mass.
    """
    dead = pattern if dead is None else dead
    placing = Placing(model, pattern.name)
    weights = carried_weights(model, pattern)
    pushes = any(isinstance(load, BodyForce) for load in pattern.loads)
    masses = carried_weights(model, dead) if pushes else weights
    if pushes and dead != pattern and weights.pushed.any():
        first = pattern.loads[int(weights.load[weights.pushed > 0][0])]
        msg = (
            f"load pattern {pattern.name!r}: {type(first).__name__} has a mass that would grow with the load factor, "
            "beside a BodyForce that pushes the masses of the dead load; move it to the dead load, or give mass_share=0"
        )
        raise ModelError(msg)
    own = np.array([b.weight for b in model.blocks])
    centroid = np.array([b.centroid for b in model.blocks])
    every = np.arange(len(own))
    down = np.array([0.0, 0.0, -1.0])
    parts: list[tuple[int, Index, Array, Array, Array | None]] = []
    for k, load in enumerate(pattern.loads):
        match load:
            case SelfWeight():
                parts.append((k, every, centroid, own[:, None] * down, None))
            case BodyForce(direction=direction, share=share):
                towards = share * np.array(direction)
                parts.append((k, every, centroid, own[:, None] * towards, None))
                if len(masses):
                    parts.append((k, masses.block, masses.point, masses.pushed[:, None] * towards, None))
            case Moment(moment=moment):
                i = placing.at(load)
                parts.append((k, every[[i]], centroid[[i]], np.zeros((1, 3)), np.array([moment])))
            case PointLoad(point=point, force=force):
                problem = (
                    f"acts at {point} m, outside the block, which reaches {{reach}}; correct the point, or add a "
                    "Moment for a force with a longer arm"
                )
                at = np.array([point])
                placing.check_extent(load, at, 3, problem)
                parts.append((k, every[[placing.at(load)]], at, np.array([force]), None))
            case FaceLoad():
                points, forces = _on_face(placing, load)
                parts.append((k, np.full(len(points), placing.at(load)), points, forces, None))
            case _ if isinstance(load, WeightLoad):
                mine = weights.load == k
                block, weight = weights.block[mine], weights.weight[mine]
                parts.append((k, block, weights.point[mine], weight[:, None] * down, None))
                if weights.lateral[mine].any():
                    parts.append((k, block, weights.lateral_point[mine], weights.lateral[mine], None))
    empty = np.empty((0, 3))
    parts.append((-1, every[:0], empty, empty, None))
    return AppliedLoads(
        np.concatenate([np.full(len(block), k) for k, block, *_ in parts]),
        np.concatenate([block for _, block, *_ in parts]),
        np.concatenate([point for _, _, point, *_ in parts]),
        np.concatenate([force for *_, force, _ in parts]),
        np.concatenate([np.zeros_like(force) if couple is None else couple for *_, force, couple in parts]),
    )


def wrenches(model: Model, pattern: LoadPattern, dead: LoadPattern | None = None) -> Array:
    """Return the wrenches (B, 6) of a load pattern on all blocks.

    A wrench is a force, N, and a moment about the centroid, N·m. Loads that cancel on a block up to rounding give
    zero. Parameters and errors are the same as in :func:`applied_loads`.
    """
    return summed(model, applied_loads(model, pattern, dead))


def magnitude(model: Model, pattern: LoadPattern, dead: LoadPattern, blocks: Index, length: float) -> float:
    """Return the sum of the magnitudes of the loads on some blocks, N.

    Forces at the same point of a block are added first. Couples are divided by ``length``, m. Other parameters and
    errors are the same as in :func:`applied_loads`.
    """
    found = applied_loads(model, pattern, dead)
    on = np.isin(found.block, blocks)
    places = np.column_stack([found.block, found.point])[on]
    _, place = np.unique(places, axis=0, return_inverse=True)
    forces = np.zeros((len(places), 3))
    np.add.at(forces, place, found.force[on])
    couples = np.linalg.norm(found.couple[on], axis=1)
    return float(np.linalg.norm(forces, axis=1).sum() + couples.sum() / length)


def summed(model: Model, found: AppliedLoads) -> Array:
    """Return the wrenches (B, 6) of forces and couples about centroids.

    Units and rounding are the same as in :func:`wrenches`.
    """
    n = len(model.blocks)
    centroid = np.array([b.centroid for b in model.blocks])[found.block]
    arm, size = found.point - centroid, np.linalg.norm(found.force, axis=1)
    parts = np.hstack([found.force, np.cross(arm, found.force) + found.couple])
    w: Array = np.column_stack([np.bincount(found.block, column, minlength=n).astype(float) for column in parts.T])
    # The rounding of these sums of magnitudes is all that remains when loads cancel.
    reach = np.linalg.norm(found.point, axis=1) + np.linalg.norm(centroid, axis=1)
    turning = np.where(arm.any(axis=1), reach * size, 0.0) + np.linalg.norm(found.couple, axis=1)
    gross = [np.bincount(found.block, of, minlength=n) for of in (size, turning)]
    count = max(int(np.bincount(found.block, minlength=n).max()), 4)
    for magnitude, part in zip(gross, (slice(0, 3), slice(3, 6)), strict=True):
        w[np.linalg.norm(w[:, part], axis=1) <= 4 * count * np.finfo(float).eps * magnitude, part] = 0.0
    return w


def _on_face(placing: Placing, load: FaceLoad) -> tuple[Array, Array]:
    """Return the points, m, and forces, N, of a load on a face.

    The first is the uniform part. The second, if any, is the part that grows with depth.
    """
    shape = placing.model.blocks[placing.at(load)].shape
    if load.face >= len(shape.faces):
        msg = (
            f"load pattern {placing.pattern!r}: FaceLoad on face {load.face} of block {load.block!r}, "
            f"which has faces 0..{len(shape.faces) - 1}"
        )
        raise ModelError(msg)
    normal = shape.normals[load.face]
    points = [shape.face_centroid(load.face)]
    forces = [shape.areas[load.face] * (np.array(load.traction) - load.pressure * normal)]
    if load.unit_weight is not None and load.level is not None:
        wet = clipped(shape.vertices[list(shape.faces[load.face])], 2, load.level)
        if len(wet) >= 3:
            triangles, area = fan(wet, normal)
            depth = load.level - triangles[..., 2]
            total = products(area, depth, np.ones_like(depth)).sum()
            if total > 0:
                points.append(np.array([products(area, depth, triangles[..., k]).sum() for k in range(3)]) / total)
                forces.append(-load.unit_weight * total * normal)
    return np.array(points), np.array(forces)
