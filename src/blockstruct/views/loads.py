"""Where the loads of a pattern act, as a view draws them."""

import numpy as np
from numpy.typing import NDArray

import blockstruct as bs

Array = NDArray[np.float64]


def applied(pattern: bs.LoadPattern, model: bs.Model, dead: bs.LoadPattern) -> tuple[Array, Array]:
    """Points (n, 3) in m and forces (n, 3) in N of a load pattern on free blocks; couples have neither.

    A mass-proportional force takes along the weights of the dead load.
    """
    found = bs.results.applied_loads(model, pattern, dead)
    free = np.array([not b.fixed for b in model.blocks])
    acts = free[found.block] & found.force.any(axis=1)
    return found.point[acts], found.force[acts]


def driving(result: bs.CaseResult) -> tuple[Array, Array]:
    """Points (n, 3) in m and vectors (n, 3) of what drives a case: the variable load in N, or supports that give way.

    Of supports the vectors are their motion. A support that turns has none: its reaction is a couple.
    """
    case = result.case
    if not isinstance(case, bs.SettlementCase):
        return applied(case.variable, result.model, case.dead)
    points = np.array([result.model.block(name).centroid for name in case.supports])
    motion = np.array(case.direction if case.about is None else (0.0, 0.0, 0.0))
    return points, np.broadcast_to(motion, points.shape)


def push(result: bs.CaseResult) -> Array:
    """Unit vector (3,) of the resultant of what drives a case; zero where its forces cancel."""
    _, forces = driving(result)
    total = forces.sum(axis=0)
    size = float(np.linalg.norm(total))
    return total / size if size > 1e-9 * np.linalg.norm(forces, axis=1).sum() else np.zeros(3)
