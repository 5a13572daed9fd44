"""Study documents, and the command that runs them."""

import json
import re

import numpy as np
import pytest
import yaml

import blockstruct as bs

MODEL = """
blockstruct: model-1
materials: {tuff: {unit_weight: 12 kN/m^3}}
joint_materials: {lime 1.5: {friction_coefficient: 0.65}}
blocks:
  - {name: base, material: tuff, fixed: true, box: {origin: [-1 m, -1 m, -1 m], size: [3 m, 3 m, 1 m]}}
  - {name: "b.1", material: tuff, box: {origin: [0 m, 0 m, 0 m], size: [0.5 m, 1 m, 1 m]}}
interfaces: {joint_material: lime 1.5}
load_patterns: {dead: [{kind: self_weight}], push: [{kind: body_force, direction: +x}]}
cases: [{name: push, dead: dead, variable: push, flow: associative}]
"""
MU, HEIGHT = "joint_materials.lime 1.5.friction_coefficient", "blocks.b.1.box.size.2"


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
    path = document({MU: [0.3, 0.7], HEIGHT: ["1 m", "50 cm"]})
    _, out, err = call("study", path, "--output", tmp_path / "runs", "--workers", "1")
    assert "4 of 4 runs" in err
    table = bs.Archive(tmp_path / "runs").table().sort_values("path")
    found = table.set_index([f"parameter_{MU}", f"parameter_{HEIGHT}"])["load_factor"]
    for (mu, height), alpha in found.items():
        assert alpha == pytest.approx(min(mu, 0.5 / height), rel=1e-6)
    assert "0.7" in out
    code, out, err = call("study", path, "--output", tmp_path / "runs", "--workers", "1", "--json")
    assert (code, "4 of them found" in err) == (0, True)
    rows = json.loads(out)["rows"]
    assert rows[0]["load_factor"] == pytest.approx(0.3, rel=1e-6)
    assert rows[1][HEIGHT] == 0.5
    call("study", path, "--output", tmp_path / "runs", "--workers", "1", "--csv", tmp_path / "rows.csv")
    assert len((tmp_path / "rows.csv").read_text().splitlines()) == 5


def test_parameters_are_found_by_their_names(document, call, tmp_path):
    path, runs = document({MU: [0.3, 0.7], HEIGHT: ["50 cm", "1 m"]}), tmp_path / "runs"
    found = json.loads(call("study", path, "-o", runs, "--workers", "1", "--json")[1])
    assert (found["units"][MU], found["units"][HEIGHT]) == ("dimensionless", "centimeter")
    assert found["rows"][0][HEIGHT] == 50
    low, short = (re.sub(r"\W", "_", f"parameter_{name}") for name in (MU, HEIGHT))
    code, out, err = call("archive", runs, "--where", f"{low} < 0.4 and {short} in [0.5]")
    assert (code, out.count("run-")) == (0, 1), err


def test_samples_of_a_document(document, done, tmp_path):
    distribution = {"distribution": "uniform", "low": 0.2, "high": 0.4}
    path = document({MU: distribution}, runs=3, seed=2)
    out = done("study", path, "-o", tmp_path / "runs", "--workers", "1")
    assert "confidence" in out
    read = bs.studies.read_study(path)
    data = bs.study(read.build, read.parameters, tmp_path / "runs", workers=1, settings=read.settings, **read.options)
    np.testing.assert_allclose(data.load_factor.sel(case="push"), data[MU], rtol=1e-6)


def test_settlements_of_a_document_print_their_reactions(document, done, tmp_path):
    """A reaction has no fractile of load factors."""
    path = document({HEIGHT: {"distribution": "uniform", "low": "1 m", "high": "1.2 m"}}, runs=2)
    settlement = "{kind: settlement, name: sinks, dead: dead, supports: [base], direction: -z}"
    (tmp_path / "wall.yaml").write_text(f"{MODEL.split('cases:')[0]}cases: [{settlement}]\n")
    out = done("study", path, "-o", tmp_path / "runs", "--workers", "1")
    assert re.search(r"sinks +6\d{3}(\.\d+)? N", out), out
    assert ("nan" in out, "sinks:" in out) == (False, False)


def test_a_lognormal_has_the_mean_that_was_given(document):
    given = {"distribution": "lognormal", "mean": "4 MPa", "standard_deviation": "800 kPa"}
    found = bs.studies.read_study(document({MU: given}, runs=2)).parameters[MU]
    assert str(found.units) == "megapascal"
    assert (found.magnitude.mean(), found.magnitude.std()) == pytest.approx((4, 0.8))
    low, mode, high = 0.3, 0.5, 0.9
    given = {"distribution": "triangular", "low": low, "mode": mode, "high": high}
    found = bs.studies.read_study(document({MU: given}, runs=2)).parameters[MU]
    assert found.support() == pytest.approx((low, high))
    assert found.mean() == pytest.approx((low + mode + high) / 3)


@pytest.mark.parametrize(
    ("parameters", "more", "said"),
    [
        ({"joint_materials.lim.friction_coefficient": [1]}, {}, r"/parameters/joint_materials.lim.*has no 'lim'"),
        ({"joint_materials.lime 1.5": [1]}, {}, "holds friction_coefficient; name one of them"),
        ({MU: {"distribution": "cauchy"}}, {"runs": 2}, "cauchy"),
        ({MU: {"distribution": "normal", "mean": 1, "standard_deviation": -1}}, {"runs": 2}, "-1 where more than zero"),
        ({MU: {"distribution": "normal", "mean": "1 m", "standard_deviation": 1}}, {"runs": 2}, "all of them a unit"),
        ({MU: {"distribution": "uniform", "low": "1 m", "high": "1 kg"}}, {"runs": 2}, "one dimension"),
        ({MU: {"distribution": "uniform", "low": 0, "high": 1}}, {}, "give the number of samples"),
        ({MU: ["4 Mpaa"]}, {}, "is not a quantity"),
        ({MU: [1]}, {"sampling": "sobol"}, "/sampling"),
        ({MU: [1]}, {"workers": 2}, "unknown key 'workers'"),
    ],
)
def test_bad_documents_name_the_place(document, call, tmp_path, parameters, more, said):
    path = document(parameters, **more)
    code, _, err = call("study", path, "-o", tmp_path / "runs")
    assert code == 2
    assert re.search(said, err.replace("\n", " ")), err
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(("direction", "code", "rows"), [("+y", 3, 2), ("+x", 0, 0)])
def test_a_pushover_without_a_curve_is_told_and_exits_with_3(document, call, tmp_path, direction, code, rows):
    """A block pushed along x does not move along y, the way of the control point."""
    path = document({MU: [0.3, 0.7]})
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
    [
        ({MU: [-1, -2], HEIGHT: ["1 m", "2 m"]}, {}),
        ({MU: {"distribution": "uniform", "low": -2, "high": -1}}, {"runs": 3}),
    ],
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
    path = document({MU: [0.3]})
    words = ("study", path, "-o", tmp_path / "runs", "--scheduler", "tcp://127.0.0.1:9")
    fails("no scheduler answers at tcp://127.0.0.1:9", *words)
