"""The state of a joint follows its forces: a joint that is pressed is never open."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import box, model_of, push, single_block, solve


def final_state(history, interface):
    return bs.results.contact_state(history.isel(iteration=[-1])).sel(interface=interface).item()


@pytest.fixture(scope="module")
def sliding():
    return solve(model_of(*single_block(1.0, 0.5)), push(1, 0, 0)).history


@pytest.mark.parametrize(("height", "state"), [(0.5, "sliding"), (2.0, "hinge")])
@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
def test_a_block_slides_below_its_slenderness_and_rocks_above(height, state, flow):
    """Along a joint without dilatancy it falls at the smaller of μ and b / h."""
    result = solve(model_of(*single_block(1.0, height)), push(1, 0, 0), flow)
    assert result.load_factor == pytest.approx(min(0.65, 1 / height), rel=1e-3)
    assert final_state(result.history, "ground|block") == state


@pytest.mark.parametrize("share", [0.0, 0.005, 0.02, 0.1])
def test_a_joint_that_bears_and_slides_is_closed(sliding, share):
    """A solver lifts a block within its tolerance; the weight that the joint carries shows that it does not rise."""
    lifted = sliding.copy(deep=True)
    lifted["relative_velocity"].loc[{"component": "n"}] += share * np.abs(lifted["relative_velocity"]).max()
    assert final_state(lifted, "ground|block") == "sliding"


def test_a_joint_that_loses_its_weight_is_open():
    """A block is lifted by its weight of 10 kN, and solver noise in the joint carries nothing."""
    up = bs.LoadPattern("up", [bs.PointLoad("block", Q_([0.5, 0.5, 0.5], "m"), Q_([0, 0, 1], "N"))])
    result = solve(model_of(*single_block(1.0, 0.5)), up)
    assert result.load_factor == pytest.approx(10e3, rel=1e-6)
    assert final_state(result.history, "ground|block") == "open"


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")  # The state counts, not the number.
def test_a_light_cap_slides_on_a_wall():
    """A cap between smooth keepers holds the head of a wall by friction alone, and bears its own weight on it."""
    height, depth, thickness, n = 1.5, 0.11, 0.02, 18
    cap = bs.Material("light", "5 kN/m^3")
    size = [depth, 1, height / n]
    blocks = [box("ground", [0, 0, -0.1], [depth, 1, 0.1], fixed=True)]
    blocks += [box(f"{k}", [0, 0, k * height / n], size) for k in range(n)]
    blocks.append(bs.Block.box("cap", Q_([0, 0, height], "m"), Q_([depth, 1, thickness], "m"), cap))
    blocks += [box(f"keeper {k}", [x, 0, height], [0.1, 1, thickness], fixed=True) for k, x in enumerate([-0.1, depth])]
    joints = {
        "keeper*|*": bs.JointMaterial("smooth", 0.0),
        "*|keeper*": bs.JointMaterial("smooth", 0.0),
        "*": bs.JointMaterial("rough", 10.0),
    }
    model = bs.Model("wall", blocks, bs.detect_interfaces(blocks, joints))
    at = Q_([depth / 2, 0.5, height / 2], "m")
    result = solve(model, bs.LoadPattern("push", [bs.PointLoad(f"{n // 2}", at, Q_([1, 0, 0], "N"))]), "nonassociative")
    weight = depth * thickness * 5e3
    name = f"{n - 1}|cap"
    assert result.resultants.force.sel(component="n", interface=name)[-1].item() == pytest.approx(weight, rel=1e-3)
    assert "sliding" in final_state(result.history, name).split(" + ")
