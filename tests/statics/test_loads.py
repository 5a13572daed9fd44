"""Weights, fill and pressures against closed forms."""

import numpy as np
import pytest
import shapely

import blockstruct as bs
from blockstruct import Q_
from blockstruct.statics.carried import carried_weights
from blockstruct.statics.wrenches import wrenches
from structures import STONE, box, model_of, moved, push, rotation, single_block, solve

DRY, GROUND = bs.JointMaterial("dry", 0.7), box("ground", [-1, -1, -1], [4, 4, 1], fixed=True)


def resultant(model, *loads):
    """Force and moment about the origin of loads, of all blocks."""
    w = wrenches(model, bs.LoadPattern("loads", loads))
    centroid = np.array([b.centroid for b in model.blocks])
    return w[:, :3].sum(axis=0), (w[:, 3:] + np.cross(centroid, w[:, :3])).sum(axis=0)


@pytest.fixture(scope="module")
def room():
    """Four walls of 0.5 m about a room of 3 m by 4 m, with joints in plan of their own."""
    size = {"unit_length": "1 m", "unit_height": "0.5 m", "thickness": "0.5 m", "material": STONE}
    sides = [
        bs.structures.Sidewall("left", at="0 m", length="4.5 m"),
        bs.structures.Sidewall("right", at="3.5 m", length="4.5 m"),
    ]
    return model_of(bs.wall(length="4 m", courses=4, sidewalls=sides, **size), DRY)


def test_a_floor_that_spans_is_borne_by_the_walls_in_proportion_of_their_area(room):
    floor = bs.AreaLoad("4 kN/m^2", ["0 m", "0 m", "2 m"], ["4 m", "5 m", "2 m"], spanning=True)
    force, moment = resultant(room, floor)
    np.testing.assert_allclose(force, [0, 0, -4e3 * 4 * 5])
    walls = {"front": (4 * 0.5, 2, 0.25), "left": (4.5 * 0.5, 0.25, 2.75), "right": (4.5 * 0.5, 3.75, 2.75)}
    area, x, y = np.array(list(walls.values())).T
    np.testing.assert_allclose(moment, [-80e3 * area @ y / area.sum(), 80e3 * area @ x / area.sum(), 0], atol=1e-6)


def test_a_rectangle_over_voids_is_refused_without_spanning(room):
    floor = bs.AreaLoad("4 kN/m^2", ["0 m", "0 m", "2 m"], ["4 m", "5 m", "2 m"])
    with pytest.raises(bs.errors.ModelError, match=r"AreaLoad has blocks below 32\.5% of its 20 m².*spanning=True"):
        resultant(room, floor)


def test_line_loads_share_the_blocks_below_and_follow_the_line(room):
    inner = bs.LineLoad("6 kN/m", ["0 m", "0.1 m", "2 m"], ["4 m", "0.1 m", "2 m"])
    force, moment = resultant(room, inner)
    np.testing.assert_allclose(force, [0, 0, -24e3])
    np.testing.assert_allclose(moment, [-24e3 * 0.1, 24e3 * 2, 0], atol=1e-6)


@pytest.mark.parametrize("degrees", [0, 10, 30, 40])
@pytest.mark.parametrize("drawn", ["exactly", "to a millimetre"])
@pytest.mark.parametrize(("y", "shares"), [(0.3, (0.5, 0.5)), (0.0, (1, 0)), (1.0, (0, 1))])
def test_a_line_along_a_joint_is_shared_by_halves_and_one_along_an_edge_is_borne_however_they_are_turned(
    degrees, drawn, y, shares
):
    blocks = [GROUND, box("a", [0, 0, 0], [1, 0.3, 1]), box("b", [0, 0.3, 0], [1, 0.7, 1])]
    # By rounding, which of the two blocks or whether any is under the line differs from angle to angle.
    R = rotation((0, 0, 1), np.radians(degrees))
    model = model_of(moved(blocks, R), DRY)
    ends = np.array([[0.2, y, 1], [0.8, y, 1]]) @ R.T
    start, end = ends if drawn == "exactly" else ends.round(3)
    w = wrenches(model, bs.LoadPattern("d", [bs.LineLoad("10 kN/m", Q_(start, "m"), Q_(end, "m"))]))
    share, arm = np.array(shares), y - np.array([0.15, 0.65])
    rough = {} if drawn == "exactly" else {"rtol": 2e-3, "atol": 5.0}
    np.testing.assert_allclose(w[1:, 2], -6e3 * share, **({"atol": 1e-6} | rough))
    np.testing.assert_allclose((w[1:, 3:] @ R)[:, 0], -6e3 * share * arm, **({"atol": 1e-6} | rough))


