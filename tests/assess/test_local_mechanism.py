"""Local mechanisms against hand calculations; notes and refusals."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.text import assessment
from facades import DEPTH, DRY, EDGE, GROUND, SITE, box, case, checked, codes, facade, run, small_blocks, tied
from structures import SELF_WEIGHT, model_of, push, solve

g, TOP = 9.80665, "[2.5, 0.3, 6] m"


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
    relied = checked(result, method="displacement")
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


def test_loads_that_a_facade_carries_by_hand():
    """A roof of 90 kN at the top, 0.4 m from the outer edge, whose mass pushes at 6 m.

    α0 = (324 · 0.3 + 90 · 0.4) / (324 · 3 + 90 · 6) = 133.2 / 1512 = 0.0880952; one body, e* = 1, P + Q = 414 kN.
    At θ: tan θ0 = 133.2 / 1512, the centroid of P + Q at (324 · 0.3 + 90 · 0.4) / 414 = 0.321739 m from the edge.
    """
    point = "[2.5, 0.4, 6] m"
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), bs.PointLoad("façade", point, "[0, 0, -90] kN")])
    pushed = bs.LoadPattern("push", [bs.BodyForce("-y"), bs.PointLoad("façade", point, "[0, -90, 0] kN")])
    model, loaded = facade(), case(pushed, dead)
    check = checked(run(model, loaded))
    assert check.alpha0 == pytest.approx(133.2 / 1512, rel=1e-6)
    assert check.e_star == pytest.approx(1.0, rel=1e-9)
    assert check.participation.total == pytest.approx(414e3)
    assert check.curve.d0 == pytest.approx(133.2 / 414, rel=1e-6)
    assert check.notes == ()
    hand = bs.assess.overturning(model, loaded, check.bodies[0], EDGE)
    assert (hand.alpha0, hand.d0) == pytest.approx((133.2 / 1512, 133.2 / 414))
    # The same as a weight that the dead load carries and the push takes along.
    carried = bs.LoadPattern("carried", [bs.SelfWeight(), bs.Weight("façade", point, "90 kN")])
    same = checked(run(model, case(dead=carried)))
    assert (same.a0_star, same.curve.d0) == pytest.approx((check.a0_star, check.curve.d0), rel=1e-6)
    # Half the push is twice the load factor, and the same check.
    half = bs.LoadPattern("half", [bs.BodyForce("-y", 0.5), bs.PointLoad("façade", point, "[0, -45, 0] kN")])
    halved = run(model, case(half, dead))
    assert halved.load_factor == pytest.approx(2 * check.alpha0, rel=1e-6)
    other = checked(halved)
    assert (other.a0_star, other.curve.d0) == pytest.approx((check.a0_star, check.curve.d0), rel=1e-6)
    # The mass of a load is not pushed.
    check = checked(run(model, case(dead=dead)))
    assert codes(check) == ["masses_differ"]


def test_a_tied_facade_by_hand():
    """A tie of 20 kN at 5 m: α0 = (324 · 0.3 + 20 · 5) / (324 · 3) = 197.2 / 972 = 0.202881; e* = 1.

    a0* = 0.202881 g / 1.35; linear ratio = 0.202881 / (1.35 · 0.09) = 1.669799.
    Without an elongation limit nothing verifies the tie until collapse: d0 = 0.3 m and a(0) = 0.1 g / 1.35 are those of
    the free façade (C8.7.1.2.1.6).
    """
    model = tied()
    result = run(model)
    hand = bs.assess.overturning(model, result.case, ["façade"], EDGE)
    check = checked(result, beside=hand)
    assert (check.alpha0, hand.alpha0) == pytest.approx((197.2 / 972,) * 2, rel=1e-6)
    assert (check.e_star, check.a0_star) == pytest.approx((1.0, 197.2 / 972 * g / 1.35), rel=1e-6)
    assert check.ratio == pytest.approx(197.2 / 972 / 1.35 / 0.09, rel=1e-6)
    assert (check.curve.d0, check.curve.at(0.0)) == pytest.approx((0.3, 0.1 * g / 1.35), rel=1e-5)
    assert hand.d0 == pytest.approx(0.3)
    assert "T = 20 kN, M = 100 kN m" in str(check)
    assert check.notes == ()


def test_the_trap_of_small_blocks_is_closed(result):
    """Over the n courses of a wall that turns as one, e* = 3n² / (4n² − 1), → 0.75; as one body it is 1.

    With δ = (i − 1/2) / n in course i of n = 12: Σδ = n/2, Σδ² = n/3 − 1/(12 n): 0.751304 (units across the courses
    have the same height).
    """
    n, small = 12, run(small_blocks())
    one, many = (checked(r, method="displacement") for r in (result, small))
    assert len(many.participation.names) == 1
    assert len(many.participation_of_blocks.names) > 60
    assert many.participation_of_blocks.e_star == pytest.approx(3 * n**2 / (4 * n**2 - 1), rel=1e-6)
    assert many.e_star == pytest.approx(1.0, rel=1e-9)
    for name in ("alpha0", "a0_star", "M_star", "ratio", "ag"):
        assert getattr(many, name) == pytest.approx(getattr(one, name), rel=1e-5), name
    (line,) = [line for line in str(many).splitlines() if "by single blocks, not used" in line]
    assert "e* = 0.7513, M* = 24.82 t" in line


def test_every_formula_is_printed_with_its_paragraph(result):
    check = checked(result, spectrum_slc=SITE.at(0.2 * g), spectrum_sld=SITE.at(0.05 * g))
    text = str(check)
    for words in (
        "M* = [Σ(P+Q)δ]² / (g Σ(P+Q)δ²) = (324 kN)² / (g · 324 kN) = 33.04 t",
        "a0* = α0 g / (e* FC) = 0.1 · 9.80665 m/s² / (1 · 1.35) = 0.7264 m/s² = 0.07407 g   [C8.7.1.2.1.5 (C8.7.1.8)]",
        "d_SLV = 0.4 d0 = 0.4 · 0.3 m = 0.12 m   [C8.7.1.2.1.6]",
        "T_SLV = 1.68 π √(d/a) = 1.68 π √(0.12 m / 0.4359 m/s²) = 2.769 s   [C8.7.1.2.1.8 (C8.7.1.10)]",
        "S_S = 1.40 − 0.40 F0 a_g/g, from 1.00 to 1.20 = 1.2   [NTC 2018 Tab. 3.2.IV]",
    ):
        assert words in text, words
    assert text.count("capacity / demand  ") == 4
    # The hazard of each limit state stands with it.
    printed = {part.title: str(part) for part in check.sections}
    for title, ag in (("SLD", 0.05), ("SLC, by displacement", 0.2), ("Demand at SLV", 0.15)):
        assert f"= {ag} g, F0 = 2.4" in printed[title]


def test_coefficients_are_arguments_and_changes_have_a_note(result):
    own = checked(result, coefficients=bs.assess.Coefficients(q=1.5, slv_share=0.25))
    assert own.ratio == pytest.approx(0.75 * checked(result).ratio)
    assert own.limit_states["SLV, by displacement"].capacity == pytest.approx(0.25 * 0.3, rel=1e-6)
    assert codes(own) == ["coefficients"]


def test_a_spread_is_checked_by_the_run_as_given():
    """Every schedule finds α0 = 0.1, and the run as given has the curve."""
    control = ("façade", (0, -1, 0))
    pushed = bs.Pushover("out", SELF_WEIGHT, push(0, -1, 0), control=control, steps=10)
    analysis = bs.AnalysisManager(facade()).run([pushed], spread=["half steps", "steep"])
    check = checked(analysis.spread("out"))
    assert check.result is analysis["out"]
    assert check.curve.lines[0].what == "curve of the pushover"
    assert check.notes == ()


@pytest.mark.parametrize(("load_factor", "severity"), [(0.09, "caution"), (0.02, "warning")])
def test_a_lower_run_that_has_not_settled_has_a_note(load_factor, severity):
    """The range leaves it out. It opens the verdict if its ratio is below one."""
    spread = bs.AnalysisManager(facade()).run([case()], spread=["half steps"]).spread("out of plane")
    run = spread.runs["half steps"]
    low = run.changed(outcome=dataclasses.replace(run.outcome, load_factor=load_factor, settled=False))
    weak = bs.assess.ntc_spectrum(Q_(0.05, "g_0"), 2.4, "0.3 s", "A")
    found = bs.assess.local_mechanism(dataclasses.replace(spread, runs={**spread.runs, "half steps": low}), 1.35, weak)
    note = next(note for note in found.notes if note.code == "run_unsettled")
    assert note.severity == severity
    assert f"{load_factor}" in note.text
    assert bool(found.verdict.open) == (severity == "warning")
    assert "run_unsettled" not in codes(checked(spread))


@pytest.mark.parametrize("remedy", ["uniform_torsion", "biaxial_crushing", "other_procedure"])
def test_the_effect_of_a_remedy_counts(result, remedy):
    """A load factor 5 % lower has a ratio 5 % lower; one 0.5 % lower is no effect."""
    alone = checked(result).ratio
    for low in (0.095, 0.0995):
        remedied = result.changed(outcome=dataclasses.replace(result.outcome, **{remedy: low}, estimated=True))
        check = checked(remedied)
        assert check.ratio == pytest.approx((0.95 if low < 0.099 else 1) * alone, rel=1e-6)
        assert len(check.verdict.ways) == (2 if low < 0.099 else 1)
        # Another procedure is run to its end.
        is_estimate = low < 0.099 and remedy != "other_procedure"
        assert check.verdict.governing.is_estimate == ("estimate" in str(check)) == is_estimate


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
    ],
)
def test_coefficients_outside_their_range_are_refused(changed, words):
    with pytest.raises(bs.errors.ModelError, match=words):
        bs.assess.Coefficients(**changed)
    assert bs.assess.Coefficients(slv_share=0.7, slc_share=0.7).slc_share == 0.7
    assert bs.assess.Coefficients(q=np.int64(3)).q == 3


def test_an_acceleration_below_that_of_sld_is_not_taken_at_slv(result):
    """C8.7.1.2.1.8: a_g,SLV is not less than a_g,SLD."""
    few = bs.assess.Coefficients(slv_share=0.01)
    check = checked(result, method="displacement", coefficients=few)
    assert check.ag == pytest.approx(check.limit_states["SLD"].ag)
    # The site at which SLD is met, as a_g,SLV of this share alone is not.
    site = SITE.at(0.9 * check.ag)
    met = bs.assess.local_mechanism(result, 1.35, site, method="displacement", coefficients=few)
    assert (met.satisfied, met.ratio < 1) == (True, True)
    # At a stronger site, too, the structure bears a_g,SLD.
    missed = bs.assess.local_mechanism(result, 1.35, SITE.at(0.3 * g), method="displacement", coefficients=few)
    assert (missed.satisfied, missed.ratio < 1, missed.verdict.state.of_sld) == (False, True, True)


def test_a_table_that_ends_before_the_period_leaves_the_displacement_out(result):
    short = bs.assess.table_spectrum(Q_([0, 0.15, 0.42, 2], "s"), Q_([0.18, 0.432, 0.432, 0.09], "g_0"), ag="0.15 g_0")
    check = bs.assess.local_mechanism(result, 1.35, short)
    assert check.ratio == pytest.approx(0.1 / 1.35 / 0.09, rel=1e-6)
    assert list(check.limit_states) == ["SLD", "SLV, linear"]
    assert codes(check) == ["state_left_out"] * 2
    with pytest.raises(bs.errors.ModelError, match="last period is 2 s"):
        bs.assess.local_mechanism(result, 1.35, short, method="displacement")


def test_notes_on_the_load_factor(result):
    assert codes(checked(run(facade(), case(flow="associative")))) == ["associative_bound"]
    unsettled = checked(result.changed(outcome=dataclasses.replace(result.outcome, settled=False)))
    assert (codes(unsettled), unsettled.satisfied) == (["not_settled"], False)
    assert codes(checked(result)) == []
    linear = checked(result, spectrum_sld=SITE.at(0.12 * g))
    assert (codes(linear), linear.limit_states["SLD"].satisfied) == (["state_missed"], False)


@pytest.mark.parametrize("beside", [False, True])
def test_a_mechanism_at_a_height_has_a_note_under_the_spectrum_of_the_ground(beside):
    """Ties hold the lower storey: the upper one turns 3 m above the foot, even next to a support."""
    lower, upper = box("lower", [0, -0.5, 0], [5, 1.6, 3]), box("upper", [0, 0, 3], [5, 0.6, 3])
    tower = box("tower", [0, 0.6, 3], [5, 0.6, 1], fixed=True)
    result = run(model_of([GROUND, lower, upper, *[tower] * beside], DRY, "storeys"))
    check = checked(result)
    assert check.notes == (assessment.ground_at_height(3.0, on_support=False),)
    mode = bs.assess.Mode("0.4 s", participation=1.3, shape=0.9, damping=0.1)
    assert bs.assess.local_mechanism(result, 1.35, bs.assess.floor_spectrum(SITE, [mode])).notes == ()


def at_height(ground=SITE, period="0.4 s", shape=0.9, **more):
    return bs.assess.floor_spectrum(ground, [bs.assess.Mode(period, participation=1.3, shape=shape, **more)])


@pytest.mark.parametrize(
    ("spectrum", "demand", "words"),
    [
        (at_height(), SITE.at(0.05 * g), "spectrum is a floor spectrum, .* give spectrum_sld at"),
        (at_height(), at_height(SITE.at(0.05 * g), shape=0.5), r"0\.65 and .* = 1\.17, which are two heights"),
        (SITE, bs.assess.ntc_spectrum("0.05 g_0", 2.4, "0.3 s", "D"), "soil 'D' and 'B', .* the same soil"),
        (SITE, SITE.at(0.3 * g), r"ag is 2\.942 m/s² = 0\.3 g and 1\.471 m/s² .*, but it must not fall"),
    ],
)
def test_demands_of_several_places_are_refused(result, spectrum, demand, words):
    """An a_g,SLD of the ground is larger than at a height, and a_g,SLV is not taken below a_g,SLD."""
    with pytest.raises(bs.errors.ModelError, match=words):
        bs.assess.local_mechanism(result, 1.35, spectrum, spectrum_sld=demand)


def test_an_anchorage_that_gives_way_has_a_note():
    """It is taken to slip or punch without limit, and neither does."""
    assert codes(checked(run(tied(punching_force="10 kN")))) == ["anchorages"]


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


@pytest.mark.parametrize(("share", "outcome"), [(0.99996, "not satisfied"), (1.00002, "satisfied")])
def test_a_ratio_next_to_one_does_not_read_as_one(result, share, outcome):
    """The demand a_Z / q is made to miss the capacity, 0.1 g / 1.35, by a share that four digits do not show."""
    q = share * SITE.peak / (0.1 * g / 1.35)
    check = checked(result, coefficients=bs.assess.Coefficients(q=q))
    assert f"capacity / demand = {share}, {outcome}; equal at a_g = 1.471 m/s² = 0.1" in str(check.verdict)
    borne = float(str(check.verdict).partition("m/s² = ")[2].partition(" g")[0])
    assert (borne < 0.15) == (share < 1)


@pytest.mark.parametrize(
    ("variable", "words"),
    [
        (bs.LoadPattern("roof", [bs.PointLoad("façade", TOP, "[0, -9, 0] kN")]), "has no BodyForce"),
        (push(0, -1, 0.005), "pushes along"),
        (bs.LoadPattern("turn", [bs.BodyForce("-y"), bs.Moment("façade", "[5, 0, 0] kN*m")]), "has couples"),
        (bs.LoadPattern("two", [bs.BodyForce("-y"), bs.PointLoad("façade", TOP, "[0, 0, -9] kN")]), "across or"),
    ],
)
def test_a_push_must_be_horizontal_and_proportional_to_weight(variable, words):
    found = run(facade(), case(variable))
    with pytest.raises(bs.errors.ModelError, match=words):
        checked(found)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"confidence_factor": 1.2}, "FC is at least 1.35"),
        ({"confidence_factor": 0.9}, "from 1 to 10"),
        ({"knowledge_level": "LC4"}, "known are LC1, LC2, LC3"),
        ({"confidence_factor": 1.35, "knowledge_level": "LC2"}, "give one of the two"),
        ({"method": "by eye"}, "known are linear, displacement"),
        ({"spectrum": 0.15}, r"spectrum 0.15 is a float; give bs.assess.ntc_spectrum"),
        ({"coefficients": {"q": 1.5}}, "coefficients .* is a dict; give bs.assess.Coefficients"),
        ({"beside": 0.1}, "beside 0.1 is a float; give bs.assess.overturning"),
    ],
)
def test_arguments_that_make_no_check_are_refused(result, arguments, words):
    with pytest.raises(bs.errors.ModelError, match=words):
        bs.assess.local_mechanism(result, **{"spectrum": SITE, **arguments})


def test_the_confidence_factor_depends_on_crushing(result):
    own = {"knowledge_level": "LC2", "coefficients": bs.assess.Coefficients(without_crushing=1.0)}
    crushing = run(facade(DRY.varied(compressive_strength="2 MPa")))
    for of, given, factor in (
        (result, {}, 1.35),
        (result, {"knowledge_level": "LC3"}, 1.35),
        (result, {"confidence_factor": 1.5}, 1.5),
        (result, own, 1.2),
        (crushing, {"confidence_factor": 1.2}, 1.2),
    ):
        assert bs.assess.local_mechanism(of, spectrum=SITE, **given).confidence_factor == factor
    with pytest.raises(bs.errors.ModelError, match="give the factor, or knowledge_level"):
        bs.assess.local_mechanism(crushing, spectrum=SITE)
    # Another joint of the same body that does not count crushing.
    behind = box("behind", [0, DEPTH, 0], [5, 1, 2], fixed=True)
    blocks, lime = [*facade().blocks, behind], bs.JointMaterial("lime", 0.7, compressive_strength="2 MPa")
    found = bs.detect_interfaces(blocks, {"ground|*": lime, "*": DRY})
    with pytest.raises(bs.errors.ModelError, match=r"FC is at least 1\.35"):
        bs.assess.local_mechanism(run(bs.Model("two joints", blocks, found)), 1.2, SITE)


def test_results_without_a_collapse_state_are_refused(result):
    model = facade()
    up = solve(model, push(0, 0, -1))
    assert up.status == "unbounded"
    with pytest.raises(bs.errors.ModelError, match="converged collapse state"):
        checked(up)
    settled = dataclasses.replace(result, case=SimpleNamespace(name="left pier"))
    with pytest.raises(bs.errors.ModelError, match="has no push"):
        checked(settled)
    for other in (None, model, result.history):
        with pytest.raises(bs.errors.ModelError, match="is not a limit case's result"):
            checked(other)


def test_the_loading_path_does_not_count_on_friction_that_self_stress_presses():
    """A wall of two blocks, 0.5 m and 0.35 m thick, whose lower block touches a fixed ledge at its end.

    Friction on the ledge is whatever self-stress makes it. Held there, the upper block turns alone, 0.35 m / 1.6 m. Not
    held, both turn about the foot: weights of 5.6 and 2.24, arms of 0.25 m and 0.175 m, heights of 1.4 m and 3.6 m.
    """
    ledge = box("ledge", [-0.8, 0, 2.4], [0.8, 0.35, 0.4], fixed=True)
    walls = box("lower", [0, 0, 0], [4, 0.5, 2.8]), box("upper", [0, 0, 2.8], [4, 0.35, 1.6])
    manager = bs.AnalysisManager(model_of([GROUND, ledge, *walls], bs.JointMaterial("dry", 0.6)))
    spread = manager.run([case()], spread=["path", "fictitious"]).spread("out of plane")
    both = (5.6 * 0.25 + 2.24 * 0.175) / (5.6 * 1.4 + 2.24 * 3.6)
    assert spread.runs["fictitious"].load_factor == pytest.approx(0.35 / 1.6, rel=1e-5)
    assert spread.load_factor == pytest.approx(both, rel=5e-3)
    # The schedules of the paper's procedure are no part of the range.
    assert spread.path_dependence == pytest.approx((both, both), rel=5e-3)
    check = checked(spread)
    assert check.alpha0 == spread.load_factor
    assert check.ratio <= check.limit_states[check.relied_on].ratio


def test_a_table_of_longer_periods_gives_every_limit_state(result):
    """A table has no place: its spectrum may stand beside that of a soil."""
    table = bs.assess.table_spectrum(Q_([0, 0.1, 0.4, 6], "s"), Q_([0.3, 0.9, 0.9, 0.04], "g_0"), ag="0.25 g_0")
    check = checked(result, spectrum_sld=table, spectrum_slc=table)
    assert all(np.isfinite(state.demand) for state in check.limit_states.values())
