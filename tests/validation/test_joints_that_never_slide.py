"""Joints of infinite friction: no shear force is too large, and nothing slips.

That is the assumption of J. Heyman, Int. J. Solids Struct. 2 (1966) 249–279, doi:10.1016/0020-7683(66)90018-7.

In associative flow infinite friction is the limit of a large one. ``test_minimum_thickness_arch.py`` has Heyman's arch.
"""

import math

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.errors import DimensionError, ModelError
from structures import SELF_WEIGHT, STONE, box, kept, model_of, push, semicircle, single_block, solve

NEVER = bs.JointMaterial("never slides", math.inf)
DRY = bs.JointMaterial("dry", 0.4)
PROCEDURES = [{}, {"path_steps": "interior point"}, {"procedure": "fictitious"}, {"procedure": "shifted"}]


def wall_and_return(joint):
    size = {"unit_length": "0.4 m", "unit_height": "0.2 m", "thickness": "0.2 m"}
    side = bs.structures.Sidewall("side", at="0 m", length="0.8 m")
    return model_of(bs.wall(length="1.6 m", courses=4, sidewalls=[side], material=STONE, **size), joint)


def two_stacked():
    """A block on another one that slides on the ground, with a joint between the two that does not slide."""
    blocks = [
        box("ground", [-1, -1, -1], [4, 3, 1], fixed=True),
        box("lower", [0, 0, 0], [1, 1, 0.5]),
        box("upper", [0, 0, 0.5], [1, 1, 0.5]),
    ]
    model = model_of(blocks, NEVER)
    of_ground = [i.with_joint_material(DRY) if "ground" in i.name else i for i in model.interfaces]
    return bs.Model("stacked", blocks, of_ground)


@pytest.mark.parametrize("settings", PROCEDURES)
def test_a_block_rocks_that_would_slide(settings):
    blocks, slippery = single_block(0.5, 1.0, mu=0.1)
    result = solve(model_of(blocks, NEVER), push(1, 0, 0), "nonassociative", **settings)
    assert result.load_factor == pytest.approx(0.5, rel=1e-5)
    assert result.outcome.settled
    assert solve(model_of(blocks, slippery), push(1, 0, 0)).load_factor == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize("settings", PROCEDURES)
def test_an_arch_has_one_number(settings):
    result = solve(semicircle(0.15, NEVER, 15), push(1, 0, 0), "nonassociative", **settings)
    assert result.outcome.settled
    steep = solve(semicircle(0.15, bs.JointMaterial("steep", 5.0), 15), push(1, 0, 0))
    assert result.load_factor == pytest.approx(steep.load_factor, rel=1e-6)


@pytest.mark.parametrize("direction", [(-1, 0, 0), (0, 1, 0), (0, -1, 0), (1, 0.5, 0)])
def test_limit_of_large_friction_in_associative_flow(direction):
    never, large = (
        solve(wall_and_return(joint), push(*direction)) for joint in (NEVER, bs.JointMaterial("large", 10.0))
    )
    assert never.load_factor == pytest.approx(large.load_factor, rel=1e-6)
    assert never.load_factor < 2


@pytest.mark.parametrize("settings", PROCEDURES)
def test_others_slide(settings):
    result = solve(two_stacked(), push(1, 0, 0), "nonassociative", **settings)
    assert result.load_factor == pytest.approx(0.4, rel=1e-5)
    used = bs.results.utilisation(result.history)["sliding"].isel(iteration=-1).to_numpy()
    assert used == pytest.approx([1, 0], abs=1e-3)
    joints = bs.results.active_joints(result.history)
    assert list(joints["state"]) == ["sliding"]


@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
def test_nothing_pulls_a_keyed_block_out(flow):
    blocks = [box("left", [-1, 0, 0], fixed=True), box("right", [1, 0, 0], fixed=True), box("key", [0, 0, 0])]
    assert solve(model_of(blocks, NEVER), push(0, 1, 0), flow).status == "unbounded"


def test_tensile_strength_bears_on_joints_that_never_slide():
    # α W h / 2 = W b / 2 + f_t A b / 2.
    model = model_of(single_block(0.5, 1.0)[0], NEVER.varied(tensile_strength="10 kPa"))
    assert solve(model, push(1, 0, 0)).load_factor == pytest.approx(0.5 + 0.5 * 10 / 20, rel=1e-6)


def test_crushing_is_that_of_large_friction():
    never, large = (
        solve(semicircle(0.15, joint.varied(compressive_strength="0.5 MPa"), 15), push(1, 0, 0)).load_factor
        for joint in (NEVER, bs.JointMaterial("large", 10.0))
    )
    assert never == pytest.approx(large, rel=1e-6)
    assert never < 0.99 * solve(semicircle(0.15, NEVER, 15), push(1, 0, 0)).load_factor


def test_settlement_of_an_abutment():
    case = bs.SettlementCase("spreads", SELF_WEIGHT, ["left"], "-x", flow="associative")
    models = [semicircle(0.2, joint, 15) for joint in (NEVER, bs.JointMaterial("large", 10.0))]
    never, large = (bs.run(model, case)["spreads"].reaction.magnitude for model in models)
    assert never == pytest.approx(large, rel=1e-6)


def test_files_and_documents(tmp_path):
    kept(two_stacked(), bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0)), tmp_path)


def test_constructor():
    assert NEVER.varied(compressive_strength="4 MPa").friction_coefficient == math.inf
    assert bs.JointMaterial("text", "inf") == bs.JointMaterial("text", math.inf)
    for values in ({"cohesion": "1 kPa"}, {"dilatancy_angle": "5 deg"}, {"torsion": "uniform pressure"}):
        with pytest.raises(ModelError):
            bs.JointMaterial("joint", math.inf, **values)
    for value in (-math.inf, math.nan):
        with pytest.raises(DimensionError):
            bs.JointMaterial("joint", value)


def test_a_pushover_refuses_them():
    case = bs.Pushover("push", dead=SELF_WEIGHT, variable=push(1, 0, 0), control=("block", (1, 0, 0)))
    with pytest.raises(ModelError, match="never slides"):
        bs.run(model_of(single_block(0.5, 1.0)[0], NEVER), [case], progress=False)


def test_derivatives_of_the_others():
    result = solve(two_stacked(), push(1, 0, 0))
    found = bs.studies.first_order(result, 0.1)
    derivative = found["derivative"].to_series()
    assert derivative.to_numpy() == pytest.approx([1.0, 0.0], abs=1e-4)
    assert np.isfinite(found["independent"])