def test_area_load_on_a_block_takes_its_open_upper_faces():
    blocks = [GROUND, box("step", [0, 0, 0]), box("upper", [0, 0, 1], [0.4, 1, 1])]
    force, moment = resultant(model_of(blocks, DRY), bs.AreaLoad("5 kN/m^2", block="step"))
    np.testing.assert_allclose(force, [0, 0, -3e3])
    np.testing.assert_allclose(moment, [-3e3 * 0.5, 3e3 * 0.7, 0])


def test_overturning_with_a_roof_mass():
    """Block b × h with W, roof R on its top: α (W h/2 + R h) = (W + R) b/2."""
    b, h, t = 0.5, 2.0, 1.0
    model = model_of(*single_block(b, h, t))
    W, R = 20e3 * b * h * t, 8e3
    roof = bs.AreaLoad(Q_(R / (b * t), "Pa"), ["0 m", "0 m", "2 m"], [f"{b} m", f"{t} m", "2 m"])
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), roof])
    result = solve(model, push(1, 0, 0), dead=dead)
    assert result.load_factor == pytest.approx((W + R) * b / 2 / (W * h / 2 + R * h), rel=1e-6)
    assert "Pushed weight: 20 kN masonry + 8 kN area loads." in result.describe()
    resting = bs.LoadPattern("dead", [bs.SelfWeight(), bs.AreaLoad(Q_(R / (b * t), "Pa"), block="block", mass_share=0)])
    free = solve(model, push(1, 0, 0), dead=resting)
    assert free.load_factor == pytest.approx((W + R) * b / 2 / (W * h / 2), rel=1e-6)
    assert "0 kN area loads (of 8 kN)" in free.describe()


@pytest.mark.parametrize("z", [1.0, 2.0, 3.5])
def test_a_concentrated_weight_is_pushed_at_its_own_height(z):
    b, h, R = 0.5, 2.0, 6e3
    W = 20e3 * b * h
    bell = bs.Weight("block", Q_([0.1, 0.5, z], "m"), Q_(R, "N"))
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), bell])
    result = solve(model_of(*single_block(b, h, mu=2.0)), push(-1, 0, 0), dead=dead)
    assert result.load_factor == pytest.approx((W * b / 2 + R * 0.1) / (W * h / 2 + R * z), rel=1e-6)


def test_a_force_without_mass_is_not_pushed_and_said_so():
    model = model_of(*single_block(0.5, 2.0))
    roof = bs.PointLoad("block", ["0.25 m", "0.5 m", "2 m"], ["0 N", "0 N", "-8 kN"])
    result = solve(model, push(1, 0, 0), dead=bs.LoadPattern("dead", [bs.SelfWeight(), roof]))
    assert result.load_factor == pytest.approx(28e3 * 0.25 / 20e3, rel=1e-6)
    assert "Forces of 'dead', 8 kN downwards, have no mass and are not pushed." in result.describe()
    record = bs.RecordCase("r", result.case.dead, Q_([0.0, 0.0], "g_0"), "0.1 s", "+x")
    words = "Accelerated weight: 20 kN masonry. Forces of 'dead', 8 kN downwards, have no mass and are not accelerated."
    assert words in bs.run(model, record)["r"].describe()
    on_support = [bs.SelfWeight(), bs.Weight("ground", ["0 m", "0 m", "0 m"], "3 kN")]
    result = solve(model, push(1, 0, 0), dead=bs.LoadPattern("dead", on_support))
    assert "Pushed weight: 20 kN masonry. Weights of 3 kN on supports do nothing." in result.describe()


