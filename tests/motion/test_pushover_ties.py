"""What a pushover tells of its ties: forces, elongations, and where one breaks. Hand calculations of test_pushover."""

import numpy as np
import pytest
from scipy.optimize import brentq
from test_pushover import ROUGH, box, by_hand, elongated, run, turned

import blockstruct as bs
import structures
from blockstruct import Q_
from blockstruct.results import doubtful_parts
from blockstruct.views.words import pushover_words as told
from properties import slow_after
from structures import SELF_WEIGHT, block_on_a_bar, moved, rotation

BOND = {"diameter": "10 mm", "bond_strength": "0.2 MPa", "strength": "235 MPa"}
ENDS = ("post", Q_([-2, 0.5, 1.5], "m")), ("block", Q_([0, 0.5, 1.5], "m"))


@pytest.fixture(scope="module")
def breaking():
    return run(block_on_a_bar(), "block", steps=20)


def test_forces_and_elongations_of_every_state(breaking):
    curve = breaking.capacity
    length = elongated(turned(curve, "block"))[0]
    found = curve.sel(tie="bar")
    assert curve["tie"].to_numpy().tolist() == ["bar"]
    np.testing.assert_allclose(found["tie_elongation"], length - 2.0, atol=1e-6)
    np.testing.assert_allclose(found["tie_force"], np.where(length <= 2.1, 4e3, 0.0), rtol=1e-4)
    assert [curve[name].attrs["units"] for name in ("tie_force", "tie_elongation")] == ["newton", "meter"]
    assert curve["tie_elongation_limit"].item() == 0.1


def test_where_a_tie_breaks(breaking):
    """The bar is 2.1 m long at a rotation θ; the centroid, 0.25 m and 1 m from the edge, has then moved by d."""
    curve = breaking.capacity
    angle = np.interp(2.1, elongated(np.linspace(0, 0.2, 4001))[0], np.linspace(0, 0.2, 4001))
    d = 0.25 * (1 - np.cos(angle)) + np.sin(angle)
    found = breaking.broken_ties
    assert found.index.tolist() == ["bar"]
    assert found["displacement [meter]"].item() == pytest.approx(d, rel=1e-3)
    assert found["displacement [meter]"].item() == curve["tie_break_displacement"].sel(tie="bar").item()
    assert found["elongation [meter]"].item() == 0.1
    assert found["force [newton]"].item() == pytest.approx(4e3, rel=1e-6)
    assert found["load factor before"].item() == pytest.approx(by_hand(angle, 4.0), rel=5e-3)
    assert found["load factor after"].item() < found["load factor before"].item() - 0.2
    assert breaking.curve_ended.startswith("the load factor is zero at a displacement of 0.25 m")


def test_ties_that_hold_or_are_not_there():
    holding = run(block_on_a_bar(None), "block", steps=6)
    assert np.isnan(holding.capacity["tie_break_displacement"]).all()
    assert holding.broken_ties.empty
    assert "breaks" not in holding.curve_ended
    blocks = [box("ground", (-1, 2), (-0.5, 0), fixed=True), box("block", (0, 0.5), (0, 2))]
    untied = run(bs.Model("block", blocks, bs.detect_interfaces(blocks, ROUGH)), "block", steps=6)
    assert "tie" not in untied.capacity.dims
    assert untied.broken_ties.empty
    assert untied.broken_ties.columns.tolist() == holding.broken_ties.columns.tolist()


def test_many_ties_are_counted():
    """Seven bars side by side break at once."""
    one = block_on_a_bar().ties[0]
    ties = []
    for y in np.linspace(0.2, 0.8, 7):
        ends = (one.start[0], Q_([-2, y, 1.5], "m")), (one.end[0], Q_([0, y, 1.5], "m"))
        ties.append(bs.Tie(f"bar {y}", *ends, yield_force="1 kN", elongation_limit="0.1 m"))
    result = run(block_on_a_bar().with_ties(ties), "block", steps=10)
    assert result.broken_ties.index.tolist() == [tie.name for tie in ties]


