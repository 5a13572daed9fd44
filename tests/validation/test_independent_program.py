"""Both flows of random structures against a linear program that shares only their geometry, and certificates by hand.

The associative load factor lies between those of friction pyramids inside and around the cones.
"""

import math
import warnings

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from independent import Structure, bounds, measures
from random_structures import names, structure
from structures import model_of, rotation, single_block, solve

#: Kinds of friction alone under forces, and structures of two to 24 blocks that the default run takes.
KINDS = ("arch", "arch on piers", "vault", "column", "point load", "precompressed", "falls", "jammed", "unequal")
SMALL = ["arch 1", "arch on piers 4", "column 1", "column 9", "falls 1", "jammed 1", "point load 15", "unequal 1"]
NAMES = [name for name in names() if name.rpartition(" ")[0] in KINDS]


def with_random_ties(model, seed):
    """The model with a tie or two, one of them with a prestress at times, or a bar bonded to what it runs through."""
    rng = np.random.default_rng(1000 + seed)
    free = [b for b in model.blocks if not b.fixed]
    ties = []
    for k in range(int(rng.integers(1, 3))):
        one = free[rng.integers(len(free))]
        other = next(b for b in rng.permutation(model.blocks) if b is not one)
        corners = [b.shape.vertices for b in (one, other)]
        points = [Q_(rng.dirichlet(np.ones(len(vertices))) @ vertices, "m") for vertices in corners]
        ends = zip((one.name, other.name), points, strict=True)
        force = one.weight * 10 ** rng.uniform(-1, 1)
        least = force * rng.choice([0.0, 0.0, 0.3])
        ties.append(bs.Tie(f"tie {k}", *ends, yield_force=Q_(force, "N"), prestress=Q_(least, "N")))
    if rng.random() < 0.5:
        one, *_, other = sorted(model.blocks, key=lambda b: b.centroid[2])
        a, b = (block.centroid for block in (one, other))
        force = other.weight * 10 ** rng.uniform(-1, 1)
        bond = Q_(force / (math.pi * 0.02 * np.linalg.norm(b - a)), "Pa")
        start, end = Q_(a + 0.1 * (a - b), "m"), Q_(b + 0.1 * (b - a), "m")
        bar = bs.ties.BondedBar("bar", start, end, diameter="2 cm", bond_strength=bond, yield_force=Q_(force / 2, "N"))
        ties.append(bar)
    return model.with_ties(ties)


def wrench(of, pattern):
    """Wrench of weights, body forces and point loads."""
    total = np.zeros(6 * len(of.free))
    for load in pattern.loads:
        match load:
            case bs.SelfWeight():
                total += of.body_force((0, 0, -1))
            case bs.BodyForce():
                total += of.body_force(load.share * np.array(load.direction))
            case bs.PointLoad():
                total += of.wrench({load.block: [(np.array(load.point), np.array(load.force))]})
    return total


@pytest.mark.parametrize("tied", [False, True], ids=["untied", "tied"])
@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] * (n not in SMALL)) for n in NAMES])
def test_a_linear_program_agrees(name, tied):
    seed = sum(map(ord, name))
    case = structure(name).turned(rotation((0, 0, 1), seed))
    model = with_random_ties(case.model, seed) if tied else case.model
    of = Structure.of(model)
    dead, variable = wrench(of, case.dead), wrench(of, case.variable)
    inner, outer = bounds(of, dead, variable)
    upper = solve(model, case.variable, "associative", case.dead)
    status = upper.status.value
    # The cone lies between the pyramids, and so does what it carries.
    falls, stands = ("unstable_under_dead_load",), ("converged", "unbounded")
    may_end = {(True, True): falls, (True, False): falls + stands, (False, False): stands}
    assert status in may_end[math.isnan(inner), math.isnan(outer)], (status, inner, outer)
    assert status != "converged" or outer > -1e-9
    if math.isfinite(outer):
        assert status != "unbounded", outer
    if math.isinf(inner):
        assert status == "unbounded", inner
    if status == "converged":
        low = 0.0 if math.isnan(inner) else inner
        assert low - 1e-6 * (1 + low) <= upper.load_factor <= outer + 1e-6 * (1 + outer), (inner, outer)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bs.errors.LoadFactorWarning)
        lower = solve(model, case.variable, "nonassociative", case.dead)
    if upper.status == "unstable_under_dead_load":
        assert lower.status == "unstable_under_dead_load"
    if lower.status == "converged":
        assert 0 <= lower.load_factor <= upper.load_factor * (1 + 1e-6) + 1e-6
        by_hand = measures(of, dead, variable, lower)
        numerics = lower.settings.numerics
        assert by_hand.residual < 1e-5, by_hand
        assert by_hand.excess < 10 * numerics.yield_tolerance, by_hand
        assert by_hand.penetration < 1.01 * numerics.interpenetration_tolerance, by_hand
        assert by_hand.gap < 1.01 * lower.certificate.flow_rule_gap_limit + 1e-9, by_hand
        assert by_hand.work == pytest.approx(1.0, abs=1e-5)


def test_the_independent_program_knows_the_closed_form():
    # A box 0.5 × 1 × 1 rocks at b / h; the pyramids bound friction, which is not what governs.
    structure = Structure.of(model_of(*single_block(0.5, 1.0, mu=0.8)))
    dead, variable = structure.body_force((0, 0, -1)), structure.body_force((1, 0, 0))
    assert bounds(structure, dead, variable) == pytest.approx((0.5, 0.5), rel=1e-6)
    assert structure.weight["block"] == pytest.approx(10e3)
