"""Studies in Python and as documents."""

import contextlib
import functools
import json
import re
import shutil
import warnings

import numpy as np
import pytest
import yaml
from scipy import stats

import blockstruct as bs
import studied
from blockstruct import Q_, studies
from blockstruct.analysis import IterationDone
from blockstruct.storage.run_folder import writer_lock
from structures import PIER, SELF_WEIGHT, model_of, push, single_block, stopping

MU = {"friction_coefficient": [0.3, 0.4, 0.6]}


def load_factors(data):
    return data.load_factor.sel(case="push").to_numpy().round(6).tolist()


def test_a_grid_of_the_contract(tmp_path):
    """Sliding at μ, rocking at b / h: α = min(μ, b / h)."""
    parameters = {"friction_coefficient": [0.3, 0.4, 0.6, 1.2], "height": Q_([100, 50], "cm")}
    data = bs.study(studied.block, parameters, store=tmp_path, workers=1)
    assert data.load_factor.dims == ("friction_coefficient", "height", "case")
    expected = np.minimum.outer([0.3, 0.4, 0.6, 1.2], [0.5, 1.0])
    np.testing.assert_allclose(data.load_factor.sel(case="push"), expected, rtol=1e-6)
    np.testing.assert_allclose(data.bound, data.load_factor, rtol=1e-9)
    assert data.height.to_numpy().tolist() == [100, 50]
    units = [data[name].attrs["units"] for name in ("height", "load_factor", "duration")]
    assert units == ["centimeter", "dimensionless", "second"]
    assert set(data.status.to_numpy().ravel()) == {"converged"}
    assert set(data.problem.to_numpy().ravel()) == {""}
    first = bs.open_analysis(tmp_path / data.path.to_numpy()[0, 1])
    assert first.parameters == {"friction_coefficient": 0.3, "height": Q_(50, "cm")}


def test_runs_are_rows_of_an_archive_with_their_parameters(tmp_path):
    bs.study(studied.block, {"friction_coefficient": [0.3, 0.4], "height": Q_(80, "cm")}, tmp_path, workers=1)
    table = bs.Archive(tmp_path).table()
    assert table["parameter_friction_coefficient"].tolist() == [0.3, 0.4]
    assert table["parameter_height"].tolist() == [0.8, 0.8]
    assert table.attrs["units"]["parameter_height"] == "meter"
    assert "joint_friction_coefficient" not in table
    whole = bs.Archive(tmp_path).table(all_columns=True)
    assert whole["joint_friction_coefficient"].tolist() == [0.3, 0.4]
    assert whole["study"].eq("build block").all()
    low = bs.Archive(tmp_path).select("parameter_friction_coefficient < 0.35 and joint_cohesion == 0")
    assert low["load_factor"].tolist() == pytest.approx([0.3], rel=1e-6)


def test_pushovers_have_where_they_end(tmp_path):
    """A block on edge: zero when its centroid is over the edge, half of its width further."""

    def build(width):
        case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=6)
        return model_of(*single_block(width, 1.5, mu=2.0)), case

    data = bs.study(build, {"width": [0.3, 0.4]}, tmp_path, workers=1)
    assert data.d0.sel(case="push").to_numpy() == pytest.approx([0.15, 0.2], rel=1e-4)
    assert data.curve_end.attrs["units"] == data.d0.attrs["units"] == "meter"
    assert bs.studies.frame_of(data)["d0"].tolist() == data.d0.to_numpy().ravel().tolist()
    assert "d0" not in bs.study(studied.block, MU, workers=1)