def test_a_mass_that_would_grow_with_the_load_factor_is_refused():
    model = model_of(*single_block(0.5, 2.0))
    roof = bs.AreaLoad("8 kPa", block="block")
    with pytest.raises(bs.errors.ModelError, match=r"AreaLoad has a mass that would grow.*mass_share=0"):
        solve(model, bs.LoadPattern("push", [bs.BodyForce("+x"), roof]))
    resting = bs.AreaLoad("8 kPa", block="block", mass_share=0)
    growing = solve(model, bs.LoadPattern("push", [bs.BodyForce("+x"), resting]))
    assert growing.load_factor == pytest.approx(20e3 * 0.25 / (20e3 * 1.0 - 4e3 * 0.25), rel=1e-6)


def ring(depth=1.0, voussoirs=12):
    return bs.arch(span="4 m", thickness="0.5 m", depth=Q_(depth, "m"), voussoirs=voussoirs, material=STONE)


def test_fill_on_an_arch_weighs_what_is_above_the_extrados():
    """The extrados is a polygon through points of a circle of 2.5 m: what is above it is the sum of trapezia."""
    model = model_of(ring(), DRY)
    fill = bs.FillLoad("18 kN/m^3", ["-2.5 m", "0 m", "0 m"], ["2.5 m", "1 m", "3 m"])
    found = carried_weights(model, bs.LoadPattern("d", [fill]))
    angle = np.linspace(-np.pi / 2, np.pi / 2, 13)
    x, z = 2.5 * np.sin(angle), 2.5 * np.cos(angle)
    heights = 3 - z
    areas = (x[1:] - x[:-1]) * (heights[1:] + heights[:-1]) / 2
    np.testing.assert_allclose(found.weight, 18e3 * areas, rtol=1e-9)
    assert [model.blocks[i].name for i in found.block] == [str(k) for k in range(1, 13)]
    centre = found.weight @ found.point / found.weight.sum()
    np.testing.assert_allclose(centre[:2], [0, 0.5], atol=1e-9)
    # First moment of a trapezium about the level: ∫ h²/2.
    below = ((x[1:] - x[:-1]) * (heights[1:] ** 2 + heights[1:] * heights[:-1] + heights[:-1] ** 2) / 6).sum()
    assert centre[2] == pytest.approx(3 - below / areas.sum())


def test_fill_on_a_cross_vault_is_what_is_above_its_highest_faces():
    """Summed up independently, over a fine grid of points in plan."""
    model = model_of(bs.structures.cross_vault(span="4 m", thickness="0.3 m", courses=4, units=2, material=STONE), DRY)
    low, high = np.array([-2, -2, 0.2]), np.array([2, 2, 3])
    found = carried_weights(model, bs.LoadPattern("d", [bs.FillLoad("10 kN/m^3", Q_(low, "m"), Q_(high, "m"))]))
    n = 60
    x, y = (low[k] + (np.arange(n) + 0.5) / n * (high[k] - low[k]) for k in range(2))
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    top = np.full(len(points), -np.inf)
    for block in model.blocks:
        for k in np.flatnonzero(block.shape.normals[:, 2] > 1e-3):
            corners, normal = block.shape.vertices[list(block.shape.faces[k])], block.shape.normals[k]
            over = shapely.intersects_xy(shapely.Polygon(corners[:, :2]), points)
            heights = corners[0, 2] - (points[over] - corners[0, :2]) @ normal[:2] / normal[2]
            top[over] = np.maximum(top[over], heights)
    height = np.where(top >= 0.2, 3 - top, 0.0)
    assert found.weight.sum() == pytest.approx(10e3 * height.sum() * (4 / n) ** 2, rel=2e-3)


