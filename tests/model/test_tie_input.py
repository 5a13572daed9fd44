"""Ties that hold nothing together, or that nobody could build: clear errors."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.geometry import box, polyhedron, stretches_inside
from structures import model_of, moved

STRONG = {"yield_force": "40 kN"}


@pytest.fixture(scope="module")
def pair(tuff, dry):
    """Two blocks on one support, and another support."""
    blocks = [
        bs.Block.box("ground", Q_([0, 0, -1], "m"), Q_([3, 1, 1], "m"), tuff, fixed=True),
        bs.Block.box("left", Q_([0, 0, 0], "m"), Q_([1, 1, 1], "m"), tuff),
        bs.Block.box("right", Q_([2, 0, 0], "m"), Q_([1, 1, 1], "m"), tuff),
        bs.Block.box("rock", Q_([0, 2, -1], "m"), Q_([3, 1, 1], "m"), tuff, fixed=True),
    ]
    return model_of(blocks, dry, "pair")


def tie(start, end, **given):
    return bs.Tie("tie", start, end, **(given or STRONG))


LEFT, RIGHT = ("left", "[1, 0.5, 0.5] m"), ("right", "[2, 0.5, 0.5] m")


@pytest.mark.parametrize(
    ("ends", "error", "words"),
    [
        ((LEFT, ("b9", "[2, 0.5, 0.5] m")), bs.errors.UnknownNameError, ["'b9'", "not in the model", "left, right"]),
        ((LEFT, ("left", "[0, 0.5, 0.5] m")), bs.errors.ModelError, ["both ends are at block 'left'"]),
        ((("ground", "[1, 0.5, 0] m"), ("rock", "[1, 2, 0] m")), bs.errors.ModelError, ["both ends are at supports"]),
        ((("ground", "[0.5, 0.5, 0] m"), ("left", "[0.5, 0.5, 0] m")), bs.errors.ModelError, ["no direction"]),
        ((LEFT, ("right", "[5, 0.5, 0.5] m")), bs.errors.ModelError, ["outside the block", "(5.0, 0.5, 0.5)", "[3.0"]),
    ],
    ids=["unknown block", "one block", "two supports", "no length", "outside"],
)
def test_ends(pair, ends, error, words):
    with pytest.raises(error) as raised:
        pair.with_ties([tie(*ends)])
    for word in ["tie 'tie'", *words]:
        assert word in str(raised.value)
    with pytest.raises(error):
        bs.Model("again", pair.blocks, pair.interfaces, ties=[tie(*ends)])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"yield_force": "0 kN"}, ["yield force 0 N", "more than zero"]),
        ({"yield_force": "-1 kN"}, ["yield force -1000 N"]),
        ({"area": "1 cm^2", "strength": "0 MPa"}, ["strength 0 Pa"]),
        ({"punching_force": "1 kN"}, ["either yield_force, or area and strength"]),
        ({"area": "1 cm^2"}, ["either yield_force, or area and strength"]),
        ({"yield_force": "1 kN", "area": "1 cm^2", "strength": "1 MPa"}, ["either yield_force, or area and strength"]),
        ({"yield_force": "5 kN", "bond_force": "1 kN", "prestress": "2 kN"}, ["prestress 2000 N", "1000 N (bond)"]),
        ({"yield_force": "5 kN", "prestress": "-1 kN"}, ["prestress -1000 N"]),
        ({"yield_force": "5 kN", "elongation_limit": "0 mm"}, ["elongation limit 0 m"]),
        ({"yield_force": "5 kN", "elongation_limit": "1e-10 m"}, ["elongation limit 1e-10 m", "leave the tie out"]),
    ],
)
def test_strengths(given, words):
    with pytest.raises(bs.errors.ModelError) as raised:
        tie(LEFT, RIGHT, **given)
    for word in ["tie 'tie'", *words]:
        assert word in str(raised.value)


def test_units_are_asked_for():
    with pytest.raises(bs.errors.UnitError, match="yield force: 40 has no unit"):
        tie(LEFT, RIGHT, yield_force=40)
    with pytest.raises(bs.errors.DimensionError, match="strength"):
        tie(LEFT, RIGHT, area="1 cm^2", strength="4 kN")
    with pytest.raises(bs.errors.ModelError, match="give a block and a point"):
        tie("left", RIGHT)


def test_the_least_limit_governs():
    found = tie(LEFT, RIGHT, area="2 cm^2", strength="200 MPa", punching_force="30 kN", bond_force="35 kN")
    assert found.limits == pytest.approx({"yield": 40e3, "punching": 30e3, "bond": 35e3})
    assert (found.capacity, found.governing) == (pytest.approx(30e3), "punching")


def test_names_are_unique(pair):
    with pytest.raises(bs.errors.ModelError, match="tie names used more than once: tie"):
        pair.with_ties([tie(LEFT, RIGHT), tie(LEFT, RIGHT)])
    with pytest.raises(bs.errors.ModelError, match="is none of Tie, Strip, BondedBar"):
        pair.with_ties(["tie"])


def bar(start, end, **given):
    quantities = {"diameter": "10 mm", "bond_strength": "1 MPa", "yield_force": "10 kN"} | given
    return bs.ties.BondedBar("bar", Q_(start, "m"), Q_(end, "m"), **quantities)


@pytest.mark.parametrize(
    ("start", "end", "through"),
    [
        ([0, 0.5, 5], [3, 0.5, 5], "no block at all"),
        ([0.2, 0.5, 0.5], [1.5, 0.5, 0.5], "'left'"),
        ([0.5, 0.5, -0.5], [0.5, 2.5, -0.5], "'ground', 'rock'"),
        # In the joint between the support and the blocks it runs inside none.
        ([0, 0.5, 0], [3, 0.5, 0], "no block at all"),
    ],
)
def test_a_bar_through_nothing(pair, start, end, through):
    with pytest.raises(bs.errors.ModelError, match=f"runs through {through}, so that it holds nothing") as raised:
        pair.with_ties([bar(start, end)])
    assert "pair" in "".join(raised.value.__notes__)


def test_a_bar_finds_its_blocks_and_their_bond(pair):
    (one,) = bs.ties.tie_segments([bar([0.5, 0.5, -0.75], [0.5, 0.5, 3])], pair.blocks)
    assert one.blocks == ("ground", "left")
    # 0.75 m in the ground, 1 m in the block: the end in the ground governs.
    assert one.capacity == pytest.approx(min(10e3, np.pi * 0.01 * 1e6 * 0.75))
    through = bs.ties.tie_segments([bar([-1, 0.5, 0.5], [4, 0.5, 0.5], bond_strength="10 kPa")], pair.blocks)
    assert [s.blocks for s in through] == [("left", "right")]
    assert (through[0].capacity, through[0].governing) == (pytest.approx(np.pi * 0.01 * 1e4), "bond")


def test_zero_strength_of_bars_and_strips():
    with pytest.raises(bs.errors.ModelError, match="bond strength 0 Pa"):
        bar([0, 0, 0], [1, 0, 0], bond_strength="0 MPa")
    with pytest.raises(bs.errors.ModelError, match="either yield_force or strength"):
        bar([0, 0, 0], [1, 0, 0], strength="200 MPa")
    with pytest.raises(bs.errors.ModelError, match="both ends are at"):
        bar([0, 0, 0], [0, 0, 0])
    with pytest.raises(bs.errors.ModelError, match="area 0 m"):
        bs.ties.Strip("strip", LEFT, RIGHT, area="0 mm^2", strength="300 MPa")


def test_strips_are_at_the_surface(pair):
    strip = {"area": "50 mm^2", "strength": "300 MPa"}
    outside = ("ground", "[0.5, 0, -0.2] m"), ("left", "[0.5, 0, 0.2] m")
    assert pair.with_ties([bs.ties.Strip("strip", *outside, **strip)]).ties[0].capacity == pytest.approx(15e3)
    inside = bs.ties.Strip("strip", outside[0], ("left", "[0.5, 0.1, 0.2] m"), **strip)
    with pytest.raises(bs.errors.ModelError, match=r"strip 'strip'.* 0\.1 m inside the block; give a point"):
        pair.with_ties([inside])


def test_stretches_inside_a_body_that_is_not_convex():
    # A U: two walls on a floor.
    outline = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]
    n = len(outline)
    vertices = np.array([(x, y, z) for y in (0.0, 1.0) for x, z in outline])
    sides = [(k, k + n, (k + 1) % n + n, (k + 1) % n) for k in range(n)]
    faces = [tuple(range(n)), tuple(range(2 * n - 1, n - 1, -1)), *sides]
    shape = polyhedron(vertices, faces, "U")
    found = stretches_inside(shape, np.array([-1.0, 0.5, 1.5]), np.array([4.0, 0.5, 1.5]))
    np.testing.assert_allclose(found, [(1, 2), (3, 4)])
    assert stretches_inside(shape, np.array([-1.0, 0.5, 0.5]), np.array([4.0, 0.5, 0.5])) == [(1.0, 4.0)]
    assert stretches_inside(shape, np.array([1.5, 0.5, 1.2]), np.array([1.5, 0.5, 5.0])) == []
    assert stretches_inside(shape, np.array([-1.0, 0.5, 1.0]), np.array([4.0, 0.5, 1.0])) == [(1.0, 2.0), (3.0, 4.0)]
    cube = polyhedron(*box((0, 0, 0), (1, 1, 1)), "cube")
    (stretch,) = stretches_inside(cube, np.array([-0.5, -0.5, -0.5]), np.array([0.5, 0.5, 0.5]))
    np.testing.assert_allclose(stretch, np.sqrt(3) * np.array([0.5, 1.0]))


def test_stretches_of_a_bar_whose_whole_cross_section_is_inside():
    cube = polyhedron(*box((0, 0, 0), (1, 1, 1)), "cube")
    # Squarely through two faces: from face to face, unless it is too near to one beside it.
    for z, stretches in ((0.1001, [(1.0, 2.0)]), (0.1, []), (0.05, []), (0.9001, []), (0.8999, [(1.0, 2.0)])):
        assert stretches_inside(cube, np.array([-1, 0.5, z]), np.array([3, 0.5, z]), 0.1) == stretches
    # At 30° to two faces the rim of the cross-section enters by r tan 30° behind the axis, and leaves by it before.
    d = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6), 0])
    middle = np.array([0.5, 0.5, 0.5])
    (stretch,) = stretches_inside(cube, middle - 2 * d, middle + 2 * d, 0.1)
    half = 0.5 / np.cos(np.pi / 6) - 0.1 * np.tan(np.pi / 6)
    np.testing.assert_allclose(stretch, [2 - half, 2 + half])
    # Beside an edge inside an L, the cylinder meets its faces where it passes the edge.
    outline = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)])
    vertices = np.concatenate([np.insert(outline, 1, y, axis=1) for y in (0.0, 1.0)])
    sides = [(k, k + 6, (k + 1) % 6 + 6, (k + 1) % 6) for k in range(6)]
    ell = polyhedron(vertices, [tuple(range(6)), tuple(range(11, 5, -1)), *sides], "L")
    found = stretches_inside(ell, np.array([-1, 0.5, 0.95]), np.array([4, 0.5, 0.95]), 0.1)
    np.testing.assert_allclose(found, [(1, 2)])


@pytest.mark.parametrize("degrees", [7, 13, 40])
def test_a_bar_drawn_to_the_millimetre_in_the_head_joints_of_a_turned_wall_is_bonded_to_no_block_beside_them(
    tuff, degrees
):
    wall = bs.courses(
        [[1, 1], [0.5, 1, 0.5], [1, 1]], unit_length="0.4 m", unit_height="0.2 m", depth="0.3 m", material=tuff
    )
    a = np.radians(degrees)
    R = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    blocks = moved(wall, R)
    x, y, _ = np.round(R @ (0.4, 0.15, 0), 3)
    found = bs.ties.tie_segments([bar([x, y, -0.1], [x, y, 0.6])], blocks)
    assert [s.blocks for s in found] == [("base", "2.2")]
    with pytest.raises(bs.errors.ModelError, match=r"within 0\.005 m of them, half its diameter"):
        bs.ties.tie_segments([bar([x, y, -0.1], [x, y, 0.2])], blocks)


def test_least_tie_force_of_what_is_not_there(pair):
    push = bs.LoadPattern("push", [bs.BodyForce("+x")])
    case = bs.LimitCase("case", bs.LoadPattern("dead", [bs.SelfWeight()]), push, "associative")
    tied = pair.with_ties([tie(LEFT, RIGHT), bar([-1, 0.5, 0.2], [4, 0.5, 0.2])])
    with pytest.raises(bs.errors.UnknownNameError, match="no tie 'ties'; the model has tie, bar"):
        bs.least_tie_force(tied, case, ["ties"], 0.5)
    with pytest.raises(bs.errors.UnknownNameError, match="no tie at all"):
        bs.least_tie_force(tied, case, [], 0.5)
    with pytest.raises(bs.errors.ModelError, match="bonded bar, bar"):
        bs.least_tie_force(tied, case, ["bar"], 0.5)
    with pytest.raises(bs.errors.ModelError, match="is not a LimitCase"):
        bs.least_tie_force(tied, "push", ["tie"], 0.5)
    with pytest.raises(bs.errors.ModelError, match="load factor -1"):
        bs.least_tie_force(tied, case, ["tie"], -1)
    with pytest.raises(bs.errors.ModelError, match="model 'pair' has no ties"):
        bs.ties.with_and_without(pair, [case])


def test_prestress_without_dead_load(pair):
    push = bs.LoadPattern("push", [bs.BodyForce("+x")])
    case = bs.LimitCase("case", bs.LoadPattern("none", []), push, "associative")
    tied = pair.with_ties([tie(LEFT, RIGHT, yield_force="4 kN", prestress="1 kN")])
    with pytest.raises(bs.errors.ModelError, match=r"prestress, but the dead load 'none'.* is zero"):
        bs.AnalysisManager(tied).run([case])


@pytest.mark.parametrize("off", [-1e-9, -1e-16, 0.0, 1e-16, 1e-9])
def test_rounding_does_not_move_a_bar_from_a_joint_into_a_block(tuff, dry, off):
    # Two units on a support, and a unit over their joint: in the joint the bar is bonded to neither.
    corners = {"base": [0, 0, -0.2], "1.1": [0, 0, 0], "1.2": [0.3, 0, 0], "2.1": [0.15, 0, 0.2]}
    sizes = {"base": [0.6, 0.2, 0.2]}
    blocks = [
        bs.Block.box(name, Q_(at, "m"), Q_(sizes.get(name, [0.3, 0.2, 0.2]), "m"), tuff, fixed=name == "base")
        for name, at in corners.items()
    ]
    model = model_of(blocks, dry).with_ties([bar([0.3 + off, 0.1, -0.1], [0.3 + off, 0.1, 0.4])])
    assert [s.blocks for s in bs.ties.tie_segments(model.ties, model.blocks)] == [("base", "2.1")]
