"""Pushovers against hand calculations.

Lengths in m; x along the push, z up; W the weight of a block and θ a rotation. Hinges do not slide: μ is 2 or more.
"""

from dataclasses import replace

import attrs
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import brentq

import blockstruct as bs
import structures
from blockstruct import Q_
from blockstruct.limit import LimitProblem
from blockstruct.motion.moving_problem import MovingProblem
from blockstruct.statics.moved import Placement
from blockstruct.statics.statics import Statics
from properties import slow_after
from structures import SELF_WEIGHT, STONE, block_on_a_bar, bonded, model_of, moved, push, rotation, single_block

ROUGH = bs.JointMaterial("rough", 2.0)


def box(name, x, z, *, fixed=False, depth=1.0):
    return structures.box(name, [x[0], 0, z[0]], [x[1] - x[0], depth, z[1] - z[0]], fixed=fixed)


def run(model, control, direction=(1, 0, 0), dead=SELF_WEIGHT, **more):
    case = bs.Pushover("push", dead=dead, variable=push(*direction), control=(control, direction), **more)
    return bs.run(model, case)["push"]


def turned(capacity, block):
    """Rotation of a block about y, rad."""
    return capacity["rotation"].sel(block=block, axis="y").to_numpy()


@pytest.fixture(scope="module")
def rocking():
    blocks, _ = single_block(0.3, 1.5)
    return run(model_of(blocks, ROUGH), "block")


def test_single_block(rocking):
    """A block b × h on its base: ``α(θ) = tan(atan(b / h) − θ)``, zero at θ = atan(b / h)."""
    curve = rocking.capacity
    expected = np.tan(np.arctan(0.3 / 1.5) - turned(curve, "block"))
    assert curve["load_factor"].to_numpy() == pytest.approx(expected, abs=1e-4)
    assert turned(curve, "block")[-1] == pytest.approx(np.arctan(0.2), abs=1e-4)
    # Its centroid is then above the edge it turns about, half of its width further on.
    assert float(curve["d0"]) == pytest.approx(0.15, rel=1e-5)
    assert rocking.status == "converged"
    assert rocking.load_factor == pytest.approx(0.2, rel=1e-6)
    assert "the load factor is zero" in rocking.curve_ended
    assert curve["energy_error"].max() < 1e-5
    assert curve["holds"].all()
    assert curve["penetration"].max() < 1e-6
    assert not bs.results.doubtful_parts(curve, rocking.settings.procedure)


def test_small_stones_among_large_blocks():
    """A cube of 5 cm between two blocks of 1 m; another stone, on one of them, slides at μ up to its edge."""
    blocks = [
        structures.box("ground", [-1, -1, -0.5], [8, 4, 0.5], fixed=True),
        structures.box("one", [0, 0, 0], [1, 1, 1.2]),
        structures.box("wedge", [1, 0.4, 0], [0.05] * 3),
        structures.box("other", [1.05, 0, 0], [0.5, 1, 0.8]),
        structures.box("cap", [0.2, 0.2, 1.2], [0.1, 0.05, 0.05]),
    ]
    curve = run(model_of(blocks, bs.JointMaterial("joint", 0.5)), "cap", steps=20).capacity
    load_factor, d = curve["load_factor"].to_numpy(), curve["displacement"].to_numpy()
    # Its centroid is above the edge of the block at 0.75 m. It tips a quarter of its height before.
    slides = d < 0.75 - 0.05 / 4
    assert d.max() > 0.7
    assert load_factor[slides] == pytest.approx(0.5, rel=1e-3)


def test_rocking_pier():
    """A pier b × h with a dead load N at the middle of its top, which moves with it.

    About the edge it turns on, with N at (b / 2, h) and the weight at (b / 2, h / 2) before:
    ``α W (h / 2 cos θ + b / 2 sin θ) = W (b / 2 cos θ − h / 2 sin θ) + N (b / 2 cos θ − h sin θ)``.
    """
    b, h, W, N = 0.5, 2.0, 20e3, 30e3
    blocks = [box("ground", (-1, 3), (-0.5, 0), fixed=True), box("pier", (0, b), (0, h))]
    dead = [bs.SelfWeight(), bs.PointLoad("pier", Q_([b / 2, 0.5, h], "m"), Q_([0, 0, -N], "N"))]
    curve = run(model_of(blocks, ROUGH), "pier", dead=bs.LoadPattern("dead", dead), steps=20).capacity
    angle = turned(curve, "pier")
    c, s = np.cos(angle), np.sin(angle)
    expected = (W * (b * c - h * s) + N * (b * c - 2 * h * s)) / (W * (h * c + b * s))
    assert curve["load_factor"].to_numpy() == pytest.approx(expected, abs=1e-4)
    # Zero where W (b − h tan θ) + N (b − 2 h tan θ) is.
    assert np.tan(angle[-1]) == pytest.approx((W + N) * b / (W * h + 2 * N * h), rel=1e-4)
    assert curve["energy_error"].max() < 1e-4


