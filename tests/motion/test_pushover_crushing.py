"""Pushovers of joints that crush against hand calculations.

Lengths in m; x along the push, z up; W the weight, f the strength. Under W a block b wide and t deep crushes over
``a = W / (f t)`` from its edge, and turns about the end of this part by θ. The forces act at ``a / 2`` from the edge.
"""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.analysis import StepDone
from structures import SELF_WEIGHT, beam_on_ledges, bonded, box, extruded, model_of, push, single_block, stopping

#: Friction that does not slide, and adds little to the resistance of crushed cells at different heights.
FRICTION = 0.3
#: Load factors, of about 0.19, are exact to this: the elastic part of the first states takes up to 0.4 %, and friction
#: between cells at different heights adds 0.1 %.
EXACT = 1e-3


def joint(strength=None):
    return bs.JointMaterial("joint", FRICTION, compressive_strength=strength and Q_(strength, "MPa"))


def pier(strength=None, names=("ground", "lower", "upper")):
    """Two blocks of 0.3 × 0.8 m, in an order of their names."""
    blocks = {
        "ground": box("ground", [-1, -1, -0.5], [2.3, 3, 0.5], fixed=True),
        "lower": box("lower", [0, 0, 0], [0.3, 1, 0.8]),
        "upper": box("upper", [0, 0, 0.8], [0.3, 1, 0.8]),
    }
    return model_of([blocks[name] for name in names], joint(strength))


def run(model, direction=(1, 0, 0), cells=64, control="upper", **more):
    case = bs.Pushover("push", SELF_WEIGHT, push(*direction), control=(control, direction), **{"steps": 20} | more)
    return bs.run(model, case, settings=bs.ProcedureSettings(crushing_cells=cells))["push"]


def turned(curve, block):
    return np.abs(curve["rotation"].sel(block=block, axis="y").to_numpy())


def along(result, other):
    """Load factors of one curve at the displacements of another."""
    curve, at = result.capacity, other.capacity["displacement"]
    return np.interp(at, curve["displacement"], curve["load_factor"])


@pytest.fixture(scope="module")
def rocking():
    blocks, _ = single_block(0.3, 1.5)
    return run(model_of(blocks, joint(0.5)), control="block")


@pytest.fixture(scope="module")
def crushed_pier():
    return run(pier(0.5))


def test_a_block_turns_about_the_end_of_its_stress_block(rocking):
    """``α = tan(atan((b − a) / h) − θ)``."""
    curve, a = rocking.capacity, 9e3 / 0.5e6
    angle = turned(curve, "block")
    expected = np.tan(np.arctan((0.3 - a) / 1.5) - angle)
    assert curve["load_factor"].to_numpy() == pytest.approx(expected, abs=EXACT)
    assert curve["load_factor"].to_numpy()[5:] == pytest.approx(expected[5:], abs=3e-4)
    assert rocking.load_factor == pytest.approx((0.3 - a) / 1.5, rel=1e-6)
    assert np.tan(angle[-1]) == pytest.approx((0.3 - a) / 1.5, rel=2e-3)
    # Not crushed, it turns about its edge: d0 is half of its width.
    pole = 0.15 - a
    assert float(curve["d0"]) == pytest.approx(0.75 * np.sin(angle[-1]) + pole * (1 - np.cos(angle[-1])), rel=2e-3)


def test_the_lost_depth_grows_from_the_end_of_the_stress_block(rocking):
    """A point at x from there is crushed by ``x sin θ``; each cell by the depth at its centre."""
    curve, a = rocking.capacity, 9e3 / 0.5e6
    late = turned(curve, "block") > 1e-2
    edge = curve["crushed_depth"].max("cell").to_numpy()[late]
    # The outer row of 8 is ``(1 − cos(π / 8)) / 2`` of the width.
    centre = a - 0.3 * (1 - np.cos(np.pi / 8)) / 4
    assert edge == pytest.approx(centre * np.sin(turned(curve, "block")[late]), abs=4e-5)
    assert (np.diff(curve["crushed_depth"], axis=0) >= 0).all()
    assert curve["largest_crushed_depth"].to_numpy()[late] == pytest.approx(edge, rel=1e-6)
    assert curve["penetration"].max() < 1e-6


def test_energy_and_certificates(rocking, crushed_pier):
    """The first steps miss more, relative to the little work so far: their joints are partly elastic."""
    for result in (rocking, crushed_pier):
        missed = result.capacity["energy_error"].to_numpy()
        assert missed.max() < 5e-3
        assert missed[5:].max() < 1e-3
        assert result.capacity["holds"].all()


def test_crushing_takes_up_work(rocking):
    """Work of the loads is the work of crushing: there is no slip, and the block rests on its stress block."""
    curve = rocking.capacity
    crushed = 0.5e6 * 1.0 * (9e3 / 0.5e6) ** 2 / 2 * np.sin(turned(curve, "block")[-1])
    d, alpha = curve["displacement"].to_numpy(), curve["load_factor"].to_numpy()
    height = curve["position"].sel(block="block", axis="z").to_numpy()
    work = 9e3 * (np.sum(np.diff(d) * (alpha[1:] + alpha[:-1]) / 2) - (height[-1] - height[0]))
    assert work == pytest.approx(crushed, rel=0.05)


