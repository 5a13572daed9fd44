"""Capacity curves by hand: ties, hinges, pushovers."""

import dataclasses
from types import SimpleNamespace

import attrs
import numpy as np
import pytest
import xarray as xr
from scipy.optimize import brentq

import blockstruct as bs
import facades
from blockstruct import Q_
from blockstruct.assess.capacity import curve_of_pushover
from facades import DEPTH, DRY, GROUND, HEIGHT, SITE, STONE, box, case, checked, codes, facade, pushed_over, run, tied
from meshes import QUADS
from structures import SELF_WEIGHT, extruded, model_of, push

g = 9.80665


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
    check = checked(run(tied(breaks_at=0.1)), method="displacement")
    curve = check.curve
    ((d, loss),) = curve.losses
    assert (d, loss) == pytest.approx((moved, of_tie / (197.2 / 972)), rel=1e-5)
    assert check.verdict.state.capacity == pytest.approx(moved, rel=1e-6)
    assert curve.at(d) == pytest.approx((free + of_tie) * g / 1.35, rel=1e-5)
    assert curve.at(d * 1.000001) == pytest.approx(free * g / 1.35, rel=1e-4)
    assert curve.d0 == pytest.approx(0.3, rel=1e-5)
    beyond = 3 * np.sin(0.08) + 0.3 * (1 - np.cos(0.08))
    assert curve.at(beyond) == pytest.approx(np.tan(np.arctan(0.1) - 0.08) * g / 1.35, rel=1e-3)


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
    blocks = [GROUND, box("post", [0, 1.5, 0], [1, 0.5, 6], fixed=True), box("wall", [0, 0, 0], [1, 0.5, 4])]
    ends = ("post", Q_([0.5, 1.5, 5], "m")), ("wall", Q_([0.5, 0.5, 3], "m"))
    breaks = {} if limit is None else {"elongation_limit": Q_(limit, "m")}
    tie = bs.Tie("tie", *ends, yield_force=Q_(force, "kN"), **breaks)
    joint = bs.JointMaterial("rough", 2, **({} if strength is None else {"compressive_strength": Q_(strength, "MPa")}))
    check = checked(run(model_of(blocks, joint).with_ties([tie])))
    assert (check.curve is not None) == straight
    assert straight or "the hinge back by 0.008944 m" in check.missing_curve


@pytest.mark.parametrize(("limit", "straight"), [(0.02, True), (0.2, False)])
def test_a_tie_that_pulls_the_foot_inwards_as_the_push_falls(limit, straight):
    """A wall of 36 kN, 1 m × 0.5 m × 4 m, with a friction of 0.3, and a tie of 18 kN at 0.8 m.

    At rest α0 = (36 · 0.25 + 18 · 0.8) / (36 · 2) = 0.325, and the foot is pulled inwards by 18 − 36 α0 = 6.3 kN. The
    friction of 10.8 kN is used up at α = 0.2: at 0.125 rad or so, where the tie is some 0.1 m longer.
    """
    blocks = [GROUND, box("post", [0, 2.5, 0], [1, 0.5, 2], fixed=True), box("wall", [0, 0, 0], [1, 0.5, 4])]
    ends = ("post", Q_([0.5, 2.5, 0.8], "m")), ("wall", Q_([0.5, 0.5, 0.8], "m"))
    tie = bs.Tie("tie", *ends, yield_force="18 kN", elongation_limit=Q_(limit, "m"))
    check = checked(run(model_of(blocks, DRY.varied(friction_coefficient=0.3)).with_ties([tie])))
    assert check.alpha0 == pytest.approx(0.325, rel=1e-6)
    assert (check.curve is not None) == straight
    assert straight or "need more friction at the hinge" in check.missing_curve