def test_finished_runs_are_not_repeated(tmp_path):
    """By a build of another source, too, if it still makes the same models."""
    built, seen = [], []

    def build(friction_coefficient):
        built.append(friction_coefficient)
        return studied.block(friction_coefficient)

    bs.study(studied.block, MU, tmp_path, workers=1)
    before = {p: p.stat().st_mtime_ns for p in tmp_path.glob("*.h5")}
    more = {"friction_coefficient": [0.3, 0.4, 0.6, 0.45]}
    data = bs.study(build, more, tmp_path, workers=1, listeners=[seen.append])
    assert load_factors(data) == [0.3, 0.4, 0.5, 0.45]
    # Those found are built, to see what build makes.
    assert built == [0.3, 0.4, 0.6, 0.45]
    assert all(p.stat().st_mtime_ns == time for p, time in before.items())
    assert (seen[0].done, seen[0].found, seen[-1].done, seen[-1].total) == (3, 3, 4, 4)


@pytest.mark.parametrize("change", ["build", "settings", "what it calls"])
def test_runs_of_another_study_are_not_taken_over(tmp_path, monkeypatch, change):
    calls = functools.partial(studied.failing, height=Q_(1, "m"))
    build = calls if change == "what it calls" else studied.block
    parameters = {"friction_coefficient": [0.3, 0.6]}
    bs.study(build, parameters, tmp_path, workers=1)
    changed, options = (functools.partial(studied.block, height=Q_(2, "m")) if change == "build" else build), {}
    if change == "settings":
        options = {"settings": bs.ProcedureSettings(schedule=bs.FictitiousSchedule(slope=0.2))}
    elif change == "what it calls":
        same = studied.block
        monkeypatch.setattr(studied, "block", lambda mu, height: same(mu, Q_(2, "m")))
    with pytest.raises(bs.errors.StorageError, match=r"2 runs of these parameters.*rerun=True"):
        bs.study(changed, parameters, tmp_path, workers=1, **options)
    data = bs.study(changed, parameters, tmp_path, workers=1, rerun=True, **options)
    assert load_factors(data) == ([0.3, 0.5] if change == "settings" else [0.25, 0.25])
    assert load_factors(bs.study(changed, parameters, tmp_path, workers=1, **options)) == load_factors(data)


def test_files_under_the_names_of_other_runs_are_refused(tmp_path):
    parameters = {"friction_coefficient": [0.1, 0.2, 0.3, 0.4], "height": Q_(90, "cm")}
    path = bs.study(studied.block, parameters, tmp_path, workers=1).path.to_numpy()
    shutil.copy(tmp_path / path[2], tmp_path / path[1])
    said = rf"{path[1]} was made with friction_coefficient 0\.3, but its name stands for 0\.2.*own name.*rerun=True"
    with pytest.raises(bs.errors.StorageError, match=said):
        bs.study(studied.block, parameters, tmp_path, workers=1)
    data = bs.study(studied.block, parameters, tmp_path, workers=1, rerun=True)
    assert load_factors(data) == [0.1, 0.2, 0.3, 0.4]


def cut(build, path, values, error=KeyboardInterrupt):
    """Replace a run of a study by one of other values that ended after an iteration."""
    whose = bs.open_analysis(path).study
    path.unlink()
    model, case = build(**values)
    stop = stopping(IterationDone, error=error)
    manager = bs.AnalysisManager(model, path, parameters=values, study=whose, listeners=[stop])
    with contextlib.suppress(SystemExit):
        manager.run([case])


def test_failures_are_rows(tmp_path):
    with pytest.warns(bs.errors.StudyWarning, match=r"1 of 3 runs failed.*ValueError: no such stone"):
        data = bs.study(studied.failing, MU, tmp_path, workers=1)
    assert data.problem.to_numpy().tolist() == ["", "ValueError: no such stone", ""]
    assert data.status.sel(case="push").to_numpy().tolist() == ["converged", "failed", "converged"]
    assert load_factors(data)[::2] == [0.3, 0.5]
    assert np.isnan(load_factors(data)[1])
    assert len(list(tmp_path.glob("*.h5"))) == 2


