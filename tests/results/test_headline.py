"""One number a case: the result, the spread, the console and the JSON say the same."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.limit import ProcedureSettings, scheduled
from blockstruct.views import analysis_summary, result_text, spread_text, summary_table
from blockstruct.views.page.payload import _head
from blockstruct.views.report.contents import contents
from blockstruct.views.words import (
    admissible_words,
    certificate_words,
    load_factor_words,
    spread_words,
    status_words,
    warning_words,
)
from structures import SELF_WEIGHT, model_of, push, single_block, solve

#: The settings as given, and every named schedule.
ALL = 1 + len(bs.SCHEDULES)


def headline(*ends, associative=0.4):
    return bs.results.Headline.of(
        [(bs.Status(status), alpha, not drifts) for status, alpha, *drifts in ends], bs.Flow.NONASSOCIATIVE, associative
    )


def test_the_lowest_certified_number_is_the_headline_everywhere(every_schedule):
    spread = every_schedule.spread("push")
    found = every_schedule.headlines
    assert list(found) == ["push"]
    assert found["push"] == spread.headline
    assert spread.load_factor == spread.lowest.load_factor
    assert spread.headline.highest == spread.highest.load_factor
    assert spread.headline.associative == spread.upper_bound.load_factor
    said = f"{spread.lowest.load_factor:.4g} (lowest of {ALL} of {ALL} schedules certified, up to"
    assert str(spread).startswith(said)
    assert said in spread_text(every_schedule)
    given = every_schedule["push"]
    assert given.relied_on == spread.headline
    told = f"relied on: {spread.headline}"
    assert str(given).splitlines()[1].strip() == told
    assert str(every_schedule).count(told) == 1
    assert told in result_text(given).plain
    assert str(spread.headline) in given._repr_html_()
    summary = json.loads(json.dumps(analysis_summary(every_schedule)))["headlines"]["push"]
    assert summary["load_factor"] == spread.load_factor
    assert summary["certified"] == ALL


def test_a_single_run_shows_its_associative_bound(small_analysis):
    lower, upper = small_analysis["push nonassociative"], small_analysis["push associative"]
    assert lower.associative_load_factor == pytest.approx(upper.load_factor, rel=1e-7)
    assert str(lower.headline) == f"{lower.load_factor:.4g} (associative bound {upper.load_factor:.4g})"
    assert str(upper.headline) == f"{upper.load_factor:.4g}"
    assert f"load factor {lower.headline.text(6)}" in result_text(lower).plain
    assert load_factor_words(lower) == lower.headline.number


def test_print_tells_how_many_schedules_converged():
    found = headline(("converged", 0.31), ("not_converged", math.nan), ("converged", 0.26))
    assert str(found) == "0.26 (lowest of 2 of 3 schedules certified, up to 0.31; associative bound 0.4)"
    assert (found.lowest, found.highest, found.certified) == (0.26, 0.31, 2)


@pytest.mark.parametrize(
    ("given", "lowest"), [(0.3, 0.3), (0.3 * (1 + 9e-7), 0.3 * (1 + 9e-7)), (0.3 * (1 + 2e-6), 0.3), (0.29, 0.29)]
)
def test_the_run_as_given_is_the_lowest_within_a_millionth(given, lowest):
    found = headline(("converged", given), ("converged", 0.3), ("converged", 0.31))
    assert (found.lowest, found.load_factor) == (lowest, lowest)
    assert headline(("converged", given, True), ("converged", 0.3)).lowest == 0.3


DRIFTS = "still drifting"


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        ([("converged", 0.23, DRIFTS)], "0.23 (still drifting when it was stopped)"),
        (
            [("converged", 0.3), ("converged", 0.26), ("converged", 0.05, DRIFTS)],
            "0.26 (lowest of 2 of 3 schedules certified and settled, up to 0.3; 1 more still drifting, at 0.05)",
        ),
        (
            [("converged", 0.23, DRIFTS), ("converged", 0.05, DRIFTS)],
            "0.05 (lowest of 2 of 2 schedules certified, all still drifting, up to 0.23)",
        ),
        (
            [("converged", 0.3), ("converged", 0.31, DRIFTS), ("converged", 0.31, DRIFTS)],
            "0.3 (1 of 3 schedules certified and settled; 2 more still drifting, at 0.31)",
        ),
        (
            [("converged", 0.3, DRIFTS), ("not_converged", math.nan)],
            "0.3 (1 of 2 schedules certified, still drifting)",
        ),
    ],
)
def test_a_number_that_drifts_is_no_answer_where_another_settled(ends, said):
    assert str(headline(*ends, associative=math.nan)) == said


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        ([("converged", 0.3), ("not_converged", math.nan)], "that of the only certified run"),
        (
            [("converged", 0.3, DRIFTS), ("not_converged", math.nan)],
            "that of the only certified run, which had not settled",
        ),
        (
            [("converged", 0.3), ("converged", 0.31, DRIFTS)],
            "that of the only certified run that settled (1 more, at 0.31, was still drifting when stopped)",
        ),
        ([("converged", 0.3), ("converged", 0.31)], "the lowest of 2 certified runs"),
    ],
)
def test_one_run_is_not_the_lowest_of_several(ends, said):
    assert headline(*ends).among == said


def test_a_case_without_a_load_factor_has_none_wherever_it_stands(small_model, dead):
    case = bs.LimitCase("push", dead, push(1, 0, 0))
    analysis = bs.run(small_model, case, settings=bs.ProcedureSettings(schedule=bs.FictitiousSchedule(max_programs=1)))
    (cells,) = [list(c.cells) for c in summary_table(analysis).columns if str(c.header) == "load factor"]
    texts = [str(analysis), repr(analysis), repr(analysis["push"]), analysis._repr_html_(), str(cells[0])]
    assert [text for text in texts if "none" not in text or "nan" in text] == []


def test_a_number_that_drifts_says_so_wherever_it_stands(small_model, blank_pictures):
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))
    settings = ProcedureSettings(schedule=bs.FictitiousSchedule(patience=3, load_factor_tolerance=1e-15))
    analysis = bs.AnalysisManager(small_model, settings=settings).run([case], spread=["slow", "loading path"])
    spread, alone = analysis.spread("push"), analysis["push"]
    report = contents(analysis, {})
    assert alone.status == "converged"
    assert alone.drifts
    assert not alone.settled
    assert spread.load_factor == analysis["push [loading path]"].load_factor
    texts = {
        "print of a result": str(alone),
        "describe": alone.describe(),
        "print of a spread": str(spread).splitlines()[1],
        "terminal": result_text(alone).plain,
        "sentence of the status": status_words(alone),
        "sentence of the spread": spread_words(spread),
        "report": report["spreads"][0]["runs"][0]["status"],
        "page": " ".join(_head(analysis, alone)["below"]),
    }
    assert [what for what, text in texts.items() if DRIFTS not in text] == []
    shown = _head(analysis, alone)
    said = f"{spread.load_factor:.4g}"
    assert said == spread.headline.number == shown["number"] == report["results"][0]["number"]
    assert str(spread).startswith(said)
    assert json.loads(json.dumps(analysis_summary(analysis)))["cases"][0]["settled"] is False


@pytest.mark.parametrize(
    ("ends", "status", "load_factor"),
    [
        # What is found about the dead load holds whatever other schedules find.
        ([("converged", 0.3), ("depends_on_self_stress", math.nan)], "depends_on_self_stress", math.nan),
        ([("unbounded", math.inf), ("converged", 0.3)], "converged", 0.3),
        ([("unbounded", math.inf), ("not_converged", math.nan)], "unbounded", math.inf),
        ([("not_converged", math.nan), ("converged", 0.3)], "converged", 0.3),
        ([("unstable_under_dead_load", math.nan)], "unstable_under_dead_load", math.nan),
    ],
)
def test_status_of_a_headline(ends, status, load_factor):
    found = headline(*ends)
    assert found.status == status
    assert found.load_factor == pytest.approx(load_factor, nan_ok=True)
    assert found.status.words in str(found) or math.isfinite(found.load_factor) or found.load_factor == math.inf


def test_a_schedule_never_raises_the_number_of_programs():
    assert scheduled(ProcedureSettings(schedule=bs.FictitiousSchedule(max_programs=7)), "shift").max_programs == 7
    # The shift took 59 % of the time of a spread, and failed in three of four: it has a budget.
    assert scheduled(ProcedureSettings(), "shift").max_programs == 40
    assert scheduled(ProcedureSettings(), "steep") == ProcedureSettings(schedule=bs.FictitiousSchedule(slope=0.6))


@pytest.mark.parametrize("status", list(bs.Status))
def test_every_status_has_its_sentence(small_analysis, status):
    result = replace(small_analysis["push nonassociative"], status=status)
    assert status_words(result).endswith(".")
    assert certificate_words(result).endswith(".")


def test_words_of_what_has_not_converged(small_model):
    for flow, meaning in (("nonassociative", "no lower bound"), ("associative", "a lower bound")):
        result = solve(small_model, push(1, 0, 0), flow, max_programs=6, gap_tolerance=0.0)
        assert result.status == "not_converged"
        words = admissible_words(result)
        assert f"at load factor {result.admissible_load_factor:.4g}" in words
        assert meaning in words
        assert words in result_text(result).plain


def test_words_of_a_warning():
    with pytest.warns(bs.errors.LoadFactorWarning):
        result = solve(model_of(*single_block(1.0, 1.0)), push(0.3, 0, -1), "nonassociative")
    assert warning_words(result) == result.warnings[0]
    assert result.warnings[0] in result_text(result).plain
    assert warning_words(solve(model_of(*single_block(0.5, 1.0)), push(1, 0, 0))) == ""


def test_spread_words_count_the_schedules(every_schedule):
    assert spread_words(every_schedule.spread("push")).startswith(
        f"{ALL} of {ALL} schedules found a certified collapse state, at"
    )
    one = SimpleNamespace(headline=headline(("converged", 0.3), ("not_converged", math.nan)), path_dependence=None)
    assert spread_words(one) == (
        "1 of 2 schedules found a certified collapse state, at load factor 0.3; associative bound 0.4."
    )


def test_few_joints_are_active_and_the_first_dissipates_most(every_schedule):
    """At a threshold of 1e-4 the mechanism of a solver moves joints far away from it."""
    result = every_schedule["push"]
    active = result.active_joints
    assert list(active.columns) == ["state", "dissipation", "speed"]
    assert active["dissipation"].is_monotonic_decreasing
    assert active["speed"].gt(0.01).all()
    assert not active["state"].isin(["sticking", "unknown"]).any()
    # All work of the loads is dissipated in the joints: w_L·u = 1, and the dead load's.
    last = result.history.isel(iteration=-1)
    weight = np.array([0.0 if b.fixed else b.weight for b in every_schedule.model.blocks])
    falls = -(weight * last.block_velocity.sel(axis="z").to_numpy()).sum()
    assert active["dissipation"].sum() == pytest.approx(result.load_factor + falls, rel=5e-3)


def test_joints_at_rest_are_not_active(small_analysis):
    history = small_analysis["push nonassociative"].history
    slow = history.copy(deep=True)
    v = slow.relative_velocity.to_numpy()
    fastest = int(np.argmax(np.abs(v[-1]).max(axis=1)))
    joint = slow.interface_of_contact_point.to_numpy()[fastest]
    # Every other joint moves at half a percent of the fastest.
    others = slow.interface_of_contact_point.to_numpy() != joint
    v[-1, others] = 0.005 * np.abs(v[-1]).max() * np.sign(v[-1, others])
    assert list(bs.results.active_joints(slow).index) == [slow.interface.to_numpy()[joint]]
    assert len(bs.results.active_joints(slow, tolerance=1e-4)) > 1


def test_a_block_that_rocks_has_an_active_hinge_that_dissipates_nothing():
    active = solve(model_of(*single_block(0.5, 1.0)), push(1, 0, 0)).active_joints
    assert active["state"].tolist() == ["hinge"]
    assert active["dissipation"].tolist() == [0.0]
    assert active["speed"].tolist() == [1.0]