@pytest.mark.parametrize("of", ["straight", "pushover"])
def test_ties_that_break_together_are_one_loss(of):
    """Two bars of 10 kN are one of 20 kN: each alone loses less than half of the strength, both more."""
    d_SLV = []
    for bars in (1, 2):
        model = tied(breaks_at=0.1, force=20 / bars, bars=bars)
        result = run(model) if of == "straight" else pushed_over(model, 30)
        check = checked(result, method="displacement")
        d_SLV.append(check.verdict.state.capacity)
        assert d_SLV[-1] < 0.4 * check.curve.d0 * 0.6
    assert d_SLV[1] == pytest.approx(d_SLV[0], rel=1e-6)


def test_the_loss_of_a_tie_in_a_pushover_does_not_depend_on_its_steps():
    """Less than half is lost; the way to the next state, on which α falls as well, would make it more."""
    by_hand = checked(run(tied(0.1, 19))).curve
    ((_, loss),) = by_hand.losses
    assert loss < 0.5
    for steps in (8, 30):
        found = checked(pushed_over(tied(0.1, 19), steps), method="displacement")
        assert max(lost for _, lost in found.curve.losses) == pytest.approx(loss, abs=3e-3)
        assert found.verdict.state.capacity == pytest.approx(0.4 * found.curve.d0)


def prism(base, height, angle, **joint):
    """The push, along an angle, of a block on a base [(x, y), …] and a joint that does not slide."""
    block = attrs.evolve(extruded("block", base, 0, height), material=STONE)
    model = model_of([GROUND, block], bs.JointMaterial("rough", 3).varied(**joint))
    return run(model, case(push(np.cos(angle), np.sin(angle), 0.0)))


PENTAGON = [(-0.5, -0.5), (0.2, -0.5), (0.5, 0.4), (0.5, 0.5), (-0.5, 0.5)]


def test_a_resultant_that_leaves_the_hinge_has_no_straight_curve():
    """About the edge at x = 0.5 m the resultant is at y = y_G + α u_y z_G, at rest at its middle, 0.45 m.

    With R = √(0.5624² + 1.5²) and β = atan(0.5624 / 1.5), α = tan(β − θ) / u_x, z_G = R cos(β − θ): y falls below the
    end of the edge, 0.4 m, at R (sin β − sin(β − θ)) u_x = 0.0540 m, and α vanishes about it at 0.4511 m.
    """
    # From the centroid of the pentagon to the middle of its edge from (0.5, 0.4) to (0.5, 0.5).
    at, u = np.array([0.5624277, 1.5]), np.arctan2(0.45 - 0.0312139, 0.5 + 0.0624277)
    R, beta = np.hypot(*at), np.arctan(at[0] / at[1])

    def y(theta):
        return 0.0312139 + np.tan(u) * np.tan(beta - theta) * R * np.cos(beta - theta)

    assert y(0) == pytest.approx(0.45, abs=1e-5)
    left = brentq(lambda theta: y(theta) - 0.4, 0, 0.2)
    d = R * (np.sin(beta) - np.sin(beta - left)) * np.cos(u)
    found = prism(PENTAGON, 3, u)
    check = checked(found)
    assert check.curve is None
    assert d == pytest.approx(0.054, abs=2e-4)
    assert float(check.missing_curve.split("d = ")[1].split(" m")[0]) == pytest.approx(d, rel=0.01)
    assert "vanishes about it at 0.4511 m, the resultant leaves the hinge, which is 0.1 m long" in check.missing_curve
    edge = Q_([[0.5, 0.4, 0], [0.5, 0.5, 0]], "m")
    hand = bs.assess.overturning(found.model, found.case, ["block"], edge)
    assert hand.d0 == pytest.approx(0.4511, abs=1e-4)
    (line,) = (line for line in hand.lines if line.what == "the resultant leaves the edge")
    assert float(line.formula.split("d = ")[1].split(" m")[0]) == pytest.approx(d, rel=0.01)