@pytest.mark.parametrize("steps", [20, pytest.param(60, marks=pytest.mark.slow)])
def test_three_hinges(steps):
    """A wall that spans from its base to a smooth restraint at its top, and cracks at half its height.

    Two panels b × h. The lower turns by θ about its edge (b, 0), away from the push; the crack closes at its edge M
    towards the push, ``M = (b − b cos θ + h sin θ, b sin θ + h cos θ)``; the upper one turns back by φ about M, and its
    face slides down the edge E of the restraint: ``(E − M)·(cos φ, sin φ) = b``. Virtual work of the weights and of the
    push, in each position: ``α = d(z_1 + z_2) / d(x_1 + x_2)`` of the centroids. At rest, with E at height 2 h, it is
    ``2 b / h``.
    """
    b, h, e = 0.3, 1.5, 2.9
    blocks = [
        box("ground", (-1, 2), (-0.5, 0), fixed=True),
        box("lower", (0, b), (0, h)),
        box("upper", (0, b), (h, 2 * h)),
        box("restraint", (b, b + 0.5), (e, 2 * h), fixed=True),
    ]
    smooth = {"restraint|*": bs.JointMaterial("smooth", 1e-6), "*": ROUGH}
    model = bs.Model("wall", blocks, bs.detect_interfaces(blocks, smooth))
    result = run(model, "lower", steps=steps)
    curve = result.capacity

    def hinge(angle):
        c, s = np.cos(angle), np.sin(angle)
        return b - b * c + h * s, b * s + h * c

    def back(angle):
        x, z = hinge(angle)
        return brentq(lambda phi: (b - x) * np.cos(phi) + (e - z) * np.sin(phi) - b, -1e-3, 1.0)

    def centroids(angle):
        """Sums of the centroids' x and z."""
        (x, z), phi = hinge(angle), back(angle)
        c, s = np.cos(angle), np.sin(angle)
        x1, z1 = b + (-b * c + h * s) / 2, (b * s + h * c) / 2
        x2, z2 = x + (b * np.cos(phi) - h * np.sin(phi)) / 2, z + (b * np.sin(phi) + h * np.cos(phi)) / 2
        return np.array([x1 + x2, z1 + z2])

    curve = curve.sel(step=curve["falls"] == 0)
    for angle, alpha in zip(turned(curve, "lower"), curve["load_factor"].to_numpy(), strict=True):
        dx, dz = centroids(angle + 1e-6) - centroids(angle - 1e-6)
        # The weights are lifted, by the work of the push.
        assert alpha == pytest.approx(dz / dx, abs=1e-3)
    # The weight of the upper panel has come behind M: without the restraint no push holds both panels.
    assert float(curve["load_factor"][-1]) < 0.03
    assert "the method ends" in result.curve_ended
    assert np.isnan(curve["d0"])
    assert curve["energy_error"].max() < 1e-4


def test_a_block_slides_until_it_overhangs():
    """A block b × h that slides on one as wide: ``α = μ`` until its resultant leaves the edge, at ``(b − μ h) / 2``."""
    b, h, mu = 0.6, 0.4, 0.3
    blocks = [box("lower", (0, b), (-0.5, 0), fixed=True), box("upper", (0, b), (0, h))]
    result = run(model_of(blocks, bs.JointMaterial("dry", mu)), "upper", steps=20)
    curve = result.capacity.sel(step=result.capacity["displacement"] < (b - mu * h) / 2 - 1e-3)
    assert curve.sizes["step"] > 5
    assert curve["load_factor"].to_numpy() == pytest.approx(mu, rel=1e-5)
    assert curve["dissipation"].to_numpy() == pytest.approx(mu, rel=1e-4)
    assert np.abs(turned(curve, "upper")).max() < 1e-6