@pytest.mark.filterwarnings("ignore::blockstruct.errors.StudyWarning")
@pytest.mark.parametrize(("sampling", "heights"), [("grid", [1, 2, 1, 2]), ("paired", [1, 2])])
def test_a_table_of_failures_alone(sampling, heights):
    parameters = {"friction_coefficient": Q_([1, 2], "kPa"), "height": Q_([1, 2], "m")}
    data = bs.study(studied.block, parameters, workers=1, sampling=sampling)
    table = studies.frame_of(data)
    assert set(table["status"]) == {"failed"}
    assert table["problem"].str.contains("a plain number").all()
    assert table["height"].tolist() == heights
    if sampling == "paired":
        with pytest.raises(bs.errors.ModelError, match=r"all 2 runs failed, the first one: DimensionError.*again"):
            studies.summary(data)


def test_a_killed_run_is_gone_on_with(tmp_path):
    """What a study leaves that is killed: its next call resumes the run in flight."""
    values, seen = {"friction_coefficient": 0.3, "height": Q_(1, "m")}, []
    path = tmp_path / bs.study(studied.block, values, tmp_path, workers=1).path.item()
    cut(studied.block, path, values, SystemExit)
    again = bs.study(studied.block, values, tmp_path, workers=1, listeners=[seen.append])
    assert again.load_factor.to_numpy().ravel() == pytest.approx([0.3], rel=1e-6)
    assert seen[0].found == 0
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("error", [SystemExit, KeyboardInterrupt], ids=["killed", "interrupted"])
def test_a_run_that_began_with_another_model_is_not_gone_on_with(tmp_path, monkeypatch, error):
    """What build calls has changed since, and its own source has not: h of 1 m becomes 2 m, α = b / h."""
    build = functools.partial(studied.failing, height=Q_(1, "m"))
    values = {"friction_coefficient": [0.6]}
    path = tmp_path / bs.study(build, values, tmp_path, workers=1).path.item()
    cut(build, path, {"friction_coefficient": 0.6}, error)
    same = studied.block
    monkeypatch.setattr(studied, "block", lambda mu, height: same(mu, Q_(2, "m")))
    with pytest.raises(bs.errors.StorageError, match=r"1 run of these parameters.*another model.*rerun=True"):
        bs.study(build, values, tmp_path, workers=1)
    data = bs.study(build, values, tmp_path, workers=1, rerun=True)
    assert load_factors(data) == [0.25]


def test_a_run_counts_as_found_once_its_file_is_in_place(tmp_path, monkeypatch):
    """Its process was killed, or is about to remove the working data, and still holds the lock."""

    def kill(folder):
        raise SystemExit

    values, seen = {"friction_coefficient": 0.3, "height": Q_(1, "m")}, []
    path = tmp_path / bs.study(studied.block, values, tmp_path, workers=1).path.item()
    cut(studied.block, path, values, SystemExit)
    with monkeypatch.context() as patch, contextlib.suppress(SystemExit):
        patch.setattr("blockstruct.storage.run_folder.clear", kill)
        bs.study(studied.block, values, tmp_path, workers=1)
    assert (tmp_path / f"{path.name}.partial" / "plan").is_file()
    assert not bs.storage.is_unfinished(path)
    with writer_lock(path):
        bs.study(studied.block, values, tmp_path, workers=1, listeners=[seen.append])
    assert (seen[0].found, seen[0].total) == (1, 1)
    assert bs.AnalysisManager.resume(path).status == "finished"
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_samples_follow_from_their_seed():
    parameters = {"friction_coefficient": stats.uniform(0.2, 0.2), "height": Q_(stats.norm(80, 2), "cm")}
    sizes = (3, 7), (5, 7), (3, 8)
    few, more, other = (bs.study(studied.block, parameters, runs=n, seed=seed, workers=1) for n, seed in sizes)
    np.testing.assert_array_equal(few.height, more.height[:3])
    assert not np.array_equal(few.height, other.height)
    assert few.height.attrs["units"] == "centimeter"
    assert (few.attrs["sampling"], few.attrs["seed"]) == ("monte carlo", 7)
    np.testing.assert_allclose(few.load_factor.sel(case="push"), few.friction_coefficient, rtol=1e-6)


