"""Which bodies and masses take part, which motions are independent, and which one is activated first."""

import dataclasses
import random

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.assess.freedom import _Search, least_activation, separate_mechanisms
from blockstruct.assess.local_mechanism import without_small
from blockstruct.assess.participation import HorizontalForces, of_bodies
from blockstruct.limit import LimitProblem
from blockstruct.limit.certificate import certify
from blockstruct.limit.motion import unit_of_velocity
from blockstruct.statics.statics import Statics
from blockstruct.structures.builder import prism
from blockstruct.text import assessment
from facades import DRY, portal, pushed_over, solve
from structures import SELF_WEIGHT, STONE, box, model_of, push, single_block

SITE = bs.assess.ntc_spectrum(Q_(0.1, "g_0"), 2.4, "0.3 s", "B")


def lever(stem):
    """A column that goes over and pushes the nose of a bracket, which turns about the edge of a pier below it.

    Its stem hangs beyond the edge, m, so that its centroid is next to as high as the edge.
    """
    outline = [[0, 2.25], [0.3, 2.25], [0.3, 2], [2.1, 2], [2.1, 2 - stem], [2.6, 2 - stem], [2.6, 2.5], [0, 2.5]]
    blocks = [
        box("ground", [-2, 0, -0.5], [2.2, 1, 0.5], fixed=True),
        box("pier", [0.3, 0, -0.5], [1.7, 1, 2.5], fixed=True),
        box("column", [-1, 0, 0], [1, 1, 8]),
        prism("bracket", outline, (0, 1), STONE),
    ]
    joints = {"head": bs.JointMaterial("smooth", 0.0), "*": bs.JointMaterial("rough", 3.0)}
    return bs.Model("lever", blocks, bs.detect_interfaces(blocks, joints))


def by_hand(stem):
    """α0, weights in kN and δ of column and bracket.

    The column turns about (0, 0), the bracket about (2, 2); they meet at (0, 2.25): the bracket turns 2.25 / 0.25 = 9
    times as fast, and nothing holds it along the smooth head joint. With the force N at the nose and the moments M_z
    and M_x of the weight of the bracket, by its heights above the edge and its ways behind it, 160 (4 α − 0.5) = 2.25 N
    and 0.25 N + α M_z = M_x.
    """
    area = np.array([2.3 * 0.5, 0.3 * 0.25, 0.5 * stem])
    M_x = 20 * area @ (2 - np.array([1.45, 0.15, 2.35]))
    M_z = 20 * area @ (np.array([2.25, 2.375, 2 - stem / 2]) - 2)
    W = np.array([160, 20 * area.sum()])
    return (9 * M_x + 80) / (640 + 9 * M_z), W, np.array([1, 9 * M_z / W[1] / 4])


def share(W, d):
    return (W @ d) ** 2 / (W.sum() * (W @ d**2))


@pytest.fixture(scope="module", params=[1.105, 1.08])
def stem(request):
    return request.param


@pytest.fixture(scope="module")
def check(stem):
    return bs.assess.local_mechanism(solve(lever(stem), push(1, 0, 0), "nonassociative"), spectrum=SITE)


def test_a_body_that_turns_about_a_point_near_its_centroid_takes_no_part(stem, check):
    """δ = 0.0131 with the longer stem: e* = 1 without its 35.5 kN, 0.823 with them; 0.0306 takes part with 35.3 kN."""
    alpha0, W, d = by_hand(stem)
    rests = d[1] <= 0.02
    assert rests == (stem == 1.105)
    assert all(body.moves for body in check.bodies)
    assert share(W, d) < 0.84
    e_star = 1.0 if rests else share(W, d)
    assert (check.alpha0, check.participation.e_star) == pytest.approx((alpha0, e_star), rel=1e-5)
    assert check.limit_states["SLV, linear"].ratio == pytest.approx(alpha0 / e_star / 1.35 / 0.06, rel=1e-5)
    assert (check.e_star, check.ratio) == pytest.approx((1.0, alpha0 / 1.35 / 0.06), rel=1e-5)
    assert check.M_star == pytest.approx(e_star * (W[0] if rests else W.sum()) * 1e3 / 9.80665, rel=1e-5)
    assert (check.participation.left_out is not None) == rests
    small = assessment.small_motions(1e3 * W[1], 1e3 * W.sum(), d[1], e_star=1, a0_star=alpha0 / 1.35 * 9.80665)
    assert check.notes == (() if rests else (small,))