@pytest.mark.parametrize(
    ("tie", "instead"),
    [
        (bs.Tie("bar", *ENDS, yield_force="9 kN", prestress="2 kN"), "leave it out, the tie yields at the same force"),
        (
            bs.ties.Strip("strip", *ENDS, area="1 cm^2", strength="300 MPa"),
            "give a Tie across the joint",
        ),
        (bs.ties.BondedBar("bar", "[-2.2, 0.5, 1.5] m", "[0.4, 0.5, 1.5] m", **BOND), "a Tie between each two of them"),
    ],
)
def test_ties_that_are_refused_have_a_way_out(tie, instead):
    model = block_on_a_bar().with_ties([tie])
    with pytest.raises(bs.errors.ModelError, match=instead):
        run(model, "block")
    with pytest.raises(bs.errors.ModelError, match=instead):
        bs.run(model, bs.RecordCase("record", SELF_WEIGHT, Q_([0.1, 0.1], "g_0"), "1 s", "+x"))


@pytest.mark.parametrize("steps", slow_after(10, 40, 60))
def test_a_tie_does_not_pull_before_it_is_tight(steps):
    """A block slides at α = μ to a post ahead, past which its tie is as long again as it was: after 2 · 0.5 m."""
    blocks = [
        box("ground", (-4, 8), (-0.5, 0), fixed=True),
        box("block", (0, 1.2), (0, 0.3)),
        box("post", (1.7, 1.9), (0.5, 1.2), fixed=True),
    ]
    dry = bs.detect_interfaces(blocks, bs.JointMaterial("dry", 0.4))
    tie = bs.Tie("bar", ("post", "[1.7, 0.5, 0.8] m"), ("block", "[1.2, 0.5, 0.15] m"), yield_force="4 kN")
    curve = run(bs.Model("sliding", blocks, dry, ties=[tie]), "block", steps=steps).capacity
    slack = curve["tie_elongation"].sel(tie="bar").to_numpy() < -1e-3
    assert slack.sum() > 3
    assert curve["tie_force"].sel(tie="bar").to_numpy()[slack] == pytest.approx(0, abs=1.0)
    assert curve["load_factor"].to_numpy()[slack] == pytest.approx(0.4, abs=1e-5)
    assert curve["load_factor"].max() > 0.5


@pytest.mark.parametrize("steps", slow_after(10, 20, 40))
@pytest.mark.parametrize("level", slow_after(1.0, 1.5, 2.0))
def test_a_tie_that_is_slack_changes_nothing(level, steps):
    """A tower leans on another, and the tie between them is tight again when both have turned over some way."""
    blocks = [
        box("ground", (-4, 8), (-0.5, 0), fixed=True),
        box("ahead", (0.65, 1.35), (0, 2.8)),
        box("behind", (0, 0.5), (0, 2.4)),
    ]
    ends = ("behind", Q_([0.5, 0.5, level], "m")), ("ahead", Q_([0.65, 0.5, level], "m"))
    tie = bs.Tie("bar", *ends, yield_force="3 kN")
    model = bs.Model("towers", blocks, bs.detect_interfaces(blocks, ROUGH))
    tied_too, alone = (run(m, "behind", steps=steps).capacity for m in (model.with_ties([tie]), model))
    slack = tied_too["tie_elongation"].sel(tie="bar").to_numpy() < -1e-3
    assert 5 < slack.sum() < len(slack) - 2
    assert tied_too["tie_force"].sel(tie="bar").to_numpy()[slack] == pytest.approx(0, abs=1.0)
    expected = np.interp(tied_too["displacement"][slack], alone["displacement"], alone["load_factor"])
    assert tied_too["load_factor"].to_numpy()[slack] == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("steps", slow_after(20, 5, 60))
