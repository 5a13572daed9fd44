"""A pushover that was killed at any of its states goes on as the one run through, to the last digit."""

import shutil

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.analysis import StepDone
from blockstruct.storage.file import folder_of
from structures import SELF_WEIGHT, block_on_a_bar, box, model_of, push, slid_from_under, slipping_units, stopping


def sliding_to_a_stop():
    """A block slides until it meets a low stop, and turns over there."""
    blocks = [
        box("ground", [-1, 0, -0.5], [3, 1, 0.5], fixed=True),
        box("block", [0, 0, 0], [0.4, 1, 0.5]),
        box("stop", [0.5, 0, 0], [0.1, 1, 0.05], fixed=True),
    ]
    return model_of(blocks, bs.JointMaterial("smooth", 0.2)), "block"


def turning_onto_others():
    """A tall block falls against one that turns and meets a third."""
    blocks = [
        box("ground", [-1, 0, -0.5], [6, 1, 0.5], fixed=True),
        box("tall", [0, 0, 0], [0.3, 1, 1.2]),
        box("other", [0.4, 0, 0], [0.5, 1, 1]),
        box("third", [1, 0, 0], [0.5, 1, 0.4]),
    ]
    return model_of(blocks, bs.JointMaterial("rough", 2.0)), "tall"


def on_a_tie():
    """A block on a bar that yields and breaks."""
    return block_on_a_bar(), "block"


def slipping():
    """A wall of ten units, which slip and rock."""
    model = slipping_units()
    return model, model.blocks[-1].name


def dropping():
    """A block that drops onto a ledge."""
    return slid_from_under(), "a"


@pytest.mark.parametrize("states", [4, pytest.param(10, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("structure", "steps"),
    [
        (on_a_tie, 6),
        *(
            pytest.param(*row, marks=pytest.mark.slow)
            for row in ((sliding_to_a_stop, 4), (turning_onto_others, 3), (slipping, 6), (dropping, 10))
        ),
    ],
)
def test_killed_at_any_state_it_is_the_same_curve(tmp_path, structure, steps, states):
    model, control = structure()
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=(control, (1, 0, 0)), steps=steps)
    path, kept = tmp_path / "run.h5", []

    def keep(event):
        """The working data as a kill would leave them."""
        if isinstance(event, StepDone):
            copy = tmp_path / f"{event.index}" / "run.h5"
            shutil.copytree(folder_of(path), folder_of(copy))
            kept.append(copy)

    whole = bs.AnalysisManager(model, path, listeners=[keep]).run([case])["push"]
    assert len(kept) == whole.capacity.sizes["step"] > steps
    # What follows a state depends on what is kept alone: where three more are the same, all are, as those that are
    # continued to the end show.
    chosen = range(0, len(kept), -(-len(kept) // states))
    to_the_end = {chosen[1], chosen[len(chosen) // 2], *range(len(kept) - 4, len(kept))}
    for at in chosen:
        last = None if at in to_the_end else at + 3
        listeners = [] if last is None else [stopping(StepDone, at=last)]
        done = bs.AnalysisManager.resume(kept[at], listeners=listeners)["push"]
        expected = whole.capacity.drop_vars("solver_time")
        if last is not None:
            expected = expected.isel(step=slice(last + 1), contact=(expected["step_of_contact"] <= last).to_numpy())
            expected = expected.drop_vars(["d0", "tie_break_displacement"], errors="ignore")
        else:
            assert done.curve_ended == whole.curve_ended, at
            assert done.load_factor == pytest.approx(whole.load_factor, rel=1e-8), at
        for name, values in expected.variables.items():
            np.testing.assert_array_equal(done.capacity[name], values, f"{name}, gone on with at {at}")
