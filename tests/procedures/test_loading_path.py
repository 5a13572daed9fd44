"""The loading path: the same number whatever the steps, the stiffness and the frame; and its place in files."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.limit import ConicProgram, LimitProblem
from blockstruct.procedures.splitting_path import SplittingPath
from blockstruct.statics.statics import Statics
from blockstruct.vocabulary import Stage
from structures import SELF_WEIGHT, STONE, bonded, box, model_of, moved, push, rotation, single_block, solve

PATH, STEPS = {"procedure": "loading path"}, ("splitting", "interior point")


@pytest.fixture(scope="module")
def corner(tuff):
    """A wall of three courses with a return, bonded: pushed away from it, the courses slide out of one another."""
    size = {"length": "1.2 m", "unit_length": "40 cm", "unit_height": "20 cm", "thickness": "20 cm"}
    sides = [bs.structures.Sidewall("left", "0 m", "0.8 m", bonded=True)]
    return bs.wall(**size, courses=4, sidewalls=sides, material=tuff)


def along_path(model, load, **settings):
    return solve(model, load, "nonassociative", **PATH, **settings)


def exact(result):
    assert result.status == "converged"
    assert result.outcome.procedure is bs.vocabulary.Procedure.LOADING_PATH
    assert result.certificate.flow_rule_gap <= 1e-4 * result.load_factor
    assert result.certificate.interpenetration <= 1e-4
    return result.load_factor


@pytest.mark.parametrize(
    ("b", "h", "mu", "direction", "expected"),
    [(0.3, 1.0, 0.65, (1, 0, 0), 0.3), (1.0, 0.6, 0.4, (1, 0, 0), 0.4), (0.4, 1.0, 0.5, (0, 0, 1), 1.0)],
    ids=["rocks", "slides", "is lifted and leaves no force"],
)
def test_single_block(b, h, mu, direction, expected):
    found = along_path(model_of(*single_block(b, h, mu=mu)), push(*direction))
    assert exact(found) == pytest.approx(expected, rel=1e-5)


def test_arch_has_its_associative_load_factor():
    blocks = bs.arch(span="18.8 m", thickness="1.2 m", depth="1 m", voussoirs=27, material=STONE)
    model = model_of(blocks, bs.JointMaterial("dry", 0.6))
    bound = solve(model, push(1, 0, 0)).load_factor
    assert exact(along_path(model, push(1, 0, 0))) == pytest.approx(bound, rel=1e-5)


MORTAR, CRUSHES = {"cohesion": "0.5 kPa", "tensile_strength": "0.3 kPa"}, {"compressive_strength": "60 kPa"}


@pytest.mark.parametrize(
    "strengths",
    [{"dilatancy_angle": "15 deg"}, MORTAR, CRUSHES, MORTAR | CRUSHES],
    ids=["partly dilatant", "mortar", "weak", "weak mortar"],
)
def test_every_joint_is_certified_below_the_bound(corner, strengths):
    model = model_of(corner, bs.JointMaterial("joint", 0.65, **strengths))
    bound = solve(model, push(0, -1, 0), crushing_cells=16).load_factor
    found = exact(along_path(model, push(0, -1, 0), crushing_cells=16))
    assert 0.5 * bound < found <= bound * (1 + 1e-6)


def test_the_number_does_not_depend_on_steps_stiffness_or_frame(corner, dry):
    model = model_of(corner, dry)
    load_factor = exact(along_path(model, push(0, -1, 0)))
    others = [{"path_step": 0.5, "path_growth": 3.0}, {"shear_stiffness_ratio": 0.2}, {"shear_stiffness_ratio": 1.0}]
    for settings in others:
        other = exact(along_path(model, push(0, -1, 0), **settings))
        # Of so few blocks, and bonded, a tenth of the resistance hangs on how the dead load presses the joints.
        assert other == pytest.approx(load_factor, rel=1.5e-2)

    turned = moved(corner, R := rotation((1, 2, 3), 0.7), (5, -3, 2))
    gravity = bs.LoadPattern("dead", [bs.BodyForce(R @ [0, 0, -1])])
    other = along_path(model_of(turned, dry), push(*(R @ [0, -1, 0])), dead=gravity)
    assert exact(other) == pytest.approx(load_factor, rel=1e-2)

    assert exact(along_path(model_of(corner[::-1], dry), push(0, -1, 0))) == pytest.approx(load_factor, rel=1e-2)


def test_displacement_is_in_the_history(small_model):
    result = along_path(small_model, push(1, 0, 0))
    d = result.history.displacement
    path = result.history["stage"].to_numpy() == "loading_path"
    assert d.units == "dimensionless"
    assert np.isnan(d.to_numpy()[~path]).all()
    along = d.to_numpy()[path]
    assert (along[0], along[1]) == (0.0, pytest.approx(0.5))
    assert (np.diff(along) > 0).all()
    # The load factor of an elastic structure is its displacement in these units; joints that open or slide take off.
    assert result.history.load_factor.to_numpy()[path][1] <= 1.0


def test_displacement_is_in_metres_where_joints_have_a_stiffness(tuff):
    def path(stiffness):
        joint = bs.JointMaterial("lime", 0.65, normal_stiffness=stiffness, shear_stiffness=0.4 * stiffness)
        history = along_path(model_of(bonded(2, 3, material=tuff), joint), push(1, 0, 0)).history
        return history.where(history["stage"] == "loading_path", drop=True)

    soft, stiff = path(Q_(1, "MPa/mm")), path(Q_(10, "MPa/mm"))
    assert soft.displacement.units == "meter"
    np.testing.assert_allclose(soft.displacement, 10 * stiff.displacement, rtol=1e-9)
    np.testing.assert_allclose(soft.load_factor, stiff.load_factor, rtol=1e-6)
    # Weight 12 kN/m3 over four courses on 1 MPa/mm: hundredths of a millimetre and less.
    assert 1e-8 < float(soft.displacement[1]) < 1e-4


@pytest.mark.parametrize(
    ("loads", "carried"),
    [
        ([bs.PointLoad("block", Q_([0, 0.5, 1], "m"), "[2, 0, 0] kN")], []),
        ([bs.PointLoad("block", Q_([0, 0.5, z], "m"), f"[{p}, 0, 0] kN") for z, p in ((1, 1), (0.2, 3))], []),
        ([bs.BodyForce("+x")], [bs.Weight("block", Q_([0.5, 0.5, 3], "m"), "20 kN")]),
    ],
    ids=["at the top", "at two heights", "a mass above"],
)
def test_displacement_is_that_of_the_points_where_the_load_acts(loads, carried):
    # A block of 1 m on its four corners, k A / 4 each: forces F_i at heights z_i move it by F / k_t, and turn it by
    # sum(F_i z_i) / (k_n A (b / 2)^2).
    joint = bs.JointMaterial("joint", 0.8, normal_stiffness="2 GPa/m", shear_stiffness="1 GPa/m")
    model = model_of(single_block(1.0, 1.0)[0], joint)
    dead, variable = bs.LoadPattern("dead", [bs.SelfWeight(), *carried]), bs.LoadPattern("push", loads)
    acts = bs.results.applied_loads(model, variable, dead)
    F, z = acts.force[acts.block == 1, 0], acts.point[acts.block == 1, 2]
    history = along_path(model, variable, dead=dead, path_step=0.05).history
    first = history.where(history["stage"] == "loading_path", drop=True).isel(iteration=1)
    moves = F.sum() / 1e9 + z * (F @ z) / 0.5e9
    expected = float(first.load_factor) * (F @ moves) / F.sum()
    assert float(first.displacement) == pytest.approx(expected, rel=1e-4)


ADVANCE = SplittingPath.advance
NO_STEP = ("SplittingPath.advance", lambda *_: None)
NO_WHOLE_STEP = ("SplittingPath.advance", lambda path, bound: ADVANCE(path, bound) if path._first < 0.5 else None)
NO_EXACT_STEP = ("InteriorPointPath.advance", lambda *_: None)


def test_a_state_under_dead_load_that_is_found_slowly_is_found(tuff):
    """Its residual is 1.1e-3 after 205 iterations, when it halves too slowly: other procedures had to stand in."""
    windows = [
        bs.structures.Opening(start=start, sill=sill, width="0.9 m", height="1.5 m")
        for start in ("1.5 m", "4.2 m")
        for sill in ("0.75 m", "3.75 m")
    ]
    size = {"length": "6.6 m", "width": "5.4 m", "height": "6 m", "thickness": "0.6 m"}
    units = {"unit_length": "1.5 m", "unit_height": "0.75 m", "material": tuff}
    blocks = bs.room(openings={"front": windows}, **size, **units)
    model = model_of(blocks, bs.JointMaterial("lime mortar", 0.6, compressive_strength="2 MPa"))
    problem = LimitProblem.of(Statics.of(model), bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))).at_unit_load
    settings = bs.ProcedureSettings()
    assert SplittingPath(ConicProgram(problem, settings), settings).dead_load.certificate.equilibrium_residual < 1e-3


@pytest.mark.parametrize(
    ("steps", "failing"),
    [
        ("splitting", ("SplittingPath._at_rest", lambda _: None)),
        ("splitting", NO_STEP),
        ("splitting", NO_WHOLE_STEP),
        ("interior point", NO_EXACT_STEP),
    ],
    ids=["no state", "no step", "no whole step", "no exact step"],
)
def test_steps_of_the_other_kind_or_of_half_the_length_finish_a_path(corner, dry, monkeypatch, steps, failing):
    model = model_of(corner, dry)
    expected = exact(along_path(model, push(1, 0, 0), path_steps=steps))
    monkeypatch.setattr(f"blockstruct.procedures.loading_path.{failing[0]}", failing[1])
    result = along_path(model, push(1, 0, 0), path_steps=steps)
    assert (result.outcome.path_end, result.settled) == (bs.vocabulary.PathEnd.CLOSED, True)
    assert exact(result) == pytest.approx(expected, rel=5e-3)


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
def test_fictitious_conditions_stand_in_where_no_path_finishes(small_model, monkeypatch):
    for name, nothing in (NO_STEP, NO_EXACT_STEP):
        monkeypatch.setattr(f"blockstruct.procedures.loading_path.{name}", nothing)
    result = along_path(small_model, push(1, 0, 0))
    assert result.status == "converged"
    assert (result.outcome.path_end, result.outcome.stands_in) == (bs.vocabulary.PathEnd.STEP_NOT_SOLVED, True)
    assert not result.settled


def two_blocks_in_turn(ratio):
    """A block that slides at half of the load factor, and pushes another one on a soft joint."""
    ground = box("ground", [-1, -1, -0.5], [4, 3, 0.5], fixed=True)
    a, b = (box(n, [x, 0, 0], [1, 1, 0.5]) for n, x in (("a", 0), ("b", 1)))
    soft, stiff = (
        bs.JointMaterial(n, 0.5, normal_stiffness="10 GPa/m", shear_stiffness=Q_(k, "GPa/m"))
        for n, k in (("soft", 4 * ratio), ("stiff", 4))
    )
    load = bs.PointLoad("a", Q_([0.5, 0.5, 0.05], "m"), "[10, 0, 0] kN")
    return model_of([ground, a, b], {"ground|b": soft, "*": stiff}), bs.LoadPattern("push", [load])


@pytest.mark.parametrize("ratio", [1e-2, 2e-4])
def test_a_load_factor_that_rises_after_a_plateau_is_followed_to_its_end(ratio):
    result = along_path(*two_blocks_in_turn(ratio))
    assert exact(result) == pytest.approx(1.0, rel=1e-5)
    assert result.settled
    if ratio == 2e-4:
        # It stays within 0.5 % of 0.5 for a decade, where a closed state, not that of the path, carries twice as much.
        stages, alpha = result.history["stage"].to_numpy().tolist(), result.history.load_factor.to_numpy()
        closed = stages.index("admissible")
        assert alpha[[closed - 2, closed]] == pytest.approx([0.5, 1.0], rel=1e-2)
        assert alpha[closed] == pytest.approx(1.0, rel=1e-4)
        assert stages[closed + 1] == "loading_path"


@pytest.mark.parametrize("steps", STEPS)
def test_a_load_factor_that_never_settles_is_no_number(corner, dry, monkeypatch, steps):
    monkeypatch.setattr("blockstruct.procedures.path.FURTHEST", 2.0)
    result = along_path(model_of(corner, dry), push(0, -1, 0), path_steps=steps)
    assert result.status == "not_converged"
    assert np.isnan(result.load_factor)
    assert (result.outcome.reason, result.outcome.path_end) == (
        bs.vocabulary.Reason.NEVER_SETTLES,
        bs.vocabulary.PathEnd.LIMIT_REACHED,
    )
    low, high = result.outcome.drift
    assert 0 < low < 0.99 * high


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
def test_a_block_that_jams_carries_any_load():
    """Pressed against a fixed jamb at 11°, below the friction angle, it never slides."""
    blocks, joint = single_block(1.0, 0.5, mu=0.6)
    jamb = box("jamb", [1, 0, 0], [0.5, 1, 0.5], fixed=True)
    direction = np.array([1, 0.2, 0]) / np.hypot(1, 0.2)
    result = solve(model_of([*blocks, jamb], joint), push(*direction), "nonassociative")
    assert (result.status, result.outcome.reason) == ("unbounded", bs.vocabulary.Reason.GROWS_WITHOUT_LIMIT)


def test_drift_is_the_range_of_the_last_load_factors(corner, dry):
    result = along_path(model_of(corner, dry), push(0, -1, 0))
    path = result.history["stage"].to_numpy() == "loading_path"
    s, alpha = result.history.displacement.to_numpy()[path], result.history.load_factor.to_numpy()[path]
    last = [*alpha[10 * s >= s[-1]], result.load_factor]
    assert result.outcome.drift == pytest.approx((min(last), max(last)), rel=1e-12)
    assert max(last) - min(last) <= 1e-2 * result.load_factor


def test_two_leaves_with_a_collar_between_each_alone_and_the_bound():
    """A collar joint without dilatancy adds nothing to leaves that rock at t / h = 0.1; the bound is 0.1273."""
    ground, joint = box("ground", [-1, -1, -0.5], [3, 3, 0.5], fixed=True), bs.JointMaterial("joint", 0.7)
    one, other = ([box(f"{y}.{k}", [0, y, 0.2 * k], [1, 0.2, 0.2]) for k in range(10)] for y in (0, 0.2))
    assert exact(along_path(model_of([ground, *one], joint), push(0, 1, 0))) == pytest.approx(0.1, rel=1e-5)
    both = model_of([ground, *one, *other], joint)
    bound = solve(both, push(0, 1, 0)).load_factor
    result = along_path(both, push(0, 1, 0))
    # The dead load presses nothing across the collar, and friction without dilatancy brings no pressure of its own: of
    # the 27 % that dilatant joints would add, nothing is left.
    dead = result.history.isel(iteration=int(np.flatnonzero(result.history["stage"] == "loading_path")[0]))
    normal = dead.interface_frame.to_numpy()[dead.interface_of_contact_point.to_numpy(), 0]
    between = np.abs(normal[:, 1]) > 0.5
    assert dead.load_factor == 0.0
    assert np.abs(dead.contact_force.to_numpy()[between]).max() < 1e-3 * dead.contact_force.to_numpy().max()
    assert bound == pytest.approx(0.1273, abs=1e-4)
    assert exact(result) == pytest.approx(0.1, rel=2e-3)


def test_result_tells_what_the_path_depends_on(small_model, small_analysis, dead, tmp_path):
    assert small_analysis["push nonassociative"].path_dependence is None
    case = bs.LimitCase("push", dead, push(1, 0, 0), "nonassociative")
    analysis = bs.AnalysisManager(small_model, tmp_path / "a.h5").run([case], spread=True)
    spread = analysis.spread("push")
    names = ["half steps", "shear ratio 0.2", "shear ratio 1"]
    assert list(spread.runs) == ["as given", *names]
    low, high = analysis["push"].path_dependence
    assert (low, high) == spread.path_dependence
    assert bs.open_analysis(tmp_path / "a.h5")["push"].path_dependence == (low, high)
    factors = [run.load_factor for run in spread.runs.values()]
    assert (low, high) == (min(factors), max(factors))
    assert spread.headline.range in analysis["push"].describe()
    assert high <= low * 1.01
    assert high <= spread.upper_bound.load_factor * (1 + 1e-6)


@pytest.mark.parametrize(
    ("strength", "direction", "within"),
    [
        (None, (1, 0, 0), 5e-3),
        (None, (0, -1, 0), 5e-3),
        pytest.param("600 kPa", (-0.8, 0.6, 0), 1.5e-2, marks=pytest.mark.slow),
        ("600 kPa", (0.8, 0.6, 0), 1.5e-2),
    ],
)
def test_interior_point_steps_lead_to_the_same_load_factor(corner, strength, direction, within):
    """Also where joints crush: unless the steps are solved, the return does not lean away, and bears an eighth more."""
    model = model_of(corner, bs.JointMaterial("joint", 0.65, compressive_strength=strength))
    one, other = (exact(along_path(model, push(*direction), path_steps=steps)) for steps in STEPS)
    assert one == pytest.approx(other, rel=within)


@pytest.mark.parametrize("growth", [2.0, pytest.param(4.0, marks=pytest.mark.slow)])
def test_a_plateau_at_the_peak_is_not_the_end(tuff, dry, growth):
    """With a door and a window the load factor hardly moves at 0.448 for a while, and ends at 0.439 whatever steps."""
    openings = [
        bs.structures.Opening(start="1.2 m", sill="0 m", width="0.8 m", height="2 m"),
        bs.structures.Opening(start="3.6 m", sill="0.8 m", width="1.2 m", height="1.2 m"),
    ]
    size = {"length": "6 m", "unit_length": "40 cm", "unit_height": "20 cm", "thickness": "20 cm"}
    blocks = bs.wall(**size, courses=14, openings=openings, material=tuff)
    found = along_path(model_of(blocks, dry), push(1, 0, 0), path_growth=growth)
    assert exact(found) == pytest.approx(0.4395, rel=5e-3)


@pytest.mark.slow
def test_a_large_wall_ends_where_tight_steps_lead(monkeypatch, tuff, dry):
    """2,430 bricks in running bond: the last step with five times the patience is within 0.3 %."""
    model = model_of(bonded(40, 60, material=tuff), dry)
    found = along_path(model, push(1, 0, 0))
    assert found.settled
    assert exact(found) == pytest.approx(0.405, rel=1e-2)
    monkeypatch.setattr("blockstruct.procedures.splitting_path.PATIENCE", 400)
    tight = along_path(model, push(1, 0, 0)).history
    last = tight["load_factor"].where(tight["stage"] == Stage.LOADING_PATH.value, drop=True)[-1]
    assert found.load_factor == pytest.approx(float(last), rel=3e-3)


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
def test_an_end_that_is_not_certified_is_told(small_model, monkeypatch):
    monkeypatch.setattr("blockstruct.limit.friction.CAP", np.nan)
    result = along_path(small_model, push(1, 0, 0))
    assert result.status == "converged"
    assert (result.outcome.path_end, result.settled) == (bs.vocabulary.PathEnd.NOT_CERTIFIED, False)
