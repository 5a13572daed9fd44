"""Responses of tied structures to records: closed forms, slack and broken ties, energy, smaller steps."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.motion.record import respond
from blockstruct.statics.statics import Statics
from structures import SELF_WEIGHT, block_on_a_bar, box, model_of

G = Q_(1, "g_0").to("m/s^2").magnitude


def record(acceleration, time, direction="-x", **settings):
    return bs.RecordCase("record", SELF_WEIGHT, Q_(acceleration, "g_0"), time, direction, **settings)


def response(model, *motion, **settings):
    return bs.run(model, record(*motion, **settings), progress=False)["record"]


def missed(states):
    """Largest error of the energy, relative to the energy that is dissipated."""
    energy = states.kinetic_energy - states.dead_work - states.record_work + states.dissipated_energy
    return np.abs(energy).max() / states.dissipated_energy.max()


def sliding(yields_at, elongation_limit=None):
    """A cube of 4.32 kN, on a joint of friction 0.2, held by a bar through its centroid."""
    blocks = [
        box("ground", [-1, -1, -0.5], [5, 3, 0.5], fixed=True),
        box("block", [0, 0, 0], [0.6, 0.6, 0.6]),
        box("post", [3, 0, 0], [0.5, 0.6, 0.6], fixed=True),
    ]
    bar = bs.Tie(
        "bar",
        ("block", Q_([0.6, 0.3, 0.3], "m")),
        ("post", Q_([3, 0.3, 0.3], "m")),
        yield_force=Q_(yields_at * 4320, "N"),
        elongation_limit=elongation_limit,
    )
    return model_of(blocks, bs.JointMaterial("joint", 0.2)).with_ties([bar])


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_a_block_on_a_bar_slides_as_newmark_says(share):
    """A pulse of 0.6 g for 0.3 s. The bar yields at a share of the weight, and resists like friction."""
    mu, a, t = 0.2, 0.6, 0.3
    found = response(sliding(share), [a, a, 0, 0], Q_([0, t, t + 1e-6, 1.0], "s"), "+x", interval="50 ms")
    resists = mu + share
    speed = max(a - resists, 0.0) * G * t
    slip = speed * t / 2 + speed**2 / (2 * resists * G)
    last = found.response.isel(time=-1)
    assert found.status is bs.Status.STANDS
    assert -last.displacement[1, 0] == pytest.approx(slip, abs=1e-3 * slip + 1e-6)
    assert last.peak_tie_elongation == pytest.approx(slip, abs=1e-3 * slip + 1e-6)
    assert found.response.tie_force.max() == pytest.approx(min(share, a - mu) * 4320, rel=1e-6)
    assert last.dissipated_energy == pytest.approx(4320 * resists * slip, rel=2e-3, abs=0.01)
    assert missed(found.response) < 1e-9
    assert "Tie bar holds" in found.describe()


def test_a_bar_breaks_and_the_block_slides_on():
    """The speed at the break follows from the way to it, and the rest of the way from friction alone."""
    mu, a, t, share, limit = 0.2, 0.6, 0.3, 0.3, 0.01
    found = response(
        sliding(share, f"{limit} m"),
        [a, a, 0, 0],
        Q_([0, t, t + 1e-6, 1.0], "s"),
        "+x",
        interval="10 ms",
        time_step="1 ms",
    )
    slow, fast = (a - mu - share) * G, (a - mu) * G
    breaks = np.sqrt(2 * limit / slow)
    speed = slow * breaks + fast * (t - breaks)
    slip = limit + slow * breaks * (t - breaks) + fast * (t - breaks) ** 2 / 2 + speed**2 / (2 * mu * G)
    assert -found.response.displacement[-1, 1, 0] == pytest.approx(slip, rel=5e-3)
    assert found.broken_ties.loc["bar", "time [second]"] == pytest.approx(breaks, rel=5e-3)
    assert found.broken_ties.loc["bar", "elongation [meter]"] == limit
    assert f"Tie bar breaks at {found.response.tie_break_time.item():.4g} s." in found.describe()
    after = found.response.time > breaks + 0.02
    assert not found.response.tie_force[after].any()
    states = bs.results.pushed_tie_state(found.model, found.response).to_numpy()
    assert set(states[after.to_numpy()].ravel()) == {"broken"}


def test_a_bar_turns_over_late():
    """A block of 0.5 m by 2 m turns over at 0.25 g, and with a bar of a fifth of its weight at 1.5 m at 0.55 g."""
    still, falls = (response(block_on_a_bar(None), [a, a], "3 s", interval="50 ms") for a in (0.545, 0.555))
    assert still.status is bs.Status.STANDS
    assert still.response.peak_displacement.max() < 1e-5
    assert falls.status is bs.Status.COLLAPSES
    assert falls.response.peak_tie_elongation.max() > 0.5


def test_a_tight_tie_lets_a_block_rock_to_one_side_only():
    t = np.arange(0, 3, 0.01)
    found = response(block_on_a_bar(None, "1 GN"), 0.4 * np.sin(2 * np.pi * t), "0.01 s")
    angle = found.response.rotation[:, 2, 1]
    assert angle.min() < -0.02
    # Impacts stretch it by its trace of compliance.
    assert angle.max() < 2e-4
    assert 0 < found.response.peak_tie_elongation.max() < 3e-4
    assert missed(found.response) < 1e-9


def test_a_tie_breaks_only_where_it_yields():
    """Impacts stretch a bar of 1 GN by 0.15 mm, but load it to 8 kN."""
    holds, limited = (
        response(block_on_a_bar(limit, "1 GN"), 0.4 * np.sin(2 * np.pi * np.arange(0, 3, 0.01)), "0.01 s")
        for limit in (None, "0.05 mm")
    )
    assert holds.response.peak_tie_elongation.max() > 1e-4
    assert limited.status is bs.Status.STANDS
    assert limited.broken_ties.empty
    assert limited.response.displacement.equals(holds.response.displacement)


def test_a_broken_tie_changes_nothing():
    """The response after the break is that of the block without the bar."""
    model, case = block_on_a_bar("0.01 m"), record(np.repeat([0.8, 0.0], [4, 8]), "0.05 s", interval="25 ms")
    states = list(respond(Statics.of(model), case))
    k = next(k for k, s in enumerate(states) if s.peak_tie_elongation[0] > 0.01 and s.finds_contacts)
    none = np.empty(0)
    before = replace(states[k], tie_force=none, tie_elongation=none, peak_tie_elongation=none)
    rest = list(respond(Statics.of(model.with_ties(())), case, before))
    assert len(rest) > 5
    for with_tie, without in zip(states[k + 1 :], rest, strict=True):
        np.testing.assert_allclose(with_tie.displacement, without.displacement, atol=1e-9)


def test_a_tie_that_stays_slack_changes_nothing():
    model, case = block_on_a_bar(), record(np.repeat([0.4, 0.0], [4, 8]), "0.05 s", "+x", interval="25 ms")
    tied, free = (
        [s.displacement for s in islice(respond(Statics.of(m), case), 14)] for m in (model, model.with_ties(()))
    )
    assert np.abs(tied).max() > 0.02
    np.testing.assert_allclose(tied, free, atol=1e-9)


def test_half_the_step_gives_the_same_peak():
    """A tower between two posts, with ties at two heights that yield and break."""
    blocks = [box("ground", [-3, -1, -0.5], [7, 3, 0.5], fixed=True)]
    blocks += [box(f"b{k}", [0, 0, 0.5 * k], [0.6, 0.6, 0.5]) for k in range(4)]
    blocks += [box(f"post {x}", [x, 0, 0], [0.5, 0.6, 2], fixed=True) for x in (-2, 2.1)]
    model = model_of(blocks, bs.JointMaterial("joint", 0.6)).with_ties(
        bs.Tie(
            f"{post} {k}",
            (f"b{k}", Q_([x, 0.3, 0.5 * k + 0.25], "m")),
            (post, Q_([end, 0.3, 0.5 * k + 0.25], "m")),
            yield_force="1 kN",
            elongation_limit="30 mm",
        )
        for k in (1, 3)
        for post, x, end in (("post -2", 0.0, -1.5), ("post 2.1", 0.6, 2.1))
    )
    t = np.arange(0, 1.01, 0.01)
    pulse = 0.7 * np.sin(np.pi * t / 0.2) * (t < 0.4)
    found = [response(model, pulse, "0.01 s", "+x", time_step=h, interval="50 ms") for h in ("4 ms", "2 ms")]
    peaks = [float(r.response.peak_displacement.max()) for r in found]
    assert found[0].broken_ties.index.tolist() == found[1].broken_ties.index.tolist() != []
    assert peaks[0] > 0.1
    assert peaks[0] == pytest.approx(peaks[1], rel=0.05)
    assert max(missed(r.response) for r in found) < 1e-6
