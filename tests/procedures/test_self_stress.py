"""Loads that only jammed blocks carry: no load factor below zero, and none without a warning."""

import math
import warnings
from dataclasses import replace

import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.analysis import IterationDone
from blockstruct.limit import ConicProgram, LimitProblem
from blockstruct.limit.friction import true_sliding
from blockstruct.limit.settings import scheduled
from blockstruct.procedures.step import solve_step
from blockstruct.solvers import solver_of
from blockstruct.statics.statics import Statics
from structures import SELF_WEIGHT, box, model_of, push, single_block, solve, stopping

MORE_WEIGHT = push(0, 0, -1)


def lintel(n, mu=0.65):
    """A flat lintel of n cubes between fixed jambs, with vertical joints and no support below."""
    jambs = [box(name, [x, 0, 0], [1, 1, 1], fixed=True) for name, x in (("left", -1), ("right", n))]
    return model_of([*jambs, *(cube(f"{i}", i) for i in range(n))], bs.JointMaterial("dry", mu))


def point_load(n):
    """10 kN down on the block in the middle."""
    at = Q_([n / 2, 0.5, 1], "m")
    return bs.LoadPattern("point", [bs.PointLoad(f"{n // 2}", at, Q_([0, 0, -10], "kN"))])


def pads(order, mu=0.65):
    """A block on four pads in a row, slick or rough: how much each bears is not determined."""
    rough, slick = bs.JointMaterial("rough", mu), bs.JointMaterial("slick", 0.0)
    blocks = [box(f"pad {i}", [i, 0, -0.5], [0.5, 1, 0.5], fixed=True) for i in range(4)]
    blocks.append(box("block", [0, 0, 0], [3.5, 1, 1]))
    return model_of(blocks, {f"pad {i}|*": {"r": rough, "s": slick}[kind] for i, kind in enumerate(order)}, "pads")


HANGING = pytest.mark.parametrize(
    ("blocks", "load"),
    [(3, MORE_WEIGHT), (5, point_load(5)), (1, MORE_WEIGHT)],
    ids=["3 blocks, more weight", "5 blocks, a point load", "one clamped block"],
)


@HANGING
def test_the_dead_load_of_a_flat_lintel_hangs_on_self_stress(blocks, load):
    """Load factors of −0.9988, −1.7775 and −0.9997 were certified here, and called converged."""
    model = lintel(blocks)
    result = solve(model, load, "nonassociative")
    assert result.status == "depends_on_self_stress"
    assert math.isnan(result.load_factor)
    assert result.outcome.reason is bs.vocabulary.Reason.DEAD_LOAD_COLLAPSES
    # The proof is a collapse state of the whole dead load: friction does as much work as the falling blocks.
    assert result.certificate.holds
    assert result.history.stage.to_numpy().tolist() == ["dead_load_collapse"]
    last = result.history.isel(iteration=-1)
    friction = -(last.contact_force * last.relative_velocity).sum().item()
    fall = -sum(b.weight * last.block_velocity.sel(block=b.name, axis="z").item() for b in model.blocks)
    assert fall > 0
    assert friction == pytest.approx(fall, rel=2e-3)
    analysis = bs.AnalysisManager(model).run([result.case], spread="steep")
    assert bs.results.recomputed_certificate(analysis, "case").holds
    spread = analysis.spread("case")
    assert (spread.headline.status, spread.warnings, spread.given.owed) == ("depends_on_self_stress", (), ())


@HANGING
@pytest.mark.parametrize("schedule", list(bs.limit.SCHEDULES))
def test_every_schedule_finds_what_hangs(blocks, load, schedule):
    case = bs.LimitCase("case", SELF_WEIGHT, load, "nonassociative")
    result = bs.run(lintel(blocks), case, settings=scheduled(bs.ProcedureSettings(), schedule))["case"]
    assert result.status == "depends_on_self_stress"
    assert result.hung


def overhang(share):
    """Two bricks in a row on a bed. The second one extends beyond its end by a share of its length."""
    brick = [length := 0.25, depth := 0.12, 0.065]
    bed = box("bed", [-1, 0, -0.1], [1 + (1 - share) * length, depth, 0.1], fixed=True)
    bricks = box("first", [-length, 0, 0], brick), box("second", [0, 0, 0], brick)
    return model_of([bed, *bricks], bs.JointMaterial("dry", 0.6))