def test_a_pier_over_its_corner_has_no_straight_curve():
    """0.6 × 0.6 × 2 m at 45°: over the corner d0 would be 0.4243 m, and over the edge next to it 0.2121 m."""
    base = [(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3)]
    check = checked(prism(base, 2, np.pi / 4))
    assert check.alpha0 == pytest.approx(np.hypot(0.6, 0.6) / 2, rel=1e-5)
    crushing = checked(prism(base, 2, np.pi / 4, compressive_strength="2 MPa"))
    for of in (check, crushing):
        assert "turns about a point and not about an edge" in of.missing_curve
    assert checked(prism(base, 2, 0.0)).curve.d0 == pytest.approx(0.3, rel=1e-5)


def leaning(*limits):
    """A wall 0.5 m × 3 m that leans by 0.7 m towards -y, held by ties of 10 kN to a wall 3.5 m behind, at 2.8 m."""
    corners = [[x, y - 0.7 * z / 3, z] for z in (0, 3) for x, y in ((0, 0), (1, 0), (1, 0.5), (0, 0.5))]
    wall = bs.Block.from_faces("wall", Q_(corners, "m"), QUADS, STONE)
    at = [("wall", Q_([0.5, -0.7 * 2.8 / 3, 2.8], "m")), ("back", Q_([0.5, 3, 2.8], "m"))]
    more = [{} if limit is None else {"elongation_limit": Q_(limit, "m")} for limit in limits]
    ties = [bs.Tie(f"bar {k}", *at, yield_force="10 kN", **of) for k, of in enumerate(more)]
    return model_of([wall, GROUND, box("back", [0, 3, 0], [1, 1, 3], fixed=True)], DRY, "leaning").with_ties(ties)


def test_a_leaning_wall_that_ties_hold_goes_as_far_as_they_do():
    """W = 27 kN, its centroid 0.1 m beyond the edge: α0 = (Σ T · 2.8 − 27 · 0.1) / (27 · 1.5).

    A tie of 20 mm breaks at θ = 0.02 / 2.8, to first order: d0 = 1.5 θ = 10.71 mm; a second one of 30 mm at 16.07 mm.
    They lose their share of the moment, 28 of 25.3 kN m and 28 and 56 of 53.3 kN m, down to zero, at most all of it.
    """
    one, two = (checked(run(leaning(*limits))) for limits in ((0.02,), (0.02, 0.03)))
    assert one.alpha0 == pytest.approx((28 - 2.7) / 40.5, rel=1e-6)
    assert two.alpha0 == pytest.approx((56 - 2.7) / 40.5, rel=1e-6)
    assert one.curve.d0 == pytest.approx(1.5 * 0.02 / 2.8, rel=2e-3)
    assert two.curve.d0 == pytest.approx(1.5 * 0.03 / 2.8, rel=2e-3)
    assert [d for d, _ in two.curve.losses] == pytest.approx([one.curve.d0, two.curve.d0], rel=1e-9)
    assert [lost for _, lost in one.curve.losses] == pytest.approx([1.0], abs=0.015)
    assert [lost for _, lost in two.curve.losses] == pytest.approx([28 / 53.3, 1.0], abs=0.015)
    assert one.curve.at(0.999 * one.curve.d0) > 0.9 * one.a0_star
    assert one.curve.at(one.curve.d0) == 0.0
    assert "ties that have no elongation limit" in checked(run(leaning(None))).missing_curve


def test_the_mechanism_of_a_wall_in_its_plane_has_several_bodies_and_no_straight_curve():
    rows = [[1, 1, 1, 1], [0.5, 1, 1, 1, 0.5], [1, 1, -1, 1], [0.5, 1, -1, 1, 0.5], [1, 2, 1], [0.5, 1, 1, 1, 0.5]]
    blocks = bs.courses(rows, unit_length="40 cm", unit_height="20 cm", thickness="30 cm", material=STONE)
    check = checked(run(model_of(blocks, DRY), case(push(1, 0, 0))))
    assert sum(body.moves for body in check.bodies) > 1
    assert check.curve is None
    assert 0 < check.participation_of_blocks.e_star <= check.e_star <= 1
    with pytest.raises(bs.errors.ModelError, match=r"run a Pushover, or give method='linear' \(--method linear on"):
        checked(check.result, method="displacement")