def test_ties_that_hold_keep_their_length(steps):
    """Two leaves, 0.3 m and 0.5 m thick and 3 m high, turn over one after the other, the slender one held back by ties.

    Leaf i, b thick and h high, turned by θ about its edge, has its centroid h/2 cos θ + b/2 sin θ high and moved by
    b/2 cos θ - h/2 sin θ. The stouter one turns by θ, the other by φ(θ) so that the tie that is tighter is as long as
    it was: 0.3 m. No tie yields, so that α dX = dV: work of the push and of the weights, 20 kN/m³ each.
    """
    b, h, gap, levels = np.array([0.3, 0.5]), 3.0, 0.3, (1.0, 2.5)
    blocks = [
        box("ground", (-2, 4), (-1, 0), fixed=True),
        box("slender", (0, b[0]), (0, h)),
        box("stout", (b[0] + gap, b.sum() + gap), (0, h)),
    ]
    ends = [(("slender", Q_([b[0], 0.5, z], "m")), ("stout", Q_([b[0] + gap, 0.5, z], "m"))) for z in levels]
    ties = [bs.Tie(f"bar {k}", *both, yield_force="2 kN") for k, both in enumerate(ends)]
    model = bs.Model("leaves", blocks, bs.detect_interfaces(blocks, ROUGH), ties=ties)
    curve = run(model, "stout", (-1, 0, 0), steps=steps).capacity

    def longest(phi, theta):
        z = np.array(levels)
        one = b[0] * np.cos(phi) - z * np.sin(phi), b[0] * np.sin(phi) + z * np.cos(phi)
        other = b[0] + gap - z * np.sin(theta), z * np.cos(theta)
        return np.hypot(*np.subtract(one, other)).max()

    def heights_and_ways(theta):
        turned = np.array([brentq(lambda phi: longest(phi, theta) - gap, theta - 0.1, theta + 0.1), theta])
        height = h / 2 * np.cos(turned) + b / 2 * np.sin(turned)
        return np.array([b @ height, -b @ (b / 2 * np.cos(turned) - h / 2 * np.sin(turned))])

    theta = -curve["rotation"].sel(block="stout", axis="y").to_numpy()[1:]
    changes = [heights_and_ways(t + 1e-6) - heights_and_ways(t - 1e-6) for t in theta]
    expected = [rise / way for rise, way in changes]
    np.testing.assert_allclose(curve["load_factor"][1:], expected, atol=4e-3 / steps**2 + 4e-6)
    assert curve["tie_elongation"].max() < 1e-2 / steps**2


@pytest.mark.parametrize("steps", slow_after(20, 30, 60))
def test_a_tie_that_takes_up_the_dead_load_is_followed_to_zero(steps):
    """A block of 0.5 m × 2 m, with a tie of 8 kN to a beam behind it that is slack first: its moment comes to zero.

    The anchor (0, 1.5) is at (0.5 − 0.5 cos θ + 1.5 sin θ, 0.5 sin θ + 1.5 cos θ) at θ; the dead load then drives the
    block with three times the work of the push at collapse, and the tie takes it.
    """
    blocks = [
        box("ground", (-6, 3), (-0.5, 0), fixed=True),
        box("block", (0, 0.5), (0, 2)),
        box("beam", (-0.27, -0.07), (2.493, 2.793), fixed=True),
    ]
    tie = bs.Tie("bar", ("beam", "[-0.168, 0.5, 2.493] m"), ("block", "[0, 0.5, 1.5] m"), yield_force="8 kN")
    model = bs.Model("tied", blocks, bs.detect_interfaces(blocks, ROUGH), ties=[tie])

    def moment(angle):
        c, s = np.cos(angle), np.sin(angle)
        anchor = np.array([0.5 - 0.5 * c + 1.5 * s, 0.5 * s + 1.5 * c])
        turning = np.array([0.5 * s + 1.5 * c, 0.5 * c - 1.5 * s])
        along = anchor - [-0.168, 2.493]
        return 20 * (0.25 * c - s) + 8 * along @ turning / np.linalg.norm(along)

    angle = brentq(moment, 0.7, 1.0)
    d0 = 0.25 - 0.25 * np.cos(angle) + np.sin(angle)
    assert float(run(model, "block", steps=steps).capacity["d0"]) == pytest.approx(d0, rel=1e-4)