@pytest.mark.parametrize(
    "slope", [pytest.param(18, marks=pytest.mark.slow), pytest.param(20, marks=pytest.mark.slow), 21]
)
def test_a_block_slides_down_a_slope_that_hardly_holds_it(slope):
    """``α = tan(atan μ − β)``: the dead load does up to thirty times the push's work, and friction takes all of it."""
    blocks = [box("ground", (-2, 4), (-0.5, 0), fixed=True), box("block", (0, 1), (0, 0.3))]
    tilted = moved(blocks, rotation((0, 1, 0), np.radians(slope)))
    result = run(model_of(tilted, bs.JointMaterial("dry", 0.4)), "block", steps=20)
    curve = result.capacity
    on = curve["displacement"].to_numpy() < 2.5
    assert on.sum() > 10
    expected = np.tan(np.arctan(0.4) - np.radians(slope))
    assert curve["load_factor"].to_numpy()[on] == pytest.approx(expected, abs=1e-6)
    assert result.curve_outcome.displacement > 2.5


def test_contacts_that_were_none_close():
    """A block slides until it meets a stop 0.1 m away, without an interface; there it turns over, at ``α = b / h``."""
    b, h, mu = 0.4, 0.5, 0.2
    blocks = [
        box("ground", (-1, 2), (-0.5, 0), fixed=True),
        box("block", (0, b), (0, h)),
        box("stop", (b + 0.1, b + 0.2), (0, 0.05), fixed=True),
    ]
    result = run(model_of(blocks, bs.JointMaterial("dry", mu)), "block", steps=20)
    curve = result.capacity
    before = curve.sel(step=curve["displacement"] < 0.099)
    assert before["load_factor"].to_numpy() == pytest.approx(mu, rel=1e-4)
    after = curve.sel(step=np.abs(curve["displacement"] - 0.1) < 1e-3)
    assert float(after["load_factor"].max()) > 2 * mu
    assert float(curve["penetration"].max()) < 1e-3
    rise, jump, *_ = bs.results.doubtful_parts(curve, result.settings.procedure)
    last = curve.isel(step=int(curve["load_factor"].argmax("step")))
    top, where = float(last["load_factor"]), float(last["displacement"])
    assert where == pytest.approx(0.1, rel=1e-3)
    assert (rise.doubt, rise.load_factor, rise.displacement[1]) == ("rises", pytest.approx((mu, top)), where)
    assert jump.doubt in ("slips", "leaps")
    assert jump.load_factor[0] == pytest.approx(mu, rel=1e-3)


def elongated(angle):
    """Length of the tie of :func:`block_on_a_bar`, m, and its derivative by the rotation."""
    c, s = np.cos(angle), np.sin(angle)
    x, z = 2.5 - 0.5 * c + 1.5 * s, 0.5 * s + 1.5 * c - 1.5
    length = np.hypot(x, z)
    return length, (x * (0.5 * s + 1.5 * c) + z * (0.5 * c - 1.5 * s)) / length


def by_hand(angle, force):
    """Load factor of :func:`block_on_a_bar`, W = 20 kN, turned by θ about its edge, with T at a length ℓ of the tie.

    ``α W (h / 2 cos θ + b / 2 sin θ) = W (b / 2 cos θ − h / 2 sin θ) + T dℓ/dθ``, with the tie's end on the block at
    ``(b − b cos θ + z sin θ, b sin θ + z cos θ)``, z = 1.5 m: at rest ``α = b / h + 2 T z / (W h) = 0.25 + 0.3``.
    """
    c, s = np.cos(angle), np.sin(angle)
    return (20 * (0.25 * c - s) + force * elongated(angle)[1]) / (20 * (c + 0.25 * s))


def test_tie_that_breaks():
    """By hand until the bar is 0.1 m longer; then the block alone, ``tan(atan(b / h) − θ)``."""
    result = run(block_on_a_bar(), "block", steps=20)
    curve, angle = result.capacity, turned(result.capacity, "block")
    assert result.load_factor == pytest.approx(0.55, rel=1e-6)
    whole = elongated(angle)[0] <= 2.1
    assert 3 < whole.sum() < len(angle) - 3
    expected = np.where(whole, by_hand(angle, 4.0), np.tan(np.arctan(0.25) - angle))
    assert curve["load_factor"].to_numpy() == pytest.approx(expected, abs=1e-4)
    # The last state with the bar is that at which it breaks.
    assert elongated(angle[whole][-1])[0] == pytest.approx(2.1, abs=1e-3)
    assert turned(curve, "block")[-1] == pytest.approx(np.arctan(0.25), abs=1e-4)
    assert curve["energy_error"].max() < 1e-4


