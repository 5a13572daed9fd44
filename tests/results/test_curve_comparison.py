"""Pushovers side by side: compared, reproduced, in the table of an archive, and against their own numbers."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import blockstruct as bs
from blockstruct import Q_
from blockstruct.motion.state import CurveOutcome
from blockstruct.results import doubtful_parts
from blockstruct.vocabulary import CurveEnd
from structures import SELF_WEIGHT, model_of, push, single_block

EVEN = np.linspace(0, 1, 21)
#: Of short and of long steps.
UNEVEN = np.concatenate([[0, 0.001, 0.003, 0.01], np.linspace(0.05, 0.5, 6), [0.5001, 0.503], np.linspace(0.6, 1, 5)])


CERTIFIED = {"dissipation": 0.0, "energy_error": 0.0, "holds": True, "falls": False}


def parts(d, load_factor, procedure="fictitious", collapse=np.nan, ties=(), **values):
    """Doubtful parts of a curve over d; without friction, errors and falls by default."""
    values = CERTIFIED | values | {"load_factor": load_factor}
    curve = {name: ("step", np.broadcast_to(v, d.shape)) for name, v in values.items()}
    curve = xr.Dataset(curve | dict(ties), coords={"displacement": ("step", d)})
    return doubtful_parts(curve, procedure, collapse)


@pytest.mark.parametrize("d", [EVEN, UNEVEN])
@pytest.mark.parametrize(
    "of",
    [
        lambda d: 0.3 * (1 - d),
        lambda d: np.tan(np.arctan(0.3) * (1 - d)),
        lambda d: np.minimum(0.3, 0.6 * (1 - d)),
        lambda d: 0.3 - np.maximum(0.0, 0.5 * (d - 0.31)),
        lambda d: np.full_like(d, 0.3),
        lambda d: 0.3 * (1 - d) ** 2,
        lambda d: 0.3 * np.sqrt(1.2 - d),
    ],
    ids=["straight", "tangent", "kink", "another kink", "constant", "bends", "bends back"],
)
def test_neither_curves_nor_kinks_are_jumps(d, of):
    assert parts(d, of(d)) == parts(d[:2], of(d)[:2]) == []


@pytest.mark.parametrize("d", [EVEN, UNEVEN])
@pytest.mark.parametrize("share", [0.05, -0.05])
def test_a_jump_has_its_load_factors_and_its_displacement(d, share):
    load_factor = 0.3 * (1 - d) + 0.3 * share * (d > 0.4)
    (jump,) = parts(d, load_factor)
    k = int((d > 0.4).argmax())
    ends = slice(k - 1, k + 1)
    assert (jump.doubt, jump.displacement, jump.load_factor) == ("leaps", (*d[ends],), (*load_factor[ends],))
    assert parts(d, 0.3 * (1 - d) + 0.3 * share * (d > 0))[-1].displacement == (0, d[1])
    # Rounding may put a state on its way.
    between = 0.3 * (1 - EVEN) + 0.3 * share * ((EVEN > 0.38) + 1.0 * (EVEN > 0.42)) / 2
    (jump,) = parts(EVEN, between)
    assert jump.load_factor == (between[7], between[9])


def test_a_control_point_that_goes_back():
    d = np.concatenate([EVEN, [0.99, 0.97]])
    load_factor = 0.3 - 0.2 * np.append(0.0, np.abs(np.diff(d)).cumsum())
    (back,) = parts(d, load_factor)
    assert (back.doubt, back.displacement) == ("goes_back", (1.0, 0.97))
    assert parts(-d, load_factor)[0].displacement == (-1.0, -0.97)
    assert parts(d[:-1], load_factor[:-1]) == []


def test_a_curve_that_begins_above_the_collapse_state():
    (begun,) = parts(EVEN, 0.3 - 0.2 * EVEN, collapse=0.25)
    assert (begun.doubt, begun.load_factor) == ("begins_above", (0.25, 0.3))
    assert parts(EVEN, 0.3 - 0.2 * EVEN, collapse=0.299) == parts(EVEN, 0.3 - 0.2 * EVEN, collapse=0.35) == []


@pytest.mark.parametrize(("before", "after", "doubt"), [(0.0, 0.0, "leaps"), (0.3, 0.0, "slips"), (0.0, 0.2, "slips")])
def test_a_jump_slips_only_with_friction(before, after, doubt):
    load_factor = 0.3 * (1 - EVEN) - 0.05 * (EVEN > 0.4)
    (jump,) = parts(EVEN, load_factor, dissipation=np.where(EVEN > 0.4, after, before))
    assert jump.doubt == doubt


@pytest.mark.parametrize(("left", "doubt"), [(0.0, "rocks"), (0.1, "rocks_and_slides")])
def test_sliding_that_gives_way_to_rocking_on_a_long_step(left, doubt):
    """The load factor has a kink there and no jump; how far blocks slid is known to a step."""

    def of(d):
        return parts(d, np.minimum(0.3, 0.6 * (1 - d)), dissipation=np.where(d < 0.5, 0.3, left))

    (change,) = of(EVEN)
    assert (change.doubt, change.displacement) == (doubt, pytest.approx((0.45, 0.5)))
    assert of(np.linspace(0, 1, 401)) == []


def test_missed_work():
    (part,) = parts(EVEN, 0.3 * (1 - EVEN), energy_error=np.where(np.isclose(EVEN, 0.5), 0.02, 1e-3))
    assert (part.doubt, part.displacement, part.missed) == ("misses_work", pytest.approx((0.45, 0.5)), 0.02)


def test_states_whose_certificates_do_not_hold():
    """A state in which blocks fall may miss the flow rule."""
    (part,) = parts(EVEN, 0.3 * (1 - EVEN), holds=np.abs(EVEN - 0.45) > 0.16, falls=np.abs(EVEN - 0.3) < 0.01)
    assert (part.doubt, part.displacement) == ("not_certified", pytest.approx((0.35, 0.6)))


def test_a_rise():
    load_factor = 0.3 + 0.1 * np.sin(np.pi * EVEN) - 0.3 * EVEN**2
    (rise,) = parts(EVEN, load_factor)
    assert (rise.doubt, rise.load_factor) == ("rises", (load_factor[0], load_factor.max()))


@pytest.mark.parametrize("second", [np.nan, 0.44, 0.47, 0.52])
def test_jumps_of_ties_that_break_are_not_jumps(second):
    load_factor = 0.3 * (1 - EVEN) + 0.1 * (EVEN < 0.42) + 0.1 * (second > EVEN)
    assert parts(EVEN, load_factor)
    assert parts(EVEN, load_factor, ties={"tie_break_displacement": ("tie", [second, 0.42])}) == []


def test_a_tie_that_is_pulled_tight_is_no_jump():
    load_factor = 0.3 * (1 - EVEN) + 0.006 * (EVEN > 0.5) + 0.02 * (EVEN > 0.7)
    assert parts(EVEN, load_factor)[0].doubt == "leaps"
    assert parts(EVEN, load_factor, ties={"tie_force": (("step", "tie"), 1e3 * (EVEN > 0.7)[:, None])}) == []


def analysis(steps=12, control_point=None, width=0.3):
    blocks, joint = single_block(width, 1.5, mu=2.0)
    control = {"control": ("block", (1, 0, 0)), "control_point": control_point}
    return bs.run(model_of(blocks, joint), bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), steps=steps, **control))


@pytest.fixture(scope="module")
def rocking():
    """Zero at 0.15 m: half the width of the block."""
    return analysis()


def ending(whole, n):
    """An analysis whose pushover ends after so many states."""
    result = whole["push"]
    curve = result.capacity.assign(d0=((), np.nan, result.capacity["d0"].attrs))
    curve = curve.isel(step=slice(n), contact=np.flatnonzero(curve["step_of_contact"] < n))
    return whole.replaced(results={"push": replace(result, capacity=curve, curve_outcome=CurveOutcome(CurveEnd.FALLS))})


def test_the_same_curve_in_half_the_steps(rocking):
    found = bs.results.compare(rocking, analysis(24))
    row = found.cases.loc["push"]
    assert not row["same_question"]
    assert row["d0"] == pytest.approx(0.15, rel=1e-4)
    assert 0 < row["curve_difference"] < 1e-2
    assert np.isnan(row["curves_part_at"])
    assert found.agrees()
    assert not found.agrees(curve_rtol=1e-12)
    assert "d0 0.15 m, other 0.15 m, curves differ by" in str(found)


def test_curves_of_other_points_part(rocking):
    """The top of the block goes twice as far as its centroid, and further still."""
    found = bs.results.compare(rocking, analysis(control_point=Q_([0.3, 0.5, 1.5], "m")))
    row = found.cases.loc["push"]
    assert row["d0_other"] == pytest.approx(1.5 * np.sin(np.arctan(0.2)), rel=1e-4)
    # α falls to its 99th hundredth where the two have gone some hundredths of their ways.
    assert 0 < row["curves_part_at"] < 0.02
    assert row["curve_difference"] > 0.4
    assert not found.agrees()
    assert found.agrees(curve_rtol=np.inf)
    assert f", from {row['curves_part_at']:.4g} m on" in str(found)


def test_one_that_ends_before_the_load_factor_is_zero(rocking):
    found = bs.results.compare(rocking, ending(rocking, 6))
    assert found.cases.loc["push", "curve_difference"] == np.inf
    assert not found.agrees()
    assert "zero; other: falls" in str(found)
    earlier = bs.results.compare(ending(rocking, 8), ending(rocking, 6)).cases.loc["push", "curve_difference"]
    d = rocking["push"].capacity["displacement"].to_numpy()
    assert earlier == pytest.approx((d[7] - d[5]) / (d[7] - d[0]))
    without = rocking.replaced(results={"push": replace(rocking["push"], capacity=None)})
    assert bs.results.compare(rocking, without).cases.loc["push", "curve_difference"] == np.inf
    assert bs.results.compare(without, without).agrees(0)


def test_a_pushover_is_reproduced(rocking, tmp_path):
    path = bs.save_analysis(rocking, tmp_path / "push.h5")
    found = bs.reproduce(bs.open_analysis(path))
    assert found.agrees(1e-9, curve_rtol=1e-6)
    other = bs.reproduce(ending(rocking, 6))
    assert not other.agrees()
    assert other.cases.loc["push", "curve_ended"] == "falls"
    assert other.cases.loc["push", "d0_other"] == pytest.approx(0.15, rel=1e-4)


def test_the_d0_of_a_curve_is_held_against_its_displacements(rocking):
    result = rocking["push"]
    curve = result.capacity.copy(deep=True)
    curve["displacement"] = curve["displacement"] * 1.01
    changed = rocking.replaced(results={"push": replace(result, capacity=curve)})
    *_, (_, said) = bs.results.contradictions(changed)
    assert said.startswith("d0 is 0.15 m, that of the capacity curve 0.151")


def test_archives_tell_how_far_pushovers_went(rocking, tmp_path):
    for folder, done in (("a", rocking), ("b", ending(rocking, 6))):
        bs.save_analysis(done, tmp_path / folder / "push.h5")
    table = bs.Archive(tmp_path).table(all_columns=True).set_index("path")
    curve = rocking["push"].capacity
    assert table.attrs["units"]["d0"] == table.attrs["units"]["curve_end"] == "meter"
    assert table.loc["a/push.h5", "d0"] == curve["d0"].item()
    assert np.isnan(table.loc["b/push.h5", "d0"])
    assert table.loc["b/push.h5", ["curve_end", "curve_ended"]].tolist() == [curve["displacement"][5].item(), "falls"]
    assert bs.Archive(tmp_path).select("d0 < 0.2")["path"].tolist() == ["a/push.h5"]
    row = bs.Archive(tmp_path / "a").difference(bs.Archive(tmp_path / "b")).loc[("push.h5", "push")]
    assert (row["agree"], row["relative_difference"]) == (False, 0)
    assert row["end_difference"] < -0.1
    assert bs.Archive(tmp_path / "b").difference(bs.Archive(tmp_path / "b"))["agree"].all()


def test_the_command_prints_the_states_of_a_pushover(rocking, tmp_path, call, fails):
    path, curve = bs.save_analysis(rocking, tmp_path / "push.h5"), rocking["push"].capacity
    words = ("history", path, "push", "--pushover")
    assert len(call(*words)[1].splitlines()) == 2 + curve.sizes["step"]
    assert f"{curve['position'][-1, 1, 2].item():.6f}" in call(*words, "--variable", "position", "--last")[1]
    call(*words, "--csv", tmp_path / "states.csv")
    np.testing.assert_allclose(pd.read_csv(tmp_path / "states.csv")["displacement [meter]"], curve["displacement"])
    fails("known are load_factor", *words, "--variable", "colour")
    fails("leave it", *words, "--interface", "a|b")
