"""Torsion of joints: by friction at the corners, and by that of uniform pressure.

A square block of side b and weight W is twisted about its axis. Corners slide at the distance b / √2 and resist
``0.7071 b μ W``. Under uniform pressure each part of the area slides at its own distance, whose mean is
``(√2 + asinh 1) / 6 = 0.38260`` of the side.
"""

from dataclasses import replace
from functools import partial

import cvxpy as cp
import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar

import blockstruct as bs
import structures
from blockstruct import Q_
from blockstruct.analysis.manager import with_effects
from blockstruct.geometry.polygon import mean_distances, plane_axes
from blockstruct.limit import LimitProblem
from blockstruct.limit.torsion import UniformTorsion
from blockstruct.statics.contacts import ContactPoints, Division
from blockstruct.statics.statics import Statics
from blockstruct.statics.uniform_friction import multiple_of_uniform_friction
from blockstruct.text.note import NoteCode, effect_note, torsion_note
from structures import SELF_WEIGHT, STONE, box, kept, model_of, moved, push, random_frame, rotation

FRICTION, HEIGHT = 0.6, 0.5
CORNERS, UNIFORM = np.sqrt(2) / 2, (np.sqrt(2) + np.arcsinh(1)) / 6
WEIGHT = 20e3 * HEIGHT


def block(torsion="uniform pressure", width=1.0, R=None, **joint):
    """Model of a block of 1 m by ``width`` on a base."""
    blocks = [box("base", [-1, -1, -0.5], [3, 2 + width, 0.5], fixed=True), box("block", [0, 0, 0], [1, width, HEIGHT])]
    blocks = blocks if R is None else moved(blocks, R)
    return model_of(blocks, bs.JointMaterial("joint", FRICTION, torsion=torsion, **joint))


#: Two forces of 1 N, one metre apart, in the plane of the joint.
FORCES = [bs.PointLoad("block", Q_([0.5, y, 0], "m"), Q_([x, 0, 0], "N")) for y, x in ((0, 1), (1, -1))]
COUPLE = bs.LoadPattern("couple", FORCES)


#: The remedies of torsion run, too.
solve = partial(structures.solve, effects=True)


@pytest.mark.parametrize(("torsion", "lever"), [("corners", CORNERS), ("uniform pressure", UNIFORM)])
@pytest.mark.parametrize("procedure", ["associative", "fictitious", "shifted", "loading path"])
def test_twisted_square(torsion, lever, procedure):
    flow = "associative" if procedure == "associative" else "nonassociative"
    of_procedure = {} if procedure == "associative" else {"procedure": procedure}
    result = solve(block(torsion), COUPLE, flow, **of_procedure)
    assert result.status == "converged"
    assert result.certificate.holds
    assert result.load_factor == pytest.approx(lever * FRICTION * WEIGHT, rel=1e-6)
    assert result.states.isel(iteration=-1).item() == "twisting"
    assert float(result.utilisation["sliding"][-1, 0]) == pytest.approx(1.0, rel=1e-4)
    assert bs.results.contradictions(bs.run(result.model, result.case)) == []


@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
@pytest.mark.parametrize("share", [0.3, 0.9])
def test_shear_and_torque_keep_to_an_ellipse(flow, share):
    force = bs.PointLoad("block", Q_([0.5, 0.5, 0], "m"), Q_([share * FRICTION * WEIGHT, 0, 0], "N"))
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), force])
    result = solve(block(), COUPLE, flow, dead)
    expected = UNIFORM * FRICTION * WEIGHT * np.sqrt(1 - share**2)
    assert result.status == "converged"
    assert result.load_factor == pytest.approx(expected, rel=2e-5)


