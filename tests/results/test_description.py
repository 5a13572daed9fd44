"""A collapse in words, and the bodies that move."""

from dataclasses import replace

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.results import macro_blocks
from blockstruct.results.description import _motion, describe
from blockstruct.views import figures
from structures import SELF_WEIGHT, model_of, moved, push, single_block, solve

TUFF, LIME = bs.Material("tuff", "16 kN/m^3"), bs.JointMaterial("lime", 0.65)


def wall(**options):
    size = {"unit_length": "1.2 m", "unit_height": "0.5 m", "depth": "0.5 m", "material": TUFF}
    return model_of(bs.wall(length="6 m", courses=6, **size, **options), LIME)


def test_a_wall_out_of_plane_is_one_body_about_its_edge():
    model = wall()
    result = solve(model, push(0, -1, 0))
    (body,) = macro_blocks(model, result.mechanism)
    assert len(body.blocks) == len(model.blocks) - 1
    assert body.weight == pytest.approx(6 * 3 * 0.5 * 16e3)
    np.testing.assert_allclose(body.centroid, [3, 0.25, 1.5], atol=1e-9)
    direction, point = body.axis
    np.testing.assert_allclose(abs(direction), [1, 0, 0], atol=1e-6)
    np.testing.assert_allclose(point[1:], [0, 0], atol=1e-5)
    text = describe(model, result.history)
    assert "33 of 33 free blocks move, 100% of the weight, as 1 body." in text
    assert "turns about the axis along x through y = 0 m, z = 0 m" in text
    assert "Hinges: 5, first base|1." in text
    assert "not a step of loading" in text


def test_iterations_along_the_loading_path_are_steps_of_displacement():
    model = model_of(*single_block(0.5, 1.0))
    plain, path = (solve(model, push(1, 0, 0), "nonassociative", procedure=p) for p in ("fictitious", "loading path"))
    for result, said, caption in (
        (plain, "a numerical step, not a step of loading", "numerical steps, not steps of load"),
        (path, "the loading path are steps of displacement", "steps of displacement along the loading path"),
    ):
        assert said in result.describe()
        (drawn,) = [d.caption for d in figures.drawings(result) if d.name == "convergence"]
        assert drawn.endswith(caption)


def test_the_motion_of_a_run_without_an_end_is_no_result():
    """That every block moves was told of an iteration as of a collapse."""
    model = model_of(*single_block(0.5, 1.0))
    words = "the last iteration, which is no result."
    for programs, said in ((2, True), (120, False)):
        result = solve(model, push(1, 0, 0), "nonassociative", procedure="fictitious", max_programs=programs)
        assert (result.status == "not_converged") is said
        assert (words in result.describe()) is said
        assert "1 of 1 free block moves" in result.describe()


def test_a_low_block_slides_without_turning():
    model = model_of(*single_block(2.0, 1.0, mu=0.3))
    text = describe(model, solve(model, push(1, 0, 0), "nonassociative").history)
    assert "moves towards +x without turning" in text
    assert "Sliding joints: " in text
    assert "Hinges" not in text


def test_the_centroid_of_a_block_that_twists_about_it_stays():
    couple = bs.LoadPattern("couple", [bs.Moment("block", ["0 N m", "0 N m", "1 kN m"])])
    model = model_of(*single_block(1.0, 0.5, mu=0.6))
    text = describe(model, solve(model, couple, "nonassociative").history)
    assert "turns about the axis along z" in text
    assert "its centroid stays." in text


def test_an_arch_has_three_moving_bodies_and_four_hinges():
    blocks = bs.arch(span="3.64 m", thickness="0.36 m", depth="0.6 m", voussoirs=15, material=TUFF)
    model = model_of(blocks, LIME)
    loaded = next(b for b in blocks if b.name == "5")
    load = bs.LoadPattern("1 kN", [bs.PointLoad("5", bs.Q_(loaded.centroid, "m"), "[0, 0, -1] kN")])
    result = solve(model, load)
    bodies = macro_blocks(model, result.mechanism)
    assert sum(body.moves for body in bodies) == 3
    assert "Hinges: 4, first" in describe(model, result.history)
    # Two rest: they are fast at none of their joints.
    assert sum(len(body.blocks) for body in bodies if not body.moves) == 2


