"""The history Dataset, the states of its joints, and questions to it: what slides when, what differs, tables."""

import dataclasses
import importlib.util
import io

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import blockstruct as bs
from blockstruct.files import csv_text
from structures import SELF_WEIGHT, model_of, push, settings_of, single_block, solve


@pytest.fixture(scope="module")
def result(small_analysis):
    return small_analysis["push nonassociative"]


def test_every_iteration_is_there_and_the_last_one_is_a_collapse_state(result, small_model):
    """Block by block, from the history alone: weight, push and contact forces sum up to nothing, the push does 1 W."""
    history, last = result.history, result.history.isel(iteration=-1)
    assert history.sizes["iteration"] == len(history.stage) == result.n_iterations
    assert list(history.stage.to_numpy()[[0, 1, -1]]) == ["associative", "loading_path", "admissible"]
    assert history.load_factor[-1] == pytest.approx(result.load_factor, rel=1e-12)
    assert (history.solver_status == "solved").all()
    for name in ("solver_time", "contact_force", "fictitious_cohesion", "fictitious_slope", "block_angular_velocity"):
        assert np.isfinite(history[name]).all(), name
    index = last.interface_of_contact_point.to_numpy()
    force = np.einsum("kc,kca->ka", last.contact_force, last.interface_frame.to_numpy()[index])
    total, names = np.zeros((len(small_model.blocks), 3)), [b.name for b in small_model.blocks]
    for i, interface in enumerate(small_model.interfaces):
        total[names.index(interface.plus)] += force[index == i].sum(axis=0)
        total[names.index(interface.minus)] -= force[index == i].sum(axis=0)
    weight = np.array([0 if b.fixed else b.weight for b in small_model.blocks])
    total[:, 2] -= weight
    total[:, 0] += result.load_factor * weight
    # 10 N act 0.1 m above the centroid of block 3.1: v_x + ω_y · 0.1 m.
    total[names.index("3.1"), 0] += result.load_factor * 10
    assert np.abs(total[weight > 0]).max() < 1e-7 * weight.max()
    at_load = last.sel(block="3.1")
    extra = 10 * float(at_load.block_velocity.sel(axis="x") + 0.1 * at_load.block_angular_velocity.sel(axis="y"))
    assert weight @ last.block_velocity.sel(axis="x").to_numpy() + extra == pytest.approx(1.0, rel=1e-6)
    translation = result.mechanism.translation
    assert np.linalg.norm(translation, axis=1).max() == pytest.approx(1.0)
    assert not translation.sel(block="base").any()


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
    rounding = 1e-9 * float(abs(h.relative_velocity).max())
    assert h.relative_velocity[k].to_numpy() == pytest.approx(expected, abs=rounding)


def test_resultants_take_selections(result):
    one = bs.results.interface_resultants(result.history.isel(iteration=3))
    every = result.resultants.isel(iteration=3)
    assert one.force.dims == ("interface", "component")
    assert np.allclose(one.moment, every.moment)
    states = bs.results.contact_state(result.history.isel(iteration=[2, 3]))
    assert states.sizes["iteration"] == 2
    assert states[1].equals(result.states[3])
    assert set(result.utilisation.coords) == {"iteration", "stage", "interface"}


@pytest.fixture(scope="module")
def sliding():
    return solve(model_of(*single_block(1.0, 0.5)), push(1, 0, 0)).history


@pytest.mark.parametrize("share", [0.0, 0.005, 0.02, 0.1])
def test_a_joint_that_bears_and_slides_is_closed(sliding, share):
    """A solver lifts a block within its tolerance; the weight that the joint carries shows that it does not rise."""
    lifted = sliding.copy(deep=True)
    lifted["relative_velocity"].loc[{"component": "n"}] += share * np.abs(lifted["relative_velocity"]).max()
    assert bs.results.contact_state(lifted.isel(iteration=[-1])).item() == "sliding"


NAME = "push nonassociative"


@pytest.fixture
def history(small_analysis):
    return small_analysis[NAME].history


