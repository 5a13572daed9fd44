"""Settlements through large displacements against hand calculations.

Lengths in m; x along the span, z up; W the weight of a block and θ its rotation.
"""

import numpy as np
import pytest

import blockstruct as bs
import structures
from blockstruct import Q_
from properties import slow_after
from structures import SELF_WEIGHT, STONE, model_of, stopping

SPAN, DEPTH = 1.0, 0.25


def box(name, x, z, *, fixed=False):
    return structures.box(name, [x[0], 0, z[0]], [x[1] - x[0], 1, z[1] - z[0]], fixed=fixed)


def beam():
    """Beam of 4 m × 0.6 m on ledges of 0.5 m."""
    ledges = [box(name, x, (-3, 0), fixed=True) for name, x in (("left", (0, 0.5)), ("right", (3.5, 4)))]
    return model_of([*ledges, box("beam", (0, 4), (0, 0.6))], bs.JointMaterial("joint", 0.6))


def flat_arch():
    """Two blocks between abutments, hinged at the bottom of their ends and at the top in the middle."""
    sides = [box(name, x, (-1, 1), fixed=True) for name, x in (("left", (-0.5, 0)), ("right", (2, 2.5)))]
    blocks = [box(name, (x, x + SPAN), (0, DEPTH)) for name, x in (("a", 0), ("b", SPAN))]
    return model_of([*sides, *blocks], bs.JointMaterial("rough", 1.0))


def settle(model, direction, displacement, **more):
    case = bs.SettlementCase("case", SELF_WEIGHT, ["left"], direction, displacement=displacement, **more)
    return bs.run(model, case)["case"]


@pytest.fixture(scope="module")
def sunk():
    return settle(beam(), "-z", "0.5 m", steps=20)


@pytest.fixture(scope="module")
def spread():
    return settle(flat_arch(), "-x", "0.2 m", steps=100)


def test_a_beam_turns_about_one_ledge_and_slides_on_the_other(sunk):
    """Moments about the edge of the ledge that stays: ``R 3.5 (cos θ + μ sin θ) = W (1.5 cos θ + 0.3 sin θ)``."""
    curve, W = sunk.capacity, 48e3
    turn = -curve["rotation"].sel(block="beam", axis="y").to_numpy()
    expected = W * (1.5 * np.cos(turn) + 0.3 * np.sin(turn)) / (3.5 * (np.cos(turn) + 0.6 * np.sin(turn)))
    slides = turn > 1e-3
    np.testing.assert_allclose(curve["reaction"].to_numpy()[slides], expected[slides], rtol=1e-4)
    np.testing.assert_allclose(curve["displacement"][slides], 3.5 * np.sin(turn[slides]), rtol=1e-4)
    assert curve["reaction"][0] == pytest.approx(sunk.reaction.magnitude, rel=1e-6)
    assert curve["holds"].all()
    assert curve["energy_error"].max() < 1e-4
    assert (sunk.curve_outcome.end, float(curve["displacement"][-1])) == ("displacement_reached", pytest.approx(0.5))
    assert np.isnan(curve["d0"])


def test_a_tie_that_breaks_changes_the_reaction(sunk):
    """A hanger of 5 kN at x = 0.25 m: at first ``R = (W 1.5 + 5 kN 3.25) / 3.5 − 5 kN``, without it the beam alone."""
    plain = beam()
    hanger = bs.Tie(
        "hanger",
        ("left", "[0.25, 0.5, -2] m"),
        ("beam", "[0.25, 0.5, 0.5] m"),
        yield_force="5 kN",
        elongation_limit="10 mm",
    )
    result = settle(bs.Model("hung", plain.blocks, plain.interfaces, ties=[hanger]), "-z", "0.2 m", steps=20)
    assert result.reaction.magnitude == pytest.approx((48e3 * 1.5 + 5e3 * 3.25) / 3.5 - 5e3, rel=1e-4)
    (broken,) = result.broken_ties.to_dict("records")
    alone = np.interp(broken["displacement [meter]"], sunk.capacity["displacement"], sunk.capacity["reaction"])
    assert broken["reaction after [newton]"] == pytest.approx(alone, rel=1e-3)
    assert broken["reaction before [newton]"] == pytest.approx(19.8e3, rel=2e-3)
    (words,) = bs.results.breaking_words(result.capacity)
    assert words.endswith("the reaction changes from 19.79 kN to 20.24 kN")


