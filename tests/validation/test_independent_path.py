"""The independent path against closed forms, and the loading path of the library against the independent one.

The independent solver (``tests/support/independent_path.py``) takes implicit steps by Newton's method, with a return
mapping at every contact point. The library splits its steps. They share blocks, loads and corners of interfaces alone.
"""

import numpy as np
import pytest

import blockstruct as bs
from independent_path import Structure, follow
from random_structures import structure
from structures import SELF_WEIGHT, STONE, model_of, push, solve

#: Structures of at most 45 blocks, pushed in plane, askew and by points; arches, vaults, ties and strengths.
SMALL = ("rubble 0", "tied 1", "arch 1", "arch 2", "arch on piers 0", "vault 0", "point load 0", "cohesion 0")


def path_of(case, cells=0):
    return follow(Structure.of(case.model, case.dead, case.variable, cells))


@pytest.mark.parametrize("number", [0, 1, 2, 4, 5, 6, 8, 10, 11])
def test_load_factors_by_hand(number):
    case = structure(f"by hand {number}")
    path = path_of(case)
    assert path.finished
    assert path.last == pytest.approx(case.exact, rel=1e-6)
    assert path.change < 1e-6


@pytest.mark.parametrize("number", [3, 9, 15])
def test_a_block_crushes_at_its_edge(number):
    # Cells bear at their centres, so that the edge of the stress block is off by half a cell: on the safe side.
    case = structure(f"by hand {number}")
    assert 0.98 * case.exact < path_of(case, 12).last < case.exact * (1 + 1e-6)


def test_what_falls_has_no_path():
    assert path_of(structure("falls 0")) is None


@pytest.mark.parametrize("seed", range(3))
def test_associative_sliding_ends_at_the_associative_load_factor(seed):
    random = np.random.default_rng(seed)
    size = {"unit_length": "0.4 m", "unit_height": "0.2 m", "thickness": "0.3 m"}
    blocks = bs.wall(length="1.2 m", courses=int(random.integers(3, 6)), material=STONE, **size)
    friction = float(random.uniform(0.3, 0.7))
    rough = bs.JointMaterial("rough", friction, dilatancy_angle=bs.Q_(float(np.arctan(friction)) * (1 - 1e-9), "rad"))
    model, load = model_of(blocks, rough), push(1, float(random.uniform(0, 0.5)), 0)
    path = follow(Structure.of(model, SELF_WEIGHT, load))
    assert path.last == pytest.approx(solve(model, load).load_factor, rel=1e-4)


@pytest.mark.parametrize("name", SMALL)
def test_the_loading_path_ends_where_the_independent_one_does(name):
    case = structure(name)
    path = path_of(case)
    result = solve(case.model, case.variable, "nonassociative", case.dead, procedure="loading path")
    assert path.finished
    assert result.load_factor == pytest.approx(path.last, rel=5e-3)
