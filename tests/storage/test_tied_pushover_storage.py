"""A pushover whose tie yields and breaks: written, read, stopped half way and gone on with."""

import numpy as np
import pytest
from test_pushover_storage import StopError, same, stopping

import blockstruct as bs
from blockstruct import Q_
from structures import SELF_WEIGHT, box, model_of, push

CASE = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=16)


@pytest.fixture(scope="module")
def model():
    """A block on the ground, tied to a post behind it by a bar that breaks when it is 60 mm longer."""
    blocks = [
        box("ground", [-3, -0.5, -0.5], [6, 2, 0.5], fixed=True),
        box("post", [-2.5, 0, 0], [0.5, 1, 2], fixed=True),
        box("block", [0, 0, 0], [0.5, 1, 2]),
    ]
    ends = ("post", Q_([-2, 0.5, 1.5], "m")), ("block", Q_([0, 0.5, 1.5], "m"))
    bar = bs.Tie("bar", *ends, yield_force="4 kN", elongation_limit="60 mm")
    return model_of(blocks, bs.JointMaterial("rough", 2.0)).with_ties([bar])


@pytest.fixture(scope="module")
def stored(model, tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "run.h5"
    return bs.run(model, CASE, path)["push"], path


def broken_at(curve):
    """The first state without the bar."""
    return int((curve["tie_elongation"].sel(tie="bar") > 0.06).argmax("step"))


def test_written_and_read(stored):
    result, path = stored
    read = bs.open_analysis(path)["push"]
    assert read.capacity.identical(result.capacity)
    assert read.capacity["tie_break_displacement"].item() == result.broken_ties["displacement [meter]"].item()
    assert read.broken_ties.equals(result.broken_ties)
    assert read.curve_outcome.text == result.curve_outcome.text
    bs.check_file(path)


@pytest.mark.parametrize("beyond", [*(pytest.param(k, marks=pytest.mark.slow) for k in (-2, 2)), 0])
@pytest.mark.parametrize("how", ["stopped", "killed"])
def test_gone_on_with_it_is_the_curve_run_through(model, stored, tmp_path, how, beyond):
    """Before the bar breaks, as it breaks and after: it stays broken, and what it has yielded it keeps."""
    whole, path = stored[0], tmp_path / "run.h5"
    at = broken_at(whole.capacity) + beyond
    assert 2 < at < whole.capacity.sizes["step"] - 2
    error = {"stopped": KeyboardInterrupt(), "killed": StopError()}[how]
    manager = bs.AnalysisManager(model, path, listeners=[stopping(error, at)])
    if how == "stopped":
        cut = manager.run([CASE])["push"]
        assert cut.status == "interrupted"
        assert cut.curve_outcome is None
        assert cut.broken_ties.index.tolist() == ["bar"] * (beyond >= 0)
    else:
        with pytest.raises(StopError):
            manager.run([CASE])
    done = bs.AnalysisManager.resume(path)["push"]
    assert same(done.capacity, whole.capacity)
    assert done.outcome.reason is whole.outcome.reason
    assert done.load_factor == pytest.approx(whole.load_factor, rel=1e-8)
    assert done.curve_ended == whole.curve_ended
    assert done.capacity.attrs == whole.capacity.attrs
    np.testing.assert_allclose(done.broken_ties, whole.broken_ties, rtol=1e-6)
    assert bs.open_analysis(path)["push"].capacity.identical(done.capacity)


def test_a_curve_that_had_ended_when_the_run_was_killed(model, stored, tmp_path):
    """How it ended is among the working data."""
    path, whole = tmp_path / "run.h5", stored[0]

    def kill(event):
        if isinstance(event, bs.analysis.CaseStarted) and event.case.name == "after":
            raise StopError

    after = bs.LimitCase("after", SELF_WEIGHT, CASE.variable, "associative")
    with pytest.raises(StopError):
        bs.AnalysisManager(model, path, listeners=[kill]).run([CASE, after])
    done = bs.AnalysisManager.resume(path)["push"]
    assert done.outcome.reason is whole.outcome.reason
    assert done.load_factor == pytest.approx(whole.load_factor, rel=1e-8)
    assert done.curve_ended == whole.curve_ended
    assert done.capacity.attrs == whole.capacity.attrs
    assert same(done.capacity, whole.capacity)
