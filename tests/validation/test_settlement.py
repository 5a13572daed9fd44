"""Supports that give way: reactions in closed form, ranges of thrust, invariances.

A rigid beam of length L and weight W lies on ledges of width a at its ends. While one ledge goes down, the beam turns
about the inner edge of the other one, and is carried at its own end by the one that goes: moments about the edge give
``R = W (L/2 − a) / (L − a)``. While the ledge rises, the beam turns about the outer edge of the other one, carried at
the inner edge of the one that rises: ``R = W (L/2) / (L − a)``.
"""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import SELF_WEIGHT, beam_on_ledges, box, model_of, moved, rotation, semicircle

LENGTH, LEDGE, HEIGHT = 4.0, 0.5, 0.6
WEIGHT = 20e3 * LENGTH * HEIGHT
LEAST, LARGEST = (WEIGHT * arm / (LENGTH - LEDGE) for arm in (LENGTH / 2 - LEDGE, LENGTH / 2))


def beam(friction=0.6, R=None, shift=(0, 0, 0), **joint):
    """Model of the beam on its ledges, ``left`` and ``right``."""
    blocks = beam_on_ledges().blocks if R is None else moved(beam_on_ledges().blocks, R, shift)
    return model_of(blocks, bs.JointMaterial("joint", friction, **joint))


def on_three_ledges():
    """Model of the beam with another ledge, ``middle``."""
    return beam_on_ledges(box("middle", [1.75, 0, -0.3], [LEDGE, 1, 0.3], fixed=True))


def arch(thickness, friction=0.6, **more):
    return semicircle(thickness, bs.JointMaterial("joint", friction), **more)


def settle(model, supports, direction, dead=SELF_WEIGHT, settings=None, **case):
    return bs.run(model, bs.SettlementCase("case", dead, supports, direction, **case), settings=settings)["case"]


@pytest.mark.parametrize(
    ("flow", "procedure"),
    [("associative", None), *(("nonassociative", of) for of in (None, "fictitious", "shifted", "loading path"))],
)
@pytest.mark.parametrize("friction", [0.1, 0.6])
def test_beam_on_ledges(flow, procedure, friction):
    settings = procedure and bs.ProcedureSettings(procedure=procedure)
    result = settle(beam(friction), ["left"], (0, 0, -1), settings=settings, flow=flow)
    assert result.status == "converged"
    assert result.certificate.holds
    # What the iteration without dilatancy leaves is its cohesion, 1e-6 of the beam's weight.
    assert result.reaction.to("N").magnitude == pytest.approx(LEAST, rel=1e-6)
    np.testing.assert_allclose(result.reaction_range.to("N").magnitude, [LEAST, LARGEST], rtol=1e-6)
    assert bs.results.contradictions(bs.run(beam(friction), [result.case])) == []


def test_the_mechanism_turns_about_the_inner_edge():
    result = settle(beam(), ["left"], "-z")
    assert set(result.states.isel(iteration=-1).to_numpy()) == {"hinge"}
    mechanism = result.mechanism
    # The ledge goes down by one, and with it the end of the beam.
    np.testing.assert_allclose(mechanism.translation.sel(block="left"), [0, 0, -1], atol=1e-6)
    np.testing.assert_allclose(mechanism.translation.sel(block="right"), 0, atol=1e-6)
    arm = LENGTH - LEDGE
    np.testing.assert_allclose(mechanism.rotation.sel(block="beam"), [0, -1 / arm, 0], atol=1e-6)


def test_the_loading_path_lowers_the_support():
    settings = bs.ProcedureSettings(procedure="loading path")
    model = beam(normal_stiffness="10 GPa/m", shear_stiffness="4 GPa/m")
    history = settle(model, ["left"], "-z", settings=settings).history
    path = history.where(history["stage"] == "loading_path", drop=True)
    # From half the weight, which elastic ledges carry alike, while they go down by millimetres.
    assert path["reaction"].to_numpy()[0] == pytest.approx(WEIGHT / 2, rel=1e-5)
    assert path["reaction"].to_numpy()[-1] == pytest.approx(LEAST, rel=1e-4)
    assert path["displacement"].attrs["units"] == "meter"
    assert 0 < path["displacement"].to_numpy()[1] < 1e-3