def test_designs_of_lists_and_distributions():
    """Lists side by side, None as NaN, and a sample in every layer of a Latin hypercube."""
    parameters = {"friction_coefficient": [0.3, 1.2], "height": ["1 m", "0.5 m"]}
    data = bs.study(studied.block, parameters, sampling="paired", workers=1)
    assert (data.load_factor.dims, load_factors(data)) == (("run", "case"), [0.3, 1.0])
    assert (data.friction_coefficient.dims, data.height.to_numpy().tolist()) == (("run",), ["1 m", "0.5 m"])
    design = studies.design.design_of({"strength": [None, Q_(200, "kPa")]}, None, None, seed=0)
    np.testing.assert_array_equal(design.axes["strength"].coordinate, [np.nan, 200])
    design = studies.design.design_of({"a": stats.uniform(), "b": stats.uniform(10, 1)}, "latin hypercube", 20, seed=0)
    for name, low in (("a", 0), ("b", 10)):
        assert sorted(np.floor((design.axes[name].coordinate - low) * 20)) == list(range(20))


def test_equal_samples_are_run_once(tmp_path):
    seen = []
    values = {"friction_coefficient": 0.3, "courses": stats.randint(1, 3)}

    def build(friction_coefficient, courses):
        return studied.block(friction_coefficient, Q_(courses, "m"))

    data = bs.study(build, values, tmp_path, runs=6, seed=1, workers=1, listeners=[seen.append])
    assert len(list(tmp_path.glob("*.h5"))) == 2
    assert load_factors(data) == [min(0.3, 0.5 / courses) for courses in data.courses.to_numpy()]
    assert (seen[-1].done, seen[-1].total) == (2, 2)


@pytest.mark.parametrize(
    ("parameters", "options", "said"),
    [
        ({}, {}, "give a mapping of names to values"),
        ({"friction_coefficient": []}, {}, "friction_coefficient has no value"),
        ({"friction_coeficient": [0.3]}, {}, "takes friction_coefficient, .* the study gives friction_coeficient"),
        ({"height": Q_([1], "m")}, {}, "missing a required argument: 'friction_coefficient'"),
        ({"friction_coefficient": [0.3], "height": [Q_(1, "m"), Q_(1, "kg")]}, {}, "values of one dimension"),
        ({"friction_coefficient": [0.3, Q_(1, "m")]}, {}, "mixes a number and a quantity"),
        ({"friction_coefficient": [object()]}, {}, "is not a parameter"),
        ({"friction_coefficient": [np.nan]}, {}, "not finite"),
        ({"friction_coefficient": stats.norm(0.6, 0.1)}, {}, "runs=None; give the number of samples"),
        ({"friction_coefficient": stats.norm(0.6, -1)}, {"runs": 3}, "its distribution gives nan"),
        ({"friction_coefficient": stats.norm(0.6, 0.1), "height": Q_([1, 2], "m")}, {"runs": 3}, "height is a list"),
        ({"friction_coefficient": [0.3]}, {"runs": 3}, "lists have as many runs as values"),
        ({"friction_coefficient": stats.norm()}, {"sampling": "grid", "runs": 2}, "'monte carlo' or 'latin"),
        ({"friction_coefficient": [0.3, 0.4], "height": Q_([1], "m")}, {"sampling": "paired"}, "different lengths"),
        ({"friction_coefficient": stats.norm()}, {"runs": 2, "seed": "x"}, "seed is 'x'"),
        ({"friction_coefficient": [0.3]}, {"settings": "fast"}, "settings are 'fast'"),
        ({"friction_coefficient": np.linspace(0, 1, 1001), "height": Q_(np.arange(1.0, 1001), "m")}, {}, "1,001,000"),
    ],
)
def test_bad_studies_are_refused_before_they_begin(tmp_path, parameters, options, said):
    with pytest.raises(bs.errors.BlockstructError, match=said):
        bs.study(studied.block, parameters, tmp_path / "store", **options)
    assert not (tmp_path / "store").exists()


