"""What results print: the headline, the description of a collapse, and the reprs."""

import copy
import json
import pickle
from xml.etree import ElementTree

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.results import macro_blocks
from blockstruct.results.case_result import main_joints
from blockstruct.text.mechanism import motion_clause
from blockstruct.views import figures
from blockstruct.views.console import analysis_summary, result_text, summary_table
from blockstruct.views.report.contents import contents
from blockstruct.views.words import admissible_words
from structures import SELF_WEIGHT, model_of, push, settings_of, single_block, solve


def test_a_spread_gives_the_range_of_the_path_and_never_moves_the_headline(every_schedule):
    spread, given = every_schedule.spread("push"), every_schedule["push"]
    assert list(every_schedule.headlines) == ["push"]
    assert spread.given is given
    assert spread.load_factor == given.load_factor == spread.headline.load_factor
    paths = [r for r in spread.runs.values() if r.outcome.procedure is bs.vocabulary.Procedure.LOADING_PATH]
    assert len(paths) == 4
    assert given.path_dependence == (min(r.load_factor for r in paths), max(r.load_factor for r in paths))
    assert {r.outcome.procedure for r in spread.runs.values()} > {
        bs.vocabulary.Procedure.FICTITIOUS,
        bs.vocabulary.Procedure.SHIFTED,
    }
    assert spread.upper_bound.load_factor == pytest.approx(given.associative_load_factor, rel=1e-6)
    assert given.headline.lowest == given.path_dependence[0]


def test_every_text_marks_an_unsettled_load_factor(small_model, blank_pictures):
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))
    settings = settings_of(procedure="fictitious", patience=3, load_factor_tolerance=1e-15)
    with pytest.warns(bs.errors.LoadFactorWarning):
        analysis = bs.run(small_model, [case], settings=settings, spread="slow")
    alone = analysis["push"]
    assert (alone.status, alone.settled) == ("converged", False)
    texts = {
        "print": str(alone),
        "describe": alone.describe(),
        "terminal": result_text(alone).plain,
        "table": str(next(iter(summary_table(analysis).columns[2].cells))),
        "report": contents(analysis, {})["spreads"][0]["runs"][0]["status"],
    }
    assert [what for what, text in texts.items() if "NOT SETTLED" not in text] == []
    assert json.loads(json.dumps(analysis_summary(analysis)))["cases"][0]["settled"] is False


def test_the_admissible_state_of_an_unconverged_case(small_model):
    for flow, meaning in (("nonassociative", "not a lower bound"), ("associative", "It is a lower bound")):
        result = solve(small_model, push(1, 0, 0), flow, procedure="fictitious", max_programs=6, gap_tolerance=0.0)
        assert result.status == "not_converged"
        words = admissible_words(result)
        assert f"at load factor {result.admissible_load_factor:.4g}" in words
        assert meaning in words


def test_few_joints_are_active_and_the_first_dissipates_most(every_schedule):
    """At a threshold of 1e-4 the mechanism of a solver moves joints far away from it."""
    result = every_schedule["push"]
    active = result.active_joints
    assert list(active.columns) == ["state", "dissipation", "speed"]
    assert active["dissipation"].is_monotonic_decreasing
    assert active["speed"].gt(0.01).all()
    assert not active["state"].isin(["sticking", "unknown"]).any()
    # All work of the loads is dissipated in the joints: w_L·u = 1, and the dead load's. Joints that move by less than a
    # hundredth of the fastest are left out.
    last = result.history.isel(iteration=-1)
    weight = np.array([0.0 if b.fixed else b.weight for b in every_schedule.model.blocks])
    falls = -(weight * last.block_velocity.sel(axis="z").to_numpy()).sum()
    assert active["dissipation"].sum() == pytest.approx(result.load_factor + falls, rel=1e-2)


def test_a_block_that_rocks_is_one_body_on_a_hinge_that_dissipates_nothing():
    result = solve(model_of(*single_block(0.5, 1.0)), push(1, 0, 0))
    assert result.active_joints.to_dict("list") == {"state": ["hinge"], "dissipation": [0.0], "speed": [1.0]}
    table, (body,) = result.bodies, result.macro_blocks
    assert table.loc["body 1", ["axis_x", "axis_z"]].to_list() == pytest.approx([0.5, 0.0], abs=1e-5)
    assert table.loc["body 1", "rotation_y"] == body.rotation[1]
    assert table.attrs["units"]["translation_x"] == "dimensionless"


TUFF, LIME = bs.Material("tuff", "16 kN/m^3"), bs.JointMaterial("lime", 0.65)