@pytest.mark.parametrize("about", [None, Q_([1, 0, 0], "m")], ids=["lowered", "turned"])
def test_the_displacement_of_the_path_is_that_of_the_support(about):
    # Bearings of stiffness k and kt against turning: while the left one goes down by d and turns by t, the beam turns
    # by (d - 2 dR / k) / l, and what its turn and theirs press into the bearings is dR l.
    model = beam(normal_stiffness="10 GPa/m", shear_stiffness="4 GPa/m")
    k, span = 10e9 * LEDGE, LENGTH - LEDGE
    kt = k * (LEDGE / 2) ** 2
    # The weight of the beam alone is none of the dead load, nor is any load on what lies on it.
    plate = box("plate", [1.8, 0, HEIGHT], [0.4, 1, 0.1])
    model = model_of([*model.blocks, plate], model.interfaces[0].joint_material)
    dead = bs.LoadPattern("dead", [bs.PointLoad("beam", Q_([LENGTH / 2, 0.5, HEIGHT], "m"), "[0, 0, -48] kN")])
    settings = bs.ProcedureSettings(procedure="loading path", path_step=0.001)
    direction = "-z" if about is None else "-y"
    history = settle(model, ["left"], direction, dead, settings, about=about).history
    path = history.where(history["stage"] == "loading_path", drop=True)
    fall = float(path["reaction"][0] - path["reaction"][1])
    s = float(path["displacement"][1])
    if about is None:
        expected = 2 * kt * s / (span**2 + 4 * kt / k)
    else:
        # At one characteristic length from the axis; the ledge is 0.75 m from it.
        t = s / model.characteristic_length
        arm = 1 - LEDGE / 2
        dR = (2 * kt * arm * t - kt * t * span) / (span**2 + 4 * kt / k)
        turn = (arm * t - 2 * dR / k) / span
        expected = dR * arm + kt * (t - turn)
    assert fall == pytest.approx(expected, rel=1e-4)


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
def test_a_support_that_carries_all_keeps_all():
    # The structure follows as one body: relative velocities are rounding, and so is the motion of its joints.
    blocks = [box("base", [-1, -1, -1], [3, 3, 1], fixed=True), *(box(f"b{k}", [0, 0, k], [1, 1, 1]) for k in range(2))]
    result = settle(model_of(blocks, bs.JointMaterial("joint", 0.6)), ["base"], "-z")
    assert result.status == "converged"
    assert result.reaction.magnitude == pytest.approx(40e3, rel=1e-9)
    np.testing.assert_allclose(result.reaction_range.magnitude, 40e3, rtol=1e-9)
    assert set(result.states.isel(iteration=-1).to_numpy()) == {"sticking"}
    assert result.active_joints.empty


@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
def test_a_support_that_is_not_needed_keeps_nothing(flow):
    """A third ledge under the middle: the beam stands without it, and nothing follows it."""
    model = on_three_ledges()
    down = settle(model, ["middle"], "-z", flow=flow)
    assert down.status == "converged"
    assert abs(down.reaction.magnitude) < 1e-6 * WEIGHT
    assert down.certificate.flow_rule_gap_limit == pytest.approx(1e-3 * down.settings.numerics.gap_tolerance, rel=1e-6)
    # The middle alone carries the beam at most: the other two then carry nothing, and the beam stands on it.
    np.testing.assert_allclose(down.reaction_range.magnitude, [0, WEIGHT], atol=1e-6 * WEIGHT)
    up = settle(model, ["middle"], "+z", flow=flow)
    np.testing.assert_allclose(up.reaction_range.magnitude, [-WEIGHT, 0], atol=1e-6 * WEIGHT)
    path = settle(model, ["middle"], "-z", settings=bs.ProcedureSettings(procedure="loading path"))
    assert abs(path.reaction.magnitude) < 1e-6 * WEIGHT
    assert (path.outcome.procedure, path.settled) == (bs.vocabulary.Procedure.LOADING_PATH, True)


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
def test_the_reaction_of_a_pebble_beside_a_beam_is_as_exact():
    """The gap of a reaction is measured by what it carries, and not by the weight of all that stands around."""
    size = 0.02
    pebble = [box("slab", [9, 0, -0.3], [1, 1, 0.3], fixed=True), box("pebble", [9.5, 0.5, 0], [size, size, size])]
    found = settle(model_of([*beam().blocks, *pebble], bs.JointMaterial("joint", 0.6)), ["slab"], "-z")
    assert found.reaction.magnitude == pytest.approx(20e3 * size**3, rel=1e-6)
    assert found.certificate.flow_rule_gap_limit <= 1.01 * found.settings.numerics.gap_tolerance * -found.load_factor