def test_fill_stands_in_its_box_only_and_not_under_the_vault():
    model = model_of(ring(), DRY)
    left = bs.FillLoad("18 kN/m^3", ["-1 m", "0.25 m", "0 m"], ["0 m", "0.75 m", "3 m"], block="6")
    (own,) = carried_weights(model, bs.LoadPattern("d", [left])).block
    assert model.blocks[own].name == "6"
    # A slab below the arch lies under it: what is in the box above it is air, and the arch.
    slab = box("slab", [-3, 0, -1], [6, 1, 0.5], fixed=True)
    under = bs.Model("m", [*model.blocks, slab], model.interfaces)
    fill = bs.FillLoad("18 kN/m^3", ["-2 m", "0 m", "-1 m"], ["2 m", "1 m", "3 m"])
    assert "slab" not in [under.blocks[i].name for i in carried_weights(under, bs.LoadPattern("d", [fill])).block]


def test_fill_is_not_inside_walls_that_rise_above_it_nor_kept_off_by_what_hangs_over_it():
    stones = box("low", [0, 0, 0]), box("high", [0, 0, 1], [0.5, 1, 2]), box("beam", [0, 0, 3])
    model = model_of([GROUND, *stones], DRY)
    fill = bs.FillLoad("18 kN/m^3", ["0 m", "0 m", "0 m"], ["1 m", "1 m", "2 m"])
    found = carried_weights(model, bs.LoadPattern("d", [fill]))
    assert [model.blocks[i].name for i in found.block] == ["low"]
    np.testing.assert_allclose(found.weight, 18e3 * 0.5)
    np.testing.assert_allclose(found.point, [[0.75, 0.5, 1.5]])


def test_lateral_pressure_of_fill():
    """K γ h over the height of a slope of 45°: K γ (h1² − h0²)/2 at its centre of pressure."""
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [0, 1, 1]]
    faces = [[0, 2, 3, 1], [0, 1, 4], [2, 5, 3], [0, 4, 5, 2], [1, 3, 5, 4]]
    wedge = bs.Block.from_faces("wedge", Q_(corners, "m"), faces, STONE)
    model = model_of([GROUND, wedge], DRY)
    K, g, level = 0.4, 18e3, 1.5
    fill = bs.FillLoad(Q_(g, "N/m^3"), ["0 m", "0 m", "0 m"], ["1 m", "1 m", "1.5 m"], lateral_coefficient=K)
    w = wrenches(model, bs.LoadPattern("d", [fill]))[1]
    volume = level - 0.5
    push_ = K * g * (level**2 - 0.5**2) / 2
    np.testing.assert_allclose(w[:3], [-push_, 0, -g * volume], atol=1e-6)
    c = wedge.centroid
    x = (level - 1) / 2 + 1 / 3  # ∫ (level − 1 + x) x dx
    z = level - (level**3 - 0.5**3) / 3 / ((level**2 - 0.5**2) / 2)
    assert w[4] == pytest.approx(-push_ * (z - c[2]) + g * (x - volume * c[0]))


def test_pressures_of_water_and_wind():
    """Water to a depth d against a wall: γ d²/2 a metre, d/3 above its foot; nothing above its level."""
    model = model_of(*single_block(1.0, 3.0, 2.0))
    face = model.block("block").face_towards("-x")
    for level, depth in ((2.4, 2.4), (4.0, 3.0), (-1.0, 0.0)):
        water = bs.FaceLoad("block", face, unit_weight="9.81 kN/m^3", level=Q_(level, "m"))
        force, moment = resultant(model, water)
        total = 9.81e3 * 2.0 * (level * depth - depth**2 / 2)
        first = 9.81e3 * 2.0 * (level * depth**2 / 2 - depth**3 / 3)
        np.testing.assert_allclose(force, [total, 0, 0], atol=1e-6)
        np.testing.assert_allclose(moment, [0, first, -total], atol=1e-6)
    # Water that just reaches a face from below.
    foot = bs.FaceLoad("block", model.block("block").face_towards("-z"), unit_weight="9.81 kN/m^3", level="0 m")
    assert not np.any(resultant(model, foot))
    # Wind as pressure in front and suction behind.
    front, back = (model.block("block").face_towards(side) for side in ("-y", "+y"))
    wind = (bs.FaceLoad("block", side, pressure=p) for side, p in ((front, "0.8 kPa"), (back, "-0.4 kPa")))
    np.testing.assert_allclose(resultant(model, *wind)[0], [0, 1.2e3 * 1.0 * 3.0, 0], atol=1e-9)