@pytest.mark.parametrize(
    ("joint", "flow", "settings"),
    [
        ({"dilatancy_angle": "15 deg"}, "nonassociative", {}),
        ({"compressive_strength": Q_(2 * WEIGHT, "Pa")}, "nonassociative", {"crushing": "conic"}),
        ({"compressive_strength": Q_(2 * WEIGHT, "Pa")}, "nonassociative", {"crushing": "linearised"}),
        ({"cohesion": "30 kPa"}, "associative", {}),
    ],
    ids=str,
)
def test_other_joints_twist_by_the_torque_of_their_forces(joint, flow, settings):
    """Those that dilate, in part or fully, lift the block as it turns."""
    result = solve(block(**joint), COUPLE, flow, **settings)
    assert result.status == "converged"
    strength = FRICTION * WEIGHT + (30e3 if "cohesion" in joint else 0)
    assert result.load_factor == pytest.approx(UNIFORM * strength, rel=1e-5)
    rise = result.mechanism.translation.sel(block="block", axis="z").item()
    assert (rise > 1e-4) == ("compressive_strength" not in joint)


def test_torque_does_not_depend_on_the_axes():
    R = rotation((1, 2, 3), 0.7)
    gravity = bs.LoadPattern("dead", [bs.BodyForce(R @ np.array([0, 0, -1.0]))])
    couple = bs.LoadPattern("couple", [bs.Moment("block", Q_(R @ np.array([0, 0, 1.0]), "N*m"))])
    turned = solve(block(R=R), couple, dead=gravity)
    assert turned.load_factor == pytest.approx(UNIFORM * FRICTION * WEIGHT, rel=1e-6)


def test_sliding_alone_is_as_before():
    for flow in ("associative", "nonassociative"):
        alone, uniform = (solve(block(t), push(1, 0, 0), flow).load_factor for t in ("corners", "uniform pressure"))
        assert uniform == pytest.approx(alone, rel=1e-6)


# -- levers ------------------------------------------------------------------------------------------------------------


def lever_of(corners):
    polygon = Q_(np.column_stack([corners, np.zeros(len(corners))]), "m")
    return bs.Interface("a|b", "a", "b", polygon, bs.JointMaterial("joint", 0.6)).torsion_lever


def sampled(corners, side=1201):
    """Mean distance from the mean point of a fine grid of points inside."""
    from matplotlib.path import Path

    corners = np.asarray(corners, dtype=float)
    low, high = corners.min(axis=0), corners.max(axis=0)
    grid = np.stack(np.meshgrid(*(np.linspace(a, b, side) for a, b in zip(low, high, strict=True))), axis=-1)
    points = grid.reshape(-1, 2)
    inside = points[Path(corners).contains_points(points)]
    return np.linalg.norm(inside - inside.mean(axis=0), axis=1).mean()


def test_lever_of_a_square_and_of_a_disc():
    assert lever_of([(0, 0), (2, 0), (2, 2), (0, 2)]) == pytest.approx(2 * UNIFORM, rel=1e-12)
    angles = np.linspace(0, 2 * np.pi, 721)[:-1]
    assert lever_of(np.column_stack([np.cos(angles), np.sin(angles)])) == pytest.approx(2 / 3, rel=1e-4)


@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (4, 0), (4, 1), (0, 1)],
        [(0, 0), (3, 0), (0, 1)],
        # The centroid of an angle lies outside of it.
        [(0, 0), (4, 0), (4, 0.5), (0.5, 0.5), (0.5, 4), (0, 4)],
    ],
)
def test_lever_of_other_outlines(corners):
    assert lever_of(corners) == pytest.approx(sampled(corners), rel=3e-3)


#: Tolerances of the conic program.
EXACT = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), 1e-11)
#: Resistances of n points.
RESISTANCES = {
    "even": lambda n, random: random.uniform(0.1, 1.0, n),
    "one to a million": lambda n, random: 10 ** random.permutation(np.linspace(0, 6, n)),
    "at one point": lambda n, random: np.eye(n)[0],
    "at half of the points": lambda n, random: np.arange(n) % 2.0,
    "none": lambda n, random: np.zeros(n),
}
#: Places of n points.
PLACES = {
    "anywhere": lambda n, random: random.normal(size=(n, 2)),
    "in a line": lambda n, random: np.outer(random.normal(size=n), (1.0, 0.3)) + 0.1,
    "in a narrow joint": lambda n, random: random.choice([-1.0, 1.0], (n, 2)) * (1.7, 0.02),
}