def test_bad_stores_and_what_build_returns_are_told(tmp_path):
    with pytest.warns(bs.errors.StudyWarning, match=r"returned 3; return a Model and its cases"):
        bs.study(lambda mu: 3, {"mu": [1]}, workers=1)
    (tmp_path / "file").write_text("x")
    with pytest.raises(bs.errors.StorageError, match="is not a folder to write to"):
        bs.study(studied.block, MU, tmp_path / "file", workers=1)


def test_names_of_what_a_study_gives_are_no_parameters():
    def build(friction_coefficient, **more):
        raise AssertionError(more)

    data = bs.study(studied.pulled, {"friction_coefficient": [0.3, 0.4]}, workers=1, sampling="paired")
    for name in {*map(str, data.variables)} - {"friction_coefficient"} | {"run", "d0"}:
        with pytest.raises(bs.errors.ModelError, match=rf"parameter {name}: "):
            bs.study(build, {"friction_coefficient": [0.3, 0.4], name: [1, 2]}, workers=1)


def test_a_damaged_run_is_told(tmp_path):
    data = bs.study(studied.block, MU, tmp_path, workers=1)
    (tmp_path / data.path.to_numpy()[0]).write_bytes(b"damaged")
    with pytest.raises(bs.errors.StorageError, match=r".*move it away"):
        bs.study(studied.block, MU, tmp_path, workers=1)


def test_several_cases_and_the_loss_of_a_bound(tmp_path):
    def build(mu):
        model, case = studied.block(mu)
        press = bs.LoadPattern("press", [bs.BodyForce("-z")])
        lift = bs.LimitCase("down", SELF_WEIGHT, press, "associative")
        return model, [case, lift] if mu < 0.5 else [case]

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = bs.study(build, {"mu": [0.3, 0.6]}, tmp_path, workers=1)
    assert data.case.to_numpy().tolist() == ["push", "down"]
    assert data.status.sel(case="down").to_numpy().tolist() == ["unbounded", ""]
    assert data.bound.sel(case="down", mu=0.3) == np.inf
    assert np.isnan(data.load_factor.sel(case="down", mu=0.6))


def test_a_study_tells_how_it_goes_on_and_not_how_each_run_does(capsys, monkeypatch):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    bs.study(studied.block, {"friction_coefficient": [0.2, 0.3]}, workers=1)
    said = "".join(capsys.readouterr())
    assert "2 of 2 runs" in said
    assert "numerical iteration" not in said


def test_a_run_of_another_study_is_elsewhere_and_has_not_failed(tmp_path):
    """Of three runs, another process is carrying out the second."""
    seen = []
    path = tmp_path / str(bs.study(studied.block, {"friction_coefficient": [0.4]}, tmp_path, workers=1).path.item())
    path.unlink()
    with writer_lock(path), pytest.warns(bs.errors.StudyWarning, match="another study is carrying out 1 of 3 runs"):
        data = bs.study(studied.block, MU, tmp_path, workers=1, listeners=[seen.append])
    assert data.elsewhere.to_numpy().tolist() == [False, True, False]
    assert data.status.sel(case="push").to_numpy().tolist() == ["converged", "elsewhere", "converged"]
    assert (seen[-1].done, seen[-1].failed) == (3, 0)
    assert studies.frame_of(data)["status"].tolist() == ["converged", "elsewhere", "converged"]
    assert load_factors(bs.study(studied.block, MU, tmp_path, workers=1)) == [0.3, 0.4, 0.5]


#: Dots in names do not end them.
MODEL = PIER.replace("lime", "lime 1.5").replace("name: pier", 'name: "b.1"')
FRICTION, HEIGHT = "joint_materials.lime 1.5.friction_coefficient", "blocks.b.1.box.size.2"


def normal(mean, deviation):
    return {"distribution": "normal", "mean": mean, "standard_deviation": deviation}


def uniform(low, high):
    return {"distribution": "uniform", "low": low, "high": high}


