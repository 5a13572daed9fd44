"""Load factors that statics gives by hand, to 1e-6 of their value in the associative program."""

import math

import attrs
import pytest

import blockstruct as bs
from blockstruct import Q_
from structures import box, extruded, model_of, moved, push, rotation, single_block, solve

REL = 1e-6


@pytest.mark.parametrize(("b", "h", "mu"), [(0.5, 1.0, 0.65), (0.5, 1.0, 0.4), (2.0, 1.0, 0.65), (0.1, 3.0, 0.3)])
@pytest.mark.parametrize("psi", [None, 0, 10, 16])
def test_single_block_slides_or_rocks(b, h, mu, psi):
    """Sliding with dilatancy lifts the block and costs work: α = μ at any angle, ``None`` for the associative one."""
    joint, flow = bs.JointMaterial("joint", mu, dilatancy_angle=Q_(psi or 0, "deg")), bs.Flow.NONASSOCIATIVE
    result = solve(model_of(single_block(b, h)[0], joint), push(1, 0, 0), "associative" if psi is None else flow)
    assert result.status == "converged"
    assert result.load_factor == pytest.approx(min(mu, b / h), rel=REL if psi is None else 1e-5)


def test_block_on_a_tilted_plane():
    # Plane tilted by θ, weight vertical, pushed down the slope by α W: sliding when tan θ + α / cos θ = μ.
    blocks, joint = single_block(3.0, 1.0, mu=0.65)
    theta = 0.3
    R = rotation((0, 1, 0), theta)
    variable = bs.LoadPattern("push", [bs.BodyForce(R @ [1, 0, 0])])
    result = solve(model_of(moved(blocks, R), joint), variable)
    assert result.load_factor == pytest.approx(0.65 * math.cos(theta) - math.sin(theta), rel=REL)


def test_block_on_two_supports_rocks_about_the_outer_edge():
    # Two interfaces under one block: it still turns about the edge of the outer one.
    piers = [box(f"pier {x}", [x, 0, -1], [0.3, 1, 1], fixed=True) for x in (0, 0.9)]
    model = model_of([*piers, box("beam", [0, 0, 0], [1.2, 1, 2])], bs.JointMaterial("joint", 0.9))
    assert len(model.interfaces) == 2
    assert solve(model, push(1, 0, 0)).load_factor == pytest.approx(0.6, rel=REL)


@pytest.mark.parametrize(
    ("load", "expected"),
    [
        # H at the height z about the toe: α H z = W b / 2, with W = 10 kN and b = 0.5 m.
        (bs.PointLoad("block", Q_([0, 0.5, 0.8], "m"), Q_([3, 0, 0], "kN")), 10 * 0.25 / (3 * 0.8)),
        # Pressure p on the side of 1 m²: its resultant is at the middle of its height.
        (bs.FaceLoad("block", 5, Q_([2, 0, 0], "kPa")), 10 * 0.25 / (2 * 0.5)),
        # A couple about +y turns the block over its edge at +x.
        (bs.Moment("block", Q_([0, 1, 0], "kN*m")), 10 * 0.25),
    ],
    ids=["point", "face", "moment"],
)
def test_loads_overturn(load, expected):
    model = model_of(*single_block(0.5, 1.0, mu=0.9))
    assert solve(model, bs.LoadPattern("v", [load])).load_factor == pytest.approx(expected, rel=REL)


def test_point_load_under_dead_weight_slides():
    # P downwards, dead, raises the friction: α H = μ (W + P).
    P, H, W = 7e3, 2e3, 80e3
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), bs.PointLoad("block", "[2, 0.5, 1] m", Q_([0, 0, -P], "N"))])
    variable = bs.LoadPattern("v", [bs.PointLoad("block", "[0, 0.5, 0.1] m", Q_([H, 0, 0], "N"))])
    result = solve(model_of(*single_block(4.0, 1.0, mu=0.5)), variable, dead=dead)
    assert result.load_factor == pytest.approx(0.5 * (W + P) / H, rel=REL)


def test_cohesion_and_tension():
    # Pure shear of a weightless joint: H = c A. Pure pull: T = f_t A.
    joint = bs.JointMaterial("mortar", 0.5, cohesion="0.2 MPa", tensile_strength="0.1 MPa")
    blocks = [box("ground", [0, 0, -1], [0.4, 0.3, 1], fixed=True), box("block", [0, 0, 0], [0.4, 0.3, 1e-3])]
    model = model_of([attrs.evolve(b, material=bs.Material("feather", "0 kN/m^3")) for b in blocks], joint)
    for force, strength in (([1, 0, 0], 0.2e3), ([0, 0, 1], 0.1e3)):
        load = bs.LoadPattern("v", [bs.PointLoad("block", Q_([0.2, 0.15, 0], "m"), Q_(force, "kN"))])
        result = solve(model, load, dead=bs.LoadPattern("none", []))
        assert result.load_factor == pytest.approx(strength * 0.12, rel=REL)