DIRECTIONS = ("+x", "-x", "+y", "-y", "+z", "-z")


def pushes(flow="nonassociative"):
    return [bs.LimitCase(d, SELF_WEIGHT, bs.LoadPattern(d, [bs.BodyForce(d)]), flow) for d in DIRECTIONS]


@pytest.mark.parametrize("procedure", ["loading path", "fictitious"])
@pytest.mark.parametrize("share", [0.501, 0.55, 0.6])
def test_a_brick_that_tips_off_does_so_whatever_the_push(share, procedure):
    """Only friction on the head joint can hold it. It was converged at 0.6 towards -x and at 1.0 towards +z."""
    settings = bs.ProcedureSettings(procedure=procedure)
    analysis = bs.AnalysisManager(overhang(share), settings=settings).run(pushes())
    assert {r.status for r in analysis.values()} == {bs.Status.SELF_STRESS}
    assert {r.hung for r in analysis.values()} == {("second",)}
    assert all(r.certificate.holds and math.isnan(r.load_factor) for r in analysis.values())
    assert len({r.message for r in analysis.values()}) == 1


@pytest.mark.parametrize("share", [0.49, 0.5])
@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
def test_a_brick_whose_centroid_is_supported_stands(share):
    analysis = bs.AnalysisManager(overhang(share)).run(pushes())
    assert [r.hung for r in analysis.values()] == [()] * len(DIRECTIONS)
    assert {d: analysis[d].load_factor for d in ("-x", "+y", "+z")} == pytest.approx(
        {"-x": 0.6, "+y": 0.6, "+z": 1.0}, rel=1e-3
    )


def test_with_dilatancy_the_dead_load_has_one_answer():
    """Friction with dilatancy holds the brick, as large as self-stress must be."""
    analysis = bs.AnalysisManager(overhang(0.51)).run(pushes("associative"))
    assert bs.Status.SELF_STRESS not in {r.status for r in analysis.values()}


def beside(*blocks, jambs=3.0, joint=None):
    """Blocks, with jambs of a height on both sides of the first metre, on the ground."""
    sides = (box(n, [x, 0, 0], [1, 1, jambs], fixed=True) for n, x in (("left", -1), ("right", 1)))
    return model_of([GROUND, *sides, *blocks], joint or bs.JointMaterial("dry", 0.65))


def cube(name, x, z=0.0):
    return box(name, [x, 0, z], [1, 1, 1])


GROUND, PIER = box("ground", [-5, -5, -1], [40, 40, 1], fixed=True), box("pier", [10, 0, 0], [0.5, 2, 2])
ON_PIER = bs.LoadPattern("on the pier", [bs.PointLoad("pier", Q_([10, 1, 2], "m"), Q_([1, 0, 0], "kN"))])


@pytest.mark.parametrize(
    ("load", "others"),
    [(push(1, 0, 0), ()), (push(1, 0, 0), (PIER,)), (push(0, 1, 0), (PIER,)), (ON_PIER, (PIER,))],
    ids=["unbounded", "+x", "+y", "the pier alone"],
)
@pytest.mark.parametrize("procedure", ["loading path", "fictitious", "shifted"])
def test_a_hung_block_is_told_whatever_bounds_the_load(load, others, procedure):
    """A pier that falls by itself made the load factor finite."""
    result = solve(beside(cube("hung", 0, 1), *others), load, "nonassociative", procedure=procedure)
    assert (result.status, result.hung) == ("depends_on_self_stress", ("hung",))
    assert result.certificate.holds


def test_blocks_that_others_hang_on_are_not_told():
    """The lower of two blocks stands, and so does the upper one on it."""
    result = solve(beside(cube("lower", 0), cube("upper", 0, 1), PIER), ON_PIER, "nonassociative")
    assert (result.status, result.warnings) == ("converged", ())