@pytest.mark.parametrize("resistance", RESISTANCES)
@pytest.mark.parametrize("places", PLACES)
def test_division_of_rates_dissipates_least(places, resistance):
    """Against a conic program, on joints that turn, shift, turn about a point, and on velocities of no rigid motion."""
    random, counts = np.random.default_rng(7), [3, 4, 5, 6, 40, 4]
    owner = np.repeat(np.arange(len(counts)), counts)
    place = np.concatenate([PLACES[places](n, random) for n in counts])
    R = np.concatenate([RESISTANCES[resistance](n, random) for n in counts])
    torsion = UniformTorsion(np.arange(len(counts)), np.arange(len(owner)), owner, place)
    motion = random.normal(size=(len(counts), 3)) * [(1, 1, 1), (0, 0, 1), (1, 1, 0), (1, 1, 1), (1, 1, 1), (0, 0, 0)]
    motion[3, :2] = -motion[3, 2] * np.array([-1, 1]) * place[owner == 3][0, ::-1]
    v_t = torsion.moved(motion) + np.where(owner == 4, 0.3, 0.0)[:, None] * random.normal(size=(len(owner), 2))
    slip = torsion.slip(np.column_stack([np.zeros(len(owner)), v_t]), R)
    assert (slip[owner == 5] == 0).all()
    for j in range(len(counts) - 1):
        own, w = owner == j, cp.Variable(3)
        at_points = [v - w[:2] - w[2] * np.array([-y, x]) for v, (x, y) in zip(v_t[own], place[own], strict=True)]
        share = R[own] / R[own].sum() if resistance != "none" else np.ones(own.sum())
        work = sum(c * cp.norm(e) for c, e in zip(share, at_points, strict=True)) + share.sum() * cp.norm(w)
        least = cp.Problem(cp.Minimize(work)).solve(solver=cp.CLARABEL, **EXACT)
        assert share @ slip[own] == pytest.approx(least, rel=2e-9, abs=1e-10)


# -- joints that dilate ------------------------------------------------------------------------------------------------


def test_a_joint_that_carries_nothing_opens_as_it_slides():
    """A block on two bases turns about a corner of the one that carries it; over the other it opens and slides.

    The load W rests at ``(q, q)`` from the corner, whose neighbours carry q W each and slide: the torque is
    ``2 μ q W b``, beside the cone for ``2 q b < r̄``. At ``(x, y)`` from the corner the block is lifted by
    ``μ ω (x + y)`` and slides by ``ω √(x² + y²)``: no point penetrates if each slides by itself, as the cone of a joint
    that carries nothing must know, though any division dissipates nothing there.
    """
    W, q = 100.0, 0.15
    blocks = [
        box("base", [0, 0, -0.5], [1, 1, 0.5], fixed=True),
        box("idle", [2, 0.1, -0.5], [1, 0.9, 0.5], fixed=True),
        box("block", [0, 0, 0], [3, 1, HEIGHT]),
    ]
    model = model_of(blocks, bs.JointMaterial("joint", FRICTION, torsion="uniform pressure"))
    dead = bs.LoadPattern("dead", [bs.PointLoad("block", Q_([q, q, 0], "m"), Q_([0, 0, -W], "N"))])
    twist = bs.LoadPattern("twist", [bs.Moment("block", Q_([0, 0, 1], "N m"))])
    result = solve(model, twist, dead=dead)
    assert result.status == "converged"
    assert result.load_factor == pytest.approx(2 * FRICTION * q * W, rel=1e-6)
    assert result.certificate.interpenetration < 1e-6


