"""Ties that join nothing or cannot be built: the error names the tie, the field and the value."""

import numpy as np
import pytest

import blockstruct as bs
import structures
from blockstruct import Q_
from blockstruct.geometry.polyhedron import box, polyhedron
from blockstruct.geometry.triangles import stretches_inside
from refusals import refused
from structures import bonded, extruded, model_of, moved, rotation

STRONG = {"yield_force": "40 kN"}
STRIP = {"area": "50 mm^2", "strength": "300 MPa"}
MODEL, UNKNOWN = bs.errors.ModelError, bs.errors.UnknownNameError


@pytest.fixture(scope="module")
def pair(dry):
    """Two blocks on one support, and another support."""
    supports = [structures.box(name, [0, y, -1], [3, 1, 1], fixed=True) for name, y in (("ground", 0), ("rock", 2))]
    free = [structures.box(name, [x, 0, 0]) for name, x in (("left", 0), ("right", 2))]
    return model_of([supports[0], *free, supports[1]], dry, "pair")


def tie(start, end, **quantities):
    return bs.Tie("tie", start, end, **(quantities or STRONG))


def bar(start, end, **quantities):
    quantities = {"diameter": "10 mm", "bond_strength": "1 MPa", "yield_force": "10 kN"} | quantities
    return bs.ties.BondedBar("bar", Q_(start, "m"), Q_(end, "m"), **quantities)


LEFT, RIGHT = ("left", "[1, 0.5, 0.5] m"), ("right", "[2, 0.5, 0.5] m")


@pytest.mark.parametrize(
    ("ends", "error", "words"),
    [
        ((LEFT, ("b9", "[2, 0.5, 0.5] m")), UNKNOWN, "'b9' left, right"),
        ((LEFT, ("left", "[0, 0.5, 0.5] m")), MODEL, "block 'left'"),
        ((("ground", "[1, 0.5, 0] m"), ("rock", "[1, 2, 0] m")), MODEL, "supports 'ground' 'rock'"),
        ((("ground", "[0.5, 0.5, 0] m"), ("left", "[0.5, 0.5, 0] m")), MODEL, "direction"),
        ((LEFT, ("right", "[5, 0.5, 0.5] m")), MODEL, "outside (5.0, 0.5, 0.5) [3.0"),
    ],
    ids=["unknown block", "one block", "two supports", "no length", "outside"],
)
def test_ends_must_be_points_of_two_blocks(pair, ends, error, words):
    with refused(error, f"'tie' {words}"):
        pair.with_ties([tie(*ends)])
    with pytest.raises(error):
        bs.Model("again", pair.blocks, pair.interfaces, ties=[tie(*ends)])


ORIGIN, BEYOND = [0, 0, 0], [1, 0, 0]
BOTH = "yield_force area strength"


@pytest.mark.parametrize(
    ("error", "words", "make"),
    [
        *(
            (MODEL, f"'tie' {words}", lambda quantities=quantities: tie(LEFT, RIGHT, **quantities))
            for words, quantities in [
                ("yield_force 0 N", {"yield_force": "0 kN"}),
                (BOTH, {"area": "1 cm^2"}),
                (BOTH, {"yield_force": "1 kN", "area": "1 cm^2", "strength": "1 MPa"}),
                ("prestress 2 kN 1 kN bond", {"yield_force": "5 kN", "bond_force": "1 kN", "prestress": "2 kN"}),
                ("elongation_limit 1e-10 m", {"yield_force": "5 kN", "elongation_limit": "1e-10 m"}),
            ]
        ),
        (MODEL, "'tie' start block point", lambda: tie("left", RIGHT)),
        (bs.errors.DimensionError, "'tie' strength", lambda: tie(LEFT, RIGHT, area="1 cm^2", strength="4 kN")),
        (MODEL, "'bar' bond_strength 0 Pa", lambda: bar(ORIGIN, BEYOND, bond_strength="0 MPa")),
        (MODEL, "'bar' yield_force strength", lambda: bar(ORIGIN, BEYOND, strength="200 MPa")),
        (MODEL, "'bar' (0.0, 0.0, 0.0)", lambda: bar(ORIGIN, ORIGIN)),
        (MODEL, "'strip' area 0 m²", lambda: bs.ties.Strip("strip", LEFT, RIGHT, **STRIP | {"area": "0 mm^2"})),
    ],
)
def test_refused_quantities(error, words, make):
    with refused(error, words):
        make()


def test_the_least_limit_governs():
    bolt = tie(LEFT, RIGHT, area="2 cm^2", strength="200 MPa", punching_force="30 kN", bond_force="35 kN")
    assert bolt.limits == pytest.approx({"yield": 40e3, "punching": 30e3, "bond": 35e3})
    assert (bolt.capacity, bolt.governing) == (pytest.approx(30e3), "punching")


def test_ties_of_a_model_have_unique_names(pair):
    with refused(MODEL, "'pair' tie names tie"):
        pair.with_ties([tie(LEFT, RIGHT), tie(LEFT, RIGHT)])
    with refused(MODEL, "'pair' 'tie' Tie, Strip, BondedBar"):
        pair.with_ties(["tie"])