def test_buoyancy_of_water_on_all_faces():
    """Pressure on every face of a submerged body adds up to the weight of the water it displaces, at its centroid."""
    blocks, joint = single_block(1.0, 1.5)
    model = model_of(moved(blocks, rotation((1, 2, 3), 0.7)), joint)
    turned = model.block("block")
    loads = [bs.FaceLoad("block", k, unit_weight="10 kN/m^3", level="3 m") for k in range(6)]
    w = wrenches(model, bs.LoadPattern("water", loads))[1]
    np.testing.assert_allclose(w, [0, 0, 10e3 * turned.volume, 0, 0, 0], atol=1e-8)


def test_weights_move_with_the_structure():
    """Loads and structure shifted together give the same wrenches; other units the same loads."""
    blocks = bs.structures.arch_on_piers(
        span="4 m", thickness="0.5 m", depth="1 m", voussoirs=9, pier_width="1 m", pier_height="2 m", pier_courses=2,
        material=STONE,
    )  # fmt: skip
    shift = np.array([123.0, -45.0, 6.7])

    def loads(by, unit="m"):
        def at(*xyz):
            return Q_((np.array(xyz) + by) / (1.0 if unit == "m" else 0.3048), unit)

        return [
            bs.FillLoad("18 kN/m^3", at(-3, 0, 1), at(3, 1, 5), lateral_coefficient=0.4),
            bs.Weight("5", at(0, 0.5, 6), "7 kN"),
            bs.LineLoad("2 kN/m", at(-3, 0.2, 2), at(-2, 0.3, 2), block="left.2"),
            bs.FaceLoad("left.1", 5, unit_weight="9.81 kN/m^3", level=at(0, 0, 1.3)[2]),
        ]

    one = wrenches(model_of(blocks, DRY), bs.LoadPattern("d", loads(np.zeros(3))))
    feet = wrenches(model_of(blocks, DRY), bs.LoadPattern("d", loads(np.zeros(3), "ft")))
    far = wrenches(model_of(moved(blocks, np.eye(3), shift), DRY), bs.LoadPattern("d", loads(shift)))
    np.testing.assert_allclose(feet, one, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(far, one, rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize(
    ("load", "words"),
    [
        (bs.Weight("block", ["3 m", "0 m", "0 m"], "1 kN"), "in plan outside the block, which reaches from"),
        (bs.LineLoad("1 kN/m", ["0 m", "0 m", "9 m"], ["1 m", "0 m", "9 m"]), "no upper face of a block at z = 9 m"),
        (bs.LineLoad("1 kN/m", ["0 m", "0 m", "2 m"], ["1 m", "0 m", "2 m"]), "below 50.0% of its 1 m at z = 2 m"),
        (bs.LineLoad("1 kN/m", ["0 m", "0 m", "2 m"], ["1 m", "0 m", "2 m"], block="block"), "leaves the block"),
        (bs.AreaLoad("1 kPa", ["5 m", "5 m", "2 m"], ["6 m", "6 m", "2 m"]), "over no upper face"),
        (bs.AreaLoad("1 kPa", ["0 m", "0 m", "2 m"], ["1 m", "1 m", "2 m"], block="ground"), "over no upper face"),
        (bs.FillLoad("1 kN/m^3", ["5 m", "5 m", "2 m"], ["6 m", "6 m", "3 m"]), "no face below it that looks up"),
    ],
    ids=lambda v: type(v).__name__,
)  # fmt: skip
def test_loads_that_do_not_fit_the_model_are_refused(load, words):
    model = model_of(*single_block(0.5, 2.0))
    with pytest.raises((bs.errors.ModelError, bs.errors.UnknownNameError)) as caught:
        wrenches(model, bs.LoadPattern("p", [load]))
    assert words in str(caught.value)
    assert "'p'" in str(caught.value)
