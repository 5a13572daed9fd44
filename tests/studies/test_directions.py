"""Load factors around the compass."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import PIER, SELF_WEIGHT, box, model_of, moved, rotation, settings_of


@pytest.fixture(scope="module")
def tower():
    """A square tower of three drums, 1 m wide and 4 m high."""
    blocks = [box("ground", [-1, -1, -1], [3, 3, 1], fixed=True)]
    blocks += [box(f"drum {k}", [0, 0, k], [1, 1, 1]) for k in range(4)]
    return model_of(blocks, bs.JointMaterial("joint", 0.6), name="tower")


def test_a_square_tower_is_symmetric(tower):
    """It overturns at b / h in the direction of a side; across a corner the lever is √2 times as long."""
    around = bs.directions(tower, SELF_WEIGHT, directions=8, flow="associative")
    expected = np.tile([0.25, 0.25 * 2**0.5], 4)
    np.testing.assert_allclose(around.data.load_factor, expected, rtol=1e-6)
    assert around.data.direction.to_numpy().tolist() == [0, 45, 90, 135, 180, 225, 270, 315]
    assert around.data.direction.attrs["units"] == "degree"
    assert around.load_factor == around.governing.load_factor == pytest.approx(around.data.load_factor.min().item())
    assert around.governing_direction % 90 == 0
    # A square by its corners: the loads it carries are those on its sides, at 0.25 and more from the centre.
    assert around.least_between == pytest.approx(0.25, rel=1e-6)
    assert around.governing.mechanism.sizes["block"] == 5


def test_between_the_directions(tower):
    """Turned by 45 degrees and pushed across its corners only, its least is that of a chord: α cos 45°."""
    blocks = moved(tower.blocks, rotation((0, 0, 1), np.pi / 4))
    turned = model_of(blocks, tower.interfaces[0].joint_material)
    around = bs.directions(turned, SELF_WEIGHT, 4, flow="associative")
    assert around.load_factor == pytest.approx(0.25 * 2**0.5, rel=1e-6)
    assert around.least_between == pytest.approx(0.25, rel=1e-6)
    half = bs.directions(turned, SELF_WEIGHT, 2, flow="associative")
    assert np.isnan(half.least_between)


@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
def test_what_a_part_of_the_compass_does_not_cover_is_told(flow):
    """A wall 0.2 m by 2 m, 1 m high, pushed at 60 and 120 degrees alone: at 180 it carries half of what is found."""
    blocks = [box("ground", [-1, -1, -1], [4, 4, 1], fixed=True), box("wall", [0, 0, 0], [0.2, 2, 1])]
    model = model_of(blocks, bs.JointMaterial("joint", 0.9))
    around = bs.directions(model, SELF_WEIGHT, Q_([60, 120], "deg"), flow=flow)
    assert around.load_factor == pytest.approx(0.4, rel=1e-3)
    said = "are not covered, and one of them may be lower: none was run for 300 deg, from 120 to 60 deg"
    assert f"  directions between them {said}" in str(around).splitlines()
    whole = bs.directions(model, SELF_WEIGHT, 4, flow=flow)
    assert whole.load_factor == pytest.approx(0.2, rel=1e-3)
    assert "none was run" not in str(whole)
    assert ("not covered" in str(whole)) is (flow == "nonassociative")


@pytest.mark.parametrize("share", [0.5, -0.5])
def test_with_a_vertical_part(tower, share):
    """Moments about the edge: α h / 2 = (1 − share α) b / 2."""
    around = bs.directions(tower, SELF_WEIGHT, Q_([0, 30], "deg"), vertical=share, flow="associative")
    assert around.data.attrs["vertical"] == share
    assert around.data.load_factor.to_numpy()[0] == pytest.approx(1 / (4 + share), rel=1e-6)
    assert np.isnan(around.least_between)
    assert f"with 0.5 of it {'up' if share > 0 else 'down'}" in str(around)


def test_a_file_keeps_all_directions(tower, tmp_path):
    around = bs.directions(tower, SELF_WEIGHT, 4, store=tmp_path / "around.h5")
    again = bs.studies.Directions.of(bs.open_analysis(tmp_path / "around.h5"))
    assert again.data.identical(around.data)
    assert str(again) == str(around)


def test_directions_without_a_load_factor_are_told(tower, small_analysis):
    settings = settings_of(procedure="fictitious", max_programs=2)
    with pytest.warns(bs.errors.StudyWarning, match=r"no load factor for push 0 deg.*the envelope may be lower"):
        around = bs.directions(tower, SELF_WEIGHT, 2, settings=settings)
    assert np.isnan(around.load_factor)
    with pytest.raises(bs.errors.ModelError, match=r"none has a load factor \(not converged\)"):
        _ = around.governing
    with pytest.raises(bs.errors.ModelError, match="no case pushes the weight in a direction"):
        bs.studies.Directions.of(small_analysis)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (0, "directions: 0"),
        ([0, 45], "0 has no unit"),
        (Q_([0, 360], "deg"), "repeats a direction"),
        (Q_([1], "m"), "does not fit"),
        ([], "number of angles 0"),
    ],
)
def test_bad_directions(tower, given, said):
    with pytest.raises(bs.errors.BlockstructError, match=said):
        bs.directions(tower, SELF_WEIGHT, given)


def test_directions_of_a_document(tmp_path, done):
    """Each case with directions has its summary."""
    path, thin = tmp_path / "pier.yaml", PIER.replace("[0.5 m, 1 m, 1 m]", "[0.5 m, 0.2 m, 1 m]")
    path.write_text(thin.replace("variable: push", "directions: [30 deg, 300 deg], vertical: -0.5"))
    names = [case.name for case in bs.read_document(path).cases]
    assert names == ["push 30 deg, 0.5 down", "push 300 deg, 0.5 down"]
    quake = "{name: quake, dead: dead, directions: [0 deg, 90 deg], vertical: 0.5, flow: associative}"
    along = "{name: along, dead: dead, variable: push, flow: associative}"
    around = "{name: push, dead: dead, directions: 4, flow: associative}"
    path.write_text(f"{thin.partition('cases:')[0]}cases: [{around}, {quake}, {along}]")
    out = done("run", path, "-o", tmp_path / "pier.h5")
    assert "case push, pier: pushed in 4 directions\n" in out
    assert "  governing: 90 deg, load factor 0.2\n" in out
    # About the edge, the lever of the weight is b / 2, that of the push h / 2 and of its part upwards b / 2.
    assert "case quake, pier: pushed in 2 directions, with 0.5 of it up\n" in out
    assert f"  governing: 90 deg, load factor {0.2 / (1 + 0.5 * 0.2):.4g}\n" in out