def test_a_block_that_nothing_is_near():
    """One that has fallen off its support has no contact points, and is none that ends a run with an error."""
    blocks, joint = single_block(0.3, 1.5)
    model = model_of(blocks, joint)
    case = bs.Pushover("push", dead=SELF_WEIGHT, variable=push(1, 0, 0), control=("block", (1, 0, 0)))
    statics = Statics.of(model)
    moving, rest = MovingProblem(statics, LimitProblem.of(statics, case), case), Placement.of(model)
    away = replace(rest, position=rest.position + np.array([[0, 0, 0], [50, 0, 0]]))
    assert moving.at(away, 0.01, *2 * [moving.lengths(rest)]).problem.n_points == 0


@pytest.mark.parametrize("parts", [1, 2])
def test_rounded_corners(parts):
    """A pier b × h of one or two blocks with corners of radius r rolls on its corner.

    Its weight W and the push α W act at the centre G, the ground at the point P below the centre C of the corner:
    ``C − G = (b / 2 − r, r − h / 2)`` at rest, turned by θ, and P is r below C. So
    ``α = ((b / 2 − r) cos θ − (h / 2 − r) sin θ) / ((b / 2 − r) sin θ + (h / 2 − r) cos θ + r)``; r = 0 gives that of
    sharp ones, and θ = 0 that of a base shorter by r at each end, ``α = (b − 2 r) / h``.
    """
    b, h, r = 0.4, 1.6, 0.02
    heights = np.linspace(0, h, parts + 1)
    blocks = [box("ground", (-1, 2), (-0.5, 0), fixed=True)]
    blocks += [box(f"block {i}", (0, b), heights[i : i + 2]) for i in range(parts)]
    top = blocks[-1].name
    result = run(model_of(blocks, ROUGH), top, steps=20, corner_rounding="20 mm")
    curve, angle = result.capacity, turned(result.capacity, top)
    c, s = np.cos(angle), np.sin(angle)
    x, z = b / 2 - r, h / 2 - r
    assert curve["load_factor"].to_numpy() == pytest.approx((x * c - z * s) / (x * s + z * c + r), abs=1e-6)
    # The state at rest is that of sharp corners, as of any limit case.
    assert result.load_factor == pytest.approx(b / h, rel=1e-6)
    assert "load factor is zero" in result.curve_ended
    assert curve["energy_error"].max() < 1e-4
    assert curve["penetration"].max() < 1e-5


def test_rounded_corners_leave_something():
    blocks, joint = single_block(0.3, 1.5)
    with pytest.raises(bs.errors.GeometryError, match=r"block 'block': the corner radius 0\.15 m"):
        run(model_of(blocks, joint), "block", corner_rounding="15 cm")


def test_invariance():
    """Turned about the vertical, moved away, and in other units of length and force."""
    blocks, _ = single_block(0.3, 1.5)
    plain = run(model_of(blocks, ROUGH), "block", steps=12).capacity
    R = rotation((0, 0, 1), 0.7)
    away = moved(blocks, R, (30, -20, 5))
    other = run(model_of(away, ROUGH), "block", direction=tuple(R[:, 0]), steps=12).capacity
    assert other["load_factor"].to_numpy() == pytest.approx(plain["load_factor"].to_numpy(), abs=1e-6)
    assert other["displacement"].to_numpy() == pytest.approx(plain["displacement"].to_numpy(), rel=1e-5, abs=1e-9)
    scaled = run(model_of(moved(blocks, 1e3 * np.eye(3)), ROUGH), "block", steps=12).capacity
    assert scaled["load_factor"].to_numpy() == pytest.approx(plain["load_factor"].to_numpy(), abs=1e-6)
    assert scaled["displacement"].to_numpy() / 1e3 == pytest.approx(
        plain["displacement"].to_numpy(), rel=1e-5, abs=1e-9
    )


def test_control_point():
    """The top of a block goes further than its centroid."""
    blocks, _ = single_block(0.3, 1.5)
    top = run(model_of(blocks, ROUGH), "block", control_point=Q_([0.3, 0.5, 1.5], "m"), steps=12)
    # The edge (0.3, 0), θ = atan(0.2): the point straight above it comes to 1.5 m times sin θ.
    assert float(top.capacity["d0"]) == pytest.approx(1.5 * np.sin(np.arctan(0.2)), rel=1e-4)
    assert top.case.control_point == (0.3, 0.5, 1.5)


