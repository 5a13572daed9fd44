"""Shares of records under which a structure collapses."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import binom

import blockstruct as bs
from blockstruct import Q_
from structures import SELF_WEIGHT, model_of, single_block


def build(scale, pulse):
    """A slender block under a rectangular pulse of ``pulse`` g."""
    values = np.array([1.0, 1.0, 0.0, 0.0]) * scale * pulse
    times = Q_([0, 0.6, 0.61, 0.7], "s")
    case = bs.RecordCase("pulse", SELF_WEIGHT, Q_(values, "g_0"), times, "+x", interval="50 ms")
    return model_of(*single_block(0.3, 1.0, mu=0.9)), case


def test_a_study_of_records_gives_shares_and_peaks():
    data = bs.study(build, {"scale": [0.5, 1.0, 2.0], "pulse": [0.3, 0.4]}, workers=1, listeners=[])
    found = bs.studies.fragility(data)
    assert found.records.values.tolist() == [2, 2, 2]
    assert found.collapses.values.tolist() == [0, 1, 2]
    assert found.peak_displacement.sel(scale=0.5, fractile=0.84) < 1e-4
    assert np.isinf(found.peak_displacement.sel(scale=2.0, fractile=0.5))
    rows = bs.studies.frame_of(data)
    assert np.isfinite(rows.loc[rows["status"] == "collapses", "collapse_time"]).all()


def test_the_interval_is_that_of_clopper_and_pearson():
    status = xr.DataArray([["collapses"] * 3 + ["stands"] * 7 + ["undecided"]], dims=["scale", "case"])
    found = bs.studies.fragility(xr.Dataset({"status": status}, coords={"scale": [1.0]}), confidence=0.9).isel(scale=0)
    assert (int(found.records), float(found.share)) == (10, 0.3)
    assert binom.sf(2, 10, float(found.low)) == pytest.approx(0.05)
    assert binom.cdf(3, 10, float(found.high)) == pytest.approx(0.05)


def test_a_study_without_records_is_refused():
    status = xr.DataArray([["converged"]], dims=["scale", "case"])
    with pytest.raises(bs.errors.ModelError, match="RecordCase"):
        bs.studies.fragility(xr.Dataset({"status": status}))
    with pytest.raises(bs.errors.ModelError, match="scale"):
        bs.studies.fragility(xr.Dataset({"status": status}), "factor")
