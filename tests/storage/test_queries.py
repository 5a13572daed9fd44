"""Questions to histories and analyses: what slides when, what differs, tables in other formats."""

import dataclasses
import importlib.util
import io

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import blockstruct as bs
from blockstruct.files import csv_text
from structures import SELF_WEIGHT, model_of, push, settings_of, single_block

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


def test_a_change_counts_from_the_last_solved_program(history):
    alpha = xr.DataArray([2.0, np.nan, 3.0], dims="iteration", attrs=history.load_factor.attrs)
    failed = history.isel(iteration=[0, 1, 2]).assign(load_factor=alpha)
    np.testing.assert_allclose(failed.blockstruct.convergence()["change"], [np.nan, np.nan, 0.5])


def test_what_fails_and_when_it_first_did(history, small_analysis):
    states = small_analysis[NAME].states
    for state in ("sliding", "open", "hinge", "sticking"):
        first = history.blockstruct.first(state)
        for i in range(history.sizes["iteration"]):
            names = history.blockstruct.interfaces(state, i)
            here = states.isel(iteration=i)
            assert names == [
                n for n, s in zip(here.interface.values, here.values, strict=True) if state in s.split(" + ")
            ]
            assert set(first.index[first == i]) == set(names) - set(first.index[first < i])
    assert history.blockstruct.interfaces("sliding")
    assert history.blockstruct.first("unknown").empty


def test_a_program_that_found_nothing_is_in_the_file(history):
    """Without forces, but not left out: no state is known, and none is hidden."""
    failed = history.copy(deep=True)
    failed["contact_force"][3] = np.nan
    failed["relative_velocity"][3] = np.nan
    assert set(failed.blockstruct.interfaces("unknown", 3)) == set(history.interface.values)
    assert len(failed.blockstruct.first("sliding"))


def test_a_block_that_rocks_never_slides():
    case = bs.LimitCase("rocks", SELF_WEIGHT, push(1, 0, 0), "associative")
    history = bs.AnalysisManager(model_of(*single_block(0.5, 2.0))).run([case])["rocks"].history
    assert history.blockstruct.interfaces("hinge") == ["ground|block"]
    assert history.blockstruct.first("hinge").to_dict() == {"ground|block": 0}
    assert history.blockstruct.interfaces("sliding") == []
    # Closed form: the block stands on the edge it turns about, 0.25 m from its centre, with 0.5·2·20 kN.
    found = history.blockstruct.resultants("ground|block")
    assert found["force"][0, 0].to("kN").magnitude == pytest.approx(20, rel=1e-6)
    assert np.hypot(*found["eccentricity"][0].to("cm").magnitude) == pytest.approx(25, rel=1e-5)
    forces = history.blockstruct.quantity("contact_force", contact_point="ground|block", component="n")
    assert forces.sum().to("kN").magnitude == pytest.approx(20, rel=1e-6)


def test_the_most_used_interfaces():
    """A block on a table tilted to 0.4 of its weight, μ = 0.65: 0.4 / 0.65 of the friction is used before it rocks."""
    case = bs.LimitCase("rocks", SELF_WEIGHT, push(1, 0, 0), "associative")
    history = bs.AnalysisManager(model_of(*single_block(0.4, 1.0))).run([case])["rocks"].history
    assert history.blockstruct.top()["ground|block"] == pytest.approx(0.4 / 0.65, rel=1e-5)


def test_forces_and_resultants_of_an_interface(history, small_analysis):
    name = str(history.interface.values[3])
    index = np.flatnonzero(history.interface_of_contact_point.values == 3)
    forces = history.blockstruct.quantity("contact_force", contact_point=name)
    assert forces.units == bs.units.ureg.newton
    np.testing.assert_array_equal(forces.magnitude, history.contact_force.values[:, index])
    expected = small_analysis[NAME].resultants.isel(interface=3)
    for key, values in history.blockstruct.resultants(name, plain=True).items():
        np.testing.assert_allclose(values, expected[key].values, rtol=1e-12, atol=1e-12)
    assert history.blockstruct.resultants(name)["moment"].units == bs.units.ureg.newton * bs.units.ureg.meter


