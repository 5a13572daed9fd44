"""Pushovers on disk: written, read, checked, interrupted and gone on with."""

import numpy as np
import pytest
import xarray as xr

import blockstruct as bs
from blockstruct import Q_
from blockstruct.analysis import CaseStarted, StepDone
from structures import SELF_WEIGHT, block_on_a_bar, edited, model_of, push, single_block, stopping

CASE = bs.Pushover(
    "push",
    dead=SELF_WEIGHT,
    variable=push(1, 0, 0),
    control=("block", (1, 0, 0)),
    control_point=Q_([0.3, 0, 1.5], "m"),
    steps=12,
    corner_rounding="20 mm",
)


@pytest.fixture(scope="module")
def model():
    blocks, joint = single_block(0.3, 1.5, mu=2.0)
    return model_of(blocks, joint)


@pytest.fixture(scope="module")
def whole(model):
    return bs.run(model, CASE)["push"]


def same(one, other):
    """Whether two curves agree, but for their times and the rounding of rotations."""
    xr.testing.assert_allclose(one.drop_vars("solver_time"), other.drop_vars("solver_time"), rtol=1e-6, atol=1e-7)
    return True


def test_written_and_read(model, whole, tmp_path):
    path = tmp_path / "run.h5"
    result = bs.run(model, CASE, path)["push"]
    read = bs.open_analysis(path)["push"]
    assert read.capacity.identical(result.capacity)
    assert read.case == CASE
    assert str(read.outcome) == str(whole.outcome)
    assert read.curve_ended == whole.curve_ended
    assert same(read.capacity, whole.capacity)
    bs.check_file(path)
    assert read.capacity["position"].attrs["units"] == "meter"


def test_an_interrupted_run_goes_on_where_it_was(model, whole, tmp_path):
    path = tmp_path / "run.h5"
    manager = bs.AnalysisManager(model, path, listeners=[stopping(StepDone, at=4)])
    result = manager.run([CASE])["push"]
    assert result.status == "interrupted"
    assert result.capacity.sizes["step"] == 5
    heard = []
    done = bs.AnalysisManager.resume(path, listeners=[heard.append])["push"]
    assert done.status == "converged"
    assert same(done.capacity, whole.capacity)
    steps = [e.index for e in heard if isinstance(e, StepDone)]
    assert steps == list(range(whole.capacity.sizes["step"]))
    # Those that were known took no time.
    times = done.capacity["solver_time"].to_numpy()[:5]
    assert times.tolist() == result.capacity["solver_time"].to_numpy().tolist()
    assert bs.open_analysis(path)["push"].capacity.identical(done.capacity)


def test_a_curve_of_another_model_is_told(model, tmp_path):
    path = tmp_path / "run.h5"
    bs.run(model, CASE, path)
    with edited(path) as file:
        file["cases/push/capacity/block"][0] = "another"
    with pytest.raises(bs.errors.FormatError, match="block names of the capacity curve"):
        bs.open_analysis(path)


def test_how_a_curve_ended_is_kept_when_a_later_case_is_killed(tmp_path):
    """With a bar that has broken by then."""
    model, path = block_on_a_bar(), tmp_path / "run.h5"
    pushover = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=8)
    after = bs.LimitCase("after", SELF_WEIGHT, push(1, 0, 0), "associative")
    seen = []
    with pytest.raises(RuntimeError):
        bs.AnalysisManager(
            model, path, listeners=[seen.append, stopping(CaseStarted, case="after", error=RuntimeError)]
        ).run([pushover, after])
    bs.AnalysisManager.resume(path)
    whole, read = seen[-2].result, bs.open_analysis(path)["push"]
    assert not whole.broken_ties.empty
    assert read.broken_ties.equals(whole.broken_ties)
    assert read.capacity.identical(whole.capacity)
    assert str(read.outcome) == str(whole.outcome)
    assert read.curve_outcome.text == whole.curve_outcome.text


def test_a_spread_has_one_curve(model):
    analysis = bs.AnalysisManager(model).run([CASE], spread="steep")
    assert analysis["push"].capacity is not None
    assert [name for name, r in analysis.items() if r.capacity is None] == ["push [steep]", "push [associative]"]
    assert np.isfinite(analysis["push"].capacity["d0"])