def test_supports_settle_as_one_body():
    both = settle(beam(), ["left", "right"], "-z", flow="associative")
    assert both.reaction.magnitude == pytest.approx(WEIGHT, rel=1e-9)
    # Together they carry the whole weight, whose moment about the left end is W L / 2.
    turn = settle(beam(), ["left", "right"], (0, 1, 0), about=Q_([0, 0, 0], "m"), flow="associative")
    np.testing.assert_allclose(turn.reaction_range.to("N*m").magnitude, WEIGHT * LENGTH / 2, rtol=1e-7)
    # About the outer edge of the right ledge the left one turns, and is pressed at its own outer edge.
    one = settle(beam(), ["left"], (0, -1, 0), about=Q_([LENGTH, 0, 0], "m"), flow="associative")
    assert one.reaction.to("kN*m").magnitude == pytest.approx(LEAST * LENGTH / 1e3, rel=1e-6)


def test_crushing_raises_the_least_reaction():
    """Stress blocks of depth ``R / (f_c b)`` stand at the edges: the arms shorten by half of each."""
    strength, reaction = 200e3, LEAST
    result = settle(beam(compressive_strength="200 kPa"), ["left"], "-z", flow="associative")
    for _ in range(60):
        own, other = reaction / strength / 2, LENGTH - LEDGE + (WEIGHT - reaction) / strength / 2
        reaction = WEIGHT * (other - LENGTH / 2) / (other - own)
    assert reaction > 1.04 * LEAST
    assert result.reaction.magnitude == pytest.approx(reaction, rel=1e-6)


def test_a_tie_between_beam_and_ledge():
    """The end of the beam turns away from the ledge that goes down: a tie a quarter metre from it yields.

    By moments about the inner edge of the other ledge the joint is pressed by ``T (L − a − 0.25 m) / (L − a)`` more,
    while the tie pulls the ledge up by T.
    """
    model = beam()
    ends = ("left", "[0.25, 0.5, -0.2] m"), ("beam", "[0.25, 0.5, 0.5] m")
    tie = bs.Tie("tie", *ends, yield_force="10 kN", prestress="5 kN")
    tied = bs.Model("tied", model.blocks, model.interfaces, ties=[tie])
    result = settle(tied, ["left"], "-z", flow="associative")
    assert result.reaction.magnitude == pytest.approx(LEAST - 10e3 * 0.25 / (LENGTH - LEDGE), rel=1e-6)
    rate = result.history["tie_elongation_rate"].to_numpy()[-1, 0] * WEIGHT
    assert rate == pytest.approx(0.25 / (LENGTH - LEDGE), rel=1e-5)


def test_loads_on_supports_are_told():
    on_ledge = bs.PointLoad("left", Q_([0.25, 0.5, 0], "m"), Q_([0, 0, -5], "kN"))
    bell = bs.Weight("left", Q_([0.25, 0.5, 0], "m"), "2 kN")
    couple = bs.Moment("right", Q_([0, 3, 0], "kN*m"))
    loaded = settle(beam(), ["left"], "-z", bs.LoadPattern("dead", [bs.SelfWeight(), on_ledge, bell, couple]))
    plain = settle(beam(), ["left"], "-z")
    assert loaded.reaction.magnitude == pytest.approx(plain.reaction.magnitude, rel=1e-9)
    said = "Loads of 'dead' on supports do nothing, forces of 7 kN and moments of 3 kN·m on left, right:"
    assert said in loaded.describe()
    assert "do nothing" not in plain.describe()
    on_beam = bs.PointLoad("beam", Q_([2, 0.5, HEIGHT], "m"), Q_([0, 0, -5], "kN"))
    assert settle(beam(), ["left"], "-z", bs.LoadPattern("dead", [bs.SelfWeight(), on_beam])).masses == ""


@pytest.mark.parametrize(
    ("thicknesses", "voussoirs", "least", "within"),
    [((0.1074, 0.1070, 0.1068), 27, 0.10672, 2e-5), ((0.1083, 0.1079), 101, 0.107426, 1e-4)],
)
def test_the_thrust_of_the_thinnest_arch_is_one_number(thicknesses, voussoirs, least, within):
    """The range of thrust closes linearly towards the least thickness: 0.10672 of 27 voussoirs, 0.107426 of an arch."""
    spans = []
    for thickness in thicknesses:
        result = settle(arch(thickness, voussoirs=voussoirs), ["left"], "-x", flow="associative")
        low, high = result.reaction_range.magnitude
        spans.append((high - low) / high)
    assert spans[0] < 7 * (thicknesses[0] - least)
    slope = (spans[0] - spans[-1]) / (thicknesses[0] - thicknesses[-1])
    closed = [thickness - span / slope for thickness, span in zip(thicknesses[1:], spans[1:], strict=True)]
    assert closed == pytest.approx([least] * len(closed), abs=within)


