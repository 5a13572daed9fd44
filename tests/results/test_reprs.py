"""What a console and a notebook show of an object: a line, and a table."""

import copy
import pickle
from xml.etree import ElementTree

import pytest

import blockstruct as bs


@pytest.fixture(scope="module")
def objects(small_model, small_analysis):
    found = bs.detect_interfaces(small_model.blocks, joint_material=bs.JointMaterial("dry", 0.6))
    result = next(iter(small_analysis.values()))
    spread = bs.results.Spread({"as given": result}, None)
    return small_model, found.report, found, small_analysis, result, spread


def test_everything_has_a_line(objects):
    for shown in objects:
        text = repr(shown)
        assert "\n" not in text
        assert len(text) < 400, text
    small_model, *_, small_analysis, result, _ = objects
    assert repr(small_model).startswith(f"<Model {small_model.name!r}: ")
    assert result.name in repr(small_analysis)
    assert f"{result.load_factor:.4g}" in repr(result)


def page_of(shown):
    """What a notebook shows of an object, which is well formed, with the names of its elements and its texts."""
    page = ElementTree.fromstring(f"<div>{shown._repr_html_()}</div>")
    return {element.tag for element in page.iter()}, list(page.itertext())


def test_everything_has_a_table(objects):
    for shown in (*objects, objects[4].certificate):
        assert {"table", "tr", "td"} <= page_of(shown)[0]
    *_, result, _ = objects
    assert {result.headline.text(6), "equilibrium", "1e-06"} <= set(page_of(result)[1])


def test_names_are_not_markup(small_model):
    name = "<script>&"
    joint = bs.JointMaterial(name, 0.6, compressive_strength="4 MPa", dilatancy_angle="5 deg")
    model = bs.Model(name, small_model.blocks, [i.with_joint_material(joint) for i in small_model.interfaces])
    tags, texts = page_of(model)
    assert "script" not in tags
    assert "friction coefficient 0.6, dilatancy angle 5°, compressive strength 4 MPa" in texts


def test_a_certificate_prints_each_measure_with_its_tolerance(small_analysis):
    result = next(iter(small_analysis.values()))
    first, *lines = str(result.certificate).splitlines()
    assert first == "certificate holds"
    for line, (value, limit) in zip(lines, result.certificate.texts.values(), strict=True):
        assert f" {value} of " in line
        assert line.endswith(f"(tolerance {limit})")
    limit = result.settings.numerics.gap_tolerance * result.load_factor
    assert result.certificate.tolerances["flow_rule_gap"] == pytest.approx(limit)


@pytest.mark.parametrize("again", [lambda thing: pickle.loads(pickle.dumps(thing)), copy.deepcopy])
def test_results_are_the_same_in_another_process(small_analysis, tmp_path, again):
    bs.save_analysis(small_analysis, tmp_path / "small.h5")
    for analysis in (small_analysis, bs.open_analysis(tmp_path / "small.h5")):
        same = again(analysis)
        assert str(same) == str(small_analysis)
        assert (same.model.hash, same.versions) == (small_analysis.model.hash, small_analysis.versions)
        assert all(same[name].history.identical(result.history) for name, result in small_analysis.items())
    spread = bs.results.Spread({"as given": next(iter(small_analysis.values()))}, None)
    assert str(again(spread)) == str(spread)
    brick = bs.library.masonry("solid brick and lime mortar")
    assert (again(brick), str(again(brick))) == (brick, str(brick))
    for frozen in (same.results, again(spread).runs):
        with pytest.raises(TypeError):
            frozen["another"] = None
