"""Points and forces of load patterns, for views."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import blockstruct as bs

Array = NDArray[np.float64]

#: Least force that is drawn, relative to the largest of its pattern.
_LEAST = 0.02


@dataclass(frozen=True, slots=True)
class LoadArrows:
    """Forces of a load pattern that are drawn, without the weight of the blocks.

    Attributes
    ----------
    name : str
        Name of the pattern.
    grows : bool
        Whether the load factor multiplies it.
    block : (n,) array
        Index of the block of each force.
    point, force : (n, 3) arrays
        m and N, at a load factor of 1.
    largest, total : float
        Largest force, and resultant of all forces including the ones too small to draw, N.
    """

    name: str
    grows: bool
    block: NDArray[np.int64]
    point: Array
    force: Array
    largest: float
    total: float


def load_arrows(result: bs.CaseResult) -> list[LoadArrows]:
    """Return the forces of the dead and the variable load of a case, without patterns that have none.

    Forces below 2 % of the largest of their pattern are left out, and couples, too.
    """
    found = []
    for k, pattern in enumerate(result.case.patterns):
        carried = [load for load in pattern.loads if not isinstance(load, bs.SelfWeight)]
        block, point, force = _acting(bs.LoadPattern(pattern.name, carried), result.model, result.case.dead)
        size = np.linalg.norm(force, axis=1)
        if len(size):
            shown = size > _LEAST * size.max()
            total = float(np.linalg.norm(force.sum(axis=0)))
            arrows = (block[shown], point[shown], force[shown], float(size.max()), total)
            found.append(LoadArrows(pattern.name, k > 0, *arrows))
    return found


def applied(pattern: bs.LoadPattern, model: bs.Model, dead: bs.LoadPattern) -> tuple[Array, Array]:
    """Return points (n, 3) in m and forces (n, 3) in N of a load pattern on free blocks, without couples.

    A mass-proportional force also moves the weights of the dead load.
    """
    _, points, forces = _acting(pattern, model, dead)
    return points, forces


def _acting(pattern: bs.LoadPattern, model: bs.Model, dead: bs.LoadPattern) -> tuple[NDArray[np.int64], Array, Array]:
    """Return blocks (n,), points (n, 3) and forces (n, 3) of a load pattern on free blocks."""
    found = bs.results.applied_loads(model, pattern, dead)
    free = np.array([not b.fixed for b in model.blocks])
    acts = free[found.block] & found.force.any(axis=1)
    return found.block[acts], found.point[acts], found.force[acts]


def driving(result: bs.CaseResult) -> tuple[Array, Array]:
    """Return points (n, 3) in m and vectors (n, 3) of the variable load in N, or of moving supports.

    The vectors of supports are their motions. A support that turns has none: its reaction is a couple.
    """
    case = result.case
    if not isinstance(case, bs.SettlementCase):
        return applied(case.patterns[-1], result.model, case.dead)
    points = np.array([result.model.block(name).centroid for name in case.supports])
    motion = np.array(case.direction if case.about is None else (0.0, 0.0, 0.0))
    return points, np.broadcast_to(motion, points.shape)


def push(result: bs.CaseResult) -> Array:
    """Return the unit vector (3,) of the resultant of :func:`driving`; zero if its vectors cancel."""
    _, forces = driving(result)
    total = forces.sum(axis=0)
    size = float(np.linalg.norm(total))
    return total / size if size > 1e-9 * np.linalg.norm(forces, axis=1).sum() else np.zeros(3)