@pytest.mark.parametrize(
    ("start", "end", "blocks"),
    [
        ([0.2, 0.5, 0.5], [1.5, 0.5, 0.5], "'left'"),
        ([0.5, 0.5, -0.5], [0.5, 2.5, -0.5], "'ground', 'rock'"),
        # In the joint between the support and the blocks it is inside no block.
        ([0, 0.5, 0], [3, 0.5, 0], "no block"),
    ],
)
def test_a_bonded_bar_must_cross_two_blocks(pair, start, end, blocks):
    with refused(MODEL, f"'bar' crosses {blocks}"):
        pair.with_ties([bar(start, end)])


def test_strips_end_at_the_surface(pair):
    outside = ("ground", "[0.5, 0, -0.2] m"), ("left", "[0.5, 0, 0.2] m")
    assert pair.with_ties([bs.ties.Strip("strip", *outside, **STRIP)]).ties[0].capacity == pytest.approx(15e3)
    inside = bs.ties.Strip("strip", outside[0], ("left", "[0.5, 0.1, 0.2] m"), **STRIP)
    with refused(MODEL, "'strip' 'left' 0.1 m inside"):
        pair.with_ties([inside])


def test_segments_inside_a_body_that_is_not_convex():
    # A U: two legs and what joins them.
    shape = extruded("U", [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)], 0.0, 1.0).shape

    def along(start, end):
        return stretches_inside(shape, np.array(start), np.array(end))

    np.testing.assert_allclose(along([-1.0, 1.5, 0.5], [4.0, 1.5, 0.5]), [(1, 2), (3, 4)])
    assert along([-1.0, 0.5, 0.5], [4.0, 0.5, 0.5]) == [(1.0, 4.0)]
    assert along([1.5, 1.2, 0.5], [1.5, 5.0, 0.5]) == []
    assert along([-1.0, 1.0, 0.5], [4.0, 1.0, 0.5]) == [(1.0, 2.0), (3.0, 4.0)]
    cube = polyhedron(*box((0, 0, 0), (1, 1, 1)), "cube")
    (stretch,) = stretches_inside(cube, np.array([-0.5, -0.5, -0.5]), np.array([0.5, 0.5, 0.5]))
    np.testing.assert_allclose(stretch, np.sqrt(3) * np.array([0.5, 1.0]))


def test_segments_contain_the_whole_cross_section():
    cube = polyhedron(*box((0, 0, 0), (1, 1, 1)), "cube")
    # Perpendicular to two faces: from face to face, unless a side face is too near.
    for z, stretches in ((0.1001, [(1.0, 2.0)]), (0.1, []), (0.9001, []), (0.8999, [(1.0, 2.0)])):
        assert stretches_inside(cube, np.array([-1, 0.5, z]), np.array([3, 0.5, z]), 0.1) == stretches
    # At 30° to two faces the rim of the cross-section enters r tan 30° after the axis, and leaves r tan 30° before it.
    d, middle = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6), 0]), np.array([0.5, 0.5, 0.5])
    (stretch,) = stretches_inside(cube, middle - 2 * d, middle + 2 * d, 0.1)
    half = 0.5 / np.cos(np.pi / 6) - 0.1 * np.tan(np.pi / 6)
    np.testing.assert_allclose(stretch, [2 - half, 2 + half])


@pytest.mark.parametrize(("degrees", "off"), [*((0, off) for off in (-1e-9, 0.0, 1e-16, 1e-9)), (7, 0.0), (40, 0.0)])
def test_a_bar_in_a_head_joint_that_is_rounded_is_not_bonded_to_its_blocks(tuff, degrees, off):
    R = rotation((0, 0, 1), np.radians(degrees))
    blocks = moved(bonded(2, 3, "0.3 m", tuff), R)
    x, y, _ = np.round(R @ (0.4, 0.15, 0), 3) + off * np.eye(3)[0]
    segments = bs.ties.tie_segments([bar([x, y, -0.1], [x, y, 0.6])], blocks)
    assert [s.blocks for s in segments] == [("base", "2.2")]
    with refused(MODEL, "'bar' 0.005 m"):
        bs.ties.tie_segments([bar([x, y, -0.1], [x, y, 0.2])], blocks)


def test_least_tie_force_needs_ties_and_a_limit_case(pair):
    push = bs.LoadPattern("push", [bs.BodyForce("+x")])
    case = bs.LimitCase("case", bs.LoadPattern("dead", [bs.SelfWeight()]), push, "associative")
    tied = pair.with_ties([tie(LEFT, RIGHT), bar([-1, 0.5, 0.2], [4, 0.5, 0.2])])
    for error, words, arguments in [
        (UNKNOWN, "'ties' tie, bar", (case, ["ties"], 0.5)),
        (UNKNOWN, "tie", (case, [], 0.5)),
        (MODEL, "bonded bar", (case, ["bar"], 0.5)),
        (MODEL, "LimitCase", ("push", ["tie"], 0.5)),
        (MODEL, "factor -1", (case, ["tie"], -1)),
    ]:
        with refused(error, words):
            bs.ties.least_tie_force(tied, *arguments)
    with refused(MODEL, "'pair' ties"):
        bs.ties.with_and_without(pair, [case])


def test_prestress_needs_a_dead_load(pair):
    case = bs.LimitCase("case", bs.LoadPattern("none", []), bs.LoadPattern("push", [bs.BodyForce("+x")]), "associative")
    tied = pair.with_ties([tie(LEFT, RIGHT, yield_force="4 kN", prestress="1 kN")])
    with refused(MODEL, "prestress 'none' zero"):
        bs.AnalysisManager(tied).run([case])
