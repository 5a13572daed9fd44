"""Joints between faces that an import moved: only moves of their faces close them."""

import warnings

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.contacts import corrected_joints
from meshes import CUBE, objects_text, read
from structures import rotation

JOINT = bs.JointMaterial("joint", 0.6)


def wall(head, bed, *, off=0.0):
    """Two courses of four stones on a slab, in mm. One bed joint is closed; there a corner of a stone is off."""
    boxes = [("slab", (-100, 0, -300), (4200, 500, 300))]
    for course in range(2):
        for k in range(4):
            origin = (1000 * k, 0, course * 400 + bed * (course == 1 and k != 1))
            boxes.append((f"{course}.{k}", origin, (1000 - head, 500, 400)))
    bodies = {name: np.array(CUBE, dtype=float) * size + origin for name, origin, size in boxes}
    bodies["0.1"][6, 2] += off
    return objects_text(bodies)


def imported(tmp_path, text):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bs.errors.GeometryWarning)
        return read(tmp_path, "wall.obj", text, unit="mm", fixed=["slab"])


def pairs(contacts):
    return {(c.minus, c.plus) for c in contacts if not c.reason}


def test_one_moved_vertex_closes_only_its_joint(tmp_path):
    found = imported(tmp_path, wall(head=8, bed=0, off=3.5))
    assert 0.7e-3 < max(r.amount for r in found.report.repairs if r.kind == "flattened") < 0.9e-3
    assert set(found.moves) == {"0.1"}
    joints = corrected_joints(found.blocks, JOINT, found.moves)
    # The tilted bed joint at the corner is closed, the head joints of 8 mm are not.
    assert pairs(joints.closed) == {("0.1", "1.1")}
    assert "0.1 | 1.1" in str(joints)
    report = bs.detect_interfaces(found.blocks, JOINT, joints.tolerance, explicit=joints.explicit).report
    beds = {("slab", f"0.{k}") for k in range(4)} | {(f"0.{k}", f"1.{k}") for k in range(4)}
    assert pairs(report.contacts) == beds
    assert bs.detect_interfaces(found.blocks, JOINT).report.accepted == 7


def test_joints_are_explicit_if_no_tolerance_separates_them(tmp_path):
    # Other bed joints have a smaller gap than the move of the corner.
    found = imported(tmp_path, wall(head=8, bed=1, off=3.5))
    joints = corrected_joints(found.blocks, JOINT, found.moves)
    assert joints.tolerance is None
    assert [i.name for i in joints.explicit] == ["0.1|1.1"]
    report = bs.detect_interfaces(found.blocks, JOINT, joints.tolerance, explicit=joints.explicit).report
    assert pairs(report.contacts) == {("slab", f"0.{k}") for k in range(4)} | {("0.1", "1.1")}
    # No moves close no joint.
    still = imported(tmp_path, wall(head=8, bed=1))
    joints = corrected_joints(still.blocks, JOINT, still.moves)
    assert (still.moves, joints.closed, joints.tolerance, joints.explicit) == ({}, (), None, ())


@pytest.mark.parametrize("seed", range(5))
def test_closed_joints_are_within_the_moves_of_their_blocks(tmp_path, seed):
    rng = np.random.default_rng(seed)
    text = wall(head=rng.uniform(0.1, 4), bed=rng.uniform(0.05, 1), off=rng.uniform(1, 4.5))
    found = imported(tmp_path, text)
    joints = corrected_joints(found.blocks, JOINT, found.moves)
    rounding = bs.detect_interfaces(found.blocks, JOINT).report.tolerances.gap
    report = bs.detect_interfaces(found.blocks, JOINT, joints.tolerance, explicit=joints.explicit).report
    for c in [*joints.closed, *(c for c in report.contacts if c.interface and not np.isnan(c.gap))]:
        moved = sum(float(np.abs(found.moves.get(name, 0.0)).max()) for name in (c.minus, c.plus))
        assert abs(c.gap) <= rounding + 4 * np.sqrt(3) * moved


def test_moves_that_open_no_joint_close_none(tmp_path):
    """Two blocks of general shape with one face in common, written to three decimals: it is moved alike."""
    lower = np.round(np.array(CUBE) @ rotation((1, 2, 0.5), 0.4).T * [1, 1.2, 0.9], 3)
    upper = np.concatenate([lower[4:], np.round(lower[4:] + 0.8 * (lower[4:] - lower[:4]), 3)])
    with pytest.warns(bs.errors.GeometryWarning, match="moved into the planes"):
        found = read(tmp_path, "two.obj", objects_text({"a": lower, "b": upper}))
    assert set(found.moves) == {"a", "b"}
    assert corrected_joints(found.blocks, JOINT, found.moves).closed == ()