def test_a_ratio_that_a_note_relies_on_decides(stem):
    """With e* = 1 the ratio is α0 g / (1.35 · 0.5 ag), 0.95 here; with the weight of the bracket it is above one."""
    alpha0, W, d = by_hand(stem)
    site = bs.assess.ntc_spectrum(Q_(alpha0 / 1.35 / 0.5 / 0.95, "g_0"), 2.4, "0.3 s", "A")
    check = bs.assess.local_mechanism(solve(lever(stem), push(1, 0, 0), "nonassociative"), spectrum=site)
    assert (check.ratio, check.satisfied) == (pytest.approx(0.95, rel=1e-5), False)
    if d[1] <= 0.02:
        return
    # At one load factor the motion of the least ratio counts; the other way is printed.
    assert check.verdict.range == pytest.approx((0.95, 0.95), rel=1e-5)
    assert check.verdict.ways[-1].state.ratio == pytest.approx(0.95 / share(W, d), rel=1e-5)
    assert check.verdict.governing.way is bs.assess.Way.WITHOUT_SMALL
    # Damage begins with the same motion.
    assert check.limit_states["SLD"].capacity == pytest.approx(alpha0 / 1.35 * 9.80665, rel=1e-5)


def test_a_sidewall_that_hardly_moves_along_the_push_takes_no_part():
    """With the whole weight of its sidewall, 43 % of all or more, the façade of a corner had e* = 0.40, not 0.69."""
    size = {"unit_length": "1 m", "unit_height": "0.5 m", "thickness": "0.5 m", "material": STONE}
    side = bs.structures.Sidewall("left", at="0 m", length="3.5 m")
    blocks = bs.wall(length="4 m", courses=8, sidewalls=[side], **size)
    joint = bs.JointMaterial("lime", 0.6, compressive_strength="3 MPa")
    result = solve(model_of(blocks, joint), push(0, -1, 0), "nonassociative", effects=False)
    check = bs.assess.local_mechanism(result, knowledge_level="LC1", spectrum=SITE)
    both = np.append(check.participation.weight, check.participation.left_out.weight)
    moved = np.append(check.participation.displacement, check.participation.left_out.displacement)
    assert check.participation.left_out.total > 0.4 * both.sum()
    assert check.e_star > 1.6 * share(both, moved)


def standing(*walls, ties=()):
    """Walls (x, y, length, thickness, height), m, each a block on one ground."""
    blocks = [box(f"wall {k}", [x, y, 0], size) for k, (x, y, *size) in enumerate(walls)]
    ground = box("ground", [-1, -1, -0.5], [20, 5, 0.5], fixed=True)
    return model_of([ground, *blocks], DRY, "walls").with_ties(ties)


def checked(model, **more):
    return bs.assess.local_mechanism(solve(model, push(0, -1, 0)), spectrum=SITE, **more)


@pytest.mark.parametrize("lengths", [(12,), (3, 9), (1, 2, 9)])
def test_walls_apart_are_checked_as_one_wall_is(lengths):
    """0.5 m × 6 m: α0 = 1/12, e* = 1, a0* = g / 12 / 1.35; over all of the parts e* would be 0.75 and 0.47.

    a_Z / 2 = 0.1 g S / 2 with S = 1.2: ratio 1 / 12 / 1.35 / 0.06 = 1.028807.
    """
    starts = np.cumsum([0, *lengths[:-1]]) + 0.02 * np.arange(len(lengths))
    check = checked(standing(*((x, 0, length, 0.5, 6) for x, length in zip(starts, lengths, strict=True))))
    assert (check.alpha0, check.e_star, check.ratio) == pytest.approx((1 / 12, 1.0, 1 / 12 / 1.35 / 0.06), rel=1e-6)
    assert ("separate_mechanisms" in [note.code for note in check.notes]) == (len(lengths) > 1)
    assert sum(body.moves for body in check.bodies) == 1


def test_the_part_with_the_lowest_ratio_is_relied_on():
    """Piers of 0.25 m × 2.5 m and 2 m × 20 m have one α0; by displacement the smaller one has an eighth of d0."""
    small, large = (0, 0, 5, 0.25, 2.5), (10, 0, 5, 2, 20)
    together = checked(standing(large, small), method="displacement")
    alone = [checked(standing(one), method="displacement").ratio for one in (small, large)]
    assert alone[1] > 2 * alone[0]
    assert together.ratio == pytest.approx(alone[0], rel=1e-6)
    parts = [("body 2 (wall 1)", together.ratio), ("body 1 (wall 0)", alone[1])]
    assert assessment.separate_mechanisms(2, parts, []) in together.notes


#: Load factor of a wall of 0.2 m × 3 m, 60 kN, and one of 0.8 m × 4 m, 320 kN, that turn by one angle.
TIED = (60 * 0.1 + 320 * 0.4) / (60 * 1.5 + 320 * 2)


