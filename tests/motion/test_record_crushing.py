"""Responses of joints that crush to records, against hand calculations.

Under its weight W a block b wide and t deep crushes over ``a = W / (f t)`` from its edge, with the strength f.
"""

from itertools import islice

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.motion.record import respond
from blockstruct.statics.contacts import Division
from blockstruct.statics.statics import Statics
from structures import SELF_WEIGHT, box, model_of, push, single_block

G = Q_(1, "g_0").to("m/s^2").magnitude


def joint(friction, strength=None):
    return bs.JointMaterial("joint", friction, compressive_strength=strength and Q_(strength, "MPa"))


def response(model, acceleration, time, direction="-x", cells=64, **settings):
    case = bs.RecordCase("record", SELF_WEIGHT, Q_(acceleration, "g_0"), time, direction, **settings)
    procedure = bs.ProcedureSettings(crushing_cells=cells)
    return bs.run(model, case, settings=procedure, progress=False)["record"]


def slender(strength):
    """A block of 0.3 m by 1.5 m."""
    return model_of(single_block(0.3, 1.5)[0], joint(0.3, strength))


@pytest.fixture(scope="module")
def falling():
    """The block under a push that is 1 % above the static one."""
    return response(slender(0.5), np.array([0, 1.01, 1.01]) * 0.188, Q_([0, 1, 4], "s"), interval="20 ms")


def test_a_block_turns_over_about_its_stress_block(falling):
    """At ``(b − a) / h = 0.188``, as the limit case says."""
    limit = bs.run(slender(0.5), bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0)), progress=False)["push"]
    assert limit.load_factor == pytest.approx(0.188, rel=1e-6)
    stands = response(slender(0.5), np.array([0, 0.99, 0.99]) * 0.188, Q_([0, 1, 4], "s"), interval="20 ms")
    assert stands.status is bs.Status.STANDS
    assert stands.response.peak_displacement.max() < 1e-4
    assert falling.status is bs.Status.COLLAPSES


def test_the_lost_depth_grows_from_the_end_of_the_stress_block(falling):
    """A point at x from there is crushed by ``x sin θ``; each cell by the depth at its centre."""
    states, a = falling.response, 9e3 / 0.5e6
    angle = states.rotation.sel(block="block", axis="y").to_numpy()
    some = (np.abs(angle) > 0.02) & (np.abs(angle) < 0.1)
    centre = a - 0.3 * (1 - np.cos(np.pi / 8)) / 4
    edge = states.crushed_depth.max("cell").to_numpy()
    assert np.count_nonzero(some) > 3
    assert edge[some] == pytest.approx(centre * np.sin(np.abs(angle[some])), rel=0.1)
    assert (np.diff(states.crushed_depth, axis=0) >= 0).all()
    assert (states.largest_crushed_depth >= edge).all()
    energy = states.kinetic_energy - states.dead_work - states.record_work + states.dissipated_energy
    assert np.abs(energy).max() <= 1e-6 * states.dissipated_energy.max()


def test_a_block_that_lands_flat_crushes_by_its_energy():
    """The ground leaves with 3 g for 0.05 s. The strength F of the joint stops the block: ``(F − W) d = m v² / 2``."""
    blocks, _ = single_block(0.5, 0.5)
    model = model_of(blocks, joint(0.6, 0.05))
    found = response(model, [-3, -3, 0, 0], Q_([0, 0.05, 0.0501, 1], "s"), "+z", interval="20 ms")
    weight, strength = 5e3, 25e3
    speed, rise = 2 * G * 0.05, 2 * G * 0.05**2 / 2
    fall = rise + speed**2 / (2 * G)
    depth = weight * fall / (strength - weight)
    last = found.response.isel(time=-1)
    assert found.status is bs.Status.STANDS
    assert last.crushed_depth.to_numpy() == pytest.approx(np.full(last.sizes["cell"], depth), rel=0.02)
    assert last.displacement[1, 2] == pytest.approx(-depth, rel=0.02)
    assert last.dissipated_energy == pytest.approx(strength * depth, rel=0.02)