@pytest.mark.parametrize(
    ("seed", "procedure"), [*((k, None) for k in (1, 5, 8, 10, 13, 19)), *((k, "shifted") for k in (1, 8, 19))]
)
def test_frames_of_uniform_torsion_converge(seed, procedure):
    """Shifts follow the sliding rates: if these are not those of the least work, the programs alternate."""
    model, variable = random_frame(seed, "uniform pressure")
    how = {"flow": "nonassociative", "procedure": procedure} if procedure else {}
    result = structures.solve(model, variable, **how)
    assert (result.status, result.certificate.holds) == ("converged", True)
    if procedure is None:
        assert result.certificate.interpenetration < 1e-6
        assert result.certificate.flow_rule_gap < 1e-5 * result.load_factor


# -- the warning -------------------------------------------------------------------------------------------------------


#: A joint of 5 m by 1 cm.
NARROW = np.array([(0, 0, 0), (5, 0, 0), (5, 0.01, 0), (0, 0.01, 0)])


def without_effect(result):
    return result.changed(outcome=replace(result.outcome, uniform_torsion=np.nan, lowered_friction=np.nan))


def test_corner_torsion_has_a_note():
    result = solve(block("corners"), COUPLE, "nonassociative")
    (note,) = result.notes
    times, limited = CORNERS / UNIFORM, UNIFORM * FRICTION * WEIGHT
    assert result.outcome.uniform_torsion == pytest.approx(limited, rel=1e-6)
    assert note == effect_note(NoteCode.CORNER_TORSION, result.load_factor, limited, result.answer)
    assert note.text in result.describe()
    # Without the effect it gives an estimate.
    (note,) = without_effect(result).notes
    assert note == torsion_note(["base|block"], times, 1 - 1 / times, "load factor", at_corners=True)
    found = bs.results.corner_torsion(result.model, result.history).loc["base|block"]
    assert abs(found["torque"]) == pytest.approx(CORNERS * FRICTION * WEIGHT, rel=1e-6)
    assert found["uniform"] == pytest.approx(UNIFORM * FRICTION * WEIGHT, rel=1e-6)
    # What the load factor loses.
    assert found["share"] == pytest.approx(1 - UNIFORM / CORNERS, rel=1e-4)


def test_the_first_steps_of_a_path_estimate_the_effect_of_torsion(tmp_path):
    """Both paths of one block are flat after them. A file keeps the estimate, and that it is one."""
    result = without_effect(solve(block("corners"), COUPLE, "nonassociative"))
    estimated = with_effects(result, is_estimate=True)
    limited = UNIFORM * FRICTION * WEIGHT
    assert estimated.outcome.uniform_torsion == pytest.approx(limited, rel=1e-3)
    (note,) = estimated.notes
    assert (note.change, "estimated" in note.text) == (pytest.approx(UNIFORM / CORNERS - 1, abs=1e-3), True)
    file = bs.save_analysis(bs.Analysis(result.model, {"case": estimated}, "", result.versions[0]), tmp_path / "a.h5")
    assert bs.open_analysis(file)["case"].notes == (note,)
    exact = with_effects(estimated)
    assert (exact.outcome.uniform_torsion, exact.outcome.estimated) == (pytest.approx(limited, rel=1e-6), False)


def uniform_friction(a, b, beside, cells=1500):
    """Share of its friction with which a uniformly pressed area of a by b, long along x, resists a force along y."""
    x, y = ((np.arange(cells) + 0.5) / cells - 0.5 for _ in range(2))
    x, y = a * x[:, None], b * y[None, ::10]

    def needed(centre):
        return float(np.hypot(x - centre, y).mean()) / (beside - centre)

    best = minimize_scalar(needed, bounds=(-20 * a, 0.0), method="bounded", options={"xatol": 1e-9 * a})
    return min(best.fun, 1.0)