def test_differences(history, small_analysis):
    none = history.blockstruct.difference(iteration=3, before=3)
    assert all(not none[name].any() for name in none.data_vars)
    step = history.blockstruct.difference(iteration=5, before=4)
    np.testing.assert_array_equal(step.contact_force, history.contact_force[5] - history.contact_force[4])
    assert step.contact_force.attrs["units"] == "newton"
    other = small_analysis["push associative"].history
    between = history.blockstruct.difference(other)
    assert float(between.load_factor) == history.load_factor[-1] - other.load_factor[-1]
    case = bs.LimitCase("rocks", SELF_WEIGHT, push(1, 0, 0), "associative")
    another = bs.AnalysisManager(model_of(*single_block(0.5, 2.0))).run([case])["rocks"].history
    with pytest.raises(bs.errors.ModelError, match="different contact point positions"):
        history.blockstruct.difference(another)
    for no_history in (3, history.load_factor):
        with pytest.raises(bs.errors.ModelError, match=r"is not a history; give result\.history"):
            history.blockstruct.difference(no_history)


def exact(path, columns):
    """Numbers of a file to their last digit, which pandas before 3 rounds."""
    return pd.read_csv(path, dtype=str)[columns].astype(float)


@pytest.mark.parametrize("variable", [None, "contact_force", "state", "moment"])
def test_exports(history, tmp_path, variable):
    path = history.blockstruct.export(tmp_path / "h.csv", variable)
    frame = history.blockstruct.frame(variable)
    found = pd.read_csv(path, index_col=list(range(frame.index.nlevels)))
    assert found.shape == frame.shape
    numbers = found.select_dtypes("number").columns
    np.testing.assert_allclose(exact(path, numbers), frame[numbers].astype(float), rtol=1e-14)


def test_export_to_netcdf(history, tmp_path):
    path = history.blockstruct.export(tmp_path / "h.nc")
    with xr.open_dataset(path, engine="h5netcdf") as found:
        assert found.load().identical(history)


def test_export_to_parquet(history, tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(bs.errors.StorageError, match=r"pip install pyarrow.*\.csv"):
        history.blockstruct.export(tmp_path / "h.parquet")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name)
    written = []
    monkeypatch.setattr(pd.DataFrame, "to_parquet", lambda frame, path: written.append((path, frame)))
    history.blockstruct.export(tmp_path / "h.parquet", "moment")
    assert written[0][1].equals(history.blockstruct.frame("moment"))


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda h: h.interfaces("broken"), "no state 'broken'.*sliding"),
        (lambda h: h.interfaces("open", 1000), "no iteration 1000"),
        (lambda h: h.first("broken"), "no state"),
        (lambda h: h.resultants("x|y"), r"no interface 'x\|y'"),
        (lambda h: h.quantity("colour"), "no variable 'colour'"),
        (lambda h: h.quantity("contact_force", component="z"), "contact_force has no"),
        (lambda h: h.quantity("contact_force", iteration=1000), "contact_force has no"),
        (lambda h: h.frame("colour"), "no variable"),
        (lambda h: h.export("x.xlsx"), r"ends in \.csv"),
        (lambda h: h.export("/proc/x.csv"), "cannot be written"),
        (lambda h: h.export("/proc/x.nc"), "cannot be written"),
    ],
)
def test_bad_questions(history, ask, words):
    with pytest.raises(bs.errors.BlockstructError, match=words):
        ask(history.blockstruct)