def test_an_arch_that_does_not_stand_has_no_thrust():
    result = settle(arch(0.1065), ["left"], "-x")
    assert result.status == "unstable_under_dead_load"
    assert np.isnan(result.reaction.magnitude)
    assert np.isnan(result.reaction_range.magnitude).all()


def test_thrusts_of_both_abutments_and_directions_agree():
    model = arch(0.15)
    left = settle(model, ["left"], "-x", flow="associative").reaction_range.magnitude
    right = settle(model, ["right"], "+x", flow="associative").reaction_range.magnitude
    np.testing.assert_allclose(left, right, rtol=1e-7)
    # Against the motion the least is the largest.
    inward = settle(model, ["left"], "+x", flow="associative").reaction_range.magnitude
    np.testing.assert_allclose(inward, -left[::-1], rtol=1e-7)


def test_a_jammed_beam_has_no_largest_thrust():
    # Between two walls friction holds the beam by any force; without walls it only rubs on its ledges.
    ends = [box("a", [-1, 0, 0], fixed=True), box("b", [2, 0, 0], fixed=True)]
    model = model_of([*ends, box("beam", [0, 0, 0], [2, 1, 1])], bs.JointMaterial("joint", 0.6))
    least, largest = settle(model, ["a"], "-x", flow="associative").reaction_range.magnitude
    # Each side carries half the weight by friction at least.
    assert least == pytest.approx(20e3 / 0.6, rel=1e-6)
    assert np.isposinf(largest)
    jammed = settle(model, ["a"], "+x", flow="associative")
    assert jammed.status == "unbounded"
    assert jammed.outcome.reason is bs.vocabulary.Reason.NEVER_COLLAPSES
    assert np.isneginf(jammed.reaction.magnitude)
    with_friction_alone = settle(model, ["a"], "+x")
    assert with_friction_alone.status == "unbounded"
    assert with_friction_alone.outcome.reason is not bs.vocabulary.Reason.NEVER_COLLAPSES


def test_nonassociative_reactions_are_not_below_the_least():
    model = arch(0.2, friction=0.4)
    flat = bs.SettlementCase("case", SELF_WEIGHT, ["left"], "-x")
    analysis = bs.run(model, flat, spread=["steep", "shifted"])
    least, largest = analysis["case"].reaction_range.magnitude
    for result in analysis.values():
        assert result.status == "converged"
        assert least * (1 - 1e-6) <= result.reaction.magnitude <= largest
    head = analysis.headlines["case"]
    assert "associative bound" in str(head)
    assert str(head).endswith("kN)")


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_reaction_scales_with_size(scale):
    """Weights go with the third power of the size."""
    own = settle(arch(0.15, voussoirs=9), ["left"], "-x").reaction.magnitude
    other = settle(arch(0.15, voussoirs=9, radius=scale), ["left"], "-x").reaction.magnitude
    assert other == pytest.approx(own * scale**2, rel=1e-6)


def test_reaction_is_that_of_the_rotated_structure():
    R, shift = rotation((1, 2, 3), 0.7), (5.0, -3.0, 2.0)
    # Gravity does not turn along; a force on the beam does, and with it the ledges.
    load = np.array([0.0, 0.0, -WEIGHT])
    centre = np.array([LENGTH / 2, 0.5, HEIGHT / 2])

    def reaction(Q, d, about=None):
        point, force = Q @ centre + d, Q @ load
        dead = bs.LoadPattern("dead", [bs.PointLoad("beam", Q_(point, "m"), Q_(force, "N"))])
        more = {} if about is None else {"about": Q_(Q @ about + d, "m")}
        axis = np.array([0, 0, -1.0]) if about is None else np.array([0, -1.0, 0])
        model = beam(R=Q, shift=d)
        return settle(model, ["left"], Q @ axis, dead, flow="associative", **more).reaction.magnitude

    for about in (None, np.array([LENGTH, 0, 0])):
        upright = reaction(np.eye(3), np.zeros(3), about)
        assert reaction(R, np.array(shift), about) == pytest.approx(upright, rel=1e-6)