def test_an_arch_on_spreading_abutments_falls(spread):
    """Its thrust is ``W (l cos θ + h sin θ) / 2 (h cos θ − l sin θ)``, until both diagonals are horizontal."""
    curve, W = spread.capacity, 20e3 * SPAN * DEPTH
    turn = curve["rotation"].sel(block="a", axis="y").to_numpy()
    along, rise = SPAN * np.cos(turn) + DEPTH * np.sin(turn), DEPTH * np.cos(turn) - SPAN * np.sin(turn)
    early = turn < 0.05
    np.testing.assert_allclose(curve["reaction"].to_numpy()[early], (W * along / 2 / rise)[early], rtol=1e-4)
    largest = 2 * (np.hypot(SPAN, DEPTH) - SPAN)
    assert float(curve["d0"]) == pytest.approx(largest, rel=2e-3)
    assert spread.curve_outcome.end == "falls"
    assert spread.curve_outcome.displacement == float(curve["d0"])
    assert set(spread.curve_outcome.blocks) == {"a", "b"}
    assert "then blocks fall" in spread.describe()


@pytest.mark.parametrize("steps", [40, *slow_after(80, 120, 240)])
def test_the_fall_of_an_arch_depends_little_on_steps(steps):
    """The arch turns hardly unstable, and blocks fall slowly at first: 120 steps gave a curve without a fall."""
    blocks = bs.arch(span="3.4 m", thickness="0.6 m", depth="1 m", voussoirs=13, material=STONE)
    result = settle(model_of(blocks, bs.JointMaterial("dry", 0.6)), "-z", "2.5 m", steps=steps)
    # 1.892, 1.882, 1.878, 1.877 and 1.875 m with 20, 40, 80, 120 and 240 steps: an error of first order.
    assert float(result.capacity["d0"]) == pytest.approx(1.875, abs=0.3 / steps)


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
def test_a_support_that_carries_all_takes_the_structure_with_it():
    stack = [box("left", (-1, 2), (-1, 0), fixed=True), *(box(f"b{k}", (0, 1), (k, k + 1)) for k in range(2))]
    curve = settle(model_of(stack, bs.JointMaterial("joint", 0.6)), "-z", "1 m", steps=5).capacity
    np.testing.assert_allclose(curve["reaction"], 40e3, rtol=1e-6)
    fallen = curve["position"].isel(step=-1) - curve["position"].isel(step=0)
    np.testing.assert_allclose(fallen.sel(axis="z"), -1, atol=1e-4)


@pytest.mark.parametrize(("width", "drums"), [(0.7, 2), (0.7, 3), (0.7, 5), (0.4, 5)])
def test_the_reaction_of_a_foundation_that_carries_all_is_the_weight(width, drums):
    """Nothing resists the motion elastically: the displacement under a unit reaction was negative by rounding."""
    stack = [structures.box("left", [-2, -2, -0.3], [5, 5, 0.3], fixed=True)]
    stack += [structures.box(f"b{k}", [0, 0, 0.8 * k], [width, 1, 0.8]) for k in range(drums)]
    case = bs.SettlementCase("case", SELF_WEIGHT, ["left"], "-z")
    found = bs.run(model_of(stack, bs.JointMaterial("joint", 0.6)), case)["case"]
    assert found.outcome.settled
    assert found.reaction.magnitude == pytest.approx(16e3 * width * drums, rel=1e-6)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
def test_a_block_follows_a_settlement_far_longer_than_itself():
    stack = [box("left", (-1, 2), (-1, 0), fixed=True), box("b", (0, 1), (0, 1))]
    result = settle(model_of(stack, bs.JointMaterial("joint", 0.6)), "-z", "1000 km", steps=10)
    assert result.curve_outcome.end in ("displacement_reached", "limit_reached")
    assert float(result.capacity["reaction"].min()) == pytest.approx(float(result.capacity["reaction"][0]), rel=1e-3)


def test_a_support_that_carries_nothing_leaves_the_structure():
    places = {"left": (1.75, 2.25), "a": (0, 0.5), "b": (3.5, 4)}
    ledges = [box(name, x, (-3, 0), fixed=True) for name, x in places.items()]
    model = model_of([*ledges, beam().blocks[2]], bs.JointMaterial("joint", 0.6))
    curve = settle(model, "-z", "0.1 m", steps=5).capacity
    np.testing.assert_allclose(curve["reaction"], 0, atol=1)
    np.testing.assert_allclose(curve["position"].sel(block="beam", axis="z"), 0.3, atol=1e-5)


