"""Supports that hold some motions only.

A wall of thickness t is cracked at the height a, its upper part of height c. A roller holds the centroid of the upper
part horizontally. Pushed by α times its weight, the lower part turns about its toe by θ, and the upper part the other
way by ``2 a θ / c`` about the inner edge of the crack. The virtual work of their weights gives
``α = t (3 a + 2 c) / a²``. Moments of the upper part W about that edge give the reaction ``−W (α + t / c)``.
"""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from refusals import refused
from structures import SELF_WEIGHT, STONE, beam_on_ledges, box, kept, model_of, moved, push, rotation

THICKNESS, LOWER, UPPER = 0.3, 1.2, 1.0
ALPHA = THICKNESS * (3 * LOWER + 2 * UPPER) / LOWER**2
REACTION = -20e3 * THICKNESS * UPPER * (ALPHA + THICKNESS / UPPER)


def wall(motions=("x",), friction=0.7, R=None, shift=(0, 0, 0), **joint):
    blocks = [
        box("ground", [-1, -1, -0.5], [3, 3, 0.5], fixed=True),
        box("lower", [0, 0, 0], [THICKNESS, 1, LOWER]),
        box("upper", [0, 0, LOWER], [THICKNESS, 1, UPPER], fixed=motions),
    ]
    blocks = blocks if R is None else moved(blocks, R, shift)
    return model_of(blocks, bs.JointMaterial("joint", friction, **joint))


def solve(model, direction=(1, 0, 0), flow="nonassociative", **settings):
    case = bs.LimitCase("push", SELF_WEIGHT, push(*direction), flow)
    return bs.run(model, case, settings=bs.ProcedureSettings(**settings))["push"]


OTHERS = [{"path_steps": "interior point"}, {"procedure": "fictitious"}, {"procedure": "shifted"}]


@pytest.mark.parametrize("settings", [{"flow": "associative"}, {}, *OTHERS], ids=str)
def test_a_wall_held_at_its_head(settings):
    result = solve(wall(), **settings)
    assert (result.status, result.certificate.holds) == ("converged", True)
    assert result.load_factor == pytest.approx(ALPHA, rel=1e-5)
    reactions = result.support_reactions
    np.testing.assert_allclose(reactions.force.sel(support="upper"), [REACTION, 0, 0], rtol=1e-4)
    assert not reactions.moment.sel(support="upper").any()
    # The ground carries all weights, and the roller what the ground does not.
    weight = 20e3 * THICKNESS * (LOWER + UPPER)
    np.testing.assert_allclose(reactions.force.sum("support"), [-result.load_factor * weight, 0, weight], atol=1)
    np.testing.assert_allclose(result.mechanism.translation.sel(block="upper", axis="x"), 0, atol=1e-12)


@pytest.mark.parametrize("joint", [{"compressive_strength": "4 MPa"}, {"torsion": "uniform pressure"}], ids=str)
def test_other_joints_are_certified_on_a_roller(joint):
    result = solve(wall(**joint))
    assert result.certificate.holds
    assert result.load_factor <= ALPHA * (1 + 1e-5)
    assert result.load_factor > 0.9 * ALPHA


def test_the_number_does_not_depend_on_the_frame():
    turned = solve(wall(("y",), R=rotation([0, 0, 1], np.pi / 2), shift=(30, -40, 7)), (0, 1, 0))
    assert turned.load_factor == pytest.approx(ALPHA, rel=1e-5)
    reaction = turned.support_reactions.force.sel(support="upper")
    np.testing.assert_allclose(reaction, [0, REACTION, 0], rtol=1e-4, atol=1e-9)


