"""Record cases: what they take and refuse, and that they are written and read again."""

import attrs
import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import SELF_WEIGHT, model_of, single_block

PULSE = Q_([0.0, 0.3, 0.0], "g_0")
GAP = {"acceleration": Q_(np.full(30, 0.1), "g_0"), "time": Q_([*np.arange(20), *np.arange(25, 35)], "s") / 100}


def record(acceleration=PULSE, time="0.1 s", direction="+x", **more):
    return bs.RecordCase("record", SELF_WEIGHT, acceleration, time, direction, **more)


def test_a_record_along_a_direction_and_along_the_axes():
    one, three = record(), record(Q_(np.outer([0, 0.3, 0], [1, 0, 0]), "g_0"), Q_([0, 0.1, 0.2], "s"), None)
    np.testing.assert_array_equal(one.ground, three.ground)
    np.testing.assert_array_equal(one.times, three.times)
    assert one.peak == pytest.approx(0.3 * 9.80665)
    assert one.scaled(2.0, "double").peak == pytest.approx(2 * one.peak)
    assert one.scaled(2.0, "double").name == "double"


@pytest.mark.parametrize(
    ("changes", "error", "told"),
    [
        ({"acceleration": Q_([0.0, np.nan, 0.0], "g_0")}, bs.errors.DimensionError, "sample 1"),
        ({"acceleration": [0.0, 0.3, 0.0]}, bs.errors.UnitError, "unit"),
        ({"acceleration": Q_([0.0, 0.3, 0.0], "g")}, bs.errors.DimensionError, "acceleration"),
        ({"acceleration": Q_([0.3], "g_0")}, bs.errors.ModelError, "shape"),
        ({"time": Q_([0.0, 0.2, 0.1], "s")}, bs.errors.ModelError, "sample 2"),
        ({"time": Q_([0.0, 0.2], "s")}, bs.errors.ModelError, "2 times and 3"),
        (GAP, bs.errors.ModelError, "no samples from 0.19 to 0.25 s"),
        ({"time": "0 s"}, bs.errors.ModelError, "more than zero"),
        ({"direction": None}, bs.errors.ModelError, "direction"),
        ({"acceleration": Q_(np.zeros((3, 3)), "g_0")}, bs.errors.ModelError, "leave the direction out"),
    ],
)
def test_what_is_wrong_is_named(changes, error, told):
    with pytest.raises(error, match=told):
        record(**changes)


@pytest.mark.parametrize(
    "joint", [{"cohesion": "1 kPa"}, {"friction_coefficient": np.inf}, {"dilatancy_angle": "5 deg"}]
)
def test_joints_that_are_not_followed_are_refused(joint):
    blocks, _ = single_block(0.5, 1.0)
    model = model_of(blocks, bs.JointMaterial("joint", **{"friction_coefficient": 0.6} | joint))
    with pytest.raises(bs.errors.ModelError, match="record case 'record'"):
        bs.run(model, record())


def test_a_block_without_mass_is_refused():
    blocks, joint = single_block(0.5, 1.0)
    feather = bs.Material("feather", "0 kN/m^3")
    model = model_of([blocks[0], attrs.evolve(blocks[1], material=feather)], joint)
    with pytest.raises(bs.errors.ModelError, match="no mass"):
        bs.run(model, record())


@pytest.mark.parametrize("name", ["record.yaml", "record.json"])
def test_documents_hold_records(tmp_path, name):
    model = model_of(*single_block(0.5, 1.0))
    cases = [
        record(interval="20 ms", time_step="1 ms"),
        record(Q_(np.eye(3), "m/s^2"), Q_([0.5, 0.75, 1.5], "s"), None).renamed("axes"),
    ]
    read = bs.read_document(bs.write_document(tmp_path / name, model, cases))
    assert list(read.cases) == cases
