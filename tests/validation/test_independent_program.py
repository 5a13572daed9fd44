"""Random models in space against a linear program that shares nothing with the library but the geometry.

The load factor with associative flow lies between those of friction pyramids inside and around the cones; that without
dilatancy lies below, and its certificate is recomputed contact by contact.
"""

import math
import warnings
from collections import Counter

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from independent import Structure, bounds, measures
from structures import model_of, moved, rotation, single_block, solve

KINDS = ("box", "stack", "boxes", "wall", "arch")


def random_model(seed):
    """A model of one of five kinds, turned about the vertical, and a variable load."""
    rng = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    stone = bs.Material("stone", f"{rng.uniform(10, 25)} kN/m^3")
    joint = bs.JointMaterial("joint", rng.uniform(0.2, 0.9))
    blocks = globals()[f"random_{kind}"](rng, stone)
    blocks = moved(blocks, rotation((0, 0, 1), rng.uniform(0, 6)), rng.uniform(-5, 5, 3))
    model = model_of(blocks, joint, f"{kind} {seed}")
    direction = rng.normal(size=3) * (1, 1, rng.choice([0.0, 0.3, 1.0]))
    direction /= np.linalg.norm(direction)
    loaded = [b for b in model.blocks if not b.fixed]
    block = loaded[rng.integers(len(loaded))]
    if rng.random() < 0.7:
        return model, bs.BodyForce(direction)
    corner = block.shape.vertices[rng.integers(len(block.shape.vertices))]
    return model, bs.PointLoad(block.name, Q_(corner, "m"), Q_(direction * block.weight, "N"))


def random_box(rng, stone):
    size = rng.uniform(0.3, 1.5, 3)
    ground = bs.Block.box("ground", Q_([-2, -2, -1], "m"), Q_([6, 6, 1], "m"), stone, fixed=True)
    return [ground, bs.Block.box("box", Q_([0, 0, 0], "m"), Q_(size, "m"), stone)]


def random_stack(rng, stone):
    blocks = [bs.Block.box("ground", Q_([-3, -3, -1], "m"), Q_([6, 6, 1], "m"), stone, fixed=True)]
    low = np.zeros(3)
    for i in range(rng.integers(2, 7)):
        size = rng.uniform((0.5, 0.5, 0.2), (1.2, 1.2, 0.8))
        blocks.append(bs.Block.box(f"{i}", Q_(low, "m"), Q_(size, "m"), stone))
        low = low + np.append(rng.uniform(-0.12, 0.12, 2), size[2])
    return blocks


def random_boxes(rng, stone):
    """Piers of boxes under beams of two bays: several supports, joints on more than one side."""
    blocks = [bs.Block.box("ground", Q_([-1, -1, -1], "m"), Q_([8, 3, 1], "m"), stone, fixed=True)]
    height, depth = rng.uniform(0.3, 0.7), rng.uniform(0.3, 0.8)
    courses = int(rng.integers(1, 4))
    for pier in range(3):
        for course in range(courses):
            low = (2.0 * pier + rng.uniform(-0.05, 0.05), 0, course * height)
            blocks.append(bs.Block.box(f"{pier}.{course}", Q_(low, "m"), Q_([0.6, depth, height], "m"), stone))
    for bay in range(2):
        low, size = (2.0 * bay + 0.3 - 0.3 * (bay == 0), 0, courses * height), (2.0 + 0.3 * (bay == 0), depth, 0.4)
        blocks.append(bs.Block.box(f"beam {bay}", Q_(low, "m"), Q_(size, "m"), stone))
    return blocks


def random_wall(rng, stone):
    n, rows = int(rng.integers(2, 5)), int(rng.integers(2, 6))
    widths = rng.uniform(0.5, 1.5, n)
    pattern = [[*widths], [widths[0] / 2, *(widths[:-1] + widths[1:]) / 2, widths[-1] / 2]]
    size = {"unit_length": "0.4 m", "unit_height": "0.2 m", "thickness": f"{rng.uniform(0.1, 0.4)} m"}
    return bs.courses([pattern[i % 2] for i in range(rows)], material=stone, **size)


