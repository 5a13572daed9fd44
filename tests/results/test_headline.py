"""One number a case: result, spread, console, page and JSON show the same."""

import json

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.views import analysis_summary, result_text, summary_table
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


def test_a_block_that_rocks_has_an_active_hinge_that_dissipates_nothing():
    active = solve(model_of(*single_block(0.5, 1.0)), push(1, 0, 0)).active_joints
    assert active["state"].tolist() == ["hinge"]
    assert active["dissipation"].tolist() == [0.0]
    assert active["speed"].tolist() == [1.0]