@pytest.fixture
def document(tmp_path):
    """Writer of a study document beside its model."""
    (tmp_path / "wall.yaml").write_text(MODEL)

    def write(parameters, **more):
        path = tmp_path / "study.yaml"
        content = {"blockstruct": "study-1", "model": "wall.yaml", "parameters": parameters, **more}
        path.write_text(yaml.safe_dump(content, sort_keys=False))
        return path

    return write


def test_a_grid_of_a_document(document, call, tmp_path):
    path = document({FRICTION: [0.3, 0.7], HEIGHT: ["50 cm", "1 m"]})
    _, out, err = call("study", path, "--output", tmp_path / "runs", "--workers", "1")
    assert "4 of 4 runs" in err
    table = bs.Archive(tmp_path / "runs").table().sort_values("path")
    found = table.set_index([f"parameter_{FRICTION}", f"parameter_{HEIGHT}"])["load_factor"]
    for (mu, height), alpha in found.items():
        assert alpha == pytest.approx(min(mu, 0.5 / height), rel=1e-6)
    assert "0.7" in out
    code, out, err = call("study", path, "--output", tmp_path / "runs", "--workers", "1", "--json")
    assert (code, "4 of them found" in err) == (0, True)
    found, rows = json.loads(out)["units"], json.loads(out)["rows"]
    assert (found[FRICTION], found[HEIGHT], rows[0][HEIGHT]) == ("dimensionless", "centimeter", 50)
    assert rows[1]["load_factor"] == pytest.approx(0.3, rel=1e-6)
    low, short = (re.sub(r"\W", "_", f"parameter_{name}") for name in (FRICTION, HEIGHT))
    code, out, err = call("archive", tmp_path / "runs", "--where", f"{low} < 0.4 and {short} in [0.5]")
    assert (code, out.count("run-")) == (0, 1), err
    call("study", path, "--output", tmp_path / "runs", "--workers", "1", "--csv", tmp_path / "rows.csv")
    assert len((tmp_path / "rows.csv").read_text().splitlines()) == 5


def test_samples_of_a_document(document, done, tmp_path):
    path = document({FRICTION: uniform(0.2, 0.4)}, runs=3, seed=2)
    out = done("study", path, "-o", tmp_path / "runs", "--workers", "1")
    assert "confidence" in out
    read = bs.studies.read_study(path)
    data = bs.study(read.build, read.parameters, tmp_path / "runs", workers=1, settings=read.settings, **read.options)
    np.testing.assert_allclose(data.load_factor.sel(case="push"), data[FRICTION], rtol=1e-6)


def test_settlements_of_a_document_print_their_reactions(document, done, tmp_path):
    """A reaction has no fractile of load factors."""
    path = document({HEIGHT: uniform("1 m", "1.2 m")}, runs=2)
    settlement = "{kind: settlement, name: sinks, dead: dead, supports: [base], direction: -z}"
    (tmp_path / "wall.yaml").write_text(f"{MODEL.split('cases:')[0]}cases: [{settlement}]\n")
    out = done("study", path, "-o", tmp_path / "runs", "--workers", "1")
    assert re.search(r"sinks +[\d.]+ +6\d{3}(\.\d+)? N", out), out
    assert ("nan" in out, "sinks:" in out) == (False, False)


def test_a_lognormal_has_the_mean_that_was_given(document):
    given = {"distribution": "lognormal", "mean": "4 MPa", "standard_deviation": "800 kPa"}
    found = bs.studies.read_study(document({FRICTION: given}, runs=2)).parameters[FRICTION]
    assert str(found.units) == "megapascal"
    assert (found.magnitude.mean(), found.magnitude.std()) == pytest.approx((4, 0.8))
    low, mode, high = 0.3, 0.5, 0.9
    given = {"distribution": "triangular", "low": low, "mode": mode, "high": high}
    found = bs.studies.read_study(document({FRICTION: given}, runs=2)).parameters[FRICTION]
    assert found.support() == pytest.approx((low, high))
    assert found.mean() == pytest.approx((low + mode + high) / 3)


