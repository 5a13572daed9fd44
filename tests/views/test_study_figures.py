"""Figures of studies."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import blockstruct as bs
from blockstruct.views import figures


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def around(small_model, dead):
    return bs.directions(small_model, dead, 4, flow="associative")


def test_the_compass(around):
    ax = figures.compass(around, label="wall")
    line = ax.get_lines()[0]
    np.testing.assert_allclose(line.get_ydata()[:4], around.data.load_factor)
    np.testing.assert_allclose(np.degrees(line.get_xdata()), [0, 90, 180, 270, 360])
    assert f"{around.load_factor:.4g}" in ax.get_title()
    assert line.get_linestyle() == "-"
    assert "not covered" not in ax.get_title() + str(around)
    assert ax.get_rmax() > around.data.load_factor.max()
    figures.compass(around.analysis, label="again", ax=ax)
    assert len(ax.get_legend().get_texts()) == 2
    with pytest.raises(bs.errors.ModelError, match="give polar ones"):
        figures.compass(around, ax=plt.figure().add_subplot())


def test_points_half_a_turn_apart_are_not_joined(small_model, dead):
    around = bs.directions(small_model, dead, bs.Q_([0, 90], "deg"), flow="associative")
    ax = figures.compass(around)
    assert np.isnan(ax.get_lines()[0].get_ydata()).tolist() == [False, False, True, False]
    assert "directions between the points are not covered" in ax.get_title()


def test_a_compass_joins_points_of_convex_directions_only(small_model, dead):
    around = bs.directions(small_model, dead, 4)
    settled = around.data["settled"].copy(data=[True, False, True, True])
    drifting = bs.studies.Directions(around.analysis, around.data.assign(settled=settled))
    ax = figures.compass(drifting)
    assert ax.get_lines()[0].get_linestyle() == "None"
    assert "directions between the points are not covered" in ax.get_title()
    (hollow,) = ax.collections
    np.testing.assert_allclose(hollow.get_offsets().ravel(), [np.pi / 2, around.data.load_factor[1]])
    assert "hollow" in ax.get_title()
    assert "directions between them are not covered, and one of them may be lower" in str(around)
    upwards = bs.directions(small_model, dead, 4, vertical=0.1, flow="associative")
    assert not upwards.is_convex
    assert "hollow" not in figures.compass(upwards).get_title()


def test_the_tornado():
    data = xr.Dataset(
        {"contribution": ("interface", [0.2, -0.1, 0.0]), "load_factor": 0.5, "independent": 0.2, "correlated": 0.3},
        coords={"interface": ["a|b", "b|c", "c|d"]},
        attrs={"unique": 0},
    )
    ax = figures.tornado(data)
    assert [text.get_text() for text in ax.get_yticklabels()] == ["a|b", "b|c"]
    assert [bar.get_width() for bar in ax.patches] == pytest.approx([0.2, -0.1, -0.2, 0.1])
    assert all(bar.get_x() == 0.5 for bar in ax.patches)
    assert "not derivatives" in ax.get_title(loc="left")
    with pytest.raises(bs.errors.ModelError, match="first_order"):
        figures.tornado(xr.Dataset())


def test_the_distribution():
    alpha, status = np.append(np.linspace(0.1, 0.3, 19), np.nan), ["converged"] * 19 + ["failed"]
    data = xr.Dataset(
        {"load_factor": (("run", "case"), alpha[:, None]), "status": (("run", "case"), np.array(status)[:, None])},
        coords={"case": ["push"]},
        attrs={"sampling": "monte carlo"},
    )
    ax = figures.distribution(data)
    step, *_ = ax.get_lines()
    assert step.get_xdata().tolist() == alpha[:19].tolist()
    assert step.get_ydata()[-1] == 1
    # The 5 % fractile of 20 runs has no lower end, the 95 % one no upper one.
    left, right = [line for line in ax.get_lines() if line.get_marker() in ("<", ">")]
    assert left.get_ydata().tolist() == [0.05]
    assert right.get_ydata().tolist() == [0.95]
    with pytest.raises(bs.errors.UnknownNameError, match="no case 'pull'"):
        figures.distribution(data, "pull")
    with pytest.raises(bs.errors.ModelError, match="name one"):
        figures.distribution(xr.concat([data, data.assign_coords(case=["pull"])], "case"))