def test_a_block_held_in_all_motions_is_fixed():
    block = box("b", [0, 0, 0], fixed=("rz", "z", "ry", "y", "rx", "x"))
    assert (block.fixed, block.is_roller, block.held) == (True, False, box("b", [0, 0, 0], fixed=True).held)
    assert repr(block).endswith("fixed=True)")
    assert repr(box("b", [0, 0, 0], fixed=["z", "x"])).endswith("fixed=('x', 'z'))")


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
@pytest.mark.parametrize(("direction", "alpha"), [((1, 0, 0), 0.0), ((0, 1, 0), 0.4)])
def test_a_cube_slides_free_on_a_roller(direction, alpha, flow):
    """The roller below moves along x alone: the only support of the structure."""
    blocks = [box("roller", [0, 0, 0], fixed=("y", "z", "rx", "ry", "rz")), box("cube", [0, 0, 1])]
    # Nothing resists a motion along x: a loading path has no elastic state to begin with, and warns.
    result = solve(model_of(blocks, bs.JointMaterial("joint", 0.4)), direction, flow)
    assert result.certificate.holds
    assert result.load_factor == pytest.approx(alpha, abs=1e-3)
    assert float(result.support_reactions.force.sel(support="roller", axis="z")) == pytest.approx(40e3)


def test_an_arch_on_a_roller_spreads():
    """A roller carries no thrust: the arch that stands between fixed abutments falls."""
    blocks = bs.arch(span="1.8 m", thickness="0.2 m", depth="1 m", voussoirs=9, material=STONE)
    right = next(k for k, b in enumerate(blocks) if b.name == "right")
    assert solve(model_of(blocks, bs.JointMaterial("joint", 0.6))).status == "converged"
    shape = blocks[right].shape
    along_x, about_z = ("y", "z", "rx", "ry", "rz"), ("x", "y", "z", "rx", "ry")
    for motions, status in ((along_x, "unstable_under_dead_load"), (about_z, "converged")):
        blocks[right] = bs.Block.from_faces("right", Q_(shape.vertices, "m"), shape.faces, STONE, fixed=motions)
        assert solve(model_of(blocks, bs.JointMaterial("joint", 0.6))).status == status


def test_a_settlement_beside_a_roller():
    """The beam of test_settlement.py, its other ledge free to move along its axis."""
    left, _, on = beam_on_ledges().blocks
    right = box("right", [3.5, 0, -0.3], [0.5, 1, 0.3], fixed=("y", "z", "rx", "ry", "rz"))
    model = model_of([left, right, on], bs.JointMaterial("joint", 0.6))
    result = bs.run(model, bs.SettlementCase("case", SELF_WEIGHT, ["left"], "-z"))["case"]
    assert result.certificate.holds
    assert result.reaction.to("N").magnitude == pytest.approx(48e3 * 1.5 / 3.5, rel=1e-6)
    reactions = result.support_reactions.force.sel(axis="z")
    assert float(reactions.sum()) == pytest.approx(48e3 + 20e3 * 0.15, rel=1e-6)


def test_finite_motions_refuse_rollers():
    model = wall()
    pushover = bs.Pushover("over", SELF_WEIGHT, push(1, 0, 0), control=("lower", (1, 0, 0)))
    with refused(bs.errors.ModelError, "'over' upper some motions only touches joint friction 0 LimitCase"):
        bs.run(model, pushover)
    with refused(bs.errors.ModelError, "'push' upper some motions only"):
        bs.assess.local_mechanism(solve(model), 1.35, bs.assess.ntc_spectrum("0.1 g_0", 2.4, "0.3 s", "B"))


@pytest.mark.parametrize("motions", ["no", ("x", "q"), ("",), 1, [["x"]], None], ids=str)
def test_bad_motions_are_refused(motions):
    with refused(bs.errors.ModelError, "'b' fixed True False x, y, z, rx, ry, rz"):
        box("b", [0, 0, 0], fixed=motions)


def test_files_and_documents_keep_the_motions(tmp_path):
    model = wall(("x", "ry"))
    stored = kept(model, bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0)), tmp_path)
    assert [b.held for b in stored.model.blocks] == [b.held for b in model.blocks]
    assert len({wall(motions).hash for motions in (False, ("x",), ("x", "ry"))}) == 3
    assert stored["push"].support_reactions.sizes["support"] == 2
