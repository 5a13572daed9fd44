"""Local mechanisms against hand calculations; notes and refusals."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import brentq

import blockstruct as bs
from blockstruct import Q_
from blockstruct.assess.capacity import _Pressed
from blockstruct.assess.capacity_of_pushover import curve_of_pushover
from blockstruct.assess.rotation import Pull
from blockstruct.text import assessment
from structures import SELF_WEIGHT, model_of, moved, push, solve

g = 9.80665
STONE, DRY = bs.Material("stone", "18 kN/m^3"), bs.JointMaterial("dry", 0.7)
SITE = bs.assess.ntc_spectrum(Q_(0.15, "g_0"), 2.4, "0.3 s", "B")
#: Façade 5 m × 0.6 m × 6 m, and its edge at the foot, outside.
LENGTH, DEPTH, HEIGHT = 5.0, 0.6, 6.0
EDGE = Q_([[0, 0, 0], [LENGTH, 0, 0]], "m")


def facade(joint=DRY):
    ground = bs.Block.box("ground", "[-1, -1, -0.5] m", Q_([7, 3, 0.5], "m"), STONE, fixed=True)
    wall = bs.Block.box("façade", "[0, 0, 0] m", Q_([LENGTH, DEPTH, HEIGHT], "m"), STONE)
    return model_of([ground, wall], joint, "façade")


def small_blocks(joint=DRY, courses=12):
    size = {"unit_length": "1 m", "unit_height": Q_(HEIGHT / courses, "m"), "depth": Q_(DEPTH, "m"), "material": STONE}
    return model_of(bs.wall(length=Q_(LENGTH, "m"), courses=courses, **size), joint, "façade of small blocks")


def case(variable=None, dead=SELF_WEIGHT, flow="nonassociative"):
    return bs.LimitCase("out of plane", dead, push(0, -1, 0) if variable is None else variable, flow)


def run(model, of=None):
    return bs.AnalysisManager(model).run([of or case()])["out of plane"]


def codes(check):
    return [note.code for note in check.notes]


@pytest.fixture(scope="module")
def result():
    return run(facade())


@pytest.fixture(scope="module")
def small():
    return run(small_blocks())


def test_a_push_in_two_parts_is_that_of_their_sum():
    """Shares 0.3 along −x and 0.4 along −y push each mass by 0.5 of its weight along (−0.6, −0.8).

    The façade goes over its long edge: load factor · 0.4 · 3 m = 0.3 m, thus 0.25, and α0 = 0.5 · 0.25 = 0.125.
    """
    parts = bs.LoadPattern("push", [bs.BodyForce("-x", share=0.3), bs.BodyForce("-y", share=0.4)])
    whole = bs.LoadPattern("push", [bs.BodyForce((-0.6, -0.8, 0), share=0.5)])
    checks = [bs.assess.local_mechanism(run(facade(), case(of)), spectrum=SITE) for of in (parts, whole)]
    for check in checks:
        assert check.alpha0 == pytest.approx(0.125, rel=1e-6)
        assert check.direction == pytest.approx((-0.6, -0.8, 0))
    assert checks[0].a0_star == pytest.approx(checks[1].a0_star, rel=1e-6)


def test_a_free_standing_facade_by_hand(result):
    """The façade turns as one about its outer edge.

    α0 = t / h = 0.6 / 6 = 0.1; one body: e* = 1, M* = 18 · 5 · 0.6 · 6 / g = 324 kN / g = 33.04 t.
    No crushing: FC = 1.35. a0* = 0.1 g / 1.35 = 0.726419 m/s².
    Linear: a_Z = ag S = 0.15 · 1.2 g = 1.765197 m/s², q = 2: ratio = 0.726419 / 0.882599 = 0.823045; S stays at its
    limit 1.2, so a_g,SLV = 2 · 0.726419 / 1.2 = 1.210699 m/s².
    By displacement: θ0 = atan(0.1), its centroid moves by d0 = t/2 = 0.3 m. d_SLV = 0.12 m, a = 0.6 a0* = 0.435851
    m/s², T_SLV = 1.68 π √(0.12 / 0.435851) = 2.769368 s > T_D = 2.2 s: S_De = 0.18 g F0 η T_C T_D / 4π² with η =
    √(10/13).
    """
    check = bs.assess.local_mechanism(result, confidence_factor=1.35, spectrum=SITE)
    a0 = 0.1 * g / 1.35
    assert (check.alpha0, check.e_star) == pytest.approx((0.1, 1.0), rel=1e-6)
    assert check.M_star == pytest.approx(324e3 / g, rel=1e-6)
    assert check.a0_star == pytest.approx(a0, rel=1e-6)
    assert check.ratio == pytest.approx(a0 / (0.15 * 1.2 * g / 2), rel=1e-6)
    assert check.ag == pytest.approx(2 * a0 / 1.2, rel=1e-6)
    assert not check.satisfied
    assert check.limit_states["SLD"].ag == pytest.approx(a0 / 1.2, rel=1e-6)
    by = check.limit_states["SLV, by displacement"]
    T = 1.68 * np.pi * np.sqrt(0.12 / (0.6 * a0))
    TC = 1.1 * 0.3**0.8
    assert pytest.approx(2.769368, abs=1e-6) == T
    demand = 0.18 * g * 2.4 * np.sqrt(10 / 13) * TC * 2.2 / (4 * np.pi**2)
    assert check.curve.d0 == pytest.approx(0.3, rel=1e-6)
    assert (by.capacity, by.demand) == pytest.approx((0.12, demand), rel=1e-6)
    assert by.ratio == pytest.approx(0.12 / demand, rel=1e-6)
    # T_D grows with ag: at a_g the demand is the capacity, in closed form too.
    assert by.ag * (4 * by.ag / g + 1.6) / (0.15 * g * 2.2) == pytest.approx(0.12 / demand, rel=1e-6)
    relied = bs.assess.local_mechanism(result, 1.35, SITE, method="displacement")
    assert relied.ratio == pytest.approx(by.ratio)
    assert relied.satisfied
    slc = check.limit_states["SLC, by displacement"]
    assert slc.capacity == pytest.approx(0.18, rel=1e-6)
    assert np.isnan(slc.ratio)
    for state in (slc, check.limit_states["SLD"]):
        assert (state.satisfied, state.outcome) == (False, "not checked: no spectrum of this limit state")
    small = SITE.at(0.01 * g)
    weak = bs.assess.local_mechanism(result, 1.35, small, spectrum_slc=small).limit_states
    assert (weak["SLC, by displacement"].satisfied, weak["SLC, by displacement"].outcome) == (True, "satisfied")


def test_a_facade_that_crushes_by_hand():
    """f_c = 1 MPa under 324 kN on a foot of 5 m: the hinge lies u = 324 / (2 · 1000 · 5) = 0.0324 m inside.

    α0 = (0.3 − 0.0324) / 3 = 0.0892 (the closed form t/h (1 − W / (f_c t l)) is the same); LC2: FC = 1.2.
    a0* = 0.0892 g / 1.2; d0 = 0.3 − 0.0324 = 0.2676 m; linear ratio = a0* / (0.09 g).
    """
    crushing = DRY.varied(compressive_strength="1 MPa")
    model = facade(crushing)
    result = run(model)
    hand = bs.assess.overturning(model, result.case, ["façade"], EDGE, compressive_strength="1 MPa")
    assert (hand.setback, hand.alpha0, hand.d0) == pytest.approx((0.0324, 0.0892, 0.2676), rel=1e-9)
    check = bs.assess.local_mechanism(result, spectrum=SITE, knowledge_level="LC2", beside=hand)
    assert check.confidence_factor == 1.2
    assert (check.e_star, check.a0_star) == pytest.approx((1.0, 0.0892 * g / 1.2), rel=1e-6)
    assert check.ratio == pytest.approx(0.0892 / 1.2 / 0.09, rel=1e-6)
    assert check.curve.d0 == pytest.approx(0.2676, rel=1e-5)
    assert "0.0892 / 0.0892 = 1" in str(check)
    assert "LC2" in check.confidence_reason


def test_a_hinge_far_from_the_origin_is_printed_to_the_millimetre():
    """Set back by 32.4 mm from an edge at y = 45 m, 212.75 m above the sea."""
    model = facade(DRY.varied(compressive_strength="1 MPa"))
    blocks = moved(model.blocks, np.eye(3), (120, 45, 212.75))
    result = run(model_of(blocks, model.interfaces[0].joint_material))
    check = bs.assess.local_mechanism(result, spectrum=SITE, knowledge_level="LC2")
    assert "along (1, 0, 0) through (122.5, 45.032, 212.75) m" in str(check)


def test_loads_that_a_facade_carries_by_hand():
    """A roof of 90 kN at the top, 0.4 m from the outer edge, whose mass pushes at 6 m.

    α0 = (324 · 0.3 + 90 · 0.4) / (324 · 3 + 90 · 6) = 133.2 / 1512 = 0.0880952; one body, e* = 1, P + Q = 414 kN.
    At θ: tan θ0 = 133.2 / 1512, the centroid of P + Q at (324 · 0.3 + 90 · 0.4) / 414 = 0.321739 m from the edge.
    """
    point = "[2.5, 0.4, 6] m"
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), bs.PointLoad("façade", point, "[0, 0, -90] kN")])
    pushed = bs.LoadPattern("push", [bs.BodyForce("-y"), bs.PointLoad("façade", point, "[0, -90, 0] kN")])
    model, loaded = facade(), case(pushed, dead)
    check = bs.assess.local_mechanism(run(model, loaded), 1.35, SITE)
    assert check.alpha0 == pytest.approx(133.2 / 1512, rel=1e-6)
    assert check.e_star == pytest.approx(1.0, rel=1e-9)
    assert check.participation.total == pytest.approx(414e3)
    assert check.curve.d0 == pytest.approx(133.2 / 414, rel=1e-6)
    assert check.notes == ()
    hand = bs.assess.overturning(model, loaded, check.bodies[0], EDGE)
    assert (hand.alpha0, hand.d0) == pytest.approx((133.2 / 1512, 133.2 / 414))
    # The same as a weight that the dead load carries and the push takes along.
    carried = bs.LoadPattern("carried", [bs.SelfWeight(), bs.Weight("façade", point, "90 kN")])
    same = bs.assess.local_mechanism(run(model, case(dead=carried)), 1.35, SITE)
    assert (same.a0_star, same.curve.d0) == pytest.approx((check.a0_star, check.curve.d0), rel=1e-6)
    # Half the push is twice the load factor, and the same check.
    half = bs.LoadPattern("half", [bs.BodyForce("-y", 0.5), bs.PointLoad("façade", point, "[0, -45, 0] kN")])
    halved = run(model, case(half, dead))
    assert halved.load_factor == pytest.approx(2 * check.alpha0, rel=1e-6)
    other = bs.assess.local_mechanism(halved, 1.35, SITE)
    assert (other.a0_star, other.curve.d0) == pytest.approx((check.a0_star, check.curve.d0), rel=1e-6)
    # The mass of a load is not pushed.
    check = bs.assess.local_mechanism(run(model, case(dead=dead)), 1.35, SITE)
    assert codes(check) == ["masses_differ"]


def tied(breaks_at=None, force=20, bars=1, to=(4, 5), fixed=False, joint=DRY, **more):
    """The façade with ties at 5 m to a wall 4 m behind it, or to another point (y, z)."""
    ground = bs.Block.box("ground", "[-1, -1, -0.5] m", "[7, 9, 0.5] m", STONE, fixed=True)
    wall = bs.Block.box("façade", "[0, 0, 0] m", Q_([LENGTH, DEPTH, HEIGHT], "m"), STONE)
    back = bs.Block.box(
        "back", Q_([0, min(to[0], 4), 0], "m"), Q_([LENGTH, 3, max(HEIGHT, to[1])], "m"), STONE, fixed=fixed
    )
    found = bs.detect_interfaces([ground, wall, back], joint_material=joint)
    more |= {} if breaks_at is None else {"elongation_limit": Q_(breaks_at, "m")}
    ties = [
        bs.Tie(
            f"bar {k}", ("façade", Q_([x, 0, 5], "m")), ("back", Q_([x, *to], "m")), yield_force=Q_(force, "kN"), **more
        )
        for k, x in enumerate(np.linspace(0, LENGTH, bars + 2)[1:-1])
    ]
    return bs.Model("tied façade", [ground, wall, back], found, ties=ties)


def test_a_tied_facade_by_hand():
    """A tie of 20 kN at 5 m: α0 = (324 · 0.3 + 20 · 5) / (324 · 3) = 197.2 / 972 = 0.202881; e* = 1.

    a0* = 0.202881 g / 1.35; linear ratio = 0.202881 / (1.35 · 0.09) = 1.669799.
    Without an elongation limit nothing verifies the tie until collapse: d0 = 0.3 m and a(0) = 0.1 g / 1.35 are those of
    the free façade (C8.7.1.2.1.6).
    """
    model = tied()
    result = run(model)
    hand = bs.assess.overturning(model, result.case, ["façade"], EDGE)
    check = bs.assess.local_mechanism(result, 1.35, SITE, beside=hand)
    assert (check.alpha0, hand.alpha0) == pytest.approx((197.2 / 972,) * 2, rel=1e-6)
    assert (check.e_star, check.a0_star) == pytest.approx((1.0, 197.2 / 972 * g / 1.35), rel=1e-6)
    assert check.ratio == pytest.approx(197.2 / 972 / 1.35 / 0.09, rel=1e-6)
    assert (check.curve.d0, check.curve.at(0.0)) == pytest.approx((0.3, 0.1 * g / 1.35), rel=1e-5)
    assert hand.d0 == pytest.approx(0.3)
    assert f"without ties θ0 = {np.arctan(0.1):.4g} rad; its centroid moves by d0 = 0.3 m" in str(hand)
    assert "T = 20 kN; without an elongation limit it is not counted in a(d)" in str(check)
    assert "T = 20 kN, M = 100 kN m" in str(check)


def test_a_tie_that_breaks_by_hand():
    """The same tie breaks at an elongation of 0.1 m, its anchor at (y, z) = (0, 5) m from the edge, 4 m from the other.

    At θ the anchor is at (−5 sin θ, 5 cos θ), and the tie √((4 + 5 sin θ)² + 5² (1 − cos θ)²) long: 4.1 m at θ = 0.02
    rad or so. The centroid has moved by 3 sin θ + 0.3 (1 − cos θ), some 0.06 m: less than 0.4 d0 = 0.12 m. The tie
    gives more than half of α, so that d_SLV is where it breaks (C8.7.1.2.1.6); beyond, the façade is free.
    """
    theta = brentq(lambda t: np.hypot(4 + 5 * np.sin(t), 5 * (1 - np.cos(t))) - 4.1, 0, 0.5)
    moved = 3 * np.sin(theta) + 0.3 * (1 - np.cos(theta))
    free, push_moment = np.tan(np.arctan(0.1) - theta), 324 * (3 * np.cos(theta) + 0.3 * np.sin(theta))
    along = np.array([4 + 5 * np.sin(theta), 5 - 5 * np.cos(theta)]) / 4.1
    anchor = 5 * np.array([-np.sin(theta), np.cos(theta)])
    of_tie = 20 * (anchor[1] * along[0] - anchor[0] * along[1]) / push_moment
    check = bs.assess.local_mechanism(run(tied(breaks_at=0.1)), 1.35, SITE, method="displacement")
    curve = check.curve
    ((d, loss),) = curve.losses
    assert (d, loss) == pytest.approx((moved, of_tie / (197.2 / 972)), rel=1e-5)
    assert check.limit_state.capacity == pytest.approx(moved, rel=1e-6)
    assert curve.at(d) == pytest.approx((free + of_tie) * g / 1.35, rel=1e-5)
    assert curve.at(d * 1.000001) == pytest.approx(free * g / 1.35, rel=1e-4)
    assert curve.d0 == pytest.approx(0.3, rel=1e-5)
    beyond = 3 * np.sin(0.08) + 0.3 * (1 - np.cos(0.08))
    assert curve.at(beyond) == pytest.approx(np.tan(np.arctan(0.1) - 0.08) * g / 1.35, rel=1e-3)
    assert "where a tie breaks, less than 0.4 d0" in str(check)


@pytest.mark.parametrize(
    ("force", "limit", "strength", "straight"),
    [(20, None, 1, False), (20, 0.05, 1, False), (5, 2, 1, True), (20, None, 100, True), (20, None, None, True)],
)
def test_a_tie_that_lifts_a_wall_off_joints_that_crush(force, limit, strength, straight):
    """A wall of 36 kN, 1 m × 0.5 m × 4 m, and a tie of 20 kN that rises by 2 m over 1 m.

    At collapse it takes 20 · 2/√5 = 17.9 kN off the foot, whose stress block of 1 MPa is 18 mm deep. Without the tie it
    is 36 mm deep: d0 = 0.25 − 0.018 = 0.232 m, and not the 0.25 − 0.009 = 0.241 m of the hinge at collapse.
    One of 5 kN holds until α vanishes, and of 100 MPa the hinge goes back by 0.09 mm.
    """
    blocks = [
        bs.Block.box("ground", "[-3, -2, -1] m", "[6, 6, 1] m", STONE, fixed=True),
        bs.Block.box("post", "[0, 1.5, 0] m", "[1, 0.5, 6] m", STONE, fixed=True),
        bs.Block.box("wall", "[0, 0, 0] m", "[1, 0.5, 4] m", STONE),
    ]
    tie = bs.Tie(
        "tie",
        ("post", Q_([0.5, 1.5, 5], "m")),
        ("wall", Q_([0.5, 0.5, 3], "m")),
        yield_force=Q_(force, "kN"),
        **({} if limit is None else {"elongation_limit": Q_(limit, "m")}),
    )
    joint = bs.JointMaterial("rough", 2, **({} if strength is None else {"compressive_strength": Q_(strength, "MPa")}))
    check = bs.assess.local_mechanism(run(model_of(blocks, joint).with_ties([tie])), 1.35, SITE)
    assert (check.curve is not None) == straight
    if not straight:
        assert "ties that lift the body" in check.missing_curve
        assert "the hinge back by 0.008944 m" in check.missing_curve


@pytest.mark.parametrize(("limit", "straight"), [(0.02, True), (0.2, False)])
def test_a_tie_that_pulls_the_foot_inwards_as_the_push_falls(limit, straight):
    """A wall of 36 kN, 1 m × 0.5 m × 4 m, with a friction of 0.3, and a tie of 18 kN at 0.8 m.

    At rest α0 = (36 · 0.25 + 18 · 0.8) / (36 · 2) = 0.325, and the foot is pulled inwards by 18 − 36 α0 = 6.3 kN. The
    friction of 10.8 kN is used up at α = 0.2: at 0.125 rad or so, where the tie is some 0.1 m longer.
    """
    blocks = [
        bs.Block.box("ground", "[-3, -2, -1] m", "[6, 6, 1] m", STONE, fixed=True),
        bs.Block.box("post", "[0, 2.5, 0] m", "[1, 0.5, 2] m", STONE, fixed=True),
        bs.Block.box("wall", "[0, 0, 0] m", "[1, 0.5, 4] m", STONE),
    ]
    ends = ("post", Q_([0.5, 2.5, 0.8], "m")), ("wall", Q_([0.5, 0.5, 0.8], "m"))
    tie = bs.Tie("tie", *ends, yield_force="18 kN", elongation_limit=Q_(limit, "m"))
    check = bs.assess.local_mechanism(
        run(model_of(blocks, DRY.varied(friction_coefficient=0.3)).with_ties([tie])), 1.35, SITE
    )
    assert check.alpha0 == pytest.approx(0.325, rel=1e-6)
    assert (check.curve is not None) == straight
    if not straight:
        assert "need more friction at the hinge than there is, and it slides; run a Pushover" in check.missing_curve


def test_the_loss_of_a_tie_is_relative_to_the_largest_acceleration():
    """A tie of 150 kN rises steeply from (y, z) = (0, 5) m to (1, 8) m: its arm grows faster than the weight gives way.

    At θ its anchor is A = 5 (−sin θ, cos θ), its arm |A × (1, 8)| / |(1, 8) − A|; it is 90 mm longer at 0.048 rad, and
    α = (324 (0.3 cos θ − 3 sin θ) + 150 arm) / (324 (3 cos θ + 0.3 sin θ)) is 0.378 there and 0.344 at rest.
    """

    def length(theta):
        return np.hypot(1 + 5 * np.sin(theta), 8 - 5 * np.cos(theta))

    theta = brentq(lambda t: length(t) - length(0) - 0.09, 0, 0.1)
    arm = 5 * (np.cos(theta) + 8 * np.sin(theta)) / length(theta)
    free, of_tie = 324 * (0.3 * np.cos(theta) - 3 * np.sin(theta)), 150 * arm
    curve = bs.assess.local_mechanism(run(tied(0.09, 150, to=(1, 8), fixed=True)), 1.35, SITE).curve
    ((d, loss),) = curve.losses
    assert curve.at(d) > 1.05 * curve.at(0)
    assert (d, loss) == pytest.approx(
        (3 * np.sin(theta) + 0.3 * (1 - np.cos(theta)), of_tie / (free + of_tie)), rel=1e-5
    )


def test_a_slack_tie_does_not_hide_the_overturning_angle(result):
    """17 kN pull the façade outwards to a point 0.2 m in front, at 5 m, and back once it has passed it at 0.04 rad.

    α vanishes near (97.2 − 85) / 972 = 0.0126 rad, and is above zero again before 0.08 rad.
    """
    hand = bs.assess.overturning(result.model, result.case, ["façade"], EDGE)
    bar = Pull("bar", np.array([2.5, 0, 5]), np.array([2.5, -0.2, 5]), 17e3, np.inf)

    def moment(theta):
        A = 5 * np.array([-np.sin(theta), np.cos(theta)])
        along = np.array([-0.2, 5]) - A
        return 324 * (0.3 * np.cos(theta) - 3 * np.sin(theta)) + 17 * (A[1] * along[0] - A[0] * along[1]) / np.hypot(
            *along
        )

    turning = dataclasses.replace(hand.rotation, ties=(bar,))
    assert turning.capacity() == pytest.approx(brentq(moment, 0, 0.02), rel=1e-9)
    assert turning.load_factor(0.08) > 0


def test_a_tie_breaks_at_the_first_angle_of_its_limit(result):
    """Its length is largest near 0.06 rad, where its anchor is above its other end; it is at the limit before."""
    hand = bs.assess.overturning(result.model, result.case, ["façade"], EDGE)
    # |A|² = 0.3² + 5²; the largest length is |A| + 1.
    longest = np.hypot(0.3, 5) + 1 - np.hypot(0.3, 6)
    below, beyond = (
        Pull("bar", np.array([2.5, 0.3, 5]), np.array([2.5, 0, -1]), 1e3, part * longest) for part in (0.99, 1.01)
    )
    angle = hand.rotation.breaks(below)
    assert hand.rotation.elongation(below, angle) == pytest.approx(below.limit, rel=1e-9)
    assert angle == pytest.approx(np.arctan(0.3 / 5) * 0.9, rel=1e-3)
    assert hand.rotation.breaks(beyond) == np.inf


@pytest.mark.parametrize("of", ["straight", "pushover"])
def test_ties_that_break_together_are_one_loss(of):
    """Two bars of 10 kN are one of 20 kN: each alone loses less than half of the strength, both more."""
    d_SLV = []
    for bars in (1, 2):
        model = tied(breaks_at=0.1, force=20 / bars, bars=bars)
        result = run(model) if of == "straight" else pushed_over(model)
        check = bs.assess.local_mechanism(result, 1.35, SITE, method="displacement")
        d_SLV.append(check.limit_state.capacity)
        assert d_SLV[-1] < 0.4 * check.curve.d0 * 0.6
    assert d_SLV[1] == pytest.approx(d_SLV[0], rel=1e-6)


def test_breaks_that_follow_each_other_do_not_depend_on_the_steps():
    """Three bars of 6 kN: the loss at each break excludes the fall in the step after it."""
    plain, at = tied(), Q_([[2.5, 0, 5], [2.5, 4, 5]], "m")
    ties = [
        bs.Tie(f"to {limit}", ("façade", at[0]), ("back", at[1]), yield_force="6 kN", elongation_limit=Q_(limit, "m"))
        for limit in (0.05, 0.1, 0.15)
    ]
    model = bs.Model("tied façade", plain.blocks, bs.detect_interfaces(plain.blocks, joint_material=DRY), ties=ties)
    by_hand = bs.assess.local_mechanism(run(model), 1.35, SITE, method="displacement")
    for steps in (5, 10):
        found = bs.assess.local_mechanism(pushed_over(model, steps), 1.35, SITE, method="displacement")
        assert max(lost for _, lost in found.curve.losses) == pytest.approx(by_hand.curve.losses[-1][1], abs=0.015)
        assert found.limit_state.capacity == pytest.approx(by_hand.limit_state.capacity, rel=5e-3)


@pytest.mark.parametrize(("force", "steps"), [(12, 8), (15, 15), (19, 60)])
def test_the_loss_of_a_tie_in_a_pushover_does_not_depend_on_its_steps(force, steps):
    """Less than half is lost; the way to the next state, on which α falls as well, would make it more."""
    by_hand = bs.assess.local_mechanism(run(tied(0.1, force)), 1.35, SITE).curve
    found = bs.assess.local_mechanism(pushed_over(tied(0.1, force), steps), 1.35, SITE, method="displacement")
    ((_, loss),) = by_hand.losses
    assert loss < 0.5
    assert max(lost for _, lost in found.curve.losses) == pytest.approx(loss, abs=3e-3)
    assert found.limit_state.capacity == pytest.approx(0.4 * found.curve.d0)


def test_a_tie_that_holds_longer_than_the_wall_raises_d0():
    check = bs.assess.local_mechanism(run(tied(breaks_at=5.0, force=5)), 1.35, SITE)
    assert check.curve.d0 > 0.31
    assert check.curve.losses == ()
    assert np.all(np.diff(check.curve.displacement) >= 0)
    assert np.all(np.diff(check.curve.acceleration) <= 1e-12)


def test_the_trap_of_small_blocks_is_closed(result, small):
    """Over the n courses of a wall that turns as one, e* = 3n² / (4n² − 1), → 0.75; as one body it is 1.

    With δ = (i − 1/2) / n in course i of n = 12: Σδ = n/2, Σδ² = n/3 − 1/(12 n): 0.751304 (units across the courses
    have the same height).
    """
    n = 12
    one, many = (bs.assess.local_mechanism(r, 1.35, SITE, method="displacement") for r in (result, small))
    assert len(many.participation.names) == 1
    assert len(many.participation_of_blocks.names) > 60
    assert many.participation_of_blocks.e_star == pytest.approx(3 * n**2 / (4 * n**2 - 1), rel=1e-6)
    assert many.e_star == pytest.approx(1.0, rel=1e-9)
    for name in ("alpha0", "a0_star", "M_star", "ratio", "ag"):
        assert getattr(many, name) == pytest.approx(getattr(one, name), rel=1e-5), name
    assert "by single blocks" not in str(one)
    text = str(many)
    assert "e* = [Σ(P+Q)δ]² / (Σ(P+Q) Σ(P+Q)δ²) = (324 kN)² / (324 kN · 324 kN) = 1" in text
    assert "M* = [Σ(P+Q)δ]² / (g Σ(P+Q)δ²) = (324 kN)² / (g · 324 kN) = 33.04 t" in text
    (line,) = [line for line in text.splitlines() if "by single blocks, not used" in line]
    assert "e* = 0.7513, M* = 24.82 t: together they are one" in line


def prism(base, height, angle, **joint):
    """The push, along an angle, of a block on a base [(x, y), …] and a joint that does not slide."""
    n, joint = len(base), bs.JointMaterial("rough", 3).varied(**joint)
    corners = [[x, y, z] for z in (0, height) for x, y in base]
    sides = [[k, (k + 1) % n, n + (k + 1) % n, n + k] for k in range(n)]
    block = bs.Block.from_faces(
        "block", Q_(corners, "m"), [[*range(n)][::-1], [n + k for k in range(n)], *sides], STONE
    )
    ground = bs.Block.box("ground", "[-5, -5, -1] m", "[10, 10, 1] m", STONE, fixed=True)
    model, towards = model_of([ground, block], joint), np.array([np.cos(angle), np.sin(angle), 0.0])
    return run(model, case(push(*towards)))


PENTAGON = [(-0.5, -0.5), (0.2, -0.5), (0.5, 0.4), (0.5, 0.5), (-0.5, 0.5)]


def to_the_short_edge():
    """Direction from the centroid of the pentagon to the middle of its edge from (0.5, 0.4) to (0.5, 0.5)."""
    x, y = 0.5 + 0.0624277, 0.45 - 0.0312139
    return np.arctan2(y, x)


def test_a_resultant_that_leaves_the_hinge_has_no_straight_curve():
    """About the edge at x = 0.5 m the resultant is at y = y_G + α u_y z_G, at rest at its middle, 0.45 m.

    With R = √(0.5624² + 1.5²) and β = atan(0.5624 / 1.5), α = tan(β − θ) / u_x, z_G = R cos(β − θ): y falls below the
    end of the edge, 0.4 m, at R (sin β − sin(β − θ)) u_x = 0.0540 m, and α vanishes about it at 0.4511 m.
    """
    at, u = np.array([0.5624277, 1.5]), to_the_short_edge()
    R, beta = np.hypot(*at), np.arctan(at[0] / at[1])

    def y(theta):
        return 0.0312139 + np.tan(u) * np.tan(beta - theta) * R * np.cos(beta - theta)

    assert y(0) == pytest.approx(0.45, abs=1e-5)
    left = brentq(lambda theta: y(theta) - 0.4, 0, 0.2)
    d = R * (np.sin(beta) - np.sin(beta - left)) * np.cos(u)
    found = prism(PENTAGON, 3, u)
    check = bs.assess.local_mechanism(found, 1.35, SITE)
    assert check.curve is None
    assert check.missing_curve.startswith("no capacity curve: at d = 0.05")
    assert d == pytest.approx(0.054, abs=2e-4)
    told = float(check.missing_curve.split("d = ")[1].split(" m")[0])
    assert told == pytest.approx(d, rel=0.01)
    assert "vanishes about it at 0.4511 m, the resultant leaves the hinge, which is 0.1 m long" in check.missing_curve
    with pytest.raises(bs.errors.ModelError, match="goes over to another edge; run a Pushover, or give"):
        bs.assess.local_mechanism(found, 1.35, SITE, method="displacement")
    edge = Q_([[0.5, 0.4, 0], [0.5, 0.5, 0]], "m")
    hand = bs.assess.overturning(found.model, found.case, ["block"], edge)
    assert hand.d0 == pytest.approx(0.4511, abs=1e-4)
    (line,) = (line for line in hand.lines if line.what == "the resultant leaves the edge")
    assert float(line.formula.split("d = ")[1].split(" m")[0]) == pytest.approx(d, rel=0.01)
    assert "and d0 is less; run a Pushover" in line.formula


@pytest.mark.parametrize("sides", [(0.6, 0.6), (0.6, 0.4)])
def test_a_pier_over_its_corner_has_no_straight_curve(sides):
    """0.6 × 0.6 × 2 m at 45°: over the corner d0 would be 0.4243 m, and over the edge next to it 0.2121 m."""
    a, b = sides
    base, diagonal = [(-a / 2, -b / 2), (a / 2, -b / 2), (a / 2, b / 2), (-a / 2, b / 2)], np.arctan2(b, a)
    check = bs.assess.local_mechanism(prism(base, 2, diagonal), 1.35, SITE)
    assert check.alpha0 == pytest.approx(np.hypot(a, b) / 2, rel=1e-5)
    assert "turns about a point and not about an edge" in check.missing_curve
    crushing = bs.assess.local_mechanism(prism(base, 2, diagonal, compressive_strength="2 MPa"), 1.35, SITE)
    assert "turns about a point and not about an edge" in crushing.missing_curve
    over = bs.assess.local_mechanism(prism(base, 2, 0.0), 1.35, SITE)
    assert over.curve.d0 == pytest.approx(a / 2, rel=1e-5)


@pytest.mark.parametrize("strength", ["2 MPa", "20 MPa"])
def test_an_outline_that_crushes_by_cells_keeps_its_straight_curve(strength):
    """The hinge is set back by cells, by more than the stress block is deep; its edge is still where it turns."""
    base = [(-1, 0), (1, 0), (0.6, 0.6), (-0.6, 0.6)]
    whole, cells = (
        bs.assess.local_mechanism(prism(base, 3, -np.pi / 2, **joint), spectrum=SITE, knowledge_level="LC1")
        for joint in ({}, {"compressive_strength": strength})
    )
    # The centroid of the trapezoid is 0.6 (2 + 2 · 1.2) / (3 (2 + 1.2)) = 0.275 m from its long side.
    assert whole.curve.d0 == pytest.approx(0.275, rel=1e-5)
    assert cells.curve.d0 < whole.curve.d0
    assert cells.curve.d0 == pytest.approx(1.5 * cells.alpha0, rel=1e-5)


def test_the_ends_of_a_hinge_are_corners_at_its_level():
    """Turning about +x leans the body towards −y: a corner at y = 1 m is on its far side, one at z = 2 m above."""
    corners = np.array([[-1, 0, 0], [2, 0, 0], [5, 1, 0], [-5, 0, 2]], dtype=float)
    pressed = _Pressed(np.zeros(3), np.array([0.0, 0, 1]), 1.0, 0.7, 0.0, corners)
    assert pressed.ends(np.array([1.0, 0, 0]), 0.01) == (-1, 2)
    assert pressed.ends(np.array([-1.0, 0, 0]), 0.01) == (-5, 1)


def test_an_edge_named_next_to_the_resultant_has_a_line(result):
    """Its weight is at the middle of the façade, which an edge over 0.4 of its length does not reach."""
    told = [
        "at d = 0 m"
        in str(bs.assess.overturning(result.model, result.case, ["façade"], Q_([[0, 0, 0], [x, 0, 0]], "m")))
        for x in (0.4 * LENGTH, 0.6 * LENGTH, LENGTH)
    ]
    assert told == [True, False, False]


def leaning(*limits):
    """A wall 0.5 m × 3 m that leans by 0.7 m towards -y, held by ties of 10 kN to a wall 3.5 m behind, at 2.8 m."""
    corners = [[x, y - 0.7 * z / 3, z] for z in (0, 3) for x, y in ((0, 0), (1, 0), (1, 0.5), (0, 0.5))]
    faces = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    blocks = [
        bs.Block.from_faces("wall", Q_(corners, "m"), faces, STONE),
        bs.Block.box("ground", "[-1, -3, -1] m", "[3, 8, 1] m", STONE, fixed=True),
        bs.Block.box("back", "[0, 3, 0] m", "[1, 1, 3] m", STONE, fixed=True),
    ]
    at = [("wall", Q_([0.5, -0.7 * 2.8 / 3, 2.8], "m")), ("back", Q_([0.5, 3, 2.8], "m"))]
    ties = [
        bs.Tie(f"bar {k}", *at, yield_force="10 kN", **({"elongation_limit": Q_(limit, "m")} if limit else {}))
        for k, limit in enumerate(limits)
    ]
    return bs.Model("leaning", blocks, bs.detect_interfaces(blocks, joint_material=DRY), ties=ties)


def test_a_leaning_wall_that_ties_hold_goes_as_far_as_they_do():
    """W = 27 kN, its centroid 0.1 m beyond the edge: α0 = (Σ T · 2.8 − 27 · 0.1) / (27 · 1.5).

    A tie of 20 mm breaks at θ = 0.02 / 2.8, to first order: d0 = 1.5 θ = 10.71 mm; a second one of 30 mm at 16.07 mm.
    They lose their share of the moment, 28 of 25.3 kN m and 28 and 56 of 53.3 kN m, down to zero, at most all of it.
    """
    one, two = (bs.assess.local_mechanism(run(leaning(*limits)), 1.35, SITE) for limits in ((0.02,), (0.02, 0.03)))
    assert one.alpha0 == pytest.approx((28 - 2.7) / 40.5, rel=1e-6)
    assert two.alpha0 == pytest.approx((56 - 2.7) / 40.5, rel=1e-6)
    assert one.curve.d0 == pytest.approx(1.5 * 0.02 / 2.8, rel=2e-3)
    assert two.curve.d0 == pytest.approx(1.5 * 0.03 / 2.8, rel=2e-3)
    assert [d for d, _ in two.curve.losses] == pytest.approx([one.curve.d0, two.curve.d0], rel=1e-9)
    assert [lost for _, lost in one.curve.losses] == pytest.approx([1.0], abs=0.015)
    assert [lost for _, lost in two.curve.losses] == pytest.approx([28 / 53.3, 1.0], abs=0.015)
    assert one.curve.at(0.999 * one.curve.d0) > 0.9 * one.a0_star
    assert one.curve.at(one.curve.d0) == 0.0


def test_a_leaning_wall_needs_elongation_limits():
    check = bs.assess.local_mechanism(run(leaning(None)), 1.35, SITE)
    assert "ties that have no elongation limit" in check.missing_curve


def test_ties_move_the_resultant(result):
    """T upwards at one end of the edge: 324 · 2.5 / (324 − T) from it, beyond the other one, at 5 m, from 162 kN on."""
    hand, up = bs.assess.overturning(result.model, result.case, ["façade"], EDGE), np.array([0.0, 0.0, 1.0])
    for force, left in ((150e3, np.inf), (170e3, 0.0), (400e3, 0.0)):
        bar = Pull("bar", np.zeros(3), np.array([0.0, 0.0, 1e3]), force, np.inf)
        turning = dataclasses.replace(hand.rotation, ties=(bar,))
        assert turning.leaves((-LENGTH / 2, LENGTH / 2), up, np.linspace(0, 0.02, 3)) == left


def test_two_bodies_by_hand():
    """Weights of 2 and 1 with δ = 1 and 1/2: e* = 2.5² / (3 · 2.25) = 0.925926; d = d_C · 2.25 / 2.5 at δ_C = 1."""
    found = bs.assess.Participation.of(
        ["a", "b"], [np.array([0]), np.array([1])], np.array([2.0, 1.0]), np.array([0.4, 0.2])
    )
    assert found.e_star == pytest.approx(6.25 / 6.75)
    assert found.M_star == pytest.approx(6.25 / 2.25 / g)
    assert found.factor == pytest.approx(2.25 / 2.5)


def test_the_mechanism_of_a_wall_in_its_plane_has_several_bodies_and_no_straight_curve():
    rows = [[1, 1, 1, 1], [0.5, 1, 1, 1, 0.5], [1, 1, -1, 1], [0.5, 1, -1, 1, 0.5], [1, 2, 1], [0.5, 1, 1, 1, 0.5]]
    blocks = bs.courses(rows, unit_length="40 cm", unit_height="20 cm", depth="30 cm", material=STONE)
    found = run(model_of(blocks, DRY), case(push(1, 0, 0)))
    check = bs.assess.local_mechanism(found, 1.35, SITE)
    moving = [body for body in check.bodies if body.moves]
    assert len(moving) > 1
    assert check.curve is None
    assert "bodies move against each other; run a Pushover" in str(check)
    assert 0 < check.participation_of_blocks.e_star <= check.e_star <= 1
    with pytest.raises(bs.errors.ModelError, match=r"run a Pushover, or give method='linear' \(--method linear on"):
        bs.assess.local_mechanism(found, 1.35, SITE, method="displacement")


def test_a_sliding_block_takes_part_as_one_and_has_no_d0():
    blocks = [
        bs.Block.box("ground", "[-1, -1, -0.5] m", "[5, 5, 0.5] m", STONE, fixed=True),
        bs.Block.box("block", "[0, 0, 0] m", "[2, 2, 1] m", STONE),
    ]
    found = run(model_of(blocks, bs.JointMaterial("smooth", 0.3)))
    check = bs.assess.local_mechanism(found, 1.35, SITE)
    assert (check.alpha0, check.e_star) == pytest.approx((0.3, 1.0), rel=1e-6)
    assert "slides without turning" in check.missing_curve


@pytest.mark.parametrize(("force", "strength"), [(30, None), (20, "0.5 MPa")])
def test_a_body_that_friction_holds_has_no_straight_curve(force, strength):
    """A façade pressed against a side wall that it rubs along: more than its weight resists.

    Its stress block at the foot is 64.8 / (500 · 2) = 0.0648 m deep, and with 20 kN the hinge is 0.177 m off the axis.
    """
    wall = bs.Block.box("façade", "[0, 0, 0] m", "[2, 0.6, 3] m", STONE)
    side = bs.Block.box("side", "[2, 0, 0] m", "[0.5, 3, 3] m", STONE)
    ground = bs.Block.box("ground", "[-1, -1, -0.5] m", "[5, 6, 0.5] m", STONE, fixed=True)
    pressed = [
        bs.PointLoad("side", "[2.5, 0.3, 1.5] m", Q_([-force, 0, 0], "kN")),
        bs.PointLoad("façade", "[0, 0.3, 1.5] m", Q_([force, 0, 0], "kN")),
    ]
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), *pressed])
    model = model_of([ground, wall, side], DRY.varied(compressive_strength=strength))
    check = bs.assess.local_mechanism(run(model, case(dead=dead)), 1.35, SITE)
    assert [body.blocks for body in check.bodies if body.moves] == [("façade",)]
    # Its own weight gives 0.6 / 3.
    assert check.alpha0 > 0.25
    assert check.curve is None
    assert check.missing_curve


def test_a_body_that_tension_holds_has_no_straight_curve():
    """A foot that bonds with 5 kPa: it turns about its edge, at more than its weight resists, 0.1."""
    check = bs.assess.local_mechanism(run(facade(DRY.varied(cohesion="10 kPa", tensile_strength="5 kPa"))), 1.35, SITE)
    assert 1.01 < check.alpha0 / 0.1 < 1.1
    assert "give a load factor of 0.1, not 0.10" in check.missing_curve
    assert "something else resists, too; run a Pushover, with joints that have neither" in check.missing_curve


@pytest.mark.parametrize("tensile_strength", ["1 kPa", "5 kPa"])
def test_a_body_that_mortar_holds_as_it_crushes_has_no_straight_curve(tensile_strength):
    """The hinge is where the stress block is, and not the resultant beyond it, which the tension moves outwards."""
    mortar = DRY.varied(cohesion="10 kPa", tensile_strength=tensile_strength, compressive_strength="2 MPa")
    check = bs.assess.local_mechanism(run(facade(mortar)), 1.35, SITE)
    assert check.curve is None
    assert "something else resists, too" in check.missing_curve


def test_a_body_that_crushes_askew_has_no_straight_curve():
    """Under a push 5° off its normal the stress block is a rectangle (5 − 2 e1)(0.6 − 2 e2) at a corner of the foot."""
    askew = np.array([np.sin(np.radians(5)), np.cos(np.radians(5))])
    result = run(facade(DRY.varied(compressive_strength="1 MPa")), case(push(askew[0], -askew[1], 0)))
    along, across = np.array([LENGTH, DEPTH]) - 2 * HEIGHT / 2 * result.load_factor * askew
    assert 1000 * along * across == pytest.approx(324, rel=1e-4)
    check = bs.assess.local_mechanism(result, knowledge_level="LC2", spectrum=SITE)
    assert check.curve is None
    assert "or it crushes towards a corner under an oblique push; run a Pushover" in check.missing_curve


def test_bodies_that_turn_about_other_axes_have_a_note():
    """A slender wall leans on a low one, whose far edge runs askew by 0.3 in 1."""
    base = [(0.5, 0), (1.0, 0), (1.3, 1), (0.5, 1)]
    corners = [[x, y, z] for z in (0, 2) for x, y in base]
    sides = [[k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k] for k in range(4)]
    blocks = [
        bs.Block.box("ground", "[-5, -5, -1] m", "[10, 10, 1] m", STONE, fixed=True),
        bs.Block.box("slender", "[0, 0, 0] m", "[0.5, 1, 4] m", STONE),
        bs.Block.from_faces("low", Q_(corners, "m"), [[3, 2, 1, 0], [4, 5, 6, 7], *sides], STONE),
    ]
    check = bs.assess.local_mechanism(run(model_of(blocks, DRY), case(push(1, 0, 0))), 1.35, SITE)
    assert "out_of_plane" in codes(check)


def test_a_portal_goes_as_far_by_its_control_point_as_by_its_weights():
    """Columns of 27 kN move by half of what their lintel of 22.5 kN does.

    e* = (54 / 2 + 22.5)² / (76.5 (54 / 4 + 22.5)) = 0.889706.
    """
    blocks = [
        bs.Block.box("ground", "[-1, -1, -0.5] m", "[6, 3, 0.5] m", STONE, fixed=True),
        *(bs.Block.box(f"column {x:g}", Q_([x, 0, 0], "m"), "[0.5, 1, 3] m", STONE) for x in (0, 2)),
        bs.Block.box("lintel", "[0, 0, 3] m", "[2.5, 1, 0.5] m", STONE),
    ]
    control = ("lintel", (1, 0, 0))
    pushed = bs.Pushover("portal", SELF_WEIGHT, push(1, 0, 0), control=control, steps=10)
    check = bs.assess.local_mechanism(bs.run(model_of(blocks, DRY), pushed)["portal"], 1.35, SITE)
    assert check.e_star == pytest.approx(0.889706, rel=1e-5)
    assert check.curve is not None
    assert check.notes == ()


def test_every_formula_is_printed_with_its_paragraph(result):
    text = str(
        bs.assess.local_mechanism(result, 1.35, SITE, spectrum_slc=SITE.at(0.2 * g), spectrum_sld=SITE.at(0.05 * g))
    )
    for words in (
        "relied on: SLV, linear: capacity / demand = 0.823, not satisfied; equal at a_g = 1.211 m/s² = 0.1235 g",
        "a0* = α0 g / (e* FC) = 0.1 · 9.80665 m/s² / (1 · 1.35) = 0.7264 m/s² = 0.07407 g   [C8.7.1.2.1.5 (C8.7.1.8)]",
        "d_SLV = 0.4 d0 = 0.4 · 0.3 m = 0.12 m   [C8.7.1.2.1.6]",
        "T_SLV = 1.68 π √(d/a) = 1.68 π √(0.12 m / 0.4359 m/s²) = 2.769 s   [C8.7.1.2.1.8 (C8.7.1.10)]",
        "T_SLC = 1.56 π √(d/a)",
        "η = √(10/(5 + ξ)) = 0.8771 for ξ = 8 %",
        "η = √(10/(5 + ξ)) = 0.8165 for ξ = 10 %",
        "S_S = 1.40 − 0.40 F0 a_g/g, from 1.00 to 1.20 = 1.2   [NTC 2018 Tab. 3.2.IV]",
        "FC = 1.35: α0 ignores the compressive strength",
        "behaviour factor q",
    ):
        assert words in text, words
    assert text.count("capacity / demand  ") == 4


def test_coefficients_are_arguments_and_changes_are_printed(result):
    plain = bs.assess.local_mechanism(result, 1.35, SITE)
    own = bs.assess.local_mechanism(result, 1.35, SITE, coefficients=bs.assess.Coefficients(q=1.5, slv_share=0.25))
    assert own.ratio == pytest.approx(0.75 * plain.ratio)
    assert own.limit_states["SLV, by displacement"].capacity == pytest.approx(0.25 * 0.3, rel=1e-6)
    assert "1.5 (given; the Circolare has 2)" in str(own)
    assert "(given;" not in str(plain)
    assert plain.notes == ()
    assert codes(own) == ["coefficients"]


def test_a_spread_is_checked_by_the_run_as_given():
    """Every schedule finds α0 = 0.1, and the run as given has the curve."""
    control = ("façade", (0, -1, 0))
    pushed = bs.Pushover("out", SELF_WEIGHT, push(0, -1, 0), control=control, steps=10)
    analysis = bs.AnalysisManager(facade()).run([pushed], spread=["half steps", "steep"])
    check = bs.assess.local_mechanism(analysis.spread("out"), 1.35, SITE)
    assert check.result is analysis["out"]
    assert check.curve.lines[0].what == "curve of the pushover"
    assert check.notes == ()


@pytest.mark.parametrize(("lowest", "satisfied"), [(0.09, True), (0.08, False)])
def test_the_lower_end_of_a_range_counts(result, lowest, satisfied):
    site = bs.assess.ntc_spectrum(Q_(0.1, "g_0"), 2.4, "0.3 s", "B")
    ranged = result.changed(path_dependence=(lowest, 0.1))
    alone, check = (bs.assess.local_mechanism(r, 1.35, site) for r in (result, ranged))
    assert (codes(alone), codes(check)) == ([], ["range"])
    assert check.verdict.range == pytest.approx((10 * lowest * alone.ratio, alone.ratio), rel=1e-6)
    assert (alone.satisfied, check.satisfied) == (True, satisfied)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"without_crushing": 0.9}, "from 1 up to 10"),
        ({"q": 0}, "above 0 and up to 10"),
        ({"slv_share": 1.0}, "above 0 and below 1"),
        ({"slc_share": 0.2}, r"slc_share 0\.2 is below slv_share 0\.4, .* give an slc_share of at least that"),
        ({"slv_share": 0.7}, r"slc_share 0\.6 is below slv_share 0\.7"),
    ],
)
def test_coefficients_outside_their_range_are_refused(changed, words):
    with pytest.raises(bs.errors.ModelError, match=words):
        bs.assess.Coefficients(**changed)
    assert bs.assess.Coefficients(slv_share=0.7, slc_share=0.7).slc_share == 0.7
    assert bs.assess.Coefficients(q=np.int64(3)).q == 3


def test_units_do_not_change_the_check(result):
    other = bs.assess.ntc_spectrum(Q_(1.4709975, "m/s^2"), 2.4, Q_(300, "ms"), "B")
    one, two = (bs.assess.local_mechanism(result, 1.35, site) for site in (SITE, other))
    assert two.ratio == pytest.approx(one.ratio, rel=1e-12)


def test_an_acceleration_below_that_of_sld_is_not_taken_at_slv(result):
    """C8.7.1.2.1.8: a_g,SLV is not less than a_g,SLD."""
    few = bs.assess.Coefficients(slv_share=0.01)
    check = bs.assess.local_mechanism(result, 1.35, SITE, method="displacement", coefficients=few)
    assert check.ag == pytest.approx(check.limit_states["SLD"].ag)
    assert "not below that of SLD" in str(check)
    # The site at which SLD is met, as a_g,SLV of this share alone is not.
    site = SITE.at(0.9 * check.ag)
    met = bs.assess.local_mechanism(result, 1.35, site, method="displacement", coefficients=few)
    assert met.ratio < 1
    assert met.satisfied
    borne = f"{met.ag:.4g} m/s² = {met.ag / g:.4g} g"
    assert str(met.verdict) == (
        f"SLV, by displacement: capacity / demand = {met.ratio:.4g}, below 1, but satisfied: a_g,SLV counts as no less "
        f"than a_g,SLD (C8.7.1.2.1.8); borne is a_g = a_g,SLD = {borne} (site {site.ag / g:.4g} g)."
    )


def test_a_verdict_of_sld_is_not_that_of_equality(result):
    """At a stronger site it is not satisfied; the structure still bears a_g,SLD, and capacity equals demand at less."""
    few = bs.assess.Coefficients(slv_share=0.01)
    check = bs.assess.local_mechanism(result, 1.35, SITE.at(0.3 * g), method="displacement", coefficients=few)
    equal = next(line.formula for line in check.limit_state.lines if "a_g,SLV" in line.what)
    assert not check.satisfied
    assert check.ratio < 1
    borne = f"{check.ag:.4g} m/s² = {check.ag / g:.4g} g"
    assert borne not in equal
    assert str(check.verdict).endswith(f"not satisfied; borne is a_g = a_g,SLD = {borne} (site 0.3 g).")


def test_a_table_that_ends_before_the_period_leaves_the_displacement_out(result):
    short = bs.assess.table_spectrum(Q_([0, 0.15, 0.42, 2], "s"), Q_([0.18, 0.432, 0.432, 0.09], "g_0"), ag="0.15 g_0")
    check = bs.assess.local_mechanism(result, 1.35, short)
    assert check.ratio == pytest.approx(0.1 / 1.35 / 0.09, rel=1e-6)
    assert list(check.limit_states) == ["SLD", "SLV, linear"]
    assert codes(check) == ["state_left_out"] * 2
    assert "last period is 2 s" in check.notes[0].text
    with pytest.raises(bs.errors.ModelError, match="last period is 2 s"):
        bs.assess.local_mechanism(result, 1.35, short, method="displacement")


def test_notes_on_the_load_factor(result):
    bound = run(facade(), case(flow="associative"))
    check = bs.assess.local_mechanism(bound, 1.35, SITE)
    assert codes(check) == ["associative_bound"]
    assert f"note: {check.notes[0]}" in str(check)
    drifting = result.changed(outcome=dataclasses.replace(result.outcome, settled=False))
    unsettled = bs.assess.local_mechanism(drifting, 1.35, SITE)
    assert codes(unsettled) == ["not_settled"]
    assert not unsettled.satisfied
    assert codes(bs.assess.local_mechanism(result, 1.35, SITE)) == []


def capacity_of_facade(top=0.0997, holds=60):
    """What a pushover of the façade gives: α = tan(atan 0.1 − θ) over the displacement of a corner of its top."""
    angle = np.linspace(0.0, top, 61)
    displacement = HEIGHT * np.sin(angle)
    factor = np.tan(np.arctan(0.1) - angle)
    ended = factor[-1] <= 0
    return xr.Dataset(
        {
            "load_factor": ("step", factor),
            "holds": ("step", (np.arange(61) <= holds).astype(int)),
            "d0": ((), HEIGHT * np.sin(np.arctan(0.1)) if ended else np.nan),
        },
        coords={"displacement": ("step", displacement)},
    )


def curve_of(result, dataset, control=("façade", (0.0, -1.0, 0.0)), point=(0.0, 0.0, 6.0)):
    check = bs.assess.local_mechanism(result, 1.35, SITE)
    pushed = dataclasses.replace(result)
    object.__setattr__(pushed, "case", SimpleNamespace(control=control, control_point=point))
    return curve_of_pushover(pushed, dataset, check.direction, check.participation, check.a0_star)


def test_the_curve_of_a_pushover_is_that_of_the_oscillator(result):
    """Corner of the top: δ_C = 2 where the centroid has 1: d = d_C / 2. d0 = 6 sin(atan 0.1) / 2 = 0.298511 m."""
    curve = curve_of(result, capacity_of_facade())
    assert curve.d0 == pytest.approx(3 * np.sin(np.arctan(0.1)), rel=1e-6)
    assert curve.at(0.0) == pytest.approx(0.1 * g / 1.35, rel=1e-6)
    assert curve.at(3 * np.sin(0.05)) == pytest.approx(np.tan(np.arctan(0.1) - 0.05) * g / 1.35, rel=1e-4)
    assert curve.at(curve.d0) == 0
    # By its centroid it is the same oscillator, to first order.
    part = capacity_of_facade(top=0.05)
    part["displacement"] = part["displacement"] / 2
    centred = curve_of(result, part, point=None)
    assert centred.at(0.1) == pytest.approx(curve.at(0.1), rel=1e-3)


def pushed_over(model, steps=30):
    control = ("façade", (0, -1, 0))
    return bs.run(model, bs.Pushover("out of plane", SELF_WEIGHT, push(0, -1, 0), control=control, steps=steps))[
        "out of plane"
    ]


def test_the_check_of_a_pushover_is_that_of_the_straight_curve(result):
    """A façade that rotates as one: its capacity curve is straight but for the arc of its centroid."""
    straight, found = (
        bs.assess.local_mechanism(r, 1.35, SITE, method="displacement") for r in (result, pushed_over(facade()))
    )
    assert "curve of the pushover" in str(found)
    assert found.curve.d0 == pytest.approx(straight.curve.d0, rel=1e-2)
    assert found.ratio == pytest.approx(straight.ratio, rel=1e-2)


def test_the_check_of_a_pushover_whose_tie_breaks():
    """As in :func:`test_a_tie_that_breaks_by_hand`; without a limit of the tie there is no curve to rely on."""
    by_hand, result = run(tied(breaks_at=0.1)), pushed_over(tied(breaks_at=0.1))
    by_hand, found = (bs.assess.local_mechanism(of, 1.35, SITE, method="displacement") for of in (by_hand, result))
    assert found.limit_state.capacity == pytest.approx(by_hand.limit_state.capacity, rel=1e-2)
    assert found.ratio == pytest.approx(by_hand.ratio, rel=2e-2)
    # The whole loss is where the bar breaks: just beyond it, the curve is that without the bar, and not above it.
    at = found.limit_state.capacity * (1 + 1e-2)
    assert 0.9 < found.curve.at(at) / by_hand.curve.at(at) < 1.001
    # And the one that is drawn.
    (before, after), *_ = result.broken_ties[["load factor before", "load factor after"]].to_numpy()
    k = int(np.diff(found.curve.acceleration).argmin())
    lost = found.curve.acceleration[k + 1] / found.curve.acceleration[k]
    assert lost == pytest.approx(after / before, rel=1e-3)
    unlimited = bs.assess.local_mechanism(pushed_over(tied()), 1.35, SITE)
    assert unlimited.curve is None
    assert "no elongation limit" in unlimited.missing_curve


def test_a_pushover_that_ends_early_gives_the_displacement_it_reached(result):
    early = curve_of(result, capacity_of_facade(top=0.05))
    assert early.d0 == pytest.approx(3 * np.sin(0.05), rel=1e-6)
    assert "before α vanishes" in early.lines[0].formula
    uncertified = curve_of(result, capacity_of_facade(holds=30))
    assert uncertified.d0 == pytest.approx(3 * np.sin(0.0997 / 2), rel=1e-6)


def test_a_curve_that_ends_before_its_load_factor_has_come_down_has_a_note():
    """Half of the curve of a façade, as if blocks fell there."""
    result = pushed_over(facade())
    whole = result.capacity
    middle = int(np.searchsorted(-whole["load_factor"].to_numpy(), -0.05))
    for last, has_note in ((middle, True), (whole.sizes["step"] - 2, False)):
        cut = whole.isel(step=slice(0, last + 1)).assign(d0=np.nan)
        check = bs.assess.local_mechanism(dataclasses.replace(result, capacity=cut), 1.35, SITE)
        assert ("curve_end" in codes(check)) == has_note


def test_a_control_point_near_the_hinge_has_a_note(result):
    """Its displacement, relative to the weights, grows with the angle: 0.354 m instead of 0.3 m, on the unsafe side.

    From the outer face at z it is (z sin θ + 0.6 (1 − cos θ)) / z · 3 m at tan θ = 0.1: 1 % more at 2 m, 2.5 % at 1 m.
    """
    for z, has_note in ((6.0, False), (2.1, False), (1.0, True), (0.16, True)):
        case = bs.Pushover(
            "out",
            SELF_WEIGHT,
            push(0, -1, 0),
            control=("façade", (0, -1, 0)),
            control_point=Q_([0, DEPTH, z], "m"),
            steps=10,
        )
        check = bs.assess.local_mechanism(bs.run(facade(), case)["out"], 1.35, SITE)
        assert ("control_point" in codes(check)) == has_note
    state = check.limit_states["SLV, by displacement"]
    straight = bs.assess.local_mechanism(result, 1.35, SITE).limit_states[state.name]
    relied = bs.assess.local_mechanism(check.result, 1.35, SITE, method="displacement").limit_state
    assert (relied.capacity, relied.ratio) == pytest.approx((0.12, straight.ratio), rel=6e-3)
    assert state.ratio > 1.15 * straight.ratio
    site = SITE.at((state.ag + relied.ag) / 2)
    between = bs.assess.local_mechanism(check.result, 1.35, site, method="displacement")
    assert between.limit_states[state.name].ratio > 1
    assert not between.satisfied


def test_a_body_held_beyond_the_end_of_its_rotation_has_a_note():
    """A wall 0.5 × 3 m meets a pier that nobody counts on: by itself it ends where its centroid has moved by 0.25 m."""
    ground = bs.Block.box("ground", "[-1, -3, -0.5] m", "[6, 6, 0.5] m", STONE, fixed=True)
    wall = bs.Block.box("wall", "[0, 0, 0] m", "[4, 0.5, 3] m", STONE)
    pier = bs.Block.box("pier", "[1.5, -0.9, 0] m", "[1, 0.8, 2.5] m", STONE)
    model = model_of([ground, wall, pier], DRY, "wall before a pier")
    alone = bs.assess.local_mechanism(run(model), 1.35, SITE).limit_states["SLV, by displacement"]
    pushed = bs.Pushover("out", SELF_WEIGHT, push(0, -1, 0), control=("wall", (0, -1, 0)), steps=12)
    check = bs.assess.local_mechanism(bs.run(model, pushed)["out"], 1.35, SITE, method="displacement")
    assert check.curve.d0 > 0.3
    assert check.limit_states[alone.name].ratio > 1.2 * alone.ratio
    assert "overturns_alone" in codes(check)
    assert check.ratio == pytest.approx(alone.ratio, rel=1e-6)
    between = SITE.at((alone.ag + check.limit_states[alone.name].ag) / 2)
    check = bs.assess.local_mechanism(check.result, 1.35, between, method="displacement")
    assert check.limit_states[alone.name].ratio > 1
    assert not check.satisfied
    short = bs.Pushover("out", SELF_WEIGHT, push(0, -1, 0), control=("façade", (0, -1, 0)), steps=5)
    assert bs.assess.local_mechanism(bs.run(facade(), short)["out"], 1.35, SITE).notes == ()


@pytest.mark.parametrize("beside", [False, True])
def test_a_mechanism_at_a_height_has_a_note_under_the_spectrum_of_the_ground(beside):
    """Ties hold the lower storey: the upper one turns 3 m above the foot, even next to a support."""
    ground = bs.Block.box("ground", "[-1, -1, -0.5] m", "[7, 3, 0.5] m", STONE, fixed=True)
    lower = bs.Block.box("lower", "[0, -0.5, 0] m", "[5, 1.6, 3] m", STONE)
    upper = bs.Block.box("upper", "[0, 0, 3] m", "[5, 0.6, 3] m", STONE)
    tower = bs.Block.box("tower", "[0, 0.6, 3] m", "[5, 0.6, 1] m", STONE, fixed=True)
    result = run(model_of([ground, lower, upper, *[tower] * beside], DRY, "storeys"))
    check = bs.assess.local_mechanism(result, 1.35, SITE)
    assert check.notes == (assessment.ground_at_height(3.0, on_support=False),)
    mode = bs.assess.Mode("0.4 s", participation=1.3, shape=0.9, damping=0.1)
    assert bs.assess.local_mechanism(result, 1.35, bs.assess.floor_spectrum(SITE, [mode])).notes == ()


def test_other_limit_states_that_are_not_met_have_a_note(result):
    weak, strong = (bs.assess.ntc_spectrum(ag, 2.4, "0.3 s", "B") for ag in ("0.02 g_0", "0.6 g_0"))
    check = bs.assess.local_mechanism(result, 1.35, SITE, method="displacement", spectrum_sld=weak, spectrum_slc=strong)
    assert check.satisfied
    missed = check.limit_states["SLC, by displacement"]
    assert missed.ratio < 1
    assert check.notes == (assessment.state_missed(missed.name, missed.ratio, "not satisfied"),)
    linear = bs.assess.local_mechanism(result, 1.35, SITE, spectrum_sld=SITE.at(0.12 * g))
    assert (codes(linear), linear.limit_states["SLD"].satisfied) == (["state_missed"], False)


def at_height(ground=SITE, period="0.4 s", shape=0.9, **more):
    return bs.assess.floor_spectrum(ground, [bs.assess.Mode(period, participation=1.3, shape=shape, **more)])


@pytest.mark.parametrize(
    ("spectrum", "others", "words"),
    [
        (
            at_height(),
            {"spectrum_sld": SITE.at(0.05 * g)},
            "spectrum is a floor spectrum, spectrum_sld the spectrum of the ground, .* give spectrum_sld at",
        ),
        (SITE, {"spectrum_slc": at_height()}, "spectrum_slc is a floor spectrum, spectrum the spectrum of the ground"),
        (
            at_height(),
            {"spectrum_sld": at_height(SITE.at(0.05 * g), shape=0.5)},
            r"first mode is 1\.3 · 0\.5 = 0\.65 and 1\.3 · 0\.9 = 1\.17, which are two heights",
        ),
        (
            SITE,
            {"spectrum_sld": bs.assess.ntc_spectrum("0.05 g_0", 2.4, "0.3 s", "D")},
            "spectrum_sld and spectrum: soil 'D' and 'B', .* give both with the same soil",
        ),
        (
            SITE,
            {"spectrum_slc": bs.assess.ntc_spectrum("0.2 g_0", 2.4, "0.3 s", "B", "T2")},
            "spectrum and spectrum_slc: topography 'T1' and 'T2'",
        ),
        (
            at_height(),
            {"spectrum_sld": at_height(bs.assess.ntc_spectrum("0.05 g_0", 2.4, "0.3 s", "D"))},
            "soil 'D' and 'B'",
        ),
        (
            SITE,
            {"spectrum_sld": SITE.at(0.3 * g)},
            r"ag is 2\.942 m/s² = 0\.3 g and 1\.471 m/s² = 0\.15 g, but it must not fall",
        ),
        (SITE, {"spectrum_slc": SITE.at(0.1 * g)}, "spectrum and spectrum_slc: ag is"),
        (at_height(), {"spectrum_slc": at_height(SITE.at(0.1 * g))}, "spectrum and spectrum_slc: ag is"),
    ],
)
def test_demands_of_several_places_are_refused(result, spectrum, others, words):
    """An a_g,SLD of the ground is larger than at a height, and a_g,SLV is not taken below a_g,SLD."""
    with pytest.raises(bs.errors.ModelError, match=words):
        bs.assess.local_mechanism(result, 1.35, spectrum, **others)


def test_demands_of_one_place_are_taken(result):
    """Damage makes periods longer and adds damping; a table has no place."""
    table = bs.assess.table_spectrum(Q_([0, 0.1, 0.4, 6], "s"), Q_([0.3, 0.9, 0.9, 0.04], "g_0"), ag="0.25 g_0")
    longer = at_height(SITE.at(0.05 * g), period="0.3 s", damping=0.1)
    for spectrum, others in (
        (SITE, {"spectrum_sld": SITE, "spectrum_slc": SITE.at(0.2 * g)}),
        (at_height(), {"spectrum_sld": longer, "spectrum_slc": at_height(SITE.at(0.2 * g), shape=0.85)}),
        (at_height(), {"spectrum_sld": table}),
        (SITE, {"spectrum_sld": table, "spectrum_slc": table}),
    ):
        states = bs.assess.local_mechanism(result, 1.35, spectrum, **others).limit_states
        assert np.isfinite(states["SLD"].demand) == ("spectrum_sld" in others)


def test_a_mechanism_on_a_high_support_has_a_note_under_the_spectrum_of_the_ground():
    """A pinnacle on a tower that is a support, 9 m above the foot of a wall, begins before the wall does."""
    ground = bs.Block.box("ground", "[-1, -1, -0.5] m", "[8, 3, 0.5] m", STONE, fixed=True)
    tower = bs.Block.box("tower", "[5, 0, 0] m", "[1, 1, 9] m", STONE, fixed=True)
    wall = bs.Block.box("wall", "[0, 0, 0] m", "[4, 0.9, 3] m", STONE)
    pinnacle = bs.Block.box("pinnacle", "[5.3, 0.3, 9] m", "[0.4, 0.4, 2] m", STONE)
    result = run(model_of([ground, tower, wall, pinnacle], DRY, "two levels"))
    check = bs.assess.local_mechanism(result, 1.35, SITE)
    assert check.notes == (assessment.ground_at_height(9.0, on_support=True),)


def test_the_hazard_of_every_limit_state_is_printed(result):
    """SLD at 0.06 g with F0 = 2.5 and Tc* = 0.27 s, SLC at 0.19 g with 2.45 and 0.31 s, and the site of SLV once."""
    sites = {
        "SLD": bs.assess.ntc_spectrum("0.06 g_0", 2.5, "0.27 s", "B"),
        "SLC": bs.assess.ntc_spectrum("0.19 g_0", 2.45, "0.31 s", "B"),
    }
    check = bs.assess.local_mechanism(result, 1.35, SITE, spectrum_sld=sites["SLD"], spectrum_slc=sites["SLC"])
    printed = {part.title: str(part) for part in check.sections}
    for title, hazard in (
        ("SLD", "0.06 g, F0 = 2.5, T_C* = 0.27 s"),
        ("SLC, by displacement", "0.19 g, F0 = 2.45, T_C* = 0.31 s"),
        ("Demand at SLV", "0.15 g, F0 = 2.4, T_C* = 0.3 s"),
    ):
        assert hazard in printed[title]
    assert str(check).count("hazard at the site, as given") == 3


def test_an_anchorage_that_gives_way_has_a_note():
    """It is taken to slip or punch without limit, and neither does."""
    assert bs.assess.local_mechanism(run(tied()), 1.35, SITE).notes == ()
    check = bs.assess.local_mechanism(run(tied(punching_force="10 kN")), 1.35, SITE)
    assert check.notes == (assessment.anchorages(["bar 0"]),)


@pytest.mark.parametrize(("shape", "code"), [(0.1, "floor_below_ground"), (0.9, "floor_on_ground")])
def test_a_floor_spectrum_that_does_not_suit_the_mechanism_has_a_note(result, shape, code):
    """The façade turns about its foot, which no floor moves; near the base the modes omit the motion of the ground."""
    check = bs.assess.local_mechanism(result, 1.35, at_height(shape=shape, damping=0.1))
    assert codes(check) == [code]


def test_a_ratio_above_one_is_not_satisfied_if_a_weaker_motion_demands_more(result):
    """Soil D: S_S falls faster than a_g rises, and 0.26 g demands what 0.4 g does."""
    site = bs.assess.ntc_spectrum("0.4 g_0", 2.5, "0.3 s", "D")
    q = 1.02 * site.peak / (0.1 * g / 1.35)
    check = bs.assess.local_mechanism(result, 1.35, site, coefficients=bs.assess.Coefficients(q=q))
    assert check.ratio > 1
    assert not check.satisfied


@pytest.mark.parametrize(
    ("share", "text", "outcome"), [(0.99996, "0.99996", "not satisfied"), (1.00002, "1.00002", "satisfied")]
)
def test_a_ratio_next_to_one_does_not_read_as_one(result, share, text, outcome):
    """The demand a_Z / q is made to miss the capacity, 0.1 g / 1.35, by a share that four digits do not show."""
    q = share * SITE.peak / (0.1 * g / 1.35)
    check = bs.assess.local_mechanism(result, 1.35, SITE, coefficients=bs.assess.Coefficients(q=q))
    assert f"capacity / demand = {text}, {outcome}; equal at a_g = 1.471 m/s² = 0.1" in str(check.verdict)
    borne = float(str(check.verdict).partition("m/s² = ")[2].partition(" g")[0])
    assert (borne < 0.15) == (share < 1)
    assert "(site 0.15 g)" in str(check.verdict)
    (line,) = [line for line in check.limit_state.lines if line.what == "capacity / demand"]
    capacity, demand = (float(part.split()[0]) for part in line.formula.partition(" = ")[0].split(" / "))
    assert (capacity < demand) == (share < 1)
    assert line.formula.endswith(f" = {text}")


def test_another_limit_state_next_to_one_does_not_read_as_satisfied(result):
    """A demand of SLD that the capacity misses by what four digits do not show."""
    a0 = bs.assess.local_mechanism(result, 1.35, SITE).a0_star
    flat = bs.assess.table_spectrum(Q_([0, 4], "s"), Q_([a0 / 0.99996] * 2, "m/s^2"), ag=Q_(0.06, "g_0"))
    check = bs.assess.local_mechanism(result, 1.35, SITE, spectrum_sld=flat)
    assert assessment.state_missed("SLD", 0.99996, "not satisfied") in check.notes


def test_a_pushover_without_displacement_is_refused(result):
    with pytest.raises(bs.errors.ModelError, match="rests in the mechanism"):
        curve_of(result, capacity_of_facade(), point=(0.0, 0.0, 0.0))
    with pytest.raises(bs.errors.ModelError, match="the pushover has 1 certified step,"):
        curve_of(result, capacity_of_facade(holds=1))


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(
    ("parapet", "advised"),
    [
        ([0, 0.02, 0.04, 0.06, 0.2, 0.3], "run .* control= at block 'parapet', which reaches 0.3 m"),
        ([0, 0.02, 0.04, 0.06, 0.07, 0.08], "no block goes further without turning back"),
        ([0, 0.05, 0.2, 0.1, 0.2, 0.3], "no block goes further without turning back"),
    ],
)
def test_a_control_point_that_turns_back_gives_no_curve(result, side, parapet, advised):
    """Goes 0.1 m, comes back to 1 nm and ends there: of its states only those nearer than that were kept."""
    way = np.array([0, 0.05, 0.1, 0.02, 0.9e-9, 1e-9])
    push = -side * np.array([0.0, 1.0, 0.0])
    position = np.array([way, parapet]).T[:, :, None] * push + [0.0, 0.3, 3.0]
    back = xr.Dataset(
        {
            "load_factor": ("step", np.linspace(0.1, 0, 6)),
            "holds": ("step", np.ones(6, int)),
            "d0": ((), side * 1e-9),
            "position": (("step", "block", "axis"), position),
        },
        coords={"displacement": ("step", side * way), "block": ["façade", "parapet"]},
    )
    with pytest.raises(bs.errors.ModelError, match=rf"at block 'façade' turns back at 0\.1 m, .* {advised}"):
        curve_of(result, back)


def test_a_control_point_that_goes_back_by_next_to_nothing_gives_a_curve(result):
    """One hinge closes and another opens, as in an arch with fill: 15 µm back of 238 mm.

    If the control point passes twice, the lower α counts.
    """
    whole = capacity_of_facade(top=np.arctan(0.1))
    straight = curve_of(result, whole)
    for sign in (-1, 1):
        way, alpha = whole["displacement"].to_numpy().copy(), whole["load_factor"].to_numpy().copy()
        way[21], alpha[21] = way[20] - 15e-6 / 0.238 * way[-1], alpha[20] + sign * 1e-4 * alpha[0]
        back = whole.assign_coords(displacement=("step", way)).assign(load_factor=("step", alpha))
        curve = curve_of(result, back)
        assert np.all(np.diff(curve.displacement) > 0)
        for d, lowest in zip(way[[20, 21]] / 2, [min(alpha[20:22])] * 2, strict=True):
            assert curve.at(d) <= lowest * g / 1.35 * (1 + 1e-6)
        assert curve.d0 == pytest.approx(straight.d0, rel=1e-9)
        assert curve.at(0.4 * curve.d0) == pytest.approx(straight.at(0.4 * curve.d0), rel=1e-3)


def test_a_pushover_that_turns_back_is_checked_by_the_linear_method():
    """A body that stops as another takes over returns to its start."""
    pushed = pushed_over(facade(), steps=10)
    curve = pushed.capacity
    way = curve["displacement"].to_numpy() * np.where(curve["step"] < curve.sizes["step"] // 2, 1, 1e-9)
    curve = curve.assign_coords(displacement=("step", way)).assign(d0=way[-1])
    check = bs.assess.local_mechanism(dataclasses.replace(pushed, capacity=curve), 1.35, SITE)
    assert check.curve is None
    assert "the control point at block 'façade' turns back" in check.missing_curve
    assert check.ratio == pytest.approx(0.1 / 1.35 / 0.09, rel=1e-6)
    with pytest.raises(bs.errors.ModelError, match=r"turns back .* or give method='linear'"):
        bs.assess.local_mechanism(check.result, 1.35, SITE, method="displacement")


def test_a_curve_that_falls_at_once_has_no_displacement():
    """0.4 of the load factor is left at the first state: d_SLV = 0, and the demand there as well."""
    pushed = pushed_over(facade(), steps=10)
    curve = pushed.capacity.copy()
    curve["load_factor"] = curve["load_factor"].where(curve["step"] < 1, 0.4 * curve["load_factor"])
    fallen = dataclasses.replace(pushed, capacity=curve)
    check = bs.assess.local_mechanism(fallen, 1.35, SITE)
    assert "state_left_out" in codes(check)
    with pytest.raises(bs.errors.ModelError, match=r"loses more than 0.5 .* with more steps, or give method='linear'"):
        bs.assess.local_mechanism(fallen, 1.35, SITE, method="displacement")


@pytest.mark.parametrize("along", [(1, 0, 0), (0, 0, 1), (0, -1, -1), (1, -1, 0), (0.1, -1, 0)])
def test_a_control_direction_across_the_push_is_refused(result, along):
    """Followed downwards as well, the corner of the top would have a larger d0, as it sinks."""
    along = tuple(np.array(along) / np.linalg.norm(along))
    with pytest.raises(bs.errors.ModelError, match=r"the control point .* control=\('façade', \(0, -1, 0\)\)"):
        curve_of(result, capacity_of_facade(), control=("façade", along))


def test_a_control_point_at_rest_names_the_moving_blocks():
    """The arch goes as three bodies on piers that rest: a pushover of the same point would end as this one."""
    size = {"span": "3.6 m", "thickness": "0.35 m", "depth": "1 m", "pier_width": "1.1 m", "pier_height": "2.4 m"}
    blocks = bs.structures.arch_on_piers(voussoirs=13, pier_courses=2, material=STONE, **size)
    control = ("left.2", "+x")
    pushed = bs.Pushover("out of plane", SELF_WEIGHT, push(1, 0, 0), control=control, steps=3)
    found = run(model_of(blocks, DRY), pushed)
    assert found.capacity is None
    check = bs.assess.local_mechanism(found, 1.35, SITE)
    assert check.missing_curve.startswith("no capacity curve: the control point at block 'left.2' does not move along ")
    assert " moves furthest, along " in check.missing_curve
    assert "run a Pushover" not in check.missing_curve


def test_rounded_corners_count_from_the_first_state():
    control = ("façade", (0, -1, 0))
    case = bs.Pushover("out", SELF_WEIGHT, push(0, -1, 0), control=control, steps=10, corner_rounding="30 mm")
    result = bs.run(facade(), case)["out"]
    check = bs.assess.local_mechanism(result, 1.35, SITE)
    # (b / 2 − r) / (h / 2) at rest, with b = 0.6 m, h = 6 m and r = 0.03 m.
    assert check.curve.at(0.0) == pytest.approx(0.09 * g / 1.35, rel=1e-4)
    assert check.a0_star == pytest.approx(0.1 * g / 1.35, rel=1e-6)
    assert "rounded_corners" in codes(check)


def test_a_curve_that_jumps_has_a_note():
    pushed = pushed_over(facade(), steps=10)
    smooth = bs.assess.local_mechanism(pushed, 1.35, SITE)
    assert "curve_doubt" not in codes(smooth)
    curve = pushed.capacity.copy()
    curve["load_factor"] = curve["load_factor"].where(curve["step"] < 5, 0.8 * curve["load_factor"])
    jumping = bs.assess.local_mechanism(dataclasses.replace(pushed, capacity=curve), 1.35, SITE)
    assert "curve_doubt" in codes(jumping)


@pytest.mark.parametrize(
    ("variable", "words"),
    [
        (bs.LoadPattern("roof", [bs.PointLoad("façade", "[2.5, 0.3, 6] m", "[0, -9, 0] kN")]), "has no BodyForce"),
        (push(0, -0.8, 0.6), "pushes along"),
        (push(0, -1, 0.005), "pushes along"),
        (
            bs.LoadPattern("turn", [bs.BodyForce("-y"), bs.Moment("façade", "[5, 0, 0] kN*m")]),
            "has couples",
        ),
        (
            bs.LoadPattern("two", [bs.BodyForce("-y"), bs.PointLoad("façade", "[2.5, 0.3, 6] m", "[0, 0, -9] kN")]),
            "across or against",
        ),
    ],
)
def test_a_push_must_be_horizontal_and_proportional_to_weight(variable, words):
    found = run(facade(), case(variable))
    with pytest.raises(bs.errors.ModelError, match=words):
        bs.assess.local_mechanism(found, 1.35, SITE)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"confidence_factor": 1.2}, "FC is at least 1.35"),
        ({"confidence_factor": 0.9}, "from 1 to 10"),
        ({"confidence_factor": True}, "from 1 to 10"),
        ({"knowledge_level": "LC4"}, "known are LC1, LC2, LC3"),
        ({"confidence_factor": 1.35, "knowledge_level": "LC2"}, "give one of the two"),
        ({"method": "by eye"}, "known are linear, displacement"),
        ({"spectrum": 0.15}, r"spectrum 0.15 is a float; give bs.assess.ntc_spectrum"),
        ({"spectrum": None}, "spectrum None is a NoneType; give"),
        ({"spectrum_sld": 0.15}, "spectrum_sld 0.15 is a float; give bs.assess.ntc_spectrum"),
        ({"spectrum_slc": "x"}, "spectrum_slc 'x' is a str; give bs.assess.ntc_spectrum"),
        ({"coefficients": {"q": 1.5}}, "coefficients .* is a dict; give bs.assess.Coefficients"),
        ({"beside": 0.1}, "beside 0.1 is a float; give bs.assess.overturning"),
    ],
)
def test_arguments_that_make_no_check_are_refused(result, arguments, words):
    with pytest.raises(bs.errors.ModelError, match=words):
        bs.assess.local_mechanism(result, **{"spectrum": SITE, **arguments})


def test_the_confidence_factor_depends_on_crushing(result):
    assert bs.assess.local_mechanism(result, spectrum=SITE).confidence_factor == 1.35
    assert bs.assess.local_mechanism(result, spectrum=SITE, knowledge_level="LC3").confidence_factor == 1.35
    assert bs.assess.local_mechanism(result, 1.5, SITE).confidence_factor == 1.5
    own = {"knowledge_level": "LC2", "coefficients": bs.assess.Coefficients(without_crushing=1.0)}
    assert bs.assess.local_mechanism(result, spectrum=SITE, **own).confidence_factor == 1.2
    crushing = run(facade(DRY.varied(compressive_strength="2 MPa")))
    with pytest.raises(bs.errors.ModelError, match="give the factor, or knowledge_level"):
        bs.assess.local_mechanism(crushing, spectrum=SITE)
    assert bs.assess.local_mechanism(crushing, 1.2, SITE).confidence_factor == 1.2
    # Another joint of the same body that does not count crushing.
    ground, wall = facade().blocks
    behind = bs.Block.box("behind", Q_([0, DEPTH, 0], "m"), "[5, 1, 2] m", STONE, fixed=True)
    foot = bs.detect_interfaces(
        [ground, wall], joint_material=bs.JointMaterial("lime", 0.7, compressive_strength="2 MPa")
    )
    back = bs.detect_interfaces([wall, behind], joint_material=DRY)
    both = bs.Model("two joints", [ground, wall, behind], [*foot.interfaces, *back.interfaces])
    with pytest.raises(bs.errors.ModelError, match=r"FC is at least 1\.35"):
        bs.assess.local_mechanism(run(both), 1.2, SITE)


def test_results_without_a_collapse_state_are_refused(result):
    model = facade()
    up = solve(model, push(0, 0, -1))
    assert up.status == "unbounded"
    with pytest.raises(bs.errors.ModelError, match="converged collapse state"):
        bs.assess.local_mechanism(up, 1.35, SITE)
    settled = dataclasses.replace(result, case=SimpleNamespace(name="left pier"))
    with pytest.raises(bs.errors.ModelError, match="has no push"):
        bs.assess.local_mechanism(settled, 1.35, SITE)
    for other in (None, model, result.history):
        with pytest.raises(bs.errors.ModelError, match="is not a limit case's result"):
            bs.assess.local_mechanism(other, 1.35, SITE)


def test_a_hand_calculation_of_nothing_is_refused(result):
    model, of = result.model, result.case
    for blocks, edge, error, words in (
        (["wall"], EDGE, bs.errors.UnknownNameError, "no block 'wall'"),
        (["ground"], EDGE, bs.errors.ModelError, "name free blocks"),
        ([], EDGE, bs.errors.ModelError, "name free blocks"),
        (["façade"], Q_([0, 0, 0], "m"), bs.errors.ModelError, "two ends"),
        (["façade"], Q_([[0, 0, 0], [0, 0.6, 0]], "m"), bs.errors.ModelError, "does not turn"),
        (["façade"], EDGE * 1000, bs.errors.ModelError, r"from \[0.0, 0.0, 0.0\] to \[5000.0, .* not at the blocks"),
        (["façade"], EDGE + Q_([0, 0.6, 0], "m"), bs.errors.ModelError, r"do not hold .* \(α0 = -0.1\); give the edge"),
        (["façade"], [[0, 0, 0], [5, 0, 0]], bs.errors.UnitError, "no unit"),
    ):
        with pytest.raises(error, match=words):
            bs.assess.overturning(model, of, blocks, edge)


def test_a_hand_calculation_without_a_push_is_refused(result):
    settled = bs.SettlementCase("sinking", SELF_WEIGHT, ["ground"], "-z")
    with pytest.raises(bs.errors.ModelError, match="case 'sinking' is a SettlementCase; give a LimitCase with a push"):
        bs.assess.overturning(result.model, settled, ["façade"], EDGE)


@pytest.mark.parametrize(
    ("strength", "words"),
    [("0 MPa", "give more than zero"), ("-1 MPa", "give more than zero"), ("10 kPa", "set back by 3.24 m by crushing")],
)
def test_a_strength_that_holds_nothing_is_refused(result, strength, words):
    """N / (2 f_c l) = 324 kN / (2 · 10 kPa · 5 m) = 3.24 m, behind the wall."""
    with pytest.raises(bs.errors.ModelError, match=words):
        bs.assess.overturning(result.model, result.case, ["façade"], EDGE, compressive_strength=strength)


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


def test_ties_that_lift_the_blocks_off_the_edge_are_refused():
    """Upwards at 45 degrees to a point 2 m behind: 600 kN pull 537 kN up, more than the 324 kN of the façade."""
    model = tied(force=600, to=(2, 9), fixed=True)
    with pytest.raises(bs.errors.ModelError, match="they lift"):
        bs.assess.overturning(model, case(), ["façade"], EDGE)


def test_a_tie_between_the_edge_and_the_hinge_by_hand():
    """One of 100 kN down at 10 mm from the edge is slackened by the rotation about the hinge, 32.4 mm from it."""
    ground, wall = facade(DRY.varied(compressive_strength="1 MPa")).blocks
    found = bs.detect_interfaces([ground, wall], joint_material=DRY.varied(compressive_strength="1 MPa"))
    ends = ("façade", Q_([2.5, 0.01, 5], "m")), ("ground", Q_([2.5, 0.01, -0.2], "m"))
    model = bs.Model("anchored", [ground, wall], found, ties=[bs.Tie("bar", *ends, yield_force="100 kN")])
    result = run(model)
    hand = bs.assess.overturning(model, result.case, ["façade"], EDGE, compressive_strength="1 MPa")
    assert (hand.setback, hand.alpha0) == pytest.approx((0.0324, 0.0892), rel=1e-6)
    assert result.load_factor == pytest.approx(0.0892, rel=1e-5)


def test_an_upright_edge_does_not_crush(result):
    edge = Q_([[0, 0, 0], [0, 0, HEIGHT]], "m")
    with pytest.raises(bs.errors.ModelError, match="an edge that is upright has no joint"):
        bs.assess.overturning(result.model, result.case, ["façade"], edge, compressive_strength="1 MPa")


@pytest.mark.parametrize(
    ("blocks", "edge", "words"),
    [
        (["façade"], [[0, 0, 0], [0, 0, HEIGHT]], "weight does not hold blocks that turn about an upright edge"),
        (["façade"], [[0, 0, 0], [0, 0, 0]], r"both ends of the edge are at \(0, 0, 0\) m; give its two ends"),
        (["façade"], [[0, 0, 0]], r"edge of shape \(1, 3\); give its two ends"),
        (["façade", "façade"], [[0, 0, 0], [5, 0, 0]], "'façade' is given twice; name each block once"),
    ],
)
def test_wrong_edges_and_blocks_are_refused(result, blocks, edge, words):
    with pytest.raises(bs.errors.ModelError, match=words):
        bs.assess.overturning(result.model, result.case, blocks, Q_(edge, "m"))


def test_blocks_that_stand_on_named_ones_have_a_line(small):
    names = [b.name for b in small.model.blocks if not b.fixed]
    lower = [n for n in names if small.model.block(n).centroid[2] < HEIGHT / 2]
    text = str(bs.assess.overturning(small.model, small.case, lower, EDGE))
    above = min(set(names) - set(lower), key=lambda n: small.model.block(n).centroid[2])
    assert "standing on them, not counted" in text
    assert above in text
    whole = str(bs.assess.overturning(small.model, small.case, names, EDGE))
    assert "standing" not in whole
    assert whole.startswith(f"overturning of {len(names)} blocks about")


def edge_at(height, y=0.0):
    return Q_([[0, y, height], [LENGTH, y, height]], "m")


@pytest.mark.parametrize("height", [0.5, 2.8])
def test_an_edge_without_a_joint_has_a_note(result, height):
    """About an edge at z the façade begins at 0.3 / (3 − z), and the part below z hangs from it."""
    hand = bs.assess.overturning(result.model, result.case, ["façade"], edge_at(height))
    assert hand.alpha0 == pytest.approx(0.3 / (HEIGHT / 2 - height))
    (note,) = hand.notes
    assert note == assessment.edge_is_high(height, "façade", 0)
    assert f"note: {note}" in str(hand)
    check = bs.assess.local_mechanism(result, 1.35, SITE, beside=hand)
    assert note in check.notes


@pytest.mark.parametrize(("over", "notes"), [(0.0, []), (0.1, ["edge_overhangs"])])
def test_an_edge_beyond_the_joint_has_a_note(over, notes):
    """A bell-cote 0.5 m thick and 2.5 m high reaches beyond its ledge, about whose edge it turns.

    It begins at (0.25 − over) / 1.25, thus 0.12 with over = 0.1 m, and about its own lower edge at 0.2.
    """
    ledge = bs.Block.box("ledge", "[0, 0, -1] m", "[2, 0.6, 1] m", STONE, fixed=True)
    cote = bs.Block.box("bell-cote", Q_([0, -over, 0], "m"), "[2, 0.5, 2.5] m", STONE)
    model = model_of([ledge, cote], DRY)
    own, joint = (Q_([[0, y, 0], [2, y, 0]], "m") for y in (-over, 0.0))
    beyond, at_joint = (bs.assess.overturning(model, case(), ["bell-cote"], edge) for edge in (own, joint))
    assert (beyond.alpha0, at_joint.alpha0) == pytest.approx((0.2, (0.25 - over) / 1.25))
    assert at_joint.notes == ()
    assert codes(beyond) == notes


def test_an_edge_over_an_opening_crushes_over_its_piers_alone():
    """Piers of 1.25 m on each side of a door of 2.5 m bear a façade of 18 · 0.6 · (2.5 · 2 + 5 · 4) = 270 kN.

    With f_c = 1 MPa over 2.5 m the hinge is set back by 270 / (2 · 1000 · 2.5) = 0.054 m, over 5 m by half as much.
    """
    origins, lengths = [[0, 0, 0], [3.75, 0, 0], [0, 0, 2]], [1.25, 1.25, 5]
    parts = [
        bs.Block.box(f"part {k}", Q_(origin, "m"), Q_([length, DEPTH, 4 if k == 2 else 2], "m"), STONE)
        for k, (origin, length) in enumerate(zip(origins, lengths, strict=True))
    ]
    model = model_of([facade().blocks[0], *parts], DRY.varied(compressive_strength="1 MPa"))
    names = [b.name for b in parts]

    def of(length, strength="1 MPa"):
        edge = Q_([[0, 0, 0], [length, 0, 0]], "m")
        return bs.assess.overturning(model, case(), names, edge, compressive_strength=strength)

    assert (of(5.0).setback, of(2.5).setback) == pytest.approx((0.027, 0.054))
    assert of(5.0).notes == (assessment.edge_is_long(5.0, 2.5),)
    assert of(2.5).notes == of(5.0, None).notes == ()
    assert run(model).load_factor == pytest.approx(of(2.5).alpha0, rel=1e-6)


def test_blocks_that_turn_are_no_joint_for_each_other(small):
    """The joint above the second course, 1 m up, is within the group: it belongs to the blocks above alone."""
    names = [b.name for b in small.model.blocks if not b.fixed]
    upper = [n for n in names if small.model.block(n).centroid[2] > 1]
    whole, part = (bs.assess.overturning(small.model, small.case, of, edge_at(1.0)) for of in (names, upper))
    assert codes(whole) == ["edge_is_high"]
    assert f" and {len(names) - len(upper) - 1} more, " in whole.notes[0].text
    assert part.notes == ()
    slanted = Q_([[0, 0, 1], [LENGTH, 0.3, 1]], "m")
    assert bs.assess.overturning(small.model, small.case, upper, slanted).notes == ()


@pytest.mark.parametrize(("joint", "has_note"), [("none", True), ("stop", False), ("end", True), ("back", True)])
def test_a_stop_that_the_wall_leans_on_is_a_joint(joint, has_note):
    """Ground filled up to 1 m in front holds an edge there; walls at its end and its back do not."""
    ground, wall = facade().blocks
    beside = {
        "stop": bs.Block.box("stop", "[0, -1, 0] m", "[5, 1, 1] m", STONE, fixed=True),
        "end": bs.Block.box("end", "[5, 0, 0] m", "[1, 0.6, 6] m", STONE, fixed=True),
        "back": bs.Block.box("back", "[0, 0.6, 0] m", "[5, 1, 6] m", STONE, fixed=True),
    }
    model = model_of([ground, wall, *([beside[joint]] if joint in beside else [])], DRY)
    hand = bs.assess.overturning(model, case(), ["façade"], edge_at(1.0))
    assert bool(hand.notes) == has_note
    assert bs.assess.overturning(model, case(), ["façade"], EDGE).notes == ()


def test_an_edge_up_a_stair_of_joints_is_at_them(small):
    """A triangle of the wall over a stair of its units turns about a line through the corners of the stair."""
    model = small.model
    corners = {b.name: b.shape.vertices for b in model.blocks if not b.fixed}
    above = [name for name, at in corners.items() if at[:, 2].min() >= at[:, 0].min() - 1e-9]
    hand = bs.assess.overturning(model, small.case, above, Q_([[0, 0, 0], [LENGTH, 0, LENGTH]], "m"))
    assert hand.notes == ()


def test_the_ends_of_an_edge_have_no_order(result):
    one, other = (bs.assess.overturning(result.model, result.case, ["façade"], edge) for edge in (EDGE, EDGE[::-1]))
    assert (one.alpha0, one.d0) == pytest.approx((0.1, 0.3), rel=1e-9)
    assert str(one).startswith("overturning of 1 block about an edge")
    assert (other.alpha0, other.d0) == pytest.approx((one.alpha0, one.d0), rel=1e-12)
    for angle in (0.02, 0.05):
        assert other.rotation.load_factor(angle) == pytest.approx(np.tan(np.arctan(0.1) - angle), rel=1e-9)


@pytest.mark.parametrize("tolerance", [0, -1, 1e-6, 2, np.nan, "0.02"])
def test_a_tolerance_below_the_accuracy_is_refused(small, tolerance):
    """Each block a body of its own, e* would be 0.75."""
    with pytest.raises(bs.errors.ModelError, match=r"macro_blocks: tolerance .* from 0.001 to 1"):
        bs.assess.local_mechanism(small, 1.35, SITE, tolerance=tolerance)
    assert bs.assess.local_mechanism(small, 1.35, SITE, tolerance=1e-3).e_star == pytest.approx(1.0, rel=1e-6)


def test_a_mechanism_by_hand_below_the_one_found_has_a_note(result):
    lower = bs.assess.overturning(result.model, result.case, ["façade"], EDGE, compressive_strength="0.5 MPa")
    check = bs.assess.local_mechanism(result, 1.35, SITE, beside=lower)
    assert check.notes == (assessment.hand_is_lower(0.0784, check.alpha0),)
    equal = bs.assess.overturning(result.model, result.case, ["façade"], EDGE)
    assert bs.assess.local_mechanism(result, 1.35, SITE, beside=equal).notes == ()


def test_a_mechanism_by_hand_of_other_weights_or_loads_is_refused(result):
    """Another façade begins elsewhere, and so does this one where it is pushed the other way or carries a roof."""
    model = result.model
    roof = bs.LoadPattern("roof", [bs.SelfWeight(), bs.Weight("façade", "[2.5, 0.4, 6] m", "90 kN")])
    thick = bs.Block.box("façade", "[0, 0, 0] m", Q_([LENGTH, 2 * DEPTH, HEIGHT], "m"), STONE)
    others = [
        bs.assess.overturning(model_of([model.block("ground"), thick], DRY), case(), ["façade"], EDGE),
        bs.assess.overturning(model, case(dead=roof), ["façade"], EDGE),
        bs.assess.overturning(model, case(push(0, 1, 0)), ["façade"], edge_at(0.0, DEPTH)),
        bs.assess.overturning(small_blocks(), case(), ["1.1"], Q_([[0, 0, 0], [1, 0, 0]], "m")),
    ]
    for hand in others:
        with pytest.raises(bs.errors.ModelError, match="beside has other blocks or loads than case 'out of plane'"):
            bs.assess.local_mechanism(result, 1.35, SITE, beside=hand)


def test_a_mechanism_by_hand_higher_up_has_a_note():
    """The upper storey, 2 m on 4 m, begins at α0 = 0.3, three times the α0 of both, with the demand of its height."""
    ground = bs.Block.box("ground", "[-1, -1, -0.5] m", "[7, 3, 0.5] m", STONE, fixed=True)
    lower, upper = (
        bs.Block.box(name, Q_([0, 0, z], "m"), Q_([5, 0.6, height], "m"), STONE)
        for name, z, height in (("lower", 0, 4), ("upper", 4, 2))
    )
    result = run(model_of([ground, lower, upper], DRY, "storeys"))
    by_hand = bs.assess.overturning(result.model, result.case, ["upper"], EDGE + Q_([0, 0, 4], "m"))
    assert by_hand.alpha0 == pytest.approx(0.3)
    check = bs.assess.local_mechanism(result, 1.35, SITE, beside=by_hand)
    assert "compared with the one found             0.3 / 0.1 = 3" in str(check)
    assert check.notes == (assessment.hand_is_higher(4.0),)
    level = bs.assess.overturning(result.model, result.case, ["lower", "upper"], EDGE)
    plain = bs.assess.local_mechanism(result, 1.35, SITE, beside=level)
    assert plain.notes == ()
    assert bs.assess.lines.HIGHER in str(plain)


def test_numbers_are_printed_as_an_engineer_reads_them(result):
    check = bs.assess.local_mechanism(result, 1.35, SITE)
    assert bs.assess.lines.ROUNDED in str(check)
    still = dataclasses.replace(
        check, participation=dataclasses.replace(check.participation, displacement=np.array([-4.8e-11]))
    )
    assert "P + Q = " in str(still)
    assert "δ = 0\n" in str(still)


def test_the_loading_path_does_not_count_on_friction_that_self_stress_presses():
    """A wall of two blocks, 0.5 m and 0.35 m thick, whose lower block touches a fixed ledge at its end.

    Friction on the ledge is whatever self-stress makes it. Held there, the upper block turns alone, 0.35 m / 1.6 m. Not
    held, both turn about the foot: weights of 5.6 and 2.24, arms of 0.25 m and 0.175 m, heights of 1.4 m and 3.6 m.
    """
    parts = [
        ("base", [-1, -1, -0.5], [6, 3, 0.5]),
        ("ledge", [-0.8, 0, 2.4], [0.8, 0.35, 0.4]),
        ("lower", [0, 0, 0], [4, 0.5, 2.8]),
        ("upper", [0, 0, 2.8], [4, 0.35, 1.6]),
    ]
    fixed = ("base", "ledge")
    blocks = [bs.Block.box(n, Q_(at, "m"), Q_(size, "m"), STONE, fixed=n in fixed) for n, at, size in parts]
    manager = bs.AnalysisManager(model_of(blocks, bs.JointMaterial("dry", 0.6)))
    spread = manager.run([case()], spread=["path", "fictitious"]).spread("out of plane")
    both = (5.6 * 0.25 + 2.24 * 0.175) / (5.6 * 1.4 + 2.24 * 3.6)
    assert spread.runs["fictitious"].load_factor == pytest.approx(0.35 / 1.6, rel=1e-5)
    assert spread.load_factor == pytest.approx(both, rel=5e-3)
    # The schedules of the paper's procedure are no part of the range.
    assert spread.path_dependence == pytest.approx((both, both), rel=5e-3)
    check = bs.assess.local_mechanism(spread, 1.35, SITE)
    assert check.alpha0 == spread.load_factor
    assert check.ratio <= check.limit_states[check.relied_on].ratio
