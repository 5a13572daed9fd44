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
        path.write_text(
            yaml.safe_dump(
                {"blockstruct": "study-1", "model": "wall.yaml", "parameters": parameters, **more}, sort_keys=False
            )
        )
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
    _, out, err = call("study", path, "-o", runs, "--workers", "1", "--csv", tmp_path / "rows.csv")
    assert "rows.csv: 4 rows" in out, err
    header = (tmp_path / "rows.csv").read_text().splitlines()[0].split(",")
    assert header[1:3] == [MU, f"{HEIGHT} [centimeter]"]
    found = json.loads(call("study", path, "-o", runs, "--workers", "1", "--json")[1])
    assert (found["units"][MU], found["units"][HEIGHT]) == ("dimensionless", "centimeter")
    assert found["rows"][0][HEIGHT] == 50
    low, short = (re.sub(r"\W", "_", f"parameter_{name}") for name in (MU, HEIGHT))
    code, out, err = call("archive", runs, "--where", f"{low} < 0.4 and {short} in [0.5]")
    assert (code, out.count("run-")) == (0, 1), err
    assert "size.2" in out


def test_a_place_that_an_alias_shares_is_varied_alone(document, tmp_path):
    path = document({"joint_materials.other.friction_coefficient": [0.2, 0.4]})
    shared = MODEL.replace(
        "{lime 1.5: {friction_coefficient: 0.65}}", "{lime 1.5: &j {friction_coefficient: 0.3}, other: *j}"
    )
    (tmp_path / "wall.yaml").write_text(shared)
    read = bs.studies.read_study(path)
    data = bs.study(read.build, read.parameters, workers=1)
    np.testing.assert_allclose(data.load_factor.sel(case="push"), [0.3, 0.3], rtol=1e-6)


def test_quantities_of_every_unit_are_varied(document):
    """A unit with powers, and one that is a power: as they are written in the document, and as files carry them."""
    weights = ["12 kN/m^3", "2e-5 N/mm**3", "30000 newton / meter ** 3"]
    read = bs.studies.read_study(document({"materials.tuff.unit_weight": weights}))
    data = bs.study(read.build, read.parameters, workers=1)
    assert set(data.problem.to_numpy()) == {""}
    built = [read.build(**{"materials.tuff.unit_weight": weight})[0] for weight in read.parameters.popitem()[1]]
    assert [model.blocks[1].weight / 0.5 for model in built] == pytest.approx([12e3, 20e3, 30e3])


def test_samples_of_a_document(document, done, tmp_path):
    distribution = {"distribution": "uniform", "low": 0.2, "high": 0.4}
    path = document({MU: distribution}, runs=3, seed=2)
    out = done("study", path, "-o", tmp_path / "runs", "--workers", "1")
    assert "confidence" in out
    read = bs.studies.read_study(path)
    data = bs.study(read.build, read.parameters, tmp_path / "runs", workers=1, settings=read.settings, **read.options)
    np.testing.assert_allclose(data.load_factor.sel(case="push"), data[MU], rtol=1e-6)


@pytest.mark.parametrize("alone", [True, False])
def test_settlements_of_a_document_print_their_reactions(document, done, tmp_path, alone):
    """A reaction has no fractile of load factors; beside a push, that of the push alone is told."""
    path = document({HEIGHT: {"distribution": "uniform", "low": "1 m", "high": "1.2 m"}}, runs=2)
    settlement = "{kind: settlement, name: sinks, dead: dead, supports: [base], direction: -z}"
    pushed = "" if alone else ", {name: push, dead: dead, variable: push, flow: associative}"
    before = MODEL.split("cases:")[0]
    (tmp_path / "wall.yaml").write_text(f"{before}cases: [{settlement}{pushed}]\n")
    out = done("study", path, "-o", tmp_path / "runs", "--workers", "1")
    assert re.search(r"sinks +6\d{3}(\.\d+)? N", out), out
    assert "nan" not in out
    assert "sinks:" not in out
    assert ("push: 2 runs" in out) != alone


def test_a_lognormal_has_the_mean_that_was_given(document):
    given = {"distribution": "lognormal", "mean": "4 MPa", "standard_deviation": "800 kPa"}
    place = "joint_materials.lime 1.5.friction_coefficient"
    found = bs.studies.read_study(document({place: given}, runs=2)).parameters[place]
    assert str(found.units) == "megapascal"
    assert (found.magnitude.mean(), found.magnitude.std()) == pytest.approx((4, 0.8))
    low, mode, high = 0.3, 0.5, 0.9
    given = {"distribution": "triangular", "low": low, "mode": mode, "high": high}
    found = bs.studies.read_study(document({place: given}, runs=2)).parameters[place]
    assert found.support() == pytest.approx((low, high))
    assert found.mean() == pytest.approx((low + mode + high) / 3)


