"""Mechanisms named by hand: closed forms, notes and refusals."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import brentq

import blockstruct as bs
import facades
from blockstruct import Q_
from blockstruct.assess.rotation import Pull
from blockstruct.text import assessment
from facades import DEPTH, DRY, EDGE, HEIGHT, LENGTH, box, by_hand, case, checked, codes, facade, run, tied
from structures import SELF_WEIGHT, model_of, push


def test_a_slack_tie_does_not_hide_the_overturning_angle(result):
    """17 kN pull the façade outwards to a point 0.2 m in front, at 5 m, and back once it has passed it at 0.04 rad.

    α vanishes near (97.2 − 85) / 972 = 0.0126 rad, and is above zero again before 0.08 rad.
    """
    hand = by_hand(result)
    bar = Pull("bar", np.array([2.5, 0, 5]), np.array([2.5, -0.2, 5]), 17e3, np.inf)

    def moment(theta):
        A = 5 * np.array([-np.sin(theta), np.cos(theta)])
        along = np.array([-0.2, 5]) - A
        turns = (A[1] * along[0] - A[0] * along[1]) / np.hypot(*along)
        return 324 * (0.3 * np.cos(theta) - 3 * np.sin(theta)) + 17 * turns

    turning = dataclasses.replace(hand.rotation, ties=(bar,))
    assert turning.capacity() == pytest.approx(brentq(moment, 0, 0.02), rel=1e-9)
    assert turning.load_factor(0.08) > 0


def test_a_tie_breaks_at_the_first_angle_of_its_limit(result):
    """Its length is largest near 0.06 rad, where its anchor is above its other end; it is at the limit before."""
    hand = by_hand(result)
    # |A|² = 0.3² + 5²; the largest length is |A| + 1.
    longest = np.hypot(0.3, 5) + 1 - np.hypot(0.3, 6)
    ends = np.array([2.5, 0.3, 5]), np.array([2.5, 0, -1])
    below, beyond = (Pull("bar", *ends, 1e3, part * longest) for part in (0.99, 1.01))
    angle = hand.rotation.breaks(below)
    arm = below.towards - below.anchor
    longer = np.linalg.norm(arm - hand.rotation.moved(below.anchor, angle)) - np.linalg.norm(arm)
    assert longer == pytest.approx(below.limit, rel=1e-9)
    assert angle == pytest.approx(np.arctan(0.3 / 5) * 0.9, rel=1e-3)
    assert hand.rotation.breaks(beyond) == np.inf


def test_an_edge_named_next_to_the_resultant_has_a_line(result):
    """Its weight is at the middle of the façade, which an edge over 0.4 of its length does not reach."""
    edges = [Q_([[0, 0, 0], [share * LENGTH, 0, 0]], "m") for share in (0.4, 0.6, 1)]
    assert ["at d = 0 m" in str(by_hand(result, edge)) for edge in edges] == [True, False, False]


def test_ties_move_the_resultant(result):
    """T upwards at one end of the edge: 324 · 2.5 / (324 − T) from it, beyond the other one, at 5 m, from 162 kN on."""
    hand, up = by_hand(result), np.array([0.0, 0.0, 1.0])
    for force, left in ((150e3, np.inf), (170e3, 0.0), (400e3, 0.0)):
        bar = Pull("bar", np.zeros(3), np.array([0.0, 0.0, 1e3]), force, np.inf)
        turning = dataclasses.replace(hand.rotation, ties=(bar,))
        assert turning.leaves((-LENGTH / 2, LENGTH / 2), up, np.linspace(0, 0.02, 3)) == left


@pytest.mark.parametrize(
    ("blocks", "edge", "words", "more"),
    [
        ("wall", EDGE, "no block 'wall'", {}),
        ("ground", EDGE, "name free blocks", {}),
        ("façade façade", EDGE, "'façade' is given twice", {}),
        ("façade", Q_([[0, 0, 0], [0, 0, 0]], "m"), r"both ends of the edge are at \(0, 0, 0\) m", {}),
        ("façade", Q_([[0, 0, 0], [0, 0.6, 0]], "m"), "does not turn", {}),
        ("façade", Q_([[0, 0, 0], [0, 0, HEIGHT]], "m"), "about an upright edge", {}),
        ("façade", Q_([[0, 0, 0], [0, 0, HEIGHT]], "m"), "upright has no joint", {"compressive_strength": "1 MPa"}),
        ("façade", EDGE * 1000, r"from \[0.0, 0.0, 0.0\] to \[5000.0, .* not at the blocks", {}),
        ("façade", EDGE + Q_([0, 0.6, 0], "m"), r"do not hold .* \(α0 = -0.1\); give the edge", {}),
        ("façade", Q_([0, 0, 0], "m"), r"shape \(3,\); give its two ends", {}),
        ("façade", EDGE, "give more than zero", {"compressive_strength": "0 MPa"}),
        # N / (2 f_c l) = 324 kN / (2 · 10 kPa · 5 m), behind the wall.
        ("façade", EDGE, "set back by 3.24 m by crushing", {"compressive_strength": "10 kPa"}),
    ],
)
def test_a_hand_calculation_of_nothing_is_refused(result, blocks, edge, words, more):
    with pytest.raises(bs.errors.BlockstructError, match=words):
        bs.assess.overturning(result.model, result.case, blocks.split(), edge, **more)


def test_a_hand_calculation_without_a_push_or_a_pressed_edge_is_refused(result):
    """Upwards at 45 degrees to a point 2 m behind: 600 kN pull 537 kN up, more than the 324 kN of the façade."""
    settled = bs.SettlementCase("sinking", SELF_WEIGHT, ["ground"], "-z")
    for model, of, words in (
        (result.model, settled, "case 'sinking' is a SettlementCase; give a LimitCase with a push"),
        (tied(force=600, to=(2, 9), fixed=True), case(), "they lift"),
    ):
        with pytest.raises(bs.errors.ModelError, match=words):
            bs.assess.overturning(model, of, ["façade"], EDGE)


@pytest.mark.parametrize("prestress", [0, 10])
def test_a_tie_that_the_push_slackens_does_not_pull_by_hand(prestress):
    """A tie to a point 4 m in front, at 5 m: (324 · 0.3 − 5 · T0) / (324 · 3), T0 its prestress and not its 15 kN."""
    model = tied(force=15, to=(-4, 5), fixed=True, **({"prestress": Q_(prestress, "kN")} if prestress else {}))
    result = run(model)
    hand = bs.assess.overturning(model, result.case, ["façade"], EDGE)
    assert hand.alpha0 == pytest.approx((97.2 - 5 * prestress) / 972, rel=1e-9)
    assert result.load_factor == pytest.approx(hand.alpha0, rel=1e-6)


@pytest.mark.parametrize(("force", "down"), [(40, 1), (100, 1), (100, -1)])
def test_a_tie_that_pulls_down_crushes_more_by_hand(force, down):
    """To a point 4 m behind and 4 m lower, with f_c = 1 MPa: T_y = T_z = T / √2, at the outer face.

    N = 324 + T_z and u = N / 10000 (for 100 kN 394.7 kN and 0.03947 m), α0 = (324 (0.3 − u) + 5 T_y − T_z u) / 972
    (0.447710); to a point 4 m higher T_z is below zero. Without the tie u = 0.0324 m, whichever way it pulls, and d0 =
    0.3 − 0.0324 = 0.2676 m.
    """
    model = tied(force=force, to=(4, 5 - 4 * down), fixed=True, joint=DRY.varied(compressive_strength="1 MPa"))
    result, T = run(model), force / np.sqrt(2)
    hand = bs.assess.overturning(model, result.case, ["façade"], EDGE, compressive_strength="1 MPa")
    u = (324 + down * T) / 1e4
    alpha0 = (324 * (0.3 - u) + 5 * T - down * T * u) / 972
    assert (hand.setback, hand.alpha0) == pytest.approx((u, alpha0), rel=1e-9)
    assert hand.d0 == pytest.approx(0.2676, rel=1e-9)
    assert "without ties and with u = 0.0324 m θ0 = " in str(hand)
    assert result.load_factor == pytest.approx(alpha0, rel=1e-5)


def test_a_tie_between_the_edge_and_the_hinge_by_hand():
    """One of 100 kN down at 10 mm from the edge is slackened by the rotation about the hinge, 32.4 mm from it."""
    ends = ("façade", Q_([2.5, 0.01, 5], "m")), ("ground", Q_([2.5, 0.01, -0.2], "m"))
    tie = bs.Tie("bar", *ends, yield_force="100 kN")
    model = facade(DRY.varied(compressive_strength="1 MPa")).with_ties([tie])
    result = run(model)
    hand = bs.assess.overturning(model, result.case, ["façade"], EDGE, compressive_strength="1 MPa")
    assert (hand.setback, hand.alpha0) == pytest.approx((0.0324, 0.0892), rel=1e-6)
    assert result.load_factor == pytest.approx(0.0892, rel=1e-5)


def edge_at(height, y=0.0):
    return Q_([[0, y, height], [LENGTH, y, height]], "m")


@pytest.mark.parametrize("height", [0.5, 2.8])
def test_an_edge_without_a_joint_has_a_note(result, height):
    """About an edge at z the façade begins at 0.3 / (3 − z), and the part below z hangs from it."""
    hand = by_hand(result, edge_at(height))
    assert hand.alpha0 == pytest.approx(0.3 / (HEIGHT / 2 - height))
    (note,) = hand.notes
    assert note == assessment.edge_is_high(height, "façade", 0)
    check = checked(result, beside=hand)
    assert note in check.notes


@pytest.mark.parametrize(("over", "notes"), [(0.0, []), (0.1, ["edge_overhangs"])])
def test_an_edge_beyond_the_joint_has_a_note(over, notes):
    """A bell-cote 0.5 m thick and 2.5 m high reaches beyond its ledge, about whose edge it turns.

    It begins at (0.25 − over) / 1.25, thus 0.12 with over = 0.1 m, and about its own lower edge at 0.2.
    """
    ledge = box("ledge", [0, 0, -1], [2, 0.6, 1], fixed=True)
    model = model_of([ledge, box("bell-cote", [0, -over, 0], [2, 0.5, 2.5])], DRY)
    own, joint = (Q_([[0, y, 0], [2, y, 0]], "m") for y in (-over, 0.0))
    beyond, at_joint = (bs.assess.overturning(model, case(), ["bell-cote"], edge) for edge in (own, joint))
    assert (beyond.alpha0, at_joint.alpha0) == pytest.approx((0.2, (0.25 - over) / 1.25))
    assert at_joint.notes == ()
    assert codes(beyond) == notes


def test_an_edge_over_an_opening_crushes_over_its_piers_alone():
    """Piers of 1.25 m on each side of a door of 2.5 m bear a façade of 18 · 0.6 · (2.5 · 2 + 5 · 4) = 270 kN.

    With f_c = 1 MPa over 2.5 m the hinge is set back by 270 / (2 · 1000 · 2.5) = 0.054 m, over 5 m by half as much.
    """
    origins = [[0, 0, 0], [3.75, 0, 0], [0, 0, 2]]
    sizes = [[1.25, DEPTH, 2], [1.25, DEPTH, 2], [5, DEPTH, 4]]
    parts = [box(f"part {k}", *where) for k, where in enumerate(zip(origins, sizes, strict=True))]
    model = model_of([facade().blocks[0], *parts], DRY.varied(compressive_strength="1 MPa"))
    names = [b.name for b in parts]

    def of(length, strength="1 MPa"):
        edge = Q_([[0, 0, 0], [length, 0, 0]], "m")
        return bs.assess.overturning(model, case(), names, edge, compressive_strength=strength)

    assert (of(5.0).setback, of(2.5).setback) == pytest.approx((0.027, 0.054))
    assert of(5.0).notes == (assessment.edge_is_long(5.0, 2.5, of(5.0).alpha0, of(2.5).alpha0),)
    assert of(2.5).notes == of(5.0, None).notes == ()
    # The remedy of the note.
    assert of(5.0, "0.5 MPa").alpha0 == pytest.approx(of(2.5).alpha0)
    assert run(model).load_factor == pytest.approx(of(2.5).alpha0, rel=1e-6)


@pytest.mark.parametrize(("joint", "has_note"), [("stop", False), ("end", True), ("back", True)])
def test_a_stop_that_the_wall_leans_on_is_a_joint(joint, has_note):
    """Ground filled up to 1 m in front holds an edge there; walls at its end and its back do not."""
    places = {"stop": ([0, -1, 0], [5, 1, 1]), "end": ([5, 0, 0], [1, 0.6, 6]), "back": ([0, 0.6, 0], [5, 1, 6])}
    model = model_of([*facade().blocks, box(joint, *places[joint], fixed=True)], DRY)
    assert bool(bs.assess.overturning(model, case(), ["façade"], edge_at(1.0)).notes) == has_note
    assert bs.assess.overturning(model, case(), ["façade"], EDGE).notes == ()


def test_a_mechanism_by_hand_below_the_one_found_has_a_note(result):
    lower = by_hand(result, EDGE, compressive_strength="0.5 MPa")
    check = checked(result, beside=lower)
    assert check.notes == (assessment.hand_is_lower(0.0784, check.alpha0),)
    equal = by_hand(result)
    assert checked(result, beside=equal).notes == ()


def test_a_mechanism_by_hand_of_other_weights_or_loads_is_refused(result):
    """Another façade begins elsewhere, and so does this one where it is pushed the other way or carries a roof."""
    model = result.model
    roof = bs.LoadPattern("roof", [bs.SelfWeight(), bs.Weight("façade", "[2.5, 0.4, 6] m", "90 kN")])
    thick = box("façade", [0, 0, 0], [LENGTH, 2 * DEPTH, HEIGHT])
    others = [
        bs.assess.overturning(model_of([model.block("ground"), thick], DRY), case(), ["façade"], EDGE),
        bs.assess.overturning(model, case(dead=roof), ["façade"], EDGE),
        bs.assess.overturning(model, case(push(0, 1, 0)), ["façade"], edge_at(0.0, DEPTH)),
        bs.assess.overturning(facades.small_blocks(), case(), ["1.1"], Q_([[0, 0, 0], [1, 0, 0]], "m")),
    ]
    for hand in others:
        with pytest.raises(bs.errors.ModelError, match="beside has other blocks or loads than case 'out of plane'"):
            checked(result, beside=hand)
