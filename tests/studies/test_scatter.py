"""Distributions of load factors, and their first-order scatter."""

from functools import partial

import numpy as np
import pytest
import xarray as xr
from scipy import stats
from scipy.stats import binom

import blockstruct as bs
import studied
from blockstruct import Q_
from blockstruct.views import figures
from blockstruct.views.console import study_summary
from structures import SELF_WEIGHT, box, model_of, push, single_block, solve
from studied import samples


def test_the_summary_of_a_study_of_samples():
    """Sliding at μ: the fractiles are those of its distribution, within their confidence intervals."""
    mu = stats.uniform(0.2, 0.2)
    data = bs.study(studied.block, {"friction_coefficient": mu}, runs=12, seed=3, workers=1)
    found = bs.studies.summary(data, below=[0.3]).sel(case="push")
    true = mu.ppf(found.fractile)
    assert ((found.lower <= true) & (true <= found.upper)).all()
    assert found.mean_load_factor.item() == pytest.approx(data.friction_coefficient.mean().item(), rel=1e-6)
    assert found.probability_lower <= 0.5 <= found.probability_upper
    assert found.runs == 12
    assert found.attrs["exact"] == 1
    assert found.load_factor.attrs["units"] == "dimensionless"


def test_settlements_have_no_load_factors():
    """Their reactions are in the data, but neither a bound nor fractiles of load factors are told of them."""
    mixed = bs.study(studied.pulled, {"friction_coefficient": stats.uniform(0.5, 0.2)}, runs=3, seed=1, workers=1)
    assert np.isnan(mixed["bound"].sel(case="spreads")).all()
    assert (mixed["reaction"].sel(case="spreads") < 0).all()
    assert bs.studies.summary(mixed, below=[0.5])["case"].values.tolist() == ["push"]
    told = r"spreads: settlements have no load factors; .*data\.reaction\.quantile"
    with pytest.raises(bs.errors.ModelError, match=told):
        bs.studies.summary(mixed.sel(case=["spreads"]))


def test_schedules_of_a_spread_are_cases_and_leave_the_load_factor_as_it_is():
    """A study tells the runs apart by their case; that of the case itself is the run as given."""
    mu = {"friction_coefficient": stats.uniform(0.3, 0.5)}
    study = partial(bs.study, studied.wall, mu, runs=2, seed=2, workers=1)
    data, alone = study(spread="steep"), study()
    of_push = data.sel(case=["push", "push [steep]"])
    assert set(of_push.procedure.sel(case="push").values) == {"loading path"}
    assert set(of_push.procedure.sel(case="push [steep]").values) == {"fictitious"}
    assert (of_push.settled == 1).all()
    for name in ("load_factor", "status", "reason"):
        np.testing.assert_array_equal(data[name].sel(case=alone.case), alone[name])
    assert (of_push.load_factor <= data.bound.sel(case="push") + 1e-6).all()


def test_intervals_are_those_of_scipy():
    """Order statistics, against the interval of scipy's test of a quantile; and a proportion's."""
    values = np.random.default_rng(1).lognormal(size=200)
    found = bs.studies.summary(samples(values), confidence=0.95, below=[1.0]).sel(case="push")
    for fractile in found.fractile.to_numpy():
        # One rank further than scipy's: P(X_(u) ≥ q) counts u − 1 values below.
        interval = stats.quantile_test(values, p=fractile).confidence_interval(0.95)
        one = found.sel(fractile=fractile)
        ranked = np.sort(values)
        assert abs(np.searchsorted(ranked, one.lower) - np.searchsorted(ranked, interval.low)) <= 1
        assert abs(np.searchsorted(ranked, one.upper) - np.searchsorted(ranked, interval.high)) <= 1
    proportion = stats.binomtest(int((values < 1).sum()), 200).proportion_ci(0.95, method="exact")
    assert found.probability_lower.item() == pytest.approx(proportion.low)
    assert found.probability_upper.item() == pytest.approx(proportion.high)