@pytest.mark.parametrize("supports", [["middle"], ["left"], ["left", "right"]])
def test_a_support_that_others_relieve_leaves_the_structure(supports):
    """Two of three ledges bear the beam, or one. The reaction is zero, and a share of no work was missed."""
    ledges = [box(name, (x, x + 0.5), (-3, 0), fixed=True) for name, x in (("left", 0), ("middle", 2), ("right", 4))]
    model = model_of([*ledges, box("beam", (0, 4.5), (0, 0.6))], bs.JointMaterial("joint", 0.6))
    case = bs.SettlementCase("case", SELF_WEIGHT, supports, "-z", displacement="0.1 m", steps=5)
    result = bs.run(model, case)["case"]
    assert result.curve_outcome.end == "displacement_reached"
    np.testing.assert_allclose(result.capacity["reaction"], 0, atol=1)
    np.testing.assert_allclose(result.capacity["position"].sel(block="beam", axis="z"), 0.3, atol=1e-5)
    # Only the supports move in the end, and nothing is near them.
    assert result.capacity["holds"].all()


def test_a_foundation_that_moves_sideways_takes_the_structure_with_it():
    """Nothing resists it. The curve ended after 301 states, within a micrometre."""
    stack = [box("left", (-1, 2), (-1, 0), fixed=True), box("block", (0, 1), (0, 1))]
    result = settle(model_of(stack, bs.JointMaterial("joint", 0.6)), "+x", "0.5 m", steps=5)
    assert result.curve_outcome.end == "displacement_reached"
    gone = result.capacity["position"].sel(block="block", axis="x") - result.capacity["displacement"]
    np.testing.assert_allclose(gone, 0.5, atol=1e-4)


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"displacement": 0.1}, bs.errors.UnitError, "displacement"),
        ({"displacement": "-1 mm"}, bs.errors.ModelError, "more than zero"),
        ({"displacement": "1 kN"}, bs.errors.DimensionError, "displacement"),
        ({"steps": 2}, bs.errors.ModelError, "steps"),
        ({"about": Q_([0, 0, 0], "m")}, bs.errors.ModelError, "turn"),
        ({"flow": "associative"}, bs.errors.ModelError, "associative"),
        ({"displacement": None, "steps": 40}, bs.errors.ModelError, "40 steps"),
    ],
)
def test_bad_input(changes, error, words):
    with pytest.raises(error, match=words):
        bs.SettlementCase("case", SELF_WEIGHT, ["left"], "-z", **{"displacement": "0.1 m", **changes})


def test_supports_that_meet_what_they_cannot_move():
    """A support pushes a block 0.1 m up to another one: 301 states, with reactions up to 5.3 MN, had no end there."""
    places = {
        "ground": ((-2, 6), (-0.5, 0)),
        "left": ((-0.5, 0), (0, 1)),
        "block": ((0, 1), (0, 1)),
        "stop": ((1.1, 2), (0, 1)),
    }
    blocks = [box(name, *place, fixed=name != "block") for name, place in places.items()]
    result = settle(model_of(blocks, bs.JointMaterial("joint", 0.5)), "+x", "0.3 m", steps=20)
    assert (result.curve_outcome.end, result.curve_outcome.displacement) == ("jams", pytest.approx(0.1, rel=1e-4))
    assert result.capacity["holds"].all()


def test_joints_that_large_displacements_do_not_know_are_refused():
    model = model_of(beam().blocks, bs.JointMaterial("mortar", 0.6, cohesion="0.1 MPa"))
    with pytest.raises(bs.errors.ModelError, match=r"settlement case 'case'.*'mortar' has a cohesion"):
        settle(model, "-z", "0.1 m")


def test_it_is_kept_interrupted_and_resumed(tmp_path, sunk):
    case = bs.SettlementCase("case", SELF_WEIGHT, ["left"], "-z", displacement="0.5 m", steps=20)

    path = tmp_path / "beam.h5"
    bs.run(beam(), case, path, listeners=[stopping(bs.analysis.StepDone, at=12)])
    assert bs.open_analysis(path)["case"].capacity.sizes["step"] == 13
    again = bs.AnalysisManager.resume(path)["case"]
    stored = bs.open_analysis(path)["case"]
    for found in (again, stored):
        assert found.case == case
        timed = ["solver_time"]
        assert found.capacity.drop_vars(timed).identical(sunk.capacity.drop_vars(timed))
        assert found.curve_outcome.text == sunk.curve_outcome.text
    document = bs.documents.write_document(tmp_path / "beam.yaml", beam(), [case])
    assert bs.read_document(document).cases == (case,)


def test_every_view_shows_the_reaction(spread, tmp_path):
    from blockstruct.views import figures

    axes = figures.capacity(spread)
    assert axes.get_ylabel() == "reaction R [kN]"
    assert "left" in axes.get_xlabel()
    frame = bs.results.capacity_frame(spread.capacity)
    assert {"displacement [meter]", "reaction [newton]"} <= set(frame)