@pytest.mark.parametrize("load", [(0, 1, 0), (1, 0, 0)], ids=["along the jambs", "against a jamb"])
def test_a_jammed_block_is_told_beside_one_that_bounds_the_load(load):
    """Friction on the ground stops it at 0.65; jambs may add any. A pier that rocks at 1 hid that nothing bounds it."""
    joints = {"ground|squat": bs.JointMaterial("rough", 1.5), "*": bs.JointMaterial("dry", 0.65)}
    model = beside(cube("stuck", 0), cube("squat", 10), jambs=1.0, joint=joints)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = solve(model, push(*load), "nonassociative")
    assert result.associative_load_factor == pytest.approx(1.0, rel=1e-6)
    assert result.status == "converged"
    assert result.jammed == (("stuck",) if load[1] else ())
    assert len(caught) == len(result.warnings) == bool(load[1])
    assert result.wanted_effects == ("other_procedure",) * bool(load[1])
    for other, told in ((result.load_factor, False), (0.9 * result.load_factor, True)):
        known = result.changed(outcome=replace(result.outcome, other_procedure=other))
        assert bool(known.warnings) == (told and bool(load[1]))


def test_a_problem_is_the_sum_of_its_groups():
    """Blocks, contact points, rectangles that crush and ties of each, by which nothing is lost or shared."""
    top, ground = ("one", Q_([0.5, 0.5, 1], "m")), ("ground", Q_([0.5, 3, 0], "m"))
    rods = [bs.Tie("rod", top, ground, yield_force="5 kN")]
    blocks = [GROUND, cube("one", 0), cube("two", 5), cube("on two", 5, 1)]
    joint = bs.JointMaterial("weak", 0.6, compressive_strength="1 MPa", torsion="uniform pressure")
    model = bs.Model("model", blocks, bs.detect_interfaces(blocks, joint), ties=rods)
    case = bs.LimitCase("case", SELF_WEIGHT, push(1, 0, 0), "nonassociative")
    problem = LimitProblem.of(Statics.of(model), case)
    assert problem.groups.tolist() == [0, 1, 1]
    parts = [problem.part(problem.groups == g) for g in (0, 1)]
    assert [(p.n_blocks, p.n_points, len(p.rectangles), len(p.torsion), len(p.ties)) for p in parts] == [
        (1, 4, 1, 1, 1),
        (2, 8, 2, 2, 0),
    ]
    settings = bs.ProcedureSettings()
    found = [
        solve_step(
            ConicProgram(p, settings), true_sliding(p), bs.vocabulary.Stage.ASSOCIATIVE, settings, solver_of(settings)
        )
        for p in (problem, *parts)
    ]
    assert all(step.solved for step in found)
    assert found[0].load_factor == pytest.approx(min(step.load_factor for step in found[1:]), rel=1e-6)


@pytest.mark.parametrize(("share", "mu"), [(0.1, 0.4), (0.3, 0.4), (0.3, 0.65), (0.5, 0.65)])
def test_a_load_inside_the_friction_cone_is_recognised_early(share, mu):
    """Pushed down by more than friction needs: it ended after 60 programs and more, as not converged, at −0.857."""
    model, load = model_of(*single_block(1.0, 1.0, mu=mu)), push(share, 0, -1)
    with pytest.warns(bs.errors.LoadFactorWarning, match="grows without limit"):
        result = solve(model, load, "nonassociative")
    with pytest.warns(bs.errors.LoadFactorWarning, match="grows without limit"):
        fictitious = solve(model, load, "nonassociative", procedure="fictitious")
    assert result.status == fictitious.status == "unbounded"
    assert result.load_factor == math.inf
    assert result.certificate is None
    assert fictitious.n_iterations <= 15


def test_a_load_outside_the_friction_cone_slides():
    # 0.5 α = 0.4 (1 + α).
    result = solve(model_of(*single_block(1.0, 1.0, mu=0.4)), push(0.5, 0, -1), "nonassociative")
    assert result.load_factor == pytest.approx(4.0, rel=1e-3)


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
@pytest.mark.parametrize("order", ["srrs", "rssr", "rsrs", "ssrr"])
def test_growth_for_a_while_is_not_taken_for_unbounded(order):
    """The slick pads may bear all of it, so that the block slides at once; for a while its load factor only grows."""
    result = solve(pads(order), push(0.1, 0, -1), "nonassociative", procedure="fictitious")
    assert result.status == "converged"
    assert result.load_factor < 0.05