@pytest.mark.parametrize("direction", ["-y", "+x", "-x"])
def test_tension_of_a_joint_that_is_not_convex(direction):
    """A U of unequal legs peels off about its edge, d from its centroid: α = (W + f_t A) d / (W h / 2)."""
    outline = [(0, 0), (2, 0), (2, 1), (1.9, 1), (1.9, 0.1), (0.1, 0.1), (0.1, 0.5), (0, 0.5)]
    h, ft = 2.0, 200e3
    area = 0.33
    x, y = (0.2 * 1 + 0.09 * 1.95 + 0.04 * 0.05) / area, (0.2 * 0.05 + 0.09 * 0.55 + 0.04 * 0.3) / area
    block = extruded("block", outline, 0.0, h)
    ground = box("ground", [-1, -1, -1], [4, 3, 1], fixed=True)
    model = model_of([ground, block], bs.JointMaterial("mortar", 3.0, cohesion="1 MPa", tensile_strength=Q_(ft, "Pa")))
    d = {"-y": y, "+x": 2 - x, "-x": x}[direction]
    W = 20e3 * area * h
    variable = bs.LoadPattern("v", [bs.BodyForce(direction)])
    assert solve(model, variable).load_factor == pytest.approx((W + ft * area) * d / (W * h / 2), rel=REL)


def test_only_dilatancy_jams_a_drawer():
    """The associative answer of a drawer, which its dilatancy wedges, is no bound: μ W holds the real one."""
    supports = [box(name, [x, 0, 0], fixed=True) for name, x in (("left", 0), ("right", 2))]
    blocks = [box("ground", [0, 0, -1], [3, 1, 1], fixed=True), *supports, box("drawer", [1, 0, 0])]
    model = model_of(blocks, bs.JointMaterial("joint", 0.5))
    dilatant = model_of(blocks, bs.JointMaterial("joint", 0.5, dilatancy_angle="10 deg"))
    assert solve(model, push(0, 1, 0)).status == "unbounded"
    assert solve(dilatant, push(0, 1, 0), "nonassociative").status == "unbounded"
    with pytest.warns(bs.errors.LoadFactorWarning, match="how firmly the blocks are jammed"):
        slides = solve(model, push(0, 1, 0), "nonassociative")
    assert slides.status == "converged"
    assert slides.load_factor == pytest.approx(0.5, rel=1e-3)
    assert slides.history.load_factor[0] == math.inf
    assert slides.headline.bound == "no associative bound"


@pytest.mark.parametrize("direction", [1, -1])
def test_unstable_under_dead_load_names_its_share(direction):
    """A block whose centroid lies outside its base falls by itself, also if some push would hold it."""
    blocks = [box("ground", [0, 0, -1], [0.4, 1, 1], fixed=True), box("block", [0, 0, 0], [1, 1, 1])]
    model = model_of(blocks, bs.JointMaterial("joint", 0.65))
    result = solve(model, push(direction, 0, 0), "nonassociative")
    assert result.status == "unstable_under_dead_load"
    assert math.isnan(result.load_factor)
    assert (result.n_iterations, result.history.stage.item(), result.outcome.carried) == (1, "dead_load", 0)
    # Its centroid falls.
    assert result.mechanism.translation.sel(block="block", axis="z") < 0


def leaning(standing, **strength):
    """A plate whose centroid is beside the block that it lies on, and piers of other heights that stand beside them."""
    joint = bs.JointMaterial("joint", 0.65, **strength)
    ground = box("ground", [-1, -1, -1], [20, 3, 1], fixed=True)
    foot = box("foot", [0, 0, 0], [0.4, 1, 1])
    plate = box("plate", [0.3, 0, 1], [2, 1, 0.2])
    beside = [box(f"pier {i}", [3 + 2 * i, 0, 0], [0.5, 0.5, h]) for i, h in enumerate((0.1, 1, 3, 9)[:standing])]
    return model_of([ground, foot, plate, *beside], joint)


@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
@pytest.mark.parametrize("standing", [0, 1, 4])
def test_what_stands_is_at_rest_where_something_else_falls(standing, flow):
    result = solve(leaning(standing), push(1, 0, 0), flow)
    assert result.status == "unstable_under_dead_load"
    assert result.active_joints.state.to_dict() == {"foot|plate": "hinge"}
    # It turns about the edge of the foot, at (0.4, 1) m; its centroid is at (1.3, 1.1) m.
    motion = result.mechanism.translation.sel(block="plate")
    assert motion.sel(axis="x") / motion.sel(axis="z") == pytest.approx(-0.1 / 0.9, rel=1e-4)
    assert f"1 of {2 + standing} free blocks moves" in result.describe()
    assert result.certificate.holds


@pytest.mark.parametrize("strength", [{"compressive_strength": "300 kPa"}, {"torsion": "uniform pressure"}])
@pytest.mark.parametrize("force", [None, "0.1 kN"])
def test_what_crushes_or_yields_once_it_falls_is_no_part_of_the_proof(strength, force):
    """Under no load no joint crushes and no tie yields."""
    model = leaning(1, **strength)
    if force is not None:
        ends = ("foot", Q_([0.4, 0.5, 0.5], "m")), ("pier 0", Q_([3, 0.25, 0.05], "m"))
        model = model.with_ties([bs.Tie("tie", *ends, yield_force=force)])
    result = solve(model, push(1, 0, 0))
    assert result.outcome.carried == 0
    assert result.active_joints.state.to_dict() == {"foot|plate": "hinge"}
    assert result.certificate.holds