@pytest.mark.parametrize(
    ("name", "values", "more", "said"),
    [
        ("joint_materials.lim.friction_coefficient", [1], {}, r"/parameters/joint_materials.lim.*has no 'lim'"),
        ("joint_materials.lime 1.5", [1], {}, "holds friction_coefficient; name one of them"),
        (FRICTION, {"distribution": "cauchy"}, {"runs": 2}, "cauchy"),
        (FRICTION, normal(1, -1), {"runs": 2}, "-1 where more than zero"),
        (FRICTION, normal("1 m", 1), {"runs": 2}, "all of them a unit"),
        (FRICTION, uniform("1 m", "1 kg"), {"runs": 2}, "one dimension"),
        (FRICTION, uniform(0, 1), {}, "give the number of samples"),
        (FRICTION, ["4 Mpaa"], {}, "is not a quantity"),
        (FRICTION, [1], {"sampling": "sobol"}, "/sampling"),
        (FRICTION, [1], {"workers": 2}, "unknown key 'workers'"),
    ],
)
def test_bad_documents_name_the_place(document, call, tmp_path, name, values, more, said):
    path = document({name: values}, **more)
    code, _, err = call("study", path, "-o", tmp_path / "runs")
    assert code == 2
    assert re.search(said, err.replace("\n", " ")), err
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(("direction", "code", "rows"), [("+y", 3, 2), ("+x", 0, 0)])
def test_a_pushover_without_a_curve_is_told_and_exits_with_3(document, call, tmp_path, direction, code, rows):
    """A block pushed along x does not move along y, the way of the control point."""
    path = document({FRICTION: [0.3, 0.7]})
    control = f"control: {{block: b.1, direction: {direction}}}, steps: 3"
    of_case = "{name: push, dead: dead, variable: push, flow: associative}"
    pushover = f"{{kind: pushover, name: push, dead: dead, variable: push, {control}}}"
    (tmp_path / "wall.yaml").write_text(MODEL.replace(of_case, pushover))
    found, out, err = call("study", path, "-o", tmp_path / "runs", "--workers", "1")
    assert (found, " ".join(out.split()).count("no capacity curve, rests")) == (code, rows), err
    _, out, _ = call("study", path, "-o", tmp_path / "runs", "--workers", "1", "--json")
    assert [row["missing_curve"] == "rests" for row in json.loads(out)["rows"]] == [rows == 2] * 2


@pytest.mark.filterwarnings("default::blockstruct.errors.StudyWarning")
@pytest.mark.parametrize(
    ("parameters", "more"),
    [({FRICTION: [-1, -2], HEIGHT: ["1 m", "2 m"]}, {}), ({FRICTION: uniform(-2, -1)}, {"runs": 3})],
)
def test_failures_alone_are_printed(document, call, tmp_path, parameters, more):
    words = ("study", document(parameters, **more), "-o", tmp_path / "runs", "--workers", "1")
    code, out, err = call(*words)
    assert (code, "failed:" in out) == (3, True), err
    assert re.search(r"(\d) of \1 runs failed", err)
    code, out, _ = call(*words, "--json")
    assert (code, {row["status"] for row in json.loads(out)["rows"]}) == (3, {"failed"})
    assert call(*words, "--csv", tmp_path / "rows.csv")[0] == 3
    assert "failed" in (tmp_path / "rows.csv").read_text()


def test_an_unreachable_scheduler_is_one_message(document, fails, tmp_path, monkeypatch):
    monkeypatch.setattr("blockstruct.studies.workers.PATIENCE", 0.3)
    words = ("study", document({FRICTION: [0.3]}), "-o", tmp_path / "runs", "--scheduler", "tcp://127.0.0.1:9")
    fails("no worker of cluster 'tcp://127.0.0.1:9' answers", *words)
    assert not (tmp_path / "runs").exists()