@pytest.mark.parametrize("y", [0.3, 0.2, 0.1, 0.0])
def test_torque_counts_with_the_shear_next_to_it(y):
    """A force beside the centre: the torque alone is below that of uniform pressure, with its shear it is above."""
    beside = bs.LoadPattern("beside", [bs.PointLoad("block", Q_([0.5, y, 0], "m"), Q_([1, 0, 0], "N"))])
    result, limited = (solve(block(torsion), beside) for torsion in ("corners", "uniform pressure"))
    assert limited.load_factor == pytest.approx(FRICTION * WEIGHT / np.hypot(1, (0.5 - y) / UNIFORM), rel=1e-6)
    found = bs.results.corner_torsion(result.model, result.history).loc["base|block"]
    assert abs(found["torque"]) < found["uniform"]
    exact = FRICTION * WEIGHT * uniform_friction(1, 1, 0.5 - y)
    assert found["times"] == pytest.approx(result.load_factor / exact, rel=1e-4)
    assert found["share"] == pytest.approx(1 - exact / result.load_factor, abs=1e-4)
    # The note states the load factor of the remedy, which is run again. Without effects it gives an estimate.
    assert result.outcome.uniform_torsion == pytest.approx(limited.load_factor, rel=1e-6)
    effect, left = result.notes
    assert result.answer.text(limited.load_factor) in effect.text
    # The ellipse leaves 5 to 6 % in a square: what its own run says. Its remedy takes them off.
    assert (left,) == without_effect(limited).notes
    assert limited.outcome.lowered_friction == pytest.approx(exact, rel=1e-4)
    assert limited.answer.text(limited.outcome.lowered_friction) in limited.notes[0].text
    assert found["times_left"] == pytest.approx(limited.load_factor / exact, rel=1e-4)
    assert found["share_left"] == pytest.approx(1 - exact / limited.load_factor, abs=1e-4)
    (note,) = without_effect(result).notes
    assert f"About {1 - exact / result.load_factor:.0%} of the load factor" in note.text


@pytest.mark.parametrize("torsion", ["corners", "uniform pressure"])
@pytest.mark.parametrize(
    ("a", "b", "beside", "exact"), [(2, 0.5, 0.4, 0.4211), (5, 0.6, 1.5, 0.3440), (5, 0.3, 0.5, 0.6 / 1.2165)]
)
def test_narrow_joints_pushed_off_their_middle_have_a_note(a, b, beside, exact, torsion):
    """Neither the corners nor the ellipse is on the safe side there, by up to 13 %."""
    blocks = [box("base", [-6, -6, -1], [12, 12, 1], fixed=True), box("block", [-a / 2, -b / 2, 0], [a, b, 0.3])]
    model = model_of(blocks, bs.JointMaterial("joint", FRICTION, torsion=torsion))
    weight = 20e3 * a * b * 0.3
    across = bs.LoadPattern("across", [bs.PointLoad("block", Q_([beside, 0, 0], "m"), Q_([0, weight, 0], "N"))])
    result = solve(model, across)
    assert uniform_friction(a, b, beside) * FRICTION == pytest.approx(exact, abs=1e-4)
    found = bs.results.corner_torsion(model, result.history).loc["base|block"]
    assert result.load_factor / found["times"] == pytest.approx(exact, rel=1e-3)
    assert found["share"] == pytest.approx(1 - exact / result.load_factor, abs=1e-3)
    assert found["share"] > 0.03
    # What the option takes off is an effect; what it leaves has a note of its own, as in joints that have the option.
    limited = result.load_factor if torsion == "uniform pressure" else result.outcome.uniform_torsion
    effect = effect_note(NoteCode.CORNER_TORSION, result.load_factor, limited, result.answer)
    left = torsion_note(["base|block"], limited / exact, 1 - exact / limited, "load factor", at_corners=False)
    if torsion == "uniform pressure":
        assert result.outcome.lowered_friction == pytest.approx(exact, rel=1e-3)
        result = without_effect(result)
    assert result.notes == (*filter(None, [effect]), left)


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow), pytest.param(5, marks=pytest.mark.slow)])
def test_uniform_friction_against_a_general_minimiser(seed):
    """Outlines of any narrowness, a triangle and an angle, turned, under random shear and torque."""
    random = np.random.default_rng(seed)
    narrow = [[(0, 0), (3, 0), (3, w), (0, w)] for w in (3, 1, 0.2, 0.02)]
    others = [[(0, 0), (3, 0), (0, 1)], [(0, 0), (4, 0), (4, 0.5), (0.5, 0.5), (0.5, 4), (0, 4)]]
    for corners in narrow + others:
        flat = np.column_stack([corners, np.zeros(len(corners))])
        of = bs.Interface("a|b", "a", "b", Q_(flat @ rotation((1, 2, 3), 0.7).T, "m"), bs.JointMaterial("joint", 0.6))
        forces = 2 * random.normal(size=3)
        axes = np.stack(plane_axes(of.normal))

        def work(z, of=of, forces=forces, axes=axes):
            w = forces / (forces @ forces) + z @ np.linalg.svd(forces[None])[2][1:]
            centre = of.centroid + of.torsion_lever / w[2] * np.array([-w[1], w[0]]) @ axes
            arms = np.array([0]), centre[None], of.normal[None]
            return abs(w[2]) / of.torsion_lever * mean_distances(of.polygon, *arms)[0]

        starts = np.array([(0.0, 0.0), (0.2, 0.3), (-0.3, 0.1)])
        least = min(
            minimize(work, z, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12}).fun for z in starts
        )
        (found,) = multiple_of_uniform_friction([of], forces[None])
        surely = np.linalg.norm(forces[:2]) + abs(forces[2])
        assert found == pytest.approx(1 / least if surely > 1 else surely, rel=1e-4)