def test_a_block_that_turns_far():
    """Beyond 30° the side of a cube looks at the ground, and meets it only at the edge that its cells stand for."""
    blocks, _ = single_block(1.0, 1.0)
    rough = bs.JointMaterial("rough", 1.2, compressive_strength="0.5 MPa")
    curve = run(model_of(blocks, rough), control="block").capacity
    angle = turned(curve, "block")
    assert angle[-1] > np.radians(40)
    # Friction of 1.2 between cells at different heights.
    assert curve["load_factor"].to_numpy() == pytest.approx(np.tan(np.arctan(0.96) - angle), abs=1.5e-3)
    assert curve["energy_error"][5:].max() < 1e-3


@pytest.mark.parametrize(
    ("names", "direction", "steps"),
    [("upper lower ground", 1, 20), ("ground lower upper", -1, 20), ("ground lower upper", 1, 40)],
    ids=["renumbered", "mirrored", "half the steps"],
)
def test_the_same_curve(crushed_pier, names, direction, steps):
    other = run(pier(0.5, names.split()), (direction, 0, 0), steps=steps)
    assert along(crushed_pier, other) == pytest.approx(other.capacity["load_factor"].to_numpy(), abs=2e-4)


@pytest.mark.parametrize(("cells", "off"), [(64, EXACT), (16, 1.5e-3), (256, EXACT)])
def test_a_pier_of_two_blocks(crushed_pier, cells, off):
    curve = (crushed_pier if cells == 64 else run(pier(0.5), cells=cells)).capacity
    for block in ("lower", "upper"):
        expected = np.tan(np.arctan((0.3 - 9.6e3 / 0.5e6) / 1.6) - turned(curve, block))
        assert curve["load_factor"].to_numpy() == pytest.approx(expected, abs=off)


def test_great_strength_is_no_limit():
    """Stress blocks of 0.02 mm: the curve is that of joints that do not crush."""
    strong, rigid = run(pier(500)), run(pier())
    assert along(rigid, strong) == pytest.approx(strong.capacity["load_factor"].to_numpy(), abs=EXACT)
    assert float(strong.capacity["d0"]) == pytest.approx(float(rigid.capacity["d0"]), rel=1e-4)
    assert "crushed_depth" not in rigid.capacity


def test_joints_that_are_no_rectangles():
    """A triangular prism pushed over an edge: at rest the load factor of a limit case, whose cells are on its side."""
    ground = box("ground", [-1, -1, -0.5], [3, 3, 0.5], fixed=True)
    blocks = [ground, extruded("block", [(0, 0), (0.4, 0.4), (0, 0.8)], 0, 1.5)]
    result = run(model_of(blocks, joint(0.5)), (-1, 0, 0), control="block")
    first = float(result.capacity["load_factor"][0])
    assert first == pytest.approx(result.load_factor, rel=0.05)
    assert first > 0.995 * result.load_factor


@pytest.mark.parametrize("direction", [(0, 1, 0), pytest.param((1, 0, 0), marks=pytest.mark.slow)])
def test_walls_begin_at_the_limit_case(direction):
    """Walls pushed across and in their plane lose 1 to 2 % of their load factor."""
    blocks = bonded(3, 6, material=bs.Material("tuff", "12 kN/m^3"))
    crushes = model_of(blocks, bs.JointMaterial("lime", 0.65, compressive_strength="0.5 MPa"))
    control = blocks[-1].name
    result = run(crushes, direction, control=control)
    rigid = run(model_of(blocks, bs.JointMaterial("lime", 0.65)), direction, control=control)
    assert float(result.capacity["load_factor"].max()) == pytest.approx(result.load_factor, rel=0.01)
    assert float(result.capacity["d0"]) < float(rigid.capacity["d0"])


def test_a_support_that_sinks():
    """A beam of 4 m and 48 kN on ledges of 0.5 m, both of which crush: by moments about the right resultant.

    ``R (3.5 + a / 2 − c / 2) = W (1.5 + a / 2)``, where the stress blocks are ``a = (W − R) / f`` and ``c = R / f``.
    """
    model = model_of(beam_on_ledges().blocks, joint(0.5))
    case = bs.SettlementCase("sinks", SELF_WEIGHT, ["left"], "-z", displacement="20 mm", steps=10)
    result = bs.run(model, case)["sinks"]
    W, f, R = 48e3, 0.5e6, 20e3
    for _ in range(20):
        R = W * (1.5 + (W - R) / f / 2) / (3.5 + (W - R) / f / 2 - R / f / 2)
    assert result.reaction.magnitude == pytest.approx(R, rel=1e-6)
    assert result.capacity["reaction"].to_numpy() == pytest.approx(R, rel=5e-3)
    assert result.curve_outcome.end == "displacement_reached"


def test_it_is_kept_interrupted_and_resumed(tmp_path, crushed_pier):
    path = tmp_path / "pier.h5"
    bs.run(pier(0.5), crushed_pier.case, path, listeners=[stopping(StepDone, at=11)])
    assert bs.open_analysis(path)["push"].status == "interrupted"
    again = bs.AnalysisManager.resume(path)["push"].capacity.drop_vars("solver_time")
    assert again.identical(crushed_pier.capacity.drop_vars("solver_time"))


def test_rounded_corners_are_refused():
    with pytest.raises(bs.errors.ModelError, match=r"strength of 500000 Pa, and corner_rounding is 0\.01 m"):
        run(pier(0.5), corner_rounding="10 mm")