def test_convergence(history):
    table = history.blockstruct.convergence()
    alpha = history.load_factor.to_numpy()
    assert table["load_factor"].tolist() == alpha.tolist()
    assert np.isnan(table["change"].iloc[0])
    np.testing.assert_allclose(table["change"].iloc[3:], alpha[3:] / alpha[2:-1] - 1)
    assert table["stage"].iloc[0] == "associative"
    # A change counts from the last solved program.
    alpha = xr.DataArray([2.0, np.nan, 3.0], dims="iteration", attrs=history.load_factor.attrs)
    failed = history.isel(iteration=[0, 1, 2]).assign(load_factor=alpha)
    np.testing.assert_allclose(failed.blockstruct.convergence()["change"], [np.nan, np.nan, 0.5])


def test_what_fails_and_when_it_first_did(history, small_analysis):
    states = small_analysis[NAME].states
    for state in ("sliding", "open", "hinge", "sticking"):
        first = history.blockstruct.first(state)
        for i in range(history.sizes["iteration"]):
            names = history.blockstruct.interfaces(state, i)
            here = states.isel(iteration=i).to_series()
            assert names == [n for n, s in here.items() if state in s.split(" + ")]
            assert set(first.index[first == i]) == set(names) - set(first.index[first < i])
    assert history.blockstruct.interfaces("sliding")
    assert history.blockstruct.first("unknown").empty


def test_a_joint_that_carries_nothing_is_open_unless_none_carries_anything(history):
    last = history.isel(iteration=[-1]).copy(deep=True)
    joint = history.blockstruct.interfaces("sticking")[0]
    for unloaded, state in (({"contact_point": joint}, "open"), ({}, "sticking")):
        last["contact_force"].loc[unloaded] = 0.0
        assert bs.results.contact_state(last).sel(interface=joint).item() == state


def test_a_block_that_rocks_never_slides():
    history = solve(model_of(*single_block(0.5, 2.0)), push(1, 0, 0)).history
    assert history.blockstruct.interfaces("hinge") == ["ground|block"]
    assert history.blockstruct.first("hinge").to_dict() == {"ground|block": 0}
    assert history.blockstruct.interfaces("sliding") == []
    # Pushed by 0.25 of its weight it uses 0.25 / 0.65 of the friction.
    assert history.blockstruct.top()["ground|block"] == pytest.approx(0.25 / 0.65, rel=1e-5)
    # Closed form: the block stands on the edge it turns about with 0.5·2·20 kN.
    forces = history.blockstruct.quantity("contact_force", contact_point="ground|block", component="n")
    assert forces.sum().to("kN").magnitude == pytest.approx(20, rel=1e-6)


def test_forces_and_resultants_of_an_interface(history, small_analysis):
    name = str(history.interface.values[3])
    index = np.flatnonzero(history.interface_of_contact_point.values == 3)
    forces = history.blockstruct.quantity("contact_force", contact_point=name)
    assert forces.units == bs.units.ureg.newton
    np.testing.assert_array_equal(forces.magnitude, history.contact_force.values[:, index])
    expected = small_analysis[NAME].resultants.isel(interface=3)
    for key, values in history.blockstruct.resultants(name).items():
        np.testing.assert_allclose(values.magnitude, expected[key].values, rtol=1e-12, atol=1e-12)
    assert history.blockstruct.resultants(name)["moment"].units == bs.units.ureg.newton * bs.units.ureg.meter


@pytest.mark.parametrize("variable", [None, "contact_force", "state", "moment"])
def test_exports(history, tmp_path, variable):
    path = history.blockstruct.export(tmp_path / "h.csv", variable)
    frame = history.blockstruct.frame(variable)
    found = pd.read_csv(path, index_col=list(range(frame.index.nlevels)))
    assert found.shape == frame.shape
    numbers = found.select_dtypes("number").columns
    # As texts: pandas before 3 rounds the last digit.
    exact = pd.read_csv(path, dtype=str)[numbers].astype(float)
    np.testing.assert_allclose(exact, frame[numbers].astype(float), rtol=1e-14)
    with xr.open_dataset(history.blockstruct.export(tmp_path / "h.nc"), engine="h5netcdf") as again:
        assert again.load().identical(history)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda h: h.interfaces("broken"), "no state 'broken'.*sliding"),
        (lambda h: h.interfaces("open", 1000), "no iteration 1000"),
        (lambda h: h.resultants("x|y"), r"no interface 'x\|y'"),
        (lambda h: h.quantity("colour"), "no variable 'colour'"),
        (lambda h: h.quantity("contact_force", component="z"), "contact_force has no"),
        (lambda h: h.export("x.xlsx"), r"ends in \.csv"),
        (lambda h: h.export("/proc/x.csv"), "cannot be written"),
    ],
)
def test_bad_questions(history, ask, words):
    with pytest.raises(bs.errors.BlockstructError, match=words):
        ask(history.blockstruct)