@pytest.mark.parametrize(
    ("yield_force", "e_star", "bodies"),
    [(90, (60 * 1.5 + 320 * 2) ** 2 / (380 * (60 * 1.5**2 + 320 * 2**2)), 2), ((TIED * 90 - 6) / 2, 1.0, 1)],
)
def test_a_tie_that_does_not_yield_makes_one_mechanism_of_two_walls(yield_force, e_star, bodies):
    """A thin wall goes over and pulls a thick one along by a tie at 2 m, with (α 60 · 1.5 − 60 · 0.1) / 2 = 5.26 kN."""
    ends = ("wall 0", Q_([2.5, 0.2, 2], "m")), ("wall 1", Q_([2.5, 1, 2], "m"))
    tie = bs.Tie("tie", *ends, yield_force=Q_(yield_force, "kN"))
    check = checked(standing((0, 0, 5, 0.2, 3), (0, 1, 5, 0.8, 4), ties=[tie]))
    assert (check.alpha0, check.e_star) == pytest.approx((TIED, e_star), rel=1e-5)
    assert sum(body.moves for body in check.bodies) == bodies


def test_a_pushover_checks_the_mechanism_that_it_follows():
    """One of two equal piers is followed to its d0, half its thickness; the other one is not checked by it."""
    model = standing((10, 0, 5, 0.6, 6), (0, 0, 5, 0.5, 5))
    check = bs.assess.local_mechanism(pushed_over(model, block="wall 0"), spectrum=SITE, method="displacement")
    assert check.curve.d0 == pytest.approx(0.3, rel=1e-5)
    assert check.notes[0] == assessment.separate_mechanisms(2, [("body 1 (wall 0)", check.ratio)], ["body 2 (wall 1)"])


def tower(*courses, mu=0.9):
    """Courses (front, thickness), m, each 1 m high and 1 m long."""
    ground = box("ground", [-1, -1, -0.5], [3, 3, 0.5], fixed=True)
    blocks = [box(f"course {k}", [0, front, k], [1, thickness, 1]) for k, (front, thickness) in enumerate(courses)]
    return model_of([ground, *blocks], bs.JointMaterial("dry", mu))


@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
def test_a_tower_whose_joints_open_together_has_all_its_mass(flow):
    """Courses of 0.6 m and 0.3 m, flush in front: either joint opens at α0 = 0.3, what turns is one body, e* = 1."""
    model = tower((0, 0.6), (0, 0.3))
    check = bs.assess.local_mechanism(solve(model, push(0, -1, 0), flow), spectrum=SITE)
    assert (check.alpha0, check.e_star, check.ratio) == pytest.approx((0.3, 1.0, 0.3 / 1.35 / 0.06), rel=1e-5)
    # The motion that the procedure ended at is one of many, each with another e*.
    assert check.participation.e_star < 0.6
    assert check.verdict.governing.way is not bs.assess.Way.COLLAPSE


def test_a_pushover_of_an_ambiguous_mechanism_has_no_curve():
    """Its control point depends on the motion found."""
    result = pushed_over(tower((0, 0.6), (0, 0.3)), 5, "course 1")
    with pytest.raises(bs.errors.ModelError, match="the mechanism is not unique"):
        bs.assess.local_mechanism(result, spectrum=SITE, method="displacement")
    assert "the mechanism is not unique" in bs.assess.local_mechanism(result, spectrum=SITE).missing_curve


def test_the_least_capacity_of_a_later_mechanism_is_printed():
    """A portal has e* = 0.9; whatever begins at a larger α0 has e* ≤ 1, and thus at least α0 g / FC."""
    check = bs.assess.local_mechanism(solve(portal(), push(1, 0, 0)), spectrum=SITE)
    assert check.e_star < 0.95
    assert f"at least α0 g / FC = {check.alpha0 * 9.80665 / 1.35:.4g} m/s²" in str(check)


def corner(*, mirrored=False, seed=None, **joint):
    """A façade with one sidewall, out of plane: bodies of unlike motion, at joints that crush, with a tie."""
    size = {"unit_length": "1 m", "unit_height": "0.5 m", "thickness": "0.5 m", "material": STONE}
    at = "2.5 m" if mirrored else "0 m"
    blocks = bs.wall(length="3 m", courses=6, sidewalls=[bs.structures.Sidewall("side", at=at, length="2.5 m")], **size)
    if seed is not None:
        random.Random(seed).shuffle(blocks)
    model = model_of(blocks, bs.JointMaterial("lime", 0.6, compressive_strength="3 MPa", **joint))
    x = 2.75 if mirrored else 0.25
    ends = [
        min((b for b in blocks if not b.fixed), key=lambda b: np.linalg.norm(b.centroid - [x, y, 2.75])).name
        for y in (0.25, 2.75)
    ]
    places = [Q_([x, y, 2.75], "m") for y in (0.0, 3.0)]
    return model.with_ties([bs.Tie("tie", (ends[0], places[0]), (ends[1], places[1]), yield_force="5 kN")])