@pytest.mark.parametrize("direction", [(0, 1, 0), (1, 0, 0)])
def test_a_control_point_at_rest_has_no_curve(direction):
    """Two towers, the slender one of which rocks: the other one does not move, nor does either across the push."""
    tall, low = box("tall", (0, 0.3), (0, 1.5)), box("low", (2, 2.5), (0, 1))
    model = model_of([box("ground", (-1, 4), (-0.5, 0), fixed=True), tall, low], ROUGH)
    control = ("low" if direction[0] else "tall", direction)
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=control, steps=5)
    result = bs.run(model, case)["push"]
    assert result.status == "converged"
    assert result.load_factor == pytest.approx(0.2, rel=1e-6)
    assert result.capacity is None
    assert "does not move along" in result.curve_ended
    assert "block 'tall' moves furthest, along (0.981, 0, 0.196)" in result.curve_ended


def test_a_control_point_that_comes_back():
    """Of the top 0.2 m behind the toe: it rises until ``tan θ = 0.2 / 1.5``, and sinks before ``tan θ = 0.2``."""
    blocks, _ = single_block(0.3, 1.5)
    control = {"control": ("block", "+z"), "control_point": Q_([0.1, 0.5, 1.5], "m")}
    case = bs.Pushover("push", dead=SELF_WEIGHT, variable=push(1, 0, 0), **control, steps=12)
    result = bs.run(model_of(blocks, ROUGH), case)["push"]
    curve, angle = result.capacity, np.arctan(0.2)
    assert float(curve["d0"]) == pytest.approx(1.5 * np.cos(angle) + 0.2 * np.sin(angle) - 1.5, rel=1e-3)
    assert 10 <= curve.sizes["step"] <= 30
    assert "where the control point at block 'block' stands still or goes back" in result.curve_ended
    # Its centroid is above the toe.
    assert "block 'block' moves furthest, along +x" in result.curve_ended


@pytest.mark.parametrize("point", [(5, 5, 50), (0.15, 0.5, 1.51), (-0.01, 0.5, 1)])
def test_a_control_point_outside_its_block_is_refused(point):
    """The box of the block is 0.3 m × 1 m × 1.5 m; a thousandth of the largest is rounding."""
    blocks, _ = single_block(0.3, 1.5)
    model = model_of(blocks, ROUGH)
    words = r"'push': control point .*'block' .*outside .*\[0\.0"
    with pytest.raises(bs.errors.ModelError, match=words):
        run(model, "block", control_point=Q_(point, "m"))
    assert run(model, "block", control_point=Q_([0.3005, 0.5, 1.5005], "m"), steps=5).capacity is not None


@pytest.mark.parametrize(("name", "vector"), [("+x", (1, 0, 0)), ("-y", (0, -1, 0)), (" +z ", (0, 0, 1))])
def test_directions_may_be_axes(name, vector):
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", name))
    assert case.control == ("block", vector)


@given(st.lists(st.floats(-1e30, 1e30, allow_subnormal=False), min_size=3, max_size=3))
def test_directions_are_unit_vectors_to_the_last_digit(components):
    assume(any(components))
    control = ("block", tuple(components))
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=control)
    assert np.linalg.norm(case.control[1]) == pytest.approx(1.0, abs=1e-12)
    assert attrs.evolve(case, control=case.control).control == case.control


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"control": "block"}, "give the name of a block and a direction"),
        ({"control": ("block", "x")}, "give the name of a block and a direction"),
        ({"control": ("block", (0, 0, 0))}, "give the name of a block and a direction"),
        ({"control": ("block", (1, np.nan, 0))}, "give the name of a block and a direction"),
        ({"control": ("block", (1, 0, 0)), "steps": 2}, "steps 2"),
        ({"control": ("block", (1, 0, 0)), "flow": "associative"}, "rise without end"),
        ({"control": ("block", (1, 0, 0)), "control_point": (0, 0, 0)}, "control_point"),
        ({"control": ("block", (1, 0, 0)), "corner_rounding": 0.02}, "corner_rounding: 0.02 has no unit"),
        ({"control": ("block", (1, 0, 0)), "corner_rounding": "-2 cm"}, "corner_rounding -0.02 m"),
    ],
)
def test_bad_input(more, said):
    with pytest.raises(bs.errors.BlockstructError, match=said):
        bs.Pushover("push", dead=SELF_WEIGHT, variable=push(1, 0, 0), **more)


