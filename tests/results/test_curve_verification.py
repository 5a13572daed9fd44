"""What a stored capacity curve or reaction says is recomputed: a change of one hundredth is found and named."""

import re
from dataclasses import replace

import numpy as np
import pytest

import blockstruct as bs
from structures import SELF_WEIGHT, beam_on_ledges, block_on_a_bar, edited, push, slipping_units


@pytest.fixture(scope="module")
def tied():
    """A block on a bar that yields and breaks, and turns over."""
    model = block_on_a_bar()
    return bs.run(model, bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=6))


@pytest.fixture(scope="module")
def wall():
    """Ten units with rounded corners, which slip and rock."""
    model = slipping_units()
    control = (model.blocks[-1].name, (1, 0, 0))
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=control, steps=6, corner_rounding="5 mm")
    return bs.run(model, case)


@pytest.fixture(scope="module")
def stored(tied, wall, tmp_path_factory):
    """Files of them, and of a block with the report of its detection, of which tests change copies."""
    blocks, joint = tied.model.blocks, tied.model.interfaces[0].joint_material
    detected = bs.Model("detected", blocks, bs.detect_interfaces(blocks, joint_material=joint))
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))
    analyses = {"tied": tied, "wall": wall, "detected": bs.run(detected, case)}
    folder = tmp_path_factory.mktemp("stored")
    return {name: bs.save_analysis(analysis, folder / f"{name}.h5") for name, analysis in analyses.items()}


def changed(analysis, name, at, by=1.01):
    """An analysis whose curve has one value times a factor."""
    curve = analysis["push"].capacity.copy(deep=True)
    values = curve[name].to_numpy().copy()
    values[at] *= by
    stored = curve[name].dims, values, curve[name].attrs
    curve = curve.assign_coords({name: stored}) if name in curve.coords else curve.assign({name: stored})
    return analysis.replaced(results={"push": replace(analysis["push"], capacity=curve)})


def largest(analysis, name, state):
    """Where the largest value of a state is."""
    curve = analysis["push"].capacity
    values = np.abs(curve[name].to_numpy())
    if "contact" in curve[name].dims:
        values = np.where((curve["step_of_contact"] == state).to_numpy()[:, None], values, -1.0)
    else:
        values = np.where((np.arange(len(values)) == state).reshape(-1, *[1] * (values.ndim - 1)), values, -1.0)
    return np.unravel_index(values.argmax(), values.shape)


LIES = {
    "load_factor": "equilibrium residual",
    "displacement": "displacement is",
    "position": "off the way that the motion before leads",
    "rotation": "off the way that the motion before leads",
    "velocity": "W of variable load",
    "angular_velocity": "off the way that the motion before leads",
    "force_of_contact": "equilibrium residual",
    "normal_of_contact": "the normal of one of its contacts",
    "dissipation": "dissipation is",
    "tie_force": "equilibrium residual",
    "tie_elongation": "tie elongation is",
}


@pytest.mark.parametrize("name", LIES)
def test_one_hundredth_is_found(tied, wall, name):
    # The bar has not broken yet; units that slide hardly turn.
    alone = name.startswith("tie_") or name in ("rotation", "angular_velocity")
    for analysis, state in ((tied, 13),) if alone else ((tied, 13), (wall, 13)):
        found = [what for _, what in bs.results.contradictions(changed(analysis, name, largest(analysis, name, state)))]
        at = state + 1 if name == "angular_velocity" else state
        words = LIES[name]
        assert any(what.startswith(f"state {at} ") and words in what for what in found), found


@pytest.mark.parametrize(
    ("name", "state", "by", "words"),
    [
        ("position", 0, 1.01, "off its place in the model"),
        ("load_factor", 4, 0.9, "equilibrium residual"),
        ("energy_error", 3, 2.0, "energy error"),
        ("equilibrium_residual", 2, np.nan, "equilibrium residual is nan"),
    ],
)
def test_other_lies(wall, name, state, by, words):
    found = bs.results.contradictions(changed(wall, name, largest(wall, name, state), by))
    assert any(what.startswith(f"state {state} ") and words in what for _, what in found), found


