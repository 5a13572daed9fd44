"""Where the loads of a pattern act, as a view draws them."""

import numpy as np
from numpy.typing import NDArray

import blockstruct as bs

Array = NDArray[np.float64]


def applied(pattern: bs.LoadPattern, model: bs.Model) -> tuple[Array, Array]:
    """Points (n, 3) in m and forces (n, 3) in N of a load pattern; couples have neither."""
    _, points, forces = pattern.applied(model.blocks)
    return points, forces


def push(result: bs.CaseResult) -> Array:
    """Unit vector (3,) of the resultant of the variable load; zero where its forces cancel."""
    _, forces = applied(result.case.variable, result.model)
    total = forces.sum(axis=0)
    size = float(np.linalg.norm(total))
    return total / size if size > 1e-9 * np.linalg.norm(forces, axis=1).sum() else np.zeros(3)
