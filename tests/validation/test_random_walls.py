"""Walls with random openings under lintels: every one must end with a certificate, and in any direction.

No published values: the associative program is the upper bound, and a rigid motion may change nothing.
"""

from itertools import pairwise

import numpy as np
import pytest

import blockstruct as bs
from structures import model_of, moved, push, rotation, solve


def wall_with_openings(seed):
    """Rows in running bond with up to three openings, each bridged by one lintel."""
    rng = np.random.default_rng(seed)
    width, height = 2 * int(rng.integers(4, 10)), int(rng.integers(6, 15))
    void, lintels = np.zeros((height, width), dtype=bool), {}
    for _ in range(rng.integers(1, 4)):
        w, h = int(rng.choice([2, 3, 4])), int(rng.integers(2, 6))
        x, z = int(rng.integers(2, max(3, width - w - 1))), int(rng.integers(0, max(1, height - h - 1)))
        if x + w + 1 > width or z + h >= height or void[max(z - 1, 0) : z + h + 1, max(x - 2, 0) : x + w + 2].any():
            continue
        void[z : z + h, x : x + w] = True
        lintels.setdefault(z + h, []).append((x - 1, x + w + 1))
    rows = []
    for j in range(height):
        unit = (np.arange(width) + j % 2) // 2
        for k, (start, stop) in enumerate(lintels.get(j, ())):
            unit[start:stop] = 1000 + k
        unit[void[j]] = -1
        edges = [0, *(np.flatnonzero(np.diff(unit)) + 1), width]
        rows.append([(b - a) / 2 * (-1 if unit[a] < 0 else 1) for a, b in pairwise(edges)])
    return rows


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(60))
def test_converges_in_every_direction(seed, tuff, dry):
    blocks = bs.courses(
        wall_with_openings(seed), unit_length="0.4 m", unit_height="0.175 m", depth="0.1 m", material=tuff
    )
    model = model_of(blocks, dry)
    upper, lower = (solve(model, push(1, 0, 0), flow) for flow in bs.Flow)
    assert upper.status == lower.status == "converged"
    assert 0.5 * upper.load_factor < lower.load_factor <= upper.load_factor * (1 + 1e-6)
    assert lower.n_iterations <= 40

    R = rotation((1, 2, 3), 0.1 + seed)
    dead = bs.LoadPattern("dead", [bs.BodyForce(R @ [0, 0, -1])])
    turned = solve(model_of(moved(blocks, R), dry), push(*(R @ [1, 0, 0])), "nonassociative", dead)
    assert turned.load_factor == pytest.approx(lower.load_factor, rel=1e-3)