def test_forces_beyond_friction_are_found(wall):
    """And joints that are pulled."""
    curve = wall["push"].capacity.copy(deep=True)
    curve["force_of_contact"][0] *= -1
    found = bs.results.contradictions(wall.replaced(results={"push": replace(wall["push"], capacity=curve)}))
    assert any("yield excess is" in what for _, what in found)


@pytest.mark.parametrize("structure", ["tied", "wall", "detected"])
def test_validate_accepts_honest_results(stored, done, structure):
    done("validate", stored[structure])


def test_a_curve_without_its_pushover_is_refused(stored, tmp_path, call):
    path = tmp_path / "x.h5"
    with edited(stored["tied"], path) as file:
        del file["cases/push"].attrs["pushover"]
    with pytest.raises(bs.errors.FormatError, match="there is a capacity curve, but no attribute pushover"):
        bs.open_analysis(path)
    with edited(stored["wall"], path) as file:
        file["cases/push/capacity/load_factor"][3] *= 1.01
    code, out, _ = call("validate", path)
    assert (code, "case 'push': state 3 of the capacity curve: its" in out) == (4, True)


def test_validate_finds_another_reaction(tmp_path, call, done):
    path = tmp_path / "beam.h5"
    bs.run(beam_on_ledges(), bs.SettlementCase("down", SELF_WEIGHT, "left", "-z"), path)
    done("validate", path)
    for place, words in (
        ("cases/down/reaction", "/cases/down/reaction: the reaction is"),
        ("cases/down/history/reaction", "case 'down': the reaction of iteration"),
    ):
        with edited(path, tmp_path / "other.h5") as file:
            reaction = file[place]
            reaction[-1 if reaction.shape else ()] *= 1.01
        code, out, _ = call("validate", tmp_path / "other.h5")
        assert (code, words in out) == (4, True)


REDUNDANT = [
    ("detected", "model/floating", 0, 1, "/model/floating: that of '.*' is 1, and 0 by the rest"),
    ("detected", "model/plus_of_contact", 1, 1, "that of contact 1 of .ground. and .post. is .ground.block."),
    ("detected", "model/area_of_contact", 0, -1.0, "/model/area_of_contact: there is a negative number"),
    ("detected", "model/volume", 1, 99.0, "/model/volume: that of .* is 99, and .* by the rest"),
    ("detected", "model/centroid", 1, np.nan, "/model/centroid: that of .* is nan, and .* by the rest"),
    ("detected", "model/area", 0, 99.0, "/model/area: that of .* is 99, and .* by the rest"),
    ("wall", "cases/push/history/iteration", -1, 0, "/history/iteration: the numbers are not 0, 1, …"),
    ("wall", "cases/push/history/load_factor", 1, 9.0, "iteration 1 miss equilibrium by"),
    ("wall", "cases/push/history/interface_corner_position", (0, 0), 50.0, "interface_corner_position of the history"),
    ("wall", "cases/push/capacity/holds", 2, 0, "state 2 of the .*: its certificate does not hold, by its forces"),
    ("wall", "cases/push/capacity/flow_rule_gap", 2, 9.0, "state 2 .*: its (flow rule gap|interpenetration) is"),
    ("wall", "cases/push/capacity/flow_rule_gap", -1, np.nan, "state .*: its flow rule gap is nan"),
    ("wall", "cases/push/capacity/falls", 1, -1, "/capacity/falls: there is other than 0 and 1"),
    ("wall", "cases/push/capacity/interpenetration", 2, 0.2, "state 2 .*: its (flow rule gap|interpenetration) is"),
    ("tied", "cases/push/capacity/tie_elongation_limit", 0, 3.0, "tie_elongation_limit of tie 'bar' .* is 3 m"),
    ("tied", "cases/push/capacity/tie_break_displacement", 0, 5.0, "tie_break_displacement of tie 'bar' .* is 5 m"),
]  # fmt: skip


@pytest.mark.parametrize(("structure", "place", "at", "value", "words"), REDUNDANT, ids=[row[1] for row in REDUNDANT])
def test_validate_compares_derived_variables(stored, tmp_path, call, structure, place, at, value, words):
    with edited(stored[structure], tmp_path / "x.h5") as file:
        assert not np.array_equal(file[place][at], value)
        file[place][at] = value
    code, out, _ = call("validate", tmp_path / "x.h5")
    assert code == 4
    assert re.search(words, out), out