@pytest.fixture(scope="module")
def result():
    return solve(corner(), push(0, -1, 0), "nonassociative")


def test_the_multiplier_of_a_motion_is_that_of_the_certificate(result):
    """The flow-rule gap of the same motion, by another code, is what its multiplier has beyond α0."""
    forces = HorizontalForces.of(result.model, result.case)
    (part,) = separate_mechanisms(result, forces, result.macro_blocks)
    whole, _ = of_bodies(result.model, forces, result.mechanism, part)
    everything = dataclasses.replace(whole, left_out=None)
    search = _Search.of(result, forces, part, everything)
    search = dataclasses.replace(search, body=np.maximum(search.body, 0))
    found = search.solved(10 * result.load_factor)
    statics = Statics.of(result.model)
    problem = LimitProblem.of(statics, result.case)
    last = result.history.isel(iteration=-1)
    x = last["contact_force"].to_numpy() / problem.force_unit[:, None]
    T = last["tie_force"].to_numpy() / problem.ties.force_unit
    moving = {name for body in part for name in body.blocks}
    u = np.zeros((problem.n_blocks, 6))
    u[[result.model.blocks[i].name in moving for i in statics.free]] = found.motion
    u = (u * unit_of_velocity(problem)).ravel()
    u /= problem.w_L @ u
    again = certify(problem, x, u, result.load_factor, result.settings, T)
    assert found.alpha > 1.02 * result.load_factor
    assert again.interpenetration < 1e-5
    assert found.alpha - result.load_factor == pytest.approx(again.flow_rule_gap, rel=1e-3)


def test_the_least_acceleration_lies_between_the_floor_and_the_collapse_mechanism(result):
    check = bs.assess.local_mechanism(result, spectrum=SITE, knowledge_level="LC1")
    (collapse,) = [one for one in check.verdict.ways if one.way is bs.assess.Way.COLLAPSE]
    (other,) = [one for one in check.verdict.ways if one.way is bs.assess.Way.OTHER_MOTION]
    assert check.alpha0 < other.alpha
    assert collapse.state.ratio * collapse.e_star <= other.state.ratio < 0.95 * collapse.state.ratio
    # The remedy of torsion takes 1 % off the load factor, and off what no motion goes below.
    assert check.verdict.governing.way is bs.assess.Way.UNIFORM_TORSION
    low = result.outcome.uniform_torsion / result.load_factor
    assert check.verdict.floor == pytest.approx(low * collapse.state.ratio * collapse.e_star, rel=1e-12)
    assert check.verdict.floor <= check.ratio == pytest.approx(low * other.state.ratio, rel=1e-9)
    a0_star = check.verdict.governing.alpha / check.e_star / check.confidence_factor
    assert check.ratio == pytest.approx(a0_star / 0.06, rel=1e-6)


@pytest.mark.slow
def test_the_ratio_follows_the_load_factor_and_nothing_else():
    """Mirrored, in another order, and with other steps: where α0 moves by less than 1 %, the ratio does by 2 %."""
    case = bs.LimitCase("case", SELF_WEIGHT, push(0, -1, 0))
    spread = bs.AnalysisManager(corner(), effects=False).run([case], spread=["half steps"]).spread("case")
    models = corner(mirrored=True), corner(seed=1)
    others = [bs.AnalysisManager(model, effects=False).run([case])["case"] for model in models]
    runs = (*spread.runs.values(), *others)
    checks = [bs.assess.local_mechanism(one, spectrum=SITE, knowledge_level="LC1") for one in runs]
    assert len(checks) == 4
    alphas, ratios = (np.array([getattr(check, name) for check in checks]) for name in ("alpha0", "ratio"))
    assert np.ptp(alphas) < 0.01 * alphas.min()
    assert np.ptp(ratios) < 0.02 * ratios.min()


def test_one_body_is_its_own_least_motion():
    """Nothing has a larger e* than one body that turns."""
    model = model_of(single_block(4.0, 3.0, 0.5)[0], bs.JointMaterial("dry", 0.7))
    result = solve(model, push(0, -1, 0), "nonassociative")
    forces = HorizontalForces.of(result.model, result.case)
    whole, _ = of_bodies(result.model, forces, result.mechanism, result.macro_blocks)
    least = least_activation(result, forces, result.macro_blocks, without_small(whole))
    assert (least.alpha, least.e_star, least.bodies) == pytest.approx((0.5 / 3, 1.0, 1), rel=1e-6)
