"""The history Dataset and its methods."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import box, model_of, push, single_block, solve


@pytest.fixture(scope="module")
def result(small_analysis):
    return small_analysis["push nonassociative"]


def test_every_iteration_is_there(result):
    history = result.history
    assert dict(history.sizes) == {
        "iteration": result.n_iterations,
        "contact_point": 4 * history.sizes["interface"],
        "component": 3,
        "interface": len(history.interface),
        "block": 8,
        "axis": 3,
        "interface_corner": 4 * history.sizes["interface"],
    }
    assert list(history.stage.to_numpy()[[0, 1, -1]]) == ["associative", "loading_path", "admissible"]
    assert history.load_factor[-1] == pytest.approx(result.load_factor, rel=1e-12)
    assert (history.solver_status == "solved").all()
    assert (history.solver_iterations > 3).all()
    assert (history.solver_time > 0).all()
    for name in (
        "contact_force",
        "relative_velocity",
        "block_velocity",
        "block_angular_velocity",
        "fictitious_cohesion",
        "fictitious_slope",
    ):
        assert np.isfinite(history[name]).all(), name


def test_units_match_the_quantities(result):
    units = {
        "newton": ("contact_force", "fictitious_cohesion", "contact_force_unit", "cohesion", "cell_strength"),
        "meter / second": ("relative_velocity", "block_velocity"),
        "meter": ("contact_point_position", "block_position", "interface_position", "interface_corner_position"),
        "meter ** 2": ("interface_area",),
        "pascal": ("compressive_strength",),
        "second": ("solver_time",),
        "dimensionless": ("load_factor", "friction_coefficient", "dilatancy", "yield_excess", "interface_frame"),
    }
    for unit, names in units.items():
        assert {result.history[name].attrs["units"] for name in names} == {unit}


def test_contact_points_are_selected_by_their_interface(result):
    history = result.history
    force = history.contact_force.sel(contact_point="2.1|3.1", component="n")
    k = list(history.interface.to_numpy()).index("2.1|3.1")
    np.testing.assert_array_equal(force, history.contact_force[:, history.interface_of_contact_point == k, 0])
    assert force.sizes["contact_point"] == 4


def test_the_schedule_is_recorded(small_model):
    result = solve(small_model, push(1, 0, 0), "nonassociative", procedure="fictitious")
    history, s = result.history, result.settings
    force = history.contact_force_unit
    steps = history.where(history.stage == "nonassociative", drop=True)
    decay = s.schedule.c0_decay ** np.arange(steps.sizes["iteration"])
    expected = np.maximum(s.schedule.c0 * decay, s.schedule.c0_min)
    assert steps.schedule_cohesion.to_numpy() == pytest.approx(expected)
    assert steps.schedule_slope[0] == s.schedule.slope
    # The recorded condition is the one the forces obey.
    f = history.contact_force
    shear = np.hypot(f.sel(component="s"), f.sel(component="t"))
    excess = shear - history.fictitious_cohesion - history.fictitious_slope * f.sel(component="n")
    assert float((excess / force).max()) < 1e-6


def test_forces_are_in_equilibrium(result, small_model):
    """Block by block, from the history alone: weight, push and contact forces sum up to nothing."""
    last = result.history.isel(iteration=-1)
    index = last.interface_of_contact_point.to_numpy()
    force = np.einsum("kc,kca->ka", last.contact_force, last.interface_frame.to_numpy()[index])
    total = np.zeros((len(small_model.blocks), 3))
    for i, interface in enumerate(small_model.interfaces):
        names = [b.name for b in small_model.blocks]
        total[names.index(interface.plus)] += force[index == i].sum(axis=0)
        total[names.index(interface.minus)] -= force[index == i].sum(axis=0)
    weight = np.array([b.weight for b in small_model.blocks])
    total[:, 2] -= weight
    total[:, 0] += result.load_factor * weight
    total[[b.name == "3.1" for b in small_model.blocks], 0] += result.load_factor * 10
    free = [not b.fixed for b in small_model.blocks]
    assert np.abs(total[free]).max() < 1e-7 * weight.max()


def test_power_of_the_variable_load_is_one_watt(result, small_model):
    last = result.history.isel(iteration=-1)
    weight = np.array([0 if b.fixed else b.weight for b in small_model.blocks])
    velocity = last.block_velocity.sel(axis="x").to_numpy()
    at_load = last.sel(block="3.1")
    # The point load acts 0.1 m above the centroid of block 3.1: v_x + ω_y · 0.1 m.
    extra = 10 * float(at_load.block_velocity.sel(axis="x") + 0.1 * at_load.block_angular_velocity.sel(axis="y"))
    assert weight @ velocity + extra == pytest.approx(1.0, rel=1e-6)


def test_relative_velocity_is_that_of_the_blocks(result):
    h = result.history.isel(iteration=-1)
    blocks = list(h.block.to_numpy())
    k = 17
    interface = int(h.interface_of_contact_point[k])
    minus, plus = str(h.interface[interface].item()).split("|")
    p, v = h.contact_point_position[k].to_numpy(), []
    for name in (minus, plus):
        u, w = (h[what][blocks.index(name)].to_numpy() for what in ("block_velocity", "block_angular_velocity"))
        v.append(u + np.cross(w, p - h.block_position[blocks.index(name)].to_numpy()))
    expected = h.interface_frame[interface].to_numpy() @ (v[1] - v[0])
    assert h.relative_velocity[k].to_numpy() == pytest.approx(
        expected, abs=1e-9 * float(abs(h.relative_velocity).max())
    )


def test_resultants_take_selections(result):
    one = bs.results.interface_resultants(result.history.isel(iteration=3))
    every = result.resultants.isel(iteration=3)
    assert one.force.dims == ("interface", "component")
    assert np.allclose(one.moment, every.moment)
    states = bs.results.contact_state(result.history.isel(iteration=[2, 3]))
    assert states.sizes["iteration"] == 2
    assert states[1].equals(result.states[3])
    assert set(result.utilisation.coords) == {"iteration", "stage", "interface"}


def test_mechanism_is_normalised(result):
    translation = result.mechanism.translation
    assert np.linalg.norm(translation, axis=1).max() == pytest.approx(1.0)
    assert np.allclose(translation.sel(block="base"), 0)
    assert translation.sel(axis="x").sum() > 0


def test_an_uplifted_interface_is_open(tuff, dry):
    blocks = bs.courses([[1], [1]], unit_length="1 m", unit_height="1 m", thickness="1 m", material=tuff)
    model = bs.Model("stack", blocks, bs.detect_interfaces(blocks, joint_material=dry).interfaces)
    lift = bs.LoadPattern("lift", [bs.PointLoad("2.1", ["0.5 m", "0.5 m", "2 m"], ["0 N", "0 N", "1 kN"])])
    result = solve(model, lift, "nonassociative")
    assert result.load_factor == pytest.approx(12.0, rel=1e-6)
    assert result.states.isel(iteration=-1).sel(interface="1.1|2.1") == "open"
    assert result.states.isel(iteration=-1).sel(interface="base|1.1") == "sticking"


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