@pytest.mark.parametrize("v", [0.2, 1 / np.sqrt(2), 0.9])
def test_a_narrow_joint_resists_a_parabola_of_shear_across_it_and_torque(v):
    """Outside of which the ellipse lies by ``1 / √(1 − v² + v⁴)``; along the joint it lies inside."""
    of = bs.Interface("a|b", "a", "b", Q_(NARROW, "m"), bs.JointMaterial("joint", 0.6))
    both = np.array([[0, v, 1 - v**2], [v, 0, 1 - v**2]])
    across, along = multiple_of_uniform_friction([of, of], both)
    assert across == pytest.approx(1.0, rel=2e-3)
    assert along < np.linalg.norm(both[1]) * (1 - 1e-3)


def test_a_settlement_held_by_shear_and_torque_has_a_note():
    """A force beside the centre presses a block against a stop, which gives way: friction keeps part of the force."""
    force = bs.PointLoad("block", Q_([0.5, 0.1, 0], "m"), Q_([6e3, 0, 0], "N"))
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), force])
    case = bs.SettlementCase("case", dead, ["stop"], "+x", flow="associative")
    stop = box("stop", [1, 0, 0], [0.2, 0.2, HEIGHT], fixed=True)
    model = block("corners")
    model = model_of([*model.blocks, stop], bs.JointMaterial("joint", FRICTION, torsion="corners"))
    result = bs.run(model, case)["case"]
    assert result.status == "converged"
    assert [note.code for note in result.notes if note.severity == "caution"] == ["corner_torsion", "ellipsoid_torsion"]
    # The block turns about the stop, which bears the more the less torsion friction takes.
    uniform = bs.JointMaterial("joint", FRICTION, torsion="uniform pressure")
    same = bs.run(model_of(model.blocks, uniform), case)["case"]
    assert result.outcome.uniform_torsion == pytest.approx(same.load_factor, rel=1e-6)
    more = same.load_factor / result.load_factor - 1
    assert more > 0.5
    assert f"{more:.0%} more" in next(note.text for note in result.notes)