def test_what_is_not_known_widens_every_interval():
    values = np.arange(1.0, 101.0)
    status = ["converged"] * 100
    for k, what in ((0, "unstable_under_dead_load"), (99, "unbounded"), (50, "failed"), (51, "not_converged")):
        status[k] = what
        values[k] = np.inf if what == "unbounded" else np.nan
    plain = bs.studies.summary(samples(np.arange(1.0, 101.0)))
    found = bs.studies.summary(samples(values, status))
    assert (found.unknown.item(), found.unstable.item(), found.unbounded.item()) == (2, 1, 1)
    assert (found.lower <= plain.lower).all()
    assert (found.upper >= plain.upper).all()
    assert np.isfinite(found.load_factor).all()
    few = bs.studies.summary(samples([1.0, 2.0]), fractiles=[0.05])
    assert few.lower.item() == -np.inf
    none = bs.studies.summary(samples([np.nan], ["failed"]), fractiles=[0.5])
    assert np.isnan(none.load_factor.item())


def test_what_mean_and_fractiles_leave_out_or_count_is_told():
    status = ["converged"] * 5
    for k, what in enumerate(("unstable_under_dead_load", "unbounded", "failed")):
        status[k] = what
    data = samples([np.nan, np.inf, np.nan, 0.3, 0.5], status)
    data["settled"] = data["status"].copy(data=np.array([0, 0, 0, 0, 1])[:, None])
    found = bs.studies.summary(data)
    assert found.drifting.item() == 1
    assert found.mean_load_factor.item() == pytest.approx(0.4)
    assert "5 runs, mean 0.4, standard deviation 0.14 of the 2" in study_summary(found)
    title = figures.distribution(data).get_title(loc="left")
    assert [line.split()[0] for line in title.splitlines()] == ["1"] * 4


def load_factor(model, friction):
    """Result with a friction coefficient for each interface."""
    joints = [bs.JointMaterial(f"joint {k}", mu) for k, mu in enumerate(friction)]
    interfaces = [i.with_joint_material(j) for i, j in zip(model.interfaces, joints, strict=True)]
    return solve(bs.Model("wall", model.blocks, interfaces), push(1, 0.3, 0))


@pytest.fixture(scope="module")
def friction(small_model):
    """No two joints alike: one mechanism only."""
    return np.random.default_rng(4).uniform(0.25, 0.45, len(small_model.interfaces))


@pytest.fixture(scope="module")
def scattered(small_model, friction):
    return load_factor(small_model, friction)


def test_derivatives_agree_with_finite_differences(small_model, friction, scattered):
    found, step = bs.studies.first_order(scattered, standard_deviation=0.05), 1e-4
    assert found.attrs["unique"] == 1
    assert (found.derivative > 0.01).sum() >= 2
    for k, interface in enumerate(small_model.interfaces):
        changed = np.eye(len(friction))[k] * step
        plus, minus = (load_factor(small_model, friction + sign * changed).load_factor for sign in (1, -1))
        expected = (plus - minus) / (2 * step)
        assert found.derivative.sel(interface=interface.name).item() == pytest.approx(expected, abs=2e-4)


def test_a_kink_is_told(small_model):
    """A wall of equal joints slides at any of its courses at the same load factor."""
    equal = load_factor(small_model, np.full(len(small_model.interfaces), 0.3))
    with pytest.warns(bs.errors.StudyWarning, match="has no derivatives with respect to friction"):
        found = bs.studies.first_order(equal, 0.05)
    assert found.attrs["unique"] == 0


def test_tension_within_the_friction_cone_stays_as_it_is():
    """A block that rocks does not depend on μ, nor one held by 3 kPa of tension: with 0.6 the cone ends at 67 kPa."""
    dry = bs.studies.first_order(bs.run(*studied.block(0.9))["push"], 0.05)
    assert (dry.attrs["unique"], dry.independent.item()) == (1, pytest.approx(0, abs=1e-6))
    mortar = bs.JointMaterial("mortar", 0.6, tensile_strength="3 kPa", cohesion="40 kPa")
    found = bs.studies.first_order(solve(model_of(single_block(0.5, 2.0)[0], mortar), push(1, 0, 0)), 0.1)
    assert found.attrs["unique"] == 1
    assert found.independent.item() == pytest.approx(0, abs=1e-6)