@pytest.mark.parametrize("steps", [5, 12])
def test_a_load_factor_that_falls_below_zero_where_a_tie_breaks_is_zero_there(steps):
    """A block held by its tie alone, down a slope steeper than friction: d0 is the 0.4 m of the tie along the slope."""
    R = rotation((0, 1, 0), np.radians(25))
    blocks = moved([box("ground", (-4, 8), (-0.5, 0), fixed=True), box("block", (0, 1), (0, 0.3))], R)
    ends = ("ground", Q_(R @ [-3, 0.5, 0], "m")), ("block", Q_(R @ [0, 0.5, 0.1], "m"))
    tie = bs.Tie("bar", *ends, yield_force="1 kN", elongation_limit="0.4 m")
    dry = bs.detect_interfaces(blocks, bs.JointMaterial("dry", 0.4))
    curve = run(bs.Model("held", blocks, dry, ties=[tie]), "block", steps=steps).capacity
    # From 3 m along and 0.1 m across, the anchor comes to a distance that is 0.4 m longer.
    way = np.sqrt((np.hypot(3, 0.1) + 0.4) ** 2 - 0.1**2) - 3
    assert float(curve["d0"]) == pytest.approx(way * np.cos(np.radians(25)), rel=1e-4)


@pytest.mark.parametrize("steps", [12, 30])
def test_what_is_left_where_ties_break_that_pulled_late(steps):
    """Bars to posts beside a block of 0.6 m × 3 m go slack, pull, and break: α is tan(atan 0.2 − θ) there."""
    posts = [structures.box(f"post {k}", [0.5, y, 0], [0.5, 1, 4], fixed=True) for k, y in enumerate((-1.5, 1.5))]
    blocks = [box("ground", (-3, 4), (-0.5, 0), fixed=True), box("block", (0, 0.6), (0, 3)), *posts]
    ends = [
        ((f"post {k}", Q_([0.65, y, 1], "m")), ("block", Q_([0.6, k, 2.8], "m"))) for k, y in enumerate((-0.5, 1.5))
    ]
    bars = [bs.Tie(f"bar {k}", *both, yield_force="6 kN", elongation_limit="2 mm") for k, both in enumerate(ends)]
    result = run(bs.Model("late", blocks, bs.detect_interfaces(blocks, ROUGH), ties=bars), "block", steps=steps)

    def length(angle):
        """From the post to the block, turned about (0.6, 0)."""
        return np.linalg.norm([0.05 - 2.8 * np.sin(angle), 0.5, 1 - 2.8 * np.cos(angle)])

    angle = brentq(lambda turn: length(turn) - length(0) - 2e-3, 0.06, 0.2)
    assert result.broken_ties["load factor after"].to_numpy() == pytest.approx(np.tan(np.arctan(0.2) - angle), rel=3e-4)


def test_a_slack_tie_beside_one_that_pulls_hides_no_jump():
    """Bars to posts on both sides: the solver rounds the force of the one behind, which is neither force nor change."""
    blocks = [
        box("ground", (-3, 4), (-0.5, 0), fixed=True),
        box("post", (-2.5, -2), (0, 2), fixed=True),
        box("behind", (3, 3.5), (0, 2), fixed=True),
        box("block", (0, 0.5), (0, 2)),
    ]
    slack = bs.Tie("slack", ("behind", "[3, 0.5, 1.5] m"), ("block", "[0.5, 0.5, 1.5] m"), yield_force="4 kN")
    bars = [bs.Tie("bar", *ENDS, yield_force="4 kN"), slack]
    model = bs.Model("between", blocks, bs.detect_interfaces(blocks, ROUGH), ties=bars)
    result = run(model, "block", steps=12)
    curve = result.capacity
    assert bs.results.pushed_tie_state(model, curve).sel(tie="slack").to_numpy().tolist() == ["slack"] * len(curve.step)
    assert not curve["tie_force"].sel(tie="slack").any()
    assert any(said.startswith("Tie slack holds: ") and said.endswith("under 0 kN at most.") for said in told(result))
    assert doubtful_parts(curve, "fictitious") == []
    jump = 0.2 * curve["load_factor"][0].item() * (curve["displacement"] > 0.4 * curve["displacement"][-1])
    (part,) = doubtful_parts(curve.assign(load_factor=curve["load_factor"] - jump), "fictitious")
    assert part.doubt in ("slips", "leaps")