@pytest.mark.parametrize("flow", ["associative", "nonassociative"])
def test_torsion_of_a_block_that_does_not_move_has_a_note(flow):
    """A pier rocks 0.1 % before the block turns; under uniform pressure the block turns at 54 % of that load factor."""
    turning = CORNERS * FRICTION * WEIGHT
    blocks = [
        box("base", [-1, -1, -1], [6, 3, 1], fixed=True),
        box("block", [0, 0, 0], [1, 1, HEIGHT]),
        box("pier", [2, 0, 0], [0.3, 1, 1]),
    ]
    rocking = 0.15 * 0.3 * STONE.unit_weight / (0.999 * turning)
    force = bs.PointLoad("pier", Q_([2, 0.5, 1], "m"), Q_([rocking, 0, 0], "N"))
    both = bs.LoadPattern("both", [bs.Moment("block", Q_([0, 0, 1], "N m")), force])
    corners, limited = (
        solve(model_of(blocks, bs.JointMaterial("joint", FRICTION, torsion=torsion)), both, flow)
        for torsion in ("corners", "uniform pressure")
    )
    assert corners.load_factor == pytest.approx(0.999 * turning, rel=1e-4)
    assert limited.load_factor == pytest.approx(UNIFORM * FRICTION * WEIGHT, rel=1e-4)
    assert bs.results.corner_torsion(corners.model, corners.history)["share"].sum() < 1e-3
    assert corners.outcome.uniform_torsion == pytest.approx(limited.load_factor, rel=1e-6)
    effect = effect_note(NoteCode.CORNER_TORSION, corners.load_factor, limited.load_factor, corners.answer)
    assert corners.notes == (effect,) != (None,)
    possible = torsion_note(["base|block"], CORNERS / UNIFORM, None, "load factor", at_corners=True)
    assert without_effect(corners).notes == (possible,)
    assert limited.notes == ()


def test_joints_without_torsion_have_no_note():
    assert solve(block(), COUPLE, "nonassociative").notes == ()
    assert solve(block("corners"), push(1, 0, 0), "nonassociative").notes == ()


# -- keeping it --------------------------------------------------------------------------------------------------------


def test_files_documents_and_hashes_keep_it(tmp_path):
    stored = kept(block(), bs.LimitCase("case", SELF_WEIGHT, COUPLE), tmp_path)
    assert stored["case"].history["torsion_lever"].to_numpy() == pytest.approx([UNIFORM])
    assert stored.model.hash != block("corners").hash
    joint = stored.model.joint_materials["joint"]
    assert joint.varied(friction_coefficient=0.3).torsion == "uniform pressure"


def test_interfaces_of_both_kinds_stand_side_by_side():
    blocks = [
        box("base", [-1, -1, -0.5], [3, 3, 0.5], fixed=True),
        *(box(f"b{k}", [0, 0, k / 2], [1, 1, 0.5]) for k in range(2)),
    ]
    uniform = bs.JointMaterial("uniform", FRICTION, torsion="uniform pressure")
    found = bs.detect_interfaces(blocks, joint_material={"b0|b1": uniform, "*": bs.JointMaterial("corners", FRICTION)})
    model = bs.Model("column", blocks, found)
    problem = LimitProblem.of(Statics.of(model), bs.LimitCase("case", SELF_WEIGHT, push(1, 0, 0)))
    assert problem.torsion.interface.tolist() == [[i.name for i in model.interfaces].index("b0|b1")]
    assert len(ContactPoints.of(model, Division()).torsion_lever) == 2
    # The upper block twists first: its joint carries half the weight, and no more than uniform pressure does.
    twist = bs.LoadPattern("twist", [bs.Moment("b1", Q_([0, 0, 1], "N*m"))])
    assert solve(model, twist).load_factor == pytest.approx(UNIFORM * FRICTION * WEIGHT, rel=1e-6)