def test_scatter_of_independent_and_of_equal_joints(scattered):
    deviation = {joint.name: 0.05 for joint in list(scattered.model.joint_materials.values())[:3]}
    found = bs.studies.first_order(scattered, 0.05)
    contribution = found.contribution.to_numpy()
    assert (np.diff(np.abs(contribution)) <= 0).all()
    assert found.independent.item() == pytest.approx(np.sqrt((contribution**2).sum()))
    # Each joint is of a material of its own.
    assert found.correlated.item() == pytest.approx(found.independent.item())
    some = bs.studies.first_order(scattered, deviation)
    assert some.independent <= found.independent
    np.testing.assert_allclose(some.contribution, some.derivative * some.joint_material.isin(list(deviation)) * 0.05)


def test_joints_of_one_material_add_up():
    """A block on two feet slides at μ: the feet share dα/dμ = 1."""
    feet = [box(f"foot {k}", [x, 0, -1], [0.4, 1, 1], fixed=True) for k, x in enumerate((0, 1.6))]
    model = model_of([*feet, box("beam", [0, 0, 0], [2, 1, 0.3])], bs.JointMaterial("joint", 0.4))
    found = bs.studies.first_order(solve(model, push(1, 0, 0)), 0.1)
    assert found.derivative.sum().item() == pytest.approx(1, rel=1e-5)
    assert found.correlated.item() == pytest.approx(0.1, rel=1e-5)
    assert found.independent < found.correlated


@pytest.mark.parametrize(("torsion", "lever"), [("corners", 0.5**0.5), ("uniform pressure", 0.38259785823)])
def test_torsion_of_joints_counts_in_derivatives(torsion, lever):
    """A square of 1 m under 10 kN is twisted by ``lever μ W``: at its corners, or as under uniform pressure."""
    model = model_of(single_block(1.0, 0.5)[0], bs.JointMaterial("joint", 0.6, torsion=torsion))
    twist = bs.LoadPattern("twist", [bs.Moment("block", Q_([0, 0, 10], "kN*m"))])
    found = bs.studies.first_order(solve(model, twist), 0.1)
    assert found.attrs["unique"] == 1
    assert found.derivative.item() == pytest.approx(lever, rel=1e-5)


def test_questions_without_an_answer_are_refused(small_analysis):
    data = bs.study(studied.block, {"friction_coefficient": [0.3]}, workers=1)
    with pytest.raises(bs.errors.ModelError, match="are not samples"):
        bs.studies.summary(data)
    with pytest.raises(bs.errors.ModelError, match=r"fractiles \(5,\)"):
        bs.studies.summary(samples([1, 2]), fractiles=(5,))
    with pytest.raises(bs.errors.ModelError, match="run it with flow='associative'"):
        bs.studies.first_order(small_analysis["push nonassociative"], 0.1)
    with pytest.raises(bs.errors.UnknownNameError, match="did you mean dry"):
        bs.studies.first_order(small_analysis["push associative"], {"dryy": 0.1})
    with pytest.raises(bs.errors.ModelError, match="give zero or more"):
        bs.studies.first_order(small_analysis["push associative"], -0.1)


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
    others = xr.Dataset({"status": xr.DataArray([["converged"]], dims=["scale", "case"])})
    for arguments, words in (((), "RecordCase"), (("factor",), "scale")):
        with pytest.raises(bs.errors.ModelError, match=words):
            bs.studies.fragility(others, *arguments)


@pytest.mark.parametrize("undecided", [0, 2])
def test_the_interval_is_that_of_clopper_and_pearson(undecided):
    """Undecided records may be collapses or not: the interval holds for both. None decided is no share."""
    ends = [["collapses"] * 3 + ["stands"] * 7 + ["undecided"] * undecided, ["failed"] * 8 + ["undecided"] * 2]
    ends[1] += ["undecided"] * undecided
    status = xr.DataArray([["converged", *of] for of in ends], dims=["scale", "case"])
    data = xr.Dataset({"status": status}, coords={"scale": [1.0, 2.0]})
    found, none = (bs.studies.fragility(data, confidence=0.9).isel(scale=k) for k in range(2))
    assert (int(found.records), float(found.share), int(found.undecided)) == (10, 0.3, undecided)
    assert binom.sf(2, 10 + undecided, float(found.low)) == pytest.approx(0.05)
    assert binom.cdf(3 + undecided, 10 + undecided, float(found.high)) == pytest.approx(0.05)
    assert (int(none.records), float(none.low), float(none.high), bool(np.isnan(none.share))) == (0, 0, 1, True)