def test_two_analyses(small_analysis, small_model, small_cases):
    same = bs.results.compare(small_analysis, small_analysis)
    assert same.agrees(0)
    assert not same.versions
    settings = settings_of(procedure="fictitious", slope=0.2)
    other = bs.AnalysisManager(small_model, settings=settings).run(small_cases[1:])
    found = bs.results.compare(small_analysis, other)
    assert found.same_model
    assert not found.agrees()
    assert found.cases.loc["push associative", "status_other"] == "missing"
    assert found.settings == {NAME: {"procedure": ("loading path", "fictitious"), "schedule_slope": (0.3, 0.2)}}
    row = found.cases.loc[NAME]
    assert not row["same_question"]
    expected = other[NAME].load_factor / small_analysis[NAME].load_factor - 1
    assert row["relative_difference"] == pytest.approx(expected)
    assert "schedule_slope 0.3, other 0.2" in str(found)
    block = model_of(*single_block(0.5, 1.0))
    case = bs.LimitCase(NAME, SELF_WEIGHT, push(0, 0, -1), "associative")
    unbounded = bs.AnalysisManager(block).run([case])
    different = bs.results.compare(small_analysis, unbounded)
    assert not different.same_model
    assert "of forces not comparable, of the mechanism not comparable" in str(different)
    assert bs.results.compare(unbounded, unbounded).agrees(0)


def test_a_stored_analysis_is_reproduced(small_analysis, tmp_path):
    stored = small_analysis.replaced(versions={**small_analysis.versions, "clarabel": "0.0.1"})
    path = bs.save_analysis(stored, tmp_path / "x.h5")
    heard = []
    found = bs.reproduce(bs.open_analysis(path), listeners=[heard.append])
    assert heard
    assert found.agrees(1e-9)
    assert found.cases["force_difference"].max() < 1e-6
    assert found.versions == {"clarabel": ("0.0.1", small_analysis.versions["clarabel"])}
    assert found.cases["same_question"].all()


def test_what_is_not_reproduced_is_told(small_analysis):
    name = "push associative"
    alpha = small_analysis[name].load_factor * 1.01
    wrong = small_analysis[name].changed(outcome=dataclasses.replace(small_analysis[name].outcome, load_factor=alpha))
    found = bs.reproduce(small_analysis.replaced(results={**small_analysis, name: wrong}))
    assert not found.agrees()
    assert found.cases.loc[name, "relative_difference"] == pytest.approx(1 / 1.01 - 1)
    assert found.cases.loc[NAME, "relative_difference"] == 0


def test_no_name_in_a_csv_file_is_a_formula(tmp_path):
    """Spreadsheets run a text that begins with = + - or @; numbers stay numbers, negative ones too."""
    blocks, joint = single_block(0.5, 1.0)
    renamed = [bs.Block(f"{sign}{b.name}", b.shape, b.material, b.fixed) for sign, b in zip("=@", blocks, strict=True)]
    case = bs.LimitCase("rocks", SELF_WEIGHT, push(1, 0, 0), "associative")
    history = bs.AnalysisManager(model_of(renamed, joint)).run([case])["rocks"].history
    read = {}
    for variable in ("state", "block_velocity", "contact_force"):
        path = history.blockstruct.export(tmp_path / f"{variable}.csv", variable)
        read[variable] = pd.read_csv(path)
        frame = history.blockstruct.frame(variable).reset_index()
        numbers = frame.select_dtypes("number")
        assert read[variable][numbers.columns].select_dtypes("number").shape == numbers.shape
        np.testing.assert_array_equal(exact(path, numbers.columns), numbers)
    assert set(read["state"]["interface"]) == {"'=ground|@block"}
    assert set(read["block_velocity"]["block"]) == {"'=ground", "'@block"}
    assert set(read["contact_force"]["interface_of_contact_point"]) == {"'=ground|@block"}
    assert read["contact_force"]["contact_force [newton]"].min() < 0


def test_formulas_of_every_kind_are_texts():
    texts = ["=1+1", "-2", "-x", "+1e-3", "@SUM(A1)", "\tx", "x=1", None]
    frame = pd.DataFrame({"=a": texts, "n": [-1.5] * 8}, index=[f"-{k}+" for k in range(8)])
    back = pd.read_csv(io.StringIO(csv_text(frame)), index_col=0)
    assert back.columns.tolist() == ["'=a", "n"]
    assert back["'=a"].tolist()[:-1] == ["'=1+1", "-2", "'-x", "+1e-3", "'@SUM(A1)", "'\tx", "x=1"]
    assert back["n"].tolist() == [-1.5] * 8
    assert back.index.tolist() == [f"'-{k}+" for k in range(8)]