def test_a_sliding_block_takes_part_as_one_and_has_no_d0():
    block = box("block", [0, 0, 0], [2, 2, 1])
    check = checked(run(model_of([GROUND, block], bs.JointMaterial("smooth", 0.3))))
    assert (check.alpha0, check.e_star) == pytest.approx((0.3, 1.0), rel=1e-6)
    assert "slides without turning" in check.missing_curve


@pytest.mark.parametrize(("tension", "strength"), [("5 kPa", None), ("5 kPa", "2 MPa"), ("1 kPa", "2 MPa")])
def test_a_body_that_tension_holds_has_no_straight_curve(tension, strength):
    """A foot that bonds turns about its edge, or its stress block, at more than its weight resists."""
    mortar = DRY.varied(cohesion="10 kPa", tensile_strength=tension, compressive_strength=strength)
    check = checked(run(facade(mortar)))
    assert strength is not None or 1.01 < check.alpha0 / 0.1 < 1.1
    assert check.curve is None
    assert "something else resists, too; run a Pushover, with joints that have neither" in check.missing_curve


def test_a_body_that_crushes_askew_has_no_straight_curve():
    """Under a push 5° off its normal the stress block is a rectangle (5 − 2 e1)(0.6 − 2 e2) at a corner of the foot."""
    askew = np.array([np.sin(np.radians(5)), np.cos(np.radians(5))])
    result = run(facade(DRY.varied(compressive_strength="1 MPa")), case(push(askew[0], -askew[1], 0)))
    along, across = np.array([facades.LENGTH, DEPTH]) - 2 * HEIGHT / 2 * result.load_factor * askew
    assert 1000 * along * across == pytest.approx(324, rel=1e-4)
    check = bs.assess.local_mechanism(result, knowledge_level="LC2", spectrum=SITE)
    assert check.curve is None
    assert "or it crushes towards a corner under an oblique push; run a Pushover" in check.missing_curve


def test_a_portal_goes_as_far_by_its_control_point_as_by_its_weights():
    """Columns of 27 kN move by half of what their lintel of 22.5 kN does.

    e* = (54 / 2 + 22.5)² / (76.5 (54 / 4 + 22.5)) = 0.889706.
    """
    control = ("lintel", (1, 0, 0))
    pushed = bs.Pushover("portal", SELF_WEIGHT, push(1, 0, 0), control=control, steps=10)
    check = checked(bs.run(facades.portal(), pushed)["portal"])
    assert check.e_star == pytest.approx(0.889706, rel=1e-5)
    assert check.curve is not None
    assert check.notes == ()


def capacity_of_facade(top=0.0997, holds=60):
    """What a pushover of the façade gives: α = tan(atan 0.1 − θ) over the displacement of a corner of its top."""
    angle = np.linspace(0.0, top, 61)
    displacement = HEIGHT * np.sin(angle)
    factor = np.tan(np.arctan(0.1) - angle)
    ended = factor[-1] <= 0
    values = {"load_factor": ("step", factor), "holds": ("step", (np.arange(61) <= holds).astype(int))}
    values["d0"] = (), HEIGHT * np.sin(np.arctan(0.1)) if ended else np.nan
    return xr.Dataset(values, coords={"displacement": ("step", displacement)})


def curve_of(result, dataset, control=("façade", (0.0, -1.0, 0.0)), point=(0.0, 0.0, 6.0)):
    check = checked(result)
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


def test_the_check_of_a_pushover_is_that_of_the_straight_curve(result):
    """A façade that rotates as one: its capacity curve is straight but for the arc of its centroid."""
    straight, found = (checked(r, method="displacement") for r in (result, pushed_over(facade(), 30)))
    assert found.curve.d0 == pytest.approx(straight.curve.d0, rel=1e-2)
    assert found.ratio == pytest.approx(straight.ratio, rel=1e-2)