def test_two_analyses(small_analysis, small_model, small_cases):
    same = bs.results.compare(small_analysis, small_analysis)
    assert (same.agrees(0), same.versions) == (True, {})
    settings = settings_of(procedure="fictitious", slope=0.2)
    other = bs.AnalysisManager(small_model, settings=settings).run(small_cases[1:])
    found = bs.results.compare(small_analysis, other)
    assert (found.same_model, found.agrees()) == (True, False)
    assert found.cases.loc["push associative", "status_other"] == "missing"
    assert found.settings == {NAME: {"procedure": ("loading path", "fictitious"), "schedule_slope": (0.3, 0.2)}}
    row = found.cases.loc[NAME]
    assert not row["same_question"]
    expected = other[NAME].load_factor / small_analysis[NAME].load_factor - 1
    assert row["relative_difference"] == pytest.approx(expected)
    assert "schedule_slope 0.3, other 0.2" in str(found)
    case = bs.LimitCase(NAME, SELF_WEIGHT, push(0, 0, -1), "associative")
    unbounded = bs.run(model_of(*single_block(0.5, 1.0)), case)
    different = bs.results.compare(small_analysis, unbounded)
    assert not different.same_model
    assert "of forces not comparable, of the mechanism not comparable" in str(different)
    assert bs.results.compare(unbounded, unbounded).agrees(0)


def test_what_is_not_reproduced_is_told(small_analysis):
    name = "push associative"
    alpha = small_analysis[name].load_factor * 1.01
    wrong = small_analysis[name].changed(outcome=dataclasses.replace(small_analysis[name].outcome, load_factor=alpha))
    stored = small_analysis.replaced(results={**small_analysis, name: wrong}, versions={"clarabel": "0.0.1"})
    found = bs.reproduce(stored)
    assert not found.agrees()
    assert found.cases.loc[name, "relative_difference"] == pytest.approx(1 / 1.01 - 1)
    assert found.cases.loc[NAME, ["relative_difference", "same_question"]].tolist() == [0, True]
    assert found.cases["force_difference"].max() < 1e-6
    assert found.versions["clarabel"] == ("0.0.1", small_analysis.versions["clarabel"])


def test_no_name_in_a_csv_file_is_a_formula(tmp_path):
    """Spreadsheets run a text that begins with = + - or @."""
    blocks, joint = single_block(0.5, 1.0)
    renamed = [bs.Block(f"{sign}{b.name}", b.shape, b.material, b.fixed) for sign, b in zip("=@", blocks, strict=True)]
    history = solve(model_of(renamed, joint), push(1, 0, 0)).history
    path = history.blockstruct.export(tmp_path / "h.csv", "contact_force")
    assert set(pd.read_csv(path)["interface_of_contact_point"]) == {"'=ground|@block"}
    texts = ["=1+1", "-2", "-x", "+1e-3", "@SUM(A1)", "\tx", "x=1", None]
    frame = pd.DataFrame({"=a": texts, "n": [-1.5] * 8}, index=[f"-{k}+" for k in range(8)])
    back = pd.read_csv(io.StringIO(csv_text(frame)), index_col=0)
    assert back.columns.tolist() == ["'=a", "n"]
    assert back["'=a"].tolist()[:-1] == ["'=1+1", "-2", "'-x", "+1e-3", "'@SUM(A1)", "'\tx", "x=1"]
    assert back["n"].tolist() == [-1.5] * 8
    assert back.index.tolist() == [f"'-{k}+" for k in range(8)]


def test_export_to_parquet(history, tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(bs.errors.StorageError, match=r"pip install pyarrow.*\.csv"):
        history.blockstruct.export(tmp_path / "h.parquet")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name)
    written = []
    monkeypatch.setattr(pd.DataFrame, "to_parquet", lambda frame, path: written.append((path, frame)))
    history.blockstruct.export(tmp_path / "h.parquet", "moment")
    assert written[0][1].equals(history.blockstruct.frame("moment"))
