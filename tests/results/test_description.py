"""The description of a collapse, and the bodies that move."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.results import macro_blocks
from blockstruct.results.case_result import main_joints
from blockstruct.text.mechanism import STEPS_OF_PATH, STEPS_OF_PROGRAMS, motion_clause
from blockstruct.views import figures
from structures import model_of, push, single_block, solve

TUFF, LIME = bs.Material("tuff", "16 kN/m^3"), bs.JointMaterial("lime", 0.65)


def wall(**options):
    size = {"unit_length": "1.2 m", "unit_height": "0.5 m", "thickness": "0.5 m", "material": TUFF}
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
    (hinges,) = main_joints(result.history).values()
    assert len(hinges) == 5
    assert "33 of 33 free blocks move, 100% of the weight, as 1 body." in result.describe()
    assert "leans towards −y, turning about the axis along x through y = 0 m, z = 0 m." in result.describe()


@pytest.mark.parametrize(
    ("procedure", "words"),
    [("fictitious", STEPS_OF_PROGRAMS), ("loading path", STEPS_OF_PATH)],
)
def test_the_description_names_the_kind_of_its_iterations(procedure, words):
    result = solve(model_of(*single_block(0.5, 1.0)), push(1, 0, 0), "nonassociative", procedure=procedure)
    assert result.describe().endswith(words)


def test_an_arch_has_three_moving_bodies_and_four_hinges():
    blocks = bs.arch(span="3.64 m", thickness="0.36 m", depth="0.6 m", voussoirs=15, material=TUFF)
    model = model_of(blocks, LIME)
    loaded = next(b for b in blocks if b.name == "5")
    load = bs.LoadPattern("1 kN", [bs.PointLoad("5", bs.Q_(loaded.centroid, "m"), "[0, 0, -1] kN")])
    result = solve(model, load)
    bodies = macro_blocks(model, result.mechanism)
    assert sum(body.moves for body in bodies) == 3
    assert len(main_joints(result.history)["hinge"]) == 4
    # Two blocks rest: none of their joints is fast.
    assert sum(len(body.blocks) for body in bodies if not body.moves) == 2


def test_crushing_moves_the_axis_inwards():
    blocks, joint = single_block(1.0, 2.0, mu=2.0)
    model = model_of(blocks, joint.varied(compressive_strength="100 kPa"))
    result = solve(model, push(1, 0, 0))
    (body,) = macro_blocks(model, result.mechanism)
    # A weight of 40 kN on 1 m × 1 m of 100 kPa: the last 0.4 m before the edge crush.
    _, point = body.axis
    assert point[0] == pytest.approx(0.6, abs=1e-4)
    assert main_joints(result.history)["crushing"] == ["ground|block"]


def test_carried_weights_count_as_in_the_participating_mass():
    """A roof of 10 kN/m on the middle of a wall of 0.5 × 3 m, 6 m long; an eighth of a load of 8 kN has mass."""
    roof = bs.LineLoad("10 kN/m", start=["0 m", "0.25 m", "3 m"], end=["6 m", "0.25 m", "3 m"])
    lamp = bs.Weight("6.1", point=["0.5 m", "0.25 m", "3 m"], weight="8 kN", mass_share=1 / 8)
    result = solve(wall(), push(0, -1, 0), dead=bs.LoadPattern("dead", [bs.SelfWeight(), roof, lamp]))
    (body,) = result.macro_blocks
    assert (body.weight, body.carried) == pytest.approx((6 * 3 * 0.5 * 16e3, 60e3 + 1e3))
    site = bs.assess.ntc_spectrum("0.15 g_0", 2.4, "0.3 s", "B")
    assert bs.assess.local_mechanism(result, 1.35, site).participation.total == pytest.approx(body.total)
    assert "100% of the weight, carried weight included, as 1 body." in result.describe()
    assert [note.code for note in result.notes] == ["masses"]
    handles = figures.mechanism(result, colour="macro-block").get_legend().get_texts()
    assert "205 kN, 61 kN of it carried" in " ".join(label.get_text() for label in handles)


@pytest.mark.parametrize(
    ("translation", "axis", "words"),
    [
        (
            (0.99, 0.14, -0.3),
            (-0.14, 0.99, 0),
            "leans towards +x (99%), turning about an inclined axis near (1, 2, 3) m",
        ),
        ((0, -1, 0), (0, 0, 1), "swings towards −y, turning about the axis along z through x = 1 m, y = 2 m"),
    ],
)
def test_bodies_move_in_words(translation, axis, words):
    unit = np.array(axis) / np.linalg.norm(axis)
    assert motion_clause(np.array(translation), (unit, np.array([1.0, 2, 3])), np.zeros(3), 1.0) == words


def test_bodies_as_a_table_of_vectors():
    result = solve(model_of(*single_block(0.5, 1.0)), push(1, 0, 0))
    table, (body,) = result.bodies, result.macro_blocks
    assert table.loc["body 1", ["axis_x", "axis_z"]].to_list() == pytest.approx([0.5, 0.0], abs=1e-5)
    assert table.loc["body 1", "rotation_y"] == body.rotation[1]
    assert table.attrs["units"]["translation_x"] == "dimensionless"