def random_arch(rng, stone):
    ranges = {"span": (2, 6), "thickness": (0.3, 0.9), "depth": (0.3, 1.0)}
    size = {name: f"{rng.uniform(*ends)} m" for name, ends in ranges.items()}
    return bs.arch(**size, voussoirs=int(rng.integers(5, 14)), material=stone)


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


def wrenches(structure, load):
    if isinstance(load, bs.BodyForce):
        return structure.body_force(load.share * np.array(load.direction))
    return structure.wrench({load.block: [(np.array(load.point), np.array(load.force))]})


def agree(seed, *, tied=False):
    """Compare both flows of one model; gives how it ended."""
    model, load = random_model(seed)
    if tied:
        model = with_random_ties(model, seed)
    structure = Structure.of(model)
    dead, variable = structure.body_force((0, 0, -1)), wrenches(structure, load)
    inner, outer = bounds(structure, dead, variable)
    pattern = bs.LoadPattern("variable", [load])
    upper = solve(model, pattern, "associative")
    status = upper.status.value
    # The cone lies between the pyramids, and so does what it carries.
    falls, stands = ("unstable_under_dead_load",), ("converged", "unbounded")
    may_end = {(True, True): falls, (True, False): falls + stands, (False, False): stands}
    assert status in may_end[math.isnan(inner), math.isnan(outer)], (model.name, status, inner, outer)
    assert status != "converged" or outer > -1e-9
    if math.isfinite(outer):
        assert status != "unbounded", (model.name, outer)
    if math.isinf(inner):
        assert status == "unbounded", (model.name, inner)
    if status == "converged":
        low = 0.0 if math.isnan(inner) else inner
        assert low - 1e-6 * (1 + low) <= upper.load_factor <= outer + 1e-6 * (1 + outer), (model.name, inner, outer)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bs.errors.LoadFactorWarning)
        lower = solve(model, pattern, "nonassociative")
    if upper.status == "unstable_under_dead_load":
        assert lower.status == "unstable_under_dead_load"
    if lower.status == "converged":
        assert lower.load_factor >= 0
        assert lower.load_factor <= upper.load_factor * (1 + 1e-6) + 1e-6
        by_hand = measures(structure, dead, variable, lower)
        s = lower.settings
        assert by_hand.residual < 1e-5, (model.name, by_hand)
        assert by_hand.excess < 10 * s.numerics.yield_tolerance, (model.name, by_hand)
        assert by_hand.penetration < 1.01 * s.numerics.interpenetration_tolerance, (model.name, by_hand)
        assert by_hand.gap < 1.01 * lower.certificate.flow_rule_gap_limit + 1e-9, (model.name, by_hand)
        assert by_hand.work == pytest.approx(1.0, abs=1e-5)
    return status


@pytest.mark.parametrize(("seed", "tied"), [*((k, False) for k in range(10)), *((k, True) for k in range(5))])
def test_a_linear_program_agrees(seed, tied):
    agree(seed, tied=tied)


@pytest.mark.slow
@pytest.mark.parametrize(("number", "tied"), [(150, False), (100, True)])
def test_a_linear_program_agrees_on_many_models(number, tied):
    """Most models have a load factor."""
    ends = Counter(agree(seed, tied=tied) for seed in range(number))
    assert ends["converged"] > (60 if tied else 100)


def test_the_independent_program_knows_the_closed_form():
    # A box 0.5 × 1 × 1 rocks at b / h; the pyramids bound friction, which is not what governs.
    structure = Structure.of(model_of(*single_block(0.5, 1.0, mu=0.8)))
    dead, variable = structure.body_force((0, 0, -1)), structure.body_force((1, 0, 0))
    assert bounds(structure, dead, variable) == pytest.approx((0.5, 0.5), rel=1e-6)
    assert structure.weight["block"] == pytest.approx(10e3)