def test_the_check_of_a_pushover_whose_tie_breaks():
    """As in :func:`test_a_tie_that_breaks_by_hand`; without a limit of the tie there is no curve to rely on."""
    by_hand, result = run(tied(breaks_at=0.1)), pushed_over(tied(breaks_at=0.1), 30)
    by_hand, found = (checked(of, method="displacement") for of in (by_hand, result))
    assert found.verdict.state.capacity == pytest.approx(by_hand.verdict.state.capacity, rel=1e-2)
    assert found.ratio == pytest.approx(by_hand.ratio, rel=2e-2)
    # The whole loss is where the bar breaks: just beyond it, the curve is that without the bar, and not above it.
    at = found.verdict.state.capacity * (1 + 1e-2)
    assert 0.9 < found.curve.at(at) / by_hand.curve.at(at) < 1.001
    # And the one that is drawn.
    (before, after), *_ = result.broken_ties[["load factor before", "load factor after"]].to_numpy()
    k = int(np.diff(found.curve.acceleration).argmin())
    lost = found.curve.acceleration[k + 1] / found.curve.acceleration[k]
    assert lost == pytest.approx(after / before, rel=1e-3)
    assert "no elongation limit" in checked(pushed_over(tied(), 30)).missing_curve


def test_a_pushover_that_ends_early_gives_the_displacement_it_reached(result):
    early = curve_of(result, capacity_of_facade(top=0.05))
    assert early.d0 == pytest.approx(3 * np.sin(0.05), rel=1e-6)
    uncertified = curve_of(result, capacity_of_facade(holds=30))
    assert uncertified.d0 == pytest.approx(3 * np.sin(0.0997 / 2), rel=1e-6)


def test_a_control_point_near_the_hinge_has_a_note(result):
    """Its displacement, relative to the weights, grows with the angle: 0.354 m instead of 0.3 m, on the unsafe side.

    From the outer face at z it is (z sin θ + 0.6 (1 − cos θ)) / z · 3 m at tan θ = 0.1: 1 % more at 2 m, 2.5 % at 1 m.
    """
    for z, has_note in ((6.0, False), (2.1, False), (1.0, True), (0.16, True)):
        check = checked(pushed_over(facade(), control_point=Q_([0, DEPTH, z], "m")))
        assert ("control_point" in codes(check)) == has_note
    state = check.limit_states["SLV, by displacement"]
    straight = checked(result).limit_states[state.name]
    relied = checked(check.result, method="displacement").verdict.state
    assert (relied.capacity, relied.ratio) == pytest.approx((0.12, straight.ratio), rel=6e-3)
    assert state.ratio > 1.15 * straight.ratio


def test_a_body_held_beyond_the_end_of_its_rotation_has_a_note():
    """A wall 0.5 × 3 m meets a pier that nobody counts on: by itself it ends where its centroid has moved by 0.25 m."""
    wall, pier = box("wall", [0, 0, 0], [4, 0.5, 3]), box("pier", [1.5, -0.9, 0], [1, 0.8, 2.5])
    model = model_of([GROUND, wall, pier], DRY, "wall before a pier")
    alone = checked(run(model)).limit_states["SLV, by displacement"]
    check = checked(pushed_over(model, 12, "wall"), method="displacement")
    assert check.curve.d0 > 0.3
    assert check.limit_states[alone.name].ratio > 1.2 * alone.ratio
    assert "overturns_alone" in codes(check)
    assert check.ratio == pytest.approx(alone.ratio, rel=1e-6)
    between = SITE.at((alone.ag + check.limit_states[alone.name].ag) / 2)
    check = bs.assess.local_mechanism(check.result, 1.35, between, method="displacement")
    assert check.limit_states[alone.name].ratio > 1
    assert not check.satisfied