@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
@pytest.mark.parametrize("strength", [{}, {"cohesion": "100 Pa"}], ids=["dry", "cohesive"])
def test_a_block_that_slides_down_by_itself_slides(strength, flow):
    # On a slope of 0.6 with μ 0.55; by the flow rule of the proof it lifts off by μ times its way, which is no opening.
    blocks, _ = single_block(2.0, 1.0)
    joint = bs.JointMaterial("joint", 0.55, **strength)
    model = model_of(moved(blocks, rotation((0, 1, 0), math.atan(0.6))), joint)
    result = solve(model, push(1, 0, 0), flow)
    assert result.status == "unstable_under_dead_load"
    assert result.active_joints.state.to_list() == ["sliding"]


def test_resultants_balance_the_block():
    result = solve(model_of(*single_block(0.5, 1.0)), push(1, 0, 0))
    last = result.resultants.isel(iteration=-1, interface=0)
    # N = W, V = α W; N acts at the toe, e = b / 2.
    assert last.force.sel(component="n") == pytest.approx(10e3, rel=1e-6)
    assert last.force.sel(component="s") == pytest.approx(-result.load_factor * 10e3, rel=1e-6)
    assert last.eccentricity.sel(in_plane="s") == pytest.approx(0.25, rel=1e-5)
    assert last.eccentricity.sel(in_plane="t") == pytest.approx(0.0, abs=1e-5)
    # Bending about t: M_t = −N e_s, because r × N n = N (e_t s − e_s t).
    assert last.moment.sel(component="t") == pytest.approx(-10e3 * 0.25, rel=1e-5)


def test_dead_load_pattern_may_be_empty():
    """Without dead load nothing presses a block without cohesion to the ground."""
    with pytest.warns(bs.errors.UnusualValueWarning, match="the dead load 'none' has no loads") as told:
        result = solve(model_of(*single_block(1.0, 1.0)), push(1, 0, 0), dead=bs.LoadPattern("none", []))
    assert (len(told), result.status) == (1, "converged")
    assert result.load_factor == pytest.approx(0.0, abs=1e-6)


def test_a_joint_that_hangs_is_not_open():
    """Of two blocks on mortar the upper joint fails; the lower one carries 20 kN of tension and does not move."""
    roof = box("roof", [-1, -1, 2], [3, 3, 1], fixed=True)
    hung = [box(name, [0, 0, z], [1, 1, 1]) for name, z in (("low", 0), ("high", 1))]
    mortar = bs.JointMaterial("mortar", 0.5, cohesion="0.2 MPa", tensile_strength="0.1 MPa")
    result = solve(model_of([roof, *hung], mortar), push(0, 0, -1))
    # 100 kN of strength less the weights of 40 kN, over those weights.
    assert result.load_factor == pytest.approx(1.5, rel=REL)
    states = result.states.isel(iteration=-1)
    assert states.sel(interface="high|roof").item() == "open"
    assert states.sel(interface="low|high").item() == "sticking"


@pytest.mark.parametrize("size", [0.1, 0.02])
@pytest.mark.parametrize("flow", list(bs.Flow))
def test_a_pebble_beside_a_boulder(size, flow):
    # Weights that differ by 1e7: the pebble of b/h = 0.4 rocks at exactly that share of its own weight.
    blocks, joint = single_block(0.4 * size, size, t=size, mu=0.5)
    blocks[0] = box("ground", [-50, -50, -1], [200, 200, 1], fixed=True)
    boulder = box("boulder", [10, 10, 0], [20, 20, 10])
    at = Q_([0.2 * size, 0.5 * size, 0.5 * size], "m")
    load = bs.LoadPattern("v", [bs.PointLoad("block", at, Q_([1, 0, 0], "N"))])
    result = solve(model_of([*blocks, boulder], joint), load, flow)
    assert result.load_factor == pytest.approx(0.4 * 20e3 * 0.4 * size**3, rel=REL)


@pytest.mark.filterwarnings("ignore::blockstruct.errors.UnusualValueWarning")
def test_an_unstable_pebble_beside_a_boulder():
    heavy = bs.Material("heavy", "2e10 kN/m^3")
    ledge = box("ledge", [-5, 0, -1], [5.1, 1, 1], fixed=True)
    floor = box("floor", [5, 5, -1], [60, 60, 1], fixed=True)
    boulder = bs.Block.box("boulder", Q_([10, 10, 0], "m"), Q_([1, 1, 1], "m"), heavy)
    falls = box("falls", [0, 0, 0], [1, 1, 1])
    model = model_of([ledge, floor, boulder, falls], bs.JointMaterial("joint", 0.5))
    assert solve(model, push(1, 0, 0)).status == "unstable_under_dead_load"
