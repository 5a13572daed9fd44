"""Where the loads of a pattern act, as a view draws them."""

import numpy as np
from numpy.typing import NDArray

import blockstruct as bs

Array = NDArray[np.float64]


def applied(pattern: bs.LoadPattern, model: bs.Model) -> tuple[Array, Array]:
    """Points (n, 3) in m and forces (n, 3) in N of a load pattern; couples have neither."""
    blocks = {b.name: b for b in model.blocks}
    free = [b for b in model.blocks if not b.fixed]
    points, forces = [], []
    for load in pattern.loads:
        match load:
            case bs.SelfWeight():
                points += [b.centroid for b in free]
                forces += [b.weight * np.array([0.0, 0.0, -1.0]) for b in free]
            case bs.BodyForce(direction=direction, share=share):
                points += [b.centroid for b in free]
                forces += [share * b.weight * np.array(direction) for b in free]
            case bs.PointLoad(point=point, force=force):
                points.append(np.asarray(point))
                forces.append(np.asarray(force))
            case bs.FaceLoad(block=name, face=face, traction=traction):
                shape = blocks[name].shape
                corners = shape.vertices[list(shape.faces[face])]
                area = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0) @ shape.normals[face] / 2
                points.append(shape.face_centroid(face))
                forces.append(area * np.asarray(traction))
    return np.array(points).reshape(-1, 3), np.array(forces).reshape(-1, 3)


def driving(result: bs.CaseResult) -> tuple[Array, Array]:
    """Points (n, 3) in m and vectors (n, 3) of what drives a case: the variable load in N, or supports that give way.

    Of supports the vectors are their motion. A support that turns has none: its reaction is a couple.
    """
    case = result.case
    if not isinstance(case, bs.SettlementCase):
        return applied(case.variable, result.model)
    points = np.array([result.model.block(name).centroid for name in case.supports])
    motion = np.array(case.direction if case.about is None else (0.0, 0.0, 0.0))
    return points, np.broadcast_to(motion, points.shape)


def push(result: bs.CaseResult) -> Array:
    """Unit vector (3,) of the resultant of what drives a case; zero where its forces cancel."""
    _, forces = driving(result)
    total = forces.sum(axis=0)
    size = float(np.linalg.norm(total))
    return total / size if size > 1e-9 * np.linalg.norm(forces, axis=1).sum() else np.zeros(3)
