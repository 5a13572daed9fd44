"""Responses to records: closed forms, energy, smaller steps."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from scipy.integrate import quad

import blockstruct as bs
from blockstruct import Q_
from blockstruct.motion import record
from blockstruct.motion.masses import Masses
from blockstruct.motion.record import _Run, respond
from blockstruct.statics.statics import Statics
from structures import SELF_WEIGHT, box, model_of, moved, rotation, single_block

G = Q_(1, "g_0").to("m/s^2").magnitude


def response(model, acceleration, time, direction="+x", **settings):
    """Response to an acceleration in g, as a Dataset."""
    case = bs.RecordCase("record", SELF_WEIGHT, Q_(acceleration, "g_0"), time, direction, **settings)
    return bs.run(model, [case], progress=False)["record"]


@pytest.mark.parametrize("direction", ["+x", (0.6, 0.8, 0.0)])
def test_a_block_slides_as_newmark_says(direction):
    """N. M. Newmark (1965), Géotechnique 15(2): a rectangular pulse of 0.6 g for 0.3 s, friction 0.3."""
    mu, a, t = 0.3, 0.6, 0.3
    blocks, joint = single_block(0.6, 0.5, 0.6, mu=mu)
    # The record falls to zero in 1 µs.
    found = response(model_of(blocks, joint), [a, a, 0, 0], Q_([0, t, t + 1e-6, 1.0], "s"), direction, interval="50 ms")
    speed = (a - mu) * G * t
    slip = speed * t / 2 + speed**2 / (2 * mu * G)
    way = found.response.displacement.isel(block=1, time=-1)
    assert found.status is bs.Status.STANDS
    unit = np.array([1.0, 0, 0]) if direction == "+x" else np.array(direction)
    assert way.to_numpy() == pytest.approx(-slip * unit, abs=1e-3 * slip)
    energy = found.response.isel(time=-1)
    weight = blocks[1].weight
    assert float(energy.dissipated_energy) == pytest.approx(mu * weight * slip, rel=2e-3)
    assert float(energy.record_work) == pytest.approx(float(energy.dissipated_energy), rel=1e-3)


def test_a_block_on_a_slope_slips_down_while_the_ground_moves_across_it():
    """Friction opposes the slip, whose direction changes: steps of 20 µs of ``a = f − μ g cos θ v / |v|``.

    With friction against the slip at the end of a step, the way down the slope was 2.7 % short.
    """
    slope, mu, t = np.radians(20), 0.5, np.arange(0, 2, 0.005)
    across = 0.6 * np.sin(4 * np.pi * t)
    turn = rotation([0, 1, 0], slope)
    blocks = moved([box("ground", [-3, -3, -0.5], [9, 6, 0.5], fixed=True), box("block", [0, 0, 0], [1, 1, 0.1])], turn)
    found = response(model_of(blocks, bs.JointMaterial("joint", mu)), across, Q_(t, "s"), "+y")
    h, velocity, way = 2e-5, 0j, 0j
    for load in np.sin(slope) - 1j * np.interp(np.arange(0, 2.5, h), t, across, right=0):
        free = velocity + h * G * load
        after = free * max(1 - h * G * mu * np.cos(slope) / max(abs(free), 1e-300), 0)
        way, velocity = way + h * (velocity + after) / 2, after
    displacement = found.response.displacement.isel(block=1, time=-1).to_numpy() @ turn
    assert displacement == pytest.approx([way.real, way.imag, 0], abs=1e-3 * abs(way))


def fallen_pinnacle(*others):
    """A pinnacle that nearly comes to rest on its edge after a pulse, and then falls."""
    blocks = [
        box("ground", [-9, -20, -1], [29, 40, 1], fixed=True),
        box("pinnacle", [0, 0, 0], [0.3, 0.3, 1.5]),
        *others,
    ]
    model = model_of(blocks, bs.JointMaterial("joint", 0.7))
    return response(model, [0.254, 0.254, 0, 0], Q_([0, 0.5, 0.5001, 0.51], "s"), interval="10 ms")


def test_blocks_that_do_not_touch_do_not_change_what_falls():
    """Beside a block of 8 m the pinnacle was at rest, 1 mrad from its balance: all blocks had one limit of energy."""
    alone, beside = fallen_pinnacle(), fallen_pinnacle(box("tower", [5, -5, 0], [8, 8, 8]))
    assert alone.status == beside.status == "collapses"
    assert beside.collapse_time == pytest.approx(alone.collapse_time, abs=1e-6)


def test_a_stone_that_has_slipped_over_an_edge_falls_after_the_record():
    """Its centroid is 10 mm beyond the edge. It stood there: contacts were followed by the mean size of all blocks."""
    blocks = [
        box("ground", [-30, -30, -1], [80, 60, 1], fixed=True),
        box("pedestal", [0, 0, 0], [1, 1, 1.5], fixed=True),
        box("stone", [-0.09, 0.3, 1.5], [0.3, 0.3, 0.2]),
        box("pier", [10, -20, 0], [8, 8, 10]),
    ]
    joints = {"*|stone": bs.JointMaterial("smooth", 0.3), "*": bs.JointMaterial("rough", 0.8)}
    model = bs.Model("pedestal", blocks, bs.detect_interfaces(blocks, joints))
    pulse = np.sqrt(0.07 / (0.3 * G))
    found = response(model, [0, 0, 0.6, 0.6, 0], Q_([0, 2 - pulse, 2 - pulse + 1e-5, 2, 2 + 1e-5], "s"))
    assert found.status == "collapses"


def test_a_slab_that_turns_in_plan_has_not_fallen():
    """A stop catches one of its corners, and it turns by more than 45° on its bed."""
    blocks = [
        box("ground", [-5, -5, -0.5], [10, 10, 0.5], fixed=True),
        box("stop", [-0.21, 0, 0], [0.2, 0.2, 0.2], fixed=True),
        box("slab", [0, 0, 0], [1, 1, 0.2]),
    ]
    found = response(model_of(blocks, bs.JointMaterial("joint", 0.3)), [1.5, 1.5, 0, 0], Q_([0, 0.4, 0.4001, 1], "s"))
    assert found.status == "stands"
    turned = found.response["rotation"].sel(block="slab").isel(time=-1).to_numpy()
    assert abs(turned[2]) > np.radians(45)
    assert turned[:2] == pytest.approx([0, 0], abs=1e-6)


@pytest.mark.parametrize("interval", [0.004, 0.1])
def test_a_block_that_tumbles_keeps_its_angular_momentum(interval):
    """To 4 mrad with any interval. With one of a single step, the direction turned by 0.2 rad in 0.1 s."""
    blocks = [box("post", [0, 0, 0], [1, 0.5, 99], fixed=True), box("block", [0, 0, 99], [1, 0.5, 0.25])]
    case = bs.RecordCase("r", SELF_WEIGHT, Q_([0, 0], "g_0"), "1 s", "+x", interval=Q_(interval, "s"), time_step="4 ms")
    run = _Run(Statics.of(model_of(blocks, bs.JointMaterial("joint", 0.5))), case)
    spin, away = np.zeros((2, 2, 3))
    spin[1], away[1] = [3, 0.5, 5], [5, 0, 0]
    state = replace(run.at_rest(), displacement=away, angular_velocity=spin)
    start = run._momentum(state)[1, 3:]
    while state.time < 0.0999:
        state = run.advance(state)
    assert run._momentum(state)[1, 3:] == pytest.approx(start, abs=0.01 * np.linalg.norm(start))


def rocking(h, b=0.4, height=2.0, tilt=0.5, end=1.5):
    """Free rocking of a block from a tilt relative to its slenderness: states, and slenderness."""
    blocks, joint = single_block(b, height, mu=2.0)
    statics = Statics.of(model_of(blocks, joint))
    case = bs.RecordCase(
        "free", SELF_WEIGHT, Q_([0, 0], "g_0"), Q_(end, "s"), "+x", interval=Q_(0.01, "s"), time_step=Q_(h, "s")
    )
    alpha = np.arctan(b / height)
    angle = tilt * alpha
    run = _Run(statics, case)
    state = run.at_rest()
    # About the lower right edge.
    arm = blocks[1].centroid - np.array([b, blocks[1].centroid[1], 0.0])
    R = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    displacement, rotation = np.zeros((2, 2, 3))
    displacement[1], rotation[1] = R @ arm - arm, [0, angle, 0]
    states = [replace(state, displacement=displacement, rotation=rotation)]
    while not run.ended(states[-1]) and states[-1].time < end - 1e-9:
        states.append(run.advance(states[-1]))
    return states, alpha


def test_a_block_rocks_as_housner_says():
    """G. W. Housner (1963), Bull. Seismol. Soc. Am. 53(2): quarter period, and 1 − 3/2 sin²α of its speed at impact."""
    b, height, tilt = 0.4, 2.0, 0.5
    alpha, R = np.arctan(b / height), np.hypot(b, height) / 2
    p, start = np.sqrt(3 * G / (4 * R)), tilt * alpha
    # The substitution θ = θ₀ − s² removes the singularity at the start.
    speed = lambda s: p * np.sqrt(2 * (np.cos(alpha - start) - np.cos(alpha - start + s**2)))  # noqa: E731
    quarter = quad(lambda s: 2 * s / speed(s), 1e-9, np.sqrt(start))[0]
    ratio = 1 - 1.5 * np.sin(alpha) ** 2
    back = alpha - np.arccos(np.cos(alpha) + ratio**2 * (np.cos(alpha - start) - np.cos(alpha)))
    errors = []
    for h in (0.005, 0.0025):
        states, _ = rocking(h)
        time, angle = np.array([s.time for s in states]), np.array([s.rotation[1, 1] for s in states])
        k = int(np.flatnonzero(angle < 0)[0])
        found = time[k - 1] + (time[k] - time[k - 1]) * angle[k - 1] / (angle[k - 1] - angle[k])
        errors.append((abs(found / quarter - 1), abs(-angle.min() / back - 1)))
        energy = np.array([s.kinetic_energy - s.dead_work for s in states])
        # Contacts are elastic by a trace, and give back what they store.
        assert np.diff(energy).max() <= (3e-3 if h > 0.004 else 1e-3) * np.ptp(energy)
        lost = np.array([s.dissipated_energy for s in states])
        assert energy[1:] - energy[1] == pytest.approx(lost[1] - lost[1:], abs=1e-9 * np.abs(energy).max())
    assert errors[0][0] < 0.01
    assert errors[1][0] < 0.005
    assert errors[0][1] < 0.01
    assert errors[1][1] < 0.005


def tower():
    blocks = [box("ground", [-1, -1, -0.5], [3, 3, 0.5], fixed=True)]
    blocks += [box(f"b{k}", [0, 0, 0.5 * k], [0.6, 0.6, 0.5]) for k in range(4)]
    return model_of(blocks, bs.JointMaterial("joint", 0.6))


def test_half_the_step_gives_the_same_peak():
    t = np.arange(0, 1.01, 0.01)
    pulse = 0.5 * np.sin(np.pi * t / 0.2) * (t < 0.4)
    peaks = []
    for step in ("4 ms", "2 ms"):
        case = bs.RecordCase("r", SELF_WEIGHT, Q_(pulse, "g_0"), "0.01 s", "+x", time_step=step, interval="50 ms")
        states = list(islice(respond(Statics.of(tower()), case), 21))
        peaks.append(states[-1].peak_displacement.max())
        for s in states:
            missed = s.kinetic_energy - s.dead_work - s.record_work + s.dissipated_energy
            assert abs(missed) <= 1e-6 * states[-1].dissipated_energy
    assert peaks[0] > 0.1
    assert peaks[0] == pytest.approx(peaks[1], rel=0.05)


def test_sheets_that_bear_far_more_than_their_weight_keep_drums_apart():
    """Contacts of a sheet deformed by its mass alone: drums sank through sheets of 2 mm, and fell."""
    thickness, z = 0.002, 0.0
    blocks = [box("ground", [-1, -1, -0.5], [3, 3, 0.5], fixed=True)]
    for k in range(3):
        blocks += [box(f"sheet {k}", [0, 0, z], [0.8, 0.8, thickness])]
        blocks += [box(f"drum {k}", [0, 0, z + thickness], [0.8, 0.8, 0.8])]
        z += 0.8 + thickness
    found = response(model_of(blocks, bs.JointMaterial("joint", 0.6)), [0, 0, 0], "0.05 s")
    assert found.status == "stands"
    assert float(-found.response["displacement"].sel(axis="z").min()) < 3e-3 * thickness


def test_the_search_of_contacts_does_not_change_rocking(monkeypatch):
    blocks, joint = single_block(0.4, 2.0, mu=0.6)
    statics, t = Statics.of(model_of(blocks, joint)), np.arange(0, 2, 0.01)
    case = bs.RecordCase("r", SELF_WEIGHT, Q_(0.3 * np.sin(2 * np.pi * t), "g_0"), "0.01 s", "+x")
    found = []
    for reach, kept in ((record.REACH, record.KEPT), (1e-4, 1)):
        monkeypatch.setattr(record, "REACH", reach)
        monkeypatch.setattr(record, "KEPT", kept)
        found.append([state.displacement[1, 0] for state in islice(respond(statics, case), 200)])
    assert np.ptp(found[0]) > 0.05
    assert found[0] == pytest.approx(found[1], abs=1e-5)


def test_impacts_of_a_wall_between_sidewalls_are_solved():
    """A façade of 17 blocks opens under 0.3 g, and strikes its sidewalls after 1.5 s."""
    door = bs.structures.Opening(start="1.2 m", sill="0 m", width="0.8 m", height="1.6 m")
    sides = [bs.structures.Sidewall(n, x, "1.2 m", bonded=False) for n, x in (("left", "0 m"), ("right", "2.8 m"))]
    size = {"unit_length": "120 cm", "unit_height": "80 cm", "thickness": "40 cm"}
    stone = bs.Material("tuff", "12 kN/m^3")
    blocks = bs.wall(length="3.2 m", courses=3, **size, openings=[door], sidewalls=sides, material=stone)
    t = np.arange(0, 3, 0.01)
    motion = 0.3 * np.sin(2 * np.pi * t) * np.sin(np.pi * t / 3)
    case = bs.RecordCase("r", SELF_WEIGHT, Q_(motion, "g_0"), "0.01 s", "-y")
    joints = {"base|*": bs.JointMaterial("ground", 0.6), "*": bs.JointMaterial("lime mortar", 0.65)}
    statics = Statics.of(bs.Model("façade", blocks, bs.detect_interfaces(blocks, joints)))
    last = max(islice(respond(statics, case), 115), key=lambda state: state.time)
    assert last.time > 1.7
    missed = last.kinetic_energy - last.dead_work - last.record_work + last.dissipated_energy
    assert abs(missed) <= 1e-6 * last.dissipated_energy


def test_a_block_that_the_ground_leaves_flies():
    """The ground falls with 3 g for 0.2 s: the block rises relative to it with 2 g, and then only with its speed."""
    blocks, joint = single_block(0.5, 0.5, mu=0.6)
    case = bs.RecordCase("r", SELF_WEIGHT, Q_([-3, -3, 0, 0], "g_0"), Q_([0, 0.2, 0.2001, 1], "s"), "+z")
    states = list(respond(Statics.of(model_of(blocks, joint)), case))
    rise, speed = 2 * G * 0.2**2 / 2, 2 * G * 0.2
    assert states[-1].peak_displacement[1] == pytest.approx(rise + speed**2 / (2 * G), rel=1e-3)
    assert any(not len(state.force_of_contact) for state in states)


def test_two_leaves_do_not_pass_through_each_other():
    """Leaves of 6 cm back to back: fast ones are followed further apart than both are thick."""
    blocks = [box("ground", [-5, -5, -1], [10, 10, 1], fixed=True)]
    blocks += [box(name, [x, 0, 0], [0.06, 3, 3]) for name, x in (("back", 0), ("front", 0.06))]
    t = np.arange(0, 3, 0.01)
    found = response(
        model_of(blocks, bs.JointMaterial("joint", 0.6)),
        0.2 * np.sin(np.pi * t) * np.sin(np.pi * t / 4),
        "0.01 s",
        interval="50 ms",
    )
    x = found.response.displacement.sel(axis="x")
    assert float((x.sel(block="front") - x.sel(block="back")).min()) > -0.01
    assert found.status is bs.Status.COLLAPSES


def test_a_record_that_ends_in_a_push_goes_on():
    """A block that a constant acceleration leans on a wall falls back when the record ends."""
    blocks, joint = single_block(0.3, 1.5)
    wall = box("wall", [-0.4, 0, 0], [0.3, 1, 2], fixed=True)
    found = response(model_of([*blocks, wall], joint), [0.4, 0.4], "4 s", interval="0.1 s").response
    way = found.displacement.sel(block="block", axis="x")
    assert float(way.sel(time=4, method="nearest")) == pytest.approx(-0.053, abs=0.002)
    assert float(way[-1]) == pytest.approx(0, abs=0.01)


def test_a_slender_block_falls_and_the_time_is_told():
    blocks, joint = single_block(0.2, 1.5, mu=0.8)
    found = response(model_of(blocks, joint), [0.5, 0.5], "1 s", interval="50 ms")
    assert found.status is bs.Status.COLLAPSES
    assert 0.3 < found.collapse_time < 2.0
    assert float(found.response.time[-1]) == found.collapse_time
    assert bs.results.fallen_blocks(found.model, found.response) == ["block"]
    assert "collapses" in str(found)


def test_a_wall_under_a_weak_record_stays():
    found = response(tower(), [0.0, 0.1, -0.1, 0.0, 0.0], "0.1 s", interval="50 ms")
    assert found.status is bs.Status.STANDS
    assert float(found.response.peak_displacement.isel(time=-1).max()) < 1e-5
    reaction = found.response.base_reaction.isel(time=-1).to_numpy()
    weight = sum(b.weight for b in found.model.blocks if not b.fixed)
    assert reaction == pytest.approx([0, 0, weight], abs=1e-3 * weight)


def test_weights_move_with_their_blocks():
    """A weight high on a block halves the static push that turns it over: it falls where the bare block stands."""
    blocks, joint = single_block(0.5, 1.0, mu=1.0)
    on_top = bs.Weight("block", Q_([0.25, 0.5, 3.0], "m"), Q_(20, "kN"))
    loaded = bs.LoadPattern("loaded", [bs.SelfWeight(), on_top])
    model, pulse = model_of(blocks, joint), Q_([0.35] * 2, "g_0")
    cases = [bs.RecordCase(d.name, d, pulse, "0.8 s", "+x", interval="50 ms") for d in (SELF_WEIGHT, loaded)]
    found = bs.run(model, cases, progress=False)
    assert [r.status for r in found.values()] == [bs.Status.STANDS, bs.Status.COLLAPSES]


def test_the_response_is_continued_from_any_state():
    blocks, joint = single_block(0.4, 1.2, mu=0.7)
    statics = Statics.of(model_of(blocks, joint))
    case = bs.RecordCase(
        "r", SELF_WEIGHT, Q_([0.5, 0.5, 0, 0], "g_0"), Q_([0, 0.2, 0.21, 0.8], "s"), "+x", interval="0.1 s"
    )
    whole = list(respond(statics, case))
    k = max(k for k, state in enumerate(whole[:-3]) if state.finds_contacts)
    rest = list(respond(statics, case, whole[k]))
    assert 0 < k == len(whole) - 1 - len(rest)
    for name in ("displacement", "velocity", "dissipated_energy", "base_reaction", "force_of_contact"):
        np.testing.assert_array_equal(getattr(whole[-1], name), getattr(rest[-1], name))


def test_a_structure_that_does_not_stand_has_no_response():
    leaning = [box("ground", [-1, -1, -0.5], [1.1, 3, 0.5], fixed=True), box("block", [0, 0, 0], [0.5, 0.5, 0.5])]
    found = response(model_of(leaning, bs.JointMaterial("joint", 0.6)), [0.1, 0.1], "1 s")
    assert found.status is bs.Status.UNSTABLE
    assert found.response is None


def test_masses_and_inertia_of_a_block_with_a_weight():
    blocks, joint = single_block(0.6, 0.9, 0.5)
    point = Q_([0.3, 0.25, 1.45], "m")
    dead = bs.LoadPattern("loaded", [bs.SelfWeight(), bs.Weight("block", point, Q_(5.4, "kN"), mass_share=0.5)])
    found = Masses.of(model_of(blocks, joint), dead, "")
    own, more = 5400 / G, 2700 / G
    assert found.mass[1] == pytest.approx(own + more)
    assert found.offset[1] == pytest.approx([0, 0, more / (own + more) * 1.0])
    sides = np.array([0.6, 0.5, 0.9]) ** 2
    about = own / 12 * (sides.sum() - sides) + own * more / (own + more) * np.array([1, 1, 0])
    assert found.inertia[1] == pytest.approx(np.diag(about), abs=1e-9)