@pytest.mark.parametrize(
    ("control", "joint", "said"),
    [
        ("nobody", ROUGH, "no block 'nobody'"),
        ("ground", ROUGH, "does not move"),
        ("block", bs.JointMaterial("mortar", 0.6, cohesion="0.1 MPa"), "cohesion of 100000 Pa"),
        ("block", bs.JointMaterial("rough", 0.6, dilatancy_angle="5 deg"), "dilatancy_angle of 0.0872665 rad, by"),
    ],
)
def test_what_a_pushover_does_not_know(control, joint, said):
    blocks, _ = single_block(0.3, 1.5)
    with pytest.raises(bs.errors.BlockstructError, match=said):
        run(model_of(blocks, joint), control)


@pytest.mark.parametrize("steps", [10, pytest.param(20, marks=pytest.mark.slow)])
def test_two_blocks_that_slide_apart_from_each_other(steps):
    """Nothing says which of two equal blocks goes: both do, as they began, for as many steps as are asked for."""
    blocks = [
        box("ground", (-1, 9), (-0.5, 0), fixed=True, depth=2.0),
        box("behind", (0, 1), (0, 0.3)),
        box("ahead", (1.1, 2.1), (0, 0.3)),
    ]
    model = model_of(blocks, bs.JointMaterial("dry", 0.3))
    curve = run(model, "behind", steps=steps).capacity
    gone = (curve["position"] - curve["position"][0]).sel(axis="x")
    assert float(gone.sel(block="behind").max()) > 5.0
    slides = (gone.sel(block="behind") < 5).to_numpy()
    one, other = (gone.sel(block=name).to_numpy()[slides] for name in ("behind", "ahead"))
    assert one == pytest.approx(other, rel=1e-3)
    assert curve["load_factor"].to_numpy()[slides] == pytest.approx(0.3, abs=1e-4)


@pytest.mark.slow
def test_units_that_slide_first_and_rock_then():
    """Half of the steps, the same curve to 2 % up to 0.7 m, and its zero to a thousandth: 55 units.

    Rounding decides which steps are not solved, and are followed as falls of less than a millimetre.
    """
    model = model_of(bonded(4, 12), bs.JointMaterial("dry", 0.65))
    one, other = (run(model, model.blocks[-1].name, (1, 0, 0), steps=steps).capacity for steps in (30, 60))
    assert float(one["d0"]) == pytest.approx(float(other["d0"]), rel=1e-3)
    curves = [np.interp(np.linspace(0.05, 0.7, 18), c["displacement"], c["load_factor"]) for c in (one, other)]
    assert curves[0] == pytest.approx(curves[1], rel=2e-2)


@pytest.mark.parametrize("steps", slow_after(20, 12, 40, 120, 160))
def test_a_loose_unit_falls_off_or_is_carried(steps):
    """Steps decide whether the end unit 5.1 falls off a wall at a seventh of its height.

    A curve without a doubt has the zero of fine steps, which carry it to the end.
    """
    rows = [[1, 1] if j % 2 == 0 else [0.35, 1, 0.65] for j in range(5)]
    blocks = bs.courses(rows, unit_length="0.4 m", unit_height="0.2 m", thickness="0.2 m", material=STONE)
    result = run(model_of(blocks, bs.JointMaterial("dry", 0.577)), blocks[-1].name, (-1, 0, 0), steps=steps)
    curve = result.capacity
    assert result.curve_outcome.end == ("falls" if np.isnan(curve["d0"]) else "zero")
    doubts = {part.doubt for part in bs.results.doubtful_parts(curve, result.settings.procedure)}
    if not doubts:
        assert float(curve["d0"]) == pytest.approx(0.186, abs=2e-3)
    assert float(curve["displacement"][-1]) > 0.1


@pytest.mark.slow
def test_a_hinge_that_leaps_is_told():
    """The load factor of an arch whose voussoirs have come to rock falls by half; friction there hangs on the steps."""
    blocks = bs.arch(span="4 m", thickness="0.8 m", depth="1 m", voussoirs=13, material=STONE)
    crown = blocks[len(blocks) // 2].name
    result = run(model_of(blocks, bs.JointMaterial("dry", 0.7)), crown, steps=12)
    alpha = result.capacity["load_factor"].to_numpy()
    assert alpha[1:].min() < 0.6 * alpha[0]
    jump, *_ = bs.results.doubtful_parts(result.capacity, result.settings.procedure)
    assert jump.doubt in ("slips", "leaps")
