"""Blocks found by a point, and what a model says about itself."""

import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.structures import wall
from structures import STONE, extruded

DRY = bs.JointMaterial("dry", 0.6)
DEAD = bs.LoadPattern("dead", [bs.SelfWeight()])
PUSH = bs.LoadPattern("push +y", [bs.BodyForce("+y")])


@pytest.fixture(scope="module")
def model():
    blocks = wall(
        length="1.6 m", height="0.8 m", thickness="0.3 m", unit_length="0.8 m", unit_height="0.4 m", material=STONE
    )
    return bs.Model("wall", blocks, bs.detect_interfaces(blocks, joint_material=DRY))


def test_blocks_are_found_inside_and_on_faces_but_not_on_joints(model):
    middle = model.blocks[1]
    assert model.block_at(Q_(middle.centroid, "m")) is middle
    assert model.block_at(Q_(middle.centroid * [1, 0, 1], "m")) is middle
    # A free block counts before the support below.
    assert model.block_at(Q_(middle.centroid * [1, 1, 0], "m")) is middle
    corner = middle.shape.vertices.max(axis=0) * [1, 0.5, 0.5]
    with pytest.raises(bs.errors.ModelError, match="on a joint of"):
        model.block_at(Q_(corner, "m"))
    with pytest.raises(bs.errors.ModelError, match="the nearest is"):
        model.block_at("[5, 5, 5] m")


def test_notch_of_a_block_that_is_not_convex_is_outside():
    ell = extruded("ell", [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], 0.0, 1.0)
    base = bs.Block.box("base", Q_([0, 0, -1], "m"), Q_([2, 2, 1], "m"), STONE, fixed=True)
    model = bs.Model("ell", [base, ell], bs.detect_interfaces([base, ell], joint_material=DRY))
    assert model.block_at("[0.5, 1.5, 0.5] m") is ell
    with pytest.raises(bs.errors.ModelError, match="in no block"):
        model.block_at("[1.5, 1.5, 0.5] m")


def test_points_alone_equal_points_of_named_blocks(model, tmp_path):
    at, top = Q_([0.4, 0.15, 0.2], "m"), Q_([0.6, 0, 0.8], "m")
    first, last = model.block_at(at).name, model.block_at(top).name
    runs = []
    for names in ({}, {"block": last}):
        ends = {"start": at, "end": top} if not names else {"start": (first, at), "end": (last, top)}
        tied = model.with_ties([bs.Tie("tie", **ends, yield_force="1 kN")])
        loads = [bs.SelfWeight(), bs.Weight(point=top, weight="2 kN", **names)]
        loads.append(bs.PointLoad(point=top, force="[0, 0, -1] kN", **names))
        control = ((last, "+y") if names else "+y",)
        case = bs.Pushover("p", bs.LoadPattern("dead", loads), PUSH, control=control[0], control_point=top, steps=3)
        bs.write_document(tmp_path / f"{len(runs)}.yaml", tied, [case])
        assert bs.read_document(tmp_path / f"{len(runs)}.yaml").cases == (case,)
        runs.append(bs.run(tied, [case])["p"])
    assert runs[0].model.ties == runs[1].model.ties
    assert runs[0].case.control == runs[1].case.control == (last, (0.0, 1.0, 0.0))
    assert runs[0].load_factor == runs[1].load_factor


def test_points_off_the_blocks_name_what_stands_there(model):
    with pytest.raises(bs.errors.ModelError) as caught:
        model.with_ties([bs.Tie("tie", "[9, 0, 0] m", "[0.6, 0, 0.8] m", yield_force="1 kN")])
    assert "tie 'tie'" in "".join(caught.value.__notes__)
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), bs.Weight(point="[9, 0, 0] m", weight="1 kN")])
    with pytest.raises(bs.errors.ModelError) as caught:
        bs.run(model, [bs.LimitCase("c", dead, PUSH)])
    assert "'dead'" in "".join(caught.value.__notes__)
    with pytest.raises(bs.errors.ModelError, match="control_point"):
        bs.Pushover("p", DEAD, PUSH, control="+y")


def test_model_tells_its_weight_and_size(model):
    assert model.weight == pytest.approx(1.6 * 0.3 * 0.8 * STONE.unit_weight)
    assert model.quantity("weight").units == bs.units.ureg.newton
    assert "1.6 × 0.3 × 0.8 m" in model.summary()