def wall(**options):
    size = {"unit_length": "1.2 m", "unit_height": "0.5 m", "thickness": "0.5 m", "material": TUFF}
    return model_of(bs.wall(length="6 m", courses=6, **size, **options), LIME)


def test_a_wall_out_of_plane_is_one_body_about_its_edge():
    model = wall()
    result = solve(model, push(0, -1, 0))
    (body,) = macro_blocks(model, result.mechanism)
    assert len(body.blocks) == len(model.blocks) - 1
    assert body.weight == pytest.approx(6 * 3 * 0.5 * 16e3)
    np.testing.assert_allclose(body.centroid, [3, 0.25, 1.5], atol=1e-9)
    direction, point = body.axis
    np.testing.assert_allclose(abs(direction), [1, 0, 0], atol=1e-6)
    np.testing.assert_allclose(point[1:], [0, 0], atol=1e-5)
    (hinges,) = main_joints(result.history).values()
    assert len(hinges) == 5
    assert "33 of 33 free blocks move, 100% of the weight, as 1 body." in result.describe()
    assert "leans towards −y, turning about the axis along x through y = 0 m, z = 0 m." in result.describe()


def test_an_arch_has_three_moving_bodies_and_four_hinges():
    blocks = bs.arch(span="3.64 m", thickness="0.36 m", depth="0.6 m", voussoirs=15, material=TUFF)
    model = model_of(blocks, LIME)
    loaded = next(b for b in blocks if b.name == "5")
    load = bs.LoadPattern("1 kN", [bs.PointLoad("5", bs.Q_(loaded.centroid, "m"), "[0, 0, -1] kN")])
    result = solve(model, load)
    bodies = macro_blocks(model, result.mechanism)
    assert sum(body.moves for body in bodies) == 3
    assert len(main_joints(result.history)["hinge"]) == 4
    # Two blocks rest: none of their joints is fast.
    assert sum(len(body.blocks) for body in bodies if not body.moves) == 2


def test_crushing_moves_the_axis_inwards():
    blocks, joint = single_block(1.0, 2.0, mu=2.0)
    model = model_of(blocks, joint.varied(compressive_strength="100 kPa"))
    result = solve(model, push(1, 0, 0))
    (body,) = macro_blocks(model, result.mechanism)
    # A weight of 40 kN on 1 m × 1 m of 100 kPa: the last 0.4 m before the edge crush.
    _, point = body.axis
    assert point[0] == pytest.approx(0.6, abs=1e-4)
    assert main_joints(result.history)["crushing"] == ["ground|block"]


def test_carried_weights_count_as_in_the_participating_mass():
    """A roof of 10 kN/m on the middle of a wall of 0.5 × 3 m, 6 m long; an eighth of a load of 8 kN has mass."""
    roof = bs.LineLoad("10 kN/m", start=["0 m", "0.25 m", "3 m"], end=["6 m", "0.25 m", "3 m"])
    lamp = bs.Weight("6.1", point=["0.5 m", "0.25 m", "3 m"], weight="8 kN", mass_share=1 / 8)
    result = solve(wall(), push(0, -1, 0), dead=bs.LoadPattern("dead", [bs.SelfWeight(), roof, lamp]))
    (body,) = result.macro_blocks
    assert (body.weight, body.carried) == pytest.approx((6 * 3 * 0.5 * 16e3, 60e3 + 1e3))
    site = bs.assess.ntc_spectrum("0.15 g_0", 2.4, "0.3 s", "B")
    assert bs.assess.local_mechanism(result, 1.35, site).participation.total == pytest.approx(body.total)
    assert "100% of the weight, carried weight included, as 1 body." in result.describe()
    assert [note.code for note in result.notes] == ["masses"]
    handles = figures.mechanism(result, colour="macro-block").get_legend().get_texts()
    assert "205 kN, 61 kN of it carried" in " ".join(label.get_text() for label in handles)


@pytest.mark.parametrize(
    ("translation", "axis", "words"),
    [
        (
            (0.99, 0.14, -0.3),
            (-0.14, 0.99, 0),
            "leans towards +x (8° off), turning about an inclined axis near (1, 2, 3) m",
        ),
        ((0, -1, 0), (0, 0, 1), "swings towards −y, turning about the axis along z through x = 1 m, y = 2 m"),
    ],
)
def test_bodies_move_in_words(translation, axis, words):
    unit = np.array(axis) / np.linalg.norm(axis)
    assert motion_clause(np.array(translation), (unit, np.array([1.0, 2, 3])), np.zeros(3), 1.0) == words


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