@pytest.mark.parametrize(
    ("parameters", "more", "said"),
    [
        ({"joint_materials.lim.friction_coefficient": [1]}, {}, r"/parameters/joint_materials.lim.*has no 'lim'"),
        ({"joint_materials.lime 1.5": [1]}, {}, "holds friction_coefficient; name one of them"),
        ({MU: []}, {}, "/parameters/joint_materials.lime 1.5.friction_coefficient"),
        ({MU: {"distribution": "cauchy"}}, {"runs": 2}, "cauchy"),
        ({MU: {"distribution": "normal", "mean": 1}}, {"runs": 2}, "/parameters"),
        ({MU: {"distribution": "normal", "mean": 1, "standard_deviation": -1}}, {"runs": 2}, "-1 where more than zero"),
        ({MU: {"distribution": "normal", "mean": "1 m", "standard_deviation": 1}}, {"runs": 2}, "all of them a unit"),
        ({MU: {"distribution": "uniform", "low": "1 m", "high": "1 kg"}}, {"runs": 2}, "one dimension"),
        ({MU: {"distribution": "uniform", "low": 0, "high": 1}}, {}, "give the number of samples"),
        ({MU: ["4 Mpaa"]}, {}, "is not a quantity"),
        ({MU: ["4 MPa", 3]}, {}, "mixes a number and a quantity"),
        ({MU: [1]}, {"sampling": "sobol"}, "/sampling"),
        ({MU: [1]}, {"workers": 2}, "unknown key 'workers'"),
        ({MU: [1]}, {"model": "none.yaml"}, "none.yaml: no such file"),
    ],
)
def test_bad_documents_name_the_place(document, call, tmp_path, parameters, more, said):
    path = document(parameters, **more)
    code, _, err = call("study", path, "-o", tmp_path / "runs")
    assert code == 2
    assert re.search(said, err.replace("\n", " ")), err
    assert not (tmp_path / "runs").exists()


def test_a_pushover_without_a_curve_is_told_and_exits_with_3(document, call, tmp_path):
    """A block pushed along x does not move along y, the way of the control point."""
    path = document({MU: [0.3, 0.7]})
    control = "control: {block: b.1, direction: %s}, steps: 3"
    of_case = "{name: push, dead: dead, variable: push, flow: associative}"
    for direction, code, rows in (("+y", 3, 2), ("+x", 0, 0)):
        pushover = "{kind: pushover, name: push, dead: dead, variable: push, %s}" % (control % direction)
        (tmp_path / "wall.yaml").write_text(MODEL.replace(of_case, pushover))
        found, out, err = call("study", path, "-o", tmp_path / f"runs{direction}", "--workers", "1")
        assert found == code, err
        told = " ".join(out.split())
        assert told.count("no capacity curve, rests") == rows
        _, out, _ = call("study", path, "-o", tmp_path / f"runs{direction}", "--workers", "1", "--json")
        missing = [row["missing_curve"] for row in json.loads(out)["rows"]]
        assert [text == "rests" for text in missing] == [direction == "+y"] * 2


@pytest.mark.filterwarnings("default::blockstruct.errors.StudyWarning")
@pytest.mark.parametrize(
    ("parameters", "more"),
    [
        ({MU: [-1, -2], HEIGHT: ["1 m", "2 m"]}, {}),
        ({MU: [-1, -2]}, {"sampling": "paired"}),
        ({MU: {"distribution": "uniform", "low": -2, "high": -1}}, {"runs": 3}),
    ],
)
def test_failures_alone_are_printed(document, call, tmp_path, parameters, more):
    path = document(parameters, **more)
    code, out, err = call("study", path, "-o", tmp_path / "runs", "--workers", "1")
    assert code == 3, err
    assert re.search(r"(\d) of \1 runs failed", err)
    assert "failed:" in out
    code, out, _ = call("study", path, "-o", tmp_path / "runs", "--workers", "1", "--json")
    assert code == 3
    assert {row["status"] for row in json.loads(out)["rows"]} == {"failed"}
    code, _, _ = call("study", path, "-o", tmp_path / "runs", "--workers", "1", "--csv", tmp_path / "rows.csv")
    assert code == 3
    assert "failed" in (tmp_path / "rows.csv").read_text()


def test_an_unreachable_scheduler_is_one_message(document, fails, tmp_path, monkeypatch):
    monkeypatch.setattr("blockstruct.studies.workers.PATIENCE", 0.3)
    path = document({MU: [0.3]})
    words = ("study", path, "-o", tmp_path / "runs", "--scheduler", "tcp://127.0.0.1:9")
    fails("no scheduler answers at tcp://127.0.0.1:9", *words)
