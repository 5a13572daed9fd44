"""The independent path against closed forms, the library against it, and random structures by every procedure.

The independent solver (``tests/support/independent_path.py``) takes implicit steps by Newton's method, with a return
mapping at every contact point. The library splits its steps. They share blocks, loads and corners of interfaces alone.
Random structures are those of ``tests/support/random_structures.py``; ``make validation`` prints the same figures.

The façade with sidewalls has no published answer. Three algorithms of independent programs, with 12 to 24 steps and
shear over normal stiffness from 0.2 to 1, found 0.264 to 0.267 with bonded sidewalls and 0.0781 with butted ones; the
fictitious iteration finds anything from 0.004 to 0.284 with bonded ones, by schedule.
"""

import math

import numpy as np
import pytest

import blockstruct as bs
import campaign
import random_structures
from independent_path import Structure, follow
from random_structures import names, structure
from structures import SELF_WEIGHT, STONE, model_of, moved, push, rotation, solve

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


#: Structures of which a run does not converge, or differs from the independent path, as the page on validation shows.
#: For some, rounding decides, and with it the processor.
MISSES = {
    "crushing 10": "the mirrored structure ends 1.8 % off: its path depends on rounding",
    "crushing 14": "the rotated structure ends 2.8 % off: its path depends on rounding",
    "dome 2": "the path with a shear ratio of 0.2 is not solved; the associative load factor is 256",
    "dome 5": "the path is not solved; the associative load factor is 117",
    "dome 8": "the path in half steps is not solved; the associative load factor is 342",
    "front 16": "the path ends at 0.389, in half steps at 0.404, the independent one at 0.407",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", names())
def test_random_structures_fail_nowhere_and_keep_to_their_bounds(name, request):
    if name in MISSES:
        request.applymarker(pytest.mark.xfail(raises=AssertionError, reason=MISSES[name]))
    found = campaign.findings(structure(name))
    bound = found.associative.load_factor

    for run in (found.path, found.fictitious, *found.variants.values()):
        assert run.status in ("converged", "unstable_under_dead_load", "unbounded")
        if run.status == "converged":
            assert run.certified
            assert run.load_factor <= bound * (1 + 1e-6)
    if found.kind == "falls":
        assert found.path.status == "unstable_under_dead_load"
    if found.exact is not None:
        for run in (found.associative, found.path, found.fictitious):
            assert run.load_factor == pytest.approx(found.exact, rel=1e-4)
    if not math.isnan(found.without_crushing):
        assert found.path.load_factor <= found.without_crushing * 1.005
    if found.path.settled:
        for variant in campaign.SAME:
            assert found.differs(variant) < 0.01, variant
        if found.exact is None and not math.isnan(found.reference):
            assert abs(found.error(found.path)) < campaign.NEAR


JOINTS = {"base|*": bs.JointMaterial("ground", 0.6), "*": bs.JointMaterial("lime mortar", 0.65)}
SETTINGS = {
    "half steps": {"path_step": 0.5, "path_growth": 3.0},
    "shear 0.2": {"shear_stiffness_ratio": 0.2},
    "shear 1": {"shear_stiffness_ratio": 1.0},
}


def facade(bonded):
    door = bs.structures.Opening(start="1.2 m", sill="0 m", width="0.8 m", height="1.6 m")
    sides = [bs.structures.Sidewall(n, at, "1.6 m", bonded=bonded) for n, at in (("left", "0 m"), ("right", "3 m"))]
    size = {"length": "3.2 m", "unit_length": "40 cm", "unit_height": "20 cm", "thickness": "20 cm"}
    tuff = bs.Material("tuff", "12 kN/m^3")
    blocks = bs.wall(**size, courses=12, openings=[door], sidewalls=sides, material=tuff)
    return random_structures.Structure("façade", "façade", blocks, JOINTS, push(0, -1, 0))


@pytest.mark.slow
@pytest.mark.parametrize("bonded", [True, False], ids=["bonded", "butted"])
@pytest.mark.parametrize("what", [*SETTINGS, "mirrored", "rotated", "renumbered", "disturbed", "again disturbed"])
def test_facade_has_one_number(bonded, what):
    case = facade(bonded)
    if what == "mirrored":
        case = case.turned(np.diag([-1.0, 1, 1]))
    elif what == "rotated":
        case = case.turned(rotation((0, 0, 1), 0.6))
    elif what == "renumbered":
        case = case.renumbered(0)
    elif what.endswith("disturbed"):
        rng = np.random.default_rng(len(what))
        case.blocks[:] = moved(case.blocks, np.eye(3) * (1 + 1e-14 * rng.normal()), 1e-13 * rng.normal(size=3))
    settings = SETTINGS.get(what, {})
    result = solve(case.model, case.variable, "nonassociative", procedure="loading path", **settings)
    assert (result.status, result.outcome.procedure) == ("converged", bs.vocabulary.Procedure.LOADING_PATH)
    assert result.certificate.flow_rule_gap <= 1e-4 * result.load_factor
    assert result.certificate.interpenetration <= 1e-4
    assert result.load_factor == pytest.approx(0.2656 if bonded else 0.0781, rel=1e-2)