def test_a_pushover_without_displacement_or_steps_is_refused(result):
    with pytest.raises(bs.errors.ModelError, match="rests in the mechanism"):
        curve_of(result, capacity_of_facade(), point=(0.0, 0.0, 0.0))
    with pytest.raises(bs.errors.ModelError, match="the pushover has 1 certified step,"):
        curve_of(result, capacity_of_facade(holds=1))


@pytest.mark.parametrize(
    ("parapet", "advised"),
    [
        ([0, 0.02, 0.04, 0.06, 0.2, 0.3], "run .* control= at block 'parapet', which reaches 0.3 m"),
        ([0, 0.05, 0.2, 0.1, 0.2, 0.3], "no block goes further without turning back"),
    ],
)
def test_a_control_point_that_turns_back_gives_no_curve(result, parapet, advised):
    """Goes 0.1 m, comes back to 1 nm and ends there: of its states only those nearer than that were kept."""
    way = np.array([0, 0.05, 0.1, 0.02, 0.9e-9, 1e-9])
    position = np.array([way, parapet]).T[:, :, None] * [0.0, -1.0, 0.0] + [0.0, 0.3, 3.0]
    back = capacity_of_facade().isel(step=slice(6)).assign(d0=1e-9)
    back = back.assign_coords(displacement=("step", way), block=["façade", "parapet"])
    back = back.assign(position=(("step", "block", "axis"), position))
    with pytest.raises(bs.errors.ModelError, match=rf"at block 'façade' turns back at 0\.1 m, .* {advised}"):
        curve_of(result, back)


def test_a_curve_that_falls_at_once_has_no_displacement():
    """0.4 of the load factor is left at the first state: d_SLV = 0, and the demand there as well."""
    pushed = pushed_over(facade())
    curve = pushed.capacity.copy()
    curve["load_factor"] = curve["load_factor"].where(curve["step"] < 1, 0.4 * curve["load_factor"])
    fallen = dataclasses.replace(pushed, capacity=curve)
    check = checked(fallen)
    assert "state_left_out" in codes(check)
    with pytest.raises(bs.errors.ModelError, match=r"loses more than 0.5 .* with more steps, or give method='linear'"):
        checked(fallen, method="displacement")


@pytest.mark.parametrize("along", [(1, 0, 0), (0, 0, 1), (0, -1, -1), (1, -1, 0), (0.1, -1, 0)])
def test_a_control_direction_across_the_push_is_refused(result, along):
    """Followed downwards as well, the corner of the top would have a larger d0, as it sinks."""
    along = tuple(np.array(along) / np.linalg.norm(along))
    with pytest.raises(bs.errors.ModelError, match=r"the control point .* control=\('façade', \(0, -1, 0\)\)"):
        curve_of(result, capacity_of_facade(), control=("façade", along))


def test_rounded_corners_count_from_the_first_state():
    check = checked(pushed_over(facade(), corner_rounding="30 mm"))
    # (b / 2 − r) / (h / 2) at rest, with b = 0.6 m, h = 6 m and r = 0.03 m.
    assert check.curve.at(0.0) == pytest.approx(0.09 * g / 1.35, rel=1e-4)
    assert check.a0_star == pytest.approx(0.1 * g / 1.35, rel=1e-6)
    assert "rounded_corners" in codes(check)


def test_a_curve_that_jumps_has_a_note():
    pushed = pushed_over(facade())
    curve = pushed.capacity.copy()
    curve["load_factor"] = curve["load_factor"].where(curve["step"] < 5, 0.8 * curve["load_factor"])
    for of, has_note in ((pushed, False), (dataclasses.replace(pushed, capacity=curve), True)):
        assert ("curve_doubt" in codes(checked(of))) == has_note
    # And one that ends before its load factor has come down, as if blocks fell there.
    half = pushed.capacity.isel(step=slice(0, 5)).assign(d0=np.nan)
    assert "curve_end" in codes(checked(dataclasses.replace(pushed, capacity=half)))