def test_a_load_factor_of_zero_is_not_negative():
    result = solve(model_of(*single_block(1.0, 1.0, mu=0.0)), push(1, 0, 0), "nonassociative")
    assert result.status == "converged"
    assert 0 <= result.load_factor < 1e-6


def test_what_has_not_converged_keeps_its_best_admissible_state(small_model):
    result = solve(
        small_model, push(1, 0, 0), "nonassociative", procedure="fictitious", max_programs=8, gap_tolerance=1e-12
    )
    state = result.admissible_state
    assert (result.status, result.outcome.reason) == ("not_converged", bs.vocabulary.Reason.NO_CERTIFICATE)
    assert result.outcome.programs == result.n_iterations <= 8
    assert math.isnan(result.load_factor)
    assert result.admissible_load_factor == state.load_factor
    # It is admissible, not a collapse state, and none of the others misses the flow rule less.
    assert state.certificate.yield_excess <= result.settings.numerics.yield_tolerance
    assert not state.certificate.holds
    h = result.history
    inside = (h.yield_excess <= result.settings.numerics.yield_tolerance) & (h.equilibrium_residual <= 1e-6)
    assert state.certificate.flow_rule_gap == h.flow_rule_gap.where(inside).min().item()
    assert state.load_factor <= result.associative_load_factor * (1 + 1e-9)


def test_without_iterations_nothing_is_admissible(small_model, small_cases):
    result = bs.AnalysisManager(small_model, listeners=[stopping()]).run(small_cases[:1])[small_cases[0].name]
    assert result.status == "interrupted"
    assert result.admissible_state is None
    assert math.isnan(result.admissible_load_factor)
    assert math.isnan(result.associative_load_factor)


@pytest.mark.parametrize("loads", [
    [bs.BodyForce("+x", 0.1), bs.BodyForce("+x", 0.2), bs.BodyForce("-x", 0.3)],
    [
        bs.PointLoad("block", Q_([0.1, 0.3, 0.7], "m"), Q_([0.1, 0.7, 0], "kN")),
        bs.PointLoad("block", Q_([0.1, 0.3, 0.7], "m"), Q_([0.2, 0.1, 0], "kN")),
        bs.PointLoad("block", Q_([0.1, 0.3, 0.7], "m"), Q_([-0.3, -0.8, 0], "kN")),
    ],
])  # fmt: skip
def test_loads_that_cancel_to_rounding_are_none(loads):
    """They were a variable load of 1e-17, and ``converged 3.5e17``."""
    with pytest.raises(bs.errors.ModelError, match=r"'cancels' is zero on every free block.*do not cancel"):
        solve(model_of(*single_block(1.0, 1.0)), bs.LoadPattern("cancels", loads))
    pair = loads[:2]
    assert solve(model_of(*single_block(1.0, 1.0)), bs.LoadPattern("acts", pair)).status == "converged"


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
@pytest.mark.parametrize(
    ("model", "load", "status"),
    [
        (lintel(3), MORE_WEIGHT, "depends_on_self_stress"),
        (model_of(*single_block(1.0, 1.0)), push(0.3, 0, -1), "unbounded"),
    ],
)
def test_an_interrupted_case_ends_as_it_would_have(model, load, status, tmp_path):
    case = bs.LimitCase("case", SELF_WEIGHT, load)
    whole = bs.AnalysisManager(model).run([case])["case"]

    bs.AnalysisManager(model, tmp_path / "a.h5", listeners=[stopping(IterationDone, at=4)]).run([case])
    resumed = bs.AnalysisManager.resume(tmp_path / "a.h5")["case"]
    assert resumed.status == whole.status == status
    assert resumed.history.stage.to_numpy().tolist() == whole.history.stage.to_numpy().tolist()
    assert bs.results.contradictions(bs.open_analysis(tmp_path / "a.h5")) == []


@pytest.mark.filterwarnings("error::blockstruct.errors.LoadFactorWarning")
def test_a_warning_made_an_error_loses_no_result(tmp_path):
    case = bs.LimitCase("case", SELF_WEIGHT, push(0, 1, 0))
    with pytest.raises(bs.errors.LoadFactorWarning):
        bs.AnalysisManager(beside(cube("stuck", 0), jambs=1.0), tmp_path / "a.h5").run([case])
    assert bs.open_analysis(tmp_path / "a.h5")["case"].status == "converged"