def test_great_strength_is_no_limit():
    t = np.arange(0, 1.5, 0.01)
    pulse = 0.4 * np.sin(2 * np.pi * t / 0.8) * (t < 0.4)
    crushes, free = (
        response(
            model_of(single_block(0.4, 2.0)[0], joint(2.0, f)), pulse, "0.01 s", interval="20 ms", time_step="2 ms"
        )
        for f in (1e4, None)
    )
    peaks = [float(r.response.peak_displacement.max()) for r in (crushes, free)]
    assert peaks[0] > 0.02
    assert peaks[0] == pytest.approx(peaks[1], rel=0.02)
    assert "crushed_depth" not in free.response


def test_half_the_step_gives_the_same_peak():
    blocks = [box("ground", [-1, -1, -0.5], [3, 3, 0.5], fixed=True)]
    blocks += [box(f"b{k}", [0, 0, 0.5 * k], [0.6, 0.6, 0.5]) for k in range(4)]
    t = np.arange(0, 1.01, 0.01)
    pulse = Q_(0.5 * np.sin(np.pi * t / 0.2) * (t < 0.4), "g_0")
    peaks = []
    for strength, step in ((1.0, "4 ms"), (1.0, "2 ms"), (None, "4 ms")):
        case = bs.RecordCase("r", SELF_WEIGHT, pulse, "0.01 s", "+x", time_step=step, interval="50 ms")
        statics = Statics.of(model_of(blocks, joint(0.6, strength)), Division(16))
        last = max(islice(respond(statics, case), 15), key=lambda state: state.time)
        peaks.append(last.peak_displacement.max())
        missed = last.kinetic_energy - last.dead_work - last.record_work + last.dissipated_energy
        assert abs(missed) <= 1e-6 * last.dissipated_energy
    assert peaks[0] == pytest.approx(peaks[1], rel=0.05)
    assert peaks[0] > 1.1 * peaks[2]


def rocked(strength, cells, step, friction=0.6, end=1.5):
    """States of a block of 0.4 m by 2 m under one cycle of a sine of 0.33 g and 0.8 s."""
    t = np.arange(0, 1.5, 0.01)
    pulse = Q_(0.33 * np.sin(2 * np.pi * t / 0.8) * (t < 0.8), "g_0")
    case = bs.RecordCase("r", SELF_WEIGHT, pulse, "0.01 s", "+x", time_step=step, interval="20 ms")
    statics = Statics.of(model_of(single_block(0.4, 2.0)[0], joint(friction, strength)), Division(cells))
    return list(islice(respond(statics, case), round(end / 0.02) + 1))


@pytest.mark.parametrize("strength", [100.0, 2.0])
def test_cells_hardly_change_the_response(strength):
    """A cell that was crushed as a whole is tilted: its inner edge bears when the block comes back."""
    coarse, fine = (rocked(strength, cells, "2 ms") for cells in (16, 64))
    assert coarse[-1].largest_crushed_depth == pytest.approx(fine[-1].largest_crushed_depth, abs=2e-4)
    turned = [np.array([s.rotation[1, 1] for s in states]) for states in (coarse, fine)]
    assert np.abs(turned[0] - turned[1]).max() < 0.02 * np.ptp(turned[1])


@pytest.mark.parametrize("cells", [16, 64])
def test_crushing_gives_no_work_back(cells):
    """A cell that is crushed in part unloads elastically: energy falls while the block rocks, also between impacts."""
    states = rocked(2.0, cells, "1 ms", end=1.5)
    energy = np.array([s.kinetic_energy - s.dead_work - s.record_work for s in states])
    assert np.diff(energy).max() <= 0.01 * np.ptp(energy)


def test_a_strong_joint_loses_at_an_impact_what_a_joint_without_limit_loses():
    peaks = []
    for strength in (100.0, None):
        angle = np.array([s.rotation[1, 1] for s in rocked(strength, 64, "1 ms", end=1.2)])
        peaks.append((angle.min(), angle.max()))
    assert peaks[0] == pytest.approx(peaks[1], rel=0.03)


def test_friction_that_grows_solves_the_impacts_of_many_cells():
    """Newton's method alone does not solve the step of 0.7 s."""
    assert rocked(0.5, 256, "1 ms", end=0.8)[-1].time == pytest.approx(0.8, abs=1e-6)