def test_crushing_moves_the_axis_inwards():
    blocks, joint = single_block(1.0, 2.0, mu=2.0)
    model = model_of(blocks, joint.varied(compressive_strength="100 kPa"))
    result = solve(model, push(1, 0, 0))
    (body,) = macro_blocks(model, result.mechanism)
    # A weight of 40 kN on 1 m × 1 m of 100 kPa: the last 0.4 m before the edge crush.
    _, point = body.axis
    assert point[0] == pytest.approx(0.6, abs=1e-4)
    assert "Crushing joints: ground|block." in describe(model, result.history)


def test_an_axis_is_where_it_is_however_far_from_the_origin():
    """Levels above the sea: to three digits the axis at 312.75 m would lie within the block, at 313 m."""
    blocks, joint = single_block(0.5, 3.0)
    model = model_of(moved(blocks, np.eye(3), (25.164, 0, 312.75)), joint)
    text = describe(model, solve(model, push(1, 0, 0)).history)
    assert "turns about the axis along y through x = 25.66 m, z = 312.75 m" in text


def test_what_blocks_carry_counts_as_in_the_mass_that_takes_part():
    """A roof of 10 kN/m on the middle of a wall of 0.5 × 3 m, 6 m long; an eighth of a load of 8 kN has mass."""
    model = wall()
    roof = bs.LineLoad("10 kN/m", start=["0 m", "0.25 m", "3 m"], end=["6 m", "0.25 m", "3 m"])
    lamp = bs.Weight("6.1", point=["0.5 m", "0.25 m", "3 m"], weight="8 kN", mass_share=1 / 8)
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), roof, lamp])
    result = solve(model, push(0, -1, 0), dead=dead)
    (body,) = result.macro_blocks
    assert body.weight == pytest.approx(6 * 3 * 0.5 * 16e3)
    assert body.carried == pytest.approx(60e3 + 1e3)
    site = bs.assess.ntc_spectrum("0.15 g_0", 2.4, "0.3 s", "B")
    assert bs.assess.local_mechanism(result, 1.35, site).participation.total == pytest.approx(body.total)
    assert "100% of the weight with what blocks carry, as 1 body." in result.describe()
    assert "; 100% of that weight)" in result.describe()
    assert result.macro_blocks[0].total == macro_blocks(model, result.mechanism, dead=dead)[0].total
    handles = figures.mechanism(result, colour="macro-block").get_legend().get_texts()
    assert "205 kN, 61 kN of it carried" in " ".join(text.get_text() for text in handles)


def test_a_result_describes_itself_even_without_a_mechanism():
    blocks, joint = single_block(1.0, 2.0)
    model = model_of(blocks, joint)
    assert solve(model, push(1, 0, 0)).describe().startswith("case: collapses at load factor 0.5")
    lifted = solve(model, push(0, 0, -1))
    assert lifted.describe().startswith("case: never collapses")
    assert "bod" not in lifted.describe()


def test_what_a_solver_leaves_of_a_zero_is_not_told_of_an_axis():
    """A wall of 7 m that turns about y = 30 mm at its base, which the solver gives 1 µm above it."""
    tall = model_of(*single_block(0.5, 7.0))
    (body,) = macro_blocks(tall, solve(tall, push(1, 0, 0)).mechanism)
    centroid = np.array([0.25, 0.25, 3.5])
    turn, arm = np.array([1.0, 0.0, 0.0]), centroid - np.array([0.25, 0.03, 1e-6])
    slightly = replace(body, centroid=centroid, rotation=turn, translation=np.cross(turn, arm))
    assert "through y = 0.03 m, z = 0 m" in _motion(slightly)


def test_one_block_moves_and_several_move():
    model = model_of(*single_block(0.5, 1.0))
    found = bs.run(model, [bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))])
    assert repr(model).endswith(": 2 blocks, 1 fixed, 1 interface>")
    assert str(found).splitlines()[0].endswith(": 2 blocks, 1 interface")
    assert "1 of 1 free block moves, 100% of the weight, as 1 body." in found["push"].describe()
